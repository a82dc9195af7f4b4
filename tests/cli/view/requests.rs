//! Requests of others: many, slow, large, and without the token.

use super::*;
use std::time::Instant;

/// Whether the other side has ended the connection.
fn is_over(stream: &mut TcpStream) -> bool {
    matches!(stream.read(&mut [0; 512]), Ok(0)) || {
        stream.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
        loop {
            match stream.read(&mut [0; 512]) {
                Ok(0) => return true,
                Ok(_) => {}
                Err(error) => {
                    return !matches!(
                        error.kind(),
                        std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut
                    );
                }
            }
        }
    }
}

#[test]
#[cfg(unix)]
fn many_idle_connections_are_survived_where_few_files_may_be_open() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("p.pse"), "color = white\n").unwrap();
    let mut shell = Command::new("sh");
    shell.args(["-c", "ulimit -n 48; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_pse")]);
    let preview = Preview::by(shell, folder, &[]);
    let mut page = preview.events();
    page.picture();
    let mut idle: Vec<TcpStream> = Vec::new();
    for round in 0..4 {
        idle.extend((0..100).map(|_| preview.connect()));
        if round % 2 == 1 {
            idle.drain(..150);
        }
        assert_eq!(preview.get("words").0, 200, "round {round}");
        let text = format!("color = white * {round}\n");
        assert_eq!(preview.post("text", &json!({"text": text, "saves": round})).0, 200);
        let picture = page.picture();
        assert_eq!(preview.first(&picture, "color"), [round as f32; 3]);
        assert_eq!(preview.post("save", &json!({"text": text, "saves": round})).0, 200, "round {round}");
        assert_eq!(fs::read_to_string(preview.folder.path().join("p.pse")).unwrap(), text);
    }
}

#[test]
fn who_sends_slowly_is_not_waited_for() {
    let preview = Preview::new("color = white\n", &[]);
    let (port, token) = (preview.port, &preview.token);
    let begin = [
        "GET / HTTP/1.1\r\nX: ".to_string(),
        format!("POST /{token}/text HTTP/1.1\r\nHost: localhost:{port}\r\nContent-Length: 1000000\r\n\r\n{{"),
    ];
    let started = Instant::now();
    let mut slow: Vec<TcpStream> = begin
        .iter()
        .map(|begin| {
            let mut stream = preview.connect();
            stream.write_all(begin.as_bytes()).unwrap();
            stream.set_read_timeout(Some(Duration::from_millis(500))).unwrap();
            stream
        })
        .collect();
    // A byte now and then is no progress.
    while !slow.is_empty() {
        assert!(started.elapsed() < Duration::from_secs(60), "{} slow senders live on", slow.len());
        slow.retain_mut(|stream| stream.write_all(b" ").is_ok() && !is_over(stream));
    }
    assert!(started.elapsed() > Duration::from_secs(5), "some time is given");
    assert_eq!(preview.get("words").0, 200);
}

#[test]
fn without_the_token_no_body_is_read() {
    let preview = Preview::new("color = white\n", &[]);
    let (port, token) = (preview.port, &preview.token);
    let own = format!("Host: localhost:{port}\r\n");
    // The answer comes although the body does not.
    for (path, headers, status) in [
        ("/".to_string(), own.as_str(), 404),
        (format!("/{}/text", "0".repeat(32)), &own, 404),
        (format!("/{token}/text"), "Host: evil.example\r\n", 403),
        (format!("/{token}/text"), &format!("{own}Origin: http://evil.example\r\n"), 403),
    ] {
        let request = format!("POST {path} HTTP/1.1\r\n{headers}Content-Length: 16000000\r\n\r\n");
        assert_eq!(preview.send(&request).0, status, "{path} {headers}");
    }
    // Nor is one that is too long, with the token.
    let request = format!("POST /{token}/text HTTP/1.1\r\n{own}Content-Length: 99999999999\r\n\r\n");
    let (status, why) = preview.send(&request);
    assert!(status == 400 && why.starts_with(b"the request is too long"), "{status}");
    // A whole body that nobody reads leaves the answer readable.
    let request = format!("POST / HTTP/1.1\r\n{own}Content-Length: 3000000\r\n\r\n{}", " ".repeat(3_000_000));
    assert_eq!(preview.send(&request).0, 404);
}

#[test]
#[cfg(target_os = "linux")]
fn the_browsers_command_line_has_no_lasting_token() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("p.pse"), "color = white\n").unwrap();
    let browser = folder.path().join("xdg-open");
    fs::write(&browser, "#!/bin/sh\nprintf %s \"$1\" > seen.new; mv seen.new seen\n").unwrap();
    fs::set_permissions(&browser, fs::Permissions::from_mode(0o755)).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_pse"));
    let path = std::env::var("PATH").unwrap();
    command.env("PATH", format!("{}:{path}", folder.path().display()));
    let preview = Preview::by(command, folder, &["--open"]);
    let begun = Instant::now();
    let address = loop {
        match fs::read_to_string(preview.folder.path().join("seen")) {
            Ok(address) => break address,
            Err(_) => assert!(begun.elapsed() < Duration::from_secs(60), "no browser was opened"),
        }
        std::thread::sleep(Duration::from_millis(20));
    };
    assert!(!address.contains(&preview.token), "{address}");
    let start = format!("http://127.0.0.1:{}", preview.port);
    let path = address.strip_prefix(&start).expect(&address);
    let answer = |path: &str, headers: &str| {
        let mut stream = preview.connect();
        write!(stream, "GET {path} HTTP/1.1\r\n{headers}\r\n").unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).unwrap();
        answer
    };
    let own = format!("Host: 127.0.0.1:{}\r\n", preview.port);
    assert!(answer(path, "Host: evil.example\r\n").starts_with("HTTP/1.1 403"));
    assert!(answer("/once-", &own).starts_with("HTTP/1.1 404"));
    let first = answer(path, &own);
    let page = format!("Location: {start}/{}/\r\n", preview.token);
    assert!(first.starts_with("HTTP/1.1 303") && first.contains(&page), "{first}");
    assert!(answer(path, &own).starts_with("HTTP/1.1 404"), "it is good once");
}
