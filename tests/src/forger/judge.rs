//! Runs a case as a child process with little memory and time, and judges what it says.

use super::case::{Case, Content, Expected};
use std::fs;
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::os::unix::process::ExitStatusExt;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Address space of the child, in KiB: threads and their stacks take some of it.
const MEMORY_KIB: u64 = 3 << 20;

/// Nothing forged takes longer, on a machine that does other things too.
const SECONDS: u32 = 240;

/// A message that is longer is read by nobody.
const MOST_BYTES: usize = 64 << 10;

/// Exit statuses of the command that mean something.
const KNOWN: [i32; 4] = [0, 1, 2, 3];

/// What `timeout` ends with when it had to kill.
const KILLED: i32 = 137;

/// Judges what the command says to a case, in a folder that is made for it and taken away.
///
/// # Errors
/// What must not be.
pub fn judge(case: &Case, command: &Path, folder: &Path) -> Result<Output, String> {
    lay_out(case, folder).map_err(|error| format!("the case cannot be laid out: {error}"))?;
    let output = run(case, command, folder).map_err(|error| format!("the command cannot be run: {error}"));
    fs::remove_dir_all(folder).ok();
    let output = output?;
    look(case, &output)?;
    Ok(output)
}

fn lay_out(case: &Case, folder: &Path) -> io::Result<()> {
    fs::remove_dir_all(folder).ok();
    fs::create_dir_all(folder)?;
    for (name, content) in &case.files {
        let path = folder.join(name);
        match content {
            Content::Bytes(bytes) => fs::write(path, bytes)?,
            Content::Link(to) => symlink(to, path)?,
            Content::Folder => fs::create_dir(path)?,
            Content::EndlessPipe => {
                Command::new("mkfifo").arg(path).status()?;
            }
        }
    }
    Ok(())
}

fn run(case: &Case, command: &Path, folder: &Path) -> io::Result<Output> {
    let pipe = case.files.iter().find(|(_, content)| *content == Content::EndlessPipe);
    // A writer of a pipe waits until somebody reads, and ends when nobody does any more.
    let writer = pipe.map(|(name, _)| {
        Command::new("sh")
            .current_dir(folder)
            .args(["-c", &format!("exec cat /dev/zero > {name}")])
            .stderr(Stdio::null())
            .spawn()
    });
    let output = Command::new("timeout")
        .current_dir(folder)
        .args(["-s", "KILL", &SECONDS.to_string(), "sh", "-c"])
        .arg(format!("ulimit -v {MEMORY_KIB}; exec \"$@\""))
        .arg("sh")
        .arg(command)
        .args(case.arguments.iter().map(|argument| std::ffi::OsStr::from_bytes(argument.as_bytes())))
        .stdin(Stdio::null())
        .env("NO_COLOR", "1")
        .env("RUST_BACKTRACE", "0")
        .output();
    if let Some(writer) = writer {
        let mut writer = writer?;
        writer.kill()?;
        writer.wait()?;
    }
    output
}

fn look(case: &Case, output: &Output) -> Result<(), String> {
    let said = String::from_utf8_lossy(&output.stderr);
    let first = || beginning(&said);
    let Some(status) = output.status.code() else {
        return Err(format!("it ended by signal {:?}: {}", output.status.signal(), first()));
    };
    if status == KILLED {
        return Err(format!("it took more than {SECONDS} s, or was killed: {}", first()));
    }
    if !KNOWN.contains(&status) {
        return Err(format!("exit status {status}: {}", first()));
    }
    if status != 0 && said.trim().is_empty() && output.stdout.is_empty() {
        return Err(format!("exit status {status} without a word"));
    }
    look_at_words(&said)?;
    match case.expected {
        Expected::Refused if status != 2 => Err(format!("exit status {status} where 2 is expected: {}", first())),
        Expected::Refused | Expected::Anything => Ok(()),
    }
}

/// The first words of what was said.
fn beginning(said: &str) -> String {
    said.chars().take(600).collect()
}

/// Whether a user can read what the command wrote to standard error.
///
/// # Errors
/// A fault of the command's own, too many words, or such as steer a terminal.
pub fn look_at_words(said: &str) -> Result<(), String> {
    for word in ["panicked", "stack overflow", "memory allocation", "RUST_BACKTRACE"] {
        if said.contains(word) {
            return Err(format!("a user reads `{word}`: {}", beginning(said)));
        }
    }
    if said.len() > MOST_BYTES {
        return Err(format!("{} bytes of messages: {}", said.len(), beginning(said)));
    }
    if said.contains(|c: char| c.is_control() && !matches!(c, '\n' | '\t')) {
        return Err(format!("what steers a terminal is written raw: {:?}", beginning(said)));
    }
    Ok(())
}
