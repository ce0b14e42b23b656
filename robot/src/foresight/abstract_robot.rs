//! The abstract robot: where it is and what it does, in events. A drive is a duration and an outcome; what is
//! at a place, how doors stand and how grasps go is drawn when a run first comes to it, and stays so.

use super::act_model::ActModel;
use super::activity::{Doing, Outcome, UnderWay};
use super::drive::{Drive, microseconds};
use super::drive_times::DriveTimes;
use super::models::{DriveRecord, GraspRecord, Missed, Models, TimedDrive};
use super::streams::Streams;
use super::ways::{Way, WayMap, Ways};
use crate::description::{BatteryDescription, GripperDescription};
use crate::geometry::{Point, Pose, distance_m, wrap_angle_rad};
use crate::navigation::{MoveGoal, RelativeMove};
use crate::planning::Target;
use rpl_random::Stream;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// The battery is told each time it has changed by this share.
const BATTERY_STEP: f64 = 0.005;

/// The robot is charged this near to a charging place.
const CHARGING_REACH_M: f64 = 0.6;

/// What is known of a robot and told to the abstract one.
#[derive(Clone, Debug)]
pub struct Knowledge {
    /// How long its drives take.
    pub drive_times: DriveTimes,
    /// What may come between.
    pub models: Models,
    /// Where it may be, with the probability of each; the likeliest first.
    pub hypotheses: Vec<(Pose, f64)>,
    /// Its gripper.
    pub gripper: Option<GripperDescription>,
    /// Its battery.
    pub battery: Option<BatteryDescription>,
    /// Where it is charged.
    pub chargers_in_map: Vec<Point>,
    /// How long a look around takes.
    pub look_s: f64,
}

/// Something under way, and how it will end.
#[derive(Clone, Debug)]
struct Activity {
    ends_us: u64,
    outcome: Outcome,
    asked: UnderWay,
}

/// A thing that the robot has come to.
#[derive(Clone, Debug, PartialEq)]
pub struct Thing {
    /// Where it lies; nowhere if it is not here at all.
    pub lies_in_map: Option<Point>,
    /// How often the robot has put it down.
    pub put_down: u32,
    /// Where the robot knows it to lie, once it does: nowhere if it was missed too often.
    known_in_map: Option<Option<Point>>,
}

/// What an abstract robot learns in a run, as one on wheels does.
#[derive(Clone, Debug, Default)]
pub struct Experience {
    /// Of grasping.
    pub grasps: GraspRecord,
    /// Of driving.
    pub drives: DriveRecord,
    missed: Missed,
}

impl Experience {
    /// Adds what was learned in a later run.
    pub fn add(&mut self, later: &Self) {
        self.grasps.add(later.grasps);
        self.drives.add(&later.drives);
    }
}

/// The state of a projected robot.
#[derive(Clone, Debug)]
pub struct AbstractRobot {
    knowledge: Arc<Knowledge>,
    ways: Ways,
    /// Where it is.
    pub robot_in_map: Pose,
    /// Whether it knows where it is.
    pub is_lost: bool,
    /// What its gripper holds.
    pub holding: Option<String>,
    /// The charge of its battery, from 0 to 1.
    pub battery: f64,
    drive: Option<Drive>,
    /// Whether it is driven by its own controller, and moves.
    is_driven: bool,
    doing: BTreeMap<Doing, Activity>,
    /// Until when doors are closed that it has come to, or will come to on its drive.
    closed_until_us: BTreeMap<usize, u64>,
    /// Those that have kept it from coming through.
    found_closed: BTreeSet<usize>,
    /// The things that it has come to in this run.
    pub things: BTreeMap<String, Thing>,
    now_us: u64,
    told_battery: f64,
    streams: Streams,
    has_drawn: bool,
    /// What it has learned.
    pub experience: Experience,
}

/// A way that is longer than a straight stretch by this factor leads around something.
const MOST_DETOUR: f64 = 1.3;

/// Nearer than this, and turned by less, is the same place: as maxima of a belief are told apart.
const SAME_PLACE_M: f64 = 0.5;
const SAME_PLACE_RAD: f64 = 15.0 * std::f64::consts::PI / 180.0;

fn is_same_place(one: Pose, other: Pose) -> bool {
    one.distance_m(other) < SAME_PLACE_M && wrap_angle_rad(one.heading_rad - other.heading_rad).abs() < SAME_PLACE_RAD
}

impl AbstractRobot {
    /// A robot with this knowledge, at the likeliest of the places where it may be.
    pub fn new(knowledge: Knowledge, ways: Ways, holding: Option<String>, battery: f64, now_us: u64) -> Self {
        let robot_in_map = knowledge.hypotheses.first().map_or_else(Pose::default, |&(pose, _)| pose);
        Self {
            knowledge: Arc::new(knowledge),
            ways,
            robot_in_map,
            is_lost: false,
            holding,
            battery,
            drive: None,
            is_driven: false,
            doing: BTreeMap::new(),
            closed_until_us: BTreeMap::new(),
            found_closed: BTreeSet::new(),
            things: BTreeMap::new(),
            now_us,
            told_battery: battery,
            streams: Streams::of(0),
            has_drawn: false,
            experience: Experience::default(),
        }
    }

    /// The robot as it is foreseen by somebody who knows what it knows, and not what will come of what is under way
    /// ([`Self::under_way`]).
    #[must_use]
    pub fn believed(&self, models: Models, ways: Ways) -> Self {
        let hypotheses = vec![(self.robot_in_map, 1.0)];
        let known = |(name, thing): (&String, &Thing)| {
            Some((name.clone(), Thing { lies_in_map: thing.known_in_map?, ..thing.clone() }))
        };
        Self {
            knowledge: Arc::new(Knowledge { models, hypotheses, ..(*self.knowledge).clone() }),
            ways,
            holding: self.holding.clone(),
            drive: None,
            is_driven: false,
            doing: BTreeMap::new(),
            closed_until_us: BTreeMap::new(),
            found_closed: self.closed_doors().into_iter().collect(),
            things: self.things.iter().filter_map(known).collect(),
            streams: Streams::of(0),
            has_drawn: false,
            experience: Experience::default(),
            ..*self
        }
    }

    /// What it was asked to do, as far as it is left.
    pub fn under_way(&self) -> Vec<UnderWay> {
        let left = |activity: &Activity| match &activity.asked {
            UnderWay::Driving { targets, patience_s, .. } => {
                let reached = targets.len() - self.remaining_targets().min(targets.len());
                let begins_us = self.drive.as_ref().and_then(|drive| drive.begins_us.first());
                let has_set_off = begins_us.is_some_and(|&begins_us| begins_us <= self.now_us);
                UnderWay::Driving { targets: targets[reached..].to_vec(), patience_s: *patience_s, has_set_off }
            }
            asked => asked.clone(),
        };
        self.doing.values().map(left).collect()
    }

    /// Whether something was left to chance since the run began.
    pub fn has_drawn(&self) -> bool {
        self.has_drawn
    }

    /// Draws where it is for one run, before anything is under way. If that is another place than the likeliest, it
    /// is lost.
    pub fn begin_run(&mut self, seed: u64) {
        self.streams = Streams::of(seed);
        self.has_drawn = self.knowledge.hypotheses.len() > 1;
        let mut left = Stream::new(seed, "foreseen position").uniform();
        for (number, &(pose, probability)) in self.knowledge.hypotheses.iter().enumerate() {
            left -= probability;
            if left < 0.0 {
                self.robot_in_map = pose;
                self.is_lost |= number > 0 && !is_same_place(pose, self.knowledge.hypotheses[0].0);
                break;
            }
        }
    }

    /// Its own controller has driven it there.
    pub fn carry_to(&mut self, robot_in_map: Pose, is_driven: bool) {
        (self.robot_in_map, self.is_driven) = (robot_in_map, is_driven);
    }

    /// Whether there is anything left in its battery.
    pub fn has_power(&self) -> bool {
        self.knowledge.battery.is_none() || self.battery > 0.0
    }

    /// For how long a drive that should take `expected_s` is held up by people, and from when on.
    pub fn draw_hold_up(&mut self, expected_s: f64) -> (u64, u64) {
        self.leave_to_chance();
        let lost_s = self.knowledge.models.drive_time(expected_s, &mut self.streams.drives).held_up_s;
        let from_us = self.now_us + microseconds(self.streams.drives.uniform() * expected_s);
        (from_us, from_us + microseconds(lost_s))
    }

    /// It has come to a door: how that stands is drawn, if it was not before.
    pub fn come_to(&mut self, door: usize) {
        self.leave_to_chance();
        self.wait_at(door, 0.0);
    }

    /// How the doors stand that it has come to: whether each is closed at a time.
    pub fn drawn_doors(&self, at_us: u64) -> impl Iterator<Item = (usize, bool)> {
        self.closed_until_us.iter().map(move |(&door, &until_us)| (door, until_us > at_us))
    }

    /// When it goes by its clock.
    pub fn now_us(&self) -> u64 {
        self.now_us
    }

    /// When the next thing happens, if any.
    pub fn next_event_us(&self) -> Option<u64> {
        let endings = self.doing.values().map(|activity| activity.ends_us);
        let target = self.drive.as_ref().and_then(|drive| drive.next_target_us(self.now_us));
        let rate_per_s = self.battery_per_s();
        let battery = (rate_per_s != 0.0 && (self.battery > 0.0 || rate_per_s > 0.0)).then(|| {
            let bound =
                if rate_per_s > 0.0 { self.told_battery + BATTERY_STEP } else { self.told_battery - BATTERY_STEP };
            let left = (bound.clamp(0.0, 1.0) - self.battery) / rate_per_s;
            self.now_us + microseconds(left).max(1)
        });
        let is_full = self.battery >= 1.0 && rate_per_s > 0.0;
        endings.chain(target).chain(battery.filter(|_| !is_full)).min()
    }

    /// Goes on to a time: what ends until then is told, in the order in which it ends.
    pub fn advance_to(&mut self, now_us: u64) -> Vec<(Doing, Outcome)> {
        let rate_per_s = self.battery_per_s();
        let passed_s = now_us.saturating_sub(self.now_us) as f64 / 1e6;
        self.battery = (self.battery + rate_per_s * passed_s).clamp(0.0, 1.0);
        if (self.battery - self.told_battery).abs() >= BATTERY_STEP - 1e-9 {
            self.told_battery = self.battery;
        }
        self.now_us = now_us;
        let led_to = self.drive.as_ref().and_then(|drive| drive.pose_in_map(now_us, &self.knowledge.drive_times));
        self.robot_in_map = led_to.unwrap_or(self.robot_in_map);
        let mut ended: Vec<(u64, Doing)> = self
            .doing
            .iter()
            .filter(|(_, activity)| activity.ends_us <= now_us)
            .map(|(&doing, a)| (a.ends_us, doing))
            .collect();
        ended.sort_unstable();
        ended.into_iter().filter_map(|(_, doing)| self.end(doing)).collect()
    }

    fn end(&mut self, doing: Doing) -> Option<(Doing, Outcome)> {
        let Activity { outcome, asked, .. } = self.doing.remove(&doing)?;
        match &asked {
            UnderWay::Driving { .. } => self.end_drive(&outcome),
            UnderWay::Grasping(thing) => self.end_grasp(thing, outcome == Outcome::Done),
            UnderWay::Releasing if outcome == Outcome::Done => self.let_go(),
            UnderWay::Searching if outcome == Outcome::Done => self.is_lost = false,
            UnderWay::Moving(goal) if outcome == Outcome::Done => self.robot_in_map = goal.from_pose(self.robot_in_map),
            UnderWay::Moving(_)
            | UnderWay::Releasing
            | UnderWay::Looking
            | UnderWay::Searching
            | UnderWay::Acting(..) => {}
        }
        Some((doing, outcome))
    }

    fn end_grasp(&mut self, thing: &str, is_held: bool) {
        let Experience { grasps, missed, .. } = &mut self.experience;
        if missed.note(thing, is_held, grasps)
            && let Some(known) = self.things.get_mut(thing)
        {
            known.known_in_map = Some(known.lies_in_map.filter(|_| is_held));
        }
        if is_held {
            self.holding = Some(thing.to_string());
        }
    }

    fn let_go(&mut self) {
        let Some(thing) = self.holding.take() else { return };
        let here = Some(self.robot_in_map.point());
        let put_down = self.things.get(&thing).map_or(0, |known| known.put_down) + 1;
        self.things.insert(thing, Thing { lies_in_map: here, put_down, known_in_map: Some(here) });
    }

    fn end_drive(&mut self, outcome: &Outcome) {
        let Some(drive) = self.drive.take() else { return };
        let drives = &mut self.experience.drives;
        match outcome {
            Outcome::Done => drives.note(drive.timed, drive.doors_open),
            Outcome::DoorClosed(door) => {
                drives.doors_open += drive.doors_open;
                self.found_closed.insert(*door);
            }
            _ => return,
        }
        drives.doors_closed += drive.doors_closed;
    }

    /// Targets of the drive that are not reached yet.
    pub fn remaining_targets(&self) -> usize {
        self.drive.as_ref().map_or(0, |drive| drive.remaining_targets(self.now_us))
    }

    /// Whether it moves.
    pub fn drives(&self) -> bool {
        self.drive.is_some()
    }

    /// Doors found closed not long ago.
    pub fn closed_doors(&self) -> Vec<usize> {
        let is_closed = |door: &&usize| self.closed_until_us.get(door).is_some_and(|&until_us| until_us > self.now_us);
        self.found_closed.iter().filter(is_closed).copied().collect()
    }

    /// Forgets which doors it has found closed.
    pub fn forget_doors(&mut self, is_meant: impl Fn(usize) -> bool) {
        self.found_closed.retain(|&door| !is_meant(door));
    }

    /// A door was found closed before the run began.
    pub fn know_closed(&mut self, door: usize) {
        let closed_s = Models::closed_s(&mut Stream::new(self.streams.doors, &format!("door {door}")));
        self.has_drawn = true;
        self.found_closed.insert(door);
        self.closed_until_us.insert(door, self.now_us + microseconds(closed_s));
    }

    /// Begins what it is asked to do.
    pub fn begin(&mut self, map: WayMap<'_>, asked: &UnderWay) {
        let (takes_s, outcome) = match asked {
            UnderWay::Driving { targets, patience_s, has_set_off } => {
                self.drive(map, targets, *patience_s, *has_set_off)
            }
            UnderWay::Grasping(thing) => self.grasp(thing),
            UnderWay::Releasing => self.release(),
            UnderWay::Looking => (self.knowledge.look_s, Outcome::Done),
            UnderWay::Moving(goal) => self.move_by_odometry(map, *goal),
            UnderWay::Searching => self.search(),
            UnderWay::Acting(_, model) => self.act(model),
        };
        let activity = Activity { ends_us: self.now_us + microseconds(takes_s), outcome, asked: asked.clone() };
        self.doing.insert(asked.doing(), activity);
    }

    /// A turn, or a straight stretch, which is blocked where the map shows no straight way.
    fn move_by_odometry(&self, map: WayMap<'_>, goal: MoveGoal) -> (f64, Outcome) {
        let times = self.knowledge.drive_times;
        match goal {
            MoveGoal::Turn { turn_rad } => (times.turn_s_per_rad * turn_rad.abs(), Outcome::Done),
            MoveGoal::Straight { ahead_m } => {
                let end = goal.from_pose(self.robot_in_map);
                let way = Way::over(&self.ways, map, self.robot_in_map, &[Target::through(end.point())]);
                let way_m = way.map(|way| way.features().length_m());
                match way_m.is_some_and(|way_m| way_m <= ahead_m.abs() * MOST_DETOUR) {
                    true => (times.constant_s + times.office_s_per_m * ahead_m.abs(), Outcome::Done),
                    false => (RelativeMove::PATIENCE_S, Outcome::Hindered(goal)),
                }
            }
        }
    }

    /// Begins to drive over targets, in order: how long it drives, and how that ends.
    fn drive(&mut self, map: WayMap<'_>, targets: &[Target], patience_s: f64, has_set_off: bool) -> (f64, Outcome) {
        let Some(way) = Way::over(&self.ways, map, self.robot_in_map, targets) else {
            return (0.0, Outcome::Unreachable);
        };
        self.leave_to_chance();
        let features = way.features();
        let mut times = self.knowledge.drive_times;
        if has_set_off {
            times.constant_s = 0.0;
        }
        let expected_s = times.time_s(&features);
        let takes_s = self.knowledge.models.drive_time(expected_s, &mut self.streams.drives).takes_s;
        // What is lost on the way, by people and by straying, is lost evenly.
        let timed = TimedDrive { expected_s: expected_s.max(1e-3), took_s: takes_s };
        let share = timed.took_s / timed.expected_s;
        let mut at_s = times.constant_s * share;
        let mut begins_us = Vec::with_capacity(way.stretches.len() + 1);
        let mut outcome = Outcome::Done;
        let (mut doors_open, mut doors_closed) = (0, 0);
        for stretch in &way.stretches {
            at_s += share * stretch.turned_rad * times.turn_s_per_rad;
            begins_us.push(self.now_us + microseconds(at_s));
            at_s += share * times.metre_s(stretch.mode) * stretch.length_m;
            if let Some(door) = stretch.door {
                let is_new = !self.closed_until_us.contains_key(&door);
                let closed_s = self.wait_at(door, at_s);
                at_s += closed_s.min(patience_s);
                // A run finds a door as it found it before, so that it counts once.
                *(if closed_s > 0.0 { &mut doors_closed } else { &mut doors_open }) += u32::from(is_new);
                if closed_s > patience_s {
                    outcome = Outcome::DoorClosed(door);
                    break;
                }
            }
        }
        if outcome == Outcome::Done {
            begins_us.push(self.now_us + microseconds(at_s));
            at_s += share * way.last_turn_rad * times.turn_s_per_rad;
        }
        // With an empty battery it stands, and gives up when its patience is over.
        let power_s = self.power_s();
        if power_s < at_s {
            begins_us.retain(|&begins_us| begins_us <= self.now_us + microseconds(power_s));
            (at_s, outcome) = (power_s + patience_s, Outcome::Empty);
        }
        let (start_in_map, targets) = (self.robot_in_map, targets.len());
        self.drive =
            Some(Drive { way: Arc::new(way), begins_us, start_in_map, targets, timed, doors_open, doors_closed });
        (at_s, outcome)
    }

    /// What comes now is drawn, where there is anything to draw.
    fn leave_to_chance(&mut self) {
        self.has_drawn |= !self.knowledge.models.are_certain();
    }

    fn act(&mut self, model: &ActModel) -> (f64, Outcome) {
        self.has_drawn |= !model.is_certain();
        let (takes_s, failure) = model.drawn(&mut self.streams.acts);
        (takes_s, failure.map_or(Outcome::Done, |class| Outcome::Failed(class.to_string())))
    }

    /// How long it can drive.
    fn power_s(&self) -> f64 {
        self.knowledge.battery.map_or(f64::INFINITY, |battery| self.battery * battery.driving_s)
    }

    /// How long a door keeps the robot that comes to it in `in_s` seconds: mostly not at all. A run finds a
    /// door as it found it before.
    fn wait_at(&mut self, door: usize, in_s: f64) -> f64 {
        let arrives_us = self.now_us + microseconds(in_s);
        if !self.closed_until_us.contains_key(&door) {
            let mut stream = Stream::new(self.streams.doors, &format!("door {door}"));
            let closed_s = Models::closed_s(&mut stream);
            let is_closed = stream.chance(self.knowledge.models.door_closed.share());
            let until_us = if is_closed { arrives_us + microseconds(closed_s) } else { 0 };
            self.closed_until_us.insert(door, until_us);
        }
        self.closed_until_us[&door].saturating_sub(arrives_us) as f64 / 1e6
    }

    fn grasp(&mut self, thing: &str) -> (f64, Outcome) {
        let Some(gripper) = self.knowledge.gripper else { return (0.0, Outcome::NotHeld(thing.to_string())) };
        self.leave_to_chance();
        let misses = self.streams.grasps.chance(self.knowledge.models.grasp_misses.share());
        let here = self.robot_in_map.point();
        let missing = self.knowledge.models.thing_missing.share();
        let seed = self.streams.things;
        let thing_there = self.things.entry(thing.to_string()).or_insert_with(|| {
            let is_missing = Stream::new(seed, &format!("thing {thing}")).chance(missing);
            Thing { lies_in_map: (!is_missing).then_some(here), put_down: 0, known_in_map: None }
        });
        let is_here = thing_there.lies_in_map.is_some_and(|there| distance_m(there, here) <= gripper.reach_m);
        let takes = !misses && is_here && self.holding.is_none() && !self.is_lost;
        let outcome = if takes { Outcome::Done } else { Outcome::NotHeld(thing.to_string()) };
        (gripper.grasp_us as f64 / 1e6, outcome)
    }

    /// People have brought a thing to where it is.
    pub fn expect_here(&mut self, thing: &str) {
        let here = Some(self.robot_in_map.point());
        let put_down = self.things.get(thing).map_or(0, |known| known.put_down);
        self.things.insert(thing.to_string(), Thing { lies_in_map: here, put_down, known_in_map: None });
    }

    fn release(&mut self) -> (f64, Outcome) {
        let Some(gripper) = self.knowledge.gripper else { return (0.0, Outcome::NotOpened) };
        self.leave_to_chance();
        let fails = self.streams.grasps.chance(self.knowledge.models.release_fails.share());
        (gripper.release_us as f64 / 1e6, if fails { Outcome::NotOpened } else { Outcome::Done })
    }

    fn search(&mut self) -> (f64, Outcome) {
        self.has_drawn = true;
        let search = Models::search(&mut self.streams.searches);
        (search.takes_s, if search.finds { Outcome::Done } else { Outcome::NotFound })
    }

    /// Something is given up. A hand that has begun to close closes.
    pub fn stop(&mut self, doing: Doing) {
        if doing == Doing::Gripping {
            self.end(doing);
        }
        self.doing.remove(&doing);
        if doing == Doing::Driving {
            self.drive = None;
        }
    }

    fn battery_per_s(&self) -> f64 {
        let Some(battery) = self.knowledge.battery else { return 0.0 };
        let here = self.robot_in_map.point();
        let is_charged = || self.knowledge.chargers_in_map.iter().any(|&at| distance_m(at, here) <= CHARGING_REACH_M);
        if self.drives() || self.is_driven {
            -1.0 / battery.driving_s
        } else if is_charged() {
            1.0 / battery.charging_s
        } else {
            -1.0 / battery.standing_s
        }
    }
}
