//! From target to target: the state machine of every drive to targets, whoever knows the ways.
//!
//! Idle → driving as long as there are targets → turning to the heading of the last → idle. Who finds no
//! way may ask for a look around, after which the robot drives on. Ways, obstacles and the question
//! whether the robot gets on are a [`Guide`]'s: of a robot with a map, or of one without.

use super::input::NavigationInput;
use super::turning::turn_to;
use crate::avoidance::{CollisionAvoidance, DriveLimits, WindowInput};
use crate::geometry::{Point, Pose, Transform, Velocity, distance_m};
use crate::planning::{Target, path_length_m};
use serde::{Deserialize, Serialize};

/// A target before the last counts as reached from here.
const PASSING_M: f64 = 0.3;
/// The last target counts as reached from here.
const ARRIVAL_M: f64 = 0.15;
/// Something stands so near to the last target that the robot gets no nearer: after this time it
/// counts as reached from here.
const CROWDED_ARRIVAL_M: f64 = 0.3;
const CROWDED_S: f64 = 5.0;
/// How fast the robot turns to look around, and for how long: a full turn.
const LOOK_RADPS: f64 = 0.6;
const LOOK_AROUND_S: f64 = std::f64::consts::TAU / LOOK_RADPS;

/// Something that happened in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum NavigationEvent {
    /// A target was passed, and there are more.
    TargetReached,
    /// The robot stands at the last target and looks the way it was to.
    Arrived,
    /// No way to the target is known.
    Unreachable,
    /// There is a way, but for long the robot has not got on.
    Blocked,
}

/// What a step decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavigationOutput {
    /// To command.
    pub velocity: Velocity,
    /// Targets not yet reached.
    pub remaining_targets: usize,
    /// Whether the robot is held up and must see, even in a doorway.
    ///
    /// # Deviation
    /// The paper's robot drives through doorways with its sonars off. So does this one while it gets
    /// on; a door found closed or a wrong estimate can only be seen.
    pub needs_sonars: bool,
    /// What happened, if anything.
    pub event: Option<NavigationEvent>,
}

/// Where a guide sends the robot in this step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Guidance {
    /// To this point of the way to the first target, in the frame of the targets.
    Towards(Point),
    /// Nowhere: there may be a way in the next step.
    Wait,
    /// Around, on the spot: there may be a way that has not been seen.
    LookAround,
    /// Nowhere any more.
    NoWay,
}

/// Who knows the ways and what stands in them. Made anew for each step, of what is known then.
pub(super) trait Guide {
    /// Carried farther than this from the last target by braking and turning, the robot drives again.
    const LEFT_AGAIN_M: f64;

    /// Where the robot takes itself to be, in the frame of the targets.
    fn pose(&self) -> Pose;

    /// Where it is best taken to be as long as it drives.
    fn driving_pose(&self) -> Pose;

    /// Whether the robot, who is off a target, has it behind on its way to the next.
    fn is_passed(&self, here: Point, target: Point, next: Point) -> bool;

    /// The target after the first is now the one to drive to.
    fn take_next_target(&mut self, now_s: f64);

    /// Where to go for the first target. May give it up for the next one.
    fn direct(&mut self, driver: &mut Driver, first: Target, robot: Pose) -> Guidance;

    /// Whether the robot, who has a way to its first target, has not got on for too long.
    fn has_stalled(&mut self, driver: &mut Driver, first: Target, here: Point) -> bool;

    /// For how long it has not got on.
    fn stalled_s(&self, now_s: f64) -> f64;

    /// All that is known to stand around the robot.
    fn obstacles_in_base(&self, robot: Pose) -> Vec<Point>;

    /// How fast it may go.
    fn speed_limit_mps(&self, obstacles_in_base: &[Point]) -> f64;
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum DrivePhase {
    #[default]
    Idle,
    Driving,
    /// Turning on the spot to see more, for this time.
    LookingAround {
        left_s: f64,
    },
    /// At the last target, turning to its heading.
    Turning,
}

/// State of a drive to targets.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Driver {
    phase: DrivePhase,
    /// Not yet reached.
    pub targets: Vec<Target>,
    pub now_s: f64,
    pub avoidance: CollisionAvoidance,
}

/// What to do, and what happened.
pub(super) type DriveDecision = (Velocity, Option<NavigationEvent>);

impl Driver {
    /// Begins to drive to these targets, in order, instead of any others. The clock goes on.
    pub fn start(&mut self, targets: Vec<Target>) {
        let phase = if targets.is_empty() { DrivePhase::Idle } else { DrivePhase::Driving };
        *self = Self { phase, targets, now_s: self.now_s, avoidance: CollisionAvoidance::default() };
    }

    /// Whether there is anything to do.
    pub fn is_active(&self) -> bool {
        self.phase != DrivePhase::Idle
    }

    /// One step, after the guide has taken in what there is to see.
    pub fn step(&mut self, guide: &mut impl Guide, limits: &DriveLimits, input: &NavigationInput<'_>) -> DriveDecision {
        let passed = self.drop_reached(guide, guide.pose().point());
        match self.phase {
            DrivePhase::Idle => (Velocity::default(), None),
            DrivePhase::Turning => self.turn(limits, guide.pose(), input.velocity),
            DrivePhase::LookingAround { left_s } => self.look_around(left_s - limits.step_s),
            DrivePhase::Driving => {
                let (velocity, event) = self.drive(guide, limits, input);
                (velocity, event.or(passed.then_some(NavigationEvent::TargetReached)))
            }
        }
    }

    /// A decision as it is told.
    pub fn output(&self, (velocity, event): DriveDecision, needs_sonars: bool) -> NavigationOutput {
        NavigationOutput { velocity, remaining_targets: self.targets.len(), needs_sonars, event }
    }

    /// Drops the targets at hand or behind; true if there were any.
    fn drop_reached<G: Guide>(&mut self, guide: &mut G, here: Point) -> bool {
        let before = self.targets.len();
        while let [first, next, ..] = self.targets[..] {
            let is_near = distance_m(here, first.point_in_frame) <= PASSING_M;
            if !is_near && !guide.is_passed(here, first.point_in_frame, next.point_in_frame) {
                break;
            }
            self.targets.remove(0);
            guide.take_next_target(self.now_s);
        }
        if let [last] = self.targets[..] {
            let away_m = distance_m(here, last.point_in_frame);
            self.phase = match self.phase {
                DrivePhase::Driving if away_m <= ARRIVAL_M => DrivePhase::Turning,
                DrivePhase::Turning if away_m > G::LEFT_AGAIN_M => DrivePhase::Driving,
                phase => phase,
            };
        }
        self.targets.len() < before
    }

    fn turn(&mut self, limits: &DriveLimits, here: Pose, velocity: Velocity) -> DriveDecision {
        let wanted_rad = self.targets.last().and_then(|target| target.heading_rad);
        match turn_to(limits, wanted_rad, here, velocity) {
            Some(velocity) => (velocity, None),
            None => self.finish(NavigationEvent::Arrived),
        }
    }

    fn look_around(&mut self, left_s: f64) -> DriveDecision {
        self.phase = if left_s > 0.0 { DrivePhase::LookingAround { left_s } } else { DrivePhase::Driving };
        (Velocity { translation_mps: 0.0, rotation_radps: LOOK_RADPS }, None)
    }

    fn drive(&mut self, guide: &mut impl Guide, limits: &DriveLimits, input: &NavigationInput<'_>) -> DriveDecision {
        let robot = guide.driving_pose();
        let here = robot.point();
        let Some(first) = self.targets.first().copied() else { return self.finish(NavigationEvent::Arrived) };
        let towards = match guide.direct(self, first, robot) {
            Guidance::Towards(point) => point,
            Guidance::Wait => return (Velocity::default(), None),
            Guidance::LookAround => {
                self.phase = DrivePhase::LookingAround { left_s: LOOK_AROUND_S };
                return (Velocity::default(), None);
            }
            Guidance::NoWay => return self.finish(NavigationEvent::Unreachable),
        };
        // It may be another now.
        let Some(first) = self.targets.first().copied() else { return self.finish(NavigationEvent::Arrived) };
        if guide.has_stalled(self, first, here) {
            return self.finish(NavigationEvent::Blocked);
        }
        if self.targets.len() == 1
            && distance_m(here, first.point_in_frame) <= CROWDED_ARRIVAL_M
            && guide.stalled_s(self.now_s) > CROWDED_S
        {
            self.phase = DrivePhase::Turning;
        }
        let obstacles_in_base = guide.obstacles_in_base(robot);
        let choice = self.avoidance.step(
            limits,
            &WindowInput {
                odometry_in_odom: input.odometry_in_odom,
                velocity: input.velocity,
                obstacles_in_base: &obstacles_in_base,
                target_in_base: Transform::new(robot.inverse()).apply(towards),
                speed_limit_mps: guide.speed_limit_mps(&obstacles_in_base),
                remaining_m: self.remaining_m(here),
            },
        );
        (choice.velocity, None)
    }

    fn remaining_m(&self, here: Point) -> f64 {
        let points: Vec<Point> =
            std::iter::once(here).chain(self.targets.iter().map(|target| target.point_in_frame)).collect();
        path_length_m(&points)
    }

    fn finish(&mut self, event: NavigationEvent) -> DriveDecision {
        self.phase = DrivePhase::Idle;
        if event == NavigationEvent::Arrived {
            self.targets.clear();
        }
        (Velocity::default(), Some(event))
    }
}
