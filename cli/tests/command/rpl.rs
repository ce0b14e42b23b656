//! Starting `rpl` as a user does, and what is left of it at its end.

use std::io::Write;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

/// What a command has written when it has ended, and its exit status.
#[derive(Debug)]
pub struct Ended {
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub errors: String,
    /// The exit status.
    pub status: i32,
}

impl Ended {
    /// Waits for the end of a command whose streams are pipes.
    pub fn of(child: Child) -> Self {
        child.wait_with_output().expect("it ends").into()
    }
}

impl From<Output> for Ended {
    /// # Panics
    /// If it was killed, did not write text, or told of a fault of its own.
    fn from(Output { stdout, stderr, status }: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).expect("it writes text");
        let (out, errors) = (text(stdout), text(stderr));
        assert!(!errors.contains("panicked"), "{errors}");
        Self { out, errors, status: status.code().expect("it ends by itself") }
    }
}

/// `rpl` with these arguments, not started yet.
pub fn rpl(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rpl"));
    command.args(arguments);
    command
}

/// Runs it to its end.
pub fn run(arguments: &[&str]) -> Ended {
    rpl(arguments).output().expect("it starts").into()
}

/// Runs it to its end in a working folder.
pub fn run_in(folder: &Path, arguments: &[&str]) -> Ended {
    rpl(arguments).current_dir(folder).output().expect("it starts").into()
}

/// Runs a command to its end with a text on standard input.
pub fn feed(command: &mut Command, text: impl AsRef<[u8]>) -> Ended {
    let mut child = with_pipes(command);
    // What refuses its arguments does not read.
    child.stdin.take().expect("its input is a pipe").write_all(text.as_ref()).ok();
    Ended::of(child)
}

/// Starts it with pipes for all its streams.
pub fn start(arguments: &[&str]) -> Child {
    with_pipes(&mut rpl(arguments))
}

fn with_pipes(command: &mut Command) -> Child {
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("it starts")
}
