//! A text in words, each with its meaning.

use super::MOST_ORDINAL;
use super::said::ORDINALS;
use crate::feature::Side;
use chumsky::span::SimpleSpan;
use logos::Logos;
use rpl_lang::suggest::suggest;
use rpl_robot::file_text::{Finding, Findings};

/// What a word means in instructions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    Go,
    Turn,
    Enter,
    Leave,
    Pass,
    Is,
    Out,
    In,
    Through,
    Past,
    After,
    Until,
    Reach,
    Straight,
    Next,
    Ordinal(u8),
    Side(Side),
    Door,
    Room,
    Hallway,
    Opening,
    Foyer,
    End,
    /// Between two instructions: "then", "and", a comma, the end of a sentence.
    Then,
    /// Carries nothing: "the", "please".
    Empty,
    /// None of these, which was told.
    Unknown,
}

/// Every word but ordinals. British and American ones stand side by side.
const VOCABULARY: [(Word, &[&str]); 23] = [
    (
        Word::Go,
        &[
            "go",
            "going",
            "walk",
            "walking",
            "drive",
            "driving",
            "continue",
            "head",
            "keep",
            "keeping",
            "move",
            "proceed",
            "carry",
            "follow",
            "following",
            "come",
            "run",
            "roll",
            "travel",
            "get",
        ],
    ),
    (Word::Turn, &["turn", "turning", "take", "taking", "make", "bear", "swing"]),
    (Word::Enter, &["enter", "entering", "visit"]),
    (Word::Leave, &["leave", "leaving", "exit", "exiting"]),
    (Word::Pass, &["pass", "passing", "passed", "cross", "crossing"]),
    (Word::Is, &["is", "it's", "that's", "be", "find", "there's"]),
    (Word::Out, &["out", "outside"]),
    (Word::In, &["in", "into", "inside"]),
    (Word::Through, &["through"]),
    (Word::Past, &["past", "beyond"]),
    (Word::After, &["after", "behind"]),
    (Word::Until, &["until", "till"]),
    (Word::Reach, &["reach", "reaching", "see", "arrive"]),
    (
        Word::Straight,
        &["straight", "ahead", "along", "down", "up", "forward", "forwards", "onward", "onwards", "all", "way"],
    ),
    (Word::Next, &["next"]),
    (Word::Door, &["door", "doorway"]),
    (Word::Room, &["room", "office", "destination", "goal"]),
    (Word::Hallway, &["hallway", "hall", "corridor", "passage", "passageway"]),
    (Word::Opening, &["opening"]),
    (Word::Foyer, &["foyer", "lobby"]),
    (Word::End, &["end"]),
    (Word::Then, &["then", "and", "afterwards", "afterward", "finally"]),
    (
        Word::Empty,
        &[
            "the", "a", "an", "your", "my", "its", "this", "that", "it", "you", "you'll", "you're", "you've", "will",
            "are", "have", "please", "of", "on", "to", "at", "by", "from", "hand", "side", "one", "just", "simply",
            "again", "when", "once", "there", "where", "number", "i", "we", "want", "must", "should", "need", "now",
        ],
    ),
];

/// Words people use that no instruction can be made of, and why.
const REFUSED: [(&[&str], &str); 7] = [
    (
        &["last", "final"],
        "which opening is the last one is known only when the hallway ends: say the how-manieth it is",
    ),
    (&["lift", "elevator", "stairs", "staircase", "upstairs", "downstairs", "floor"], "there is one floor only"),
    (&["not", "don't", "no", "never", "without"], "say what to do, not what to leave"),
    (&["or", "maybe", "perhaps", "about"], "say one way, and which"),
    (&["back", "around", "round", "reverse", "return"], "instructions only lead on"),
    (&["north", "south", "east", "west"], "there is no compass: say `left` or `right`"),
    (&["metre", "metres", "meter", "meters", "feet", "steps"], "distances mean nothing here: count openings"),
];

/// What can be said, for advice.
pub(super) const UNDERSTOOD: &str = "understood are `leave the room to the left`, `take the third left`, `the second \
                                     door on the right`, `go past the foyer` and `go to the end of the hallway`";

#[derive(Logos, Clone, Copy, Debug, PartialEq)]
#[logos(skip r"[\t\x0c\r \-–]+")]
enum Piece {
    #[regex(r"[\p{L}\p{N}]+(['’][\p{L}\p{N}]+)*")]
    Word,
    #[regex(r"[,.;:!\n—]+")]
    Break,
}

/// The words of a text that carry something, with their places in bytes; what is no word of instructions is
/// told. Cost: linear.
pub(super) fn words(text: &str, findings: &mut Findings) -> Vec<(Word, SimpleSpan)> {
    let mut words: Vec<(Word, SimpleSpan)> = Vec::new();
    for (piece, span) in Piece::lexer(text).spanned() {
        let written = &text[span.clone()];
        let word = match piece {
            Ok(Piece::Break) => Ok(Word::Then),
            Ok(Piece::Word) => word(&written.to_lowercase().replace('’', "'")),
            Err(()) => Err("it has no meaning in instructions".to_owned()),
        };
        match word {
            Ok(Word::Empty) => {}
            // "the second turn on the left"
            Ok(Word::Turn) if words.last().is_some_and(|(before, _)| counts(*before)) => {
                words.push((Word::Opening, span.into()));
            }
            Ok(word) => words.push((word, span.into())),
            Err(help) => {
                words.push((Word::Unknown, span.clone().into()));
                findings.add(|| Finding::new(NAME, text, span, "", format!("`{written}` is not understood"), help));
            }
        }
    }
    words
}

/// As findings call the text.
pub(super) const NAME: &str = "instructions";

fn counts(word: Word) -> bool {
    matches!(word, Word::Ordinal(_) | Word::Next)
}

/// # Errors
/// Advice, if it is none.
fn word(written: &str) -> Result<Word, String> {
    if let Some(ordinal) = ordinal(written) {
        let counted = u8::try_from(ordinal).ok().filter(|ordinal| (1..=MOST_ORDINAL).contains(ordinal));
        let help = || format!("openings are counted from the first to the {}", ORDINALS[ORDINALS.len() - 1]);
        return counted.map(Word::Ordinal).ok_or_else(help);
    }
    match written {
        "left" | "lefthand" => return Ok(Word::Side(Side::Left)),
        "right" | "righthand" => return Ok(Word::Side(Side::Right)),
        _ => {}
    }
    let stem = written.strip_suffix("'s").unwrap_or(written);
    let is_known = |known: &[&str]| known.contains(&written) || known.contains(&stem);
    let known = VOCABULARY.iter().find(|(_, known)| is_known(known));
    known.map(|(word, _)| *word).ok_or_else(|| advice(written))
}

/// What to write for a word that is none.
fn advice(written: &str) -> String {
    if let Some((_, why)) = REFUSED.iter().find(|(refused, _)| refused.contains(&written)) {
        return (*why).to_owned();
    }
    let known = VOCABULARY.iter().flat_map(|(_, words)| words.iter().copied()).chain(["left", "right"]).chain(ORDINALS);
    match suggest(written, known) {
        Some(near) => format!("did you mean `{near}`?"),
        None => UNDERSTOOD.to_owned(),
    }
}

/// A number in words or digits, as an ordinal: `third`, `3rd`, `3`.
fn ordinal(written: &str) -> Option<u64> {
    const BEYOND: [&str; 10] = [
        "eleventh",
        "twelfth",
        "thirteenth",
        "fourteenth",
        "fifteenth",
        "sixteenth",
        "seventeenth",
        "eighteenth",
        "nineteenth",
        "twentieth",
    ];
    let in_words = ORDINALS.iter().chain(&BEYOND).zip(1..).find(|(known, _)| **known == written);
    let digits = ["st", "nd", "rd", "th"].iter().find_map(|ending| written.strip_suffix(ending)).unwrap_or(written);
    let is_number = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
    in_words.map(|(_, number)| number).or_else(|| is_number.then(|| digits.parse().unwrap_or(u64::MAX)))
}
