//! HTTP/1.1 (RFC 9112), as far as a page of our own asks for it: one request a connection, read whole, answered whole.
//!
//! `httparse` reads the heads. A server crate of threads (`tiny_http`) let requests wait for ever when a browser opened many
//! connections at a time; those that do not are made for an asynchronous runtime, which nothing else here needs.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// The longest head of a request.
const HEAD: usize = 16 << 10;

/// The most headers.
const HEADERS: usize = 64;

/// The longest body.
const BODY: usize = 16 << 20;

/// How long a request may take to arrive, and an answer to be taken.
const PATIENCE: Duration = Duration::from_secs(10);

/// A request.
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
    /// What was sent with it.
    pub body: Vec<u8>,
}

/// An answer.
#[derive(Debug)]
pub(super) struct Response {
    /// 200 is good.
    pub status: u16,
    /// Further headers.
    pub headers: Vec<(&'static str, &'static str)>,
    /// What is sent.
    pub body: Vec<u8>,
}

fn bad(why: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, why)
}

/// Reads a request.
pub(super) fn read(stream: &mut TcpStream) -> io::Result<Request> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    stream.set_nodelay(true)?;
    let mut bytes = Vec::new();
    let (mut request, begin, length) = loop {
        if let Some(head) = head(&bytes)? {
            break head;
        }
        if bytes.len() >= HEAD {
            return Err(bad("the head of the request is too long"));
        }
        let mut part = [0; 4096];
        match stream.read(&mut part)? {
            0 => return Err(io::ErrorKind::UnexpectedEof.into()),
            n => bytes.extend_from_slice(&part[..n]),
        }
    };
    if length > BODY {
        return Err(bad("the request is too long"));
    }
    request.body = bytes.split_off(begin);
    request.body.truncate(length);
    let rest = length - request.body.len();
    stream.take(rest as u64).read_to_end(&mut request.body)?;
    if request.body.len() < length {
        return Err(io::ErrorKind::UnexpectedEof.into());
    }
    Ok(request)
}

/// The head at the beginning of these bytes: where it ends, and how long the body is. `None` if there is more to come.
fn head(bytes: &[u8]) -> io::Result<Option<(Request, usize, usize)>> {
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
        body: Vec::new(),
    };
    Ok(Some((request, end, length)))
}

/// The words for a status that a person may see.
fn reason(status: u16) -> &'static str {
    match status {
        200 => "OK",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        _ => "Error",
    }
}

/// The beginning of an answer.
fn begin(status: u16, headers: &[(&str, &str)]) -> String {
    let mut text =
        format!("HTTP/1.1 {status} {}\r\nConnection: close\r\nCache-Control: no-store\r\n", reason(status));
    for (name, value) in headers {
        text += &format!("{name}: {value}\r\n");
    }
    text
}

/// Answers, and ends the connection.
pub(super) fn respond(stream: &mut TcpStream, response: &Response) -> io::Result<()> {
    let length = response.body.len();
    let head = begin(response.status, &response.headers) + &format!("Content-Length: {length}\r\n\r\n");
    stream.write_all(head.as_bytes())?;
    stream.write_all(&response.body)?;
    stream.flush()
}

/// Begins an answer that goes on and on.
pub(super) fn respond_on(stream: &mut TcpStream, headers: &[(&str, &str)]) -> io::Result<()> {
    stream.write_all((begin(200, headers) + "\r\n").as_bytes())
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
        let (request, end, length) = head(text).unwrap().unwrap();
        assert_eq!((&text[end..], length), (&b"xyz"[..], 3));
        assert_eq!((request.path.as_str(), request.query.as_str()), ("/a/b", "c=d"));
        assert_eq!(request.host.as_deref(), Some("localhost:1"));
        assert!(head(b"\0\0\0 nonsense\r\n\r\n").is_err());
        assert!(head(b"GET / HTTP/1.1\r\nContent-Length: -1\r\n\r\n").is_err());
    }
}
