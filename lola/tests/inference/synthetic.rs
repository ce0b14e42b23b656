//! Sides of hallways and what is perceived of them, drawn from a matrix.

use rpl_lola::feature::{Feature, Percept, Side};
use rpl_lola::state_set::Matrix;
use rpl_random::Stream;

/// What stands on one side, with the middle of each.
pub type Openings = Vec<(Feature, f64)>;

/// A number of openings of any kind, 2 m to 6 m apart, of which one, counted from 1, is of a given kind.
pub fn openings(count: usize, fixed: Option<(u8, Feature)>, stream: &mut Stream) -> Openings {
    let mut at_m = 0.0;
    let kinds = (1..=count).map(|number| match fixed {
        Some((ordinal, kind)) if usize::from(ordinal) == number => kind,
        _ => Feature::OPENINGS[stream.index(3)],
    });
    let kinds: Vec<Feature> = kinds.collect();
    let place = |kind| {
        at_m += stream.uniform_in(2.0, 6.0);
        (kind, at_m)
    };
    kinds.into_iter().map(place).collect()
}

/// What is perceived of a side by one who drives past, with a wall before each opening and behind the last.
pub fn percepts(openings: &Openings, side: Side, matrix: &Matrix, stream: &mut Stream) -> Vec<Percept> {
    let mut percepts = Vec::new();
    let mut last_m = 0.0;
    for &(kind, at_m) in openings {
        let features = [(Feature::Wall, (last_m + at_m) / 2.0), (kind, at_m)];
        for (feature, middle_m) in features {
            let seen = matrix.draw(feature, stream);
            if seen != Feature::Wall {
                percepts.push(percept(percepts.len() as u64, side, seen, middle_m));
            }
        }
        last_m = at_m;
    }
    percepts
}

/// A percept of this number, as wide as such things are.
pub fn percept(number: u64, side: Side, seen: Feature, middle_m: f64) -> Percept {
    let width_m = match seen {
        Feature::Wall => 0.0,
        Feature::ClosedDoor | Feature::OpenDoor => 0.95,
        Feature::Hallway => 2.2,
        Feature::Foyer => 4.0,
    };
    let depth_m = if seen == Feature::ClosedDoor { 0.055 } else { f64::INFINITY };
    let (from_m, to_m) = (middle_m - width_m / 2.0, middle_m + width_m / 2.0);
    Percept { number, side, seen, from_m, to_m, depth_m, marked: false }
}
