//! Recordings: all that came to a run from outside, as JSON Lines, written as it comes.
//!
//! The first line says which run it is; each further line is one thing that came: a turn of a line
//! (`{"line":…,"turn":…,"words":…,"answer":…}`, or `fault` in the place of `answer`), or what was typed
//! (`{"typed":…,"time_us":…}`). A last line that was not written to its end is left out when it is read.

use crate::journal::inputs::Inputs;
use rpl_protocol::line::LineFault;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fs::File;
use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// The version of the lines.
pub const VERSION: u64 = 1;

/// A recording being written, or what a journal has of one.
#[derive(Debug)]
pub struct Recorder {
    out: Out,
}

#[derive(Debug)]
enum Out {
    /// A file of its own.
    Recording(Mutex<RecordingFile>),
    /// The inputs of a journal, which knows what to do when the disk is full.
    Journal(Arc<Mutex<Inputs>>),
}

#[derive(Debug)]
struct RecordingFile {
    file: File,
    /// Why nothing more could be written.
    fault: Option<io::Error>,
}

/// The first line.
#[derive(Debug, Serialize, Deserialize)]
struct Head<H> {
    recording: u64,
    run: H,
}

/// A turn as it is written.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields, bound(deserialize = "N: Deserialize<'de>, Q: Deserialize<'de>, A: Deserialize<'de>"))]
struct TurnLine<N, Q, A> {
    line: N,
    turn: u64,
    words: Q,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    answer: Option<A>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    fault: Option<String>,
}

/// What was typed, and when it took effect.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Typed {
    /// The text.
    pub typed: String,
    /// Time of the run.
    pub time_us: u64,
}

impl Recorder {
    /// A recording that begins with what says which run it is.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn begin<H: Serialize>(file: File, run: &H) -> io::Result<Self> {
        let recorder = Self { out: Out::Recording(Mutex::new(RecordingFile { file, fault: None })) };
        recorder.write(&Head { recording: VERSION, run });
        recorder.finish()?;
        Ok(recorder)
    }

    /// Turns are written among the inputs of a journal.
    pub fn of_journal(inputs: Arc<Mutex<Inputs>>) -> Self {
        Self { out: Out::Journal(inputs) }
    }

    /// A turn of a line is over.
    pub fn turn<Q: Serialize, A: Serialize>(&self, line: &str, turn: u64, words: &Q, answer: &Result<A, LineFault>) {
        let (answer, fault) = match answer {
            Ok(answer) => (Some(answer), None),
            Err(LineFault(why)) => (None, Some(why.clone())),
        };
        self.write(&TurnLine { line, turn, words, answer, fault });
    }

    /// Something was typed.
    pub fn typed(&self, typed: &Typed) {
        self.write(typed);
    }

    /// Whether all was written.
    ///
    /// # Errors
    /// The first that was not.
    pub fn finish(&self) -> io::Result<()> {
        match &self.out {
            Out::Recording(file) => {
                file.lock().unwrap_or_else(PoisonError::into_inner).fault.take().map_or(Ok(()), Err)
            }
            Out::Journal(_) => Ok(()),
        }
    }

    fn write(&self, line: &impl Serialize) {
        let line = serde_json::to_vec(line).map_err(io::Error::from);
        match (&self.out, line) {
            (Out::Recording(file), line) => file.lock().unwrap_or_else(PoisonError::into_inner).write(line),
            (Out::Journal(inputs), Ok(line)) => inputs.lock().unwrap_or_else(PoisonError::into_inner).turn(&line),
            (Out::Journal(_), Err(error)) => {
                unreachable!("what was said and heard was read or written before: {error}")
            }
        }
    }
}

impl RecordingFile {
    /// Writes a line at once, so that a run that is killed leaves what it has heard. After a fault nothing
    /// is written: a recording has no gaps.
    fn write(&mut self, line: io::Result<Vec<u8>>) {
        if self.fault.is_some() {
            return;
        }
        let written = line.and_then(|mut bytes| {
            bytes.push(b'\n');
            self.file.write_all(&bytes)
        });
        self.fault = written.err();
    }
}

/// What was said at a turn, and what came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn<Q, A> {
    /// What was said.
    pub words: Q,
    /// The answer, or why there was none.
    pub answer: Result<A, LineFault>,
}

/// Turns of a line that follow each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch<Q, A> {
    /// The number of the first.
    pub first: u64,
    /// All of them.
    pub turns: Vec<Turn<Q, A>>,
}

/// A recording that was read.
#[derive(Debug)]
pub struct Recording<H> {
    /// Which run it is.
    pub run: H,
    /// What was typed, in its order.
    pub typed: Vec<Typed>,
    /// What was said to others, and what they said.
    pub turns: RecordedTurns,
}

/// The turns of all lines of a recording.
#[derive(Debug)]
pub struct RecordedTurns {
    /// As they are written: the number in the file, the name of the line, and the text.
    written: Vec<(usize, String, String)>,
}

/// What is wrong with a recording.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum RecordingFault {
    /// There is no first line, or it is none of a recording.
    #[error("line 1: a recording of rpl is expected, which begins with {{\"recording\":{VERSION},…}}: {0}")]
    NoHead(String),
    /// It was written by another version.
    #[error("line 1: the recording has version {0}, and this rpl reads version {VERSION}")]
    Version(u64),
    /// A line that says nothing a recording has.
    #[error("line {line}: {why}")]
    Line {
        /// From 1.
        line: usize,
        /// What is wrong with it.
        why: String,
    },
}

impl<H: DeserializeOwned> Recording<H> {
    /// Reads a recording. A last line without an end is left out: whoever wrote it was killed.
    ///
    /// # Errors
    /// The first fault, with its line.
    pub fn read(text: &str) -> Result<Self, RecordingFault> {
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let mut lines = whole.lines().enumerate().map(|(at, line)| (at + 1, line));
        let (_, first) = lines.next().ok_or_else(|| RecordingFault::NoHead("it has no whole line".to_string()))?;
        let run = head(first)?;
        let (mut typed, mut turns) = (Vec::new(), Vec::new());
        for (line, text) in lines.filter(|(_, text)| !text.trim().is_empty()) {
            let fault = |why: String| RecordingFault::Line { line, why };
            match serde_json::from_str::<Kind>(text).map_err(|error| fault(said(&error)))? {
                Kind { line: Some(name), typed: None } => turns.push((line, name, text.to_string())),
                Kind { line: None, typed: Some(_) } => {
                    typed.push(serde_json::from_str(text).map_err(|error| fault(said(&error)))?);
                }
                Kind { .. } => {
                    return Err(fault("a turn of a `line`, or what was `typed`, is expected".to_string()));
                }
            }
        }
        Ok(Self { run, typed, turns: RecordedTurns { written: turns } })
    }
}

impl<Q, A> Default for Stretch<Q, A> {
    fn default() -> Self {
        Self { first: 0, turns: Vec::new() }
    }
}

impl RecordedTurns {
    /// Those among the inputs of a journal.
    ///
    /// # Errors
    /// The first line that is no turn.
    pub fn of_journal(lines: Vec<String>) -> Result<Self, RecordingFault> {
        let read = lines.into_iter().enumerate().map(|(at, text)| {
            let name = serde_json::from_str::<Kind>(&text).ok().and_then(|kind| kind.line);
            let fault = || RecordingFault::Line { line: at + 1, why: "a turn of a `line` is expected".to_string() };
            Ok((at + 1, name.ok_or_else(fault)?, text))
        });
        Ok(Self { written: read.collect::<Result<_, _>>()? })
    }

    /// The turns of a line from its start on.
    ///
    /// # Errors
    /// A turn cannot be read, or is not the next of its line.
    pub fn of<Q: DeserializeOwned, A: DeserializeOwned>(&self, name: &str) -> Result<Vec<Turn<Q, A>>, RecordingFault> {
        Ok(self.turns_of(name, Some(0))?.turns)
    }

    /// The turns of a line from wherever it is heard first.
    ///
    /// # Errors
    /// As for [`RecordedTurns::of`].
    pub fn stretch<Q: DeserializeOwned, A: DeserializeOwned>(
        &self,
        name: &str,
    ) -> Result<Stretch<Q, A>, RecordingFault> {
        self.turns_of(name, None)
    }

    fn turns_of<Q: DeserializeOwned, A: DeserializeOwned>(
        &self,
        name: &str,
        mut first: Option<u64>,
    ) -> Result<Stretch<Q, A>, RecordingFault> {
        let mut turns: Vec<Turn<Q, A>> = Vec::new();
        for (line, _, text) in self.written.iter().filter(|(_, of, _)| of == name) {
            let fault = |why: String| RecordingFault::Line { line: *line, why };
            let read: TurnLine<String, Q, A> = serde_json::from_str(text).map_err(|error| fault(said(&error)))?;
            let expected = *first.get_or_insert(read.turn) + turns.len() as u64;
            if read.turn != expected {
                let why = format!("turn {expected} of `{name}` is expected, and this is turn {}", read.turn);
                return Err(fault(why));
            }
            let answer = match (read.answer, read.fault) {
                (Some(answer), None) => Ok(answer),
                (None, Some(why)) => Err(LineFault(why)),
                _ => return Err(fault("a turn has either an `answer` or a `fault`".to_string())),
            };
            turns.push(Turn { words: read.words, answer });
        }
        Ok(Stretch { first: first.unwrap_or(0), turns })
    }
}

/// What kind of line it is; the rest is read later.
#[derive(Deserialize)]
struct Kind {
    line: Option<String>,
    typed: Option<String>,
}

fn head<H: DeserializeOwned>(line: &str) -> Result<H, RecordingFault> {
    #[derive(Deserialize)]
    struct Version {
        recording: u64,
    }
    let no_head = |error: serde_json::Error| RecordingFault::NoHead(said(&error));
    let Version { recording } = serde_json::from_str(line).map_err(no_head)?;
    if recording != VERSION {
        return Err(RecordingFault::Version(recording));
    }
    serde_json::from_str::<Head<H>>(line).map(|head| head.run).map_err(no_head)
}

/// An error without its place, which is that of a line alone.
fn said(error: &serde_json::Error) -> String {
    let text = error.to_string();
    match text.rfind(" at line ") {
        Some(end) => format!("{} (column {})", &text[..end], error.column()),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: &str = "{\"recording\":1,\"run\":\"delivery\"}\n";

    fn read(rest: &str) -> Result<Vec<Turn<u8, f64>>, String> {
        let recording = Recording::<String>::read(&format!("{HEAD}{rest}")).map_err(|fault| fault.to_string())?;
        recording.turns.of("host").map_err(|fault| fault.to_string())
    }

    #[test]
    fn turns_are_read_by_their_lines() {
        let text = "{\"line\":\"host\",\"turn\":0,\"words\":7,\"answer\":0.1}\n\
                    {\"line\":\"camera\",\"turn\":0,\"words\":[],\"answer\":{}}\n\
                    {\"typed\":\"(go)\",\"time_us\":5}\n\
                    {\"line\":\"host\",\"turn\":1,\"words\":8,\"fault\":\"gone\"}\n";
        let gone = Err(LineFault("gone".to_string()));
        assert_eq!(read(text), Ok(vec![Turn { words: 7, answer: Ok(0.1) }, Turn { words: 8, answer: gone }]));
        let recording = Recording::<String>::read(&format!("{HEAD}{text}")).expect("it is whole");
        assert_eq!(recording.typed, [Typed { typed: "(go)".to_string(), time_us: 5 }]);
    }

    #[test]
    fn a_line_that_was_not_written_to_its_end_is_left_out() {
        let whole = "{\"line\":\"host\",\"turn\":0,\"words\":7,\"answer\":0.1}\n";
        let next = "{\"line\":\"host\",\"turn\":1,\"words\":7,\"answer\":0.1}";
        for end in 0..=next.len() {
            assert_eq!(read(&format!("{whole}{}", &next[..end])).map(|turns| turns.len()), Ok(1));
        }
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        let cases = [
            ("{\"line\":\"host\",\"turn\":1,\"words\":7,\"answer\":0.1}\n", "line 2: turn 0 of `host` is expected"),
            ("\n{\"line\":\"host\",\"turn\":0,\"words\":7}\n", "line 3: a turn has either"),
            ("{\"line\":\"host\",\"turn\":0,\"words\":\"x\",\"answer\":0.1}\n", "line 2: invalid type: string \"x\""),
            ("{\"what\":1}\n", "line 2: a turn of a `line`"),
            ("no json\n", "line 2: expected ident"),
        ];
        for (text, expected) in cases {
            let fault = read(text).expect_err(text);
            assert!(fault.starts_with(expected), "{fault}");
        }
        let head = |text: &str| Recording::<String>::read(text).expect_err(text).to_string();
        assert!(head("").starts_with("line 1: a recording of rpl is expected"));
        assert!(head("{\"trace\":1}\n").starts_with("line 1: a recording of rpl is expected"));
        assert_eq!(
            head("{\"recording\":9,\"run\":3}\n"),
            "line 1: the recording has version 9, and this rpl reads version 1"
        );
    }
}
