//! Writes a part. What has the name of the part is always whole: it is written beside it, and then takes its place.

use super::identity::{Identity, Input};
use super::{PartEnd, SeriesPart};
use crate::kind::Run;
use anyhow::{Context, Result, bail};
use rpl_shell::files::inputs;
use rpl_shell::files::shown::Shown;
use serde::Serialize;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// A part that is being written.
pub struct PartWriter {
    /// Where it will be.
    path: PathBuf,
    /// Where it is until then.
    beside: PathBuf,
    file: BufWriter<File>,
    done: Vec<SeriesPart>,
    bytes: u64,
    hasher: crc32fast::Hasher,
}

impl PartWriter {
    /// Begins a part.
    ///
    /// # Errors
    /// It cannot be written, or is a file that the command has read.
    pub fn begin(path: &Path, identity: &Identity) -> Result<Self> {
        let shown = path.shown();
        must_not_be_read(path)?;
        let Some(name) = path.file_name() else { bail!("`{shown}` is no name for a part; name a file") };
        let beside = path.with_file_name(format!(".{}.{}.new", name.to_string_lossy(), std::process::id()));
        let file = File::create(&beside)
            .map_err(|error| anyhow::anyhow!("cannot write the part `{shown}`: {}", inputs::reason(&error)))?;
        let mut part = Self {
            path: path.to_path_buf(),
            beside,
            file: BufWriter::new(file),
            done: Vec::new(),
            bytes: 0,
            hasher: crc32fast::Hasher::new(),
        };
        part.write(identity)?;
        Ok(part)
    }

    fn write(&mut self, value: &impl Serialize) -> Result<()> {
        self.line(serde_json::to_string(value).context("a line of a part cannot be written down")?)
    }

    fn line(&mut self, mut line: String) -> Result<()> {
        line.push('\n');
        self.bytes += line.len() as u64;
        self.hasher.update(line.as_bytes());
        self.file.write_all(line.as_bytes()).with_context(|| format!("cannot write the part `{}`", self.path.shown()))
    }

    /// The lines that follow are of the next series.
    ///
    /// # Errors
    /// What will take the name of the part has been read meanwhile.
    pub fn next_series(&mut self) -> Result<()> {
        must_not_be_read(&self.path)?;
        self.done.push(SeriesPart { at: self.bytes, runs: Vec::new() });
        Ok(())
    }

    /// Writes the line of a run of the series, which comes after those that were written.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub fn add(&mut self, run: Run, line: String) -> Result<()> {
        self.line(line)?;
        let Some(SeriesPart { runs, .. }) = self.done.last_mut() else { bail!("a run without a series was written") };
        match runs.last_mut() {
            Some((_, end)) if *end == run.number => *end += 1,
            Some(_) | None => runs.push((run.number, run.number + 1)),
        }
        Ok(())
    }

    /// Ends the part, which has its name from now on. Answers how many lines it has.
    ///
    /// # Errors
    /// The disk is full or gone.
    pub fn end(mut self, inputs: Vec<Input>) -> Result<u64> {
        let end = PartEnd {
            done: std::mem::take(&mut self.done),
            inputs,
            bytes: self.bytes,
            crc32: self.hasher.clone().finalize(),
        };
        let count = end.done.iter().flat_map(|series| &series.runs).map(|(from, to)| to - from).sum();
        self.write(&end)?;
        let cannot = || format!("cannot write the part `{}`", self.path.shown());
        self.file.flush().with_context(cannot)?;
        self.file.get_ref().sync_all().with_context(cannot)?;
        fs::rename(&self.beside, &self.path).with_context(cannot)?;
        Ok(count)
    }
}

fn must_not_be_read(path: &Path) -> Result<()> {
    if inputs::input_at(path).is_some() {
        bail!("the part cannot go into `{}`, which this command reads; name another file", path.shown());
    }
    Ok(())
}

impl Drop for PartWriter {
    fn drop(&mut self) {
        // What was not ended is nothing; what was has another name by now.
        fs::remove_file(&self.beside).ok();
    }
}
