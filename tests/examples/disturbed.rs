//! Follows instructions in arenas while somebody interferes, and says how often the robot still arrives:
//! `cargo run --release -p rpl-tests --example disturbed`.
//!
//! `--seed S` and `--seeds N` say which arenas, `--only NAME` takes one kind of interference. Arenas in which the robot
//! does not arrive when it is left alone are not counted.

use rayon::prelude::*;
use rpl_lola::arena::{Arena, ArenaSettings};
use rpl_mission::modules::SiteRobot;
use rpl_random::Stream;
use rpl_robot::geometry::Pose;
use rpl_robot::world::World;
use rpl_runtime::run::system::{Progress, System};
use rpl_tests::deliveries::{PassedDoor, counted_along_m, delivery, door_beside, with_person_before};
use rpl_tests::mission::Run;
use std::process::ExitCode;

const UNTIL_S: f64 = 900.0;
const BETWEEN_LOOKS_US: u64 = 100_000;

/// What somebody does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Interference {
    /// Turns the robot by hand.
    Turn { by_deg: f64 },
    /// Pushes it back.
    PushBack { by_m: f64 },
    /// Stands before a door that it passes.
    StandBefore,
    /// Closes a door while the robot is beside it.
    CloseDoor,
}

const ALL: [(&str, Interference); 7] = [
    ("turn+70", Interference::Turn { by_deg: 70.0 }),
    ("turn-70", Interference::Turn { by_deg: -70.0 }),
    ("turn180", Interference::Turn { by_deg: 180.0 }),
    ("push0.4", Interference::PushBack { by_m: 0.4 }),
    ("push1.5", Interference::PushBack { by_m: 1.5 }),
    ("person", Interference::StandBefore),
    ("door", Interference::CloseDoor),
];

/// A moment at which the robot drives along a hallway and counts.
#[derive(Clone, Debug)]
struct Moment {
    at_us: u64,
    door_beside: Option<PassedDoor>,
}

/// An arena whose list leads to the goal, and when the robot counts on the way.
struct Course {
    seed: u64,
    arena: Arena,
    moments: Vec<Moment>,
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().collect();
    let option = |name: &str| {
        let at = arguments.iter().position(|argument| argument == name)?;
        arguments.get(at + 1).cloned()
    };
    let number = |name: &str, usual: u64| option(name).and_then(|text| text.parse().ok()).unwrap_or(usual);
    let (first, count) = (number("--seed", 4000), number("--seeds", 12));
    let only = option("--only");
    let courses: Vec<Course> = (first..first + count).into_par_iter().filter_map(Course::of).collect();
    println!("{} of {count} arrive when left alone", courses.len());
    for (name, what) in ALL.into_iter().filter(|(name, _)| only.as_ref().is_none_or(|only| only == name)) {
        let told: Vec<(u64, Result<(), String>)> =
            courses.par_iter().filter_map(|course| Some((course.seed, course.disturbed(what)?))).collect();
        let arrived = told.iter().filter(|(_, told)| told.is_ok()).count();
        println!("{name}: {arrived} of {} arrive", told.len());
        for (seed, why) in told.iter().filter_map(|(seed, told)| Some((seed, told.as_ref().err()?))) {
            println!("  {seed}: {why}");
        }
    }
    ExitCode::SUCCESS
}

impl Course {
    /// None if the robot does not arrive when it is left alone.
    fn of(seed: u64) -> Option<Self> {
        let arena = Arena::draw(seed, &ArenaSettings::CALM);
        let mut moments = Vec::new();
        let mut counted_m = None;
        let run = run(&arena, arena.world.clone(), seed, |system| {
            let along_m = counted_along_m(system);
            if along_m.is_some() && along_m != counted_m {
                let door_beside = door_beside(&arena, system.outside.true_pose_in_map());
                moments.push(Moment { at_us: system.machine.now_us, door_beside });
            }
            counted_m = along_m;
        });
        ended(&arena, &run).is_ok().then_some(Self { seed, arena, moments })
    }

    /// What came of it, and why not; none if there is nothing to do that with.
    fn disturbed(&self, what: Interference) -> Option<Result<(), String>> {
        let mut stream = Stream::new(self.seed, "disturbance");
        let with_door: Vec<&Moment> = self
            .moments
            .iter()
            .filter(|moment| moment.door_beside.as_ref().is_some_and(|door| fits(what, door)))
            .collect();
        let needs_door = matches!(what, Interference::StandBefore | Interference::CloseDoor);
        let moments: Vec<&Moment> = if needs_door { with_door } else { self.moments.iter().collect() };
        let moment = *moments.get((stream.uniform() * moments.len() as f64) as usize)?;
        let door = moment.door_beside.as_ref();
        let stood_before = door.filter(|_| what == Interference::StandBefore);
        let world = stood_before.map_or_else(|| self.arena.world.clone(), |door| with_person_before(&self.arena, door));
        let mut is_done = false;
        let mut refused = None;
        let run = run(&self.arena, world, self.seed, |system| {
            if !is_done && system.machine.now_us >= moment.at_us {
                is_done = true;
                refused = interfere(system, what, door).err();
            }
        });
        // Where nothing was done, nothing is shown.
        refused.is_none().then(|| {
            let at_s = moment.at_us as f64 * 1e-6;
            ended(&self.arena, &run)
                .map_err(|why| format!("at {at_s:.1} s; after {:.0} s {why}", run.system.machine.now_s()))
        })
    }
}

fn fits(what: Interference, door: &PassedDoor) -> bool {
    what != Interference::CloseDoor || door.is_open
}

fn interfere(system: &mut System<SiteRobot>, what: Interference, door: Option<&PassedDoor>) -> Result<(), String> {
    let host = &mut system.outside.host;
    let here = host.state.true_pose();
    let done = match (what, door) {
        (Interference::Turn { by_deg }, _) => {
            host.state.rotate(by_deg.to_radians());
            Ok(())
        }
        (Interference::PushBack { by_m }, _) => {
            host.model.teleport(&mut host.state, here.compose(Pose::new(-by_m, 0.0, 0.0)))
        }
        (Interference::CloseDoor, Some(door)) => host.model.close_door(&mut host.state, &door.room),
        (Interference::CloseDoor | Interference::StandBefore, _) => Ok(()),
    };
    done.map_err(|error| error.to_string())
}

fn run(arena: &Arena, world: World, seed: u64, mut look: impl FnMut(&mut System<SiteRobot>)) -> Run {
    let mut system = delivery(arena, world).start(seed);
    let mut next_us = 0;
    while system.machine.now_s() < UNTIL_S && system.advance() == Progress::Running {
        if system.machine.now_us >= next_us {
            next_us = system.machine.now_us + BETWEEN_LOOKS_US;
            look(&mut system);
        }
    }
    Run::of(system)
}

/// Whether the robot says that it has arrived, and has, and has touched nothing.
fn ended(arena: &Arena, run: &Run) -> Result<(), String> {
    let (robot, outcome) = (&run.system.outside, run.outcome());
    if !outcome.starts_with("=>") {
        return Err(outcome);
    }
    if !arena.is_goal(robot.true_pose_in_map()) {
        return Err("elsewhere".to_string());
    }
    if robot.contacts().caused > 0 { Err("it has touched something".to_string()) } else { Ok(()) }
}
