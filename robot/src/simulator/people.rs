//! People who walk, and avoid each other, the walls and the robot.

use super::model::SimulatorModel;
use super::orca::{self, Disc, HalfPlane};
use super::state::SimulatorState;
use super::surface::forms_of;
use super::walker::{FASTEST_MPS, PERSON_RADIUS_M, WALL_HORIZON_S, Walker};
use crate::geometry::{Point, Vector, distance_m};
use crate::world::{Person, Solid, SolidOrigin};
use rpl_random::Stream;

/// Each person looks up and chooses a velocity in one step of this many, in turn.
const LOOK_STEPS: u64 = 5;

/// How far ahead people avoid one another and the robot.
const HORIZON_S: f64 = 2.0;

/// They do not look at people farther off.
const SIGHT_M: f64 = 3.0;

/// They hurry to get out of the way, at up to this multiple of their speed.
const HURRY: f64 = 1.3;

/// Air they keep between each other's shoulders.
const SHOULDERS_M: f64 = 0.05;

/// A goal counts as reached from here: another may stand on it.
const ARRIVAL_M: f64 = 0.5;

/// A point of a path counts as reached from here.
const PASSING_M: f64 = 0.15;

/// The spot on the way that is walked to lies so far ahead: near enough to go round a door jamb
/// by sliding along it ...
const LOOKAHEAD_M: f64 = 0.8;

/// ... and is looked up anew from here.
const NEXT_SPOT_M: f64 = 0.3;

/// The longest time for which people of the crowd stay at a goal.
const LONGEST_REST_S: f64 = 5.0;

/// Their speeds: strolling to brisk.
const SPEEDS_MPS: [f64; 2] = [0.6, 1.1];

/// No closer to the robot than this does anybody step by himself.
const STEP_SHORT_M: f64 = 0.05;

/// A touch is over when this much air is between.
const PARTED_M: f64 = 0.01;

impl SimulatorModel {
    /// The people of the world file on their paths, then the crowd, scattered over the floor.
    pub(super) fn people_at_start(&self, stream: &mut Stream) -> Vec<Walker> {
        let on_path = |person: &Person| Walker::at(person.path[0], person.speed_mps, 1);
        let mut people: Vec<Walker> = self.world.people.iter().map(on_path).collect();
        let Some(crowd) = &self.crowd else { return people };
        let closed = |door: usize| !self.world.doors[door].open;
        for _ in 0..self.world.crowd {
            let taken: Vec<Point> = people.iter().map(|walker| walker.at_in_map).collect();
            let is_free = |spot: Point| {
                let there = |solid: &&Solid| match solid.origin {
                    SolidOrigin::Door(door) => closed(door),
                    SolidOrigin::Wall | SolidOrigin::Object(_) => true,
                };
                self.solids.iter().filter(there).all(|solid| solid.outline.distance_m(spot) >= PERSON_RADIUS_M)
            };
            let at_in_map = crowd.free_spot(stream, &taken, self.world.start_in_map.point(), is_free);
            let speed_mps = stream.uniform_in(SPEEDS_MPS[0], SPEEDS_MPS[1]);
            let goal = crowd.draw(stream, at_in_map, 0, closed);
            people.push(Walker::at(at_in_map, speed_mps, goal));
        }
        people
    }

    /// Whether the goals of all people exist.
    pub(super) fn fits_people(&self, people: &[Walker]) -> bool {
        let goals = self.crowd.as_ref().map_or(0, |crowd| crowd.len());
        let exists = |index: usize, goal: usize| match self.world.people.get(index) {
            Some(person) => goal < person.path.len(),
            None => goal < goals,
        };
        people.len() == self.world.people.len() + self.world.crowd
            && people.iter().enumerate().all(|(index, walker)| exists(index, walker.goal))
    }

    /// Every person walks one step. Cost: some 0.3 µs a person, twice that in a crush.
    pub(super) fn walk(&self, state: &mut SimulatorState) {
        let step = state.time_us / self.robot().step_us;
        for index in 0..state.people.len() {
            if (step + index as u64).is_multiple_of(LOOK_STEPS) {
                let wanted_mps = self.look(state, index);
                state.people[index].velocity_mps = self.choose(state, index, wanted_mps);
            }
        }
        for index in 0..state.people.len() {
            self.go(state, index);
        }
    }

    /// Where a person would like to walk.
    fn look(&self, state: &mut SimulatorState, index: usize) -> Vector {
        let now_us = state.time_us;
        let patience_us = self.settings.person_patience_us;
        let SimulatorState { people, streams, doors_open, robot_in_map, .. } = state;
        let walker = &mut people[index];
        if now_us < walker.rests_until_us {
            return Vector::zeros();
        }
        if let Some(company) = walker.company {
            let Some(spot_in_map) = self.spot_of(walker, company, *robot_in_map) else { return Vector::zeros() };
            walker.spot_in_map = spot_in_map;
            return walker.wanted_mps();
        }
        match (self.world.people.get(index), &self.crowd) {
            (Some(person), _) => {
                let left_m = distance_m(walker.at_in_map, person.path[walker.goal]);
                if left_m <= PASSING_M {
                    walker.pass(person.path.len(), now_us);
                } else if walker.is_stuck(left_m, now_us, patience_us) {
                    walker.turn_back(now_us);
                }
                walker.spot_in_map = person.path[walker.goal];
            }
            (None, Some(crowd)) => {
                let left_m = crowd.left_m(walker.goal, walker.at_in_map);
                let arrived = left_m <= ARRIVAL_M;
                if arrived || walker.is_stuck(left_m, now_us, patience_us) {
                    let rest_s = if arrived { streams.people.uniform_in(0.0, LONGEST_REST_S) } else { 0.0 };
                    walker.rests_until_us = now_us + (rest_s * 1e6) as u64;
                    let goal = crowd.draw(&mut streams.people, walker.at_in_map, walker.goal, |door| !doors_open[door]);
                    walker.walk_to(goal, now_us);
                }
                if distance_m(walker.at_in_map, walker.spot_in_map) <= NEXT_SPOT_M {
                    walker.spot_in_map = crowd.spot_ahead(walker.goal, walker.at_in_map, LOOKAHEAD_M);
                }
            }
            (None, None) => {}
        }
        walker.wanted_mps()
    }

    /// The velocity nearest to the wanted one that avoids walls, the robot and other people.
    ///
    /// # Deviation
    /// The robot does not take part in the agreement that everybody does half of the avoiding, so
    /// people do all of it. They look in turn and not all at once.
    fn choose(&self, state: &SimulatorState, index: usize, wanted_mps: Vector) -> Vector {
        let walker = &state.people[index];
        let limit_mps = (HURRY * walker.speed_mps).min(FASTEST_MPS);
        let look_s = LOOK_STEPS as f64 * self.robot().step_s();
        let mut half_planes: Vec<HalfPlane> = Vec::with_capacity(32);
        self.for_each_body_near(state, walker.at_in_map, |nearest| {
            let reach_m = PERSON_RADIUS_M + limit_mps * WALL_HORIZON_S;
            if (nearest - walker.at_in_map).norm_squared() < reach_m * reach_m {
                half_planes.push(orca::keep_off(walker.at_in_map, PERSON_RADIUS_M, nearest, WALL_HORIZON_S));
            }
        });
        let fixed = half_planes.len();
        let near = |at: Point| (at - walker.at_in_map).norm_squared() < SIGHT_M * SIGHT_M;
        let clearance_m = self.settings.person_clearance_m;
        let robot = state.robot_in_map;
        if clearance_m > 0.0 && near(robot.point()) {
            let (sin, cos) = libm::sincos(robot.heading_rad);
            let disc = Disc {
                at_in_map: robot.point(),
                velocity_mps: Vector::new(cos, sin) * state.translation_mps,
                radius_m: self.robot().radius_m + clearance_m,
            };
            half_planes.push(orca::half_plane(walker.disc(), disc, 1.0, HORIZON_S, look_s));
        }
        let others =
            state.people.iter().enumerate().filter(|(other, person)| *other != index && near(person.at_in_map));
        for (_, person) in others {
            let disc = Disc { radius_m: PERSON_RADIUS_M + SHOULDERS_M, ..person.disc() };
            half_planes.push(orca::half_plane(walker.disc(), disc, 0.5, HORIZON_S, look_s));
        }
        orca::best_velocity(&half_planes, fixed, wanted_mps, limit_mps)
    }

    /// Gives the nearest point of every surface around a person to `mind`.
    fn for_each_body_near(&self, state: &SimulatorState, person: Point, mut mind: impl FnMut(Point)) {
        for index in self.candidates.walkable(person) {
            let surface = &self.surfaces[*index as usize];
            if state.is_there(surface.origin) && surface.form.faces(person) {
                mind(surface.form.nearest_to(person));
            }
        }
        for object in &state.objects_added {
            forms_of(&object.outline(), self.world.bounds())
                .into_iter()
                .filter(|form| form.faces(person))
                .for_each(|form| mind(form.nearest_to(person)));
        }
    }

    /// Walks one step, but never into the robot: who minds it stops short of it, who does not runs
    /// into it.
    fn go(&self, state: &mut SimulatorState, index: usize) {
        let robot = state.robot_in_map.point();
        let touch_m = self.robot().radius_m + PERSON_RADIUS_M;
        let minds = self.settings.person_clearance_m > 0.0;
        let walker = &mut state.people[index];
        let walked = walker.at_in_map + walker.velocity_mps * self.robot().step_s();
        let before = walker.at_in_map;
        let (before2, after2) = ((before - robot).norm_squared(), (walked - robot).norm_squared());
        let is_within = |reach_m: f64| after2 < reach_m * reach_m;
        if !is_within(if minds { touch_m + STEP_SHORT_M } else { touch_m }) || after2 >= before2 {
            walker.at_in_map = walked;
            walker.touching &= is_within(touch_m + PARTED_M);
            self.notice_step(state, index, before);
        } else if !minds && !walker.touching {
            walker.touching = true;
            state.contacts.run_into += 1;
        }
    }
}
