//! What is compared of cases, laid out for a quick look at all of them, and lower bounds of distances from it.
//!
//! Numbers and places stand in columns, in single precision: a pass over them bounds the distance of every case,
//! and rules out nearly all. Of the sonars the mean is there: the mean of differences is no less than the difference
//! of means. Where that does not rule a case out, the means over each sixteenth of its sonars are looked at, which
//! stand together; of sixteen sonars they are the sonars themselves.

use crate::case::Kind;
use crate::similarity::{Comparison, Similarity};
use crate::situation::{Feature, Situation, Value};
use std::f32::consts::{PI, TAU};
use std::ops::Range;

/// Cases of a chunk: few enough that a copy is quick, enough that a pass over a column is.
pub(super) const CHUNK: usize = 256;

/// Parts of a ring of sonars that are taken together.
const PARTS: usize = 16;

/// Columns in all.
pub(super) const COLUMNS: usize = 2 + 4 + 3 * 2;

/// The sonars of a case: what was heard last, and the means; not a number where they are missing.
pub(super) type Rings = [[f32; PARTS]; 2];

/// Rounding to single precision changes a distance of weight 1 by less than this.
const ROUNDING: f64 = 1e-5;

/// The columns of a feature; those that have none are bounded by 0.
fn columns_of(feature: Feature) -> Range<usize> {
    match feature {
        Feature::Sonars => 0..1,
        Feature::MeanSonars => 1..2,
        Feature::Translation => 2..3,
        Feature::Rotation => 3..4,
        Feature::ShortTermGoalDistance => 4..5,
        Feature::ShortTermGoalBearing => 5..6,
        Feature::Place => 6..8,
        Feature::ShortTermGoal => 8..10,
        Feature::LongTermGoal => 10..12,
        // There are few goals, and times do not fit into single precision.
        Feature::Priority | Feature::Time => 0..0,
    }
}

/// Which of the rings a feature is.
fn ring_of(feature: Feature) -> Option<usize> {
    [Feature::Sonars, Feature::MeanSonars].iter().position(|ring| *ring == feature)
}

/// What is compared of one situation; not a number where a feature is missing.
pub(super) struct Row {
    pub(super) columns: [f32; COLUMNS],
    pub(super) rings: Rings,
}

impl Row {
    /// With ranges taken for `most_m` if they are greater.
    pub(super) fn of(situation: &Situation, most_m: f64) -> Self {
        let mut row = Self { columns: [f32::NAN; COLUMNS], rings: [[f32::NAN; PARTS]; 2] };
        for feature in Feature::ALL {
            let columns = &mut row.columns[columns_of(feature)];
            match (situation.value(feature), &mut *columns) {
                (Value::Ranges(ranges_m), whole) => {
                    let Some(ring) = ring_of(feature) else { continue };
                    row.rings[ring] = std::array::from_fn(|part| mean_m(part_of(ranges_m, part), most_m));
                    whole[0] = mean_m(ranges_m, most_m);
                }
                (Value::Missing, _) | (_, []) => {}
                (Value::Point(point), both) => {
                    both.iter_mut().zip(point.iter()).for_each(|(column, metres)| *column = *metres as f32);
                }
                (Value::Number(number), one) => one[0] = number as f32,
            }
        }
        row
    }
}

fn part_of(ranges_m: &[f64], part: usize) -> &[f64] {
    &ranges_m[part * ranges_m.len() / PARTS..(part + 1) * ranges_m.len() / PARTS]
}

/// The mean of ranges, taken for `most_m` if they are greater; 0 of none.
fn mean_m(ranges_m: &[f64], most_m: f64) -> f32 {
    let sum_m: f64 = ranges_m.iter().map(|range_m| range_m.min(most_m)).sum();
    (sum_m / ranges_m.len().max(1) as f64) as f32
}

/// What bounds the distances to a situation from below.
pub(super) struct Bounds {
    terms: Vec<Term>,
    rings: [RingTerm; 2],
    /// How much greater than the distance a bound may be, by rounding.
    pub(super) margin: f64,
}

/// What the difference of a ring adds, by its parts, up to a limit; what is not a number counts `missing`.
#[derive(Clone, Copy, Default)]
struct RingTerm {
    asked: [f32; PARTS],
    per_unit: [f32; PARTS],
    most: f32,
    missing: f32,
}

/// What a feature adds to the bounds.
enum Term {
    /// The feature is there: the weighted difference, or what it counts if the case lacks it.
    Number { column: usize, asked: f32, per_unit: f32, most: f32, missing: f32 },
    /// The same around the circle.
    Bearing { column: usize, asked: f32, per_unit: f32, most: f32, missing: f32 },
    /// The same in the plane.
    Point { column: usize, asked: [f32; 2], per_unit: f32, most: f32, missing: f32 },
    /// The same for whether it is there.
    Present { column: usize, missing: f32 },
    /// The feature is not there: what it counts if the case has it.
    Absent { column: usize, missing: f32 },
}

impl Bounds {
    /// Of a kind of cases.
    pub(super) fn new(similarity: &Similarity, asked: &Situation, kind: Kind) -> Self {
        let row = Row::of(asked, similarity.scales.sonar_m);
        let (mut terms, mut rings) = (Vec::new(), [RingTerm::default(); 2]);
        for feature in Feature::ALL {
            let (weight, missing) = (similarity.weights[feature as usize], similarity.missing[feature as usize] as f32);
            let most = weight as f32;
            let per_unit = (weight / similarity.scales.of_number(feature)) as f32;
            let value = asked.value(feature);
            let comparison = similarity.comparison(kind, feature);
            if let (Some(ring), Value::Ranges(ranges_m), Comparison::Distance) = (ring_of(feature), value, comparison) {
                let share = |part: usize| part_of(ranges_m, part).len() as f32 / ranges_m.len() as f32;
                rings[ring] = RingTerm {
                    asked: row.rings[ring],
                    per_unit: std::array::from_fn(|part| share(part) * per_unit),
                    most: most.min(missing),
                    missing,
                };
            }
            let Some(column) = columns_of(feature).next() else { continue };
            let here = row.columns[column];
            terms.push(match (comparison, value) {
                (Comparison::Foreign, _) => continue,
                (_, Value::Missing) => Term::Absent { column, missing },
                (Comparison::Presence, _) => Term::Present { column, missing },
                (Comparison::Distance, Value::Point(_)) => {
                    Term::Point { column, asked: [here, row.columns[column + 1]], per_unit, most, missing }
                }
                (Comparison::Distance, Value::Number(_)) if feature == Feature::ShortTermGoalBearing => {
                    Term::Bearing { column, asked: here, per_unit, most, missing }
                }
                (Comparison::Distance, Value::Number(_)) => {
                    Term::Number { column, asked: here, per_unit, most, missing }
                }
                // Another ring counts as missing, however much its means differ.
                (Comparison::Distance, Value::Ranges(_)) => {
                    Term::Number { column, asked: here, per_unit, most: most.min(missing), missing }
                }
            });
        }
        let margin = ROUNDING * similarity.weights.iter().chain(&similarity.missing).sum::<f64>();
        Self { terms, rings, margin }
    }

    /// What the sonars, one by one, add to the least distance of a case by its columns.
    #[inline]
    pub(super) fn of_rings(&self, rings: &Rings) -> f32 {
        let of_ring = |(term, ring): (&RingTerm, &[f32; PARTS])| {
            let differences: [f32; PARTS] =
                std::array::from_fn(|part| (ring[part] - term.asked[part]) * term.per_unit[part]);
            let of_means = differences.iter().sum::<f32>().abs();
            let of_each: f32 = differences.iter().map(|difference| difference.abs()).sum();
            bounded(of_each, term.most, term.missing) - bounded(of_means, term.most, term.missing)
        };
        self.rings.iter().zip(rings).map(of_ring).sum()
    }

    /// The least distance each case of a chunk can have by its columns.
    pub(super) fn of(&self, columns: &[[f32; CHUNK]; COLUMNS]) -> Least {
        let mut least = [0.0; CHUNK];
        self.terms.iter().for_each(|term| term.add(columns, &mut least));
        least
    }
}

/// The least distance each case of a chunk can have by its columns; beyond the last case whatever.
pub(super) type Least = [f32; CHUNK];

impl Term {
    #[inline(always)]
    fn add(&self, columns: &[[f32; CHUNK]; COLUMNS], least: &mut [f32; CHUNK]) {
        match *self {
            Self::Number { column, asked, per_unit, most, missing } => {
                for (least, value) in least.iter_mut().zip(&columns[column]) {
                    *least += bounded((value - asked).abs() * per_unit, most, missing);
                }
            }
            Self::Bearing { column, asked, per_unit, most, missing } => {
                for (least, value) in least.iter_mut().zip(&columns[column]) {
                    let around = (value - asked).abs();
                    let shorter = if around > PI { TAU - around } else { around };
                    *least += bounded(shorter * per_unit, most, missing);
                }
            }
            Self::Point { column, asked: [x, y], per_unit, most, missing } => {
                for ((least, at_x), at_y) in least.iter_mut().zip(&columns[column]).zip(&columns[column + 1]) {
                    let (dx, dy) = (at_x - x, at_y - y);
                    *least += bounded((dx * dx + dy * dy).sqrt() * per_unit, most, missing);
                }
            }
            Self::Present { column, missing } => {
                for (least, value) in least.iter_mut().zip(&columns[column]) {
                    *least += if value.is_nan() { missing } else { 0.0 };
                }
            }
            Self::Absent { column, missing } => {
                for (least, value) in least.iter_mut().zip(&columns[column]) {
                    *least += if value.is_nan() { 0.0 } else { missing };
                }
            }
        }
    }
}

/// A weighted difference that is not more than the weight; what is missing counts, where there is no number.
#[inline(always)]
fn bounded(difference: f32, most: f32, missing: f32) -> f32 {
    if difference.is_nan() { missing } else { difference.min(most) }
}
