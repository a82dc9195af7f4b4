//! HTTP/1.1 (RFC 9112), as far as a page of our own asks for it: one request a connection. Its head is read first; its body
//! only when the head has shown the token. Each of them, and the answer, has a time by which it is done, however slowly
//! the other side sends or takes.
//!
//! `httparse` reads the heads. A server crate of threads (`tiny_http`) let requests wait for ever when a browser opened many
//! connections at a time; those that do not are made for an asynchronous runtime, which nothing else here needs.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// The longest head of a request.
const HEAD: usize = 16 << 10;

/// The most headers.
const HEADERS: usize = 64;

/// The longest body.
const BODY: u64 = 16 << 20;

/// How long the head of a request may take to arrive, all in all; and one event to be taken.
const HEAD_TIME: Duration = Duration::from_secs(10);

/// How long the body may take.
const BODY_TIME: Duration = Duration::from_secs(20);

/// How long an answer may take to be taken.
const ANSWER_TIME: Duration = Duration::from_secs(60);

/// How long what a refused request still sends is looked at, so that its sender gets to read the answer.
const LINGER: Duration = Duration::from_secs(1);

/// A connection that ends at some time, whatever the other side does.
struct Timed<'s> {
    stream: &'s TcpStream,
    until: Instant,
}

impl<'s> Timed<'s> {
    fn new(stream: &'s TcpStream, time: Duration) -> Timed<'s> {
        Timed { stream, until: Instant::now() + time }
    }

    /// What is left of the time; never nothing, which the system would take for no limit.
    fn rest(&self) -> io::Result<Option<Duration>> {
        match self.until.saturating_duration_since(Instant::now()) {
            Duration::ZERO => Err(io::ErrorKind::TimedOut.into()),
            rest => Ok(Some(rest)),
        }
    }
}

impl Read for Timed<'_> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        self.stream.set_read_timeout(self.rest()?)?;
        self.stream.read(bytes)
    }
}

impl Write for Timed<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.stream.set_write_timeout(self.rest()?)?;
        self.stream.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

/// The head of a request.
#[derive(Debug, Default)]
pub(super) struct Request {
    /// `GET`, `POST`, …
    pub method: String,
    /// With a `/` at its beginning, without what follows a `?`.
    pub path: String,
    /// What follows the `?`.
    pub query: String,
    /// The host that the browser means.
    pub host: Option<String>,
    /// The page from which it comes.
    pub origin: Option<String>,
    /// How long its body is.
    length: u64,
    /// The beginning of the body, as far as it came with the head.
    begun: Vec<u8>,
}

/// An answer.
#[derive(Debug)]
pub(super) struct Response {
    /// 200 is good.
    pub status: u16,
    /// Further headers.
    pub headers: Vec<(&'static str, String)>,
    /// What is sent.
    pub body: Vec<u8>,
}

fn bad(why: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why)
}

/// Reads the head of a request.
pub(super) fn read_head(stream: &TcpStream) -> io::Result<Request> {
    stream.set_nodelay(true)?;
    let mut timed = Timed::new(stream, HEAD_TIME);
    let mut bytes = Vec::new();
    loop {
        if let Some((mut request, end)) = head(&bytes)? {
            request.begun = bytes.split_off(end);
            return Ok(request);
        }
        if bytes.len() >= HEAD {
            return Err(bad("the head of the request is too long"));
        }
        let mut part = [0; 4096];
        match timed.read(&mut part)? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            n => bytes.extend_from_slice(&part[..n]),
        }
    }
}

/// Reads the body of a request.
pub(super) fn read_body(stream: &TcpStream, request: &mut Request) -> io::Result<Vec<u8>> {
    if request.length > BODY {
        return Err(bad("the request is too long"));
    }
    let mut body = std::mem::take(&mut request.begun);
    body.truncate(request.length as usize);
    let rest = request.length - body.len() as u64;
    Timed::new(stream, BODY_TIME).take(rest).read_to_end(&mut body)?;
    match body.len() as u64 == request.length {
        true => Ok(body),
        false => Err(io::ErrorKind::UnexpectedEof.into()),
    }
}

/// The head at the beginning of these bytes, and where it ends. `None` if there is more to come.
fn head(bytes: &[u8]) -> io::Result<Option<(Request, usize)>> {
    let mut headers = [httparse::EMPTY_HEADER; HEADERS];
    let mut parsed = httparse::Request::new(&mut headers);
    let end = match parsed.parse(bytes).map_err(|error| bad(&error.to_string()))? {
        httparse::Status::Complete(end) => end,
        httparse::Status::Partial => return Ok(None),
    };
    let (path, query) =
        parsed.path.unwrap_or("/").split_once('?').unwrap_or((parsed.path.unwrap_or("/"), ""));
    let value = |name: &str| {
        let found = parsed.headers.iter().find(|header| header.name.eq_ignore_ascii_case(name))?;
        Some(String::from_utf8_lossy(found.value).trim().to_string())
    };
    let length = match value("Content-Length") {
        Some(length) => length.parse().map_err(|_| bad("no length"))?,
        None => 0,
    };
    let request = Request {
        method: parsed.method.unwrap_or_default().to_string(),
        path: path.to_string(),
        query: query.to_string(),
        host: value("Host"),
        origin: value("Origin"),
        length,
        begun: Vec::new(),
    };
    Ok(Some((request, end)))
}

/// The words for a status that a person may see.
fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        303 => "See Other",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        503 => "Service Unavailable",
        _ => "Error",
    }
}

/// The beginning of an answer.
fn begin(status: u16, headers: &[(&str, String)]) -> String {
    let mut text =
        format!("HTTP/1.1 {status} {}\r\nConnection: close\r\nCache-Control: no-store\r\n", reason(status));
    for (name, value) in headers {
        text += &format!("{name}: {value}\r\n");
    }
    text
}

/// Answers, and ends the connection.
pub(super) fn respond(stream: &TcpStream, response: &Response) -> io::Result<()> {
    let length = response.body.len();
    let head = begin(response.status, &response.headers) + &format!("Content-Length: {length}\r\n\r\n");
    let mut timed = Timed::new(stream, ANSWER_TIME);
    timed.write_all(head.as_bytes())?;
    timed.write_all(&response.body)?;
    stream.shutdown(Shutdown::Write)?;
    if response.status != 200 {
        // A connection that is closed with bytes unread takes the answer with it.
        let _ = io::copy(&mut Timed::new(stream, LINGER).take(BODY), &mut io::sink());
    }
    Ok(())
}

/// Begins an answer that goes on and on.
pub(super) fn respond_on(stream: &TcpStream, headers: &[(&str, String)]) -> io::Result<()> {
    send_on(stream, &(begin(200, headers) + "\r\n"))
}

/// Goes on with an answer.
pub(super) fn send_on(stream: &TcpStream, text: &str) -> io::Result<()> {
    Timed::new(stream, HEAD_TIME).write_all(text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_are_read_whole_or_not_yet() {
        let text = b"POST /a/b?c=d HTTP/1.1\r\nhost: localhost:1\r\nContent-Length: 3\r\n\r\nxyz";
        for end in 0..text.len() - 3 {
            assert!(head(&text[..end]).unwrap().is_none(), "{end}");
        }
        let (request, end) = head(text).unwrap().unwrap();
        assert_eq!((&text[end..], request.length), (&b"xyz"[..], 3));
        assert_eq!((request.path.as_str(), request.query.as_str()), ("/a/b", "c=d"));
        assert_eq!(request.host.as_deref(), Some("localhost:1"));
        assert!(head(b"\0\0\0 nonsense\r\n\r\n").is_err());
        assert!(head(b"GET / HTTP/1.1\r\nContent-Length: -1\r\n\r\n").is_err());
    }
}
