//! The state Track: it turns the camera to what is in view, and looks for landmarks where nothing is. It is active
//! beside all others.

use rpl_robot::description::Camera;
use rpl_robot::geometry::{Point, Pose, distance_m};
use rpl_robot::sensors::{CameraImage, CameraReading};
use rpl_robot::simulator::CameraCommand;
use rpl_robot::vision::{PanControl, WallMark, wall_sightings};
use serde::{Deserialize, Serialize};

/// What landmarks are looked for with.
#[derive(Clone, Copy, Debug)]
pub struct LandmarkEye<'a> {
    /// The camera of the robot.
    pub camera: &'a Camera,
    /// What landmarks look like.
    pub marks: &'a [WallMark],
    /// Time from percept to percept.
    pub step_s: f64,
}

/// A sheet in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeenSheet {
    /// Where it was seen from the robot.
    pub at_in_base: Point,
    /// Which of the marks it looks like.
    pub mark: usize,
}

/// How long a sheet is followed after the last image of it.
const REMEMBERED_S: f64 = 1.0;

/// A sheet nearer than this to one that is followed is the same.
const SAME_M: f64 = 1.0;

/// The rate at which a search turns: slow enough for a sheet to be in several images.
const SEARCH_RADPS: f64 = 1.0;

/// A search turns back this far before the end of the pan unit's range.
const END_RAD: f64 = 4.0 / 180.0 * std::f64::consts::PI;

/// Where the camera is turned, and what it follows.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Track {
    control: PanControl,
    followed_in_odom: Option<Point>,
    unseen_s: f64,
    searches_right: bool,
    pan_radps: f64,
}

impl Track {
    /// Takes in what the camera told in a step in which the odometry was here, and answers what was found in its
    /// image, if there was one. `wanted_in_odom` is a sheet to be kept in view; without one it is the nearest. Cost:
    /// a pass over an image for each of the marks.
    pub fn take_in(
        &mut self,
        eye: &LandmarkEye<'_>,
        robot_in_odom: Pose,
        reading: &CameraReading,
        wanted_in_odom: Option<Point>,
    ) -> Vec<SeenSheet> {
        let sheets = reading.image.as_ref().map_or(Vec::new(), |image| found(eye, reading.pan_rad, image));
        self.unseen_s += eye.step_s;
        self.follow(robot_in_odom, &sheets, wanted_in_odom);
        self.turn(eye, robot_in_odom, reading.pan_rad);
        sheets
    }

    /// What the camera is to do in the next step.
    pub fn command(&self) -> CameraCommand {
        CameraCommand { pan_radps: self.pan_radps }
    }

    fn follow(&mut self, robot_in_odom: Pose, sheets: &[SeenSheet], wanted_in_odom: Option<Point>) {
        if self.unseen_s > REMEMBERED_S {
            self.followed_in_odom = None;
        }
        let in_odom = sheets.iter().map(|sheet| robot_in_odom.transform(sheet.at_in_base));
        let nearest = |to: Point| in_odom.clone().min_by(|a, b| distance_m(*a, to).total_cmp(&distance_m(*b, to)));
        let sought_in_odom = wanted_in_odom.or(self.followed_in_odom);
        let seen_in_odom = match sought_in_odom {
            Some(sought) => nearest(sought).filter(|seen| distance_m(*seen, sought) < SAME_M),
            None => nearest(robot_in_odom.point()),
        };
        if seen_in_odom.is_some() {
            self.unseen_s = 0.0;
        }
        self.followed_in_odom = seen_in_odom.or(sought_in_odom);
    }

    fn turn(&mut self, eye: &LandmarkEye<'_>, robot_in_odom: Pose, pan_rad: f64) {
        let range_rad = eye.camera.pan_range_rad;
        let bearing_rad = self.followed_in_odom.map(|followed| {
            let at_in_base = robot_in_odom.inverse().transform(followed);
            libm::atan2(at_in_base.y, at_in_base.x)
        });
        let seen_beyond_rad = range_rad + eye.camera.view.field_of_view_rad / 2.0;
        self.pan_radps = match bearing_rad.filter(|bearing_rad| bearing_rad.abs() < seen_beyond_rad) {
            Some(bearing_rad) => self.control.speed_radps(eye.camera, bearing_rad, pan_rad, eye.step_s),
            None => self.search(range_rad, pan_rad),
        };
    }

    /// To and fro, from one end of the range to the other.
    fn search(&mut self, range_rad: f64, pan_rad: f64) -> f64 {
        self.control = PanControl::default();
        let side = |right: bool| if right { -1.0 } else { 1.0 };
        if side(self.searches_right) * pan_rad >= range_rad - END_RAD {
            self.searches_right = !self.searches_right;
        }
        side(self.searches_right) * SEARCH_RADPS
    }
}

fn found(eye: &LandmarkEye<'_>, pan_rad: f64, image: &CameraImage) -> Vec<SeenSheet> {
    let pan_in_base = Pose::new(0.0, 0.0, pan_rad);
    let of_mark = |(mark, look): (usize, &WallMark)| -> Vec<SeenSheet> {
        let sightings = wall_sightings(look, &eye.camera.view, image);
        let sheet = |at_in_pan| SeenSheet { at_in_base: pan_in_base.transform(at_in_pan), mark };
        sightings.into_iter().map(sheet).collect()
    };
    eye.marks.iter().enumerate().flat_map(of_mark).collect()
}
