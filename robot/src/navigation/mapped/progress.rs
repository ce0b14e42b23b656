//! Whether the robot gets on: by the way that the map shows, and by the way around what it has found.

use serde::{Deserialize, Serialize};

/// Each time this has passed without getting nearer, the robot forgets what it saw and begins anew.
const ANEW_S: f64 = 10.0;
/// To look for a way around blockages the patience is multiplied by this, and for the detour at this
/// speed besides.
const SEARCH: f64 = 2.0;
const DETOUR_MPS: f64 = 0.15;
/// The least distance that counts as getting nearer.
const PROGRESS_M: f64 = 0.1;
/// No step changes the cost of the way left by this much.
const LEAP_M: f64 = 0.2;
/// Who goes on with a goal has its whole way back, and a moment there; so has who finds a door closed.
const BACK_M: f64 = 0.5;
const BACK_S: f64 = 5.0;

/// The nearest the robot has come, by the cost of the way left.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct MapProgress {
    /// The time without getting nearer that counts as blocked.
    patience_s: f64,
    /// By the way the map shows.
    least_cost_m: Option<f64>,
    /// The doors that way leads around: costs of other ways do not compare.
    avoided_doors: Vec<usize>,
    /// When that way was shortened last.
    at_s: f64,
    /// By the way around the blockages, since.
    around: AroundProgress,
    /// When either was shortened last.
    moved_at_s: f64,
    /// When that was, or when the robot began anew since.
    begun_at_s: f64,
    /// Doors found closed: one that is found so once more is no other task.
    closed_doors: Vec<usize>,
    /// How a robot that was called away gets back to where it was; until it comes nearer than that.
    back: Option<WayBack>,
}

/// What is left of a way.
#[derive(Clone, Debug)]
pub(super) struct WayLeft {
    /// By the map but for closed doors.
    pub cost_m: f64,
    /// These doors.
    pub avoided_doors: Vec<usize>,
    /// Around blockages besides, if there is a way.
    pub around_m: Option<f64>,
    /// Whether the robot stands before a closed door, for there is no other way.
    pub is_at_closed_door: bool,
}

/// The way back to where the robot was when it was called away.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct WayBack {
    around: AroundProgress,
    /// When it was shortened last.
    moved_at_s: f64,
    /// When the robot was there.
    there_at_s: Option<f64>,
}

/// Progress on the way around the blockages, which changes with each that is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct AroundProgress {
    least_cost_m: Option<f64>,
    /// A step ago.
    cost_m: Option<f64>,
    /// The most it has been longer than the way by the map.
    detour_m: f64,
}

impl MapProgress {
    /// Nothing is measured yet.
    pub fn from(at_s: f64, patience_s: f64) -> Self {
        Self { patience_s, at_s, moved_at_s: at_s, begun_at_s: at_s, ..Self::default() }
    }

    /// Nothing is measured yet of what is now another task; the patience is the same.
    fn start_again(&mut self, at_s: f64) {
        *self = Self { closed_doors: std::mem::take(&mut self.closed_doors), ..Self::from(at_s, self.patience_s) };
    }

    /// Doors were found closed, or open again. One that opens is a new task; one found closed that was not before leaves
    /// a moment to set out for another way.
    pub fn find_doors(&mut self, at_s: f64, before: &[usize], closed: &[usize]) {
        if closed.iter().any(|door| !self.closed_doors.contains(door)) {
            self.moved_at_s = self.moved_at_s.max(at_s - self.patience_s + BACK_S);
        }
        self.closed_doors.extend(closed);
        self.closed_doors.sort_unstable();
        self.closed_doors.dedup();
        if before.iter().any(|door| !closed.contains(door)) {
            self.start_again(at_s);
        }
    }

    /// What is measured next is another way's cost.
    pub fn measure_other_way(&mut self) {
        self.least_cost_m = None;
    }

    /// The same where the robot finds itself elsewhere: getting there was no progress.
    pub fn measure_from_elsewhere(&mut self) {
        self.least_cost_m = self.least_cost_m.map(|_| f64::INFINITY);
        self.around = AroundProgress::default();
    }

    /// A drive to the same goal as before an interruption: the patience is the goal's, and runs on. Whoever finds
    /// himself where he would be by his odometry is no nearer than he was.
    pub fn go_on(&mut self, now_s: f64, before: Self, is_same_place: bool) {
        let back = WayBack { around: AroundProgress::default(), moved_at_s: now_s, there_at_s: None };
        *self = Self { patience_s: self.patience_s, back: Some(back), ..before };
        self.around.cost_m = None;
        if !is_same_place {
            self.measure_from_elsewhere();
        }
    }

    /// Takes in the costs of the ways left: by the map but for closed doors, and around the blockages
    /// besides. Around other doors than before, what is nearest is counted from here; the time goes on. So it does for
    /// one that tries a closed door: it turns to and fro before the leaf, and comes a little nearer each time.
    pub fn measure(&mut self, now_s: f64, left: &WayLeft) {
        let WayLeft { cost_m, ref avoided_doors, around_m, is_at_closed_door } = *left;
        if self.avoided_doors != *avoided_doors {
            self.avoided_doors.clone_from(avoided_doors);
            self.least_cost_m = self.least_cost_m.map(|_| cost_m);
        }
        if self.least_cost_m == Some(f64::INFINITY) {
            self.least_cost_m = Some(cost_m);
        }
        if self.least_cost_m.is_none_or(|least_m| cost_m < least_m - PROGRESS_M) {
            self.least_cost_m = Some(cost_m);
            (self.around, self.back) = (AroundProgress::default(), None);
            if !is_at_closed_door {
                (self.at_s, self.moved_at_s, self.begun_at_s) = (now_s, now_s, now_s);
            }
        }
        let is_there = self.least_cost_m.is_none_or(|least_m| cost_m < least_m + BACK_M);
        if let Some(back) = &mut self.back {
            back.there_at_s = back.there_at_s.or(is_there.then_some(now_s));
            if back.around.shorten(around_m.unwrap_or(cost_m)) {
                back.moved_at_s = now_s;
            }
        }
        if let Some(around_m) = around_m {
            self.around.detour_m = self.around.detour_m.max(around_m - cost_m);
            if self.around.shorten(around_m) && !is_at_closed_door {
                (self.moved_at_s, self.begun_at_s) = (now_s, now_s);
            }
        }
    }

    /// Whether the robot should begin anew.
    pub fn is_time_to_begin_anew(&self, now_s: f64) -> bool {
        now_s - self.begun_at_s > ANEW_S
    }

    /// It does.
    pub fn begin_anew(&mut self, now_s: f64) {
        self.begun_at_s = now_s;
    }

    /// For how long the way by the map has not become shorter.
    pub fn since_s(&self, now_s: f64) -> f64 {
        now_s - self.at_s
    }

    /// Whether the robot has not come nearer for long. Coming nearer on a way around blockages counts
    /// too, but not for ever: the robot may be going to and fro between two of them.
    pub fn has_stalled(&self, now_s: f64) -> bool {
        let search_s = SEARCH * self.patience_s + self.around.detour_m / DETOUR_MPS;
        let has_stalled = now_s - self.moved_at_s > self.patience_s || self.since_s(now_s) > search_s;
        has_stalled
            && self.back.is_none_or(|back| match back.there_at_s {
                Some(there_at_s) => now_s - there_at_s > BACK_S,
                None => now_s - back.moved_at_s > self.patience_s,
            })
    }
}

impl AroundProgress {
    /// Whether the way left is shorter than ever; not the first that is measured. A cost that leaps is another way's: what was gained
    /// on the way before is carried over to it.
    fn shorten(&mut self, cost_m: f64) -> bool {
        let before_m = self.cost_m.replace(cost_m).unwrap_or(cost_m);
        if (cost_m - before_m).abs() > LEAP_M {
            self.least_cost_m = self.least_cost_m.map(|least_m| least_m + cost_m - before_m);
        }
        let is_shorter = self.least_cost_m.is_some_and(|least_m| cost_m < least_m - PROGRESS_M);
        if is_shorter || self.least_cost_m.is_none() {
            self.least_cost_m = Some(cost_m);
        }
        is_shorter
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_S: f64 = 0.05;

    fn left(cost_m: f64, around_m: f64) -> WayLeft {
        WayLeft { cost_m, avoided_doors: Vec::new(), around_m: Some(around_m), is_at_closed_door: false }
    }

    /// When a robot has stalled, if ever, by the costs of the ways left at each time.
    fn stalls_at_s(until_s: f64, costs_m: impl Fn(f64) -> (f64, f64)) -> Option<f64> {
        let mut progress = MapProgress::from(0.0, 30.0);
        let times_s = (0..(until_s / STEP_S) as u32).map(|step| f64::from(step) * STEP_S);
        times_s.into_iter().find(|&now_s| {
            let (mapped_m, around_m) = costs_m(now_s);
            progress.measure(now_s, &left(mapped_m, around_m));
            progress.has_stalled(now_s)
        })
    }

    #[test]
    fn who_stands_has_stalled_after_half_a_minute() {
        let stalled_s = stalls_at_s(100.0, |_| (5.0, 5.0));
        assert!(stalled_s.is_some_and(|at_s| (30.0..31.0).contains(&at_s)), "{stalled_s:?}");
    }

    #[test]
    fn who_is_patient_stalls_later() {
        let mut progress = MapProgress::from(0.0, 120.0);
        progress.measure(0.0, &left(5.0, 5.0));
        assert!(!progress.has_stalled(119.0) && progress.has_stalled(121.0));
        progress.start_again(100.0);
        progress.measure(100.0, &left(5.0, 5.0));
        assert!(!progress.has_stalled(219.0) && progress.has_stalled(221.0), "another task has the same patience");
    }

    #[test]
    fn the_patience_runs_on_over_interruptions() {
        let mut progress = MapProgress::from(0.0, 20.0);
        progress.measure(0.0, &left(5.0, 5.0));
        progress.find_doors(2.0, &[], &[3]);
        progress.measure(2.0, &left(5.0, 5.0));
        // Called away for ten seconds, it drives back, and finds the door closed once more.
        let mut again = MapProgress::from(15.0, 20.0);
        again.go_on(15.0, progress, true);
        for step in 0..=40 {
            let now_s = 15.0 + 0.1 * f64::from(step);
            again.measure(now_s, &left(6.0 - 0.025 * f64::from(step), 6.0 - 0.025 * f64::from(step)));
            assert!(!again.has_stalled(now_s));
        }
        again.find_doors(19.0, &[], &[3]);
        again.measure(21.9, &left(5.0, 5.0));
        assert!(!again.has_stalled(21.9) && again.has_stalled(24.0), "{again:?}");
    }

    #[test]
    fn who_was_carried_away_has_the_time_for_another_way() {
        let mut progress = MapProgress::from(0.0, 20.0);
        progress.measure(0.0, &left(5.0, 5.0));
        let mut again = MapProgress::from(100.0, 20.0);
        again.go_on(100.0, progress, false);
        let costs_m = (0..200).map(|step| 30.0 - 0.03 * f64::from(step));
        for (step, cost_m) in costs_m.enumerate() {
            let now_s = 100.0 + 0.1 * step as f64;
            again.measure(now_s, &left(cost_m, cost_m));
            assert!(!again.has_stalled(now_s), "{step}");
        }
    }

    #[test]
    fn a_door_that_opens_gives_the_patience_anew_and_one_found_closed_again_does_not() {
        let mut progress = MapProgress::from(0.0, 20.0);
        let mut stalls = |at_s: f64, before: &[usize], closed: &[usize], asked_s: f64| {
            progress.find_doors(at_s, before, closed);
            progress.measure(at_s, &WayLeft { avoided_doors: closed.to_vec(), ..left(5.0, 5.0) });
            progress.has_stalled(asked_s)
        };
        assert!(!stalls(10.0, &[], &[3], 29.0), "found closed for the first time");
        assert!(stalls(15.0, &[], &[3], 31.0), "forgotten, and found closed once more");
        assert!(!stalls(20.0, &[3], &[], 39.0), "open");
        assert!(stalls(25.0, &[], &[3], 41.0), "and closed again before the robot was there");
    }

    #[test]
    fn coming_a_little_nearer_to_a_closed_leaf_is_no_progress() {
        let stalled_s = |is_at_closed_door: bool| {
            let mut progress = MapProgress::from(0.0, 20.0);
            (0..600).map(f64::from).find(|&now_s| {
                let cost_m = 3.0 - 0.02 * now_s.min(50.0);
                progress.measure(now_s, &WayLeft { is_at_closed_door, ..left(cost_m, cost_m) });
                progress.has_stalled(now_s)
            })
        };
        assert_eq!(stalled_s(true), Some(21.0));
        assert!(stalled_s(false).is_some_and(|at_s| at_s > 60.0));
    }

    #[test]
    fn a_long_detour_has_its_time() {
        // For a minute it leads away from the goal by the map.
        let costs_m = |now_s: f64| (5.0 + 0.3 * now_s.min(120.0 - now_s), 36.0 - 0.3 * now_s);
        assert_eq!(stalls_at_s(119.0, costs_m), None);
    }

    #[test]
    fn going_to_and_fro_between_two_gaps_ends() {
        // Each time the robot comes to one of them, that is found closed too.
        let stalled_s = stalls_at_s(600.0, |now_s| (5.0, 8.0 - 0.3 * (now_s % 10.0)));
        assert!(stalled_s.is_some_and(|at_s| (60.0..120.0).contains(&at_s)), "{stalled_s:?}");
    }

    #[test]
    fn a_way_found_closed_does_not_undo_what_was_gained() {
        let mut around = AroundProgress::default();
        assert!(!around.shorten(5.0) && around.shorten(4.85));
        assert!(!around.shorten(9.0) && !around.shorten(9.05));
        assert!(around.shorten(8.88));
    }
}
