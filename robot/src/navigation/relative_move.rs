//! The behaviour `move-by-odometry`: a turn on the spot or a straight stretch, ahead or back, as far as it
//! was asked for by the odometry, whatever becomes of the estimate meanwhile. It keeps off what the sensors
//! see, and waits before it.

use super::input::NavigationInput;
use crate::avoidance::{DriveLimits, open_distance_m};
use crate::geometry::{Point, Pose, Velocity, wrap_angle_rad};
use crate::obstacles::ObstacleMemory;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A move that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum MoveGoal {
    /// To turn on the spot by this angle, to the left if it is positive; full turns count.
    Turn {
        /// The angle.
        turn_rad: f64,
    },
    /// To drive straight so far, backwards if it is negative.
    Straight {
        /// The way.
        ahead_m: f64,
    },
}

impl MoveGoal {
    /// Where it leads.
    pub fn from_pose(self, pose: Pose) -> Pose {
        match self {
            Self::Turn { turn_rad } => Pose::new(pose.x_m, pose.y_m, wrap_angle_rad(pose.heading_rad + turn_rad)),
            Self::Straight { ahead_m } => {
                let end = pose.transform(Point::new(ahead_m, 0.0));
                Pose::new(end.x, end.y, pose.heading_rad)
            }
        }
    }
}

/// How a step went.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MoveStatus {
    /// On the way: what to command.
    Moving(Velocity),
    /// It stands as far as was asked for.
    Done,
    /// For the time of its patience it has not got on.
    Blocked(MoveHindrance),
}

/// What keeps a robot from moving on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MoveHindrance {
    /// Something stands there.
    Obstacle,
    /// No sensor looks where it is to go.
    Unseen,
    /// Nothing that it knows of.
    Unknown,
}

/// A move under way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RelativeMove {
    goal: MoveGoal,
    from_in_odom: Pose,
    last_heading_rad: f64,
    /// How much it has turned, full turns included.
    turned_rad: f64,
    memory: ObstacleMemory,
    /// For how long it has not got on, and how far it had come then.
    waited_s: f64,
    best: f64,
    patience_s: f64,
}

/// It stands this near to where it is to stand.
const TURN_TOLERANCE_RAD: f64 = 0.05;
const STRAIGHT_TOLERANCE_M: f64 = 0.03;
/// Slower than this it stands.
const STANDING_MPS: f64 = 0.02;
const STANDING_RADPS: f64 = 0.1;
/// The least motion that counts as getting on.
const PROGRESS_RAD: f64 = 0.02;
const PROGRESS_M: f64 = 0.01;
/// Backwards it goes slowly, for few robots see well there.
const BACK_MPS: f64 = 0.2;
/// A robot that has got off its line turns back to its heading so fast for each radian.
const STRAIGHTENING_PER_S: f64 = 1.0;
/// It looks so far for what stands in its way.
const HORIZON_M: f64 = 2.0;

impl RelativeMove {
    /// How long it waits where it gets no further, unless it is told otherwise.
    pub const PATIENCE_S: f64 = 5.0;

    /// Will move from here.
    pub fn from(odometry_in_odom: Pose, goal: MoveGoal, patience_s: f64) -> Self {
        Self {
            goal,
            from_in_odom: odometry_in_odom,
            last_heading_rad: odometry_in_odom.heading_rad,
            turned_rad: 0.0,
            memory: ObstacleMemory::default(),
            waited_s: 0.0,
            best: 0.0,
            patience_s,
        }
    }

    /// What is left of it.
    pub fn left(&self, odometry_in_odom: Pose) -> MoveGoal {
        let progress = self.progress(odometry_in_odom);
        match self.goal {
            MoveGoal::Turn { turn_rad } => MoveGoal::Turn { turn_rad: turn_rad - libm::copysign(progress, turn_rad) },
            MoveGoal::Straight { ahead_m } => {
                MoveGoal::Straight { ahead_m: ahead_m - libm::copysign(progress, ahead_m) }
            }
        }
    }

    /// How far it has got, in the unit of the goal and in its direction.
    fn progress(&self, odometry_in_odom: Pose) -> f64 {
        match self.goal {
            MoveGoal::Turn { turn_rad } => self.turned_rad * libm::copysign(1.0, turn_rad),
            MoveGoal::Straight { ahead_m } => {
                odometry_in_odom.relative_to(self.from_in_odom).x_m * libm::copysign(1.0, ahead_m)
            }
        }
    }

    /// One step of `limits.step_s`.
    pub fn step(&mut self, limits: &DriveLimits, input: &NavigationInput<'_>, speed_limit_mps: f64) -> MoveStatus {
        let here = input.odometry_in_odom;
        self.memory.update(here, input.sonar, input.laser, limits.step_s, |_| None);
        self.memory.feel(here, limits.robot_radius_m, input.bumped);
        self.turned_rad += wrap_angle_rad(here.heading_rad - self.last_heading_rad);
        self.last_heading_rad = here.heading_rad;
        let (wanted, hindrance) = match self.goal {
            MoveGoal::Turn { turn_rad } => (turn(limits, turn_rad - self.turned_rad), MoveHindrance::Unknown),
            MoveGoal::Straight { ahead_m } => self.straight(limits, input, ahead_m, speed_limit_mps),
        };
        let Some(velocity) = wanted else {
            let Velocity { translation_mps, rotation_radps } = input.velocity;
            let stands = translation_mps.abs() < STANDING_MPS && rotation_radps.abs() < STANDING_RADPS;
            return if stands { MoveStatus::Done } else { MoveStatus::Moving(Velocity::default()) };
        };
        match self.waits_too_long(limits, here) {
            true => MoveStatus::Blocked(hindrance),
            false => MoveStatus::Moving(velocity),
        }
    }

    fn waits_too_long(&mut self, limits: &DriveLimits, here: Pose) -> bool {
        let progress = self.progress(here);
        let least = match self.goal {
            MoveGoal::Turn { .. } => PROGRESS_RAD,
            MoveGoal::Straight { .. } => PROGRESS_M,
        };
        if progress > self.best + least {
            (self.best, self.waited_s) = (progress, 0.0);
        } else {
            self.waited_s += limits.step_s;
        }
        self.waited_s > self.patience_s
    }

    /// The speeds on a straight line, none at its end, and what would hinder it.
    fn straight(
        &self,
        limits: &DriveLimits,
        input: &NavigationInput<'_>,
        ahead_m: f64,
        speed_limit_mps: f64,
    ) -> (Option<Velocity>, MoveHindrance) {
        let here = input.odometry_in_odom;
        let left_m = ahead_m.abs() - self.progress(here);
        if left_m < STRAIGHT_TOLERANCE_M {
            return (None, MoveHindrance::Unknown);
        }
        let (direction_rad, most_mps) = if ahead_m < 0.0 { (PI, BACK_MPS) } else { (0.0, limits.office_mps) };
        if !input.sees_towards(direction_rad) {
            return (Some(Velocity::default()), MoveHindrance::Unseen);
        }
        let mut obstacles_in_base: Vec<Point> = Vec::new();
        self.memory.append_in_base(here, &mut obstacles_in_base);
        let open_m = open_distance_m(limits, &obstacles_in_base, direction_rad, HORIZON_M);
        let speed_mps = limits.speed_to_stop_in_mps(left_m.min(open_m)).min(most_mps).min(speed_limit_mps);
        let off_rad = wrap_angle_rad(self.from_in_odom.heading_rad - here.heading_rad);
        let velocity = Velocity {
            translation_mps: libm::copysign(speed_mps, ahead_m),
            rotation_radps: if speed_mps > 0.0 { STRAIGHTENING_PER_S * off_rad } else { 0.0 },
        };
        let hindrance = if open_m < left_m { MoveHindrance::Obstacle } else { MoveHindrance::Unknown };
        (Some(velocity), hindrance)
    }
}

/// The speeds of a turn by what is left of it, none at its end.
fn turn(limits: &DriveLimits, left_rad: f64) -> Option<Velocity> {
    let rotation_radps = limits.braked_turn_radps(left_rad);
    (left_rad.abs() > TURN_TOLERANCE_RAD).then_some(Velocity { translation_mps: 0.0, rotation_radps })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How far it has turned and gone, and how it ends, without sensors.
    fn moved(goal: MoveGoal) -> (f64, f64, MoveStatus) {
        let limits = DriveLimits::default();
        let mut motion = RelativeMove::from(Pose::new(1.0, 2.0, 3.0), goal, RelativeMove::PATIENCE_S);
        let (mut here, mut velocity, mut turned_rad) = (Pose::new(1.0, 2.0, 3.0), Velocity::default(), 0.0);
        for _ in 0..1000 {
            let input = NavigationInput { odometry_in_odom: here, velocity, sonar: None, laser: None, bumped: false };
            match motion.step(&limits, &input, 0.5) {
                MoveStatus::Moving(wanted) => velocity = limits.towards(velocity, wanted),
                end => return (turned_rad, here.relative_to(Pose::new(1.0, 2.0, 3.0)).x_m, end),
            }
            let (step_m, step_rad) =
                (velocity.translation_mps * limits.step_s, velocity.rotation_radps * limits.step_s);
            turned_rad += step_rad;
            let to = here.transform(Point::new(step_m, 0.0));
            here = Pose::new(to.x, to.y, wrap_angle_rad(here.heading_rad + step_rad));
        }
        panic!("it never ends");
    }

    #[test]
    fn a_turn_is_as_far_as_it_was_asked_for_however_often_it_goes_round() {
        for turn_rad in [0.5, -1.5, PI, 2.0 * PI, -4.5 * PI, 0.0] {
            let (turned_rad, _, end) = moved(MoveGoal::Turn { turn_rad });
            assert!((turned_rad - turn_rad).abs() < 2.0 * TURN_TOLERANCE_RAD, "{turned_rad} of {turn_rad}");
            assert_eq!(end, MoveStatus::Done);
        }
    }

    #[test]
    fn who_does_not_see_where_it_is_to_go_stays() {
        let (_, went_m, end) = moved(MoveGoal::Straight { ahead_m: -0.5 });
        assert!(went_m.abs() < 1e-9, "{went_m}");
        assert_eq!(end, MoveStatus::Blocked(MoveHindrance::Unseen));
    }
}
