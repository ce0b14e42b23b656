//! CARMEN logs: one message a line, fields apart by spaces, metres and radians.

use super::dead_reckoning::{DeadReckoning, Reckoned};
use super::drive::{FirstReading, LogError, Recording, ScanGeometry};
use crate::geometry::Pose;
use rpl_lang::visible::shortened;

/// Fields of a pose.
const POSE: usize = 3;

/// Messages with a scan but without the pose it was taken at.
const WITHOUT_ODOMETRY: [&str; 5] = ["RAWLASER1", "RAWLASER2", "RAWLASER3", "RAWLASER4", "LASER"];

/// Fields of `ODOM` between its pose and its time: two speeds and an acceleration.
const ODOM_RATES: usize = 3;

/// Fields of `ROBOTLASER1` between odometry and its time: two speeds, two safety distances and an axis.
const ROBOTLASER_STATES: usize = 5;

/// What a `FLASER` message does not say about its laser.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaserMount {
    /// Its readings spread over this.
    pub field_of_view_rad: f64,
    /// Where the first of them is.
    pub first: FirstReading,
    /// Where the laser is mounted.
    pub laser_in_base: Pose,
}

impl Recording {
    /// Reads the `FLASER` and `ROBOTLASER1` messages of a log; other messages are skipped. The first
    /// pose of a message is taken as the corrected pose of the laser and the second one as the
    /// robot's odometry. Where both are the same throughout, odometry is that of the `ODOM` messages,
    /// carried on to the time of each scan; scans before the first and after the last of them are left out.
    /// `FLASER` does not say where its readings point, `mount` does.
    ///
    /// # Errors
    /// A line that is truncated, a number that is none, a range that is negative or not finite,
    /// scans of different kinds, and a log without scans, without odometry or without motion.
    pub fn parse_carmen(text: &str, mount: &LaserMount) -> Result<Self, LogError> {
        let mut read: Option<(ScanGeometry, Vec<Reckoned>)> = None;
        let mut reckoning = DeadReckoning::default();
        let mut skipped: Option<(usize, &str)> = None;
        for (index, text) in text.lines().enumerate() {
            let mut fields = Fields { line: index + 1, left: text.split_ascii_whitespace(), message: "" };
            let Some(message) = fields.left.next() else { continue };
            fields.message = message;
            let geometry = match message {
                "FLASER" => {
                    let readings = fields.count("the number of readings")?;
                    ScanGeometry::symmetric(readings, mount.field_of_view_rad, mount.first)
                }
                "ROBOTLASER1" => robotlaser_geometry(&mut fields)?,
                "ODOM" => {
                    let in_odom = fields.pose("the odometry")?;
                    reckoning.add(fields.stamp_s(ODOM_RATES), in_odom);
                    continue;
                }
                _ => {
                    if WITHOUT_ODOMETRY.contains(&message) {
                        skipped.get_or_insert((index + 1, message));
                    }
                    continue;
                }
            };
            let scan = read_scan(&mut fields, geometry.readings, mount)?;
            let (earlier, scans) = read.get_or_insert_with(|| (geometry, Vec::new()));
            if *earlier != geometry {
                return Err(fields.wrong(format!(
                    "{} readings where earlier scans have {}, or another field of view; a log has one laser",
                    geometry.readings, earlier.readings
                )));
            }
            scans.push(scan);
        }
        let (geometry, scans) = read.ok_or_else(|| no_scans(skipped))?;
        let scans = reckoning.scans(scans, mount.laser_in_base)?;
        Self { geometry, range_m: None, scans }.with_odometry()
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
        number.map_err(|_| self.wrong(format!("{what} must be a number, found `{}`", shortened(field))))
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

    /// The time of the message, after a number of other fields; none if no number stands there.
    fn stamp_s(&mut self, after: usize) -> Option<f64> {
        self.left.nth(after)?.parse().ok().filter(|stamp_s: &f64| stamp_s.is_finite())
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

fn read_scan(fields: &mut Fields<'_>, readings: usize, mount: &LaserMount) -> Result<Reckoned, LogError> {
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
    let is_robotlaser = fields.message == "ROBOTLASER1";
    if is_robotlaser {
        let remissions = fields.finite("the number of remission values")?;
        for _ in 0..(remissions.clamp(0.0, 100_000.0) as usize) {
            fields.number("a remission value")?;
        }
    } else if mount.first == FirstReading::Left {
        ranges_m.reverse();
    }
    let laser_in_map = fields.pose("the corrected pose")?;
    let robot_in_odom = fields.pose("the odometry")?;
    let stamp_s = fields.stamp_s(if is_robotlaser { ROBOTLASER_STATES } else { 0 });
    Ok(Reckoned { line: fields.line, ranges_m, laser_in_map, robot_in_odom, stamp_s })
}
