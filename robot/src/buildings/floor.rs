//! Where a robot can stand in a building and get to: its start, its places, spots to put it down at.

use crate::geometry::{Point, Pose, distance_m};
use crate::planning::{Inflation, PlannerModel};
use crate::world::{Place, World};
use rpl_random::Stream;

/// Edges of the cells that floors are looked at in: fine ones where the building is small.
const CELL_M: (f64, f64) = (0.05, 0.1);

/// Above this it is large.
const SMALL_M2: f64 = 1500.0;

/// Ways are wider than the robot by this on both sides: plans are made on coarser cells.
const WAY_AIR_M: f64 = 0.1;

/// Additional room around a start, a place, and a spot.
const STAND_AIR_M: f64 = 0.1;

/// How many places there are.
const PLACES: usize = 3;

/// Points tried for each of them.
const TRIES: usize = 3000;

/// No place is nearer to the last one, in a straight line, unless the building is small ...
const APART_M: f64 = 3.0;

/// ... nor farther by the way there, so that a run has an end.
const FARTHEST_M: f64 = 60.0;

/// Spots are so far apart from each other.
const SPOTS_APART_M: f64 = 1.5;

/// The floor of a world, as it is with its doors open.
pub(super) struct Floor {
    ways: PlannerModel,
    /// How far a robot's middle is from anything where it stands.
    stand_m: f64,
}

impl Floor {
    pub fn new(world: &World, robot_radius_m: f64) -> Self {
        let cell_m = if world.size_m.x * world.size_m.y <= SMALL_M2 { CELL_M.0 } else { CELL_M.1 };
        let body_radius_m = robot_radius_m + WAY_AIR_M;
        let inflation = Inflation {
            comfortable_distance_m: body_radius_m,
            closeness_weight: 0.0,
            ..Inflation::of_robot(body_radius_m)
        };
        Self { ways: PlannerModel::new(&world.open_floor(cell_m), inflation), stand_m: body_radius_m + STAND_AIR_M }
    }

    /// Draws start and places; none if there is no room for them, or if there are doors and no way leads through one.
    pub fn settle(&self, world: &mut World, within: Option<Point>, stream: &mut Stream) -> Option<()> {
        let within = within.map(|point| self.ways.cost_to_go(point));
        let hangs_together = |at: Point| within.as_ref().is_none_or(|ways| ways.cost_m(at).is_some());
        let start = (0..TRIES).find_map(|_| self.stand(world, stream).filter(|at| hangs_together(at.point())))?;
        world.start_in_map = start;
        let (mut last, mut ways) = (start, self.ways.cost_to_go(start.point()));
        for number in 1..=PLACES {
            let next = (0..TRIES).find_map(|_| {
                let at = self.stand(world, stream)?;
                let is_apart = distance_m(at.point(), last.point()) >= APART_M;
                let is_near = ways.cost_m(at.point()).is_some_and(|way_m| way_m <= FARTHEST_M);
                (is_apart && is_near).then_some(at)
            })?;
            let room = world.room_at(next.point()).map(|room| room.name.clone());
            world.places.push(Place { name: format!("place-{number}"), pose_in_map: next, room, charges: false });
            (last, ways) = (next, self.ways.cost_to_go(next.point()));
        }
        let room_of = |pose: Pose| world.room_at(pose.point()).map(|room| &room.name);
        let leaves_room = world.places.iter().any(|place| room_of(place.pose_in_map) != room_of(start));
        (world.doors.is_empty() || leaves_room).then_some(())
    }

    /// Whether a robot can stand at start and places, and get from each to the next.
    pub fn joins(&self, world: &World) -> bool {
        let poses = || std::iter::once(world.start_in_map).chain(world.places.iter().map(|place| place.pose_in_map));
        let ways = self.ways.cost_to_go(world.start_in_map.point());
        poses().all(|pose| self.is_room(pose.point()) && ways.cost_m(pose.point()).is_some())
    }

    /// Spots that the start hangs together with.
    pub fn spots(&self, world: &World, count: usize, stream: &mut Stream) -> Vec<Pose> {
        let ways = self.ways.cost_to_go(world.start_in_map.point());
        let mut spots: Vec<Pose> = Vec::new();
        for _ in 0..TRIES {
            if spots.len() == count {
                break;
            }
            let Some(pose_in_map) = self.stand(world, stream) else { continue };
            let is_apart = |spot: &Pose| spot.distance_m(pose_in_map) >= SPOTS_APART_M;
            if ways.cost_m(pose_in_map.point()).is_some() && spots.iter().all(is_apart) {
                spots.push(pose_in_map);
            }
        }
        spots
    }

    /// The shortest way from the start over all places.
    pub fn way(&self, world: &World) -> Vec<Point> {
        let mut way = vec![world.start_in_map.point()];
        for place in &world.places {
            let from = way[way.len() - 1];
            let to = place.pose_in_map.point();
            way.extend(self.ways.cost_to_go(to).path(from).unwrap_or_default());
            way.push(to);
        }
        way
    }

    fn is_room(&self, at: Point) -> bool {
        self.ways.obstacle_distance_m(at) >= self.stand_m
    }

    fn stand(&self, world: &World, stream: &mut Stream) -> Option<Pose> {
        let bounds = world.bounds();
        let (x_m, y_m) = (stream.uniform_in(bounds.min.x, bounds.max.x), stream.uniform_in(bounds.min.y, bounds.max.y));
        let heading_rad = stream.uniform_in(-std::f64::consts::PI, std::f64::consts::PI);
        self.is_room(Point::new(x_m, y_m)).then(|| Pose::new(x_m, y_m, heading_rad))
    }
}
