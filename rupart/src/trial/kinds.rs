//! Whether the kind of case comes back that is needed, for each reason to retrieve one.

use crate::case::{Case, Content, Goal, Kind, MetaPlan};
use crate::control::BehaviourParameters;
use crate::memory::CaseMemory;
use crate::places::{PlaceId, Places};
use crate::route::Route;
use crate::routes::{TravelTimes, learn_route};
use crate::similarity::{Comparison, Scales, Similarity};
use crate::situation::{Feature, Situation};
use rpl_random::Stream;
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::{Point, Pose};
use rpl_robot::occupancy::DistanceField;
use rpl_robot::sensors::SonarMount;
use rpl_robot::world::World;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;
use std::sync::Arc;

/// Edge of a cell of the map that sonars hear.
const RESOLUTION_M: f64 = 0.05;

/// Cases of each kind: twenty routes and nine behaviours (Fox and Anderson-Sprecher, RUPART Architecture), and of
/// the second phase what a day of deliveries leaves.
const ROUTES: usize = 20;
const BEHAVIOURS: usize = 9;
const GOALS: usize = 3;

/// Why a case is retrieved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Reason {
    /// There is a goal, and no route to it; also after an unexpected landmark or a place that was not reached,
    /// which erase the route.
    NewGoal,
    /// Some seconds have passed on the way, or there is no progress.
    OnTheWay,
    /// The goal was reached.
    GoalReached,
    /// The robot does not know where it is.
    Lost,
}

impl Reason {
    /// All of them.
    pub const ALL: [Reason; 4] = [Self::NewGoal, Self::OnTheWay, Self::GoalReached, Self::Lost];

    /// As tables call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::NewGoal => "new goal",
            Self::OnTheWay => "on the way",
            Self::GoalReached => "goal reached",
            Self::Lost => "lost",
        }
    }

    /// What the robot needs then.
    pub fn needed(self) -> Kind {
        match self {
            Self::NewGoal => Kind::Route,
            Self::OnTheWay => Kind::Behaviour,
            Self::GoalReached => Kind::Goal,
            Self::Lost => Kind::MetaPlan,
        }
    }
}

/// Which kinds of cases the memory has (Fox and Anderson-Sprecher, Conclusions).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Routes and behaviours.
    First,
    /// Goals and meta-plans besides.
    Second,
}

impl Phase {
    /// Why cases are retrieved in it.
    pub fn reasons(self) -> &'static [Reason] {
        match self {
            Self::First => &Reason::ALL[..2],
            Self::Second => &Reason::ALL,
        }
    }
}

/// How kinds are told apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Telling {
    /// By what is missing, which outweighs all that may differ.
    Certain,
    /// By unit weights.
    UnitWeights,
    /// By unit weights, and what is missing on one side counts nothing.
    MissingIgnored,
    /// By unit weights, every kind compared by everything.
    NothingForeign,
}

impl Telling {
    /// How cases are compared.
    pub fn similarity(self, scales: Scales) -> Similarity {
        let certain = Similarity::new(scales);
        match self {
            Self::Certain => certain,
            Self::UnitWeights => Similarity { missing: Similarity::UNIT_WEIGHTS, ..certain },
            Self::MissingIgnored => Similarity { missing: [0.0; Feature::COUNT], ..certain },
            Self::NothingForeign => Similarity {
                missing: Similarity::UNIT_WEIGHTS,
                comparisons: [[Comparison::Distance; Feature::COUNT]; Kind::ALL.len()],
                ..certain
            },
        }
    }
}

/// What came back for a reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct KindRetrieved {
    /// Why something was retrieved.
    pub reason: Reason,
    /// What came back.
    pub kind: Kind,
}

/// A building, and what a robot hears in it.
pub struct KindGround {
    world: World,
    places: Places,
    robot: Arc<RobotDescription>,
    field: DistanceField,
}

impl KindGround {
    /// O(cells of the map).
    pub fn new(world: World, places: Places, robot: Arc<RobotDescription>) -> Self {
        let field = DistanceField::new(&world.map(RESOLUTION_M));
        Self { world, places, robot, field }
    }

    /// A memory and situations of a seed, `each` of them for each reason; the same however kinds are told apart.
    pub fn retrieve(&self, telling: Telling, phase: Phase, each: usize, seed: u64) -> Vec<KindRetrieved> {
        let mut stream = Stream::new(seed, "kinds");
        let memory = self.memory(telling, phase, &mut stream);
        let mut retrieved = Vec::new();
        for &reason in phase.reasons() {
            for _ in 0..each {
                let asked = self.situation(reason, &mut stream);
                retrieved.extend(memory.retrieve(&asked).map(|found| KindRetrieved { reason, kind: found.best.kind }));
            }
        }
        retrieved
    }

    fn memory(&self, telling: Telling, phase: Phase, stream: &mut Stream) -> CaseMemory {
        let location_m = self.world.size_m.norm();
        let mut memory = CaseMemory::new(telling.similarity(Scales { location_m, ..Scales::default() }));
        let map = TravelTimes::of_map(&self.places, 1.0);
        for _ in 0..100 * ROUTES {
            let (from, to) = (self.place(stream), self.place(stream));
            let way = map.quickest_way(&self.places, from, to).filter(|way| way.places.len() > 1);
            if let Some(way) = way.filter(|_| memory.len() < ROUTES) {
                learn_route(&mut memory, &self.places, Route::over(&way.places));
            }
        }
        for _ in 0..BEHAVIOURS {
            let index = self.situation(Reason::OnTheWay, stream);
            memory.retain(Case::new(index, Content::Behaviour(BehaviourParameters::default())));
        }
        if phase == Phase::Second {
            self.add_second_phase(&mut memory, stream);
        }
        memory
    }

    fn add_second_phase(&self, memory: &mut CaseMemory, stream: &mut Stream) {
        for _ in 0..GOALS {
            let place_in_map = self.places.at_in_map(self.place(stream));
            let index = Situation {
                place_in_map: Some(place_in_map),
                priority: Some(stream.uniform()),
                time_s: stream.chance(0.5).then(|| stream.uniform_in(0.0, 3600.0)),
                ..Situation::default()
            };
            memory.retain(Case::new(index, Content::Goal(Goal { place_in_map })));
        }
        for goal in [None, Some(self.world.bounds().centre())] {
            let index = Situation { long_term_goal_in_map: goal, ..Situation::default() };
            memory.retain(Case::new(index, Content::MetaPlan(MetaPlan::LocalizeFirst)));
        }
    }

    fn place(&self, stream: &mut Stream) -> PlaceId {
        PlaceId(stream.index(self.places.count()) as u32)
    }

    /// A situation in which there is this reason to retrieve: the robot stands on a stretch between two places,
    /// somehow turned.
    pub fn situation(&self, reason: Reason, stream: &mut Stream) -> Situation {
        let from = self.place(stream);
        let stretches = &self.places.stretches[from.index()];
        let to = stretches.get(stream.index(stretches.len().max(1))).map_or(from, |stretch| stretch.to);
        let (from_in_map, to_in_map) = (self.places.at_in_map(from), self.places.at_in_map(to));
        let at = from_in_map + (to_in_map - from_in_map) * stream.uniform();
        let robot_in_map = Pose::new(at.x, at.y, stream.uniform_in(-PI, PI));
        let goal = self.places.at_in_map(self.place(stream));
        let sonars_m = self.sonars_m(robot_in_map);
        let is_driving = reason == Reason::OnTheWay;
        let sensed = Situation {
            mean_sonars_m: sonars_m
                .as_ref()
                .map(|ranges_m| ranges_m.iter().map(|range_m| range_m * stream.uniform_in(0.9, 1.1)).collect()),
            sonars_m,
            translation_mps: Some(if is_driving { stream.uniform_in(0.0, 0.8) } else { 0.0 }),
            rotation_radps: Some(if is_driving { stream.uniform_in(-0.8, 0.8) } else { 0.0 }),
            ..Situation::default()
        };
        match reason {
            Reason::NewGoal => Situation { long_term_goal_in_map: Some(goal), place_in_map: Some(at), ..sensed },
            Reason::OnTheWay => {
                Situation { short_term_goal_in_map: Some(to_in_map), long_term_goal_in_map: Some(goal), ..sensed }
                    .seen_from(robot_in_map)
            }
            Reason::GoalReached => Situation {
                place_in_map: Some(at),
                priority: Some(1.0),
                time_s: Some(stream.uniform_in(0.0, 3600.0)),
                ..sensed
            },
            Reason::Lost => Situation { long_term_goal_in_map: Some(goal), ..sensed },
        }
    }

    /// What the sonars hear of the map along their axes.
    fn sonars_m(&self, robot_in_map: Pose) -> Option<Vec<f64>> {
        let sonar = self.robot.sonar.as_ref()?;
        let heard = |at: Point, heading_rad: f64| {
            let (sin, cos) = libm::sincos(heading_rad);
            self.field.cast_m(at, (cos, sin), sonar.range_m)
        };
        let of_mount = |mount: &SonarMount| {
            heard(robot_in_map.transform(mount.at_in_base), robot_in_map.heading_rad + mount.heading_rad)
        };
        Some(sonar.layout.mounts().iter().map(of_mount).collect())
    }
}
