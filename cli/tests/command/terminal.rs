//! A program at a terminal: keys are typed, and the screen is looked at.

use pty_process::blocking::{Command, Pty};
use std::io::{Read, Write};
use std::num::NonZeroU16;
use std::process::Child;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// Nothing takes this long, however busy the machine is.
const DEADLINE: Duration = Duration::from_secs(400);

/// Nothing is quiet for this long.
const SILENCE: Duration = Duration::from_secs(60);

/// Keys that have no character of their own.
pub const ENTER: &str = "\r";
/// Completes.
pub const TAB: &str = "\t";
/// The line before.
pub const UP: &str = "\x1b[A";
/// Takes back a character.
pub const BACKSPACE: &str = "\x7f";
/// To the beginning of the line.
pub const HOME: &str = "\x01";
/// Ctrl-C.
pub const INTERRUPT: &str = "\x03";
/// Ctrl-D.
pub const END_OF_INPUT: &str = "\x04";

/// Lines that have left the screen and are kept.
const KEPT_LINES: usize = 1000;

/// A program, and the screen it draws on.
pub struct Terminal {
    /// The program.
    pub child: Child,
    /// Where keys go in.
    pub keyboard: Arc<Pty>,
    output: Receiver<Vec<u8>>,
    /// What it shows.
    pub screen: vt100::Parser,
}

impl Terminal {
    /// Starts a program at a terminal of a size.
    pub fn start(program: Command, rows: u16, columns: u16) -> Self {
        let (pty, child_end) = pty_process::blocking::open().expect("there are pseudo-terminals");
        pty.resize(pty_process::Size::new(rows, columns)).expect("it has a size");
        let child = program.spawn(child_end).expect("it starts");
        let keyboard = Arc::new(pty);
        let (sender, output) = channel();
        let reader = keyboard.clone();
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = reader.as_ref().read(&mut bytes) {
                if sender.send(bytes[..count].to_vec()).is_err() {
                    return;
                }
            }
        });
        Self { child, keyboard, output, screen: screen(rows, columns, KEPT_LINES) }
    }

    /// Types keys.
    pub fn keys(&self, keys: &str) {
        self.keyboard.as_ref().write_all(keys.as_bytes()).expect("it takes keys");
    }

    /// All that is shown.
    pub fn contents(&self) -> String {
        self.screen.screen().contents()
    }

    /// The row of the cursor up to the cursor.
    pub fn line(&self) -> String {
        let screen = self.screen.screen();
        let (row, column) = screen.cursor_position();
        screen.contents_between(row, 0, row, column)
    }

    /// Waits until the screen is as it should be.
    pub fn until(&mut self, what: &str, is_so: impl Fn(&Self) -> bool) {
        let deadline = Instant::now() + DEADLINE;
        while !is_so(self) {
            let left = deadline.saturating_duration_since(Instant::now());
            match self.output.recv_timeout(left.min(SILENCE)) {
                Ok(bytes) => self.screen.process(&bytes),
                Err(_) => panic!("{what} does not come:\n{}", self.contents()),
            }
        }
    }

    /// Waits until a text is shown.
    pub fn shows(&mut self, text: &str) {
        self.until(text, |terminal| terminal.contents().contains(text));
    }

    /// Waits until the cursor stands behind this text, at the beginning of its row.
    pub fn stands_behind(&mut self, line: &str) {
        self.until(line, |terminal| terminal.line() == line);
    }

    /// Waits until the cursor stands behind this text, whatever stands before it.
    pub fn stands_behind_an(&mut self, end: &str) {
        self.until(end, |terminal| terminal.line().ends_with(end));
    }

    /// Types a line at a prompt that is there, and waits for what it shows and for the next prompt.
    pub fn enter(&mut self, line: &str, shown: &str, prompt: &str) {
        self.keys(line);
        self.keys(ENTER);
        self.shows(shown);
        self.stands_behind(prompt);
    }

    /// Types the end of the input, and gives the exit status.
    pub fn end(mut self) -> i32 {
        self.keys(END_OF_INPUT);
        self.child.wait().expect("it ends").code().expect("it ends by itself")
    }
}

impl Drop for Terminal {
    fn drop(&mut self) {
        // After a failed test it still runs; else there is nothing to kill.
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

/// An empty screen of a size.
pub fn screen(rows: u16, columns: u16, kept_lines: usize) -> vt100::Parser {
    let size = |number| NonZeroU16::new(number).expect("a screen has rows and columns");
    vt100::Parser::new(size(rows), size(columns), kept_lines)
}
