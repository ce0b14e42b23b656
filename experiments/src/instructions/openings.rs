//! `count-openings`: whether the nth opening is chosen, by several rules and the same percepts.

use super::course::{Course, drive};
use super::features::failed_drives;
use super::figures;
use super::setting::{
    CALM, CROWDED, CROWDED_MARKED, EXACT, Ground, MARKED, NOMAD, Setting, THICK, THIN, UNREGISTERED, by, by_dervish,
};
use crate::conduct::chosen;
use crate::failed_runs::FailedRun;
use crate::findings::Findings;
use crate::kind::{ExperimentKind, Run};
use crate::request::ExperimentRequest;
use crate::statistics::Proportion;
use anyhow::Result;
use rpl_lola::feature::{Feature, Percept, Side};
use rpl_lola::features::score::TrueFeature;
use rpl_lola::instruction::{Goal, MOST_ORDINAL};
use rpl_lola::state_set::{Inference, Method, StateSet};
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// A row of `count-openings`: drives, and what is made of their percepts.
struct Counting {
    name: &'static str,
    drives: Setting,
    inference: fn() -> Inference,
}

/// A row in which openings are counted by the robot's own rule, called as its drives are.
const fn state_set(name: &'static str, drives: Setting) -> Counting {
    Counting { name, drives, inference: || Inference::of_robot(false) }
}

/// The rows of `count-openings`. Those of the same drives judge the same percepts.
static COUNTINGS: [Counting; 18] = [
    state_set("state set", CALM),
    Counting { name: "counter with class", drives: CALM, inference: || by(Method::CounterWithClass) },
    Counting { name: "plain counter", drives: CALM, inference: || by(Method::PlainCounter) },
    Counting { name: "literal equations", drives: CALM, inference: || by(Method::LiteralEquations) },
    Counting { name: "DERVISH's matrix", drives: CALM, inference: by_dervish },
    state_set("crowded", CROWDED),
    Counting { name: "crowded, counter with class", drives: CROWDED, inference: || by(Method::CounterWithClass) },
    Counting { name: "crowded, plain counter", drives: CROWDED, inference: || by(Method::PlainCounter) },
    Counting { name: "crowded, literal equations", drives: CROWDED, inference: || by(Method::LiteralEquations) },
    Counting { name: "crowded, DERVISH's matrix", drives: CROWDED, inference: by_dervish },
    Counting { name: "with markers", drives: MARKED, inference: || Inference::of_robot(true) },
    Counting { name: "crowded, with markers", drives: CROWDED_MARKED, inference: || Inference::of_robot(true) },
    state_set(THIN.name, THIN),
    state_set(THICK.name, THICK),
    state_set(EXACT.name, EXACT),
    state_set(UNREGISTERED.name, UNREGISTERED),
    Counting {
        name: "without registration, counter with class",
        drives: UNREGISTERED,
        inference: || by(Method::CounterWithClass),
    },
    state_set(NOMAD.name, NOMAD),
];

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    COUNTINGS.iter().map(|counting| counting.name).collect()
}

/// Counts openings along hallways, row by row.
pub struct CountOpenings {
    request: ExperimentRequest,
    countings: Vec<&'static Counting>,
    /// The drives whose percepts they judge, each once.
    drives: Vec<&'static Setting>,
}

impl CountOpenings {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let countings = chosen(&request, &COUNTINGS, |counting| counting.name)?;
        let mut drives: Vec<&Setting> = Vec::new();
        for counting in &countings {
            if !drives.iter().any(|known| known.name == counting.drives.name) {
                drives.push(&counting.drives);
            }
        }
        Ok(Self { request, countings, drives })
    }

    /// The rows that judge the percepts of these drives.
    fn judging<'a>(&'a self, drives: &'a Setting) -> impl Iterator<Item = &'static Counting> + 'a {
        self.countings.iter().copied().filter(|counting| counting.drives.name == drives.name)
    }
}

/// What the rows make of the percepts of a drive, each as the rows follow each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    seed: u64,
    choices: Vec<Vec<Choice>>,
    /// Why it did not get to the end, if it did not.
    failure: Option<FailedRun>,
}

impl ExperimentKind for CountOpenings {
    type Ground = Ground;
    type Record = Judged;
    type Tally = Vec<Judged>;

    fn series(&self) -> Vec<String> {
        self.drives.iter().map(|setting| setting.name.to_string()).collect()
    }

    fn ground(&self, series: usize) -> Result<Ground> {
        Ground::new(self.drives[series], &self.request.robot)
    }

    fn run(&self, series: usize, ground: &Ground, Run { seed, .. }: Run) -> Result<Judged> {
        let drives = self.drives[series];
        let course = drive(ground, &drives.arena, seed, self.request.until_us)?;
        let choices = self.judging(drives).map(|counting| choices(&course, &(counting.inference)())).collect();
        Ok(Judged { seed, choices, failure: course.failure() })
    }

    fn head(&self, _: &Judged) -> String {
        "row,seed,from [m],ordinal,side,kind,outcome".to_string()
    }

    fn lines(&self, series: &str, _: Run, judged: &Judged) -> String {
        let drives = self.drives.iter().find(|drives| drives.name == series);
        let rows = drives.into_iter().flat_map(|drives| self.judging(drives));
        rows.zip(&judged.choices)
            .flat_map(|(row, choices)| choices.iter().map(|choice| choice.line(row.name, judged.seed)))
            .collect()
    }

    fn findings(&self, tallies: Vec<Vec<Judged>>, wants_drawings: bool) -> Result<Findings> {
        let mut drawings = Vec::new();
        for (series, (drives, judged)) in self.drives.iter().zip(&tallies).enumerate() {
            if let Some(first) = judged.first().filter(|_| wants_drawings) {
                let course = drive(&self.ground(series)?, &drives.arena, first.seed, self.request.until_us)?;
                let inference = Inference::of_robot(drives.arena.markers);
                drawings.extend(figures::state_set(drives.name, &inference, &course));
            }
        }
        let of_row = |counting: &&Counting| -> Option<ChoiceRow> {
            let series = self.drives.iter().position(|drives| drives.name == counting.drives.name)?;
            let at = self.judging(self.drives[series]).position(|other| other.name == counting.name)?;
            Some(ChoiceRow::of(counting.name, &tallies[series], at))
        };
        let rows: Vec<ChoiceRow> = self.countings.iter().filter_map(of_row).collect();
        let (blocks, figures) = (blocks(&rows), json!({ "rows": rows }));
        Ok(Findings { status: Status::Succeeded, blocks, figures, drawings })
    }
}

/// The nth opening of a hallway's side that was asked for, and what came of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// From where on openings are counted, along the hallway.
    pub from_m: f64,
    /// What was asked for.
    pub goal: Goal,
    /// What came of it.
    pub outcome: ChoiceOutcome,
}

/// What came of asking for an opening.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum ChoiceOutcome {
    /// It was the one that was chosen.
    Right,
    /// Another one was, or a wall.
    Wrong,
    /// None was: the hallway ended before.
    None,
}

impl Choice {
    /// As a line of comma-separated values.
    fn line(&self, row: &str, seed: u64) -> String {
        let Self { from_m, goal, outcome } = self;
        let outcome = match outcome {
            ChoiceOutcome::Right => "right",
            ChoiceOutcome::Wrong => "wrong",
            ChoiceOutcome::None => "none",
        };
        let (side, kind) = (goal.side.in_words(), goal.kind.name());
        format!("\"{row}\",{seed},{from_m:.2},{},{side},{kind},{outcome}\n", goal.ordinal)
    }
}

/// Asks for every opening on both sides that an instruction can lead to, from the start and from behind every opening
/// before it: an instruction begins where the last one ended. Cost: the square of the openings, times the percepts.
fn choices(course: &Course, inference: &Inference) -> Vec<Choice> {
    let of_side = |side| {
        let openings = course.openings(side);
        let behind: Vec<f64> = openings.iter().map(|found| found.to_m).collect();
        let places = [0.0].into_iter().chain(behind);
        places.flat_map(|from_m| choices_from(from_m, side, course, inference)).collect::<Vec<Choice>>()
    };
    Side::ALL.into_iter().flat_map(of_side).collect()
}

/// How many were chosen right of those that were asked for by an ordinal that is meant, and how many these were.
fn right(choices: &[Choice], is_meant: impl Fn(u8) -> bool) -> (usize, usize) {
    let meant = || choices.iter().filter(|choice| is_meant(choice.goal.ordinal));
    (meant().filter(|choice| choice.outcome == ChoiceOutcome::Right).count(), meant().count())
}

/// What is asked for on a side from a place on.
fn choices_from(from_m: f64, side: Side, course: &Course, inference: &Inference) -> Vec<Choice> {
    let ahead = course.openings(side).into_iter().filter(|found| found.from_m >= from_m).zip(1..=MOST_ORDINAL);
    let can_be_goal = |found: &TrueFeature| matches!(found.is, Feature::Hallway | Feature::OpenDoor);
    let choice = |(found, ordinal): (TrueFeature, u8)| {
        let goal = Goal { ordinal, side, kind: found.is };
        let outcome = match taken(from_m, goal, course, inference) {
            None => ChoiceOutcome::None,
            Some(percept) if is_of(&percept, &found) => ChoiceOutcome::Right,
            Some(_) => ChoiceOutcome::Wrong,
        };
        Choice { from_m, goal, outcome }
    };
    ahead.filter(|(found, _)| can_be_goal(found)).map(choice).collect()
}

/// The percept that is taken for the goal, as soon as one is, of those ahead of a place.
fn taken(from_m: f64, goal: Goal, course: &Course, inference: &Inference) -> Option<Percept> {
    let mut state_set = StateSet::start(goal.instruction())?;
    course.percepts.iter().filter(|percept| percept.middle_m() > from_m).find_map(|percept| {
        state_set.progress(inference, &[*percept], &course.hidden);
        state_set.arrived()
    })
}

/// Whether the robot that turns at the middle of a percept turns into this opening.
fn is_of(percept: &Percept, found: &TrueFeature) -> bool {
    percept.side == found.side && (found.from_m..found.to_m).contains(&percept.middle_m())
}

/// What came of the choices of a row. The choices of a drive share its percepts: the intervals take them together.
#[derive(Clone, Debug, Serialize)]
pub struct ChoiceRow {
    /// What the row is called.
    pub name: String,
    /// Drives.
    pub runs: usize,
    /// Right choices among those of each ordinal, from the first on.
    pub by_ordinal: Vec<Proportion>,
    /// Among the first five.
    pub first_five: Proportion,
    /// Among all.
    pub all: Proportion,
    /// How often none was chosen.
    pub none: usize,
    /// Drives that did not get to the end, with the reason: what they did not come past is not asked for.
    pub failures: Vec<FailedRun>,
}

impl ChoiceRow {
    /// The figures of some drives, as the row at this place among those that judge them.
    fn of(name: &str, drives: &[Judged], at: usize) -> Self {
        let among = |is_meant: &dyn Fn(u8) -> bool| {
            Proportion::in_groups(&drives.iter().map(|judged| right(&judged.choices[at], is_meant)).collect::<Vec<_>>())
        };
        let choices = drives.iter().flat_map(|judged| &judged.choices[at]);
        Self {
            name: name.to_string(),
            runs: drives.len(),
            by_ordinal: (1..=MOST_ORDINAL).map(|ordinal| among(&|other| other == ordinal)).collect(),
            first_five: among(&|ordinal| ordinal <= 5),
            all: among(&|_| true),
            none: choices.filter(|choice| choice.outcome == ChoiceOutcome::None).count(),
            failures: drives.iter().filter_map(|judged| judged.failure.clone()).collect(),
        }
    }
}

/// A line for each row: the share of right choices by ordinal.
pub fn blocks(rows: &[ChoiceRow]) -> Vec<Block> {
    let ordinals: Vec<String> = (1..=MOST_ORDINAL).map(|ordinal| ordinal.to_string()).collect();
    let heads: Vec<&str> = [""]
        .into_iter()
        .chain(ordinals.iter().map(String::as_str))
        .chain(["first five", "95 % interval", "tenth: 95 % interval", "all", "none"])
        .collect();
    let mut table = Table::new(&heads);
    for row in rows {
        let share = |share: &Proportion| share.rate.map_or(NOTHING.to_string(), |rate| format!("{rate:.3}"));
        let cells = row.by_ordinal.iter().map(share);
        let tenth = row.by_ordinal.last().map_or(NOTHING.to_string(), Proportion::interval);
        let ends = [share(&row.first_five), row.first_five.interval(), tenth, share(&row.all), row.none.to_string()];
        table.row([row.name.clone()].into_iter().chain(cells).chain(ends));
    }
    let asked: Vec<String> =
        rows.first().map_or(Vec::new(), |row| row.by_ordinal.iter().map(|share| share.of.to_string()).collect());
    let asked = format!("openings asked for, from the first to the tenth: {}", asked.join(", "));
    let mut blocks = vec![Block::Table(table), Block::Lines(asked)];
    let failed = |row: &ChoiceRow| Some(Block::Lines(format!("{}: {}", row.name, failed_drives(&row.failures)?)));
    blocks.extend(rows.iter().filter_map(failed));
    blocks
}
