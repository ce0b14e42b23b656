//! The command as a process that is attacked.

use crate::forger::judge::look_at_words;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::thread;
use std::time::{Duration, Instant};

/// Somebody with good intentions is served within this time, whatever others do.
pub const IN_TIME: Duration = Duration::from_secs(2);

/// How much more memory an attacked process may take than it had when it began to serve.
const MORE_BYTES: u64 = 96 << 20;

/// How many files and connections may be open in it at a time: few.
const MOST_DESCRIPTORS: u32 = 256;

/// A process that was started.
pub struct Victim {
    child: Child,
    errors: PathBuf,
    out: PathBuf,
    bytes_at_rest: u64,
    /// How much of what it wrote to standard error was looked at.
    looked_at: usize,
}

/// The streams of a process, if somebody speaks with it.
pub type Streams = (ChildStdin, ChildStdout);

impl Victim {
    /// Starts the command; what it writes goes to files in a folder.
    pub fn start(command: &Path, folder: &Path, arguments: &[&str]) -> Result<Self, String> {
        let out = File::create(folder.join("out")).map_err(|error| error.to_string())?;
        Ok(Self::spawn(command, folder, arguments, Stdio::null(), out.into())?.0)
    }

    /// Starts the command to speak with it.
    pub fn start_to_speak(command: &Path, folder: &Path, arguments: &[&str]) -> Result<(Self, Streams), String> {
        match Self::spawn(command, folder, arguments, Stdio::piped(), Stdio::piped())? {
            (victim, Some(streams)) => Ok((victim, streams)),
            (_, None) => Err("it has no pipes".to_string()),
        }
    }

    fn spawn(
        command: &Path,
        folder: &Path,
        arguments: &[&str],
        input: Stdio,
        out: Stdio,
    ) -> Result<(Self, Option<Streams>), String> {
        let errors = folder.join("errors");
        let file = File::create(&errors).map_err(|error| error.to_string())?;
        let mut child = Command::new("sh")
            .current_dir(folder)
            .args(["-c", &format!("ulimit -n {MOST_DESCRIPTORS}; exec \"$@\""), "sh"])
            .arg(command)
            .args(arguments)
            .stdin(input)
            .stdout(out)
            .stderr(file)
            .env("NO_COLOR", "1")
            .spawn()
            .map_err(|error| format!("the command cannot be run: {error}"))?;
        let streams = child.stdin.take().zip(child.stdout.take());
        Ok((Self { child, errors, out: folder.join("out"), bytes_at_rest: u64::MAX, looked_at: 0 }, streams))
    }

    /// What it has written to standard error.
    pub fn errors(&self) -> String {
        fs::read(&self.errors).map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).unwrap_or_default()
    }

    /// Waits until what it wrote has a line with these words, and gives what stands behind them.
    pub fn says(&mut self, words: &str) -> Result<String, String> {
        let begun = Instant::now();
        while begun.elapsed() < 10 * IN_TIME {
            let said = fs::read_to_string(&self.out).unwrap_or_default() + &self.errors();
            let whole = said.rsplit_once('\n').map_or("", |(lines, _)| lines);
            if let Some((_, rest)) = whole.split_once(words) {
                self.bytes_at_rest = self.most_bytes().unwrap_or(u64::MAX);
                return Ok(rest.lines().next().unwrap_or_default().to_string());
            }
            if let Ok(Some(status)) = self.child.try_wait() {
                return Err(format!("it ended with {status} at its start: {said}"));
            }
            thread::sleep(Duration::from_millis(5));
        }
        Err(format!("it does not say `{words}`: {}", self.errors()))
    }

    /// From now on it may take little more memory than now.
    pub fn is_at_rest(&mut self) {
        self.bytes_at_rest = self.most_bytes().unwrap_or(u64::MAX);
    }

    /// The most memory it has had.
    fn most_bytes(&self) -> Option<u64> {
        let status = fs::read_to_string(format!("/proc/{}/status", self.child.id())).ok()?;
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
        Some(line.trim().strip_suffix(" kB")?.parse::<u64>().ok()? * 1024)
    }

    /// It goes on, takes no more memory than it may, and has written nothing that must not be read.
    pub fn look(&mut self) -> Result<(), String> {
        if let Ok(Some(status)) = self.child.try_wait() {
            return Err(format!("it ended with {status}: {}", self.errors()));
        }
        let bytes = self.most_bytes().unwrap_or(0);
        if bytes > self.bytes_at_rest.saturating_add(MORE_BYTES) {
            return Err(format!("it took {} MB more than at rest", (bytes - self.bytes_at_rest) >> 20));
        }
        let errors = self.errors();
        let told = errors.get(self.looked_at..).unwrap_or_default();
        self.looked_at = errors.len();
        look_at_words(told)
    }

    /// Waits for its end.
    ///
    /// # Errors
    /// It does not end in time, or wrote what must not be read.
    pub fn ends_within(&mut self, time: Duration) -> Result<ExitStatus, String> {
        let begun = Instant::now();
        while begun.elapsed() < time {
            if let Ok(Some(status)) = self.child.try_wait() {
                look_at_words(&self.errors())?;
                return Ok(status);
            }
            thread::sleep(Duration::from_millis(2));
        }
        Err(format!("it does not end within {} s: {}", time.as_secs(), self.errors()))
    }
}

impl Drop for Victim {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
