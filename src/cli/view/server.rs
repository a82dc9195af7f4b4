//! The server of the page: on this machine alone, for whoever has the address with its token.

use super::connections::{Connections, Stranger};
use super::http::{self, Request, Response};
use super::opening::Opening;
use super::session::{Ran, Session};
use super::token::token;
use crate::cli::failure::Failure;
use crate::cli::trace;
use half::slice::HalfFloatSliceExt;
use pse::Disk;
use pse::image::Variable;
use pse::internal::assist::Reading;
use pse::internal::program::{RunOptions, TraceOptions};
use pse::internal::reference;
use serde_json::{Value, json};
use std::io;
use std::net::{Ipv4Addr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;

/// The most numbers of a pixel that are sent.
pub(super) const COMPONENTS: usize = 4;

/// So often a page hears something, so that one that is gone is noticed.
const ALIVE: Duration = Duration::from_secs(10);

/// How long a connection that could not be taken has to wait: the system has no room for it yet.
const PAUSE: Duration = Duration::from_millis(20);

/// Where the path of the address for `--open` begins.
const ONCE: &str = "/once-";

/// What the page is made of, by name and kind.
const PAGE: [(&str, &str, &str); 9] = [
    ("", "text/html; charset=utf-8", include_str!("page/index.html")),
    ("style.css", "text/css; charset=utf-8", include_str!("page/style.css")),
    ("app.js", "text/javascript; charset=utf-8", include_str!("page/app.js")),
    ("server.js", "text/javascript; charset=utf-8", include_str!("page/server.js")),
    ("picture.js", "text/javascript; charset=utf-8", include_str!("page/picture.js")),
    ("editor.js", "text/javascript; charset=utf-8", include_str!("page/editor.js")),
    ("params.js", "text/javascript; charset=utf-8", include_str!("page/params.js")),
    ("probe.js", "text/javascript; charset=utf-8", include_str!("page/probe.js")),
    ("codemirror.js", "text/javascript; charset=utf-8", include_str!("page/codemirror.js")),
];

/// The page may load and reach nothing but this server. (The editor makes style sheets as it goes.)
const POLICY: &str = "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; base-uri 'none'; \
                      form-action 'none'; frame-ancestors 'none'";

/// The server.
pub(super) struct Server {
    listener: TcpListener,
    session: Arc<Session>,
    port: u16,
    token: String,
    connections: Arc<Connections>,
    opening: Opening,
}

/// What goes back, or a status and why.
type Answer = Result<Response, (u16, String)>;

impl Server {
    /// A server at a port, or at any that is free.
    pub fn bind(port: u16, session: Arc<Session>) -> Result<Server, Failure> {
        let fail = |error: io::Error| {
            Failure::plain(format!("cannot listen on port {port}: {error}"))
                .hint("Choose another with --port; 0 picks a free one.")
        };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(fail)?;
        let port = listener.local_addr().map_err(fail)?.port();
        let (connections, opening) = (Arc::default(), Opening::default());
        Ok(Server { listener, session, port, token: token()?, connections, opening })
    }

    /// Where the page is.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// An address for the browser's command line, which leads to the page once.
    pub fn one_time_address(&self) -> Result<String, Failure> {
        Ok(format!("http://127.0.0.1:{}{ONCE}{}", self.port, self.opening.token()?))
    }

    /// Answers for ever, each request in a thread of its own.
    pub fn serve(self) -> ! {
        let server = Arc::new(self);
        loop {
            let taken = server.listener.accept().and_then(|(stream, _)| {
                let stranger = server.connections.enter(stream);
                let server = Arc::clone(&server);
                let thread = std::thread::Builder::new().name("answer".into());
                thread.spawn(move || server.connection(&stranger)).map(drop)
            });
            // Too many open files, too little memory, no thread, or a connection that went away: none of them lasts.
            if taken.is_err() {
                server.connections.make_room();
                std::thread::sleep(PAUSE);
            }
        }
    }

    fn connection(&self, stranger: &Stranger) {
        let stream = &stranger.stream;
        let answer = match http::read_head(stream) {
            Ok(mut request) => match self.own(&request).map(str::to_string) {
                Ok(path) => match stranger.admit() {
                    Some(_page) if path == "events" => return self.events(stream),
                    // It is counted until the answer is made.
                    Some(_page) => self.answer(stream, &mut request, &path),
                    None => Err((503, "too many pages are open".into())),
                },
                Err((status, why)) => self.redirect(&request).ok_or((status, why.to_string())),
            },
            Err(error) if error.kind() == io::ErrorKind::InvalidData => Err((400, error.to_string())),
            // Nobody waits for an answer.
            Err(_) => return,
        };
        send(stream, answer);
    }

    /// Answers a page.
    fn answer(&self, stream: &TcpStream, request: &mut Request, path: &str) -> Answer {
        match request.method.as_str() {
            "GET" => self.get(path, &request.query),
            "POST" => {
                let body = http::read_body(stream, request).map_err(|error| (400, error.to_string()))?;
                let body = serde_json::from_slice(&body);
                self.post(path, &body.map_err(|error| (400, format!("invalid JSON: {error}")))?)
            }
            _ => Err((405, "only GET and POST".into())),
        }
    }

    /// Leads from the address of `--open` to the page, once.
    fn redirect(&self, request: &Request) -> Option<Response> {
        let token = request.path.strip_prefix(ONCE)?;
        let page = request.method == "GET" && self.is_own_page(request).is_ok() && self.opening.redeem(token);
        page.then(|| {
            let mut response = response(Vec::new(), "text/plain");
            response.status = 303;
            response.headers.push(("Location", self.address()));
            response
        })
    }

    /// The path behind the token, of a request that may be answered. A page of somebody else's that leads a name of its
    /// own to this machine sends that name as the host.
    fn own<'r>(&self, request: &'r Request) -> Result<&'r str, (u16, &'static str)> {
        self.is_own_page(request)?;
        let rest = request.path.strip_prefix('/').and_then(|p| p.strip_prefix(self.token.as_str()));
        match rest.and_then(|rest| rest.strip_prefix('/')) {
            Some(rest) => Ok(rest),
            None => {
                Err((404, "pse view: the address is incomplete. Open the address that the command printed"))
            }
        }
    }

    /// Whether a request means this server, and comes from no page but its own.
    fn is_own_page(&self, request: &Request) -> Result<(), (u16, &'static str)> {
        if !request.host.as_ref().is_some_and(|host| is_own_host(host, self.port)) {
            return Err((403, "this server answers only this machine"));
        }
        let own = |origin: &String| origin.strip_prefix("http://").is_some_and(|o| is_own_host(o, self.port));
        match request.origin.as_ref().is_none_or(own) {
            true => Ok(()),
            false => Err((403, "this server answers only its own page")),
        }
    }

    fn get(&self, path: &str, query: &str) -> Answer {
        if let Some((_, kind, text)) = PAGE.iter().find(|(name, ..)| *name == path) {
            let mut response = response(text.as_bytes().to_vec(), kind);
            response.headers.push(("Content-Security-Policy", POLICY.into()));
            return Ok(response);
        }
        let value = |name: &str| {
            form_urlencoded::parse(query.as_bytes())
                .find(|(n, _)| n == name)
                .map(|(_, value)| value.into_owned())
        };
        let number = |name: &str| value(name).and_then(|v| v.parse::<u64>().ok());
        match path {
            "picture" => {
                let drawn = number("id").and_then(|id| self.session.drawn(id));
                let (Some(drawn), Some(name)) = (drawn, value("output")) else {
                    return Err((404, "there is a newer picture".into()));
                };
                let variable = drawn.image.variable(&name);
                let variable = variable.ok_or((404, format!("the picture has no {name}")))?;
                Ok(response(halves(variable), "application/octet-stream"))
            }
            "probe" => match (number("x"), number("y")) {
                (Some(x), Some(y)) => self.probe([x as usize, y as usize]),
                _ => Err((400, "a pixel has an x and a y".into())),
            },
            "words" => Ok(told(&words())),
            _ => Err((404, format!("no such page: {path}"))),
        }
    }

    fn post(&self, path: &str, body: &Value) -> Answer {
        let text =
            |name: &str| body[name].as_str().map(str::to_string).ok_or((400, format!("{path} needs {name}")));
        let from = body["client"].as_str().unwrap_or_default();
        let saves = body["saves"].as_u64().unwrap_or(0);
        let done = match path {
            "text" => {
                self.session.edit(text("text")?, from, saves);
                Ok(())
            }
            "save" => self.session.save(text("text")?, from, saves),
            "take" => self.session.take(),
            "keep" => {
                self.session.keep_text();
                Ok(())
            }
            "set" => self.session.set(&text("name")?, body["value"].as_str()),
            "write" => self.session.write_back(&text("name")?),
            "show" => {
                self.session.show(&text("name")?);
                Ok(())
            }
            "complete" => return Ok(told(&self.complete(&text("text")?, body))),
            "hover" => return Ok(told(&self.hover(&text("text")?, body))),
            "frame" => self.session.go(body["frame"].as_f64().unwrap_or(f64::NAN)),
            _ => return Err((404, format!("no such page: {path}"))),
        };
        match done {
            Ok(()) => Ok(told(&Value::Null)),
            Err(failure) => Err((400, failure.message())),
        }
    }

    /// What may come at a place of a text that is being written.
    fn complete(&self, text: &str, body: &Value) -> Value {
        let (reading, host) = self.reading(text);
        let found = reading.complete(byte(text, body), &host);
        let items: Vec<Value> = found
            .items
            .iter()
            .map(|item| {
                let kind = format!("{:?}", item.kind).to_lowercase();
                json!({
                    "name": item.name, "kind": kind, "detail": item.detail,
                    "documentation": item.documentation,
                })
            })
            .collect();
        json!({"from": units(text, found.word.start), "items": items})
    }

    /// What a word of a text means.
    fn hover(&self, text: &str, body: &Value) -> Value {
        let (reading, _) = self.reading(text);
        reading.describe(byte(text, body)).map_or(Value::Null, |found| {
            let (from, to) = (units(text, found.range.start), units(text, found.range.end));
            json!({"from": from, "to": to, "text": found.text})
        })
    }

    fn reading(&self, text: &str) -> (Reading, Disk) {
        let host = Disk { path: self.session.fixed.path.clone() };
        let mut reading = Reading::new(&self.session.name(), text, &host);
        reading.inputs.clone_from(&self.session.state().inputs);
        (reading, host)
    }

    /// All that happens at a pixel, as `pse trace --json` tells it.
    fn probe(&self, [column, row]: [usize; 2]) -> Answer {
        let Some(ran) = self.session.state().ran.clone() else {
            return Err((404, "no picture has been drawn yet".into()));
        };
        let Ran { program, picture, frame, set } = &*ran;
        if column >= picture.image.width || row >= picture.image.height {
            return Err((404, format!("the picture has no pixel [{column} {row}]")));
        }
        let missing = |name: &str| picture.inputs.missing(name);
        let options = RunOptions {
            missing: if picture.inputs.list.is_empty() { None } else { Some(&missing) },
            ..self.session.options(*frame, set, program)
        };
        let camera = match picture.camera(program, set, &self.session.fixed.spaces) {
            Ok(camera) => camera,
            Err(failure) => return Err((400, failure.message())),
        };
        let options = camera.options(options);
        let wanted = TraceOptions { depth: u32::MAX, ..TraceOptions::default() };
        match program.trace(&picture.image, column, row, &options, &wanted) {
            Ok(trace) => {
                let json = trace::to_json(&trace, program, &self.session.name(), frame.value);
                Ok(response(json.into_bytes(), "application/json"))
            }
            Err(error) => Err((400, Failure::from(error).message())),
        }
    }

    /// Tells a page what happens, until it is closed.
    fn events(&self, stream: &TcpStream) {
        let events = self.session.join();
        let tell = || -> io::Result<()> {
            http::respond_on(stream, &[("Content-Type", "text/event-stream".into())])?;
            http::send_on(stream, "retry: 500\n\n")?;
            loop {
                let event = match events.recv_timeout(ALIVE) {
                    Ok(event) => event,
                    Err(RecvTimeoutError::Timeout) => ":\n\n".into(),
                    Err(RecvTimeoutError::Disconnected) => return Ok(()),
                };
                http::send_on(stream, &event)?;
            }
        };
        // A page that is gone is no fault.
        let _ = tell();
    }
}

/// Whether a request's host, or its page's, is this server. Browsers leave out the port of HTTP.
fn is_own_host(host: &str, port: u16) -> bool {
    let (name, given) = host.rsplit_once(':').unwrap_or((host, "80"));
    let own = name == "127.0.0.1" || name.eq_ignore_ascii_case("localhost");
    own && given.bytes().all(|digit| digit.is_ascii_digit()) && given.parse() == Ok(port)
}

/// An answer of bytes of a kind.
fn response(body: Vec<u8>, kind: &str) -> Response {
    let headers = vec![
        ("Content-Type", kind.to_string()),
        ("X-Content-Type-Options", "nosniff".into()),
        ("Referrer-Policy", "no-referrer".into()),
    ];
    Response { status: 200, headers, body }
}

/// An answer in JSON.
fn told(value: &Value) -> Response {
    response(value.to_string().into_bytes(), "application/json")
}

fn send(stream: &TcpStream, answer: Answer) {
    let response = answer.unwrap_or_else(|(status, why)| {
        let text = response(format!("{why}\n").into_bytes(), "text/plain; charset=utf-8");
        Response { status, ..text }
    });
    // A page that is gone is no fault.
    let _ = http::respond(stream, &response);
}

/// The first components of a variable, pixel by pixel, as half floats with the low byte first.
fn halves(variable: &Variable<'_>) -> Vec<u8> {
    let planes: Vec<Vec<half::f16>> = variable
        .planes
        .iter()
        .take(COMPONENTS)
        .map(|plane| {
            let mut out = vec![half::f16::ZERO; plane.len()];
            out.convert_from_f32_slice(plane);
            out
        })
        .collect();
    let pixels = planes.first().map_or(0, Vec::len);
    let mut bytes = vec![0; pixels * planes.len() * 2];
    for (c, plane) in planes.iter().enumerate() {
        for (pixel, number) in bytes.chunks_exact_mut(2 * planes.len()).zip(plane) {
            pixel[2 * c..2 * c + 2].copy_from_slice(&number.to_le_bytes());
        }
    }
    bytes
}

/// JavaScript counts in units of UTF-16.
pub(super) fn units(text: &str, byte: usize) -> usize {
    text.get(..byte).map_or(0, |part| part.encode_utf16().count())
}

/// The byte of the place `at` that a page asks for.
fn byte(text: &str, body: &Value) -> usize {
    let mut units = body["at"].as_u64().unwrap_or(0) as usize;
    for (byte, char) in text.char_indices() {
        if units < char.len_utf16() {
            return byte;
        }
        units -= char.len_utf16();
    }
    text.len()
}

/// The words that the editor colours.
fn words() -> Value {
    let functions = reference::entries().into_iter().map(|entry| entry.name);
    let names = reference::names().into_iter().flat_map(|(_, names)| names).map(|(name, _)| name.to_string());
    let keywords: Vec<&str> = reference::KEYWORDS.iter().map(|(word, _)| *word).collect();
    json!({"words": functions.chain(names).collect::<Vec<_>>(), "keywords": keywords})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hosts_of_this_server() {
        for (host, port) in
            [("127.0.0.1:8017", 8017), ("LocalHost:1", 1), ("127.0.0.1", 80), ("localhost:80", 80)]
        {
            assert!(is_own_host(host, port), "{host}");
        }
        let strange = [
            "127.0.0.1",
            "127.0.0.1:",
            "127.0.0.1:+8017",
            "evil.example:8017",
            "x127.0.0.1:8017",
            ":8017",
            "",
        ];
        for host in strange {
            assert!(!is_own_host(host, 8017), "{host}");
        }
    }
}
