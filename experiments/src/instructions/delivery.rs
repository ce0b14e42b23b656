//! `office-delivery`: whole routes from the start room into the goal room, by lists that are right and by lists
//! with an error.

use super::figures;
use super::setting::{
    CALM, CROWDED, CROWDED_MARKED, EXACT, Ground, MARKED, NOMAD, Setting, THICK, THIN, UNREGISTERED, by, by_dervish,
};
use crate::conduct::chosen;
use crate::failed_runs::FailedRun;
use crate::findings::Findings;
use crate::kind::{ExperimentKind, Run};
use crate::request::ExperimentRequest;
use crate::statistics::{Dispersion, Proportion};
use crate::trial::described;
use anyhow::{Result, bail};
use rpl_drawing::{Figure, FloorPlan, TrackKind};
use rpl_lola::LolaSettings;
use rpl_lola::arena::{Arena, Fault, Finding};
use rpl_lola::judgement::FaultKind;
use rpl_lola::state_set::Method;
use rpl_mission::robot::Robot;
use rpl_mission::run::{Reached, fluent_value, run_to};
use rpl_robot::geometry::Point;
use rpl_runtime::run::system::{Outcome, System};
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::ops::ControlFlow;

/// Which lists the robot is given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lists {
    /// Lists that lead into the goal room.
    Right,
    /// The same with an error in each.
    Wrong,
    /// The same; the robot asks back, and the experimenter answers with what is right.
    Answered,
}

impl Lists {
    /// The arena of a seed, with its list.
    fn arena(self, seed: u64, setting: &Setting) -> Arena {
        match self {
            Self::Right => Arena::draw(seed, &setting.arena),
            Self::Wrong | Self::Answered => Arena::draw_with_fault(seed, &setting.arena),
        }
    }

    /// The plan of a list. What it accuses is its value, or for as long as it asks back, that of a fluent.
    fn plan(self, arena: &Arena) -> String {
        let told = arena.told();
        match self {
            Self::Right | Self::Wrong => format!(
                "(with-failure-handling\n    \
                   ((faulty-instruction (f) (list 'accused (failure-slot f 'number) (failure-slot f 'kind))))\n  \
                 (follow-instructions {told:?})\n  'arrived)",
            ),
            Self::Answered => format!(
                "(def-fluent {ASKED} nil \"What the robot asks about.\")\n\
                 (def-plan ask-experimenter (f)\n  \
                   (setf (value {ASKED}) (list 'accused (failure-slot f 'number) (failure-slot f 'kind) (now)))\n  \
                   (unwind-protect (ask-back f) (setf (value {ASKED}) nil)))\n\
                 (follow-instructions {told:?} :on-fault ask-experimenter)\n'arrived",
            ),
        }
    }
}

/// A row of `office-delivery`.
struct DeliverySetting {
    name: &'static str,
    setting: Setting,
    lists: Lists,
}

/// A row with right lists, called as its setting is.
const fn right(setting: Setting) -> DeliverySetting {
    DeliverySetting { name: setting.name, setting, lists: Lists::Right }
}

/// A row in which openings are counted by something else.
const fn counting(name: &'static str, lola: fn(&mut LolaSettings)) -> DeliverySetting {
    right(Setting { name, lola, ..CALM })
}

/// The rows of `office-delivery`.
static DELIVERIES: [DeliverySetting; 17] = [
    right(CALM),
    right(MARKED),
    right(THIN),
    right(THICK),
    right(CROWDED),
    right(CROWDED_MARKED),
    right(EXACT),
    counting("plain counter", |settings| settings.inference = Some(by(Method::PlainCounter))),
    counting("counter with class", |settings| settings.inference = Some(by(Method::CounterWithClass))),
    counting("literal equations", |settings| settings.inference = Some(by(Method::LiteralEquations))),
    counting("DERVISH's matrix", |settings| settings.inference = Some(by_dervish())),
    right(UNREGISTERED),
    right(NOMAD),
    DeliverySetting { name: "wrong lists", setting: CALM, lists: Lists::Wrong },
    DeliverySetting { name: "wrong lists, crowded", setting: CROWDED, lists: Lists::Wrong },
    DeliverySetting { name: "asked back", setting: CALM, lists: Lists::Answered },
    DeliverySetting { name: "asked back, crowded", setting: CROWDED, lists: Lists::Answered },
];

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    DELIVERIES.iter().map(|row| row.name).collect()
}

/// Whole routes, row by row.
pub struct OfficeDelivery {
    request: ExperimentRequest,
    rows: Vec<&'static DeliverySetting>,
}

impl OfficeDelivery {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let rows = chosen(&request, &DELIVERIES, |row| row.name)?;
        Ok(Self { request, rows })
    }
}

impl ExperimentKind for OfficeDelivery {
    type Ground = Ground;
    type Record = Delivery;
    type Tally = Vec<Delivery>;

    fn series(&self) -> Vec<String> {
        self.rows.iter().map(|row| row.name.to_string()).collect()
    }

    fn ground(&self, series: usize) -> Result<Ground> {
        Ground::new(&self.rows[series].setting, &self.request.robot)
    }

    fn run(&self, series: usize, ground: &Ground, run: Run) -> Result<Delivery> {
        let DeliverySetting { setting, lists, .. } = self.rows[series];
        Ok(deliver(ground, setting, *lists, run.seed, self.request.until_us)?.0)
    }

    fn head(&self, _: &Delivery) -> String {
        "row,seed,outcome,time [s],distance [m],contacts,fault number,fault kind,detectable".to_string()
    }

    fn lines(&self, series: &str, _: Run, delivery: &Delivery) -> String {
        delivery.line(series)
    }

    fn findings(&self, tallies: Vec<Vec<Delivery>>, wants_drawings: bool) -> Result<Findings> {
        let mut drawings = Vec::new();
        for (series, (row, deliveries)) in self.rows.iter().zip(&tallies).enumerate() {
            if let Some(Delivery { seed, .. }) = deliveries.first().filter(|_| wants_drawings) {
                let DeliverySetting { name, setting, lists } = row;
                let (_, track) = deliver(&self.ground(series)?, setting, *lists, *seed, self.request.until_us)?;
                drawings.push(route(name, &lists.arena(*seed, setting), *seed, track));
            }
        }
        let rows = self.rows.iter().zip(&tallies).map(|(row, deliveries)| DeliveryRow::of(row.name, deliveries));
        let rows: Vec<DeliveryRow> = rows.collect();
        let first = rows.first().is_some_and(|row| row.others.is_empty() && row.contacts == 0);
        let status = if first { Status::Succeeded } else { Status::Failed };
        let (blocks, figures) = (blocks(&rows), json!({ "rows": rows }));
        Ok(Findings { status, blocks, figures, drawings })
    }
}

/// A delivery: one arena and one list.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Delivery {
    /// Its seed.
    pub seed: u64,
    /// What was wrong with its list, if anything.
    pub drawn: Option<Fault>,
    /// What the robot said first of a wrong instruction, if it did.
    pub accused: Option<Accusation>,
    /// What came of it.
    pub outcome: DeliveryOutcome,
    /// How long it took.
    pub time_s: f64,
    /// The way driven.
    pub distance_m: f64,
    /// Contacts the robot caused.
    pub contacts: u32,
}

/// What came of a delivery.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum DeliveryOutcome {
    /// The robot is in the goal room, and says that it has arrived.
    Arrived,
    /// It says so, and is somewhere else.
    Elsewhere,
    /// It says that an instruction is wrong, and goes no farther.
    Accused,
    /// Anything else, and why.
    Failed(String),
}

/// What a robot says of a wrong instruction.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Accusation {
    /// Which one it is, from 1.
    number: usize,
    /// In which way it is wrong.
    kind: String,
}

/// The fluent that says what a plan asks about.
const ASKED: &str = "asked";

/// Nobody answers more often than this.
const MOST_ANSWERS: usize = 3;

/// Time between two points at which the robot is drawn.
const BETWEEN_POINTS_US: u64 = 500_000;

/// Follows the list of a seed. Answers where the robot was, too, twice a second.
///
/// # Errors
/// The robot cannot be simulated there, or the list is not understood.
fn deliver(
    ground: &Ground,
    setting: &Setting,
    lists: Lists,
    seed: u64,
    until_us: u64,
) -> Result<(Delivery, Vec<Point>)> {
    let arena = lists.arena(seed, setting);
    let (site, loaded) = ground.site(arena.world.clone(), &lists.plan(&arena))?;
    let mut system = site.start(loaded, seed);
    let mut track = Vec::new();
    let mut experimenter = Experimenter::default();
    let reached = run_to(&mut system, until_us, |system| {
        if let Robot::Office(robot) = &system.outside
            && system.machine.now_us >= BETWEEN_POINTS_US * track.len() as u64
        {
            track.push(robot.true_pose_in_map().point());
        }
        experimenter.look(system, &arena)
    });
    let Robot::Office(robot) = &system.outside else { bail!("a world has a robot") };
    let mut accused = experimenter.asked.first().cloned();
    let outcome = match reached {
        Reached::End(Outcome::Succeeded(value)) => {
            let said = accusation(&system.machine.write(&system.program, value));
            match &said {
                Some(_) => {
                    accused = said;
                    DeliveryOutcome::Accused
                }
                None if arena.is_goal(robot.true_pose_in_map()) => DeliveryOutcome::Arrived,
                None => DeliveryOutcome::Elsewhere,
            }
        }
        Reached::End(Outcome::Failed(failure)) => {
            DeliveryOutcome::Failed(described(&system.machine, &system.program, failure))
        }
        Reached::End(Outcome::Evaporated) => DeliveryOutcome::Failed("ended itself".to_string()),
        Reached::Time => DeliveryOutcome::Failed("time is up".to_string()),
        Reached::Stop => DeliveryOutcome::Failed("it does not believe the answers".to_string()),
    };
    let delivery = Delivery {
        seed,
        drawn: arena.fault,
        accused,
        outcome,
        time_s: system.machine.now_s(),
        distance_m: robot.distance_driven_m(),
        contacts: robot.contacts().caused,
    };
    Ok((delivery, track))
}

/// Who answers the robot with the right instruction.
#[derive(Default)]
struct Experimenter {
    /// What was asked so far.
    asked: Vec<Accusation>,
    /// The question that was answered last, with its time: the robot may ask the same again at once.
    answered: String,
}

impl Experimenter {
    fn look(&mut self, system: &mut System<Robot>, arena: &Arena) -> ControlFlow<()> {
        let Some(value) = fluent_value(system, ASKED) else { return ControlFlow::Continue(()) };
        let question = system.machine.write(&system.program, value);
        let Some(asked) = accusation(&question).filter(|_| question != self.answered) else {
            return ControlFlow::Continue(());
        };
        let right = asked.number.checked_sub(1).and_then(|index| arena.right_instructions().get(index).copied());
        self.asked.push(asked);
        self.answered = question;
        let (Some(right), Robot::Office(robot)) = (right, &mut system.outside) else { return ControlFlow::Break(()) };
        if self.asked.len() > MOST_ANSWERS {
            return ControlFlow::Break(());
        }
        robot.host.state.send_message(right.to_string().split_whitespace().map(str::to_string).collect());
        ControlFlow::Continue(())
    }
}

/// What a plan says of a wrong instruction: `(accused NUMBER KIND)`, and when, if it asks.
fn accusation(said: &str) -> Option<Accusation> {
    let mut words = said.strip_prefix("(accused ")?.strip_suffix(')')?.split_whitespace();
    let number = words.next()?.parse().ok()?;
    Some(Accusation { number, kind: words.next()?.to_string() })
}

/// Whether an accusation names what shows of an error to somebody who counts right.
fn is_named(fault: &Fault, kind: &str) -> bool {
    let shows = match fault.finding {
        Finding::NoSuchOpening => Some(FaultKind::NoSuchOpening),
        Finding::AnotherKind(_) => Some(FaultKind::OtherKind),
        Finding::Nothing => None,
    };
    shows.is_some_and(|shows| shows.name() == kind)
}

impl Delivery {
    /// Whether the fault of the list was found: the right instruction is accused, before any other.
    fn is_found(&self) -> bool {
        let numbers = self.accused.as_ref().zip(self.drawn.as_ref());
        numbers.is_some_and(|(accused, fault)| accused.number == fault.number)
    }

    /// Whether it was also named by its kind.
    fn is_named(&self) -> bool {
        let kinds = self.accused.as_ref().zip(self.drawn.as_ref());
        self.is_found() && kinds.is_some_and(|(accused, fault)| is_named(fault, &accused.kind))
    }

    /// Whether it ended as well as it could: in the goal room, with its fault named, or led astray by an error that
    /// nobody can find.
    fn is_well(&self) -> bool {
        match self.outcome {
            DeliveryOutcome::Arrived => true,
            DeliveryOutcome::Accused => self.is_named(),
            DeliveryOutcome::Elsewhere => self.drawn.is_some_and(|fault| !fault.is_detectable()),
            DeliveryOutcome::Failed(_) => false,
        }
    }

    /// As a line of comma-separated values.
    fn line(&self, row: &str) -> String {
        let fault = self
            .drawn
            .map_or(",,".to_string(), |fault| format!("{},{:?},{}", fault.number, fault.kind, fault.is_detectable()));
        let Self { seed, time_s, distance_m, contacts, .. } = self;
        let said = self.said().replace('"', "'");
        format!("\"{row}\",{seed},\"{said}\",{time_s:.2},{distance_m:.2},{contacts},{fault}\n")
    }

    fn said(&self) -> String {
        let end = match &self.outcome {
            DeliveryOutcome::Arrived => "arrived",
            DeliveryOutcome::Elsewhere => "elsewhere",
            DeliveryOutcome::Accused => "goes no farther",
            DeliveryOutcome::Failed(why) => why,
        };
        match &self.accused {
            Some(Accusation { number, kind }) => format!("accused {number} of {kind}; {end}"),
            None => end.to_string(),
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
    /// Those that arrived after the robot had asked back about an error that can be found, and was answered.
    pub arrived_after_answer: Option<Proportion>,
    /// Errors nobody can find, because the wrong opening is of the right kind.
    pub undetectable: usize,
    /// What came of those that neither arrived nor named an error that can be found.
    pub others: Vec<FailedRun>,
}

impl DeliveryRow {
    /// The figures of some deliveries.
    pub fn of(name: &str, deliveries: &[Delivery]) -> Self {
        let (right, wrong): (Vec<&Delivery>, Vec<&Delivery>) =
            deliveries.iter().partition(|delivery| delivery.drawn.is_none());
        let detectable: Vec<&Delivery> = wrong
            .iter()
            .copied()
            .filter(|delivery| delivery.drawn.is_some_and(|fault| fault.is_detectable()))
            .collect();
        let among = |count: usize, of: usize| (of > 0).then(|| Proportion::new(count, of));
        let arrived: Vec<&Delivery> =
            deliveries.iter().filter(|delivery| delivery.outcome == DeliveryOutcome::Arrived).collect();
        let times_s: Vec<f64> = arrived.iter().map(|delivery| delivery.time_s).collect();
        let told = |delivery: &Delivery| FailedRun { seed: delivery.seed, fault: delivery.said() };
        let count = |those: &[&Delivery], is_meant: &dyn Fn(&Delivery) -> bool| {
            those.iter().filter(|delivery| is_meant(delivery)).count()
        };
        // Who goes no farther has had no answer.
        let has_asked =
            |delivery: &&Delivery| delivery.accused.is_some() && delivery.outcome != DeliveryOutcome::Accused;
        let asked: Vec<&Delivery> = detectable.iter().copied().filter(has_asked).collect();
        Self {
            name: name.to_string(),
            runs: deliveries.len(),
            arrived: Proportion::new(arrived.len(), deliveries.len()),
            contacts: deliveries.iter().map(|delivery| delivery.contacts).sum(),
            median_time_s: Dispersion::of(&times_s).map(|times| times.median),
            false_accusations: among(count(&right, &|delivery| delivery.accused.is_some()), right.len()),
            found: among(count(&detectable, &Delivery::is_found), detectable.len()),
            named: among(count(&detectable, &Delivery::is_named), detectable.len()),
            arrived_after_answer: among(
                count(&asked, &|delivery| delivery.outcome == DeliveryOutcome::Arrived),
                asked.len(),
            ),
            undetectable: wrong.len() - detectable.len(),
            others: deliveries.iter().filter(|delivery| !delivery.is_well()).map(told).collect(),
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
        "arrived after an answer",
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
            share(&row.arrived_after_answer),
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

/// A drawing of a route, with the name of its file.
fn route(row: &str, arena: &Arena, seed: u64, track: Vec<Point>) -> (String, String) {
    let plan = FloorPlan::of_world(&arena.world).naming(|room| ["start", "goal"].contains(&room.name.as_str()));
    let mut figure = Figure::new(format!("{row}, seed {seed}"), plan);
    figure.track(TrackKind::Truth, "where the robot was", vec![track]);
    (format!("route-{}.svg", figures::file_name(row)), figure.draw())
}
