//! `office-delivery`: whole routes from the start room into the goal room, by lists that are right and by lists
//! with an error.

use super::figures;
use super::setting::{Ground, Setting};
use crate::experiment::row_result::FailedRun;
use crate::experiment::statistics::{Dispersion, Proportion};
use crate::experiment::trial::described;
use crate::show::figures::{Figure, draw};
use crate::terminal::page::Block;
use crate::terminal::table::{NOTHING, Table};
use anyhow::{Result, bail};
use rpl_lola::arena::{Arena, Fault, FaultKind, Finding};
use rpl_mission::robot::Robot;
use rpl_mission::run::{Reached, run_to};
use rpl_robot::geometry::Point;
use rpl_robot::world::Room;
use rpl_runtime::run::system::Outcome;
use serde::Serialize;
use std::ops::ControlFlow;

/// Which lists the robot is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lists {
    /// Lists that lead into the goal room.
    Right,
    /// The same with an error in each.
    Wrong,
}

impl Lists {
    /// The arena of a seed, with its list.
    fn arena(self, seed: u64, setting: &Setting) -> Arena {
        match self {
            Self::Right => Arena::draw(seed, &setting.arena),
            Self::Wrong => Arena::draw_with_fault(seed, &setting.arena),
        }
    }
}

/// A delivery: one arena and one list.
#[derive(Clone, Debug, PartialEq)]
pub struct Delivery {
    /// Its seed.
    pub seed: u64,
    /// What was wrong with its list, if anything.
    pub drawn: Option<Fault>,
    /// What came of it.
    pub outcome: DeliveryOutcome,
    /// How long it took.
    pub time_s: f64,
    /// The way driven.
    pub distance_m: f64,
    /// Contacts the robot caused.
    pub contacts: u32,
    /// Where it was, twice a second.
    pub track: Vec<Point>,
}

/// What came of a delivery.
#[derive(Clone, Debug, PartialEq)]
pub enum DeliveryOutcome {
    /// The robot is in the goal room, and says that it has arrived.
    Arrived,
    /// It says so, and is somewhere else.
    Elsewhere,
    /// It says that an instruction is wrong: which one, from 1, and in which way.
    Accused { number: usize, kind: String },
    /// Anything else, and why.
    Failed(String),
}

/// Where the robot is drawn, so often.
const BETWEEN_POINTS_US: u64 = 500_000;

/// Edge of a cell in drawings of routes.
const DRAWN_CELL_M: f64 = 0.1;

/// The plan of a list.
fn plan(arena: &Arena) -> String {
    format!(
        "(with-failure-handling\n    \
           ((faulty-instruction (f) (list 'accused (failure-slot f 'number) (failure-slot f 'kind))))\n  \
         (follow-instructions {:?})\n  'arrived)",
        arena.told()
    )
}

/// Follows the list of a seed.
///
/// # Errors
/// The robot cannot be simulated there, or the list is not understood.
pub fn deliver(ground: &Ground, setting: &Setting, lists: Lists, seed: u64, until_us: u64) -> Result<Delivery> {
    let arena = lists.arena(seed, setting);
    let (site, loaded) = ground.site(arena.world.clone(), &plan(&arena))?;
    let mut system = site.start(loaded, seed);
    let mut track = Vec::new();
    let reached = run_to(&mut system, until_us, |system| {
        if let Robot::Office(robot) = &system.outside
            && system.machine.now_us >= BETWEEN_POINTS_US * track.len() as u64
        {
            track.push(robot.true_pose_in_map().point());
        }
        ControlFlow::Continue(())
    });
    let Robot::Office(robot) = &system.outside else { bail!("a world has a robot") };
    let outcome = match reached {
        Reached::End(Outcome::Succeeded(value)) => {
            let said = system.machine.write(&system.program, value);
            match accusation(&said) {
                Some((number, kind)) => DeliveryOutcome::Accused { number, kind },
                None if arena.is_goal(robot.true_pose_in_map()) => DeliveryOutcome::Arrived,
                None => DeliveryOutcome::Elsewhere,
            }
        }
        Reached::End(Outcome::Failed(failure)) => {
            DeliveryOutcome::Failed(described(&system.machine, &system.program, failure))
        }
        Reached::End(Outcome::Evaporated) => DeliveryOutcome::Failed("ended itself".to_string()),
        Reached::Time | Reached::Stop => DeliveryOutcome::Failed("time is up".to_string()),
    };
    Ok(Delivery {
        seed,
        drawn: arena.fault,
        outcome,
        time_s: system.machine.now_s(),
        distance_m: robot.distance_driven_m(),
        contacts: robot.contacts().caused,
        track,
    })
}

/// What the plan says of a wrong instruction: `(accused NUMBER KIND)`.
fn accusation(said: &str) -> Option<(usize, String)> {
    let mut words = said.strip_prefix("(accused ")?.strip_suffix(')')?.split_whitespace();
    let number = words.next()?.parse().ok()?;
    Some((number, words.next()?.to_string()))
}

/// Whether an accusation names what is wrong: as it was made, or as it shows.
fn is_named(fault: &Fault, kind: &str) -> bool {
    let made = match fault.kind {
        FaultKind::NoSuchOpening => Some("no-such-opening"),
        FaultKind::AnotherKind => Some("other-kind"),
        FaultKind::OtherSide => Some("other-side"),
        FaultKind::OrdinalOff => None,
    };
    let shows = match fault.finding {
        Finding::NoSuchOpening => Some("no-such-opening"),
        Finding::AnotherKind(_) => Some("other-kind"),
        Finding::Nothing => None,
    };
    [made, shows].contains(&Some(kind))
}

impl Delivery {
    /// Whether the fault of the list was found: the right instruction is accused.
    fn is_found(&self) -> bool {
        match (&self.outcome, &self.drawn) {
            (DeliveryOutcome::Accused { number, .. }, Some(fault)) => *number == fault.number,
            _ => false,
        }
    }

    /// Whether it was also named by its kind.
    fn is_named(&self) -> bool {
        match (&self.outcome, &self.drawn) {
            (DeliveryOutcome::Accused { kind, .. }, Some(fault)) => self.is_found() && is_named(fault, kind),
            _ => false,
        }
    }

    fn is_accused(&self) -> bool {
        matches!(self.outcome, DeliveryOutcome::Accused { .. })
    }

    fn said(&self) -> String {
        match &self.outcome {
            DeliveryOutcome::Arrived => "arrived".to_string(),
            DeliveryOutcome::Elsewhere => "elsewhere".to_string(),
            DeliveryOutcome::Accused { number, kind } => format!("accused {number} of {kind}"),
            DeliveryOutcome::Failed(why) => why.clone(),
        }
    }
}

/// What came of the deliveries of a row.
#[derive(Clone, Debug, Serialize)]
pub struct DeliveryRow {
    /// What the row is called.
    pub name: String,
    /// How many.
    pub runs: usize,
    /// Those that arrived in the goal room.
    pub arrived: Proportion,
    /// Contacts the robot caused, in all.
    pub contacts: u32,
    /// The middle one of those that arrived.
    pub median_time_s: Option<f64>,
    /// Lists that are right, and of which an instruction was called wrong.
    pub false_accusations: Option<Proportion>,
    /// Errors that can be found, and of which the right instruction was called wrong.
    pub found: Option<Proportion>,
    /// The same, with the right kind.
    pub named: Option<Proportion>,
    /// Errors nobody can find, because the wrong opening is of the right kind.
    pub undetectable: usize,
    /// What came of those that neither arrived nor named their error.
    pub others: Vec<FailedRun>,
}

impl DeliveryRow {
    /// The figures of some deliveries.
    pub fn of(name: &str, deliveries: &[Delivery]) -> Self {
        let (right, wrong): (Vec<&Delivery>, Vec<&Delivery>) =
            deliveries.iter().partition(|delivery| delivery.drawn.is_none());
        let detectable: Vec<&&Delivery> =
            wrong.iter().filter(|delivery| delivery.drawn.is_some_and(|fault| fault.is_detectable())).collect();
        let among = |count: usize, of: usize| (of > 0).then(|| Proportion::new(count, of));
        let arrived: Vec<&Delivery> =
            deliveries.iter().filter(|delivery| delivery.outcome == DeliveryOutcome::Arrived).collect();
        let times_s: Vec<f64> = arrived.iter().map(|delivery| delivery.time_s).collect();
        let told = |delivery: &Delivery| FailedRun { seed: delivery.seed, fault: delivery.said() };
        let other = |delivery: &&Delivery| delivery.outcome != DeliveryOutcome::Arrived && !delivery.is_named();
        Self {
            name: name.to_string(),
            runs: deliveries.len(),
            arrived: Proportion::new(arrived.len(), deliveries.len()),
            contacts: deliveries.iter().map(|delivery| delivery.contacts).sum(),
            median_time_s: Dispersion::of(&times_s).map(|times| times.median),
            false_accusations: among(right.iter().filter(|delivery| delivery.is_accused()).count(), right.len()),
            found: among(detectable.iter().filter(|delivery| delivery.is_found()).count(), detectable.len()),
            named: among(detectable.iter().filter(|delivery| delivery.is_named()).count(), detectable.len()),
            undetectable: wrong.len() - detectable.len(),
            others: deliveries.iter().filter(other).map(told).collect(),
        }
    }
}

/// Outcomes that are named below a table, for each row.
const NAMED: usize = 20;

/// A line for each row.
pub fn blocks(rows: &[DeliveryRow]) -> Vec<Block> {
    let heads = [
        "",
        "arrived",
        "95 % interval",
        "contacts",
        "median time [s]",
        "falsely accused",
        "error found",
        "and named",
        "undetectable",
    ];
    let mut table = Table::new(&heads);
    for row in rows {
        let share = |share: &Option<Proportion>| share.as_ref().map_or(NOTHING.to_string(), Proportion::fraction);
        table.row([
            row.name.clone(),
            row.arrived.fraction(),
            row.arrived.interval(),
            row.contacts.to_string(),
            row.median_time_s.map_or(NOTHING.to_string(), |time_s| format!("{time_s:.0}")),
            share(&row.false_accusations),
            share(&row.found),
            share(&row.named),
            row.undetectable.to_string(),
        ]);
    }
    let mut blocks = vec![Block::Table(table)];
    for row in rows.iter().filter(|row| !row.others.is_empty()) {
        let named: Vec<String> =
            row.others.iter().take(NAMED).map(|run| format!("{} ({})", run.seed, run.fault)).collect();
        let more = row.others.len().saturating_sub(NAMED);
        let more = if more > 0 { format!(", and {more} more") } else { String::new() };
        blocks.push(Block::Lines(format!("{}: neither arrived nor named: {}{more}", row.name, named.join(", "))));
    }
    blocks
}

/// Every delivery as a line of comma-separated values.
pub fn raw_rows(rows: &[(&str, Vec<Delivery>)]) -> String {
    let mut text = String::from("row,seed,outcome,time [s],distance [m],contacts,fault number,fault kind,detectable\n");
    for (name, deliveries) in rows {
        for delivery in deliveries {
            let fault = delivery.drawn.map_or(",,".to_string(), |fault| {
                format!("{},{:?},{}", fault.number, fault.kind, fault.is_detectable())
            });
            let (seed, said) = (delivery.seed, delivery.said().replace('"', "'"));
            let Delivery { time_s, distance_m, contacts, .. } = delivery;
            text += &format!("\"{name}\",{seed},\"{said}\",{time_s:.2},{distance_m:.2},{contacts},{fault}\n");
        }
    }
    text
}

/// A drawing of a route, with the name of its file.
pub fn route(row: &str, lists: Lists, setting: &Setting, delivery: &Delivery) -> (String, String) {
    let arena = lists.arena(delivery.seed, setting);
    let map = arena.world.map(DRAWN_CELL_M);
    let title = arena.told();
    let is_shown = |room: &&Room| ["start", "goal"].contains(&room.name.as_str());
    let rooms: Vec<Room> = arena.world.rooms.iter().filter(is_shown).cloned().collect();
    let mut figure = Figure::of_map(&title, &map, &rooms);
    figure.true_paths_in_map.push(delivery.track.clone());
    (format!("route-{}.svg", figures::file_name(row)), draw(&figure))
}
