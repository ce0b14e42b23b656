//! A drive: scans, and where they were taken.

use crate::geometry::Pose;

/// A way this short is a robot at rest.
const MOVED_M: f64 = 0.1;

/// What is wrong with a log, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{}{message}", self.place())]
pub struct LogError {
    /// The line, from 1; none if it is about the whole log.
    pub line: Option<usize>,
    /// What was found, and what would be right.
    pub message: String,
}

impl LogError {
    fn place(&self) -> String {
        self.line.map_or(String::new(), |line| format!("line {line}: "))
    }
}

/// At which end of a scan its first reading is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FirstReading {
    /// At the right, as CARMEN's own lasers have it.
    #[default]
    Right,
    /// At the left: a laser that turns the other way round, or is mounted upside down.
    Left,
}

/// Where the readings of a scan point: reading `i` at `first_rad + i · step_rad`, to the left of
/// straight ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScanGeometry {
    /// Readings of a scan.
    pub readings: usize,
    /// Bearing of the first one.
    pub first_rad: f64,
    /// Between two of them.
    pub step_rad: f64,
}

impl ScanGeometry {
    /// Readings over a field of view, of which the laser takes the first at one end. With an odd number both ends are
    /// read, as 181 readings over 180°; with an even one, as 180 over 180°, the last is a step short of the other end.
    pub fn symmetric(readings: usize, field_of_view_rad: f64, first: FirstReading) -> Self {
        let steps = if readings.is_multiple_of(2) { readings } else { readings - 1 };
        let step_rad = field_of_view_rad / steps.max(1) as f64;
        let first_rad = match first {
            FirstReading::Right => -field_of_view_rad / 2.0,
            FirstReading::Left => field_of_view_rad / 2.0 - (readings - 1) as f64 * step_rad,
        };
        Self { readings, first_rad, step_rad }
    }

    /// Bearing of a reading.
    pub fn bearing_rad(&self, reading: usize) -> f64 {
        self.first_rad + reading as f64 * self.step_rad
    }
}

/// One scan and where it was taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// Its line in the log, or its number among the scans, from 1.
    pub line: usize,
    /// When it was taken, by the clock of the recording, if that is known.
    pub stamp_s: Option<f64>,
    /// Readings, from right to left.
    pub ranges_m: Vec<f32>,
    /// Where the laser was: the log's corrected pose.
    pub laser_in_map: Pose,
    /// Where it was by dead reckoning.
    pub laser_in_odom: Pose,
}

/// A recorded drive.
#[derive(Clone, Debug, PartialEq)]
pub struct Recording {
    /// Where the readings point; the same for all scans.
    pub geometry: ScanGeometry,
    /// How far the laser sees, if the log says so: a reading of this is one without an echo.
    pub range_m: Option<f64>,
    /// In order of time.
    pub scans: Vec<Scan>,
}

impl Recording {
    /// A drive from scans that were read elsewhere.
    ///
    /// # Errors
    /// There are none, or no odometry or no motion in them.
    pub fn new(geometry: ScanGeometry, scans: Vec<Scan>) -> Result<Self, LogError> {
        if scans.is_empty() {
            return Err(LogError { line: None, message: "there are no scans".to_string() });
        }
        Self { geometry, range_m: None, scans }.with_odometry()
    }

    /// Length of the corrected path up to each scan.
    pub fn travelled_m(&self) -> Vec<f64> {
        let mut travelled_m = 0.0;
        let mut last = self.scans.first().map(|scan| scan.laser_in_map);
        let along = self.scans.iter().map(|scan| {
            travelled_m += last.replace(scan.laser_in_map).map_or(0.0, |last| last.distance_m(scan.laser_in_map));
            travelled_m
        });
        along.collect()
    }

    /// What is left if the robot moves, by the corrected poses and by odometry.
    pub(super) fn with_odometry(self) -> Result<Self, LogError> {
        let first = &self.scans[0];
        let moves =
            |pose: fn(&Scan) -> Pose| self.scans.iter().any(|scan| pose(scan).distance_m(pose(first)) > MOVED_M);
        let whole = |message: &str| Err(LogError { line: None, message: message.to_string() });
        match (moves(|scan| scan.laser_in_map), moves(|scan| scan.laser_in_odom)) {
            (true, true) => Ok(self),
            (true, false) => whole(
                "the log has no odometry: its poses (odom_x odom_y odom_theta of CARMEN) never change while the robot moves",
            ),
            (false, _) => whole("the robot never moves in this log: all corrected poses are the same"),
        }
    }
}
