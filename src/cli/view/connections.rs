//! How many connections there may be. Anybody on this machine can open one, so those that have not shown the token yet are
//! few, and the oldest of them gives way to a new one. The pages' own are counted apart.

use std::collections::VecDeque;
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Connections without a token.
const MAX_STRANGERS: usize = 32;

/// Connections of pages: each page has one that stays, and some for what it fetches.
const MAX_PAGES: usize = 128;

/// All connections.
#[derive(Default)]
pub(super) struct Connections {
    strangers: Mutex<VecDeque<Arc<TcpStream>>>,
    pages: AtomicUsize,
}

/// A connection that has not shown the token.
pub(super) struct Stranger {
    all: Arc<Connections>,
    pub stream: Arc<TcpStream>,
}

/// A connection of a page.
pub(super) struct Page {
    all: Arc<Connections>,
}

impl Connections {
    fn strangers(&self) -> MutexGuard<'_, VecDeque<Arc<TcpStream>>> {
        self.strangers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A new connection. If there are too many, the oldest ends: who knows the token has shown it by then.
    pub fn enter(self: &Arc<Self>, stream: TcpStream) -> Stranger {
        let stream = Arc::new(stream);
        let mut strangers = self.strangers();
        while strangers.len() >= MAX_STRANGERS {
            end(strangers.pop_front());
        }
        strangers.push_back(Arc::clone(&stream));
        Stranger { all: Arc::clone(self), stream }
    }

    /// Ends half of the connections without a token, where the system has no room for more.
    pub fn make_room(&self) {
        let mut strangers = self.strangers();
        for _ in 0..strangers.len().div_ceil(2) {
            end(strangers.pop_front());
        }
    }
}

/// Ends a connection: whoever waits for it is woken, and closes it.
fn end(stream: Option<Arc<TcpStream>>) {
    if let Some(stream) = stream {
        // It may have ended already.
        let _ = stream.shutdown(Shutdown::Both);
    }
}

impl Stranger {
    /// It has shown the token. `None` if there are too many of that kind.
    pub fn admit(&self) -> Option<Page> {
        self.leave();
        let before = self.all.pages.fetch_add(1, Ordering::Relaxed);
        // Made first, so that it is counted back.
        let page = Page { all: Arc::clone(&self.all) };
        (before < MAX_PAGES).then_some(page)
    }

    fn leave(&self) {
        self.all.strangers().retain(|other| !Arc::ptr_eq(other, &self.stream));
    }
}

impl Drop for Stranger {
    fn drop(&mut self) {
        self.leave();
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.all.pages.fetch_sub(1, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;
    use std::net::TcpListener;

    #[test]
    fn the_oldest_stranger_gives_way() {
        let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
        let address = listener.local_addr().unwrap();
        let all = Arc::new(Connections::default());
        let (mut clients, mut strangers) = (Vec::new(), Vec::new());
        for _ in 0..MAX_STRANGERS + 3 {
            clients.push(TcpStream::connect(address).unwrap());
            strangers.push(all.enter(listener.accept().unwrap().0));
        }
        assert_eq!(all.strangers().len(), MAX_STRANGERS);
        for client in &mut clients[..3] {
            assert_eq!(client.read(&mut [0]).unwrap(), 0, "it was ended");
        }
        let page = strangers.pop().unwrap().admit().expect("there is room");
        assert_eq!((all.strangers().len(), all.pages.load(Ordering::Relaxed)), (MAX_STRANGERS - 1, 1));
        drop((page, strangers));
        assert_eq!((all.strangers().len(), all.pages.load(Ordering::Relaxed)), (0, 0));
    }
}
