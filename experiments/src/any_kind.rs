//! A kind of experiment whose types are hidden: how experiments are done is compiled once, and not for each kind.

use super::findings::Findings;
use super::kind::{ExperimentKind, Line, Run, Tally};
use anyhow::Result;
use std::any::Any;
use std::sync::Arc;

/// What all runs of a series share, whatever its kind.
pub type AnyGround = Arc<dyn Any + Send + Sync>;
/// What is written down of a run, whatever its kind.
pub type AnyRecord = Box<dyn Any + Send>;
/// What is kept of the records of a series, whatever its kind.
pub type AnyTally = Box<dyn Any>;

/// An [`ExperimentKind`]. Grounds, records and tallies are handed back to the kind that made them.
pub trait AnyKind: Send + Sync {
    /// See [`ExperimentKind::series`].
    fn series(&self) -> Vec<String>;

    /// See [`ExperimentKind::jobs`].
    fn jobs(&self, asked: usize) -> usize;

    /// See [`ExperimentKind::ground`].
    ///
    /// # Errors
    /// Those of the kind.
    fn ground(&self, series: usize) -> Result<AnyGround>;

    /// See [`ExperimentKind::run`].
    ///
    /// # Errors
    /// Those of the kind.
    fn run(&self, series: usize, ground: &AnyGround, run: Run) -> Result<AnyRecord>;

    /// The line of a part that has this run.
    ///
    /// # Errors
    /// The record is none that JSON can have.
    fn line(&self, run: Run, record: &AnyRecord) -> serde_json::Result<String>;

    /// The run that a line of a part has.
    ///
    /// # Errors
    /// It has no run of this kind.
    fn read(&self, line: &[u8]) -> serde_json::Result<(Run, AnyRecord)>;

    /// See [`ExperimentKind::head`].
    fn head(&self, first: &AnyRecord) -> String;

    /// See [`ExperimentKind::lines`].
    fn lines(&self, series: &str, run: Run, record: &AnyRecord) -> String;

    /// See [`ExperimentKind::further`].
    fn further(&self, record: &AnyRecord) -> Vec<(String, String)>;

    /// See [`ExperimentKind::tally`].
    fn tally(&self) -> AnyTally;

    /// Takes the next record into a tally.
    fn add(&self, tally: &mut AnyTally, record: AnyRecord);

    /// See [`ExperimentKind::findings`].
    ///
    /// # Errors
    /// Those of the kind.
    fn findings(&self, tallies: Vec<AnyTally>, wants_drawings: bool) -> Result<Findings>;
}

/// Hides the types of a kind.
pub struct Hidden<K>(pub K);

impl<K: ExperimentKind> AnyKind for Hidden<K> {
    fn series(&self) -> Vec<String> {
        self.0.series()
    }

    fn jobs(&self, asked: usize) -> usize {
        self.0.jobs(asked)
    }

    fn ground(&self, series: usize) -> Result<AnyGround> {
        Ok(Arc::new(self.0.ground(series)?))
    }

    fn run(&self, series: usize, ground: &AnyGround, run: Run) -> Result<AnyRecord> {
        Ok(Box::new(self.0.run(series, own(ground.downcast_ref()), run)?))
    }

    fn line(&self, run: Run, record: &AnyRecord) -> serde_json::Result<String> {
        let record: &K::Record = own(record.downcast_ref());
        serde_json::to_string(&Line { run: run.number, seed: run.seed, record })
    }

    fn read(&self, line: &[u8]) -> serde_json::Result<(Run, AnyRecord)> {
        let Line::<K::Record> { run: number, seed, record } = serde_json::from_slice(line)?;
        Ok((Run { number, seed }, Box::new(record)))
    }

    fn head(&self, first: &AnyRecord) -> String {
        self.0.head(own(first.downcast_ref()))
    }

    fn lines(&self, series: &str, run: Run, record: &AnyRecord) -> String {
        self.0.lines(series, run, own(record.downcast_ref()))
    }

    fn further(&self, record: &AnyRecord) -> Vec<(String, String)> {
        self.0.further(own(record.downcast_ref()))
    }

    fn tally(&self) -> AnyTally {
        Box::new(self.0.tally())
    }

    fn add(&self, tally: &mut AnyTally, record: AnyRecord) {
        own(tally.downcast_mut::<K::Tally>()).add(*own(record.downcast().ok()));
    }

    fn findings(&self, tallies: Vec<AnyTally>, wants_drawings: bool) -> Result<Findings> {
        let tallies = tallies.into_iter().map(|tally| *own(tally.downcast().ok())).collect();
        self.0.findings(tallies, wants_drawings)
    }
}

/// What was made by the kind that is asked for it.
fn own<T>(value: Option<T>) -> T {
    value.unwrap_or_else(|| unreachable!("grounds, records and tallies come back to the kind that made them"))
}
