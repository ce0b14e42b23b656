//! Errors in instructions, "such as directing the robot toward a nonexistent hallway or room" (Gutierrez-Osuna
//! and Luo, first page).

use super::floor_plan::FloorPlan;
use super::route::{Route, Standpoint, Step};
use crate::feature::Feature;
use crate::instruction::{Instruction, MOST_ORDINAL};
use rpl_random::Stream;
use serde::{Deserialize, Serialize};

/// What was done to an instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum FaultKind {
    /// It names an opening that does not exist: there are fewer.
    NoSuchOpening,
    /// It names an opening of another kind.
    AnotherKind,
    /// It names the other side.
    OtherSide,
    /// It counts one too many or one too few.
    OrdinalOff,
}

impl FaultKind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::NoSuchOpening, Self::AnotherKind, Self::OtherSide, Self::OrdinalOff];
}

/// What somebody who counts right finds of a wrong instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Finding {
    /// There are fewer openings on that side.
    NoSuchOpening,
    /// It is one of another kind.
    AnotherKind(Feature),
    /// It is an opening of the right kind, though not the one that was meant: nobody can find that fault where
    /// it is.
    Nothing,
}

/// A wrong instruction in a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fault {
    /// Which of the list, from 1; the leaving is the first.
    pub number: usize,
    /// What was done to it.
    pub kind: FaultKind,
    /// What it says.
    pub given: Instruction,
    /// What it should say.
    pub right: Instruction,
    /// What can be found of it.
    pub finding: Finding,
}

impl Fault {
    /// Whether somebody who counts right would find it.
    pub fn is_detectable(&self) -> bool {
        self.finding != Finding::Nothing
    }

    /// An error in one of the instructions that name an opening. The last of a list always does, and can name
    /// the other side, so that there is one of some kind.
    pub(super) fn draw(stream: &mut Stream, plan: &FloorPlan, route: &Route) -> Self {
        loop {
            let wrong = Self::all(plan, route, FaultKind::ALL[stream.index(FaultKind::ALL.len())]);
            if !wrong.is_empty() {
                return wrong[stream.index(wrong.len())];
            }
        }
    }

    /// Every error of a kind that can be made in a route.
    fn all(plan: &FloorPlan, route: &Route, kind: FaultKind) -> Vec<Self> {
        let steps = route.instructions.iter().copied().enumerate().skip(1).zip(&route.standpoints);
        let wrong = steps.flat_map(|((index, right), at)| {
            wrong(plan, *at, right, kind).into_iter().map(move |given| {
                let finding = match plan.step(*at, given) {
                    Step::NoSuchOpening => Finding::NoSuchOpening,
                    Step::AnotherKind(found) => Finding::AnotherKind(found),
                    Step::To(_) | Step::Into(_) => Finding::Nothing,
                };
                Self { number: index + 1, kind, given, right, finding }
            })
        });
        wrong.collect()
    }
}

/// What an instruction can be changed to by an error of a kind.
fn wrong(plan: &FloorPlan, at: Standpoint, right: Instruction, kind: FaultKind) -> Vec<Instruction> {
    let (ordinal, side) = match right {
        Instruction::Turn { ordinal, side } | Instruction::Enter { ordinal, side } => (ordinal, side),
        Instruction::Leave(_) | Instruction::GoPastFoyer | Instruction::GoHallwayEnd => return Vec::new(),
    };
    let counted = |ordinal| match right {
        Instruction::Turn { .. } => Instruction::Turn { ordinal, side },
        _ => Instruction::Enter { ordinal, side },
    };
    let ordinals = (1..=MOST_ORDINAL).map(counted);
    match kind {
        FaultKind::NoSuchOpening => {
            ordinals.filter(|given| plan.step(at, *given) == Step::NoSuchOpening).take(1).collect()
        }
        FaultKind::AnotherKind => {
            ordinals.filter(|given| matches!(plan.step(at, *given), Step::AnotherKind(_))).collect()
        }
        FaultKind::OtherSide => vec![match right {
            Instruction::Turn { .. } => Instruction::Turn { ordinal, side: side.other() },
            _ => Instruction::Enter { ordinal, side: side.other() },
        }],
        FaultKind::OrdinalOff => {
            let off = [ordinal.checked_sub(1), ordinal.checked_add(1)].into_iter().flatten();
            off.filter(|ordinal| (1..=MOST_ORDINAL).contains(ordinal)).map(counted).collect()
        }
    }
}
