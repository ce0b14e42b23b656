//! CARMEN logs: one message a line, fields apart by spaces, metres and radians.

use crate::geometry::Pose;

/// Fields of a pose.
const POSE: usize = 3;

/// Messages with a scan but without the pose it was taken at.
const WITHOUT_ODOMETRY: [&str; 5] = ["RAWLASER1", "RAWLASER2", "RAWLASER3", "RAWLASER4", "LASER"];

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
    /// Readings over a field of view, from right to left. With an odd number both ends are read, as
    /// 181 readings over 180°; with an even one, as 180 over 180°, the last is a step short of it.
    pub fn symmetric(readings: usize, field_of_view_rad: f64) -> Self {
        let steps = if readings.is_multiple_of(2) { readings } else { readings - 1 };
        Self { readings, first_rad: -field_of_view_rad / 2.0, step_rad: field_of_view_rad / steps.max(1) as f64 }
    }

    /// Bearing of a reading.
    pub fn bearing_rad(&self, reading: usize) -> f64 {
        self.first_rad + reading as f64 * self.step_rad
    }
}

/// One scan and where it was taken.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// Its line in the log, from 1.
    pub line: usize,
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
    /// In order of time.
    pub scans: Vec<Scan>,
}

impl Recording {
    /// Reads the `FLASER` and `ROBOTLASER1` messages of a log; other messages are skipped. The first
    /// pose of a message is taken as the corrected pose of the laser and the second one as the
    /// robot's odometry. `FLASER` does not say where its readings point: they spread over
    /// `field_of_view_rad`. `laser_in_base` is where the laser is mounted.
    ///
    /// # Errors
    /// A line that is truncated, a number that is none, a range that is negative or not finite,
    /// scans of different kinds, and a log without scans, without odometry or without motion.
    pub fn parse_carmen(text: &str, field_of_view_rad: f64, laser_in_base: Pose) -> Result<Self, LogError> {
        let mut recording: Option<Recording> = None;
        let mut skipped: Option<(usize, &str)> = None;
        for (index, text) in text.lines().enumerate() {
            let mut fields = Fields { line: index + 1, left: text.split_ascii_whitespace(), message: "" };
            let Some(message) = fields.left.next() else { continue };
            fields.message = message;
            let geometry = match message {
                "FLASER" => ScanGeometry::symmetric(fields.count("the number of readings")?, field_of_view_rad),
                "ROBOTLASER1" => robotlaser_geometry(&mut fields)?,
                _ => {
                    if WITHOUT_ODOMETRY.contains(&message) {
                        skipped.get_or_insert((index + 1, message));
                    }
                    continue;
                }
            };
            let scan = read_scan(&mut fields, geometry.readings, laser_in_base)?;
            let recording = recording.get_or_insert_with(|| Recording { geometry, scans: Vec::new() });
            if recording.geometry != geometry {
                return Err(fields.wrong(format!(
                    "{} readings where earlier scans have {}, or another field of view; a log has one laser",
                    geometry.readings, recording.geometry.readings
                )));
            }
            recording.scans.push(scan);
        }
        recording.ok_or_else(|| no_scans(skipped))?.with_odometry()
    }

    /// A drive from scans that were read elsewhere.
    ///
    /// # Errors
    /// There are none, or no odometry or no motion in them.
    pub fn new(geometry: ScanGeometry, scans: Vec<Scan>) -> Result<Self, LogError> {
        if scans.is_empty() {
            return Err(LogError { line: None, message: "there are no scans".to_string() });
        }
        Self { geometry, scans }.with_odometry()
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

    fn with_odometry(self) -> Result<Self, LogError> {
        let first = &self.scans[0];
        let moves =
            |pose: fn(&Scan) -> Pose| self.scans.iter().any(|scan| pose(scan).distance_m(pose(first)) > MOVED_M);
        let whole = |message: &str| Err(LogError { line: None, message: message.to_string() });
        match (moves(|scan| scan.laser_in_map), moves(|scan| scan.laser_in_odom)) {
            (true, true) => Ok(self),
            (true, false) => whole(
                "the log has no odometry: its second poses (odom_x odom_y odom_theta) never change while the robot moves",
            ),
            (false, _) => whole("the robot never moves in this log: all corrected poses (x y theta) are the same"),
        }
    }
}

fn no_scans(skipped: Option<(usize, &str)>) -> LogError {
    match skipped {
        Some((line, message)) => LogError {
            line: Some(line),
            message: format!(
                "the log has no odometry: a {message} message does not say where its scan was taken; \
                 FLASER or ROBOTLASER1 messages are needed"
            ),
        },
        None => LogError {
            line: None,
            message: "no laser scan in it; a CARMEN log has lines that begin with FLASER or ROBOTLASER1".to_string(),
        },
    }
}

/// The fields of a line that are not read yet.
struct Fields<'t> {
    line: usize,
    left: std::str::SplitAsciiWhitespace<'t>,
    message: &'t str,
}

impl Fields<'_> {
    fn wrong(&self, message: String) -> LogError {
        LogError { line: Some(self.line), message }
    }

    fn number(&mut self, what: &str) -> Result<f64, LogError> {
        let Some(field) = self.left.next() else {
            return Err(self.wrong(format!("the {} line ends before {what}; is it truncated?", self.message)));
        };
        let number: Result<f64, _> = field.parse();
        number.map_err(|_| self.wrong(format!("{what} must be a number, found `{field}`")))
    }

    fn finite(&mut self, what: &str) -> Result<f64, LogError> {
        let number = self.number(what)?;
        if number.is_finite() { Ok(number) } else { Err(self.wrong(format!("{what} must be finite, found {number}"))) }
    }

    /// A count of something there is.
    fn count(&mut self, what: &str) -> Result<usize, LogError> {
        let number = self.finite(what)?;
        if (1.0..=100_000.0).contains(&number) && number == libm::floor(number) {
            return Ok(number as usize);
        }
        Err(self.wrong(format!("{what} must be a whole number from 1 to 100000, found {number}")))
    }

    fn pose(&mut self, what: &str) -> Result<Pose, LogError> {
        let mut values = [0.0; POSE];
        for (value, axis) in values.iter_mut().zip(["x", "y", "theta"]) {
            *value = self.finite(&format!("{axis} of {what}"))?;
        }
        Ok(Pose::new(values[0], values[1], values[2]))
    }
}

/// The fields of `ROBOTLASER1` before the readings.
fn robotlaser_geometry(fields: &mut Fields<'_>) -> Result<ScanGeometry, LogError> {
    fields.number("the laser's type")?;
    let first_rad = fields.finite("the start angle")?;
    let field_of_view_rad = fields.finite("the field of view")?;
    let step_rad = fields.finite("the angular resolution")?;
    for what in ["the maximal range", "the accuracy", "the remission mode"] {
        fields.number(what)?;
    }
    let readings = fields.count("the number of readings")?;
    if step_rad <= 0.0 || field_of_view_rad <= 0.0 {
        let message =
            format!("angular resolution and field of view must be above 0, found {step_rad} and {field_of_view_rad}");
        return Err(fields.wrong(message));
    }
    Ok(ScanGeometry { readings, first_rad, step_rad })
}

fn read_scan(fields: &mut Fields<'_>, readings: usize, laser_in_base: Pose) -> Result<Scan, LogError> {
    let mut ranges_m = Vec::with_capacity(readings);
    for reading in 1..=readings {
        let range_m = fields.number(&format!("reading {reading} of {readings}"))?;
        if !range_m.is_finite() || range_m < 0.0 {
            return Err(fields.wrong(format!(
                "reading {reading} of {readings} is {range_m}; a range is at least 0 m, and one without echo is the laser's maximal range"
            )));
        }
        ranges_m.push(range_m as f32);
    }
    if fields.message == "ROBOTLASER1" {
        let remissions = fields.finite("the number of remission values")?;
        for _ in 0..(remissions.clamp(0.0, 100_000.0) as usize) {
            fields.number("a remission value")?;
        }
    }
    let laser_in_map = fields.pose("the corrected pose")?;
    let robot_in_odom = fields.pose("the odometry")?;
    Ok(Scan { line: fields.line, ranges_m, laser_in_map, laser_in_odom: robot_in_odom.compose(laser_in_base) })
}
