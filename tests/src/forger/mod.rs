//! Forged inputs of the command: worlds, maps, images, logs, traces, parameters and command lines that
//! somebody made wrong, and what must hold whatever they are.
//!
//! [`worlds`], [`images`], [`recordings`] and [`command_lines`] write a case from a seed, [`judge`]
//! runs it as a child process with little memory and time.

pub mod command_lines;
pub mod images;
pub mod judge;
pub mod mangle;
pub mod recordings;
pub mod worlds;

use crate::generated::Dice;

/// What stands under a name in the folder of a case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Content {
    /// These bytes.
    Bytes(Vec<u8>),
    /// A link to this path.
    Link(&'static str),
    /// A folder.
    Folder,
    /// A pipe that never ends.
    EndlessPipe,
}

/// What the command may say to a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Expected {
    /// It may be right after all.
    Anything,
    /// It is refused: exit status 2.
    Refused,
}

/// Files, and what is typed where they are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Case {
    /// Which forger wrote it.
    pub kind: &'static str,
    /// Names and what is there.
    pub files: Vec<(String, Content)>,
    /// The arguments of the command.
    pub arguments: Vec<String>,
    /// What it may say.
    pub expected: Expected,
}

type Forger = fn(&mut Dice) -> Case;

/// The forgers, one after the other by the seed.
const FORGERS: [Forger; 10] = [
    worlds::mangled,
    images::map_file,
    recordings::log,
    images::pgm,
    worlds::full,
    images::png,
    recordings::trace,
    command_lines::typed,
    recordings::parameters,
    images::no_file,
];

impl Case {
    /// The case of a seed.
    pub fn new(seed: u64) -> Self {
        let forger = FORGERS[(seed % FORGERS.len() as u64) as usize];
        forger(&mut Dice::new(seed))
    }
}

/// Arguments from words.
fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(str::to_string).collect()
}

fn text(name: &str, text: impl Into<Vec<u8>>) -> (String, Content) {
    (name.to_string(), Content::Bytes(text.into()))
}

/// A plan that ends at once.
fn plan() -> (String, Content) {
    text("plan.rpl", "(wait-time 0.2)\n")
}
