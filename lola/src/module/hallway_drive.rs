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

/// The first registration takes at least the first distance of driving, and is given up after the second.
const REGISTER_M: f64 = 0.8;
const REGISTER_MOST_M: f64 = 4.0;

/// How fast it goes meanwhile.
const REGISTER_MPS: f64 = 0.4;

/// A robot that is farther than this from where it left the hallway was somewhere else meanwhile.
const ELSEWHERE_M: f64 = 0.5;

/// Held up for longer than this where it registers again, the robot goes on by what single scans have told of the
/// direction.
const HELD_UP_S: f64 = 3.0;

/// A hallway ends where no lane is free for this distance, for this time: a box leaves a lane beside it, and a person
/// in the way walks on.
const END_FREE_M: f64 = 1.0;
const AT_END_S: f64 = 2.0;

/// Held up for longer than this, it looks whether that is the end.
const MAY_END_S: f64 = 2.0;

/// And shows a wall for this share of that time.
const SHOWN_SHARE: f64 = 0.6;

/// Farther back than this it turns round and drives.
const LONGEST_REVERSE_M: f64 = 3.0;

/// Who was called away comes back by a way that is longer than the straight one by no more than this.
const MOST_DETOUR_M: f64 = 15.0;

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
            Self::There => Ending::DONE,
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
    /// The look at what may be the end of the hallway.
    look_at_end: LookAtEnd,
}

/// A robot stands before what may be the end of the hallway.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct LookAtEnd {
    /// For how long.
    stood_s: f64,
    /// For how long of that a wall showed, and how far ahead it was the last time.
    shown_s: f64,
    to_end_m: Option<f64>,
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
    /// Takes a scan in for the direction.
    fn look_along(&self, hallway: &mut Hallway, odometry_in_odom: Pose, scan: SonarScan<'_>) {
        if self.registers {
            hallway.register(odometry_in_odom, scan);
        } else {
            hallway.keep_guess(odometry_in_odom, scan);
        }
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
            look_at_end: LookAtEnd::default(),
        }
    }

    /// A drive in a hallway that was registered, from where the robot was in it last: if it was somewhere else
    /// meanwhile, it goes back there first.
    pub fn follow(hallway: &Hallway, here: Pose, until: Until, lane_m: f64, patience_s: f64) -> Self {
        let stage = if here.distance_m(hallway.at_in_odom()) > ELSEWHERE_M {
            returning(hallway, here, 0.0, patience_s)
        } else {
            Stage::Turning { registers: hallway.axis().is_none() }
        };
        Self { stage, until, lane_m, patience_s, look_at_end: LookAtEnd::default() }
    }

    /// One step.
    pub fn step(&mut self, hallway: &mut Hallway, now: &Moment<'_>, perceiving: Perceiving<'_>) -> Decision {
        let (limits, input) = (&now.model.limits, now.input());
        let here = input.odometry_in_odom;
        hallway.follow(here);
        let is_in_hallway = perceiving.registers && !matches!(self.stage, Stage::Returning(_));
        if input.sonar.filter(|_| is_in_hallway).is_some_and(|scan| hallway.is_turned(here, scan)) {
            self.stage = Stage::Turning { registers: true };
        }
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
        // Who was turned by hand knows the direction well enough to go on, as before the end of a hallway.
        let is_begun = self.until != Until::Registered;
        let patience_s = if is_begun { HELD_UP_S } else { self.patience_s };
        if gone_m > REGISTER_MOST_M || output.held_up_s > patience_s {
            if let Some(scan) = input.sonar.filter(|_| is_begun && !is_known) {
                hallway.keep_guess(input.odometry_in_odom, scan);
            }
            let end = if is_known || is_begun { None } else { Some(DriveEnd::NoWalls) };
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
                self.stage = returning(hallway, input.odometry_in_odom, -back_m, self.patience_s);
                (Velocity::default(), None)
            }
        }
    }

    /// Back where it was to go, or where it began to register, which it does on the way as well.
    fn is_back(&mut self, hallway: &Hallway) -> Decision {
        let is_there = match self.until {
            Until::Registered => true,
            Until::Along { along_m } => along_m < hallway.along_m() + THERE_M,
            Until::End => false,
        };
        if is_there {
            return (Velocity::default(), Some(DriveEnd::There));
        }
        self.stage = self.next(hallway);
        (Velocity::default(), None)
    }

    fn go_on(
        &mut self,
        hallway: &mut Hallway,
        now: &Moment<'_>,
        input: &NavigationInput<'_>,
        perceiving: Perceiving<'_>,
    ) -> Decision {
        let Perceiving { detects, markers_in_odom, .. } = perceiving;
        let limits = &now.model.limits;
        if self.until == Until::Registered && hallway.axis().is_some() {
            return (Velocity::default(), Some(DriveEnd::There));
        }
        if let Some(scan) = input.sonar {
            perceiving.look_along(hallway, input.odometry_in_odom, scan);
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
        let is_short = self.until == Until::End && output.free_m < END_FREE_M;
        let is_before_end = is_short && hallway.is_before_end();
        // Where people stood before the end, it was not heard from afar.
        let may_end = is_before_end || is_short && output.held_up_s > MAY_END_S;
        let to_end_m = match input.sonar.filter(|_| may_end) {
            Some(scan) => self.look_at_end(hallway, limits.step_s, input.odometry_in_odom, scan),
            None => {
                self.look_at_end = LookAtEnd::default();
                None
            }
        };
        let end = if remaining_m < THERE_M || to_end_m.is_some() {
            Some(DriveEnd::There)
        } else {
            (output.held_up_s > self.patience_s).then_some(DriveEnd::Blocked)
        };
        if end.is_some() && detects {
            hallway.finish(to_end_m, markers_in_odom);
        }
        (if is_before_end { Velocity::default() } else { output.velocity }, end)
    }

    /// Stands and looks for a while whether what is ahead is a wall; if it is not, there was no end. Answers how far
    /// ahead the hallway ends.
    fn look_at_end(
        &mut self,
        hallway: &mut Hallway,
        step_s: f64,
        odometry_in_odom: Pose,
        scan: SonarScan<'_>,
    ) -> Option<f64> {
        let look = &mut self.look_at_end;
        look.stood_s += step_s;
        if let Some(to_end_m) = hallway.wall_ahead_m(odometry_in_odom, scan) {
            look.shown_s += step_s;
            look.to_end_m = Some(to_end_m);
        }
        if look.stood_s <= AT_END_S {
            return None;
        }
        let to_end_m = look.to_end_m.filter(|_| look.shown_s >= SHOWN_SHARE * look.stood_s);
        if to_end_m.is_none() {
            hallway.forget_end();
        }
        self.look_at_end = LookAtEnd::default();
        to_end_m
    }
}

/// To this far ahead of where the robot was in the hallway last, looking along it.
fn returning(hallway: &Hallway, here: Pose, ahead_m: f64, patience_s: f64) -> Stage {
    let last = Pose { heading_rad: hallway.heading_in_odom_rad(), ..hallway.at_in_odom() };
    let mut navigation = MaplessNavigation::default();
    let there = last.compose(Pose::new(ahead_m, 0.0, 0.0));
    navigation.start_nearby(Target::at(there), patience_s, here.distance_m(there) + MOST_DETOUR_M);
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
