//! What the robot knows of the hallway it is in.

use crate::feature::{Percept, Side};
use crate::features::FeatureDetection;
use crate::judgement::Look;
use crate::registration::{HallwayAxis, Registration};
use crate::routines::{ScanAxis, across_m};
use rpl_robot::geometry::{Point, Pose, wrap_angle_rad};
use rpl_robot::sensors::SonarScan;
use serde::{Deserialize, Serialize};
use std::f64::consts::{FRAC_PI_2, PI};

/// The robot was turned by hand when the walls run otherwise than the axis by so much, and are as far apart as
/// those of the hallway to within so much.
const TURNED_RAD: f64 = 0.45;
const AS_WIDE_M: f64 = 0.3;

/// The end of the hallway is reached so far before its wall.
const BEFORE_END_M: f64 = 0.9;

/// The axis is corrected by at most so much at a time.
const GATE_RAD: f64 = 0.3;

/// What begins so little before where counting begins may begin behind it: a percept's edges are not sharper.
pub(super) const EDGE_M: f64 = 0.1;

/// What is known of a hallway.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hallway {
    /// Fits its direction.
    registration: Registration,
    /// The direction that it was last found to have.
    axis: Option<HallwayAxis>,
    /// What is beside it; none before the first registration.
    detection: Option<FeatureDetection>,
    /// What was perceived in it, in the order of the numbers.
    pub percepts: Vec<Percept>,
    /// How the walls run around the robot.
    scan_axis: ScanAxis,
    /// Metres along the axis from where the robot was when it began with this hallway.
    along_m: f64,
    /// The farthest it has been.
    farthest_m: f64,
    at_in_odom: Pose,
    /// What was seen of it before the robot turned round, if it has.
    first_look: Option<FirstLook>,
}

/// What was seen of a hallway on the way on, by a robot that looks at it again on the way back.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct FirstLook {
    percepts: Vec<Percept>,
    /// Where the robot turned round; what was there is where it began with the way back.
    turned_at_m: f64,
    end_m: Option<f64>,
}

impl Hallway {
    /// Begins in a hallway whose direction is roughly known.
    pub fn start(heading_in_odom_rad: f64, at_in_odom: Pose) -> Self {
        Self {
            registration: Registration::start(heading_in_odom_rad),
            axis: None,
            detection: None,
            percepts: Vec::new(),
            scan_axis: ScanAxis::default(),
            along_m: 0.0,
            farthest_m: 0.0,
            at_in_odom,
            first_look: None,
        }
    }

    /// The direction the robot goes along it.
    pub fn heading_in_odom_rad(&self) -> f64 {
        self.axis.map_or_else(|| self.registration.heading_in_odom_rad(), |axis| axis.heading_in_odom_rad)
    }

    /// Where the robot is along it.
    pub fn along_m(&self) -> f64 {
        self.along_m
    }

    /// Where the robot was in it last.
    pub fn at_in_odom(&self) -> Pose {
        self.at_in_odom
    }

    /// The axis, if it is known.
    pub fn axis(&self) -> Option<&HallwayAxis> {
        self.axis.as_ref()
    }

    /// Keeps up with how far the robot has come.
    pub fn follow(&mut self, odometry_in_odom: Pose) {
        let driven = odometry_in_odom.point() - self.at_in_odom.point();
        let (sin, cos) = libm::sincos(self.heading_in_odom_rad());
        self.along_m += driven.x * cos + driven.y * sin;
        self.farthest_m = self.farthest_m.max(self.along_m);
        self.at_in_odom = odometry_in_odom;
    }

    /// The same hallway as one goes back along it, from here on. What was seen on the way on is kept for
    /// judgements.
    pub fn turned_round(&self) -> Self {
        let first_look = FirstLook {
            percepts: self.percepts.clone(),
            turned_at_m: self.along_m,
            end_m: self.detection.as_ref().and_then(FeatureDetection::hallway_end_m),
        };
        let back_rad = wrap_angle_rad(self.heading_in_odom_rad() + PI);
        Self { first_look: Some(first_look), ..Self::start(back_rad, self.at_in_odom) }
    }

    /// Whether the robot has turned round in it, to see it once more.
    pub fn is_looked_back_at(&self) -> bool {
        self.first_look.is_some()
    }

    /// What was seen of it from a place on, once or twice, as seen on the way on; and where it ends, if that is
    /// known.
    pub fn looks(&self, from_m: f64) -> (Vec<Look>, Option<f64>) {
        let begins = |percept: &&Percept| percept.from_m > from_m - EDGE_M;
        let look = |percepts: &[Percept], from_m: f64, to_m: f64| Look {
            percepts: percepts.iter().filter(begins).copied().collect(),
            from_m,
            to_m,
        };
        match &self.first_look {
            None => {
                let end_m = self.detection.as_ref().and_then(FeatureDetection::hallway_end_m);
                (vec![look(&self.percepts, from_m, self.farthest_m)], end_m)
            }
            Some(first) => {
                let at_m = first.turned_at_m;
                let back: Vec<Percept> = self.percepts.iter().map(|percept| percept.turned(at_m)).collect();
                let second = look(&back, (at_m - self.farthest_m).max(from_m), at_m);
                (vec![look(&first.percepts, from_m, at_m), second], first.end_m)
            }
        }
    }

    /// A percept as seen on the way on, as it is seen the way the robot goes now.
    pub fn as_seen_now(&self, percept: &Percept) -> Percept {
        self.first_look.as_ref().map_or(*percept, |first| percept.turned(first.turned_at_m))
    }

    /// Takes a scan in for the direction. Answers whether the axis was known and turned out to be wrong: the robot
    /// was turned by hand, and has to register again.
    ///
    /// In a crossing the walls of the other hallway may look like a better axis. They are believed where they stand
    /// to the left and right of the robot as far apart as those of its own.
    pub fn register(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>) -> bool {
        self.registration.take_in(odometry_in_odom, scan);
        let Some(known) = self.axis else {
            self.axis = self.registration.axis().copied();
            return false;
        };
        let heading_rad = self.registration.heading_in_odom_rad();
        let is_near = wrap_angle_rad(heading_rad - known.heading_in_odom_rad).abs() < GATE_RAD;
        match self.registration.axis() {
            Some(axis) if is_near => self.axis = Some(*axis),
            None if is_near => {}
            Some(_) | None => {
                if self.are_walls_beside(odometry_in_odom, scan, heading_rad) {
                    self.axis = None;
                    return true;
                }
                self.registration = Registration::start(known.heading_in_odom_rad);
            }
        }
        false
    }

    /// The same for a robot that fits nothing: it takes the direction that was guessed for the axis.
    pub fn keep_guess(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>) {
        self.axis = Some(self.registration.keep_guess(odometry_in_odom, scan));
    }

    /// Whether walls as far apart as those of the hallway are heard beside the robot, square to a direction.
    fn are_walls_beside(&self, odometry_in_odom: Pose, scan: SonarScan<'_>, heading_rad: f64) -> bool {
        let width_m = self.width_m(odometry_in_odom);
        let across_m = across_m(scan, wrap_angle_rad(heading_rad - odometry_in_odom.heading_rad));
        width_m.is_some_and(|width_m| (across_m - width_m).abs() < AS_WIDE_M)
    }

    /// From wall to wall.
    fn width_m(&self, odometry_in_odom: Pose) -> Option<f64> {
        let wall_m = |side: Side| self.wall_distance_m(odometry_in_odom, side);
        Some(wall_m(Side::Left)? + wall_m(Side::Right)?)
    }

    /// The same for a robot that does not get on: turned by more than registration looks for, it stands before a
    /// wall of its hallway, which is as wide as ever and runs another way.
    pub fn register_held_up(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>) -> bool {
        self.scan_axis.take_in(scan);
        let Some(known) = self.axis else { return false };
        let Some(in_base_rad) = self.scan_axis.axis_in_base_rad(scan) else { return false };
        let walls_rad = one_way(odometry_in_odom.heading_rad + in_base_rad, known.heading_in_odom_rad);
        let is_off = wrap_angle_rad(walls_rad - known.heading_in_odom_rad).abs() > TURNED_RAD;
        if !is_off || !self.are_walls_beside(odometry_in_odom, scan, walls_rad) {
            return false;
        }
        self.registration = Registration::start(walls_rad);
        self.axis = None;
        true
    }

    /// The robot gets on: what its walls looked like before does not count.
    pub fn is_getting_on(&mut self) {
        self.scan_axis = ScanAxis::default();
    }

    /// Takes a scan in for what is beside the robot; nothing before the axis is known.
    pub fn detect(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>, markers_in_odom: Option<&[Point]>) {
        let Some(axis) = &self.axis else { return };
        if self.detection.is_none() {
            (self.along_m, self.farthest_m) = (0.0, 0.0);
        }
        let detection = self.detection.get_or_insert_with(|| FeatureDetection::start(axis, odometry_in_odom));
        self.percepts.extend(detection.take_in(axis, odometry_in_odom, scan, markers_in_odom));
    }

    /// The robot goes no farther: what it is beside ends here.
    pub fn finish(&mut self, markers_in_odom: Option<&[Point]>) {
        if let (Some(detection), Some(axis)) = (&mut self.detection, &self.axis) {
            self.percepts.extend(detection.finish(axis, markers_in_odom));
        }
    }

    /// The detection of what is beside it, once its axis was known.
    pub fn detection(&self) -> Option<&FeatureDetection> {
        self.detection.as_ref()
    }

    /// Whether the robot stands before the end of it.
    pub fn is_at_end(&self) -> bool {
        let to_end_m = |detection: &FeatureDetection| Some(detection.hallway_end_m()? - detection.along_m());
        self.detection.as_ref().and_then(to_end_m).is_some_and(|to_end_m| to_end_m <= BEFORE_END_M)
    }

    /// What was heard on a side lately: from the middle of the robot to whatever is there.
    pub fn heard_m(&self, odometry_in_odom: Pose, scan: SonarScan<'_>, side: Side) -> Option<f64> {
        self.registration.wall_distance_m(scan, odometry_in_odom, side)
    }

    /// From a pose to the wall on a side, if it was heard.
    pub fn wall_distance_m(&self, pose_in_odom: Pose, side: Side) -> Option<f64> {
        self.axis().and_then(|axis| axis.wall_distance_m(pose_in_odom, side))
    }

    /// The middle of an opening on the line of the wall, looking in. Where the wall was not heard, it is taken to
    /// be half a usual hallway away.
    pub fn opening_in_odom(&self, percept: &Percept) -> Pose {
        const HALF_WIDTH_M: f64 = 1.1;
        let heading_rad = self.heading_in_odom_rad();
        let here = Pose { heading_rad, ..self.at_in_odom };
        let wall_m = self.wall_distance_m(self.at_in_odom, percept.side).unwrap_or(HALF_WIDTH_M);
        let ahead_m = percept.middle_m() - self.along_m;
        let inwards_rad = percept.side.sign() * FRAC_PI_2;
        here.compose(Pose::new(ahead_m, percept.side.sign() * wall_m, inwards_rad))
    }
}

/// Walls run both ways: the way that is nearer to another direction. Who stands in the way may make the robot look
/// back, and it still goes on as it went.
fn one_way(walls_rad: f64, near_rad: f64) -> f64 {
    let off_rad = wrap_angle_rad(walls_rad - near_rad);
    if off_rad.abs() > FRAC_PI_2 { wrap_angle_rad(walls_rad + PI) } else { walls_rad }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_that_looks_back_goes_on_the_way_it_went() {
        let is = |walls_rad: f64, wanted_rad: f64| {
            let off_rad = wrap_angle_rad(one_way(walls_rad, 0.2) - wanted_rad);
            assert!(off_rad.abs() < 1e-9, "{walls_rad}: {off_rad}");
        };
        is(0.2 + PI, 0.2);
        is(0.3 - PI, 0.3);
        is(-1.0, -1.0);
        is(2.0, 2.0 - PI);
    }
}
