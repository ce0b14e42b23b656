//! The checkpoints of a journal: the newest two, and which of them a run can go on from.

use super::driver_state::DriverState;
use super::end::JournalEnd;
use super::head::KeptRun;
use super::ledgers::Ledgers;
use anyhow::{Context, Result, ensure};
use rpl_link::journal::{checkpoint, own_file};
use rpl_shell::files::shown::Shown;
use std::fs;
use std::io;
use std::path::Path;

/// How many there are at most, that which is being written included.
const KEPT: usize = 2;

/// A place to go on from.
pub struct Resumption<S> {
    /// The run, and where its driver stood; none at its start.
    pub reached: Option<(S, DriverState)>,
    /// The number of the checkpoint; none at the start.
    pub from: Option<u64>,
    /// The number of the next checkpoint.
    pub number: u64,
    /// The files that the run goes on writing.
    pub ledgers: Ledgers,
}

/// The name of a checkpoint.
pub fn name(number: u64) -> String {
    format!("checkpoint-{number:06}")
}

/// The numbers of the checkpoints in a journal, the newest first.
///
/// # Errors
/// The folder cannot be read.
pub fn numbers(journal: &Path) -> io::Result<Vec<u64>> {
    let mut numbers = Vec::new();
    for entry in fs::read_dir(journal)? {
        let file = entry?.file_name();
        let number = file.to_str().and_then(|file| file.strip_prefix("checkpoint-")?.parse().ok());
        numbers.extend(number.filter(|&number| file == *name(number)));
    }
    numbers.sort_unstable_by(|a, b| b.cmp(a));
    Ok(numbers)
}

/// The times of the checkpoints of a run with this checksum, the newest first, and how long they are; without those
/// that are damaged.
///
/// # Errors
/// The folder cannot be read.
pub fn times(journal: &Path, run: u32) -> io::Result<Vec<(u64, u64)>> {
    let mut times = Vec::new();
    for number in numbers(journal)? {
        let bytes = own_file::read(&journal.join(name(number)))?;
        let state = checkpoint::read::<DriverState>(&bytes).ok().map(|(state, _)| state);
        times.extend(state.filter(|state| state.run == run).map(|state| (state.time_us, bytes.len() as u64)));
    }
    Ok(times)
}

/// The last time that a journal knows its run to have come to.
///
/// # Errors
/// It cannot be read.
pub fn reached_us(journal: &Path, kept: &KeptRun) -> Result<u64> {
    let end = JournalEnd::read(journal)?.map(|end| end.time_us);
    let checkpoints =
        times(journal, kept.checksum).with_context(|| format!("cannot read the journal `{}`", journal.shown()))?;
    Ok(checkpoints.into_iter().map(|(time_us, _)| time_us).chain(end).max().unwrap_or(0))
}

/// Makes room for another checkpoint. The newest stays until that is there.
///
/// # Errors
/// The folder cannot be written.
pub fn drop_old(journal: &Path) -> io::Result<()> {
    numbers(journal)?.into_iter().skip(KEPT - 1).try_for_each(|number| fs::remove_file(journal.join(name(number))))
}

/// The newest checkpoint of a run with this checksum that can be loaded, and the run's start if there is none;
/// `told` is told what is wrong with newer ones.
///
/// # Errors
/// The journal cannot be read or written.
pub fn newest<S>(
    journal: &Path,
    run: u32,
    trace: Option<&Path>,
    mut load: impl FnMut(&[u8]) -> Result<S>,
    told: &mut dyn FnMut(&str),
) -> Result<Resumption<S>> {
    let numbers = numbers(journal).with_context(|| format!("cannot read the journal `{}`", journal.shown()))?;
    let number = numbers.first().map_or(0, |newest| newest + 1);
    for &at in &numbers {
        let mut opened = || {
            let bytes = own_file::read(&journal.join(name(at)))?;
            let (state, saved) = checkpoint::read::<DriverState>(&bytes)?;
            ensure!(state.run == run, "it belongs to another run");
            let ledgers = Ledgers::go_on(journal, trace, Some(&state))?;
            Ok((load(saved)?, state, ledgers))
        };
        match opened() {
            Ok((run, state, ledgers)) => {
                return Ok(Resumption { reached: Some((run, state)), from: Some(at), number, ledgers });
            }
            Err(why) => told(&format!("`{}` cannot be used: {why:#}", name(at))),
        }
    }
    let ledgers = Ledgers::go_on(journal, trace, None)
        .with_context(|| format!("the journal `{}` cannot be gone on with", journal.shown()))?;
    Ok(Resumption { reached: None, from: None, number, ledgers })
}
