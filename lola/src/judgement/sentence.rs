//! What was seen, in words.

use super::reading::Reading;
use super::side::{Nth, SideOfHallway};
use super::spots::Spot;
use crate::feature::{Feature, Side};
use crate::instruction::{Goal, MOST_ORDINAL, ordinal_in_words};

/// What was seen of an instruction's goal: "the third left is a door; I saw hallways at the first and second",
/// "there is no fourth left; I saw doors at the first and third, and a hallway at the second".
pub(super) fn sentence(goal: Goal, nth: &Nth, side: &SideOfHallway<'_>, reading: Option<&Reading>) -> String {
    let name = format!("{} {}", ordinal_in_words(goal.ordinal), goal.side.in_words());
    let is_none = nth.none > nth.some();
    let what = match is_none {
        true => format!("there is no {name}"),
        false => format!("the {name} is {}", nth.likeliest_kind().in_words()),
    };
    let mirrored = reading.filter(|reading| reading.goal.side != goal.side).map(|reading| reading.goal);
    let mirrored = mirrored.map(|Goal { ordinal, side, kind }| {
        format!(", but the {} {} is {}", ordinal_in_words(ordinal), side.in_words(), kind.in_words())
    });
    let before = if is_none { usize::MAX } else { usize::from(goal.ordinal) - 1 };
    let seen = seen_in_words(&openings(side), before, goal.side);
    [what, mirrored.unwrap_or_default(), seen].concat()
}

/// What each opening of a side most likely is, in order, as they are counted.
fn openings(side: &SideOfHallway<'_>) -> Vec<Feature> {
    let likeliest = |spot: &Spot| {
        let weights = side.weights(spot);
        let heavier =
            |best: Feature, other: Feature| if weights[other as usize] > weights[best as usize] { other } else { best };
        Feature::ALL.into_iter().fold(Feature::Wall, heavier)
    };
    side.spots.iter().map(likeliest).filter(|kind| Feature::OPENINGS.contains(kind)).collect()
}

/// "; I saw a door at the first, and hallways at the second and third", of at most `most` openings.
fn seen_in_words(openings: &[Feature], most: usize, side: Side) -> String {
    let of_kind = |kind: Feature| {
        let numbered = openings.iter().zip(1u8..=MOST_ORDINAL).take(most);
        let at: Vec<&str> =
            numbered.filter(|(seen, _)| **seen == kind).map(|(_, number)| ordinal_in_words(number)).collect();
        let what = if at.len() == 1 { kind.in_words().to_owned() } else { kind.several_in_words().to_owned() };
        (!at.is_empty()).then(|| format!("{what} at the {}", listed(&at, " and ")))
    };
    let kinds: Vec<String> = Feature::OPENINGS.into_iter().filter_map(of_kind).collect();
    match (kinds.is_empty(), most) {
        (false, _) => format!("; I saw {}", listed(&kinds, ", and ")),
        (true, 0) => String::new(),
        (true, _) => format!("; I saw no opening on the {}", side.in_words()),
    }
}

/// "first", "first and second", "first, second and third".
fn listed<T: AsRef<str>>(items: &[T], before_last: &str) -> String {
    match items {
        [] => String::new(),
        [one] => one.as_ref().to_owned(),
        [before @ .., last] => {
            let before: Vec<&str> = before.iter().map(AsRef::as_ref).collect();
            [&before.join(", "), before_last, last.as_ref()].concat()
        }
    }
}
