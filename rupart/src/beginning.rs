//! What a memory begins with, before anything was learned.

use crate::case::{Case, Content, MetaPlan};
use crate::control::BehaviourParameters;
use crate::memory::CaseMemory;
use crate::similarity::{Scales, Similarity};
use crate::situation::Situation;
use rpl_robot::sensors::RangeSensors;
use rpl_robot::world::World;

/// A memory without cases, which compares by the size of a building and the range of the sonars.
pub fn no_cases(world: &World, sensors: &RangeSensors) -> CaseMemory {
    let usual = Scales::default();
    let sonar_m = sensors.sonars.as_ref().map_or(usual.sonar_m, |sonars| sonars.range_m);
    CaseMemory::new(Similarity::new(Scales { location_m: world.size_m.norm(), sonar_m, ..usual }))
}

/// Nothing is near, and the short-term goal is ahead.
pub fn open_space(world: &World, sensors: &RangeSensors) -> Situation {
    let free_m = sensors.sonars.as_ref().map(|sonars| vec![sonars.range_m; sonars.mounts.len()]);
    Situation {
        sonars_m: free_m.clone(),
        mean_sonars_m: free_m,
        translation_mps: Some(BehaviourParameters::TUNED.translation_mps),
        rotation_radps: Some(0.0),
        short_term_goal_in_map: Some(world.bounds().centre()),
        short_term_goal_distance_m: Some(Scales::default().goal_distance_m / 2.0),
        short_term_goal_bearing_rad: Some(0.0),
        ..Situation::default()
    }
}

/// What a robot begins with that was never given a memory: the tuned parameters; that a robot which has lost its
/// position is to find it before it does anything else; and that a route is made on the map where there is no case
/// of one.
pub fn first_cases(world: &World, sensors: &RangeSensors) -> CaseMemory {
    let mut memory = tuned_alone(world, sensors);
    for goal in [None, Some(world.bounds().centre())] {
        let lost = Situation { long_term_goal_in_map: goal, ..Situation::default() };
        memory.retain(Case::new(lost, Content::MetaPlan(MetaPlan::LocalizeFirst)));
    }
    memory.retain(Case::new(no_route(world), Content::MetaPlan(MetaPlan::MakeRoute)));
    memory
}

/// A place, a goal, and a way to it that begins at once. Who asks for a route has none yet: this counts on top of how
/// far both are, so that any route case that is compared with them comes first.
fn no_route(world: &World) -> Situation {
    let centre = world.bounds().centre();
    Situation {
        short_term_goal_distance_m: Some(0.0),
        short_term_goal_bearing_rad: Some(0.0),
        ..Situation::of_route(centre, centre)
    }
}

/// Where no behaviour has brought the robot on: there one is to be trained.
pub fn to_be_trained(blocked: Situation) -> Case {
    let index =
        Situation { sonars_m: None, mean_sonars_m: None, translation_mps: None, rotation_radps: None, ..blocked };
    Case::new(index, Content::MetaPlan(MetaPlan::TrainBehaviour))
}

/// Whether a case is one of the meta-plans that every memory begins with, and not one that was learned.
pub fn is_standing(case: &Case) -> bool {
    match &case.content {
        Content::MetaPlan(MetaPlan::LocalizeFirst) => true,
        Content::MetaPlan(MetaPlan::MakeRoute) => case.index.short_term_goal_distance_m.is_some(),
        Content::MetaPlan(MetaPlan::TrainBehaviour) | Content::Behaviour(_) | Content::Route(_) | Content::Goal(_) => {
            false
        }
    }
}

/// A memory of one behaviour case, the tuned parameters.
pub fn tuned_alone(world: &World, sensors: &RangeSensors) -> CaseMemory {
    let mut memory = no_cases(world, sensors);
    memory.retain(Case::new(open_space(world, sensors), Content::Behaviour(BehaviourParameters::TUNED)));
    memory
}
