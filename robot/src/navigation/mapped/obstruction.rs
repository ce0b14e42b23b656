//! What stands in the way that the map shows.

use super::MappedNavigation;
use super::blockages::BLOCKAGE_OFF_M;
use super::model::NavigationModel;
use crate::geometry::{Point, Pose, distance_m};

/// What blocks a way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstruction {
    /// A door found closed, as an index into the world's doors.
    Door(usize),
    /// Something that is not in the map, at this point of it.
    Thing(Point),
}

impl MappedNavigation {
    /// What stands in the way that the map shows to the next target, as far as the sensors tell:
    /// nothing tells a thing from a person who stands.
    pub fn obstruction(
        &self,
        model: &NavigationModel,
        estimated_in_map: Pose,
        odometry_in_odom: Pose,
    ) -> Option<Obstruction> {
        let here = estimated_in_map.point();
        let costs = model.planner.cost_to_go(self.driver.targets.first()?.point_in_frame);
        let way = costs.way_ahead(here, f64::INFINITY)?;
        let is_on_way = |at: Point, reach_m: f64| way.iter().any(|&on_way| distance_m(on_way, at) <= reach_m);
        let nearest = |one: &Point, other: &Point| distance_m(here, *one).total_cmp(&distance_m(here, *other));
        let closed = self.closed_doors();
        let doors = model.doorways.iter().filter(|doorway| closed.contains(&doorway.door));
        let doors = doors.filter(|doorway| is_on_way(doorway.at, doorway.width_m / 2.0));
        let door = doors.min_by(|one, other| nearest(&one.at, &other.at));
        let mut points = self.standing_in_map(model, estimated_in_map, odometry_in_odom);
        points.retain(|&point| is_on_way(point, model.limits.robot_radius_m + BLOCKAGE_OFF_M));
        let thing = points.into_iter().min_by(nearest);
        match (door, thing) {
            // What is seen in a doorway is its leaf.
            (Some(door), Some(thing)) if distance_m(here, thing) + door.width_m < distance_m(here, door.at) => {
                Some(Obstruction::Thing(thing))
            }
            (Some(door), _) => Some(Obstruction::Door(door.door)),
            (None, Some(thing)) => Some(Obstruction::Thing(thing)),
            (None, None) => None,
        }
    }
}
