//! What the robot knows of the hallway it is in.

use crate::feature::{HiddenWall, Percept, Side};
use crate::features::{FeatureDetection, wall_ahead_m};
use crate::judgement::Look;
use crate::registration::{Doubt, HallwayAxis, Registration, Ring};
use rpl_robot::geometry::{Point, Pose, wrap_angle_rad};
use rpl_robot::sensors::SonarScan;
use serde::{Deserialize, Serialize};
use std::f64::consts::FRAC_PI_2;

/// What is heard while it is in doubt which way the robot looks waits for this length of the way: a crossing looks
/// like it, too.
const WAITS_M: f64 = 0.6;

/// The end of the hallway is reached this far before its wall.
const BEFORE_END_M: f64 = 0.9;

/// The axis is corrected by at most this at a time.
const GATE_RAD: f64 = 0.3;

/// What begins less than this before where counting begins may begin behind it: a percept's edges are not sharper.
const EDGE_M: f64 = 0.1;

/// Of what a robot is beside when it turns round, it sees less than half on the way back: as far behind it as this.
const BESIDE_START_M: f64 = 0.5;

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
    /// Whether the robot looks another way than it believes.
    doubt: Option<Doubt>,
    /// What was heard since that is in doubt.
    waiting: Vec<Waiting>,
    /// Metres along the axis from where the robot was when it began with this hallway.
    along_m: f64,
    /// The farthest it has been.
    farthest_m: f64,
    at_in_odom: Pose,
    /// Where it ends, once the robot stood before its end.
    end_m: Option<f64>,
    /// What was heard last.
    heard: Option<Ring>,
    /// What was seen of it before the robot turned round, each time that it has.
    earlier: Vec<Look>,
    /// Where it ends, as seen the way the robot went first, once it has turned round.
    known_end_m: Option<f64>,
    /// How the robot goes along it now.
    direction: Direction,
}

/// How a robot goes along a hallway, as seen the way it went first: where it began, and whether it goes back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Direction {
    start_m: f64,
    is_back: bool,
}

impl Direction {
    /// A place along the hallway.
    fn first_m(self, along_m: f64) -> f64 {
        if self.is_back { self.start_m - along_m } else { self.start_m + along_m }
    }

    /// A percept as seen the way the robot goes now, as it is seen the way it went first.
    fn first(self, percept: &Percept) -> Percept {
        if self.is_back { percept.turned(self.start_m) } else { percept.shifted(self.start_m) }
    }

    /// The other way.
    fn now(self, percept: &Percept) -> Percept {
        if self.is_back { percept.turned(self.start_m) } else { percept.shifted(-self.start_m) }
    }

    /// The same of what is hidden.
    fn first_hidden(self, wall: &HiddenWall) -> HiddenWall {
        if self.is_back { wall.turned(self.start_m) } else { wall.shifted(self.start_m) }
    }
}

/// What was heard at a place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Waiting {
    from_in_odom: Pose,
    ranges_m: Vec<f32>,
}

/// Whether a percept counts for who counts from a place on: the rest of what the robot began beside does not.
pub(super) fn counts(percept: &Percept, from_m: f64) -> bool {
    percept.from_m > from_m - EDGE_M && percept.middle_m() > from_m.max(BESIDE_START_M)
}

impl Hallway {
    /// Begins in a hallway whose direction is roughly known.
    pub fn start(heading_in_odom_rad: f64, at_in_odom: Pose) -> Self {
        Self::with(Registration::start(heading_in_odom_rad), at_in_odom)
    }

    fn with(registration: Registration, at_in_odom: Pose) -> Self {
        Self {
            axis: registration.axis().copied(),
            registration,
            detection: None,
            percepts: Vec::new(),
            doubt: None,
            waiting: Vec::new(),
            along_m: 0.0,
            farthest_m: 0.0,
            at_in_odom,
            end_m: None,
            heard: None,
            earlier: Vec::new(),
            known_end_m: None,
            direction: Direction::default(),
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

    /// The same hallway as one goes back along it, from here on. What was seen so far is kept for judgements.
    pub fn turned_round(&self) -> Self {
        let direction = Direction { start_m: self.direction.first_m(self.along_m), is_back: !self.direction.is_back };
        let earlier = self.earlier.iter().cloned().chain([self.look()]).collect();
        Self {
            earlier,
            known_end_m: self.first_end_m(),
            direction,
            ..Self::with(self.registration.turned_round(), self.at_in_odom)
        }
    }

    /// Whether the robot has turned round in it, to see it once more.
    pub fn is_looked_back_at(&self) -> bool {
        !self.earlier.is_empty()
    }

    /// Whether the robot goes along it the other way than it went first.
    pub fn is_gone_back(&self) -> bool {
        self.direction.is_back
    }

    /// What was seen of it since the robot turned round last, as seen the way it went first. It sees less than half of
    /// what it is beside when it turns.
    fn look(&self) -> Look {
        let begins_m = if self.is_looked_back_at() { BESIDE_START_M } else { 0.0 };
        let (one_m, other_m) = (self.direction.first_m(begins_m), self.direction.first_m(self.farthest_m));
        Look {
            turned_at_m: self.is_looked_back_at().then_some(self.direction.start_m),
            percepts: self.percepts.iter().map(|percept| self.direction.first(percept)).collect(),
            hidden: self.hidden().iter().map(|wall| self.direction.first_hidden(wall)).collect(),
            from_m: one_m.min(other_m),
            to_m: one_m.max(other_m),
        }
    }

    /// What was seen of it from a place on, once or several times, as seen the way the robot went first; and where it
    /// ends, if that is known.
    pub fn looks(&self, from_m: f64) -> (Vec<Look>, Option<f64>) {
        let mut looks: Vec<Look> = self.earlier.iter().cloned().chain([self.look()]).collect();
        for (number, look) in looks.iter_mut().enumerate() {
            // Where counting begins is the other half of what the first look began beside.
            look.from_m = look.from_m.max(if number == 0 { from_m } else { from_m + BESIDE_START_M });
            look.percepts
                .retain(|percept| counts(percept, from_m) && (number == 0 || percept.middle_m() > look.from_m));
        }
        (looks, self.first_end_m())
    }

    /// Where it ends, as seen the way the robot went first.
    fn first_end_m(&self) -> Option<f64> {
        let own_m = self.end_m.filter(|_| !self.direction.is_back).map(|end_m| self.direction.first_m(end_m));
        self.known_end_m.or(own_m)
    }

    /// Where something stood before its walls.
    pub fn hidden(&self) -> Vec<HiddenWall> {
        self.detection.as_ref().map_or_else(Vec::new, FeatureDetection::hidden)
    }

    /// A percept as seen the way the robot went first, as it is seen the way it goes now.
    pub fn as_seen_now(&self, percept: &Percept) -> Percept {
        self.direction.now(percept)
    }

    /// Takes a scan in for the direction. In a crossing the walls of the other hallway may look like a better axis:
    /// who was turned by hand is noticed by [`Hallway::is_turned`].
    pub fn register(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>) {
        self.registration.take_in(odometry_in_odom, scan);
        let Some(known) = self.axis else {
            self.axis = self.registration.axis().copied();
            return;
        };
        let heading_rad = self.registration.heading_in_odom_rad();
        let is_near = wrap_angle_rad(heading_rad - known.heading_in_odom_rad).abs() < GATE_RAD;
        match self.registration.axis() {
            Some(axis) if is_near => self.axis = Some(*axis),
            None if is_near => {}
            Some(_) | None => self.registration = Registration::start(known.heading_in_odom_rad),
        }
    }

    /// The same for a robot that fits nothing: it takes the direction that was guessed for the axis.
    pub fn keep_guess(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>) {
        self.axis = Some(self.registration.keep_guess(odometry_in_odom, scan));
    }

    /// Takes a scan in for whether the robot was turned by hand. Answers that it was, and has to register again: from
    /// where it began to be in doubt, it has gone another way than it believed.
    pub fn is_turned(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>) -> bool {
        let Some(axis) = &self.axis else { return false };
        self.doubt = Doubt::after(self.doubt.take(), self.heard.as_ref(), axis, odometry_in_odom, scan);
        self.heard = Some(Ring::of(odometry_in_odom, scan));
        let turned = self.doubt.as_ref().and_then(|doubt| Some((doubt, doubt.other_axis_in_odom_rad()?)));
        let Some((doubt, other_rad)) = turned else { return false };
        let gone = odometry_in_odom.point() - doubt.since_in_odom.point();
        let along_m = |axis_rad: f64| gone.x * libm::cos(axis_rad) + gone.y * libm::sin(axis_rad);
        self.along_m += along_m(other_rad) - along_m(axis.heading_in_odom_rad);
        self.registration = Registration::start(other_rad);
        self.axis = None;
        self.waiting.clear();
        self.doubt = None;
        true
    }

    /// Takes a scan in for what is beside the robot; nothing before the axis is known.
    pub fn detect(&mut self, odometry_in_odom: Pose, scan: SonarScan<'_>, markers_in_odom: Option<&[Point]>) {
        let Some(axis) = &self.axis else { return };
        if self.detection.is_none() {
            (self.along_m, self.farthest_m) = (0.0, 0.0);
        }
        let detection = self.detection.get_or_insert_with(|| FeatureDetection::start(axis, odometry_in_odom));
        if self
            .doubt
            .as_ref()
            .is_some_and(|doubt| doubt.has_found() && doubt.since_in_odom.distance_m(odometry_in_odom) < WAITS_M)
        {
            self.waiting.push(Waiting { from_in_odom: odometry_in_odom, ranges_m: scan.ranges_m.to_vec() });
            return;
        }
        for Waiting { from_in_odom, ranges_m } in self.waiting.drain(..) {
            let scan = SonarScan { ranges_m: &ranges_m, ..scan };
            self.percepts.extend(detection.take_in(axis, from_in_odom, scan, markers_in_odom));
        }
        self.percepts.extend(detection.take_in(axis, odometry_in_odom, scan, markers_in_odom));
    }

    /// The robot goes no farther: what it is beside ends here, or at the end of the hallway if that is so far ahead.
    pub fn finish(&mut self, to_end_m: Option<f64>, markers_in_odom: Option<&[Point]>) {
        self.waiting.clear();
        if let (Some(detection), Some(axis)) = (&mut self.detection, &self.axis) {
            let end_m = to_end_m.map(|to_end_m| detection.along_m() + to_end_m);
            self.end_m = end_m.or(self.end_m);
            self.percepts.extend(detection.finish(axis, end_m, markers_in_odom));
        }
    }

    /// The detection of what is beside it, once its axis was known.
    pub fn detection(&self) -> Option<&FeatureDetection> {
        self.detection.as_ref()
    }

    /// Whether the robot stands before the end of it, where it has driven up to.
    pub fn is_at_end(&self) -> bool {
        self.end_m.is_some_and(|end_m| end_m - self.along_m <= BEFORE_END_M + EDGE_M)
    }

    /// Whether the robot is where an end was heard on the way.
    pub fn is_before_end(&self) -> bool {
        let to_end_m = |detection: &FeatureDetection| Some(detection.hallway_end_m()? - detection.along_m());
        self.detection.as_ref().and_then(to_end_m).is_some_and(|to_end_m| to_end_m <= BEFORE_END_M)
    }

    /// How far a wall across the hallway is right ahead of a robot that stands, if there is one.
    pub fn wall_ahead_m(&self, odometry_in_odom: Pose, scan: SonarScan<'_>) -> Option<f64> {
        wall_ahead_m(wrap_angle_rad(odometry_in_odom.heading_rad - self.heading_in_odom_rad()), scan)
    }

    /// What was heard ahead was no end: somebody stood there.
    pub fn forget_end(&mut self) {
        if let Some(detection) = &mut self.detection {
            detection.forget_end();
        }
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
