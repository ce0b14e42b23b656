//! Phrases to instructions.

use super::grammar::{Mention, Noun, Phrase, Place, Verb, phrases};
use super::words::{NAME, UNDERSTOOD, words};
use super::{Goal, Instruction};
use crate::feature::Feature;
use rpl_robot::file_text::{FileFaults, Finding, Findings};

/// Instructions from English, as people say them or in the event's own form: "leave the room to the left, take
/// the third left, go past the foyer, it's the second door on the right", "turn third left, enter second
/// right". Several sentences may follow each other; "after the foyer" may stand behind the opening it is about.
///
/// Whether one turns into an opening or enters it follows from what it is called; if that is not said, from
/// the verb; and if there is none, the last opening that is counted is entered, because it is a room that is
/// looked for. An opening without a number is the first.
///
/// Cost: linear.
///
/// # Errors
/// Everything that is not understood, each with its place and what would be.
pub fn parse(text: &str) -> Result<Vec<Instruction>, FileFaults> {
    let mut findings = Findings::default();
    let words = words(text, &mut findings);
    let phrases = phrases(&words, text.len());
    let last_opening = phrases.iter().rposition(|(phrase, _)| matches!(phrase, Phrase::Opening { .. }));
    let mut instructions = Vec::new();
    let mut faults = 0;
    for (at, &(phrase, place)) in phrases.iter().enumerate() {
        let place = place.into_range();
        let said = text[place.clone()].trim();
        match understood(phrase, last_opening == Some(at), &mut instructions) {
            Ok(()) => {}
            Err(Fault::Told) => faults += 1,
            Err(fault) => {
                faults += 1;
                findings.add(|| Finding::new(NAME, text, place, "", fault.message(said), fault.help()));
            }
        }
    }
    if instructions.is_empty() && faults == 0 {
        findings.add(|| Finding::new(NAME, text, 0..text.len(), "", "there is no instruction in it", UNDERSTOOD));
    }
    findings.or_value(Some(instructions))
}

/// Why a phrase is no instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    /// A word of it is none, which was told.
    Told,
    NoPhrase,
    LeaveWhere,
    WhichSide,
    EnterWhat,
    CountedAtEnd,
}

impl Fault {
    fn message(self, said: &str) -> String {
        match self {
            Self::Told | Self::NoPhrase => format!("`{said}` is no instruction"),
            Self::LeaveWhere => "it is not said to which side of the door the way goes on".to_owned(),
            Self::WhichSide => format!("it is not said on which side `{said}` is"),
            Self::EnterWhat => "it is not said which door is to be entered".to_owned(),
            Self::CountedAtEnd => format!("`{said}`: openings are counted from the beginning, not from the end"),
        }
    }

    fn help(self) -> &'static str {
        match self {
            Self::Told | Self::NoPhrase => UNDERSTOOD,
            Self::LeaveWhere => "write `leave the room to the left` or `to the right`",
            Self::WhichSide => "write `on the left` or `on the right`",
            Self::EnterWhat => "write, for instance, `enter the second door on the right`",
            Self::CountedAtEnd => "at the end of a hallway write `turn left` or `turn right`",
        }
    }
}

/// Adds what a phrase means to the instructions before it.
fn understood(phrase: Phrase, is_last_opening: bool, instructions: &mut Vec<Instruction>) -> Result<(), Fault> {
    match phrase {
        Phrase::Leave(side) => instructions.push(Instruction::Leave(side.ok_or(Fault::LeaveWhere)?)),
        Phrase::Foyer => instructions.push(Instruction::GoPastFoyer),
        Phrase::End => instructions.push(Instruction::GoHallwayEnd),
        Phrase::Straight => {}
        Phrase::Opening { verb, mention, place } => {
            let goal = goal(verb, mention, place, is_last_opening)?;
            instructions.extend(leading_to(place));
            instructions.push(goal.instruction());
        }
        Phrase::Enter => match instructions.last_mut() {
            Some(last) => *last = entered(*last).ok_or(Fault::EnterWhat)?,
            None => return Err(Fault::EnterWhat),
        },
        Phrase::Lost { told } => return Err(if told { Fault::Told } else { Fault::NoPhrase }),
    }
    Ok(())
}

fn goal(verb: Verb, mention: Mention, place: Place, is_last_opening: bool) -> Result<Goal, Fault> {
    let side = mention.side.ok_or(Fault::WhichSide)?;
    if place == Place::AtEnd && mention.ordinal.is_some_and(|ordinal| ordinal > 1) {
        return Err(Fault::CountedAtEnd);
    }
    let is_room = match (mention.noun, verb) {
        (Some(Noun::Door), _) => true,
        (Some(Noun::Hallway), _) => false,
        (Some(Noun::Opening) | None, Verb::Enter) => true,
        (Some(Noun::Opening) | None, Verb::Turn) => false,
        // "go left"
        (None, Verb::Unsaid) if mention.ordinal.is_none() => false,
        (Some(Noun::Opening) | None, Verb::Unsaid) => is_last_opening,
    };
    let kind = if is_room { Feature::OpenDoor } else { Feature::Hallway };
    Ok(Goal { ordinal: mention.ordinal.unwrap_or(1), side, kind })
}

/// What comes before an opening that is said to be there.
fn leading_to(place: Place) -> Option<Instruction> {
    match place {
        Place::InHallway => None,
        Place::AfterFoyer => Some(Instruction::GoPastFoyer),
        Place::AtEnd => Some(Instruction::GoHallwayEnd),
    }
}

/// "Take the third left and enter": what was taken for a hallway is a room.
fn entered(instruction: Instruction) -> Option<Instruction> {
    let goal = instruction.goal()?;
    Some(Goal { kind: Feature::OpenDoor, ..goal }.instruction())
}
