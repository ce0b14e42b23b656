//! What an experiment is to those who run it, write its runs down and put them together again: runs that are
//! functions of a series and a seed, and tables that are folds of their records.

use super::findings::Findings;
use anyhow::Result;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// A run of a series: its number, from 0 on, and its seed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// Which one of the series.
    pub number: u64,
    /// What everything random in it is drawn from.
    pub seed: u64,
}

/// What the records of a series become, one after the other in the order of the runs.
pub trait Tally<Record>: Default {
    /// Takes in the next record.
    fn add(&mut self, record: Record);
}

impl<Record> Tally<Record> for Vec<Record> {
    fn add(&mut self, record: Record) {
        self.push(record);
    }
}

/// A kind of experiment. The table is a function of the records alone, so that they may come from this process or
/// from files that others have written.
pub trait ExperimentKind: Send + Sync + 'static {
    /// What all runs of a series share.
    type Ground: Send + Sync + 'static;
    /// What is written down of a run. It comes back from JSON as it was: no number in it is infinite.
    type Record: Serialize + DeserializeOwned + Send + 'static;
    /// What is kept of the records of a series.
    type Tally: Tally<Self::Record>;

    /// The names of the series. Most are rows of the table; rows that judge the same runs share one.
    fn series(&self) -> Vec<String>;

    /// What all runs of a series share.
    ///
    /// # Errors
    /// A file cannot be read or has faults, or the robot cannot be simulated there.
    fn ground(&self, series: usize) -> Result<Self::Ground>;

    /// One run.
    ///
    /// # Errors
    /// It cannot be driven.
    fn run(&self, series: usize, ground: &Self::Ground, run: Run) -> Result<Self::Record>;

    /// The names of the comma-separated values of a run, as the first of all records that are lines has them.
    fn head(&self, first: &Self::Record) -> String;

    /// A run as lines of comma-separated values, each with its end; nothing if it has none.
    fn lines(&self, series: &str, run: Run, record: &Self::Record) -> String;

    /// Further values of a run that is one line, by the names of their columns. The columns of the file are those of all
    /// runs.
    fn further(&self, _: &Self::Record) -> Vec<(String, String)> {
        Vec::new()
    }

    /// What is kept of no record yet.
    fn tally(&self) -> Self::Tally {
        Self::Tally::default()
    }

    /// The table, one tally for each series.
    ///
    /// # Errors
    /// Something that is drawn cannot be computed.
    fn findings(&self, tallies: Vec<Self::Tally>, wants_drawings: bool) -> Result<Findings>;

    /// How many runs are made at a time, if `asked` are asked for.
    fn jobs(&self, asked: usize) -> usize {
        asked
    }
}

/// A run, as a line of a part has it.
#[derive(Serialize, Deserialize)]
pub struct Line<Record> {
    /// Which one of the series.
    pub run: u64,
    /// Its seed.
    pub seed: u64,
    /// What is written down of it.
    pub record: Record,
}
