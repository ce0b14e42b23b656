//! Where drives lead, by the map. A way is searched once and remembered: what is projected goes the same
//! ways again and again.

use super::drive_times::WayFeatures;
use crate::geometry::{Point, Pose, distance_m, wrap_angle_rad};
use crate::memo::Memo;
use crate::planning::{NavigationPlan, PlannerModel, Target, TopologicalModel, Unreachable};
use crate::world::{Place, TravelMode, World};
use std::collections::BTreeMap;
use std::sync::{Arc, OnceLock};

/// In worlds with more places than this the ways between them are searched anew in each projection.
const MOST_PLACES: usize = 128;

/// A way is cut into stretches of this length, each in the travel mode of its middle.
const STRETCH_M: f64 = 0.25;

/// A way leads through a door if it passes its middle this near.
const THROUGH_DOOR_M: f64 = 0.5;

/// A stretch of a way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    /// Where it ends.
    pub to_in_map: Point,
    /// Its length.
    pub length_m: f64,
    /// How it is driven.
    pub mode: TravelMode,
    /// The turn from the stretch before.
    pub turned_rad: f64,
    /// The door in which it ends, as an index into the world's doors.
    pub door: Option<usize>,
}

/// The straight pieces of a way between two points, in order.
pub type Leg = Vec<Stretch>;

type Hundredths = (i64, i64);

fn hundredths(point: Point) -> Hundredths {
    let rounded = |value_m: f64| libm::round(value_m * 100.0) as i64;
    (rounded(point.x), rounded(point.y))
}

/// A way between two places: its plan, and its legs.
#[derive(Clone, Debug)]
struct Route {
    plan: NavigationPlan,
    legs: Vec<Option<Arc<Leg>>>,
}

/// The ways between the places of a world with all its doors open, each searched when it is first asked for:
/// functions of the map alone.
#[derive(Debug)]
pub struct Routes {
    /// Places by where they are; of two at one point the first.
    places: BTreeMap<Hundredths, usize>,
    /// Of a place to another; empty if there are too many places.
    routes: Vec<OnceLock<Result<Route, Unreachable>>>,
    count: usize,
}

impl Routes {
    /// Those of a world; nothing is searched yet.
    pub fn new(world: &World) -> Self {
        let mut places = BTreeMap::new();
        for (index, place) in world.places.iter().enumerate() {
            places.entry(hundredths(place.pose_in_map.point())).or_insert(index);
        }
        let count = if world.places.len() <= MOST_PLACES { world.places.len() } else { 0 };
        Self { places, routes: (0..count * count).map(|_| OnceLock::new()).collect(), count }
    }

    fn between(&self, from: usize, to: usize) -> Option<&OnceLock<Result<Route, Unreachable>>> {
        self.routes.get(from * self.count + to).filter(|_| from < self.count)
    }
}

/// The map that ways are searched in.
#[derive(Clone, Copy)]
pub struct WayMap<'a> {
    /// What is on it.
    pub world: &'a World,
    /// Its floor.
    pub planner: &'a PlannerModel,
    /// Its doors and areas.
    pub topology: &'a TopologicalModel,
    /// The ways between its places.
    pub routes: &'a Routes,
}

/// What a plan of the way depends on: start and goal, and the doors found closed.
type PlanKey = (Hundredths, String, Vec<usize>);

#[derive(Debug, Default)]
struct Known {
    legs: BTreeMap<(Hundredths, Hundredths), Option<Arc<Leg>>>,
    plans: BTreeMap<PlanKey, Result<NavigationPlan, Unreachable>>,
}

/// What plans of the way are made of in a projected run.
#[derive(Clone, Debug)]
pub struct ForeseenWays {
    /// The ways that were searched.
    pub ways: Ways,
    /// The doors found closed, as indices into the world's doors.
    pub closed_doors: Vec<usize>,
}

/// The ways that were searched in one projection; all its runs share them.
#[derive(Clone, Debug, Default)]
pub struct Ways(Memo<Known>);

impl Ways {
    /// The plan from a pose to a place, as [`TopologicalModel::plan`] makes it from there to the centimetre.
    ///
    /// # Errors
    /// The map leaves no way.
    pub fn plan(
        &self,
        map: WayMap<'_>,
        start_in_map: Pose,
        destination: &Place,
        closed_doors: &[usize],
    ) -> Result<NavigationPlan, Unreachable> {
        let key = (hundredths(start_in_map.point()), destination.name.clone(), closed_doors.to_vec());
        if let Some(known) = self.0.with(|known| known.plans.get(&key).cloned()) {
            return known;
        }
        let search = |from_in_map| map.topology.plan(map.planner, from_in_map, destination, closed_doors);
        let goal = hundredths(destination.pose_in_map.point());
        let pair = map.routes.places.get(&key.0).zip(map.routes.places.get(&goal));
        let places = &map.world.places;
        let pair = pair.filter(|&(_, &to)| closed_doors.is_empty() && places[to] == *destination);
        let route = pair.and_then(|(&from, &to)| Some((places[from].pose_in_map, map.routes.between(from, to)?)));
        let plan = match route {
            None => search(start_in_map),
            Some((from_in_map, route)) => {
                // From where the place is: runs side by side share it, and whichever asks first finds the same.
                let route = route.get_or_init(|| {
                    let plan = search(from_in_map)?;
                    let points = rounded_points(from_in_map.point(), &plan.targets);
                    let legs = points.windows(2).map(|ends| searched_leg(map, ends[0], ends[1])).collect();
                    Ok(Route { plan, legs })
                });
                route.as_ref().map_err(Clone::clone).map(|route| {
                    let points = rounded_points(start_in_map.point(), &route.plan.targets);
                    let keys = points.windows(2).map(|ends| (hundredths(ends[0]), hundredths(ends[1])));
                    self.0.with(|known| known.legs.extend(keys.zip(route.legs.iter().cloned())));
                    route.plan.clone()
                })
            }
        };
        self.0.with(|known| known.plans.insert(key, plan.clone()));
        plan
    }

    /// The way between two points; none if the map leaves none. Cost: a pass over the cells, once.
    fn leg(&self, map: WayMap<'_>, from_in_map: Point, to_in_map: Point) -> Option<Arc<Leg>> {
        let key = (hundredths(from_in_map), hundredths(to_in_map));
        if let Some(known) = self.0.with(|known| known.legs.get(&key).cloned()) {
            return known;
        }
        let leg = searched_leg(map, from_in_map, to_in_map);
        self.0.with(|known| known.legs.insert(key, leg.clone()));
        leg
    }
}

/// The start and the targets, as navigation is given them: to the centimetre.
fn rounded_points(start_in_map: Point, targets: &[Target]) -> Vec<Point> {
    let rounded = |point: Point| {
        let (x, y) = hundredths(point);
        Point::new(x as f64 / 100.0, y as f64 / 100.0)
    };
    std::iter::once(start_in_map).chain(targets.iter().map(|target| target.point_in_frame)).map(rounded).collect()
}

fn searched_leg(map: WayMap<'_>, from_in_map: Point, to_in_map: Point) -> Option<Arc<Leg>> {
    let corners = map.planner.cost_to_go(to_in_map).path(from_in_map)?;
    Some(Arc::new(stretches(map.world, &corners)))
}

/// A polyline cut into stretches.
fn stretches(world: &World, corners: &[Point]) -> Leg {
    let mut leg = Leg::new();
    let mut heading_rad: Option<f64> = None;
    let mut mode = TravelMode::Hallway;
    for ends in corners.windows(2) {
        let (from, along) = (ends[0], ends[1] - ends[0]);
        let length_m = distance_m(ends[0], ends[1]);
        if length_m < 1e-9 {
            continue;
        }
        let ahead_rad = libm::atan2(along.y, along.x);
        let mut turned_rad = heading_rad.map_or(0.0, |before_rad| wrap_angle_rad(ahead_rad - before_rad).abs());
        heading_rad = Some(ahead_rad);
        let count = libm::ceil(length_m / STRETCH_M).max(1.0);
        for number in 0..count as usize {
            let at = |share: f64| from + along * (share / count);
            mode = world.mode_at(at(number as f64 + 0.5)).unwrap_or(mode);
            let (to_in_map, length_m) = (at(number as f64 + 1.0), length_m / count);
            leg.push(Stretch { to_in_map, length_m, mode, turned_rad, door: None });
            turned_rad = 0.0;
        }
    }
    note_doors(world, &mut leg);
    leg
}

/// Notes each door in the stretch that comes nearest to its middle.
fn note_doors(world: &World, leg: &mut Leg) {
    for (index, door) in world.doors.iter().enumerate() {
        let near = |stretch: &&mut Stretch| distance_m(stretch.to_in_map, door.at) <= THROUGH_DOOR_M;
        let away_m = |stretch: &&mut Stretch| distance_m(stretch.to_in_map, door.at);
        let through = leg.iter_mut().filter(near).min_by(|a, b| away_m(a).total_cmp(&away_m(b)));
        if let Some(stretch) = through.filter(|stretch| stretch.mode == TravelMode::Doorway) {
            stretch.door = Some(index);
        }
    }
}

/// A drive: where it leads, and what makes it long.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// In order; those of all legs.
    pub stretches: Vec<Stretch>,
    /// Number of stretches up to each target.
    pub targets_at: Vec<usize>,
    /// The heading at its end.
    pub last_heading_rad: f64,
    /// The turn at its end.
    pub last_turn_rad: f64,
}

impl Way {
    /// From a pose over targets, in order; none if the map leaves no way to one of them.
    pub fn over(ways: &Ways, map: WayMap<'_>, start_in_map: Pose, targets: &[Target]) -> Option<Self> {
        let (mut at, mut heading_rad) = (start_in_map.point(), start_in_map.heading_rad);
        let mut way = Self { stretches: Vec::new(), targets_at: Vec::new(), last_heading_rad: 0.0, last_turn_rad: 0.0 };
        for target in targets {
            let leg = ways.leg(map, at, target.point_in_frame)?;
            for (number, stretch) in leg.iter().enumerate() {
                let ahead = stretch.to_in_map - at;
                let ahead_rad = libm::atan2(ahead.y, ahead.x);
                let mut stretch = *stretch;
                if number == 0 {
                    stretch.turned_rad = wrap_angle_rad(ahead_rad - heading_rad).abs();
                }
                (at, heading_rad) = (stretch.to_in_map, ahead_rad);
                way.stretches.push(stretch);
            }
            way.targets_at.push(way.stretches.len());
            at = target.point_in_frame;
        }
        let last_rad = targets.last().and_then(|target| target.heading_rad).unwrap_or(heading_rad);
        way.last_turn_rad = wrap_angle_rad(last_rad - heading_rad).abs();
        way.last_heading_rad = last_rad;
        Some(way)
    }

    /// What makes it long.
    pub fn features(&self) -> WayFeatures {
        let mut features = WayFeatures { turned_rad: self.last_turn_rad, ..WayFeatures::default() };
        for stretch in &self.stretches {
            features.add(stretch.mode, stretch.length_m);
            features.turned_rad += stretch.turned_rad;
        }
        features
    }

    /// Doors on it.
    pub fn doors(&self) -> impl Iterator<Item = usize> {
        self.stretches.iter().filter_map(|stretch| stretch.door)
    }
}
