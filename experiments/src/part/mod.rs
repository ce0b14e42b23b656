//! Parts of experiments: files with the records of some runs, so that the runs of one experiment can be done by many
//! machines and make one table.
//!
//! A part is lines of JSON. The first says what the runs are runs of ([`identity`]), the last what is in the part and
//! with which checksum ([`PartEnd`]); between them stands a line for each run, series by series, in the order of the runs.
//! `writer` writes one, `reader` reads one, `merging` goes through several as if they were one.

pub(crate) mod identity;
pub mod merging;
mod reader;
pub mod shard;
pub(crate) mod writer;

use identity::Input;
use serde::{Deserialize, Serialize};

/// The last line of a part.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PartEnd {
    /// What is there of each series.
    done: Vec<SeriesPart>,
    /// The files that were read for the runs.
    inputs: Vec<Input>,
    /// How many bytes stand before this line.
    bytes: u64,
    /// Their checksum (CRC-32).
    crc32: u32,
}

/// What a part has of a series.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SeriesPart {
    /// Where its first line begins, in bytes.
    at: u64,
    /// The numbers of the runs: from the first to before the second; in order, and none touches the next.
    runs: Vec<(u64, u64)>,
}
