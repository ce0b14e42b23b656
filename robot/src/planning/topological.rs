//! Topological plans: which doors to go through, and the target points that lead through them
//! orthogonally and along the corridor past no other office (Beetz, Burgard, Fox, Cremers 1998,
//! Sect. 3.1, Fig. 12).

use super::areas::{Area, Areas};
use super::cost_to_go::TARGET_REACH_M;
use super::passage::{DOOR_APPROACH_M, Passage, one_of_each};
use super::planner::PlannerModel;
use super::target::Target;
use super::way::ESCAPE_REACH_M;
use crate::geometry::{Point, Pose, distance_m};
use crate::world::{Place, Rect, Region, TravelMode, World};
use serde::{Deserialize, Serialize};
use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::sync::Arc;

/// How far from the robot's line the last point may be for it to count as passed.
const PASSING_WIDTH_M: f64 = 0.3;

/// Two target points nearer to each other than this are one.
const SAME_TARGET_M: f64 = 0.4;

/// What a door adds to a way: it is gone through slowly, and no office is entered only to be left
/// again by the way it was entered.
const DOOR_COSTS_M: f64 = 2.0;

/// The structure of a way: its target points, and the regions it leads through.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NavigationPlan {
    /// In order; at least the destination.
    pub targets: Vec<Target>,
    /// The regions the way crosses, in the order they are first entered, each once.
    pub regions: Vec<Region>,
}

/// Why there is no plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("no way there: {reason}")]
pub struct Unreachable {
    /// In words for the user.
    pub reason: String,
}

/// Areas, passages and regions of a world as its map shows them. Immutable; share it.
#[derive(Clone, Debug)]
pub struct TopologicalModel {
    pub(super) world: Arc<World>,
    pub(super) areas: Areas,
    /// Doors first, in their order.
    pub(super) passages: Vec<Passage>,
}

impl TopologicalModel {
    /// Finds the areas of the map and the passages between them. O(cells of the map).
    pub fn new(world: &Arc<World>, planner: &PlannerModel) -> Self {
        let areas = Areas::new(planner, &world.rooms);
        let openings = areas.openings(planner);
        let mut passages: Vec<Passage> = openings.into_iter().map(|opening| Passage::of(world, opening)).collect();
        passages.sort_by_key(|passage| passage.door.unwrap_or(usize::MAX));
        Self { world: world.clone(), areas, passages }
    }

    /// The plan from a pose to a place: through doors orthogonally, past no other office. Doors found
    /// closed, given as indices into the world's doors, are gone through only if there is no other
    /// way. Cost: a pass over the cells for each target.
    ///
    /// # Errors
    /// The map leaves no way; the error says what is in between.
    pub fn plan(
        &self,
        planner: &PlannerModel,
        start_in_map: Pose,
        destination: &Place,
        closed_doors: &[usize],
    ) -> Result<NavigationPlan, Unreachable> {
        let goal = Target::at(destination.pose_in_map);
        let start = start_in_map.point();
        let points = self
            .points_through_doors(planner, start, goal.point_in_frame, closed_doors)
            .or_else(|| planner.cost_to_go(goal.point_in_frame).path(start).map(|_| vec![goal.point_in_frame]))
            .ok_or_else(|| Unreachable { reason: self.what_is_between(planner, start, goal.point_in_frame) })?;
        let regions = self.regions_along(start, &points);
        let (_, through) = points.split_last().unwrap_or((&goal.point_in_frame, &[]));
        let mut targets: Vec<Target> = through.iter().copied().map(Target::through).collect();
        targets.push(goal);
        Ok(NavigationPlan { targets, regions })
    }

    /// The region around a point: of several the one with the stricter mode.
    pub fn region_at(&self, point_in_map: Point) -> Option<Region> {
        let around = self.world.regions.iter().filter(|region| region.rect.contains(point_in_map));
        around.copied().reduce(|best, region| if region.mode > best.mode { region } else { best })
    }

    /// Target points beside the doors on the way, and the goal; none where they cannot be joined.
    fn points_through_doors(
        &self,
        planner: &PlannerModel,
        start: Point,
        goal: Point,
        closed_doors: &[usize],
    ) -> Option<Vec<Point>> {
        let from = self.areas.near(planner, start, ESCAPE_REACH_M)?;
        let to = self.areas.near(planner, goal, TARGET_REACH_M)?;
        let chain =
            self.chain(start, from, goal, to, closed_doors).or_else(|| self.chain(start, from, goal, to, &[]))?;
        let narrow = one_of_each(chain.into_iter().filter(|passage| passage.is_narrow).collect());
        let beside = |passage, side| clear_point_on_axis(planner, passage, side);
        let mut points: Vec<Point> = narrow
            .iter()
            .flat_map(|passage| [-1.0, 1.0].into_iter().filter_map(move |side| beside(passage, side)))
            .collect();
        points.push(goal);
        merge_near_points(&mut points);
        drop_passed(planner, &mut points, start);
        self.joined(planner, start, &points)
    }

    /// The passages to go through, each with the direction: the shortest chain by their distances
    /// from each other, and what each of them costs. Cost: passages, times those of an area.
    fn chain(&self, start: Point, from: Area, goal: Point, to: Area, closed_doors: &[usize]) -> Option<Vec<Passage>> {
        if from == to {
            return Some(Vec::new());
        }
        // A node is a passage in one of its two directions.
        let is_open = |passage: &&Passage| passage.door.is_none_or(|door| !closed_doors.contains(&door));
        let nodes: Vec<Passage> =
            self.passages.iter().filter(is_open).flat_map(|&passage| [passage, passage.reversed()]).collect();
        let mut leaving: Vec<Vec<usize>> = vec![Vec::new(); self.areas.count()];
        for (index, node) in nodes.iter().enumerate() {
            leaving[self.areas.index(node.areas[0])].push(index);
        }
        let mut length_m = vec![f64::INFINITY; nodes.len()];
        let mut before: Vec<Option<usize>> = vec![None; nodes.len()];
        let mut closed = vec![false; nodes.len()];
        let mut best: Option<(f64, usize)> = None;
        // Lengths are not negative, so that their bits have their order.
        let mut open = BinaryHeap::new();
        for &first in &leaving[self.areas.index(from)] {
            length_m[first] = distance_m(start, nodes[first].at);
            open.push(Reverse((length_m[first].to_bits(), first)));
        }
        while let Some(Reverse((_, node))) = open.pop() {
            if std::mem::replace(&mut closed[node], true) {
                continue;
            }
            if nodes[node].areas[1] == to {
                let whole_m = length_m[node] + distance_m(nodes[node].at, goal);
                if best.is_none_or(|(least_m, _)| whole_m < least_m) {
                    best = Some((whole_m, node));
                }
            }
            for &next in &leaving[self.areas.index(nodes[node].areas[1])] {
                let costs_m = if nodes[node].is_doorway_of(&nodes[next]) { 0.0 } else { DOOR_COSTS_M };
                let through_m = length_m[node] + distance_m(nodes[node].at, nodes[next].at) + costs_m;
                if through_m < length_m[next] {
                    length_m[next] = through_m;
                    before[next] = Some(node);
                    open.push(Reverse((through_m.to_bits(), next)));
                }
            }
        }
        let mut chain = Vec::new();
        let mut node = Some(best?.1);
        while let Some(index) = node {
            chain.push(nodes[index]);
            node = before[index];
        }
        chain.reverse();
        Some(chain)
    }

    /// The points, and between two of them points on the centre line of the corridor wherever the
    /// shortest way leads through an office of others. None if the map leaves no way between two.
    fn joined(&self, planner: &PlannerModel, start: Point, points: &[Point]) -> Option<Vec<Point>> {
        let mut joined = Vec::new();
        let mut from = start;
        for &to in points {
            let path = if planner.is_straight_way_free(from, to) {
                vec![from, to]
            } else {
                planner.cost_to_go(to).path(from)?
            };
            if self.leads_through_others(&path) {
                let ends = [from, to].map(|end| self.hallway_at(end).map(|hallway| on_centre_line(&hallway, end)));
                joined.extend(ends.into_iter().flatten().filter(|&point| has_clearance(planner, point)));
            }
            joined.push(to);
            from = to;
        }
        Some(joined)
    }

    /// Whether a way crosses rooms other than those of its two ends.
    fn leads_through_others(&self, path: &[Point]) -> bool {
        const GRAIN_M: f64 = 0.2;
        let room_at = |point: Point| self.world.rooms.iter().position(|room| room.rect.contains(point));
        let [first, .., last] = path else { return false };
        let ends = [None, room_at(*first), room_at(*last)];
        path.windows(2).any(|leg| {
            let steps = libm::ceil(distance_m(leg[0], leg[1]) / GRAIN_M).max(1.0) as usize;
            let along = |step: usize| leg[0] + (leg[1] - leg[0]) * (step as f64 / steps as f64);
            (0..=steps).any(|step| !ends.contains(&room_at(along(step))))
        })
    }

    fn hallway_at(&self, point_in_map: Point) -> Option<Rect> {
        let hallways = self.world.regions.iter().filter(|region| region.mode == TravelMode::Hallway);
        hallways.map(|region| region.rect).find(|rect| rect.contains(point_in_map))
    }

    fn regions_along(&self, start: Point, points: &[Point]) -> Vec<Region> {
        const GRAIN_M: f64 = 0.05;
        let mut regions: Vec<Region> = Vec::new();
        let mut from = start;
        for &to in points {
            let steps = libm::ceil(distance_m(from, to) / GRAIN_M).max(1.0) as usize;
            for step in 0..=steps {
                let share = step as f64 / steps as f64;
                if let Some(region) = self.region_at(from + (to - from) * share)
                    && !regions.contains(&region)
                {
                    regions.push(region);
                }
            }
            from = to;
        }
        regions
    }
}

fn has_clearance(planner: &PlannerModel, point_in_map: Point) -> bool {
    const ROOM_TO_TURN_M: f64 = 0.35;
    planner.is_traversable(point_in_map) && planner.obstacle_distance_m(point_in_map) >= ROOM_TO_TURN_M
}

/// The point on the line through a passage at the usual distance, or as near to that as furniture
/// allows; none if it allows none.
fn clear_point_on_axis(planner: &PlannerModel, passage: &Passage, side: f64) -> Option<Point> {
    let at = |away_m: f64| passage.at + passage.through * (side * away_m);
    let shifts_m = (0..=10).flat_map(|step| [f64::from(step), -f64::from(step)]).map(|step| step * 0.05);
    shifts_m
        .map(|shift_m| at(DOOR_APPROACH_M + shift_m))
        .find(|&point| has_clearance(planner, point) && planner.is_straight_way_free(passage.at, point))
}

/// The foot of a point on the long middle axis of a corridor.
fn on_centre_line(corridor: &Rect, point: Point) -> Point {
    let (centre, size) = (corridor.centre(), corridor.max - corridor.min);
    if size.x >= size.y { Point::new(point.x, centre.y) } else { Point::new(centre.x, point.y) }
}

/// Of two consecutive points that are nearly one, the later stays: it is the door's or the
/// destination.
fn merge_near_points(points: &mut Vec<Point>) {
    let mut index = 0;
    while index + 1 < points.len() {
        if distance_m(points[index], points[index + 1]) < SAME_TARGET_M {
            points.remove(index);
        } else {
            index += 1;
        }
    }
}

/// Whether a robot at `here` has `point` behind it on its way to `next`, and the rest of that way
/// lies straight ahead.
pub fn is_passed(planner: &PlannerModel, here: Point, point: Point, next: Point) -> bool {
    let way = next - point;
    let length_m = way.norm();
    if length_m < 1e-9 {
        return true;
    }
    let along_m = (here - point).dot(&way) / length_m;
    let aside_m = (here - point).perp(&way).abs() / length_m;
    let is_beside = along_m > 0.0 && along_m <= length_m && aside_m < PASSING_WIDTH_M;
    is_beside && planner.is_straight_way_free(here, next)
}

fn drop_passed(planner: &PlannerModel, points: &mut Vec<Point>, here: Point) {
    let last_passed = points.windows(2).rposition(|pair| is_passed(planner, here, pair[0], pair[1]));
    if let Some(index) = last_passed {
        points.drain(..=index);
    }
}
