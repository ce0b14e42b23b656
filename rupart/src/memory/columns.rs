//! What is compared of cases, in columns, and a lower bound of each distance from them.
//!
//! Numbers and places are there as they are, in single precision; of the sonars the mean over each sixteenth of
//! them: the mean of differences is no less than the difference of means, and of sixteen sonars it is the same.

use crate::case::Kind;
use crate::similarity::{Comparison, Similarity};
use crate::situation::{Feature, Situation, Value};
use std::f32::consts::{PI, TAU};
use std::ops::Range;

/// Cases of a chunk: few enough that a copy is quick, enough that a pass over a column is.
pub(super) const CHUNK: usize = 256;

/// Parts of a ring of sonars that are taken together.
const PARTS: usize = 16;

/// Cases whose sums are kept in registers.
const LANES: usize = 8;

/// Columns in all.
pub(super) const COLUMNS: usize = 2 * PARTS + 4 + 3 * 2;

/// Rounding to single precision changes a distance of weight 1 by less than this.
const ROUNDING: f64 = 1e-5;

/// The columns of a feature; those that are left out are bounded by 0.
fn columns_of(feature: Feature) -> Range<usize> {
    const FIRST: usize = 2 * PARTS;
    match feature {
        Feature::Sonars => 0..PARTS,
        Feature::MeanSonars => PARTS..FIRST,
        Feature::Translation => FIRST..FIRST + 1,
        Feature::Rotation => FIRST + 1..FIRST + 2,
        Feature::ShortTermGoalDistance => FIRST + 2..FIRST + 3,
        Feature::ShortTermGoalBearing => FIRST + 3..FIRST + 4,
        Feature::Place => FIRST + 4..FIRST + 6,
        Feature::ShortTermGoal => FIRST + 6..FIRST + 8,
        Feature::LongTermGoal => FIRST + 8..FIRST + 10,
        // There are few goals, and times do not fit into single precision.
        Feature::Priority | Feature::Time => 0..0,
    }
}

/// The columns of one situation; not a number where a feature is missing.
pub(super) struct Row(pub(super) [f32; COLUMNS]);

impl Row {
    /// With ranges taken for `most_m` if they are greater.
    pub(super) fn of(situation: &Situation, most_m: f64) -> Self {
        let mut row = [f32::NAN; COLUMNS];
        for feature in Feature::ALL {
            let columns = &mut row[columns_of(feature)];
            match (situation.value(feature), &mut *columns) {
                (Value::Missing, _) | (_, []) => {}
                (Value::Ranges(ranges_m), parts) => {
                    for (part, mean_m) in parts.iter_mut().enumerate() {
                        *mean_m = mean_of_part(ranges_m, part, most_m);
                    }
                }
                (Value::Point(point), both) => {
                    both.iter_mut().zip(point.iter()).for_each(|(column, metres)| *column = *metres as f32);
                }
                (Value::Number(number), one) => one[0] = number as f32,
            }
        }
        Self(row)
    }
}

fn part_of(ranges_m: &[f64], part: usize) -> &[f64] {
    &ranges_m[part * ranges_m.len() / PARTS..(part + 1) * ranges_m.len() / PARTS]
}

/// 0 of a part without a sonar.
fn mean_of_part(ranges_m: &[f64], part: usize, most_m: f64) -> f32 {
    let ranges_m = part_of(ranges_m, part);
    let sum_m: f64 = ranges_m.iter().map(|range_m| range_m.min(most_m)).sum();
    (sum_m / ranges_m.len().max(1) as f64) as f32
}

/// What bounds the distances to a situation from below.
pub(super) struct Bounds {
    terms: Vec<Term>,
    /// How much greater than the distance a bound may be, by rounding.
    pub(super) margin: f64,
}

/// What a feature adds to the bounds.
enum Term {
    /// The feature is there: the weighted difference, or what it counts if the case lacks it.
    Number { column: usize, asked: f32, per_unit: f32, most: f32, missing: f32 },
    /// The same of each part of a ring of sonars.
    Ring { first: usize, asked: [f32; PARTS], per_unit: [f32; PARTS], most: f32, missing: f32 },
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
        let row = Row::of(asked, similarity.scales.sonar_m).0;
        let mut terms = Vec::new();
        for feature in Feature::ALL {
            let columns = columns_of(feature);
            let Some(column) = columns.clone().next() else { continue };
            let weight = similarity.weights[feature as usize];
            let missing = similarity.missing[feature as usize] as f32;
            let most = weight as f32;
            let per_unit = (weight / similarity.scales.of_number(feature)) as f32;
            let value = asked.value(feature);
            let term = match (similarity.comparison(kind, feature), value) {
                (Comparison::Foreign, _) => continue,
                (_, Value::Missing) => Term::Absent { column, missing },
                (Comparison::Presence, _) => Term::Present { column, missing },
                (Comparison::Distance, Value::Point(_)) => {
                    Term::Point { column, asked: [row[column], row[column + 1]], per_unit, most, missing }
                }
                (Comparison::Distance, Value::Number(_)) if feature == Feature::ShortTermGoalBearing => {
                    Term::Bearing { column, asked: row[column], per_unit, most, missing }
                }
                (Comparison::Distance, Value::Number(_)) => {
                    Term::Number { column, asked: row[column], per_unit, most, missing }
                }
                (Comparison::Distance, Value::Ranges(ranges_m)) => {
                    let share = |part: usize| part_of(ranges_m, part).len() as f32 / ranges_m.len() as f32;
                    Term::Ring {
                        first: column,
                        asked: std::array::from_fn(|part| row[column + part]),
                        per_unit: std::array::from_fn(|part| share(part) * per_unit),
                        // Another ring counts as missing, however much its means differ.
                        most: most.min(missing),
                        missing,
                    }
                }
            };
            terms.push(term);
        }
        Self { terms, margin: ROUNDING * similarity.weights.iter().chain(&similarity.missing).sum::<f64>() }
    }

    /// The least distance each case of a chunk can have.
    pub(super) fn of(&self, columns: &[[f32; CHUNK]; COLUMNS]) -> Least {
        let mut least = [0.0; CHUNK];
        self.terms.iter().for_each(|term| term.add(columns, &mut least));
        least
    }
}

/// The least distance each case of a chunk can have; beyond the last case whatever.
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
            Self::Ring { first, ref asked, ref per_unit, most, missing } => {
                for (block, least) in least.as_chunks_mut::<LANES>().0.iter_mut().enumerate() {
                    let mut sums = [0.0_f32; LANES];
                    for ((column, asked), per_unit) in columns[first..first + PARTS].iter().zip(asked).zip(per_unit) {
                        let values = &column[block * LANES..(block + 1) * LANES];
                        for (sum, value) in sums.iter_mut().zip(values) {
                            *sum += (value - asked).abs() * per_unit;
                        }
                    }
                    for (least, sum) in least.iter_mut().zip(sums) {
                        *least += bounded(sum, most, missing);
                    }
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
