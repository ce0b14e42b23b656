//! Which places are adjacent: they see each other, and no other place lies on the way.

use rpl_robot::geometry::{Point, distance_m};
use std::collections::{BTreeMap, BTreeSet};

/// Farther off places are not recognised.
pub(super) const SIGHT_M: f64 = 20.0;

/// Nearest places that each place looks for; more of them in sight lie behind each other.
const MOST_LOOKED_FOR: usize = 24;

/// A way over a third place is on the way if it is no longer than this.
const ON_THE_WAY: f64 = 1.02;

/// The adjacent pairs, the smaller place first, in their order. Cost: each place, times those near it.
pub(super) fn adjacency(points: &[Point], is_in_sight: impl Fn(Point, Point) -> bool) -> Vec<(usize, usize)> {
    let mut seen: BTreeSet<(usize, usize)> = BTreeSet::new();
    for (one, others) in near(points).into_iter().enumerate() {
        let in_sight = others.into_iter().filter(|&other| is_in_sight(points[one], points[other]));
        seen.extend(in_sight.map(|other| (one.min(other), one.max(other))));
    }
    let mut beside: Vec<Vec<usize>> = vec![Vec::new(); points.len()];
    for &(one, other) in &seen {
        beside[one].push(other);
        beside[other].push(one);
    }
    let between_m = |one: usize, other: usize| distance_m(points[one], points[other]);
    let is_on_the_way = |one: usize, other: usize, third: usize| {
        let whole_m = between_m(one, other);
        let halves_m = [between_m(one, third), between_m(third, other)];
        // A place at the very place of an end is on no way.
        halves_m.iter().all(|&half_m| half_m < whole_m) && halves_m.iter().sum::<f64>() <= ON_THE_WAY * whole_m
    };
    let is_split = |&(one, other): &(usize, usize)| {
        beside[one]
            .iter()
            .any(|&third| third != other && beside[other].contains(&third) && is_on_the_way(one, other, third))
    };
    seen.iter().copied().filter(|pair| !is_split(pair)).collect()
}

/// For each point the nearest others, the nearest first.
fn near(points: &[Point]) -> Vec<Vec<usize>> {
    let mut all = Near::default();
    all.extend(&(0..points.len()).collect::<Vec<_>>(), points);
    let of_point = |(one, &point): (usize, &Point)| {
        let others = all.around(point, points).into_iter().map(|(_, other)| other);
        others.filter(|&other| other != one).take(MOST_LOOKED_FOR).collect()
    };
    points.iter().enumerate().map(of_point).collect()
}

/// Points by where they are.
#[derive(Clone, Debug, Default)]
pub(super) struct Near {
    cells: BTreeMap<(i64, i64), Vec<usize>>,
}

impl Near {
    /// Adds some of the points.
    pub fn extend(&mut self, some: &[usize], points: &[Point]) {
        some.iter().for_each(|&index| self.cells.entry(cell(points[index])).or_default().push(index));
    }

    /// Those that are near enough to be recognised, the nearest first, with their distances.
    pub fn around(&self, point: Point, points: &[Point]) -> Vec<(f64, usize)> {
        let (column, row) = cell(point);
        let around = (-1..=1).flat_map(|right| (-1..=1).map(move |up| (column + right, row + up)));
        let others = around.filter_map(|cell| self.cells.get(&cell)).flatten();
        let mut others: Vec<(f64, usize)> = others
            .map(|&other| (distance_m(point, points[other]), other))
            .filter(|&(off_m, _)| off_m <= SIGHT_M)
            .collect();
        others.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        others
    }
}

fn cell(point: Point) -> (i64, i64) {
    ((point.x / SIGHT_M).floor() as i64, (point.y / SIGHT_M).floor() as i64)
}
