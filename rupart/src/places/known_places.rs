//! The known places of a building.

use super::adjacency::adjacency;
use super::key_positions::key_positions;
use super::lower_bound::LowerBounds;
use super::place::{KnownPlace, PlaceId, Stretch};
use super::sight::Sight;
use rpl_robot::geometry::{Point, distance_m};
use rpl_robot::world::{World, is_same_name};

/// Edge of a cell of the map that sight is looked up in.
const RESOLUTION_M: f64 = 0.05;

/// The known places of a building. Immutable; share it.
#[derive(Clone, Debug)]
pub struct Places {
    /// In the order of the world, then key positions between them.
    pub all: Vec<KnownPlace>,
    /// For each place, the stretches from it, by where they lead.
    pub stretches: Vec<Vec<Stretch>>,
    /// How many stretches there are, each counted once.
    pub stretch_count: usize,
    /// What ways between two of them cannot be shorter than.
    pub lower_bounds: LowerBounds,
}

/// A world no routes can be made in.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("world `{world}` has no places; routes lead over places: add [[place]] with a name and a pose to it")]
pub struct NoPlaces {
    /// Its name.
    pub world: String,
}

impl Places {
    /// The places of a world, which see each other where a robot of this radius can drive straight from one
    /// to the other, and key positions where they do not and yet the floor leads from one to the other. Cost: a pass
    /// over the cells of the map, and a ray for each two places near each other; as much again for each part of the
    /// floor if key positions are needed.
    ///
    /// # Errors
    /// The world has none.
    pub fn new(world: &World, robot_radius_m: f64) -> Result<Self, NoPlaces> {
        if world.places.is_empty() {
            return Err(NoPlaces { world: world.name.clone() });
        }
        let known = |name: &str, at_in_map: Point| KnownPlace {
            name: name.to_string(),
            at_in_map,
            influence: world.room_at(at_in_map).map(|room| room.rect),
        };
        let mut all: Vec<KnownPlace> =
            world.places.iter().map(|place| known(&place.name, place.pose_in_map.point())).collect();
        let map = world.map(RESOLUTION_M);
        let sight = Sight::new(&map, robot_radius_m);
        let mut points: Vec<Point> = all.iter().map(|place| place.at_in_map).collect();
        let mut pairs = adjacency(&points, |one, other| sight.is_free(one, other));
        let key_positions = key_positions(&map, &sight, &world.doors, &points, &pairs);
        if !key_positions.points_in_map.is_empty() {
            let is_new = |name: &String| world.places.iter().all(|place| !is_same_name(&place.name, name));
            let names = (1..).map(|number| format!("key-position-{number}")).filter(is_new);
            all.extend(names.zip(&key_positions.points_in_map).map(|(name, &at_in_map)| known(&name, at_in_map)));
            points.extend(key_positions.points_in_map);
            // A way is kept even where more places are in sight than are looked for.
            pairs = adjacency(&points, |one, other| sight.is_free(one, other));
            pairs.extend(key_positions.pairs);
            pairs.sort_unstable();
            pairs.dedup();
        }
        let room_m = |one: usize, other: usize| sight.room_m(points[one], points[other]).unwrap_or(0.0);
        Ok(Self::joined(all, &pairs, room_m))
    }

    /// Places with stretches between them, whose room `room_m` gives.
    pub(super) fn joined(all: Vec<KnownPlace>, pairs: &[(usize, usize)], room_m: impl Fn(usize, usize) -> f64) -> Self {
        let mut stretches: Vec<Vec<Stretch>> = vec![Vec::new(); all.len()];
        for (id, &(one, other)) in pairs.iter().enumerate() {
            let length_m = distance_m(all[one].at_in_map, all[other].at_in_map);
            let room_m = room_m(one, other);
            for (from, to) in [(one, other), (other, one)] {
                stretches[from].push(Stretch { to: PlaceId(to as u32), length_m, room_m, id });
            }
        }
        stretches.iter_mut().for_each(|from| from.sort_by_key(|stretch| stretch.to));
        let lower_bounds = LowerBounds::new(&stretches);
        Self { all, stretches, stretch_count: pairs.len(), lower_bounds }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.all.len()
    }

    /// Every one of them.
    pub fn ids(&self) -> impl Iterator<Item = PlaceId> + use<> {
        (0..self.all.len() as u32).map(PlaceId)
    }

    /// Where a place is.
    pub fn at_in_map(&self, place: PlaceId) -> Point {
        self.all[place.index()].at_in_map
    }

    /// What a place is called.
    pub fn name(&self, place: PlaceId) -> &str {
        &self.all[place.index()].name
    }

    /// The place of a name.
    pub fn named(&self, name: &str) -> Option<PlaceId> {
        self.ids().find(|&place| is_same_name(self.name(place), name))
    }

    /// The stretch from one place to another, if they see each other.
    pub fn stretch(&self, from: PlaceId, to: PlaceId) -> Option<&Stretch> {
        self.stretches[from.index()].iter().find(|stretch| stretch.to == to)
    }

    /// The known place that a point counts as being at: of those whose region of influence it is in the
    /// nearest, else the nearest of those that have none (Fox and Anderson-Sprecher, Deliberative planning).
    pub fn closest(&self, point_in_map: Point) -> PlaceId {
        let is_under = |place: &PlaceId| {
            self.all[place.index()].influence.is_some_and(|influence| influence.contains(point_in_map))
        };
        let is_open = |place: &PlaceId| self.all[place.index()].influence.is_none();
        let off_m = |place: &PlaceId| distance_m(self.at_in_map(*place), point_in_map);
        let nearest = |of: &dyn Fn(&PlaceId) -> bool| {
            self.ids().filter(of).min_by(|one, other| off_m(one).total_cmp(&off_m(other)))
        };
        nearest(&is_under).or_else(|| nearest(&is_open)).or_else(|| nearest(&|_| true)).unwrap_or(PlaceId(0))
    }
}
