//! Key positions in hallways and open spaces, where the places of a world do not see each other.

use super::adjacency::{Near, SIGHT_M, adjacency};
use super::sight::Sight;
use rpl_robot::geometry::{Point, distance_m};
use rpl_robot::occupancy::OccupancyGrid;
use rpl_robot::planning::{CostToGo, Inflation, PlannerModel};
use rpl_robot::world::Door;

/// A key position lies so far before a door, and one so far behind it.
const OFF_DOOR_M: f64 = 0.9;

/// Key positions, and what is in sight of what on the ways over them.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct KeyPositions {
    /// Where they are; they are numbered on after the places.
    pub points_in_map: Vec<Point>,
    /// Stretches of the ways.
    pub pairs: Vec<(usize, usize)>,
}

/// Outside and inside of doors, where the places of a world are not all joined by stretches; and, where that is not
/// enough, the corners of ways on the map, as far as the floor leads. Each way ends where it is in sight of what is
/// joined already, and those nearest to the first place come first. Cost: nothing where all are joined, else a pass
/// over the cells of the map for each part of the floor.
///
/// # Deviation
/// The paper's places were chosen by hand so that each is in sight of another (Fox and Anderson-Sprecher,
/// Deliberative planning); other worlds name only the places that somebody wants to be driven to.
pub(super) fn key_positions(
    map: &OccupancyGrid,
    sight: &Sight,
    doors: &[Door],
    places_in_map: &[Point],
    pairs: &[(usize, usize)],
) -> KeyPositions {
    if groups(places_in_map.len(), pairs).len() < 2 {
        return KeyPositions::default();
    }
    let mut all = KeyPositions { points_in_map: places_in_map.to_vec(), pairs: Vec::new() };
    let open = doors.iter().filter(|door| door.mapped_open);
    let sides = open.flat_map(|door| [-OFF_DOOR_M, OFF_DOOR_M].map(|off_m| door.at + door.through() * off_m));
    all.points_in_map.extend(sides.filter(|&side| sight.is_free(side, side)));
    let pairs = adjacency(&all.points_in_map, |one, other| sight.is_free(one, other));
    let mut groups = groups(all.points_in_map.len(), &pairs);
    // A corner of a cell is off its middle, and robots keep off corners.
    let planner = PlannerModel::new(map, Inflation::of_robot(sight.robot_radius_m + map.resolution_m));
    while !groups.is_empty() {
        let first = groups.remove(0);
        let to_first = planner.cost_to_go(all.points_in_map[first[0]]);
        let at_in_map = &all.points_in_map;
        let cost_m = |place: &usize| to_first.cost_m(at_in_map[*place]).unwrap_or(f64::INFINITY);
        let nearest = |group: &Vec<usize>| group.iter().copied().min_by(|a, b| cost_m(a).total_cmp(&cost_m(b)));
        let mut reached: Vec<(usize, Vec<usize>)> = Vec::new();
        groups.retain_mut(|group| {
            let place = nearest(group).filter(|place| cost_m(place).is_finite());
            reached.extend(place.map(|place| (place, std::mem::take(group))));
            place.is_none()
        });
        reached.sort_by(|(one, _), (other, _)| cost_m(one).total_cmp(&cost_m(other)));
        let mut joined = Near::default();
        joined.extend(&first, &all.points_in_map);
        for (place, group) in reached {
            let way = all.join(place, &joined, &to_first, sight);
            joined.extend(&way, &all.points_in_map);
            joined.extend(&group, &all.points_in_map);
        }
    }
    all.points_in_map.drain(..places_in_map.len());
    all
}

/// Places that stretches lead between, group by group; each has its lowest place first.
fn groups(count: usize, pairs: &[(usize, usize)]) -> Vec<Vec<usize>> {
    let mut beside: Vec<Vec<usize>> = vec![Vec::new(); count];
    for &(one, other) in pairs {
        beside[one].push(other);
        beside[other].push(one);
    }
    let mut is_sorted = vec![false; count];
    let mut groups = Vec::new();
    for first in 0..count {
        let (mut open, mut group) = (vec![first], Vec::new());
        while let Some(place) = open.pop() {
            if !std::mem::replace(&mut is_sorted[place], true) {
                group.push(place);
                open.extend(&beside[place]);
            }
        }
        groups.push(group);
    }
    groups.retain(|group| !group.is_empty());
    groups
}

impl KeyPositions {
    /// Goes from a place towards another until something is in sight that is joined already; the corners on the way.
    fn join(&mut self, place: usize, joined: &Near, to_first: &CostToGo, sight: &Sight) -> Vec<usize> {
        let way = to_first.path(self.points_in_map[place]).unwrap_or_default();
        let mut corners = way.windows(2).flat_map(|two| recognizable(two[0], two[1]));
        let (mut at, mut passed) = (place, Vec::new());
        loop {
            let here = self.points_in_map[at];
            let mut seen = joined.around(here, &self.points_in_map).into_iter().map(|(_, other)| other);
            if let Some(other) = seen.find(|&other| sight.is_free(here, self.points_in_map[other])) {
                self.pairs.push((at.min(other), at.max(other)));
                return passed;
            }
            let Some(corner) = corners.next() else { return passed };
            self.points_in_map.push(corner);
            let next = self.points_in_map.len() - 1;
            self.pairs.push((at, next));
            passed.push(next);
            at = next;
        }
    }
}

/// Points on a straight way, each to be recognised from the one before; the last is its end.
fn recognizable(from: Point, to: Point) -> impl Iterator<Item = Point> {
    let steps = libm::ceil(distance_m(from, to) / SIGHT_M).max(1.0) as u32;
    (1..=steps).map(move |step| from + (to - from) * (f64::from(step) / f64::from(steps)))
}
