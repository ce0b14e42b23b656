//! Driving along a hallway: turning into its direction, registering it, following it, and back.

use super::hallway::Hallway;
use crate::feature::Side;
use crate::routines::{DirectionFollow, DirectionInput, Reverse, ReverseStatus};
use rpl_robot::geometry::{Point, Pose, Velocity};
use rpl_robot::navigation::{MaplessNavigation, NavigationEvent, NavigationInput, turn_to};
use rpl_robot::office::Moment;
use rpl_robot::planning::Target;
use rpl_robot::sensors::SonarScan;
use rpl_runtime::robot::Ending;
use serde::{Deserialize, Serialize};

/// The first registration takes at least so much of driving, and is given up after so much.
const REGISTER_M: f64 = 0.8;
const REGISTER_MOST_M: f64 = 4.0;

/// How fast it goes meanwhile.
const REGISTER_MPS: f64 = 0.4;

/// A robot that is so far from where it left the hallway was somewhere else meanwhile.
const ELSEWHERE_M: f64 = 0.5;

/// Held up for so long, the robot looks whether it was turned by hand.
const HELD_UP_S: f64 = 2.0;

/// A hallway ends where no lane is free for so much, for so long: a box leaves a lane beside it, and who stands in
/// the way walks on.
const END_FREE_M: f64 = 1.0;
const AT_END_S: f64 = 2.0;

/// Farther back than this it turns round and drives.
const LONGEST_REVERSE_M: f64 = 3.0;

/// How near it stands to where it is to.
const THERE_M: f64 = 0.05;

/// Where a drive along a hallway ends.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Until {
    /// When the hallway is registered and the robot is back where it began.
    Registered,
    /// At this place along it, ahead or behind.
    Along {
        /// Metres from where the robot began with this hallway.
        along_m: f64,
    },
    /// At the end of the hallway.
    End,
}

/// How a drive along a hallway ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriveEnd {
    /// Where it was to.
    There,
    /// The robot did not get on.
    Blocked,
    /// There are no walls to register by.
    NoWalls,
}

impl DriveEnd {
    /// As plans are told.
    pub fn ending(self) -> Ending {
        match self {
            Self::There => Ending::Success,
            Self::Blocked => {
                Ending::failure("blocked", "something stands in the hallway, and the robot does not get on")
            }
            Self::NoWalls => Ending::failure(
                "registration-failure",
                "there are no two walls beside the robot that run the way it drives",
            ),
        }
    }
}

/// What it is at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Stage {
    /// Going back to where it left the hallway.
    Returning(Box<MaplessNavigation>),
    /// Turning into the direction of the hallway, on the spot; then it registers, or follows.
    Turning { registers: bool },
    /// Driving on until the direction is known.
    Registering { from_m: f64, follow: DirectionFollow },
    /// Back to a place along the hallway.
    Reversing { to_m: f64, reverse: Reverse },
    /// On along the hallway.
    Following(DirectionFollow),
}

/// State of a drive along a hallway.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HallwayDrive {
    stage: Stage,
    until: Until,
    lane_m: f64,
    patience_s: f64,
    /// For how long the robot has stood before what looks like the end of the hallway.
    at_end_s: f64,
}

/// What is perceived of the hallway on the way.
#[derive(Clone, Copy, Debug)]
pub struct Perceiving<'a> {
    /// Whether its axis is fitted to its walls.
    pub registers: bool,
    /// Whether what is beside it is perceived.
    pub detects: bool,
    /// Where the camera has seen markers; none without.
    pub markers_in_odom: Option<&'a [Point]>,
}

impl Perceiving<'_> {
    /// Takes a scan in for the direction. Answers whether the robot has to register again.
    fn look_along(&self, hallway: &mut Hallway, odometry_in_odom: Pose, scan: SonarScan<'_>) -> bool {
        if self.registers {
            return hallway.register(odometry_in_odom, scan);
        }
        hallway.keep_guess(odometry_in_odom, scan);
        false
    }
}

/// What a step decides.
type Decision = (Velocity, Option<DriveEnd>);

impl HallwayDrive {
    /// The first drive in a hallway, to register it.
    pub fn register(patience_s: f64) -> Self {
        Self {
            stage: Stage::Turning { registers: true },
            until: Until::Registered,
            lane_m: 0.0,
            patience_s,
            at_end_s: 0.0,
        }
    }

    /// A drive in a hallway that was registered, from where the robot was in it last: if it was somewhere else
    /// meanwhile, it goes back there first.
    pub fn follow(hallway: &Hallway, here: Pose, until: Until, lane_m: f64, patience_s: f64) -> Self {
        let stage = if here.distance_m(hallway.at_in_odom()) > ELSEWHERE_M {
            returning(hallway, 0.0, patience_s)
        } else {
            Stage::Turning { registers: hallway.axis().is_none() }
        };
        Self { stage, until, lane_m, patience_s, at_end_s: 0.0 }
    }

    /// One step.
    pub fn step(&mut self, hallway: &mut Hallway, now: &Moment<'_>, perceiving: Perceiving<'_>) -> Decision {
        let (limits, input) = (&now.model.limits, now.input());
        let here = input.odometry_in_odom;
        hallway.follow(here);
        match &mut self.stage {
            Stage::Returning(navigation) => {
                let output = navigation.step(limits, &input, limits.speed_limit_mps(now.mode));
                match output.event {
                    Some(NavigationEvent::Arrived) => self.stage = Stage::Turning { registers: false },
                    Some(NavigationEvent::Blocked | NavigationEvent::Unreachable) => {
                        return (Velocity::default(), Some(DriveEnd::Blocked));
                    }
                    Some(NavigationEvent::TargetReached) | None => {}
                }
                (output.velocity, None)
            }
            &mut Stage::Turning { registers: then_registers } => {
                match turn_to(limits, Some(hallway.heading_in_odom_rad()), here, input.velocity) {
                    Some(velocity) => (velocity, None),
                    None => {
                        self.stage = if then_registers { self.registering(hallway) } else { self.next(hallway) };
                        (Velocity::default(), None)
                    }
                }
            }
            Stage::Registering { .. } => self.go_on_registering(hallway, now, &input, perceiving),
            Stage::Reversing { .. } => self.go_back(hallway, now, &input),
            Stage::Following(_) => self.go_on(hallway, now, &input, perceiving),
        }
    }

    fn registering(&self, hallway: &Hallway) -> Stage {
        Stage::Registering { from_m: hallway.along_m(), follow: DirectionFollow::default() }
    }

    /// Ahead or back, by where the drive is to end.
    fn next(&self, hallway: &Hallway) -> Stage {
        match self.until {
            Until::Along { along_m } if along_m < hallway.along_m() - THERE_M => {
                Stage::Reversing { to_m: along_m, reverse: Reverse::default() }
            }
            Until::Along { .. } | Until::End | Until::Registered => Stage::Following(DirectionFollow::default()),
        }
    }

    fn go_on_registering(
        &mut self,
        hallway: &mut Hallway,
        now: &Moment<'_>,
        input: &NavigationInput<'_>,
        perceiving: Perceiving<'_>,
    ) -> Decision {
        let Stage::Registering { from_m, follow } = &mut self.stage else { return (Velocity::default(), None) };
        let (from_m, limits) = (*from_m, &now.model.limits);
        if let Some(scan) = input.sonar {
            perceiving.look_along(hallway, input.odometry_in_odom, scan);
        }
        let gone_m = hallway.along_m() - from_m;
        let speed_limit_mps = limits.speed_limit_mps(now.mode).min(REGISTER_MPS);
        let output = follow.step(limits, &direction_input(hallway, input, 0.0, speed_limit_mps, f64::INFINITY));
        let is_known = hallway.axis().is_some();
        if is_known && gone_m >= REGISTER_M {
            self.stage = Stage::Reversing { to_m: from_m, reverse: Reverse::default() };
            return (Velocity::default(), None);
        }
        if gone_m > REGISTER_MOST_M || output.held_up_s > self.patience_s {
            let end = if is_known { None } else { Some(DriveEnd::NoWalls) };
            self.stage = Stage::Reversing { to_m: from_m, reverse: Reverse::default() };
            return (Velocity::default(), end);
        }
        (output.velocity, None)
    }

    fn go_back(&mut self, hallway: &mut Hallway, now: &Moment<'_>, input: &NavigationInput<'_>) -> Decision {
        let Stage::Reversing { to_m, reverse } = &mut self.stage else { return (Velocity::default(), None) };
        let back_m = hallway.along_m() - *to_m;
        let status = reverse.step(&now.model.limits, input, hallway.heading_in_odom_rad(), back_m);
        match status {
            ReverseStatus::Driving(velocity) if back_m < LONGEST_REVERSE_M => (velocity, None),
            ReverseStatus::Arrived => self.is_back(hallway),
            ReverseStatus::Driving(_) | ReverseStatus::Blocked => {
                self.stage = returning(hallway, -back_m, self.patience_s);
                (Velocity::default(), None)
            }
        }
    }

    /// Back where it was to go.
    fn is_back(&mut self, hallway: &Hallway) -> Decision {
        match self.until {
            Until::Registered | Until::Along { .. } => (Velocity::default(), Some(DriveEnd::There)),
            Until::End => {
                self.stage = self.next(hallway);
                (Velocity::default(), None)
            }
        }
    }

    fn go_on(
        &mut self,
        hallway: &mut Hallway,
        now: &Moment<'_>,
        input: &NavigationInput<'_>,
        perceiving: Perceiving<'_>,
    ) -> Decision {
        let Perceiving { registers, detects, markers_in_odom } = perceiving;
        let limits = &now.model.limits;
        if self.until == Until::Registered && hallway.axis().is_some() {
            return (Velocity::default(), Some(DriveEnd::There));
        }
        if let Some(scan) = input.sonar {
            if perceiving.look_along(hallway, input.odometry_in_odom, scan) {
                self.stage = Stage::Turning { registers: true };
                return (Velocity::default(), None);
            }
            if detects {
                hallway.detect(input.odometry_in_odom, scan, markers_in_odom);
            }
        }
        let remaining_m = match self.until {
            Until::Along { along_m } => along_m - hallway.along_m(),
            Until::End | Until::Registered => f64::INFINITY,
        };
        let Stage::Following(follow) = &mut self.stage else { return (Velocity::default(), None) };
        let speed_limit_mps = limits.speed_limit_mps(now.mode);
        let output = follow.step(limits, &direction_input(hallway, input, self.lane_m, speed_limit_mps, remaining_m));
        match input.sonar.filter(|_| registers && output.held_up_s > HELD_UP_S) {
            Some(scan) if hallway.register_held_up(input.odometry_in_odom, scan) => {
                self.stage = Stage::Turning { registers: true };
                return (Velocity::default(), None);
            }
            Some(_) => {}
            None => hallway.is_getting_on(),
        }
        let is_at_end = self.until == Until::End && hallway.is_at_end() && output.free_m < END_FREE_M;
        self.at_end_s = if is_at_end { self.at_end_s + limits.step_s } else { 0.0 };
        let end = if remaining_m < THERE_M || self.at_end_s > AT_END_S {
            Some(DriveEnd::There)
        } else {
            (output.held_up_s > self.patience_s).then_some(DriveEnd::Blocked)
        };
        if end.is_some() && detects {
            hallway.finish(markers_in_odom);
        }
        (if is_at_end { Velocity::default() } else { output.velocity }, end)
    }
}

/// To so far ahead of where the robot was in the hallway last, looking along it.
fn returning(hallway: &Hallway, ahead_m: f64, patience_s: f64) -> Stage {
    let last = Pose { heading_rad: hallway.heading_in_odom_rad(), ..hallway.at_in_odom() };
    let mut navigation = MaplessNavigation::default();
    navigation.start(vec![Target::at(last.compose(Pose::new(ahead_m, 0.0, 0.0)))], patience_s);
    Stage::Returning(Box::new(navigation))
}

fn direction_input<'a>(
    hallway: &Hallway,
    sensors: &'a NavigationInput<'a>,
    lane_m: f64,
    speed_limit_mps: f64,
    remaining_m: f64,
) -> DirectionInput<'a> {
    let wall_m = |side: Side| {
        let scan = sensors.sonar?;
        hallway.heard_m(sensors.odometry_in_odom, scan, side)
    };
    DirectionInput {
        sensors,
        heading_in_odom_rad: hallway.heading_in_odom_rad(),
        left_m: wall_m(Side::Left),
        right_m: wall_m(Side::Right),
        lane_m,
        speed_limit_mps,
        remaining_m,
    }
}
