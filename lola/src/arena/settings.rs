//! What kinds of arenas there are.

use super::interval::Millimetres;

/// What kind of arena is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ArenaSettings {
    /// How thick walls are. A closed door stands in the middle, so that thin walls show little of it.
    pub walls_mm: Millimetres,
    /// Whether boxes stand in the hallways.
    pub boxes: bool,
    /// How many people walk about.
    pub people: usize,
    /// Whether a coloured marker lies on the floor before each door.
    pub markers: bool,
}

impl ArenaSettings {
    /// Nobody and nothing in the hallways, walls as in other worlds, no markers.
    pub const CALM: Self = Self { walls_mm: 150, boxes: false, people: 0, markers: false };

    /// The same with six people, and with boxes in the hallways.
    pub const CROWDED: Self = Self { boxes: true, people: 6, ..Self::CALM };

    /// The same as calm with a marker before each door.
    pub const MARKED: Self = Self { markers: true, ..Self::CALM };

    /// The settings of an arena that has a name among worlds.
    pub fn named(name: &str) -> Option<Self> {
        ARENAS.iter().find(|(known, ..)| *known == name).map(|(.., settings)| *settings)
    }
}

/// The arenas that have names among worlds, each with what it is in a sentence.
pub const ARENAS: [(&str, &str, ArenaSettings); 3] = [
    ("arena", "An office to find a room in by instructions, another one for each seed.", ArenaSettings::CALM),
    ("arena-crowded", "The same with six people, and boxes in the hallways.", ArenaSettings::CROWDED),
    ("arena-marked", "`arena` with a coloured marker before each door, for a camera.", ArenaSettings::MARKED),
];
