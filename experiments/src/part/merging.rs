//! Goes through several parts as if they were one: every run once, in the order of the runs.

use super::identity::{Identity, Input};
use super::reader::Part;
use super::shard::Shard;
use crate::any_kind::{AnyKind, AnyRecord};
use crate::kind::Run;
use anyhow::{Result, bail};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Parts of one experiment.
#[derive(Debug)]
pub struct Parts {
    parts: Vec<Part>,
    /// What all their runs are runs of.
    pub identity: Identity,
}

/// A stretch of runs that a part has of a series.
#[derive(Clone, Copy)]
struct Stretch {
    from: u64,
    to: u64,
    part: usize,
}

impl Parts {
    /// Opens parts, which must be parts of one experiment and made by this build.
    ///
    /// # Errors
    /// One of them cannot be read, is cut or damaged, or does not fit the others.
    pub fn open(paths: &[PathBuf], build: &str) -> Result<Self> {
        let parts = paths.iter().map(|path| Part::open(path)).collect::<Result<Vec<Part>>>()?;
        let Some(first) = parts.first() else { bail!("there are no parts to merge; name some") };
        for other in &parts[1..] {
            if let Some(unlike) = first.identity.unlike(&first.name, &other.identity, &other.name) {
                bail!("{unlike}");
            }
        }
        if first.identity.build != build {
            bail!(
                "the parts were made by rpl {}, and this is rpl {build}; merge them with the rpl that made them",
                first.identity.build
            );
        }
        must_have_read_the_same(&parts)?;
        let shards = first.identity.shards.filter(|of| parts.iter().all(|part| part.identity.shards == Some(*of)));
        let identity = Identity { shards, ..first.identity.clone() };
        Ok(Self { parts, identity })
    }

    /// The files that were read for the runs.
    pub fn inputs(&self) -> Vec<Input> {
        let mut inputs: Vec<Input> = self.parts.iter().flat_map(|part| part.inputs().to_vec()).collect();
        inputs.sort();
        inputs.dedup();
        inputs
    }

    fn stretches(&self, series: usize) -> Vec<Stretch> {
        let of_part = |(part, one): (usize, &Part)| {
            one.runs(series).iter().map(move |&(from, to)| Stretch { from, to, part }).collect::<Vec<_>>()
        };
        let mut stretches: Vec<Stretch> = self.parts.iter().enumerate().flat_map(of_part).collect();
        stretches.sort_by_key(|stretch| (stretch.from, std::cmp::Reverse(stretch.to), stretch.part));
        stretches
    }

    /// How many different runs of a series there are.
    pub fn count(&self, series: usize) -> u64 {
        let mut end = 0;
        self.stretches(series)
            .iter()
            .map(|stretch| {
                let new = stretch.to.max(end) - stretch.from.max(end);
                end = end.max(stretch.to);
                new
            })
            .sum()
    }

    /// Hands on every run of a series once, in order. One file is open at a time.
    ///
    /// # Errors
    /// The first of `take`; or two parts have the same runs with other records.
    pub fn read(
        &mut self,
        series: usize,
        kind: &dyn AnyKind,
        mut take: impl FnMut(Run, AnyRecord) -> Result<()>,
    ) -> Result<()> {
        let mut due = 0;
        let mut before: Option<(Stretch, u32)> = None;
        for stretch in self.stretches(series) {
            let mut hasher = crc32fast::Hasher::new();
            self.parts[stretch.part].read(series, stretch.to - stretch.from, kind, |run, record, line| {
                hasher.update(line);
                if run.number < due {
                    return Ok(());
                }
                due = run.number + 1;
                take(run, record)
            })?;
            let crc32 = hasher.finalize();
            if let Some((other, other_crc32)) = before
                && (other.from, other.to) == (stretch.from, stretch.to)
                && crc32 != other_crc32
            {
                bail!(
                    "`{}` and `{}` have the same runs, {}, with different records: a run is a function of its seed, so \
                     one of them was not made by this experiment as it says, or by a machine that errs",
                    self.parts[other.part].name,
                    self.parts[stretch.part].name,
                    self.seeds(stretch.from, stretch.to)
                );
            }
            before = Some((stretch, crc32));
        }
        Ok(())
    }

    fn seeds(&self, from: u64, to: u64) -> String {
        let seed = |number: u64| self.identity.first_seed.wrapping_add(number);
        format!("seeds {} to {}", seed(from), seed(to - 1))
    }

    /// The parts that have no run that the others do not have.
    pub(crate) fn doubled(&self) -> Vec<&str> {
        let series = self.parts.iter().map(Part::series).max().unwrap_or(0);
        // A shard of fewer runs than shards may be empty.
        let is_empty = |part: &Part| (0..series).all(|series| part.runs(series).is_empty());
        let mut is_needed: Vec<bool> = self.parts.iter().map(is_empty).collect();
        for series in 0..series {
            let mut end = 0;
            for Stretch { to, part, .. } in self.stretches(series) {
                is_needed[part] |= to > end;
                end = end.max(to);
            }
        }
        let parts = self.parts.iter().zip(is_needed);
        parts.filter(|(_, is_needed)| !is_needed).map(|(part, _)| part.name.as_str()).collect()
    }

    /// The runs that no part has, of each of the series; one clause for each that lacks some.
    pub fn missing(&self, series: &[String]) -> Vec<String> {
        let lacking = series.iter().enumerate().filter_map(|(at, name)| {
            let gaps = self.gaps(at);
            let told: Vec<String> = gaps.iter().map(|&(from, to)| self.gap(from, to)).collect();
            (!told.is_empty()).then(|| format!("{name}: {}", told.join(", ")))
        });
        lacking.collect()
    }

    fn gaps(&self, series: usize) -> Vec<(u64, u64)> {
        let (mut gaps, mut due) = (Vec::new(), 0);
        let all = u64::from(self.identity.runs);
        let end = Stretch { from: all, to: all, part: 0 };
        for Stretch { from, to, .. } in self.stretches(series).into_iter().chain([end]) {
            if due < from {
                gaps.push((due, from));
            }
            due = due.max(to);
        }
        gaps
    }

    fn gap(&self, from: u64, to: u64) -> String {
        let seeds = self.seeds(from, to);
        let Some(of) = self.identity.shards.filter(|of| *of > 1) else { return seeds };
        let (first, last) = (Shard::with(from, self.identity.runs, of), Shard::with(to - 1, self.identity.runs, of));
        match last.number - first.number {
            0 => format!("{seeds} (shard {first})"),
            _ => format!("{seeds} (shards {first} to {last})"),
        }
    }
}

/// # Errors
/// Two parts have read different files of one name.
fn must_have_read_the_same(parts: &[Part]) -> Result<()> {
    let mut known: BTreeMap<&str, (&Part, Vec<u32>)> = BTreeMap::new();
    for part in parts {
        for of_name in part.inputs().chunk_by(|a, b| a.file == b.file) {
            let file = of_name[0].file.as_str();
            let crcs: Vec<u32> = of_name.iter().map(|input| input.crc32).collect();
            let (other, others) = known.entry(file).or_insert_with(|| (part, crcs.clone()));
            if *others != crcs {
                bail!(
                    "`{}` and `{}` are no parts of one experiment: the {} `{file}` was not the same; \
                     do the runs of one of them again",
                    other.name,
                    part.name,
                    part.identity.role(file)
                );
            }
        }
    }
    Ok(())
}
