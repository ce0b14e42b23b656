//! What may come between: rates that the robot has learned from its own past, beginning with cautious
//! priors. A hundred things that were all there do not mean that none is ever missing.

use crate::description::{GripperDescription, RobotDescription};
use rpl_random::Stream;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// How often something happened, of how many times: with what was counted on before.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// Times it happened.
    pub happened: f64,
    /// Times it could have.
    pub times: f64,
}

impl Rate {
    /// A rate that is counted on beforehand: a share that weighs as much as `weight` times.
    pub fn counted_on(share: f64, weight: f64) -> Self {
        Self { happened: share * weight, times: weight }
    }

    /// With what the robot has seen itself.
    #[must_use]
    pub fn and(self, happened: f64, times: f64) -> Self {
        Self { happened: self.happened + happened, times: self.times + times }
    }

    /// The share: the mean of what is believed of it.
    pub fn share(self) -> f64 {
        self.happened / self.times
    }
}

/// How likely what may come between really is: the truth of an abstract world, which no robot knows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Chances {
    /// A thing that is there is missed.
    pub grasp_misses: f64,
    /// A gripper that is to open does not.
    pub release_fails: f64,
    /// A thing is not where it is looked for.
    pub thing_missing: f64,
    /// A door is closed.
    pub door_closed: f64,
    /// A drive is held up.
    pub held_up: f64,
}

/// What the robot has learned of grasping.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct GraspRecord {
    /// Tries at things that were there.
    pub tries: u32,
    /// How many of these missed.
    pub misses: u32,
    /// Things that were looked for.
    pub things: u32,
    /// How many of these were not there, as far as three tries tell.
    pub missing: u32,
}

impl GraspRecord {
    /// Takes down how all tries at a thing went: `misses` missed, and then it was held or was not there.
    pub fn note(&mut self, misses: u32, is_held: bool) {
        self.things += 1;
        if is_held {
            self.tries += misses + 1;
            self.misses += misses;
        } else {
            self.missing += 1;
        }
    }

    /// How often things that are there are missed, and how often they are missing, beginning with what is counted on.
    /// A thing that was missed in all its tries may have been there: the likeliest share of these is found by
    /// expectation maximization (Dempster, Laird and Rubin, 1977).
    fn rates(&self, counted_misses: Rate, counted_missing: Rate) -> (Rate, Rate) {
        let [tries, misses, things, missing] = [self.tries, self.misses, self.things, self.missing].map(f64::from);
        let all = f64::from(TRIES_AT_A_THING);
        let (mut rate_of_misses, mut rate_of_missing) = (counted_misses, counted_missing);
        for _ in 0..ROUNDS {
            let is_missing = rate_of_missing.share();
            let is_missed = (1.0 - is_missing) * libm::pow(rate_of_misses.share(), all);
            let were_there = missing * is_missed / (is_missed + is_missing);
            rate_of_misses = counted_misses.and(misses + all * were_there, tries + all * were_there);
            rate_of_missing = counted_missing.and(missing - were_there, things);
        }
        (rate_of_misses, rate_of_missing)
    }

    /// Adds what was learned later.
    pub fn add(&mut self, later: Self) {
        self.tries += later.tries;
        self.misses += later.misses;
        self.things += later.things;
        self.missing += later.missing;
    }
}

/// A thing that was missed this often is not there.
const TRIES_AT_A_THING: u32 = 3;

/// After this many rounds the rates hardly change any more. Only where two tries in three miss, or more, that of misses
/// is still some hundredths too low, and that of missing things as much too high.
const ROUNDS: usize = 32;

/// The thing that was missed last, and how often in a row.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Missed(Option<(String, u32)>);

impl Missed {
    /// Takes down a try at a thing, and whether it is known now to be there, or not to be. Misses of what turns out not
    /// to be there are none, and however often it is tried on, it is missing once.
    pub fn note(&mut self, thing: &str, is_held: bool, record: &mut GraspRecord) -> bool {
        let before = self.0.take().filter(|(name, _)| name == thing).map_or(0, |(_, times)| times);
        let is_known = is_held || before + 1 == TRIES_AT_A_THING;
        if is_known {
            // What is held after all was brought there.
            record.note(if before < TRIES_AT_A_THING { before } else { 0 }, is_held);
        }
        if !is_held {
            self.0 = Some((thing.to_string(), before.saturating_add(1)));
        }
        is_known
    }
}

/// How long a drive took, and how long it should have taken.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TimedDrive {
    /// By the way it took.
    pub expected_s: f64,
    /// In fact.
    pub took_s: f64,
}

/// What of its drives the robot goes by: how long each took, and the doors.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DriveRecord {
    /// The last drives that came to their end, the oldest first.
    pub drives: Vec<TimedDrive>,
    /// Doors that were driven through.
    pub doors_open: u32,
    /// Doors that kept the robot from coming through in time.
    pub doors_closed: u32,
}

/// Drives that are remembered.
const DRIVES_KEPT: usize = 256;

impl DriveRecord {
    /// Takes down a drive that has arrived.
    pub fn note(&mut self, drive: TimedDrive, doors_open: u32) {
        if self.drives.len() == DRIVES_KEPT {
            self.drives.remove(0);
        }
        self.drives.push(drive);
        self.doors_open = self.doors_open.saturating_add(doors_open);
    }

    /// Adds what was learned later.
    pub fn add(&mut self, later: &Self) {
        later.drives.iter().for_each(|&drive| self.note(drive, 0));
        self.doors_open += later.doors_open;
        self.doors_closed += later.doors_closed;
    }

    /// How many times the time it should take a drive takes this robot where nothing comes between: as long as its
    /// quick quarter and those about as quick took. The prior is 1, and weighs as much as [`PRIOR_DRIVES`].
    fn pace(&self) -> f64 {
        let mut shares: Vec<f64> = self.drives.iter().map(|drive| drive.took_s / drive.expected_s).collect();
        shares.sort_by(f64::total_cmp);
        let quick = shares.get(shares.len() / 4).copied().unwrap_or(1.0);
        let about: Vec<f64> = shares.into_iter().filter(|share| strays_about(*share, quick)).collect();
        (about.iter().sum::<f64>() + PRIOR_DRIVES) / (about.len() as f64 + PRIOR_DRIVES)
    }
}

/// Whether a drive that takes `share` times its time only strays from a pace.
fn strays_about(share: f64, pace: f64) -> bool {
    (share / pace - 1.0).abs() <= 3.0 * USUAL_STRAYING
}

/// How one of its own drives went.
#[derive(Clone, Copy, Debug, PartialEq)]
enum OwnDrive {
    /// How many times its time it took: on a long way that is more than on a short one.
    Strayed(f64),
    /// How long it was held up, as it would have been on any way.
    HeldUp(f64),
}

impl OwnDrive {
    fn of(TimedDrive { expected_s, took_s }: TimedDrive, pace: f64) -> Self {
        match strays_about(took_s / expected_s, pace) {
            true => Self::Strayed(took_s / expected_s),
            false => Self::HeldUp(took_s - pace * expected_s),
        }
    }
}

/// How a drive strays from its time if nothing is known: by three parts in a hundred.
const USUAL_STRAYING: f64 = 0.03;

/// One drive in twenty is held up by people or things, for up to half a minute. Like all that is counted on
/// here beforehand it is assumed, not measured.
const HELD_UP: f64 = 0.05;
const HELD_UP_S: f64 = 30.0;

/// No drive takes less than this part of its time.
const LEAST_TIME: f64 = 0.5;

/// The prior of drives weighs as much as this many of the robot's own.
const PRIOR_DRIVES: f64 = 8.0;

/// The prior of a rate weighs as much as this many times at which it could have happened: with one in fifty that is
/// half a time at which it did.
const PRIOR_TIMES: f64 = 25.0;

/// A door found closed stays so for a minute on the average: assumed.
const CLOSED_S: f64 = 60.0;

/// A search for the position takes a time between these, and succeeds nearly always: assumed.
const SEARCH_S: [f64; 2] = [10.0, 60.0];
const SEARCH_FAILS: f64 = 0.03;

/// Longest search: active localization gives up then.
const LONGEST_SEARCH_S: f64 = 600.0;

/// What may come between, with its rates.
#[derive(Clone, Debug, PartialEq)]
pub struct Models {
    /// A thing that is there is missed.
    pub grasp_misses: Rate,
    /// A gripper that is to open does not.
    pub release_fails: Rate,
    /// A thing is not where it is looked for.
    pub thing_missing: Rate,
    /// A door is closed.
    pub door_closed: Rate,
    /// A drive is held up, beside those that it remembers.
    pub held_up: Rate,
    /// By what part drives stray from their time.
    straying: f64,
    /// How many times the time it should take a drive takes where nothing comes between.
    pace: f64,
    /// How its own drives went.
    own_drives: Arc<[OwnDrive]>,
}

/// How long a drive takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DriveTime {
    /// From its beginning to its end.
    pub takes_s: f64,
    /// How long of that it is held up; less than nothing if it is far quicker than usual.
    pub held_up_s: f64,
}

/// How a search for the position goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// How long it takes.
    pub takes_s: f64,
    /// Whether it finds the position.
    pub finds: bool,
}

impl Models {
    /// For a robot with what it has learned.
    pub fn learned(robot: &RobotDescription, grasps: &GraspRecord, drives: &DriveRecord) -> Self {
        let declared = |probability: fn(&GripperDescription) -> f64| robot.gripper.as_ref().map_or(0.0, probability);
        let misses = declared(|gripper| gripper.grasp_failure_probability);
        let pace = drives.pace();
        let counted_on = |share: f64| Rate::counted_on(share, PRIOR_TIMES);
        let (grasp_misses, thing_missing) = grasps.rates(counted_on(misses.max(0.01)), counted_on(0.02));
        let [doors_open, doors_closed] = [drives.doors_open, drives.doors_closed].map(f64::from);
        Self {
            grasp_misses,
            release_fails: Rate::counted_on(declared(|gripper| gripper.release_failure_probability), 100.0),
            thing_missing,
            door_closed: counted_on(0.02).and(doors_closed, doors_open + doors_closed),
            held_up: Rate::counted_on(HELD_UP, 1.0),
            straying: USUAL_STRAYING,
            pace,
            own_drives: drives.drives.iter().map(|&drive| OwnDrive::of(drive, pace)).collect(),
        }
    }

    /// With chances that are known.
    pub fn exactly(chances: &Chances) -> Self {
        let exactly = |share: f64| Rate::counted_on(share, 1.0);
        Self {
            grasp_misses: exactly(chances.grasp_misses),
            release_fails: exactly(chances.release_fails),
            thing_missing: exactly(chances.thing_missing),
            door_closed: exactly(chances.door_closed),
            held_up: exactly(chances.held_up),
            straying: USUAL_STRAYING,
            pace: 1.0,
            own_drives: Arc::default(),
        }
    }

    /// Where nothing comes between and all takes the time that it should take.
    pub fn undisturbed() -> Self {
        let nothing =
            Chances { grasp_misses: 0.0, release_fails: 0.0, thing_missing: 0.0, door_closed: 0.0, held_up: 0.0 };
        Self { straying: 0.0, ..Self::exactly(&nothing) }
    }

    /// Whether there is nothing to draw.
    pub fn are_certain(&self) -> bool {
        let Self { grasp_misses, release_fails, thing_missing, door_closed, held_up, straying, pace, own_drives } =
            self;
        let rates = [grasp_misses, release_fails, thing_missing, door_closed, held_up];
        rates.iter().all(|rate| rate.share() == 0.0) && *straying == 0.0 && *pace == 1.0 && own_drives.is_empty()
    }

    /// How long a drive takes that should take `expected_s`, and how much of that it is held up: as one of its own was,
    /// or, the fewer these are the likelier, as a prior says.
    pub fn drive_time(&self, expected_s: f64, stream: &mut Stream) -> DriveTime {
        let own = self.own_drives.len() as f64;
        // Each drive draws the same numbers, whatever comes of them: plans are compared on the same chances.
        let (which, number, straying) = (stream.uniform(), stream.uniform(), stream.normal());
        let (is_held_up, held_up) = (stream.chance(self.held_up.share()), stream.uniform());
        let (times, held_up_s) = if which < own / (own + PRIOR_DRIVES) {
            match self.own_drives[((number * own) as usize).min(self.own_drives.len() - 1)] {
                OwnDrive::Strayed(times) => (times, 0.0),
                OwnDrive::HeldUp(held_up_s) => (self.pace, held_up_s),
            }
        } else {
            let times = (1.0 + self.straying * straying).clamp(0.8, 1.2);
            (times, if is_held_up { HELD_UP_S * held_up } else { 0.0 })
        };
        DriveTime { takes_s: (expected_s * times + held_up_s).max(expected_s * LEAST_TIME), held_up_s }
    }

    /// How long a closed door stays closed, from when it is found so.
    pub fn closed_s(stream: &mut Stream) -> f64 {
        -CLOSED_S * libm::log(1.0 - stream.uniform())
    }

    /// How a search for the position goes.
    pub fn search(stream: &mut Stream) -> Search {
        let takes_s = stream.uniform_in(SEARCH_S[0], SEARCH_S[1]);
        match stream.chance(SEARCH_FAILS) {
            true => Search { takes_s: LONGEST_SEARCH_S, finds: false },
            false => Search { takes_s, finds: true },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hundred_things_that_were_there_do_not_mean_never() {
        let grasps = GraspRecord { tries: 100, misses: 0, things: 100, missing: 0 };
        let models = Models::learned(&RobotDescription::papers(), &grasps, &DriveRecord::default());
        assert!((0.001..0.02).contains(&models.thing_missing.share()), "{:?}", models.thing_missing);
        assert!(models.grasp_misses.share() < 0.03, "fewer than declared were missed");
    }

    #[test]
    fn a_thing_that_is_not_there_is_missing_once_however_often_it_is_tried() {
        let (mut missed, mut record) = (Missed::default(), GraspRecord::default());
        let known: Vec<bool> = (0..9).map(|_| missed.note("cup", false, &mut record)).collect();
        assert_eq!(known.iter().position(|&is_known| is_known), Some(2), "after three tries");
        assert_eq!(record, GraspRecord { tries: 0, misses: 0, things: 1, missing: 1 });
        // Somebody has brought it; and another one was missed once.
        assert!(missed.note("cup", true, &mut record));
        assert!(!missed.note("letter", false, &mut record) && missed.note("letter", true, &mut record));
        assert_eq!(record, GraspRecord { tries: 3, misses: 1, things: 3, missing: 1 });
    }

    #[test]
    fn things_that_were_missed_three_times_may_have_been_there() {
        // Of 10,000 things one in five was missing, and what was there was missed with a chance of 0.4.
        let mut stream = Stream::new(1, "things");
        let mut record = GraspRecord::default();
        for _ in 0..10_000 {
            let is_missing = stream.chance(0.2);
            let misses = (0..TRIES_AT_A_THING).take_while(|_| is_missing || stream.chance(0.4)).count() as u32;
            record.note(misses, misses < TRIES_AT_A_THING);
        }
        assert!(f64::from(record.missing) / f64::from(record.things) > 0.24, "{record:?}");
        let models = Models::learned(&RobotDescription::papers(), &record, &DriveRecord::default());
        let [misses, missing] = [models.grasp_misses.share(), models.thing_missing.share()];
        assert!((misses - 0.4).abs() < 0.02 && (missing - 0.2).abs() < 0.02, "{misses} {missing}");
    }

    /// Of a robot whose drives should have taken 50 s each, and took these times.
    fn after_drives_of_50_s(took_s: &[f64]) -> Models {
        let drives = took_s.iter().map(|&took_s| TimedDrive { expected_s: 50.0, took_s }).collect();
        let drives = DriveRecord { drives, ..DriveRecord::default() };
        Models::learned(&RobotDescription::papers(), &GraspRecord::default(), &drives)
    }

    #[test]
    fn drives_of_its_own_come_to_outweigh_the_prior() {
        let mean = |took_s: &[f64]| {
            let models = after_drives_of_50_s(took_s);
            let mut stream = Stream::new(1, "drives");
            (0..4000).map(|_| models.drive_time(100.0, &mut stream).takes_s).sum::<f64>() / 4000.0
        };
        // The prior: 100 s, and one time in twenty 15 s more.
        assert!((mean(&[]) - 100.75).abs() < 0.5);
        // A robot that is slow on all ways, and one that is held up as long on a short way as on a long one.
        assert!((mean(&[60.0; 72]) - (0.9 * 120.0 + 0.1 * 100.75)).abs() < 0.5);
        let half = [[50.0; 36], [70.0; 36]].concat();
        assert!((mean(&half) - (0.9 * 110.0 + 0.1 * 100.75)).abs() < 0.5);
    }

    #[test]
    fn a_drive_is_held_up_by_what_is_more_than_usual() {
        let mean = |took_s: &[f64]| {
            let models = after_drives_of_50_s(took_s);
            let mut stream = Stream::new(1, "drives");
            (0..4000).map(|_| models.drive_time(100.0, &mut stream).held_up_s).sum::<f64>() / 4000.0
        };
        assert!((mean(&[]) - 0.75).abs() < 0.5, "one in twenty, for a quarter of a minute");
        assert!(mean(&[60.0; 72]) < 0.2, "it is slower than the table says, and always so");
        let one_in_four: Vec<f64> = (0..72).map(|drive| if drive % 4 == 0 { 75.0 } else { 50.0 }).collect();
        assert!((mean(&one_in_four) - 0.9 * 0.25 * 25.0).abs() < 1.0);
    }
}
