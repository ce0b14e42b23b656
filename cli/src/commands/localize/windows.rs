//! The windows of a drive, and the trials made in them.

use super::arguments::{Arguments, WINDOWS};
use anyhow::{Result, bail};
use rpl_robot::recording::{Recording, Trial, TrialStart, Window};

/// A window, and by which share of the way to the next one it is shifted; a whole drive by none.
pub struct Placed {
    pub phase: f64,
    pub window: Window,
}

/// A trial, the window it was made in, when the last scan of it was taken, and how long it took.
pub struct Timed {
    pub phase: f64,
    pub window: Window,
    pub ends_s: Option<f64>,
    pub trial: Trial,
    pub wall_s: f64,
}

/// The windows of one phase after the other, so that whatever is done of them is spread over the drive.
pub fn windows(arguments: &Arguments, recording: &Recording) -> Result<Vec<Placed>> {
    let count = arguments.windows.map(|count| count as usize);
    match (arguments.start(), count) {
        (TrialStart::FromTruth, None) if arguments.phases > 1 => {
            bail!("with --from-truth there is one window, the whole drive; `--phases` needs `--windows`")
        }
        (TrialStart::FromTruth, None) => Ok(vec![Placed { phase: 0.0, window: Window::whole(recording) }]),
        (_, count) => {
            let count = count.unwrap_or(WINDOWS);
            let mut placed = Vec::new();
            for phase in arguments.all_phases() {
                let windows = Window::spread(recording, count, arguments.window_length, phase)?;
                placed.extend(windows.into_iter().map(|window| Placed { phase, window }));
            }
            Ok(placed)
        }
    }
}
