//! Journals that somebody changed: links in their folder, other files where their trace was, bytes that are damaged.

use super::canary::{look_at_canary, put_canary};
use super::surface::{Judged, Surface};
use super::victim::Victim;
use crate::forger::mangle;
use crate::generated::Dice;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::time::Duration;

const ENDED: Duration = Duration::from_secs(30);

/// A run that is killed after its first lines.
const PLAN: &str = "(dotimes (i 200000) (print i) (wait-time 1))\n";

struct Journals {
    command: PathBuf,
    folder: PathBuf,
    /// The files of a journal whose process was killed, and its trace.
    files: Vec<(String, Vec<u8>)>,
    trace: Vec<u8>,
}

pub(super) fn start(command: &Path, folder: &Path) -> Result<Box<dyn Surface>, String> {
    let wrong = |error: std::io::Error| format!("no journal can be made: {error}");
    fs::write(folder.join("plan.rpl"), PLAN).map_err(wrong)?;
    let mut run =
        Victim::start(command, folder, &["run", "plan.rpl", "--journal", "journal", "--trace", "trace.jsonl"])?;
    run.says("30\n")?;
    // Killed where it was.
    drop(run);
    let mut files = Vec::new();
    for entry in fs::read_dir(folder.join("journal")).map_err(wrong)? {
        let entry = entry.map_err(wrong)?;
        files.push((entry.file_name().to_string_lossy().into_owned(), fs::read(entry.path()).map_err(wrong)?));
    }
    files.sort();
    let trace = fs::read(folder.join("trace.jsonl")).map_err(wrong)?;
    Ok(Box::new(Journals { command: command.to_path_buf(), folder: folder.to_path_buf(), files, trace }))
}

impl Journals {
    /// The journal and its trace as the process left them.
    fn lay_out(&self) -> std::io::Result<()> {
        let journal = self.folder.join("journal");
        fs::remove_dir_all(&journal).ok();
        fs::create_dir(&journal)?;
        for (name, bytes) in &self.files {
            fs::write(journal.join(name), bytes)?;
        }
        fs::remove_file(self.folder.join("trace.jsonl")).ok();
        fs::write(self.folder.join("trace.jsonl"), &self.trace)
    }

    fn change(&self, canary: &Path, dice: &mut Dice) -> std::io::Result<&'static str> {
        let (journal, trace) = (self.folder.join("journal"), self.folder.join("trace.jsonl"));
        let (name, bytes) = &self.files[dice.below(self.files.len())];
        match dice.below(5) {
            0 => {
                fs::remove_file(journal.join(name))?;
                symlink(canary, journal.join(name))?;
                Ok("a link in the journal")
            }
            1 => {
                fs::remove_file(&trace)?;
                symlink(canary, &trace)?;
                Ok("a link where the trace was")
            }
            2 => {
                fs::copy(canary, &trace)?;
                Ok("another file where the trace was")
            }
            3 => {
                fs::write(journal.join(name), mangle::bytes(bytes, dice))?;
                Ok("damaged bytes")
            }
            _ => {
                fs::remove_file(journal.join(name))?;
                fs::create_dir(journal.join(name))?;
                Ok("a folder in the journal")
            }
        }
    }
}

impl Surface for Journals {
    fn attack(&mut self, dice: &mut Dice) -> Judged {
        let wrong = |error: std::io::Error| format!("the journal cannot be laid out: {error}");
        let canary = self.folder.join("canary");
        put_canary(&canary)?;
        self.lay_out().map_err(wrong)?;
        let kind = self.change(&canary, dice).map_err(wrong)?;
        let arguments: &[&str] =
            if dice.once_in(3) { &["journal", "journal"] } else { &["resume", "journal", "--until", "60s"] };
        let mut victim = Victim::start(&self.command, &self.folder, arguments)?;
        let status = victim.ends_within(ENDED).map_err(|finding| format!("{kind}: {finding}"))?;
        look_at_canary(&canary).map_err(|finding| format!("{kind}, rpl {arguments:?}: {finding}"))?;
        if kind == "another file where the trace was" {
            look_at_canary(&self.folder.join("trace.jsonl")).map_err(|finding| format!("{kind}: {finding}"))?;
        }
        match status.code() {
            Some(0..=3) => Ok(kind),
            _ => Err(format!("{kind}, rpl {arguments:?}: it ended with {status}: {}", victim.errors())),
        }
    }

    fn end(&mut self) -> Result<(), String> {
        Ok(())
    }
}
