//! Messages as the protocol frames them (LSP 3.17, "Base Protocol"): headers, of which `Content-Length` counts, an empty
//! line, and JSON. Whatever else comes is answered by an error, and what follows it is read from the next header on.

use lsp_server::{ErrorCode, Message};
use serde_json::{Value, json};
use std::io::{self, Read};

/// The longest message: the longest program, with every byte escaped.
const MAX_BYTES: usize = 128 << 20;

/// The longest headers of a message.
const MAX_HEADERS: usize = 4096;

/// What is read at once.
const PART: usize = 1 << 16;

/// What every message begins with, or has among its headers.
const LENGTH: &[u8] = b"content-length:";

/// What came.
pub(super) enum Frame {
    /// A message.
    Message(Message),
    /// Something else, and the response to it.
    Refused(Value),
}

/// Reads one message after another.
pub(super) struct Frames<R> {
    input: R,
    /// What has come and has not been read.
    bytes: Vec<u8>,
    max_bytes: usize,
}

/// A response to what is no request that could be answered.
fn refusal(id: Value, code: ErrorCode, why: &str) -> Frame {
    let error = json!({"code": code as i32, "message": why});
    Frame::Refused(json!({"jsonrpc": "2.0", "id": id, "error": error}))
}

/// Where the name of the header that counts begins.
fn find_length(bytes: &[u8]) -> Option<usize> {
    bytes.windows(LENGTH.len()).position(|part| part.eq_ignore_ascii_case(LENGTH))
}

/// The same, where the bytes may end in the middle of that name; their length if it is not in there.
fn begin_of_length(bytes: &[u8]) -> usize {
    let last = bytes.len().saturating_sub(LENGTH.len() - 1)..bytes.len();
    let cut = |&at: &usize| bytes[at..].eq_ignore_ascii_case(&LENGTH[..bytes.len() - at]);
    find_length(bytes).or_else(|| last.clone().find(cut)).unwrap_or(bytes.len())
}

/// The headers at the beginning of these bytes: where they end, and the length that they state. `None` if there may be
/// more of them to come.
fn headers(bytes: &[u8]) -> Option<Result<(usize, usize), String>> {
    let (mut at, mut length) = (0, None);
    loop {
        let Some(end) = bytes[at..].iter().position(|&b| b == b'\n') else {
            let long = bytes.len() > MAX_HEADERS;
            return long.then(|| Err("the headers have no end".into()));
        };
        let line = bytes[at..at + end].trim_ascii();
        at += end + 1;
        if line.is_empty() {
            return Some(length.map(|length| (at, length)).ok_or("no Content-Length".into()));
        }
        let colon = line.iter().position(|&b| b == b':');
        let Some((name, value)) = colon.map(|colon| (&line[..colon], line[colon + 1..].trim_ascii())) else {
            return Some(Err("invalid header".into()));
        };
        if name.eq_ignore_ascii_case(b"content-length") {
            let digits = std::str::from_utf8(value).ok().filter(|v| v.bytes().all(|b| b.is_ascii_digit()));
            match digits.and_then(|digits| digits.parse().ok()) {
                Some(number) => length = Some(number),
                None => return Some(Err("Content-Length is not a number of bytes".into())),
            }
        }
    }
}

/// The message that these bytes are.
fn message(bytes: &[u8]) -> Frame {
    let value: Value = match serde_json::from_slice(bytes) {
        Ok(value) => value,
        Err(error) => {
            return refusal(Value::Null, ErrorCode::ParseError, &format!("invalid JSON: {error}"));
        }
    };
    let id = value.get("id").filter(|id| id.is_string() || id.is_number()).cloned().unwrap_or_default();
    match serde_json::from_value(value) {
        Ok(message) => Frame::Message(message),
        Err(_) => refusal(id, ErrorCode::InvalidRequest, "not a message of the protocol"),
    }
}

impl<R: Read> Frames<R> {
    /// All that comes from there.
    pub fn new(input: R) -> Frames<R> {
        Frames { input, bytes: Vec::new(), max_bytes: MAX_BYTES }
    }

    /// Reads more; false at the end of the input.
    fn more(&mut self) -> io::Result<bool> {
        let before = self.bytes.len();
        self.bytes.resize(before + PART, 0);
        let count = loop {
            match self.input.read(&mut self.bytes[before..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                count => break count,
            }
        };
        self.bytes.truncate(before + count.as_ref().map_or(0, |count| *count));
        count.map(|count| count > 0)
    }

    /// Leaves out all that comes before the next header that states a length, but at least `at_least` bytes.
    fn skip(&mut self, at_least: usize) -> io::Result<()> {
        self.bytes.drain(..at_least.min(self.bytes.len()));
        loop {
            if let Some(at) = find_length(&self.bytes) {
                self.bytes.drain(..at);
                return Ok(());
            }
            // The end may be the beginning of one.
            let rest = self.bytes.len().saturating_sub(LENGTH.len() - 1);
            self.bytes.drain(..rest);
            if !self.more()? {
                self.bytes.clear();
                return Ok(());
            }
        }
    }

    /// The next message; `None` at the end of the input.
    ///
    /// # Errors
    /// If the input cannot be read.
    pub fn next(&mut self) -> io::Result<Option<Frame>> {
        let parsed = loop {
            match headers(&self.bytes) {
                Some(parsed) => break parsed,
                None if self.more()? => {}
                None => return Ok(None),
            }
        };
        let (begin, length) = match parsed {
            Ok((begin, length)) if length <= self.max_bytes => (begin, length),
            Ok((begin, length)) => {
                self.skip(begin)?;
                let why = format!("a message of {length} bytes is too long: the limit is {}", self.max_bytes);
                return Ok(Some(refusal(Value::Null, ErrorCode::InvalidRequest, &why)));
            }
            Err(why) => {
                // Of a header that is wrong, the rest is no header either.
                self.skip(1)?;
                return Ok(Some(refusal(Value::Null, ErrorCode::ParseError, &why)));
            }
        };
        while self.bytes.len() < begin + length {
            if !self.more()? {
                return Ok(None);
            }
        }
        let frame = message(&self.bytes[begin..begin + length]);
        // A length that was too long has taken the beginning of the next message for its own.
        let wrong = matches!(frame, Frame::Refused(_));
        let next = wrong.then(|| begin_of_length(&self.bytes[begin..begin + length]));
        self.bytes.drain(..begin + next.unwrap_or(length));
        // A message of some MB needs its room once.
        self.bytes.shrink_to(8 * PART);
        Ok(Some(frame))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message in its frame.
    fn framed(text: &str) -> Vec<u8> {
        format!("Content-Length: {}\r\n\r\n{text}", text.len()).into_bytes()
    }

    const NOTE: &str = r#"{"jsonrpc":"2.0","method":"note"}"#;

    /// Yields a fixed number of bytes at a time.
    struct Drops<'b>(&'b [u8], usize);

    impl Read for Drops<'_> {
        fn read(&mut self, to: &mut [u8]) -> io::Result<usize> {
            let count = self.1.min(self.0.len()).min(to.len());
            to[..count].copy_from_slice(&self.0[..count]);
            self.0 = &self.0[count..];
            Ok(count)
        }
    }

    /// How many messages come out of these bytes, and the codes of the refusals, however they arrive.
    fn all(bytes: &[u8]) -> (usize, Vec<i64>) {
        let read = |at_once| {
            let mut frames = Frames { max_bytes: 1000, ..Frames::new(Drops(bytes, at_once)) };
            let (mut messages, mut codes) = (0, Vec::new());
            while let Some(frame) = frames.next().unwrap() {
                match frame {
                    Frame::Message(_) => messages += 1,
                    Frame::Refused(value) => codes.push(value["error"]["code"].as_i64().unwrap()),
                }
            }
            (messages, codes)
        };
        let whole = read(usize::MAX);
        assert_eq!(read(1), whole);
        whole
    }

    #[test]
    fn a_message_that_is_wrong_is_one_error_and_the_next_is_read() {
        let good = framed(NOTE);
        assert_eq!(all(&good.repeat(3)), (3, vec![]));
        let wrong: [(&[u8], &[i64]); 20] = [
            (&framed("{"), &[-32700]),
            (&framed(""), &[-32700]),
            (&framed("[1, 2]"), &[-32600]),
            (&framed("{}"), &[-32600]),
            (&framed(r#"{"id":1.5,"method":"x"}"#), &[]),
            (&framed(r#"{"id":[],"params":1}"#), &[-32600]),
            (&framed(&"[".repeat(900)), &[-32700]),
            (b"Content-Length: 2\r\n\r\n\xff\xfe", &[-32700]),
            (b"Content-Length: 99999999999\r\n\r\n", &[-32600]),
            (b"Content-Length: 99999999999999999999999999\r\n\r\n", &[-32700]),
            (b"Content-Length: 1001\r\n\r\n{}", &[-32600]),
            (b"Content-Length: -1\r\n\r\n{}", &[-32700]),
            (b"Content-Length: +1\r\n\r\n", &[-32700]),
            (b"Content-Length: many\r\n\r\n{}", &[-32700]),
            (b"Content-Length:\r\n\r\n", &[-32700]),
            (b"Content-Type: text\r\n\r\n{}", &[-32700]),
            (b"\r\n\r\n", &[-32700]),
            (b"nonsense\r\n", &[-32700]),
            (&[0; 9000], &[-32700]),
            (&[b'x'; 70_000], &[-32700]),
        ];
        for (bytes, codes) in wrong {
            let shown = String::from_utf8_lossy(&bytes[..bytes.len().min(60)]).into_owned();
            let more = usize::from(codes.is_empty());
            let found = all(&[&good, bytes, &good, &good].concat());
            assert_eq!(found, (3 + more, codes.to_vec()), "{shown:?}");
        }
    }

    #[test]
    fn lengths_that_are_wrong_lose_no_message_behind_them() {
        let good = framed(NOTE);
        for (length, more) in [(NOTE.len() + 10, 0), (NOTE.len() + 1, 0), (NOTE.len() - 1, 0), (3, 0)] {
            let wrong = format!("Content-Length: {length}\r\n\r\n{NOTE}");
            let (messages, codes) = all(&[wrong.as_bytes(), &good, &good].concat());
            assert_eq!(messages, 2 + more, "{length}");
            assert!(!codes.is_empty() && codes.len() <= 2, "{length}: {codes:?}");
        }
    }

    #[test]
    fn whatever_comes_later_messages_are_read() {
        let parts: [&[u8]; 16] = [
            b"Content-Length: ",
            b"content-length:",
            b"Content-Le",
            b"7",
            b"900",
            b"99999999999",
            b"-",
            b"\r\n",
            b"\n",
            b"\r\n\r\n",
            b"{",
            b"}",
            b"\"",
            b"\xff\0",
            b"Content-Type: x",
            NOTE.as_bytes(),
        ];
        let mut random = 1_u64;
        for round in 0..500 {
            let mut bytes = Vec::new();
            for _ in 0..1 + round % 20 {
                random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                bytes.extend(parts[(random >> 60) as usize]);
            }
            // A length that is believable may take up to 1000 bytes before it turns out to be wrong.
            let (messages, codes) = all(&[&bytes[..], &framed(NOTE).repeat(40)].concat());
            assert!(messages >= 20, "{messages} messages, {codes:?}: {:?}", String::from_utf8_lossy(&bytes));
        }
    }

    #[test]
    fn headers_as_other_editors_write_them() {
        let length = NOTE.len();
        for head in [
            format!("content-length:{length}\r\n\r\n"),
            format!("CONTENT-LENGTH: {length}\n\n"),
            format!(
                "Content-Type: application/vscode-jsonrpc; charset=utf-8\r\nContent-Length: {length}\r\n\r\n"
            ),
        ] {
            assert_eq!(all(&[head.as_bytes(), NOTE.as_bytes()].concat()), (1, vec![]), "{head}");
        }
    }
}
