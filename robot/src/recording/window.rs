//! Trials cut out of a recording.

use super::drive::Recording;
use std::ops::Range;

/// Why there are no windows.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("a window of {length_m} m does not fit into a path of {path_m:.1} m")]
pub struct WindowError {
    /// Of a window.
    pub length_m: f64,
    /// Of the whole path.
    pub path_m: f64,
}

/// A part of a recording, of a given length along the corrected path.
#[derive(Clone, Debug, PartialEq)]
pub struct Window {
    /// Its scans.
    pub scans: Range<usize>,
    /// Where it begins, along the path of the recording.
    pub start_m: f64,
    /// How long it is; the last scan is the first one at this length or beyond.
    pub length_m: f64,
}

impl Window {
    /// `count` windows, their starts spread evenly over the recording: window `i` begins at the share
    /// `(i + phase) / count` of the starts there are. Other phases are other starts.
    ///
    /// # Errors
    /// The recording is shorter than a window, or the length is not positive.
    pub fn spread(recording: &Recording, count: usize, length_m: f64, phase: f64) -> Result<Vec<Self>, WindowError> {
        let travelled_m = recording.travelled_m();
        let path_m = travelled_m.last().copied().unwrap_or(0.0);
        if !(length_m > 0.0 && length_m <= path_m) {
            return Err(WindowError { length_m, path_m });
        }
        let window = |index: usize| {
            let wanted_m = (index as f64 + phase) / count as f64 * (path_m - length_m);
            let first = travelled_m.partition_point(|&m| m < wanted_m);
            let end = travelled_m.partition_point(|&m| m < travelled_m[first] + length_m) + 1;
            Window { scans: first..end.min(travelled_m.len()), start_m: travelled_m[first], length_m }
        };
        Ok((0..count).map(window).collect())
    }

    /// The whole recording.
    pub fn whole(recording: &Recording) -> Self {
        let length_m = recording.travelled_m().last().copied().unwrap_or(0.0);
        Self { scans: 0..recording.scans.len(), start_m: 0.0, length_m }
    }
}
