//! One trial: the filter goes through a window and is compared with the corrected poses.

use super::beams::BeamChoice;
use super::drive::Recording;
use super::window::Window;
use crate::geometry::{Pose, wrap_angle_rad};
use crate::localization::{Localization, LocalizationModel, Spread};
use std::ops::ControlFlow;

/// An estimate this near to the corrected pose is right.
pub const RIGHT_M: f64 = 0.5;

/// An estimate turned by no more than this is.
pub const RIGHT_RAD: f64 = 10.0 / 180.0 * std::f64::consts::PI;

/// A filter that is so certain is sure: what it says then should be right.
pub const SURE: f64 = 0.9;

/// The share of a window by the end of which the robot must be found.
const FOUND_WITHIN: f64 = 0.9;

/// What the filter knows at the start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrialStart {
    /// Nothing.
    Uniform,
    /// The corrected pose.
    FromTruth,
}

/// How far an estimate is from the corrected pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseError {
    /// Since the start of the window, along the corrected path.
    pub travelled_m: f64,
    /// The corrected pose.
    pub true_in_map: Pose,
    /// What the filter says.
    pub estimate_in_map: Pose,
    /// How sure of it the filter is.
    pub certainty: f64,
}

impl PoseError {
    /// Between the positions.
    pub fn position_m(&self) -> f64 {
        self.true_in_map.distance_m(self.estimate_in_map)
    }

    /// Between the headings, at least 0.
    pub fn heading_rad(&self) -> f64 {
        libm::fabs(wrap_angle_rad(self.estimate_in_map.heading_rad - self.true_in_map.heading_rad))
    }

    /// Whether the filter is certain of it, to nine tenths.
    pub fn is_sure(&self) -> bool {
        self.certainty >= SURE
    }

    /// Whether it is within 0.5 m and 10° of the corrected pose.
    pub fn is_right(&self) -> bool {
        self.position_m() <= RIGHT_M && self.heading_rad() <= RIGHT_RAD
    }
}

/// What a trial showed.
#[derive(Clone, Debug, PartialEq)]
pub struct Trial {
    /// After each scan.
    pub errors: Vec<PoseError>,
    /// After this way the estimate was right and stayed so until the end; none if it was wrong there.
    pub found_after_m: Option<f64>,
    /// Whether that was within nine tenths of the window.
    pub succeeded: bool,
}

impl Trial {
    /// The errors from the moment on from which the estimate stayed right.
    pub fn errors_once_found(&self) -> &[PoseError] {
        let found = self.errors.iter().rposition(|error| !error.is_right()).map_or(0, |last| last + 1);
        &self.errors[found..]
    }

    /// After how many scans the filter was sure, and after how many of these it was wrong.
    pub fn sure_and_wrong(&self) -> (usize, usize) {
        let sure = || self.errors.iter().filter(|error| error.is_sure());
        (sure().count(), sure().filter(|error| !error.is_right()).count())
    }
}

/// Runs the filter over a window. `after_scan` is called after each scan; there is no trial if it breaks off.
pub fn localize(
    model: &LocalizationModel,
    recording: &Recording,
    beams: &BeamChoice,
    window: &Window,
    start: TrialStart,
    mut after_scan: impl FnMut() -> ControlFlow<()>,
) -> Option<Trial> {
    let scans = &recording.scans[window.scans.clone()];
    let mut localization = match (start, scans.first()) {
        (TrialStart::FromTruth, Some(first)) => Localization::start_at(model, first.laser_in_map, Spread::default()),
        (TrialStart::Uniform, _) | (_, None) => Localization::start_uniform(model),
    };
    let mut travelled_m = 0.0;
    let mut last = scans.first().map_or(Pose::default(), |scan| scan.laser_in_map);
    let mut errors = Vec::with_capacity(scans.len());
    for scan in scans {
        travelled_m += last.distance_m(scan.laser_in_map);
        last = scan.laser_in_map;
        localization.observe(model, scan.laser_in_odom, &[Some(&beams.ranges_m(scan))]);
        let estimate = localization.estimate(model);
        errors.push(PoseError {
            travelled_m,
            true_in_map: scan.laser_in_map,
            estimate_in_map: estimate.pose_in_map,
            certainty: estimate.certainty,
        });
        if after_scan().is_break() {
            return None;
        }
    }
    let mut trial = Trial { errors, found_after_m: None, succeeded: false };
    trial.found_after_m = trial.errors_once_found().first().map(|error| error.travelled_m);
    trial.succeeded = trial.found_after_m.is_some_and(|found_m| found_m <= FOUND_WITHIN * window.length_m);
    Some(trial)
}
