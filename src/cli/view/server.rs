//! The server of the page: on this machine alone, for whoever has the address with its token.

use super::session::{Ran, Session};
use crate::assist::Reading;
use crate::cli::failure::Failure;
use crate::cli::interrupt::CANCEL;
use crate::cli::trace;
use crate::host::Disk;
use crate::image::Variable;
use crate::program::{RunOptions, TraceOptions};
use crate::reference;
use half::slice::HalfFloatSliceExt;
use serde_json::{Value, json};
use std::io::{self, Read, Write};
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::RecvTimeoutError;
use std::time::Duration;
use tiny_http::{Header, Method, Request, Response};

/// The most numbers of a pixel that are sent.
pub(super) const COMPONENTS: usize = 4;

/// The largest text that a page may send.
const MOST: u64 = 16 << 20;

/// Requests that are answered at the same time.
const THREADS: usize = 4;

/// So often a page hears something, so that one that is gone is noticed.
const ALIVE: Duration = Duration::from_secs(10);

/// What the page is made of, by name and kind.
const PAGE: [(&str, &str, &str); 9] = [
    ("", "text/html", include_str!("page/index.html")),
    ("style.css", "text/css", include_str!("page/style.css")),
    ("app.js", "text/javascript", include_str!("page/app.js")),
    ("server.js", "text/javascript", include_str!("page/server.js")),
    ("picture.js", "text/javascript", include_str!("page/picture.js")),
    ("editor.js", "text/javascript", include_str!("page/editor.js")),
    ("params.js", "text/javascript", include_str!("page/params.js")),
    ("probe.js", "text/javascript", include_str!("page/probe.js")),
    ("codemirror.js", "text/javascript", include_str!("page/codemirror.js")),
];

/// The page may load and reach nothing but this server. (The editor makes style sheets as it goes.)
const POLICY: &str = "default-src 'self'; style-src 'self' 'unsafe-inline'; img-src 'self' data:; base-uri 'none'; \
                      form-action 'none'; frame-ancestors 'none'";

/// The server.
pub(super) struct Server {
    http: Arc<tiny_http::Server>,
    session: Arc<Session>,
    port: u16,
    token: String,
}

/// What goes back.
type Answer = Result<Response<io::Cursor<Vec<u8>>>, (u16, String)>;

impl Server {
    /// A server at a port, or at any that is free.
    pub fn bind(port: u16, session: Arc<Session>) -> Result<Server, Failure> {
        let fail = |error: &dyn std::fmt::Display| {
            Failure::plain(format!("cannot listen at port {port}: {error}"))
                .hint("Choose another one, or 0 for any that is free (--port).")
        };
        let http =
            tiny_http::Server::http(SocketAddr::from((Ipv4Addr::LOCALHOST, port))).map_err(|e| fail(&e))?;
        let port = http.server_addr().to_ip().map_or(port, |address| address.port());
        Ok(Server { http: Arc::new(http), session, port, token: super::token::token()? })
    }

    /// Where the page is.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// Answers until the command is interrupted.
    pub fn serve(&self) {
        std::thread::scope(|scope| {
            for _ in 0..THREADS {
                scope.spawn(|| {
                    while !CANCEL.load(Ordering::Relaxed) {
                        match self.http.recv_timeout(Duration::from_millis(100)) {
                            Ok(Some(request)) => self.answer(request),
                            Ok(None) => {}
                            Err(_) => break,
                        }
                    }
                });
            }
        });
    }

    fn answer(&self, mut request: Request) {
        let url = request.url().to_string();
        let (path, query) = url.split_once('?').unwrap_or((&url, ""));
        let path = match self.own(&request, path) {
            Ok(path) => path.to_string(),
            Err((status, why)) => return send(request, Err((status, why.to_string()))),
        };
        if path == "events" {
            self.events(request);
            return;
        }
        let answer = match request.method() {
            Method::Get => self.get(&path, query),
            Method::Post => body(&mut request).and_then(|body| self.post(&path, &body)),
            _ => Err((405, "only GET and POST".into())),
        };
        send(request, answer);
    }

    /// The path behind the token, of a request that may be answered. A page of somebody else's that leads a name of its
    /// own to this machine sends that name as the host.
    fn own<'p>(&self, request: &Request, path: &'p str) -> Result<&'p str, (u16, &'static str)> {
        let value = |name: &'static str| {
            request.headers().iter().find(|h| h.field.equiv(name)).map(|h| h.value.as_str())
        };
        let hosts = [format!("127.0.0.1:{}", self.port), format!("localhost:{}", self.port)];
        if !value("Host").is_some_and(|host| hosts.iter().any(|own| own == host)) {
            return Err((403, "this server is for this machine alone"));
        }
        let foreign = |origin: &str| !hosts.iter().any(|own| origin.strip_prefix("http://") == Some(own));
        if value("Origin").is_some_and(foreign) {
            return Err((403, "this server is for its own page alone"));
        }
        let rest = path.strip_prefix('/').and_then(|p| p.strip_prefix(self.token.as_str()));
        match rest.and_then(|rest| rest.strip_prefix('/')) {
            Some(rest) => Ok(rest),
            None => Err((404, "pse view: the address is not whole; it is what the command printed")),
        }
    }

    fn get(&self, path: &str, query: &str) -> Answer {
        if let Some((_, kind, text)) = PAGE.iter().find(|(name, ..)| *name == path) {
            let response = response(text.as_bytes().to_vec(), &format!("{kind}; charset=utf-8"));
            return Ok(response.with_header(header("Content-Security-Policy", POLICY)));
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
            _ => Err((404, format!("there is no {path}"))),
        }
    }

    fn post(&self, path: &str, body: &Value) -> Answer {
        let text =
            |name: &str| body[name].as_str().map(str::to_string).ok_or((400, format!("{path} needs {name}")));
        let from = body["client"].as_str().unwrap_or_default();
        let done = match path {
            "text" => {
                self.session.edit(text("text")?, from);
                Ok(())
            }
            "save" => self.session.save(text("text")?, from),
            "take" => {
                self.session.take();
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
            "frame" => self.session.go(body["frame"].as_f64().unwrap_or(f64::NAN) as f32),
            _ => return Err((404, format!("there is no {path}"))),
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
        let wanted = TraceOptions { depth: u32::MAX, ..TraceOptions::default() };
        match program.trace(&picture.image, column, row, &options, &wanted) {
            Ok(trace) => {
                let json = trace::to_json(&trace, program, &self.session.name(), *frame);
                Ok(response(json.into_bytes(), "application/json"))
            }
            Err(error) => Err((400, Failure::from(error).message())),
        }
    }

    /// Tells a page what happens, until it is closed.
    fn events(&self, request: Request) {
        let events = self.session.join();
        let mut out = request.into_writer();
        let mut tell = move || -> io::Result<()> {
            out.write_all(
                b"HTTP/1.1 200 OK\r\nContent-Type: text/event-stream\r\nCache-Control: no-store\r\n\
                  Connection: close\r\n\r\nretry: 500\n\n",
            )?;
            out.flush()?;
            loop {
                let event = match events.recv_timeout(ALIVE) {
                    Ok(event) => event,
                    Err(RecvTimeoutError::Timeout) => ":\n\n".into(),
                    Err(RecvTimeoutError::Disconnected) => return Ok(()),
                };
                out.write_all(event.as_bytes())?;
                out.flush()?;
            }
        };
        // A page that is gone is no fault.
        std::thread::spawn(move || drop(tell()));
    }
}

fn header(name: &str, value: &str) -> Header {
    Header::from_bytes(name, value).expect("headers are ASCII")
}

fn response(bytes: Vec<u8>, kind: &str) -> Response<io::Cursor<Vec<u8>>> {
    Response::from_data(bytes)
        .with_header(header("Content-Type", kind))
        .with_header(header("Cache-Control", "no-store"))
        .with_header(header("X-Content-Type-Options", "nosniff"))
        .with_header(header("Referrer-Policy", "no-referrer"))
}

fn told(value: &Value) -> Response<io::Cursor<Vec<u8>>> {
    response(value.to_string().into_bytes(), "application/json")
}

fn send(request: Request, answer: Answer) {
    let response = answer.unwrap_or_else(|(status, why)| {
        response(format!("{why}\n").into_bytes(), "text/plain; charset=utf-8").with_status_code(status)
    });
    // A page that is gone is no fault.
    let _ = request.respond(response);
}

/// What a page sends.
fn body(request: &mut Request) -> Result<Value, (u16, String)> {
    let mut bytes = Vec::new();
    let read = request.as_reader().take(MOST).read_to_end(&mut bytes);
    read.map_err(|error| (400, format!("the request broke off: {error}")))?;
    serde_json::from_slice(&bytes).map_err(|error| (400, format!("that is no JSON: {error}")))
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
