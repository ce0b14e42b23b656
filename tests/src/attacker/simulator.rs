//! A simulated robot that waits for missions.

use super::surface::{Judged, Surface};
use super::victim::{IN_TIME, Victim};
use crate::forger::mangle;
use crate::generated::Dice;
use std::io::{BufRead, BufReader, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

/// A mission that says nothing more has lost the robot to others within this time: the patience of the simulator, and
/// the time that others take.
const ROBOT_IS_FREE: Duration = Duration::from_secs(6);

/// How many connections are held open at a time.
const MOST_HELD: usize = 200;

struct Simulator {
    victim: Victim,
    address: SocketAddr,
    held: Vec<(TcpStream, Vec<u8>)>,
}

pub(super) fn start(command: &Path, folder: &Path) -> Result<Box<dyn Surface>, String> {
    let arguments = ["simulate", "--world", "test-room", "--listen", "127.0.0.1:0", "--patience", "2s"];
    let mut victim = Victim::start(command, folder, &arguments)?;
    let address = victim.says("listening at ")?;
    let address = address.trim().parse().map_err(|_| format!("`{address}` is no address"))?;
    Ok(Box::new(Simulator { victim, address, held: Vec::new() }))
}

/// The greeting of a mission for the robot that is served.
const HELLO: &str = "{\"type\":\"hello\",\"protocol\":2,\"rpl\":\"1\",\"robot\":\"b21\",\"mission\":\"good\"}\n";

fn commands(number: u64) -> String {
    format!(
        "{{\"type\":\"commands\",\"number\":{number},\"translation_mps\":0.1,\"rotation_radps\":0.0,\"sonars_on\":true}}\n"
    )
}

impl Simulator {
    fn bytes(&self, dice: &mut Dice) -> (&'static str, Vec<u8>) {
        let whole = HELLO.to_string() + &commands(0) + &commands(1);
        let named = |name: &str| {
            format!("{{\"type\":\"hello\",\"protocol\":2,\"rpl\":{name},\"robot\":{name},\"mission\":{name}}}\n")
                .into_bytes()
        };
        match dice.below(9) {
            0 => ("silence", Vec::new()),
            1 => ("half a greeting", HELLO.as_bytes()[..dice.below(HELLO.len())].to_vec()),
            2 => ("a line without end", vec![b'x'; 1 + dice.below(8 << 20)]),
            3 => ("names that steer a terminal", named("\"\\u001b[2Jx\\nlistening at 127.0.0.1:1\\u009b1m\"")),
            4 => ("commands before the greeting", commands(0).into_bytes()),
            5 => (
                "a reason that steers a terminal",
                b"{\"type\":\"bye\",\"reason\":\"\\u001b]0;x\\u0007\\n\\r\"}\n".to_vec(),
            ),
            6 => ("numbers nobody means", mangle::numbers(&whole, 3, dice).into_bytes()),
            7 => ("many messages that nobody reads", whole.repeat(1 + dice.below(3_000)).into_bytes()),
            _ => ("a mangled conversation", mangle::bytes(whole.as_bytes(), dice)),
        }
    }

    /// A mission greets and is greeted, as soon as the robot is free.
    fn serves(&self, within: Duration) -> Result<(), String> {
        let begun = Instant::now();
        let mut last = String::new();
        while begun.elapsed() < within {
            let Ok(mut stream) = TcpStream::connect_timeout(&self.address, IN_TIME) else {
                return Err("nobody can connect any more".to_string());
            };
            stream.set_read_timeout(Some(IN_TIME)).ok();
            last.clear();
            let is_said = stream.write_all(HELLO.as_bytes()).is_ok();
            let heard = BufReader::new(&stream).read_line(&mut last);
            if last.contains("\"hello\"") {
                stream.write_all(b"{\"type\":\"bye\"}\n").ok();
                return Ok(());
            }
            if !is_said || heard.is_err() {
                last = format!("no answer within {} s", IN_TIME.as_secs());
            }
            thread::sleep(Duration::from_millis(20));
        }
        let errors = self.victim.errors();
        let told = errors.lines().rev().take(9).collect::<Vec<_>>().join("; ");
        Err(format!(
            "a mission has not got the robot within {} s: {}; the last it told: {told}",
            within.as_secs(),
            last.trim()
        ))
    }
}

impl Surface for Simulator {
    fn attack(&mut self, dice: &mut Dice) -> Judged {
        let (kind, bytes) = self.bytes(dice);
        let sent = bytes.clone();
        // Whoever was held before and has greeted by now has the robot for as long as it may.
        let within = ROBOT_IS_FREE;
        if let Ok(mut stream) = TcpStream::connect_timeout(&self.address, IN_TIME) {
            stream.set_write_timeout(Some(IN_TIME / 10)).ok();
            match dice.below(8) {
                0 => {
                    stream.write_all(&bytes).ok();
                    self.held.push((stream, Vec::new()));
                }
                1 => self.held.push((stream, bytes)),
                _ => drop(stream.write_all(&bytes)),
            }
        }
        self.held.retain_mut(|(stream, rest)| rest.is_empty() || stream.write_all(&[rest.remove(0)]).is_ok());
        while self.held.len() > MOST_HELD {
            self.held.remove(0);
        }
        self.serves(within)
            .and_then(|()| self.victim.look())
            .map_err(|finding| format!("{kind}: {finding}; sent {:.400}", String::from_utf8_lossy(&sent)))?;
        Ok(kind)
    }

    fn end(&mut self) -> Result<(), String> {
        self.victim.look()
    }
}
