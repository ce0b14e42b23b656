//! Instructions said back in words.

use super::{Goal, Instruction};
use crate::feature::{Feature, Side};
use std::fmt;

/// "first" for 1; up to the tenth.
pub(super) const ORDINALS: [&str; 10] =
    ["first", "second", "third", "fourth", "fifth", "sixth", "seventh", "eighth", "ninth", "tenth"];

/// The nth, in words: "third".
pub fn ordinal_in_words(ordinal: u8) -> &'static str {
    let at = usize::from(ordinal.max(1)) - 1;
    ORDINALS.get(at).copied().unwrap_or("so-manieth")
}

impl Side {
    /// As people say it.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
        }
    }
}

impl Feature {
    /// One of them, as people say it.
    pub fn in_words(self) -> &'static str {
        match self {
            Self::Wall => "a wall",
            Self::ClosedDoor => "a closed door",
            Self::OpenDoor => "a door",
            Self::Hallway => "a hallway",
            Self::Foyer => "a foyer",
        }
    }

    /// Several of them, as people say it.
    pub fn several_in_words(self) -> &'static str {
        match self {
            Self::Wall => "walls",
            Self::ClosedDoor => "closed doors",
            Self::OpenDoor => "doors",
            Self::Hallway => "hallways",
            Self::Foyer => "foyers",
        }
    }
}

/// "the third left" for a hallway, "the second door on the right" for a door.
impl fmt::Display for Goal {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (ordinal, side) = (ordinal_in_words(self.ordinal), self.side.in_words());
        match self.instruction() {
            Instruction::Enter { .. } => write!(out, "the {ordinal} door on the {side}"),
            _ => write!(out, "the {ordinal} {side}"),
        }
    }
}

/// In words which [`parse`](super::parse) reads as the same instruction: "take the third left".
impl fmt::Display for Instruction {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self, self.goal()) {
            (Self::Turn { .. }, Some(goal)) => write!(out, "take {goal}"),
            (Self::Enter { .. }, Some(goal)) => write!(out, "enter {goal}"),
            (Self::Leave(side), _) => write!(out, "leave the room to the {}", side.in_words()),
            (Self::GoPastFoyer, _) => out.write_str("go past the foyer"),
            _ => out.write_str("go to the end of the hallway"),
        }
    }
}
