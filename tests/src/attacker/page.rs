//! The live page of a run that can be steered: attacked by clients without its token.

use super::surface::{Judged, Surface};
use super::victim::{IN_TIME, Victim};
use crate::forger::mangle;
use crate::generated::Dice;
use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpStream};
use std::path::Path;

/// A run that goes on until somebody at the page ends it.
const PLAN: &str = "(loop (wait-time 1))\n";

/// How many connections are held open at a time.
const MOST_HELD: usize = 300;

struct Page {
    victim: Victim,
    address: SocketAddr,
    token: String,
    /// Connections that say nothing more, and such as say a byte at a time.
    held: Vec<(TcpStream, Vec<u8>)>,
}

pub(super) fn start(command: &Path, folder: &Path) -> Result<Box<dyn Surface>, String> {
    std::fs::write(folder.join("plan.rpl"), PLAN).map_err(|error| error.to_string())?;
    let arguments = ["run", "plan.rpl", "--realtime", "--live", "127.0.0.1:0", "--control"];
    let mut victim = Victim::start(command, folder, &arguments)?;
    let link = victim.says("http://")?;
    let (address, token) = link.split_once("/?token=").ok_or_else(|| format!("the link has no token: {link}"))?;
    let address = address.parse().map_err(|_| format!("`{address}` is no address"))?;
    Ok(Box::new(Page { victim, address, token: token.trim().to_string(), held: Vec::new() }))
}

/// How a client behaves when it has sent its bytes.
#[derive(Clone, Copy)]
enum After {
    /// It goes.
    Goes,
    /// It stays, and neither reads nor writes.
    Stays,
    /// It says that it will write nothing more, and stays.
    Closes,
    /// It has not sent them: it sends a byte now and then.
    Drips,
}

impl Page {
    /// What a client sends, by the kind of attack.
    fn bytes(&self, dice: &mut Dice) -> (&'static str, Vec<u8>) {
        let host = self.address;
        let get = format!("GET / HTTP/1.1\r\nHost: {host}\r\n\r\n");
        let fields = |more: &str| format!("GET / HTTP/1.1\r\nHost: {host}\r\n{more}\r\n").into_bytes();
        match dice.below(17) {
            0 => ("silence", Vec::new()),
            1 => ("half a request", get.as_bytes()[..dice.below(get.len())].to_vec()),
            2 => ("a body that does not come", fields("Content-Length: 1000000\r\n")),
            3 => ("a body that is waited for", fields("Content-Length: 10\r\nExpect: 100-continue\r\n")),
            4 => (
                "a chunked body without end",
                [&fields("Transfer-Encoding: chunked\r\n")[..], b"ffffffff\r\n"].concat(),
            ),
            5 => ("a long field", fields(&format!("X: {}\r\n", "x".repeat(1 + dice.below(4 << 20))))),
            6 => ("many fields", fields(&"X: y\r\n".repeat(1 + dice.below(20_000)))),
            7 => ("a long line", format!("GET /{} HTTP/1.1\r\n\r\n", "x".repeat(dice.below(4 << 20))).into_bytes()),
            8 => ("many requests at once", get.repeat(1 + dice.below(2_000)).into_bytes()),
            9 => ("a question for lines", format!("GET /lines?from=0 HTTP/1.1\r\nHost: {host}\r\n\r\n").into_bytes()),
            10 => {
                let asked = "\"stop\"";
                let head = format!("POST /ask HTTP/1.1\r\nHost: {host}\r\nContent-Length: {}\r\n\r\n", asked.len());
                ("a stop without the token", (head + asked).into_bytes())
            }
            11 => {
                let origin = "Origin: http://elsewhere.example\r\nContent-Length: 6\r\n";
                let head = format!("POST /ask?token={} HTTP/1.1\r\nHost: {host}\r\n{origin}\r\n", self.token);
                ("a stop from another page", (head + "\"stop\"").into_bytes())
            }
            12 => ("another host", b"GET / HTTP/1.1\r\nHost: elsewhere.example\r\n\r\n".to_vec()),
            13 => ("no HTTP", [0x16, 3, 1, 2, 0, 1, 0, 1, 0xfc, 3, 3].repeat(1 + dice.below(50))),
            14 => ("two lengths", fields("Content-Length: 5\r\nContent-Length: 7\r\n")),
            15 => ("an odd length", fields(&format!("Content-Length: {}\r\n", dice.pick(mangle::NUMBERS)))),
            _ => ("a mangled request", mangle::bytes(get.as_bytes(), dice)),
        }
    }

    /// Those who drip say one byte more; those who were sent away are forgotten.
    fn drip(&mut self) {
        self.held.retain_mut(|(stream, rest)| match rest.is_empty() {
            true => true,
            false => stream.write_all(&[rest.remove(0)]).is_ok(),
        });
        while self.held.len() > MOST_HELD {
            self.held.remove(0);
        }
    }

    /// What the person with the link asks for, and the status of the answer.
    fn ask(&self, method: &str, path: &str, body: &str) -> Result<String, String> {
        let ask = || -> io::Result<String> {
            let mut stream = TcpStream::connect_timeout(&self.address, IN_TIME)?;
            stream.set_read_timeout(Some(IN_TIME))?;
            stream.set_write_timeout(Some(IN_TIME))?;
            let (host, token, length) = (self.address, &self.token, body.len());
            let head = format!("{method} {path}?token={token} HTTP/1.1\r\nHost: {host}\r\n");
            write!(stream, "{head}Connection: close\r\nContent-Length: {length}\r\n\r\n{body}")?;
            let mut answer = String::new();
            stream.read_to_string(&mut answer)?;
            Ok(answer)
        };
        let answer =
            ask().map_err(|error| format!("{method} {path} with the token is not answered in time: {error}"))?;
        Ok(answer.split(' ').nth(1).unwrap_or_default().to_string())
    }

    fn is_served(&self, method: &str, path: &str, body: &str, status: &str) -> Result<(), String> {
        match self.ask(method, path, body)? {
            found if found == status => Ok(()),
            found => Err(format!("{method} {path} is answered with status {found:?} and not {status}")),
        }
    }
}

impl Surface for Page {
    fn attack(&mut self, dice: &mut Dice) -> Judged {
        let (kind, bytes) = self.bytes(dice);
        let after = [After::Goes, After::Stays, After::Closes, After::Drips][dice.below(4)];
        // Whoever is refused has not attacked: the page may take no more connections than it likes.
        if let Ok(mut stream) = TcpStream::connect_timeout(&self.address, IN_TIME) {
            stream.set_write_timeout(Some(IN_TIME / 10)).ok();
            match after {
                After::Drips => self.held.push((stream, bytes)),
                After::Goes => drop(stream.write_all(&bytes)),
                After::Stays | After::Closes => {
                    stream.write_all(&bytes).ok();
                    if matches!(after, After::Closes) {
                        stream.shutdown(Shutdown::Write).ok();
                    }
                    self.held.push((stream, Vec::new()));
                }
            }
        }
        self.drip();
        let served = match dice.below(4) {
            0 => self.is_served("POST", "/ask", "\"go\"", "204"),
            _ => self.is_served("GET", "/", "", "200"),
        };
        served.and_then(|()| self.victim.look()).map_err(|finding| format!("{kind}: {finding}"))?;
        Ok(kind)
    }

    fn end(&mut self) -> Result<(), String> {
        self.victim.look()?;
        self.is_served("POST", "/ask", "\"stop\"", "204")?;
        self.victim.says("interrupted at ").map(drop)
    }
}
