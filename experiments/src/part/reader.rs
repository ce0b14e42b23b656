//! Reads a part: first as a whole, to see whether all of it is there, then stretch by stretch.

use super::identity::{FORM, Identity};
use super::{PartEnd, SeriesPart};
use crate::any_kind::{AnyKind, AnyRecord};
use crate::kind::Run;
use anyhow::{Context, Result, bail};
use rpl_shell::files::inputs;
use rpl_shell::files::shown::Shown;
use serde::Deserialize;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

/// A longer line is none of a part.
const LINE_BYTES: u64 = 64 << 20;

/// A part that is there as a whole.
#[derive(Debug)]
pub struct Part {
    /// Its file.
    pub name: String,
    path: PathBuf,
    /// What its runs are runs of.
    pub identity: Identity,
    end: PartEnd,
    /// Where the next line of each series begins.
    next: Vec<u64>,
}

impl Part {
    /// Looks through a part. Its memory is that of its longest line.
    ///
    /// # Errors
    /// It cannot be read, is no part, of another form, cut, or damaged.
    pub fn open(path: &Path) -> Result<Self> {
        let name = path.shown();
        let file = inputs::open(path).map_err(|reason| anyhow::anyhow!("cannot read the part `{name}`: {reason}"))?;
        let mut lines = BufReader::new(file);
        let (mut line, mut hasher, mut bytes) = (Vec::new(), crc32fast::Hasher::new(), 0);
        let read = |lines: &mut BufReader<File>, line: &mut Vec<u8>| {
            line.clear();
            let read = lines.by_ref().take(LINE_BYTES).read_until(b'\n', line);
            read.with_context(|| format!("cannot read the part `{name}`"))
        };
        read(&mut lines, &mut line)?;
        let identity = identity_in(&line, &name)?;
        let mut last = Vec::new();
        let mut runs: u64 = 0;
        while !line.is_empty() {
            std::mem::swap(&mut last, &mut line);
            read(&mut lines, &mut line)?;
            if !line.is_empty() {
                hasher.update(&last);
                bytes += last.len() as u64;
                runs += 1;
            }
        }
        let found: Option<PartEnd> = last.ends_with(b"\n").then(|| serde_json::from_slice(&last).ok()).flatten();
        let Some(end) = found else {
            // The first line is no run, and the last one is none either if it is not whole.
            let runs = if last.ends_with(b"\n") { runs } else { runs.saturating_sub(1) };
            bail!("the part `{name}` is cut: its end is not there, after {runs} runs; do its shard again")
        };
        if (end.bytes, end.crc32) != (bytes, hasher.finalize()) {
            bail!("the part `{name}` is damaged: its checksum is not that of its lines; do its shard again");
        }
        let next = end.done.iter().map(|series| series.at).collect();
        Ok(Self { name, path: path.to_path_buf(), identity, end, next })
    }

    /// The files that were read for its runs.
    pub fn inputs(&self) -> &[super::identity::Input] {
        &self.end.inputs
    }

    /// The runs it has of a series.
    pub fn runs(&self, series: usize) -> &[(u64, u64)] {
        self.end.done.get(series).map_or(&[], |SeriesPart { runs, .. }| runs)
    }

    /// How many series it has something of.
    pub fn series(&self) -> usize {
        self.end.done.len()
    }

    /// Reads the next `count` runs of a series, each with the bytes of its line.
    ///
    /// # Errors
    /// The file is not any more what it was, or a record is none of this experiment.
    pub fn read(
        &mut self,
        series: usize,
        count: u64,
        kind: &dyn AnyKind,
        mut take: impl FnMut(Run, AnyRecord, &[u8]) -> Result<()>,
    ) -> Result<()> {
        let cannot = || format!("cannot read the part `{}`", self.name);
        let mut file = File::open(&self.path).with_context(cannot)?;
        file.seek(SeekFrom::Start(self.next[series])).with_context(cannot)?;
        let (mut lines, mut line) = (BufReader::new(file), Vec::new());
        for _ in 0..count {
            line.clear();
            let bytes = lines.by_ref().take(LINE_BYTES).read_until(b'\n', &mut line).with_context(cannot)?;
            self.next[series] += bytes as u64;
            let (run, record) = kind
                .read(&line)
                .with_context(|| format!("the part `{}` has a line that is no run of this experiment", self.name))?;
            take(run, record, &line)?;
        }
        Ok(())
    }
}

/// What every form of a part has in its first line.
#[derive(Deserialize)]
struct AnyForm {
    rpl_part: u32,
    build: String,
}

fn identity_in(line: &[u8], name: &str) -> Result<Identity> {
    let Ok(AnyForm { rpl_part, build }) = serde_json::from_slice(line) else {
        bail!("`{name}` is no part of an experiment: `rpl experiment NAME --shard I/K --out PART` writes one")
    };
    match serde_json::from_slice(line) {
        Ok(identity) if rpl_part == FORM => Ok(identity),
        Ok(_) | Err(_) => bail!(
            "the part `{name}` has the form {rpl_part}, and this rpl reads the form {FORM}; \
             it was written by rpl {build}"
        ),
    }
}
