//! Whether an instruction is wrong, or something was missed: what LOLA could not tell (Gutierrez-Osuna and
//! Luo, "State-Set Progression": "there is no way to tell […] if this circumstance is the result of a faulty
//! instruction or an error in feature detection").

mod expectation;
mod reading;
mod sentence;
mod side;
mod spots;

pub use expectation::Expectation;
pub use reading::Reading;
pub use spots::Look;

use crate::feature::{Feature, Percept};
use crate::instruction::{Goal, MOST_ORDINAL};
use serde::{Deserialize, Serialize};
use side::{Nth, SideOfHallway};

/// What is wrong with an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FaultKind {
    /// The hallway ends before the opening that the instruction counts to.
    NoSuchOpening,
    /// The opening is of another kind.
    OtherKind,
}

impl FaultKind {
    /// As plans and tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::NoSuchOpening => "no-such-opening",
            Self::OtherKind => "other-kind",
        }
    }
}

/// What is to be done about an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// It is right, or nothing speaks against it yet.
    Right,
    /// It is wrong.
    Wrong(FaultKind),
    /// What was seen does not suffice: drive along the hallway again, in the other direction.
    LookAgain,
}

/// How likely an instruction is right, and in which way it is wrong, given what was seen; these three sum to 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judgement {
    /// The opening that was asked for.
    pub goal: Goal,
    /// That there is such an opening.
    pub right: f64,
    /// That there are fewer openings than the instruction counts.
    pub no_such_opening: f64,
    /// That it is of another kind.
    pub other_kind: f64,
    /// Where the opening that was asked for most likely is, if there is one and it was seen.
    pub at: Option<Percept>,
    /// What might have been meant, and where it is; the likeliest first. It sums to 1, if there is any.
    pub readings: Vec<Reading>,
    /// What was seen, in words: "the third left is a door; I saw hallways at the first and second".
    pub sentence: String,
    looks: usize,
    /// Whether the opening may be where no look has come.
    is_ahead: bool,
}

// The limits were chosen by drives along hallways of arenas, there and back, calm and crowded, so that few
// right instructions are called wrong where boxes hide doors. A robot that judges so rather asks
// back than look for what may not be there.

/// Below this an instruction is called wrong after a second look: a third would not save it.
const WRONG_BELOW: f64 = 0.05;

/// Below this an instruction is doubted, so that another look is worth its time.
const DOUBTED_BELOW: f64 = 0.9;

/// Below this an instruction is called wrong when no other look is worth its time.
const WRONG_AT_LAST: f64 = 0.8;

/// The same, and the limit of doubt, where the end of the hallway was not reached: what is ahead may be right.
const WRONG_UNDER_WAY: f64 = 0.5;

/// Whoever walked beside the robot hid what he passed, so no instruction is called wrong after one look. The second
/// begins beside what is at the end of the hallway and does not see it well; the third does. More see what these saw.
const MOST_LOOKS: usize = 3;

/// What is less likely there is not gone to.
const LEAST_READING: f64 = 0.25;

impl Judgement {
    /// Judges an instruction by everything that was seen in the hallway, which ends at `end_m` if that is
    /// known. Cost: spots, times the square of the ordinal.
    #[must_use]
    pub fn of(goal: Goal, looks: &[Look], end_m: Option<f64>, expectation: &Expectation) -> Self {
        let side = SideOfHallway::new(expectation, looks, end_m, goal.side);
        let nth = side.nth(usize::from(goal.ordinal));
        let unseen = side.nth_unseen(usize::from(goal.ordinal));
        let (right, none, other) = probabilities(goal, &nth, &unseen, expectation.wrong);
        let readings = readings(goal, looks, end_m, expectation);
        Self {
            goal,
            right,
            no_such_opening: none,
            other_kind: other,
            at: nth.at(goal.kind).filter(|(_, mass)| *mass > 0.5 * nth.of_kind(goal.kind)).map(|(percept, _)| percept),
            sentence: sentence::sentence(goal, &nth, &side, readings.first()),
            readings,
            looks: looks.len(),
            is_ahead: end_m.is_none(),
        }
    }

    /// What is to be done.
    pub fn verdict(&self) -> Verdict {
        let wrong_below = if self.is_ahead { WRONG_UNDER_WAY } else { WRONG_AT_LAST };
        if self.needs_another_look() {
            Verdict::LookAgain
        } else if self.right < wrong_below {
            Verdict::Wrong(self.likeliest_fault())
        } else {
            Verdict::Right
        }
    }

    /// Whether it is neither right nor wrong beyond doubt, and another look may tell.
    pub fn needs_another_look(&self) -> bool {
        let doubted_below = if self.is_ahead { WRONG_UNDER_WAY } else { DOUBTED_BELOW };
        let wrong_below = if self.looks < 2 { 0.0 } else { WRONG_BELOW };
        self.looks < MOST_LOOKS && (wrong_below..doubted_below).contains(&self.right)
    }

    /// That the instruction is wrong.
    pub fn wrong(&self) -> f64 {
        1.0 - self.right
    }

    /// What is wrong, if anything is.
    pub fn likeliest_fault(&self) -> FaultKind {
        if self.no_such_opening >= self.other_kind { FaultKind::NoSuchOpening } else { FaultKind::OtherKind }
    }

    /// That it is wrong, and the other side is meant.
    pub fn other_side(&self) -> f64 {
        let mirrored = self.readings.iter().filter(|reading| reading.goal.side != self.goal.side);
        self.wrong() * mirrored.map(|reading| reading.probability).sum::<f64>()
    }

    /// What most likely was meant.
    pub fn likeliest_reading(&self) -> Option<Reading> {
        self.readings.first().copied()
    }
}

/// That the instruction is right, that there is no such opening, and that it is of another kind (Bayes): what
/// was seen is judged under each, so that a long hallway in which the fifth opening is no wonder does not
/// speak for the instruction. What is still ahead speaks neither for it nor against.
fn probabilities(goal: Goal, nth: &Nth, unseen: &Nth, wrong: f64) -> (f64, f64, f64) {
    let share = unseen.of_kind(goal.kind) / unseen.some();
    let is_right = |nth: &Nth| nth.of_kind(goal.kind) + nth.ahead * share;
    let right = (1.0 - wrong) * is_right(nth) / is_right(unseen);
    let scale = wrong / (1.0 - is_right(unseen));
    let none = scale * nth.none;
    let other = scale * (nth.some() + nth.ahead - is_right(nth));
    let sum = right + none + other;
    (right / sum, none / sum, other / sum)
}

/// What might have been meant, by how likely people err so: a number by one more often than by two, one side
/// for the other, a hallway for a door. Only what was seen is gone to.
fn readings(goal: Goal, looks: &[Look], end_m: Option<f64>, expectation: &Expectation) -> Vec<Reading> {
    let mut readings = Vec::new();
    for (other, weight) in mistakes(goal) {
        let side = SideOfHallway::new(expectation, looks, end_m, other.side);
        let nth = side.nth(usize::from(other.ordinal));
        if let Some((at, certainty)) = nth.at(other.kind).filter(|(_, certainty)| *certainty > LEAST_READING) {
            readings.push(Reading { goal: other, at, probability: weight * certainty });
        }
    }
    let sum: f64 = readings.iter().map(|reading| reading.probability).sum();
    readings.iter_mut().for_each(|reading| reading.probability /= sum);
    readings.sort_by(|a, b| b.probability.total_cmp(&a.probability));
    readings
}

/// Other openings that might be meant, and how often.
fn mistakes(goal: Goal) -> Vec<(Goal, f64)> {
    let other_kind = if goal.kind == Feature::Hallway { Feature::OpenDoor } else { Feature::Hallway };
    let mut mistakes = vec![(Goal { side: goal.side.other(), ..goal }, 0.3), (Goal { kind: other_kind, ..goal }, 0.2)];
    for ordinal in 1..=MOST_ORDINAL {
        let apart = ordinal.abs_diff(goal.ordinal);
        if apart > 0 {
            mistakes.push((Goal { ordinal, ..goal }, 0.5 / f64::from(1u32 << u32::from(apart).min(20))));
        }
    }
    mistakes
}
