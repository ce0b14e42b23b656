//! The behaviour `navigation`: drives from target point to target point, whatever stands in the way.

use super::alignment::aligned;
use super::doorways::{DoorMemory, Doorway, barriers};
use super::dynamic_window::{DriveLimits, DynamicWindow, Speeds, WindowInput};
use super::obstacle_memory::{ObstacleMemory, RememberedPoint, Transform};
use super::planner::{PlannerModel, PlannerParameters};
use super::progress::Progress;
use super::topological::{Target, is_passed};
use super::value_field::{ValueField, path_length_m};
use crate::geometry::{Point, Pose, distance_m, wrap_angle_rad};
use crate::localization::SONARS;
use crate::world::{TravelMode, World};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What navigation needs to know of the world and the robot. Immutable; share it.
#[derive(Clone, Debug)]
pub struct NavigationModel {
    /// The map.
    pub planner: PlannerModel,
    /// The doors that the map shows open.
    pub doorways: Vec<Doorway>,
    /// The robot.
    pub limits: DriveLimits,
}

impl NavigationModel {
    /// Edge of a cell of the planner's map.
    pub const CELL_M: f64 = 0.1;

    /// The map of a world at 10 cm, and its doors.
    pub fn new(world: &World, limits: DriveLimits) -> Self {
        let planner = PlannerModel::new(&world.map(Self::CELL_M), PlannerParameters::default());
        Self { planner, doorways: Doorway::all(world), limits }
    }
}

/// What one step gets to know.
#[derive(Clone, Copy, Debug)]
pub struct NavigationInput<'a> {
    /// Dead reckoning.
    pub odometry_in_odom: Pose,
    /// As measured.
    pub speeds: Speeds,
    /// Distances from the robot's centre, sonar i at i · 15°; `None` while the sonars are off.
    pub sonar_m: Option<&'a [f32; SONARS]>,
    /// Distances from the robot's centre, a degree apart, from right to left about straight ahead;
    /// `None` without a laser.
    pub laser_m: Option<&'a [f32]>,
    /// Whether something touches the robot.
    pub bumped: bool,
}

/// Something that happened in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum NavigationEvent {
    /// A target was passed, and there are more.
    TargetReached,
    /// The robot stands at the last target and looks the way it was to.
    Arrived,
    /// The map shows no way to the target.
    Unreachable,
    /// There is a way in the map, but for long the robot has not got on.
    Blocked,
}

/// What blocks a way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstruction {
    /// A door found closed, as an index into the world's doors.
    Door(usize),
    /// Something that is not in the map, at this point of it.
    Thing(Point),
}

/// What a step decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NavigationOutput {
    /// To command.
    pub speeds: Speeds,
    /// Targets not yet reached.
    pub remaining_targets: usize,
    /// Whether the robot is held up and must see, even in a doorway.
    ///
    /// # Deviation
    /// The paper's robot drives through doorways with its sonars off. So does this one while it gets
    /// on; a door found closed or a wrong estimate can only be seen.
    pub needs_sonars: bool,
    /// What happened, if anything.
    pub event: Option<NavigationEvent>,
}

/// An unmapped obstacle the planner is to avoid for a while.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Blockage {
    /// On a grid of 10 cm in the map, by which blockages are kept apart and in order.
    cell: (i32, i32),
    until_s: f64,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
enum Phase {
    #[default]
    Idle,
    Driving,
    /// At the last target, turning to its heading.
    Turning,
}

/// State of the navigation.
///
/// The value field of the current target is kept beside the state, but is no part of it: it follows
/// from target and blockages, is not saved, and does not count in comparisons.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Navigation {
    phase: Phase,
    /// Targets not yet reached.
    targets: Vec<Target>,
    now_s: f64,
    memory: ObstacleMemory,
    doors: DoorMemory,
    window: DynamicWindow,
    /// Sorted by cell.
    blockages: Vec<Blockage>,
    /// Until then blockages are not planned around: with them there was no way.
    trusting_map_until_s: f64,
    /// Until then doors found closed are not planned around: there was no other way.
    trying_doors_until_s: f64,
    next_look_s: f64,
    /// Until then the robot must see where it is.
    sonars_until_s: f64,
    progress: Progress,
    /// Estimate and odometry of the step before.
    last: Option<(Pose, Pose)>,
    without_way_s: f64,
    #[serde(skip)]
    cache: FieldCache,
}

#[derive(Clone, Debug, Default)]
struct FieldCache(Option<CachedFields>);

#[derive(Clone, Debug)]
struct CachedFields {
    target_in_map: Point,
    barriers_in_map: Vec<Point>,
    blocked_in_map: Vec<Point>,
    fields: Fields,
}

/// The value of every cell for the current target.
#[derive(Clone, Debug)]
struct Fields {
    /// As the map has it, but for doors found closed.
    mapped: Arc<ValueField>,
    /// With the blockages besides.
    around: Arc<ValueField>,
}

impl FieldCache {
    fn bytes_apart(&self, earlier: &Self) -> usize {
        let Some(CachedFields { fields, .. }) = &self.0 else { return 0 };
        let known: Vec<&Arc<ValueField>> =
            earlier.0.iter().flat_map(|cached| [&cached.fields.mapped, &cached.fields.around]).collect();
        let is_new = |field: &&Arc<ValueField>| !known.iter().any(|known| Arc::ptr_eq(known, field));
        [&fields.mapped, &fields.around].into_iter().filter(is_new).map(|field| field.bytes()).sum()
    }
}

impl PartialEq for FieldCache {
    /// A cache is what it was computed from, which is compared elsewhere.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// An intermediate target counts as reached from here.
const PASSING_M: f64 = 0.3;
/// The last target counts as reached from here.
const ARRIVAL_M: f64 = 0.15;
/// Something stands so near to the last target that the robot gets no nearer: after so long it
/// counts as reached from here.
const CROWDED_ARRIVAL_M: f64 = 0.3;
const CROWDED_S: f64 = 5.0;
/// After being held up or touched the robot wants its sonars for so long.
const LOOK_AROUND_S: f64 = 5.0;
/// Carried farther than this by braking and turning, the robot drives again.
const LEFT_AGAIN_M: f64 = 0.4;
/// The robot stops turning this near to the wanted heading; 10° would do.
const HEADING_TOLERANCE_RAD: f64 = 0.1;
/// How far along the way the point lies that the collision avoidance heads for.
const LOOKAHEAD_M: f64 = 2.0;
/// And no nearer than this: towards a corner at its side the robot would turn to and fro.
const AT_HAND_M: f64 = 0.3;
/// So long without a way in the map is unreachable; the estimate may be wrong for a moment.
const UNREACHABLE_S: f64 = 1.0;
/// The way ahead is checked for unmapped obstacles this often.
const LOOK_S: f64 = 0.5;
/// And this far.
const LOOK_M: f64 = 2.0;
/// An obstacle point this far from all obstacles of the map is unmapped.
const UNMAPPED_M: f64 = 0.3;
/// Readings up to this are sharp enough to plan around.
const SHARP_RANGE_M: f64 = 1.5;
/// Blockages are planned around for so long, or until they are seen to be gone: a way around them may
/// lead out of sight of them.
const BLOCKAGE_S: f64 = 90.0;
/// From so near what stands at a blockage is seen, as a point at most so far off.
const BLOCKAGE_SIGHT_M: f64 = 1.0;
const BLOCKAGE_OFF_M: f64 = 0.2;
/// And edges of their cells are so long.
const BLOCKAGE_GRAIN_M: f64 = 0.1;
/// Where there is no way around them, blockages or closed doors are not planned around for so long.
const TRUSTING_MAP_S: f64 = 5.0;
/// An estimate that moves so much more than the odometry has jumped.
const JUMP_M: f64 = 0.4;
const JUMP_RAD: f64 = 0.5;
/// Obstacles of the map are looked up this far around the robot while the sonars are off.
const MAP_SUPPORT_M: f64 = 1.2;

impl Navigation {
    /// How long a robot that is told nothing else waits where it gets no nearer: doors are closed for a
    /// minute now and then, and people stand and talk.
    pub const PATIENCE_S: f64 = 120.0;

    /// Bytes of planned ways that an earlier state does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        self.cache.bytes_apart(&earlier.cache)
    }

    /// Begins to drive to these targets, in order, instead of any others. What the sensors saw and
    /// which doors were found closed is kept. The way is blocked when for `patience_s` the robot has
    /// come no nearer.
    pub fn start(&mut self, targets: Vec<Target>, patience_s: f64) {
        let (memory, doors) = (std::mem::take(&mut self.memory), std::mem::take(&mut self.doors));
        let phase = if targets.is_empty() { Phase::Idle } else { Phase::Driving };
        *self = Self {
            phase,
            targets,
            memory,
            doors,
            now_s: self.now_s,
            next_look_s: self.now_s,
            progress: Progress::from(self.now_s, patience_s),
            ..Self::default()
        };
    }

    /// Deletes all targets: how another process interrupts the navigation. Not an arrival.
    pub fn remove_all_targets(&mut self) {
        self.start(Vec::new(), Self::PATIENCE_S);
    }

    /// Targets not yet reached.
    pub fn remaining_targets(&self) -> &[Target] {
        &self.targets
    }

    /// The doors found closed, as indices into the world's doors.
    pub fn closed_doors(&self) -> Vec<usize> {
        self.doors.closed(self.now_s)
    }

    /// Whether there is anything to do.
    pub fn is_active(&self) -> bool {
        self.phase != Phase::Idle
    }

    /// The intermediate targets not yet reached: the corners of the way to the current target.
    pub fn intermediate_targets(&mut self, model: &NavigationModel, estimated_in_map: Pose) -> Vec<Point> {
        let Some(target) = self.targets.first().copied() else { return Vec::new() };
        let path = self.fields(model, target).around.path(estimated_in_map.point()).unwrap_or_default();
        path.into_iter().skip(1).collect()
    }

    /// One step of `model.limits.step_s`. Also takes in the sonars when there is nothing to do, so
    /// that the memory of obstacles is fresh when there is.
    pub fn step(
        &mut self,
        model: &NavigationModel,
        estimated_in_map: Pose,
        input: &NavigationInput<'_>,
        mode: TravelMode,
    ) -> NavigationOutput {
        let limits = &model.limits;
        self.now_s += limits.step_s;
        let (sonar_m, laser_m) = (input.sonar_m, input.laser_m);
        let odom_in_map = Transform::new(estimated_in_map.compose(input.odometry_in_odom.inverse()));
        let off_map_m = |point_in_odom| model.planner.off_obstacle_m(odom_in_map.apply(point_in_odom));
        self.memory.update(
            input.odometry_in_odom,
            sonar_m,
            laser_m,
            limits.sonar_max_range_m,
            limits.step_s,
            off_map_m,
        );
        self.memory.feel(input.odometry_in_odom, limits.robot_radius_m, input.bumped);
        if input.bumped || self.window.is_held_up() {
            self.sonars_until_s = self.now_s + LOOK_AROUND_S;
        } else if mode == TravelMode::Doorway && self.now_s < self.sonars_until_s {
            // Not off again half way through the door: memory and estimate were not good enough.
            self.sonars_until_s = self.sonars_until_s.max(self.now_s + 1.0);
        }
        self.notice_jump(estimated_in_map, input.odometry_in_odom);
        let passed = self.drop_reached(&model.planner, estimated_in_map.point());
        match self.phase {
            Phase::Idle => self.output(Speeds::default(), None),
            Phase::Turning => self.turn(limits, estimated_in_map, input.speeds),
            Phase::Driving => {
                let mut output = self.drive(model, estimated_in_map, input, mode);
                if passed {
                    output.event = output.event.or(Some(NavigationEvent::TargetReached));
                }
                output
            }
        }
    }

    fn output(&self, speeds: Speeds, event: Option<NavigationEvent>) -> NavigationOutput {
        let needs_sonars = self.phase != Phase::Idle && self.now_s < self.sonars_until_s;
        NavigationOutput { speeds, remaining_targets: self.targets.len(), needs_sonars, event }
    }

    fn finish(&mut self, event: NavigationEvent) -> NavigationOutput {
        self.phase = Phase::Idle;
        if event == NavigationEvent::Arrived {
            self.targets.clear();
        }
        self.output(Speeds::default(), Some(event))
    }

    /// An estimate that jumped makes old progress, blockages and doors meaningless.
    fn notice_jump(&mut self, estimated_in_map: Pose, odometry_in_odom: Pose) {
        if let Some((estimated_before, odometry_before)) = self.last {
            let expected = estimated_before.compose(odometry_in_odom.relative_to(odometry_before));
            let off_rad = wrap_angle_rad(estimated_in_map.heading_rad - expected.heading_rad).abs();
            if estimated_in_map.distance_m(expected) > JUMP_M || off_rad > JUMP_RAD {
                self.blockages.clear();
                self.doors = DoorMemory::default();
                self.window = DynamicWindow::default();
                self.progress.measure_other_way();
                self.next_look_s = self.now_s;
            }
        }
        self.last = Some((estimated_in_map, odometry_in_odom));
    }

    /// Drops the targets at hand or behind; true if there were any.
    fn drop_reached(&mut self, planner: &PlannerModel, here: Point) -> bool {
        let before = self.targets.len();
        while let [current, next, ..] = self.targets[..] {
            let is_near = distance_m(here, current.point_in_map) <= PASSING_M;
            if !is_near && !is_passed(planner, here, current.point_in_map, next.point_in_map) {
                break;
            }
            self.targets.remove(0);
            self.progress.measure_other_way();
        }
        if let [last] = self.targets[..] {
            let away_m = distance_m(here, last.point_in_map);
            self.phase = match self.phase {
                Phase::Driving if away_m <= ARRIVAL_M => Phase::Turning,
                Phase::Turning if away_m > LEFT_AGAIN_M => Phase::Driving,
                phase => phase,
            };
        }
        self.targets.len() < before
    }

    fn turn(&mut self, limits: &DriveLimits, estimated_in_map: Pose, speeds: Speeds) -> NavigationOutput {
        let wanted_rad = self.targets.last().and_then(|target| target.heading_rad);
        match turn_to(limits, wanted_rad, estimated_in_map, speeds) {
            Some(speeds) => self.output(speeds, None),
            None => self.finish(NavigationEvent::Arrived),
        }
    }

    /// What stands in the way that the map shows to the next target, as far as the sensors tell:
    /// nothing tells a thing from a person who stands.
    pub fn obstruction(
        &self,
        model: &NavigationModel,
        estimated_in_map: Pose,
        odometry_in_odom: Pose,
    ) -> Option<Obstruction> {
        let here = estimated_in_map.point();
        let field = model.planner.value_field(self.targets.first()?.point_in_map);
        let way = field.way_ahead(here, f64::INFINITY)?;
        let is_on_way = |at: Point, reach_m: f64| way.iter().any(|&on_way| distance_m(on_way, at) <= reach_m);
        let nearest = |one: &Point, other: &Point| distance_m(here, *one).total_cmp(&distance_m(here, *other));
        let closed = self.closed_doors();
        let doors = model.doorways.iter().filter(|doorway| closed.contains(&doorway.door));
        let doors = doors.filter(|doorway| is_on_way(doorway.at, doorway.width_m / 2.0));
        let door = doors.min_by(|one, other| nearest(&one.at, &other.at));
        let mut points = self.unmapped_points(model, estimated_in_map, odometry_in_odom);
        points.extend(self.blockages.iter().map(Blockage::point_in_map));
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

    fn drive(
        &mut self,
        model: &NavigationModel,
        estimated_in_map: Pose,
        input: &NavigationInput<'_>,
        mode: TravelMode,
    ) -> NavigationOutput {
        let estimated_in_map = if input.sonar_m.is_some() {
            estimated_in_map
        } else {
            aligned(&model.planner, &self.memory, input.odometry_in_odom, estimated_in_map)
        };
        let here = estimated_in_map.point();
        let Some(target) = self.targets.first().copied() else { return self.finish(NavigationEvent::Arrived) };
        self.look_for_blockages(model, estimated_in_map, input.odometry_in_odom, target);
        let Some((target, towards_in_map)) = self.towards(model, here, target) else {
            self.without_way_s += model.limits.step_s;
            if self.without_way_s > UNREACHABLE_S {
                return self.finish(NavigationEvent::Unreachable);
            }
            return self.output(Speeds::default(), None);
        };
        self.without_way_s = 0.0;
        let remaining_m = self.remaining_m(here);
        if self.has_stalled(model, here, target) {
            return self.finish(NavigationEvent::Blocked);
        }
        if self.targets.len() == 1
            && distance_m(here, target.point_in_map) <= CROWDED_ARRIVAL_M
            && self.progress.since_s(self.now_s) > CROWDED_S
        {
            self.phase = Phase::Turning;
        }
        let map_in_base = Transform::new(estimated_in_map.inverse());
        let mut obstacles_in_base = Vec::new();
        self.memory.append_in_base(input.odometry_in_odom, &mut obstacles_in_base);
        if input.sonar_m.is_none() {
            let mapped = model.planner.obstacle_edges_near(here, MAP_SUPPORT_M);
            obstacles_in_base.extend(mapped.into_iter().map(|point| map_in_base.apply(point)));
        }
        let choice = self.window.step(
            &model.limits,
            &WindowInput {
                odometry_in_odom: input.odometry_in_odom,
                speeds: input.speeds,
                obstacles_in_base: &obstacles_in_base,
                target_in_base: map_in_base.apply(towards_in_map),
                speed_limit_mps: model.limits.speed_limit_mps(mode),
                remaining_m,
            },
        );
        self.output(choice.speeds, None)
    }

    /// The target and the point to head for. If something stands at an intermediate target, the next target is
    /// headed for instead. Without any way the blockages are forgotten, for some may have gone. If
    /// there still is none, doors found closed are tried: somebody may open them.
    fn towards(&mut self, model: &NavigationModel, here: Point, target: Target) -> Option<(Target, Point)> {
        let towards = self.fields(model, target).around.lookahead(here, AT_HAND_M, LOOKAHEAD_M);
        if towards.is_some() || (self.blockages.is_empty() && self.avoided_doors().is_empty()) {
            return Some((target, towards?));
        }
        if let [_, next, ..] = self.targets[..]
            && let Some(towards) = self.fields(model, next).around.lookahead(here, AT_HAND_M, LOOKAHEAD_M)
        {
            self.targets.remove(0);
            self.progress.measure_other_way();
            return Some((next, towards));
        }
        self.trust_map();
        if let Some(towards) = self.fields(model, target).around.lookahead(here, AT_HAND_M, LOOKAHEAD_M) {
            return Some((target, towards));
        }
        self.trying_doors_until_s = self.now_s + TRUSTING_MAP_S;
        Some((target, self.fields(model, target).around.lookahead(here, AT_HAND_M, LOOKAHEAD_M)?))
    }

    fn trust_map(&mut self) {
        self.blockages.clear();
        self.trusting_map_until_s = self.now_s + TRUSTING_MAP_S;
    }

    fn fields(&mut self, model: &NavigationModel, target: Target) -> Fields {
        let target_in_map = target.point_in_map;
        let barriers_in_map = barriers(&model.doorways, &self.avoided_doors());
        let blocked_in_map: Vec<Point> = self.blockages.iter().map(|blockage| blockage.point_in_map()).collect();
        let is_same =
            |cached: &CachedFields| cached.target_in_map == target_in_map && cached.barriers_in_map == barriers_in_map;
        let cached = self.cache.0.take().filter(is_same);
        if let Some(cached) = cached.clone().filter(|cached| cached.blocked_in_map == blocked_in_map) {
            self.cache.0 = Some(cached.clone());
            return cached.fields;
        }
        let mapped = cached.map_or_else(
            || Arc::new(model.planner.value_field_around(target_in_map, &barriers_in_map)),
            |cached| cached.fields.mapped,
        );
        let around = if blocked_in_map.is_empty() {
            mapped.clone()
        } else {
            let all = [&barriers_in_map[..], &blocked_in_map].concat();
            Arc::new(model.planner.value_field_around(target_in_map, &all))
        };
        let fields = Fields { mapped, around };
        self.cache.0 = Some(CachedFields { target_in_map, barriers_in_map, blocked_in_map, fields: fields.clone() });
        fields
    }

    /// The doors found closed, unless there was no other way.
    fn avoided_doors(&self) -> Vec<usize> {
        if self.now_s < self.trying_doors_until_s { Vec::new() } else { self.closed_doors() }
    }

    fn remaining_m(&self, here: Point) -> f64 {
        let points: Vec<Point> =
            std::iter::once(here).chain(self.targets.iter().map(|target| target.point_in_map)).collect();
        path_length_m(&points)
    }

    /// Whether the robot has not come nearer for long. If so for a while, it begins anew.
    fn has_stalled(&mut self, model: &NavigationModel, here: Point, target: Target) -> bool {
        let fields = self.fields(model, target);
        if let Some(cost_m) = fields.mapped.cost_m(here) {
            let avoided_doors = self.avoided_doors();
            self.progress.measure(self.now_s, cost_m, avoided_doors, fields.around.cost_m(here));
            if self.progress.is_time_to_begin_anew(self.now_s) {
                self.begin_anew();
            }
        }
        self.progress.has_stalled(self.now_s)
    }

    /// What holds the robot up may be an echo long gone: it looks again, and tries the map's way.
    fn begin_anew(&mut self) {
        self.progress.begin_anew(self.now_s);
        self.memory.forget();
        self.window = DynamicWindow::default();
        self.trust_map();
        self.sonars_until_s = self.now_s + LOOK_AROUND_S;
    }

    /// Turns unmapped obstacle points into blockages if any of them stands on the way ahead. People
    /// who walk are left to the collision avoidance: until a way around them is planned they are
    /// elsewhere, and with twenty of them about the ways would never be the same for a second.
    fn look_for_blockages(
        &mut self,
        model: &NavigationModel,
        estimated_in_map: Pose,
        odometry_in_odom: Pose,
        target: Target,
    ) {
        if self.now_s < self.next_look_s {
            return;
        }
        self.next_look_s = self.now_s + LOOK_S;
        self.forget_blockages(estimated_in_map, odometry_in_odom);
        self.look_at_doors(model, estimated_in_map, odometry_in_odom);
        if self.now_s >= self.trusting_map_until_s {
            let unmapped = self.unmapped_points(model, estimated_in_map, odometry_in_odom);
            let way = self.fields(model, target).around.way_ahead(estimated_in_map.point(), LOOK_M).unwrap_or_default();
            let reach_m = model.limits.robot_radius_m + 0.03;
            let stands_in_way = |point: &Point| way.iter().any(|&on_way| distance_m(on_way, *point) < reach_m);
            if unmapped.iter().any(stands_in_way) {
                self.block(&unmapped);
            }
        }
    }

    /// What was planned around long ago is forgotten, and what is seen to be gone.
    fn forget_blockages(&mut self, estimated_in_map: Pose, odometry_in_odom: Pose) {
        let points = self.sharp_points(estimated_in_map, odometry_in_odom, |_| true);
        let (here, now_s) = (estimated_in_map.point(), self.now_s);
        self.blockages.retain(|blockage| {
            let at = blockage.point_in_map();
            let is_far = distance_m(here, at) > BLOCKAGE_SIGHT_M;
            let is_there = is_far || points.iter().any(|&point| distance_m(point, at) <= BLOCKAGE_OFF_M);
            is_there && blockage.until_s > now_s
        });
    }

    /// A door found closed, or open again, is a new task: there is time for the way that is now the
    /// best, and nothing to escape from.
    fn look_at_doors(&mut self, model: &NavigationModel, estimated_in_map: Pose, odometry_in_odom: Pose) {
        let before = self.closed_doors();
        let points = self.sharp_points(estimated_in_map, odometry_in_odom, |_| true);
        let robot_width_m = 2.0 * model.limits.robot_radius_m;
        let here = estimated_in_map.point();
        self.doors.look(&model.doorways, here, &points, robot_width_m, self.now_s, LOOK_S);
        if self.closed_doors() != before {
            self.progress.start_again(self.now_s);
            self.window = DynamicWindow::default();
        }
    }

    fn sharp_points(
        &self,
        estimated_in_map: Pose,
        odometry_in_odom: Pose,
        counts: impl Fn(&RememberedPoint) -> bool,
    ) -> Vec<Point> {
        let odom_in_map = Transform::new(estimated_in_map.compose(odometry_in_odom.inverse()));
        let sharp = self.memory.points().iter().filter(|point| point.range_m <= SHARP_RANGE_M && counts(point));
        sharp.map(|point| odom_in_map.apply(point.point_in_odom)).collect()
    }

    fn unmapped_points(&self, model: &NavigationModel, estimated_in_map: Pose, odometry_in_odom: Pose) -> Vec<Point> {
        let mut points = self.sharp_points(estimated_in_map, odometry_in_odom, RememberedPoint::stands);
        points.retain(|&point_in_map| model.planner.obstacle_distance_m(point_in_map) > UNMAPPED_M);
        points
    }

    fn block(&mut self, points_in_map: &[Point]) {
        let until_s = self.now_s + BLOCKAGE_S;
        for point in points_in_map {
            let cell = (libm::floor(point.x / BLOCKAGE_GRAIN_M) as i32, libm::floor(point.y / BLOCKAGE_GRAIN_M) as i32);
            match self.blockages.binary_search_by(|blockage| blockage.cell.cmp(&cell)) {
                Ok(index) => self.blockages[index].until_s = until_s,
                Err(index) => self.blockages.insert(index, Blockage { cell, until_s }),
            }
        }
    }
}

/// The speeds that turn the robot on the spot to a heading; `None` once it stands and looks there.
pub(super) fn turn_to(limits: &DriveLimits, wanted_rad: Option<f64>, here: Pose, speeds: Speeds) -> Option<Speeds> {
    let off_rad = wanted_rad.map_or(0.0, |wanted_rad| wrap_angle_rad(wanted_rad - here.heading_rad));
    if off_rad.abs() > HEADING_TOLERANCE_RAD {
        return Some(Speeds { translation_mps: 0.0, rotation_radps: limits.braked_turn_radps(off_rad) });
    }
    let stands = speeds.translation_mps.abs() < 0.02 && speeds.rotation_radps.abs() < 0.1;
    (!stands).then(Speeds::default)
}

impl Blockage {
    fn point_in_map(&self) -> Point {
        let middle = |cell: i32| (f64::from(cell) + 0.5) * BLOCKAGE_GRAIN_M;
        Point::new(middle(self.cell.0), middle(self.cell.1))
    }
}
