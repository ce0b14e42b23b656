//! `rpl cases FILE`: a case memory of a robot, what it would retrieve, and what is wrong with it.

use anyhow::{Result, anyhow, bail};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_drive::show::place_figures;
use rpl_robot::avoidance::DriveLimits;
use rpl_robot::world::World;
use rpl_rupart::case::{Case, Content, Kind};
use rpl_rupart::file::{read_situation, world_of};
use rpl_rupart::forgetting::Capacity;
use rpl_rupart::maintenance::{Concern, concerns};
use rpl_rupart::memory::{CaseMemory, CaseNumber};
use rpl_rupart::places::Places;
use rpl_rupart::route::{Route, Stop};
use rpl_rupart::routes::{Competence, TravelTimes, competences};
use rpl_shell::arguments::completion;
use rpl_shell::files::case_files::{self, CaseGround, faulty};
use rpl_shell::files::outputs::OutputFile;
use rpl_shell::files::{robot_files, world_files};
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use std::path::PathBuf;
use std::sync::Arc;

/// The robot that is to pass between places, unless another is named.
const ROBOT: &str = "pioneer-2dx";

/// Show a case memory, explain what it retrieves, and check it
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Case file
    #[arg(value_name = "FILE", value_hint = ValueHint::FilePath)]
    file: PathBuf,
    /// World of its places (default: the one that the file names)
    #[arg(long, value_name = "W", add = ArgValueCompleter::new(completion::worlds))]
    world: Option<String>,
    /// Robot that will drive there (default: pioneer-2dx)
    #[arg(long, value_name = "R", add = ArgValueCompleter::new(completion::robots))]
    robot: Option<String>,
    /// Explain which case is retrieved in a situation, such as '{"place_in_map":[1,2]}'
    #[arg(long, value_name = "SITUATION", conflicts_with_all = ["check", "draw"])]
    explain: Option<String>,
    /// Look for cases that are poor, hidden behind others, or lead through walls
    #[arg(long, conflicts_with = "draw")]
    check: bool,
    /// Draw places and routes into this file, as SVG
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    draw: Option<PathBuf>,
}

/// Shows a case memory.
///
/// # Errors
/// The file cannot be read or has faults, there is no such world, or the drawing cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let drawing = arguments.draw.as_ref().map(|path| OutputFile::open(path, "the drawing")).transpose()?;
    let name = arguments.file.to_string_lossy().into_owned();
    let text = case_files::read(&arguments.file)?;
    let robot = robot_files::named(Some(arguments.robot.as_deref().unwrap_or(ROBOT)))?;
    let world = match &arguments.world {
        Some(world) => world.clone(),
        None => world_of(&text, &name).map_err(|faults| faulty(&arguments.file, &faults))?,
    };
    let world = world_files::for_all_seeds(&world, &robot)?;
    let ground = CaseGround::new(&world, &robot);
    let memory = ground.memory(&text, &arguments.file)?;
    let (places, speed_mps) = (ground.places, DriveLimits::of(&robot).hallway_mps);
    if let Some(situation) = &arguments.explain {
        return explain(&memory, situation, console);
    }
    if arguments.check {
        return check(&memory, places.as_ref(), speed_mps, console);
    }
    if let Some(drawing) = drawing {
        drawing.write(drawn(&memory, &world, places.as_ref())?.as_bytes())?;
    }
    console.block(&Block::Table(table(&memory, places.as_ref(), speed_mps)))?;
    console.block(&Block::Lines(limits(&memory)))?;
    Ok(Status::Succeeded)
}

fn explain(memory: &CaseMemory, situation: &str, console: &mut Console) -> Result<Status> {
    let asked = read_situation(situation, "--explain").map_err(|faults| anyhow!("{faults}"))?;
    let Some(found) = memory.retrieve(&asked) else { bail!("the memory is empty: nothing can be retrieved") };
    console.explain(&found.best.to_string())?;
    for runner_up in &found.runners_up {
        console.explain(&format!("then {runner_up}"))?;
    }
    Ok(Status::Succeeded)
}

fn check(memory: &CaseMemory, places: Option<&Places>, speed_mps: f64, console: &mut Console) -> Result<Status> {
    let found = concerns(memory, places, speed_mps);
    found.iter().map(Concern::to_string).try_for_each(|line| console.explain(&line))?;
    if found.is_empty() {
        console.explain(&format!("{} cases, and nothing is wrong with them", memory.len()))?;
    }
    Ok(if found.is_empty() { Status::Succeeded } else { Status::Failed })
}

fn drawn(memory: &CaseMemory, world: &World, places: Option<&Places>) -> Result<String> {
    let Some(places) = places else {
        bail!("the world `{}` has no places, so there are no routes to draw", world.name)
    };
    let title = format!("{}: places and the routes of {} cases", world.name, memory.cases_of(Kind::Route).count());
    Ok(place_figures::routes(&title, world, places, memory.routes().map(|(_, route)| route)))
}

/// How many cases there are of each kind, and how many a robot remembers.
fn limits(memory: &CaseMemory) -> String {
    let told = |kind: Kind| {
        let plural = if memory.count(kind) == 1 { "" } else { "s" };
        format!("{} {}{plural} of at most {}", memory.count(kind), kind.name(), Capacity::USUAL.of(kind))
    };
    Kind::ALL.map(told).join(", ")
}

/// A line for each case.
fn table(memory: &CaseMemory, places: Option<&Places>, speed_mps: f64) -> Table {
    let competence: Vec<Competence> = places.map_or_else(Vec::new, |places| {
        let routes: Vec<(CaseNumber, &Route)> = memory.routes().collect();
        let times = TravelTimes::of_routes(places, speed_mps, routes.iter().map(|(_, route)| *route));
        competences(places, &times, &routes)
    });
    let mut table = Table::new(&["case", "kind", "what", "used", "succeeded", "covers", "reached by"]);
    for (number, case) in memory.cases() {
        let found =
            competence.binary_search_by_key(&number, |competence| competence.number).ok().map(|at| competence[at]);
        let told =
            |of: fn(&Competence) -> usize| found.as_ref().map_or(NOTHING.to_string(), |found| of(found).to_string());
        table.row([
            number.to_string(),
            case.content.kind().name().to_string(),
            what(case, places),
            case.counts.used.to_string(),
            case.counts.succeeded.to_string(),
            told(|competence| competence.coverage),
            told(|competence| competence.reachability),
        ]);
    }
    table
}

fn what(case: &Arc<Case>, places: Option<&Places>) -> String {
    let told = |stop: &Stop| match (stop, places) {
        (Stop::Known(place), Some(places)) => places.name(*place).to_string(),
        (Stop::Known(place), None) => place.0.to_string(),
        (Stop::At(point), _) => format!("({:.1}, {:.1})", point.x, point.y),
    };
    match &case.content {
        Content::Behaviour(parameters) => {
            format!("{:.2} m/s, {:.2} rad/s", parameters.translation_mps, parameters.rotation_radps)
        }
        Content::Route(route) => {
            let ends = route.stops.first().zip(route.stops.last());
            let ends = ends.map_or(String::new(), |(start, goal)| format!("{} to {}", told(start), told(goal)));
            format!("{ends}, {} steps", route.times_s.len())
        }
        Content::Goal(goal) => told(&Stop::At(goal.place_in_map)),
        Content::MetaPlan(plan) => plan.name().to_string(),
    }
}
