//! Instructions in words.

use proptest::prelude::*;
use rpl_lola::feature::Side;
use rpl_lola::instruction::{Instruction, MOST_ORDINAL, parse};

/// What people say, and what it means, said back.
const SENTENCES: [(&str, &str); 64] = [
    // The event's own form.
    ("turn third left", "take the third left"),
    ("enter second right", "enter the second door on the right"),
    ("go hallway end", "go to the end of the hallway"),
    ("go past foyer", "go past the foyer"),
    ("leave left", "leave the room to the left"),
    (
        "turn third left, go past foyer, enter second right",
        "take the third left; go past the foyer; enter the second door on the right",
    ),
    (
        "TURN FIRST RIGHT; GO HALLWAY END; TURN FIRST LEFT; ENTER TENTH LEFT",
        "take the first right; go to the end of the hallway; take the first left; enter the tenth door on the left",
    ),
    (
        "turn third left enter second right go hallway end go past foyer",
        "take the third left; enter the second door on the right; go to the end of the hallway; go past the foyer",
    ),
    // To turn.
    ("take the third left", "take the third left"),
    ("take the 3rd left", "take the third left"),
    ("take the 2nd right, please", "take the second right"),
    ("turn left", "take the first left"),
    ("take the next right", "take the first right"),
    ("take the fifth hallway on the left", "take the fifth left"),
    ("take the second turn on the right", "take the second right"),
    ("turn into the second corridor on your right", "take the second right"),
    ("turn right at the third opening", "take the third right"),
    ("turn left into the second corridor", "take the second left"),
    ("make a left at the second opening", "take the second left"),
    ("go left", "take the first left"),
    ("go down the third corridor on the left", "take the third left"),
    ("take the corridor on the left", "take the first left"),
    ("follow the hallway until you reach the second corridor on the right", "take the second right"),
    (
        "left, then right, then the third door on the left",
        "take the first left; take the first right; enter the third door on the left",
    ),
    // To enter.
    ("it's the second door on the right", "enter the second door on the right"),
    ("it’s the second left", "enter the second door on the left"),
    ("enter the second left", "enter the second door on the left"),
    ("go into the fourth room on the left", "enter the fourth door on the left"),
    ("go through the second door on the left", "enter the second door on the left"),
    ("the next door on your left", "enter the first door on the left"),
    ("the sixth right-hand door", "enter the sixth door on the right"),
    ("on the left the second door", "enter the second door on the left"),
    ("on your right, the second door", "enter the second door on the right"),
    ("door number 3 on the left", "enter the third door on the left"),
    ("it is the room on the left", "enter the first door on the left"),
    ("the room is the next door on the right", "enter the first door on the right"),
    ("you'll find it behind the third door on the left", "enter the third door on the left"),
    ("the second office on the left is your destination", "enter the second door on the left"),
    ("walk down the corridor until you reach the third door on the right", "enter the third door on the right"),
    ("take the third left and enter", "enter the third door on the left"),
    // What is not called anything is a room if it comes last.
    ("third left, second right", "take the third left; enter the second door on the right"),
    ("turn left, second door on the right", "take the first left; enter the second door on the right"),
    // Foyers.
    ("go past the lobby", "go past the foyer"),
    ("walk through the foyer", "go past the foyer"),
    ("cross the foyer and turn right", "go past the foyer; take the first right"),
    ("after the foyer, take the next left", "go past the foyer; take the first left"),
    ("take the second left after the foyer", "go past the foyer; take the second left"),
    ("it's the third door on the left past the lobby", "go past the foyer; enter the third door on the left"),
    ("once you've passed the foyer, take the first right", "go past the foyer; take the first right"),
    ("continue down the hall past the lobby to the end", "go past the foyer; go to the end of the hallway"),
    // Ends.
    ("go to the end of the hallway", "go to the end of the hallway"),
    ("straight on to the end of the corridor", "go to the end of the hallway"),
    ("at the end of the hall turn left", "go to the end of the hallway; take the first left"),
    ("turn right at the end of the passage", "go to the end of the hallway; take the first right"),
    ("follow the corridor to its end", "go to the end of the hallway"),
    // To leave.
    ("leave the room to the left", "leave the room to the left"),
    ("go out of the room to the right", "leave the room to the right"),
    ("when you leave the room, turn left", "leave the room to the left"),
    ("turn right out of your office", "leave the room to the right"),
    ("exit the room and go right along the hallway", "leave the room to the right"),
    // Whole ways.
    (
        "take the third left, go past the foyer, it's the second door on the right",
        "take the third left; go past the foyer; enter the second door on the right",
    ),
    (
        "Leave the room and turn right. Take the 2nd left.\nEnter the first door on your right.",
        "leave the room to the right; take the second left; enter the first door on the right",
    ),
    (
        "Leave your office to the right, walk to the end of the corridor and turn left; it's the fourth door on your \
         right-hand side.",
        "leave the room to the right; go to the end of the hallway; take the first left; enter the fourth door on the \
         right",
    ),
    (
        "please take the second right; then keep going straight until the end of the hallway, and the room is the \
         third door on the left",
        "take the second right; go to the end of the hallway; enter the third door on the left",
    ),
];

/// What cannot be followed, the place that is marked, and what is said of it.
const REFUSED: [(&str, &str, &str); 32] = [
    ("", "", "there is no instruction in it"),
    ("…", "…", "`…` is not understood"),
    ("the", "the", "there is no instruction in it"),
    ("go straight on", "go straight on", "there is no instruction in it"),
    ("it's the last door", "last", "`last` is not understood"),
    ("turn left at the lift", "lift", "`lift` is not understood"),
    ("go up the stairs", "stairs", "`stairs` is not understood"),
    ("take the eleventh left", "eleventh", "`eleventh` is not understood"),
    ("take the 0th left", "0th", "`0th` is not understood"),
    ("take the 99999999999999999999th left", "99999999999999999999th", "`99999999999999999999th` is not understood"),
    ("the third door", "third door", "it is not said on which side `third door` is"),
    ("turn second", "turn second", "it is not said on which side `turn second` is"),
    ("enter third", "enter third", "it is not said on which side `enter third` is"),
    ("go back", "back", "`back` is not understood"),
    ("turn around", "around", "`around` is not understood"),
    ("go north", "north", "`north` is not understood"),
    ("turn", "turn", "`turn` is no instruction"),
    ("go past", "go past", "`go past` is no instruction"),
    ("take the door", "take the door", "`take the door` is no instruction"),
    ("enter the room", "enter the room", "it is not said which door is to be entered"),
    ("go past the foyer and enter", "enter", "it is not said which door is to be entered"),
    ("leave the room", "leave the room", "it is not said to which side of the door the way goes on"),
    (
        "leave the room, take the third left",
        "leave the room",
        "it is not said to which side of the door the way goes on",
    ),
    ("take the third left or the fourth", "or", "`or` is not understood"),
    ("don't turn left", "don't", "`don't` is not understood"),
    ("turn left left", "turn left left", "`turn left left` is no instruction"),
    (
        "the third left at the end",
        "third left at the end",
        "`third left at the end`: openings are counted from the beginning, not from the end",
    ),
    ("take the scond left", "scond", "`scond` is not understood"),
    ("turn left before the foyer", "before", "`before` is not understood"),
    ("turn left when you see the plant", "plant", "`plant` is not understood"),
    ("go 5 metres", "metres", "`metres` is not understood"),
    ("room 214", "214", "`214` is not understood"),
];

fn said(instructions: &[Instruction]) -> String {
    instructions.iter().map(Instruction::to_string).collect::<Vec<_>>().join("; ")
}

#[test]
fn sentences_are_understood_as_they_are_meant() {
    for (sentence, meaning) in SENTENCES {
        let understood = parse(sentence).map(|list| said(&list)).unwrap_or_else(|faults| faults.to_string());
        assert_eq!(understood, meaning, "{sentence}");
    }
}

#[test]
fn what_cannot_be_followed_is_told_with_its_place() {
    for (sentence, marked, message) in REFUSED {
        let faults = parse(sentence).expect_err(sentence).findings;
        assert_eq!(faults.len(), 1, "{sentence}: {faults:?}");
        assert!(
            faults[0].message.starts_with(message) || faults[0].message.ends_with(message),
            "{sentence}: {}",
            faults[0]
        );
        let place = &faults[0].source_line
            [faults[0].source_line.char_indices().nth(faults[0].before_mark).map_or(0, |(at, _)| at)..];
        let place: String = place.chars().take(faults[0].marked).collect();
        assert_eq!(place, marked, "{sentence}");
        assert!(!faults[0].help.is_empty(), "{sentence}");
    }
}

#[test]
fn all_faults_are_told_at_once_with_what_would_be_right() {
    let faults =
        parse("take the scond lft,\nthen leave the room. It's the third door on the right").expect_err("faults");
    assert_eq!(
        faults.to_string(),
        "instructions:1:10: `scond` is not understood\n  1 | take the scond lft,\n    |          ^^^^^\n    = did you mean \
         `second`?\n\n\
         instructions:1:16: `lft` is not understood\n  1 | take the scond lft,\n    |                ^^^\n    = did you mean \
         `left`?\n\n\
         instructions:2:6: it is not said to which side of the door the way goes on\n  2 | then leave the room. It's the \
         third door on the right\n    |      ^^^^^^^^^^^^^^\n    = write `leave the room to the left` or `to the right`"
    );
}

#[test]
fn every_instruction_said_back_is_understood_as_itself() {
    let sides = Side::ALL.into_iter().flat_map(|side| {
        let counted = (1..=MOST_ORDINAL)
            .flat_map(move |ordinal| [Instruction::Turn { ordinal, side }, Instruction::Enter { ordinal, side }]);
        counted.chain([Instruction::Leave(side)])
    });
    let all: Vec<Instruction> = sides.chain([Instruction::GoPastFoyer, Instruction::GoHallwayEnd]).collect();
    for instruction in &all {
        assert_eq!(parse(&instruction.to_string()), Ok(vec![*instruction]));
    }
    assert_eq!(parse(&said(&all)), Ok(all));
}

#[test]
fn a_text_of_any_length_is_read_once() {
    let text = "take the third left, ".repeat(20_000);
    assert_eq!(parse(&text).map(|list| list.len()), Ok(20_000));
    let faults = parse(&"plugh ".repeat(20_000)).expect_err("unknown");
    assert_eq!(faults.findings.len() + faults.more, 20_000);
}

proptest! {
    #[test]
    fn no_text_brings_the_reader_down(words in prop::collection::vec("(turn|enter|left|right|third|foyer|end|past|it's|,|the|door|hallway|room|leave|go|until|\\PC{0,3})", 0..12)) {
        if let Ok(list) = parse(&words.join(" ")) {
            prop_assert!(!list.is_empty());
        }
    }
}
