//! The servers of editors and debuggers: messages that are no messages, and a good one after each.

use super::surface::{Judged, Surface};
use super::victim::{IN_TIME, Victim};
use crate::forger::mangle;
use crate::generated::Dice;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{ChildStdin, ChildStdout};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::Instant;

/// Which protocol is spoken.
#[derive(Clone, Copy)]
enum Protocol {
    LanguageServer,
    DebugAdapter,
}

struct Editor {
    protocol: Protocol,
    command: PathBuf,
    folder: PathBuf,
    victim: Victim,
    to: ChildStdin,
    heard: Receiver<Value>,
    number: i64,
}

pub(super) fn start_language_server(command: &Path, folder: &Path) -> Result<Box<dyn Surface>, String> {
    Editor::start(Protocol::LanguageServer, command, folder)
}

pub(super) fn start_debug_adapter(command: &Path, folder: &Path) -> Result<Box<dyn Surface>, String> {
    Editor::start(Protocol::DebugAdapter, command, folder)
}

fn framed(text: &[u8]) -> Vec<u8> {
    [format!("Content-Length: {}\r\n\r\n", text.len()).as_bytes(), text].concat()
}

/// The next message of a stream.
fn next(from: &mut impl BufRead) -> Option<Value> {
    let mut length = 0;
    loop {
        let mut line = String::new();
        if from.read_line(&mut line).ok()? == 0 {
            return None;
        }
        match line.trim_end() {
            "" => break,
            line => {
                length = line.strip_prefix("Content-Length: ").map_or(Some(length), |number| number.parse().ok())?
            }
        }
    }
    let mut bytes = vec![0; length];
    from.read_exact(&mut bytes).ok()?;
    serde_json::from_slice(&bytes).ok()
}

/// All that is said to the end of a stream, message by message.
fn listen(out: ChildStdout) -> Receiver<Value> {
    let (said, heard) = channel();
    thread::spawn(move || {
        let mut from = BufReader::new(out);
        while let Some(message) = next(&mut from) {
            if said.send(message).is_err() {
                return;
            }
        }
    });
    heard
}

impl Protocol {
    fn subcommand(self) -> &'static str {
        match self {
            Self::LanguageServer => "lsp",
            Self::DebugAdapter => "dap",
        }
    }

    fn request(self, number: i64, method: &str, parameters: Value) -> Value {
        match self {
            Self::LanguageServer => {
                json!({ "jsonrpc": "2.0", "id": number, "method": method, "params": parameters })
            }
            Self::DebugAdapter => {
                json!({ "seq": number, "type": "request", "command": method, "arguments": parameters })
            }
        }
    }

    fn is_answer(self, message: &Value, number: i64) -> bool {
        match self {
            Self::LanguageServer => message["id"] == number && message["method"].is_null(),
            Self::DebugAdapter => message["type"] == "response" && message["request_seq"] == number,
        }
    }

    /// Messages that are good before they are mangled.
    fn good(self, number: i64, dice: &mut Dice) -> Value {
        let uri = format!("file:///nowhere/{}.rpl", dice.below(4));
        let line = [0, 1, 7, 1 << 31, u32::MAX as usize][dice.below(5)];
        let position = json!({ "line": line, "character": dice.below(9) });
        let range = json!({ "start": { "line": dice.below(3), "character": line }, "end": position });
        match self {
            Self::LanguageServer => match dice.below(5) {
                0 => json!({ "jsonrpc": "2.0", "method": "textDocument/didOpen", "params": { "textDocument":
                    { "uri": uri, "languageId": "rpl", "version": dice.below(9), "text": "(print \"é🤖\")\n(go-to 'x)" } } }),
                1 => json!({ "jsonrpc": "2.0", "method": "textDocument/didChange", "params": { "textDocument":
                    { "uri": uri, "version": dice.below(9) }, "contentChanges": [{ "range": range, "text": "\u{fffd}(é" }] } }),
                2 => {
                    json!({ "jsonrpc": "2.0", "method": "textDocument/didClose", "params": { "textDocument": { "uri": uri } } })
                }
                3 => json!({ "jsonrpc": "2.0", "method": "$/cancelRequest", "params": { "id": number } }),
                _ => {
                    let method = dice.pick(&["textDocument/hover", "textDocument/completion", "textDocument/rename"]);
                    let place = json!({ "textDocument": { "uri": uri }, "position": position, "newName": "x y" });
                    self.request(number, method, place)
                }
            },
            Self::DebugAdapter => {
                let method =
                    dice.pick(&["setBreakpoints", "stackTrace", "evaluate", "next", "launch", "stepBack", "scopes"]);
                let arguments = json!({ "program": "nowhere.rpl", "threadId": line, "frameId": line, "expression": "(",
                    "source": { "path": uri }, "breakpoints": [{ "line": line }], "variablesReference": line });
                self.request(number, method, arguments)
            }
        }
    }
}

impl Editor {
    fn start(protocol: Protocol, command: &Path, folder: &Path) -> Result<Box<dyn Surface>, String> {
        let (victim, (to, out)) = Victim::start_to_speak(command, folder, &[protocol.subcommand()])?;
        let (command, folder) = (command.to_path_buf(), folder.to_path_buf());
        let mut editor = Self { protocol, command, folder, victim, to, heard: listen(out), number: 0 };
        editor.is_answered("initialize", json!({ "capabilities": {}, "adapterID": "rpl" }))?;
        if matches!(protocol, Protocol::LanguageServer) {
            let initialized = json!({ "jsonrpc": "2.0", "method": "initialized", "params": {} });
            editor.to.write_all(&framed(initialized.to_string().as_bytes())).map_err(|error| error.to_string())?;
        }
        editor.victim.is_at_rest();
        Ok(Box::new(editor))
    }

    /// A good request is answered in time, whatever the answer is.
    fn is_answered(&mut self, method: &str, parameters: Value) -> Result<(), String> {
        self.number += 1;
        let request = self.protocol.request(self.number, method, parameters).to_string();
        let begun = Instant::now();
        self.to.write_all(&framed(request.as_bytes())).map_err(|error| format!("it does not read: {error}"))?;
        while let Some(left) = IN_TIME.checked_sub(begun.elapsed()) {
            match self.heard.recv_timeout(left) {
                Ok(message) if self.protocol.is_answer(&message, self.number) => return Ok(()),
                Ok(_) => {}
                Err(_) => break,
            }
        }
        Err(format!("a good request is not answered in time: {}", self.victim.errors()))
    }

    /// A text that is no message, or not a right one.
    fn text(&mut self, dice: &mut Dice) -> (&'static str, Vec<u8>) {
        self.number += 1;
        let good = self.protocol.good(self.number, dice);
        let text = good.to_string();
        match dice.below(8) {
            0 => (
                "half a surrogate pair",
                text.replace('\u{fffd}', "\\ud83d").replace("nowhere", "\\udd16").into_bytes(),
            ),
            1 => ("no JSON", mangle::bytes(text.as_bytes(), dice)),
            2 => ("an array", format!("[{text}]").into_bytes()),
            3 => ("numbers nobody means", mangle::numbers(&text, 2, dice).into_bytes()),
            4 => ("no object", dice.pick(&["null", "7", "\"x\"", "{}", "", "\u{feff}{}", "[[[[", "{\"id\":1}"]).into()),
            5 => ("no text", vec![0xff; 1 + dice.below(99)]),
            6 => ("parts of another kind", text.replace(":{", ":[{").replace("}", "}]").into_bytes()),
            _ => ("a strange message", text.into_bytes()),
        }
    }

    /// Frames without rule or end: the server may go, in time and with a reason.
    fn frame(&self, dice: &mut Dice) -> Result<&'static str, String> {
        let arguments = [self.protocol.subcommand()];
        let (mut victim, (mut to, out)) = Victim::start_to_speak(&self.command, &self.folder, &arguments)?;
        let heard = listen(out);
        let good = framed(self.protocol.request(1, "initialize", json!({ "capabilities": {} })).to_string().as_bytes());
        let (kind, bytes) = match dice.below(4) {
            0 => {
                ("a frame of any length", format!("Content-Length: {}\r\n\r\n{{}}", dice.pick(mangle::NUMBERS)).into())
            }
            1 => ("a head without end", vec![b'x'; 1 + dice.below(4 << 20)]),
            2 => ("half a frame", good[..dice.below(good.len())].to_vec()),
            _ => ("a mangled frame", mangle::bytes(&good, dice)),
        };
        to.write_all(&bytes).ok();
        drop(to);
        let status = victim.ends_within(IN_TIME).map_err(|finding| format!("{kind}: {finding}"))?;
        drop(heard);
        match status.code() {
            Some(0..=2) => Ok(kind),
            _ => Err(format!("{kind}: it ended with {status}: {}", victim.errors())),
        }
    }
}

impl Surface for Editor {
    fn attack(&mut self, dice: &mut Dice) -> Judged {
        if dice.once_in(50) {
            return self.frame(dice);
        }
        let (kind, text) = self.text(dice);
        let method = match self.protocol {
            Protocol::LanguageServer => "workspace/symbol",
            Protocol::DebugAdapter => "threads",
        };
        self.to
            .write_all(&framed(&text))
            .map_err(|error| error.to_string())
            .and_then(|()| self.is_answered(method, json!({ "query": "x" })))
            .and_then(|()| self.victim.look())
            .map_err(|finding| format!("{kind}: {finding}; sent {:.300}", String::from_utf8_lossy(&text)))?;
        Ok(kind)
    }

    fn end(&mut self) -> Result<(), String> {
        self.victim.look()
    }
}
