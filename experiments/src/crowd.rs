//! Whether a robot with people around it, who block many of its beams, knows where it is: by each way to leave
//! readings out.

use super::conduct::chosen;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::request::ExperimentRequest;
use super::statistics::{PerKm, Proportion};
use super::trial::{WRONG_ESTIMATE_M, described, is_right, off_m};
use anyhow::Result;
use rpl_mission::robot::Robot;
use rpl_mission::run::run_to;
use rpl_mission::sight::Sight;
use rpl_mission::site::{Setup, Site};
use rpl_robot::localization::{Gating, LocalizationParameters};
use rpl_robot::office::{OfficeSettings, ReportKind};
use rpl_runtime::run::library::Loaded;
use rpl_runtime::run::system::System;
use rpl_shell::files::{plans, world_files};
use rpl_shell::sites;
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::ops::ControlFlow::{self, Break, Continue};

/// Where it is.
const WORLD: &str = "hall";

/// How often the estimate is compared with the truth.
const LOOK_US: u64 = 100_000;

/// The beams are counted at one look in this many.
const BEAMS_EVERY: usize = 10;

/// That the robot was carried elsewhere must be noticed on this way.
const NOTICED_WITHIN_M: f64 = 3.0;

/// A run ends when it has not been noticed on this one.
const GIVEN_UP_AFTER_M: f64 = 10.0;

/// How readings are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Filter {
    None,
    Entropy,
    Novelty,
    /// As the robot is.
    Ours,
}

impl Filter {
    fn apply(self, localization: &mut LocalizationParameters) {
        let gating = match self {
            Self::None => None,
            Self::Entropy => Some(Gating::Entropy),
            Self::Novelty => Some(Gating::Novelty { most_probable: 0.99 }),
            Self::Ours => return,
        };
        localization.sensors.iter_mut().for_each(|sensor| sensor.gating.clone_from(&gating));
    }
}

/// A number of people, and a filter.
#[derive(Clone, Copy, Debug)]
pub struct CrowdRow {
    name: &'static str,
    people: usize,
    filter: Filter,
}

const fn row(name: &'static str, people: usize, filter: Filter) -> CrowdRow {
    CrowdRow { name, people, filter }
}

const ROWS: [CrowdRow; 16] = [
    row("nobody, no filter", 0, Filter::None),
    row("nobody, entropy filter", 0, Filter::Entropy),
    row("nobody, novelty filter", 0, Filter::Novelty),
    row("nobody", 0, Filter::Ours),
    row("20 people, no filter", 20, Filter::None),
    row("20 people, entropy filter", 20, Filter::Entropy),
    row("20 people, novelty filter", 20, Filter::Novelty),
    row("20 people", 20, Filter::Ours),
    row("40 people, no filter", 40, Filter::None),
    row("40 people, entropy filter", 40, Filter::Entropy),
    row("40 people, novelty filter", 40, Filter::Novelty),
    row("40 people", 40, Filter::Ours),
    row("60 people, no filter", 60, Filter::None),
    row("60 people, entropy filter", 60, Filter::Entropy),
    row("60 people, novelty filter", 60, Filter::Novelty),
    row("60 people", 60, Filter::Ours),
];

/// What can be asked for with `--row`.
pub fn row_names() -> Vec<&'static str> {
    ROWS.iter().map(|row| row.name).collect()
}

/// Drives in crowds, row by row.
pub struct Crowds {
    request: ExperimentRequest,
    rows: Vec<CrowdRow>,
}

impl Crowds {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let rows = chosen(&request, &ROWS, |row| row.name)?.into_iter().copied().collect();
        Ok(Self { request, rows })
    }
}

/// What came of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CrowdTrial {
    /// Why the run counts for nothing: its scenario failed.
    unmeasured: Option<String>,
    /// Looks before the robot was carried elsewhere ...
    looks: usize,
    /// ... and those at which the estimate was right.
    right: usize,
    /// How often beams were counted then ...
    counts: usize,
    /// ... the sum of the shares that people stood in ...
    blocked: f64,
    /// ... and how often that was half of them or more.
    half_blocked: usize,
    /// Driven until then.
    way_m: f64,
    /// How often the position counted as lost then, and the estimate was right.
    false_alarms: u32,
    /// Contacts the robot caused.
    contacts: u32,
    /// None of a run that ended before.
    carried: Option<Carried>,
}

/// What became of a robot that was carried elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Carried {
    /// Whether it took itself to be lost when that happened.
    was_lost: bool,
    /// Driven until it took itself to be lost, or its estimate was right again.
    noticed_m: Option<f64>,
    /// Driven at all.
    way_m: f64,
}

impl Carried {
    /// Whether it was noticed soon; none if the robot was lost anyway, or the run ended sooner.
    fn is_noticed(&self) -> Option<bool> {
        match self.noticed_m {
            _ if self.was_lost => None,
            Some(noticed_m) => Some(noticed_m <= NOTICED_WITHIN_M),
            None => (self.way_m > NOTICED_WITHIN_M).then_some(false),
        }
    }
}

impl ExperimentKind for Crowds {
    type Ground = (Site, Loaded);
    type Record = CrowdTrial;
    type Tally = Vec<CrowdTrial>;

    fn series(&self) -> Vec<String> {
        self.rows.iter().map(|row| row.name.to_string()).collect()
    }

    fn ground(&self, series: usize) -> Result<(Site, Loaded)> {
        let row = &self.rows[series];
        let mut world = world_files::for_all_seeds(WORLD, &self.request.robot)?;
        world.crowd = row.people;
        let mut settings = OfficeSettings::of(self.request.robot.clone());
        row.filter.apply(&mut settings.localization);
        let setup = Setup { world: Some(world), settings, ..Setup::default() };
        let site = sites::build(setup, Some(plans::scenario("experiments/crowd.rpl")?), Vec::new())?;
        let loaded = sites::load(&site, &plans::plan("experiments/in-a-crowd.rpl")?, self.request.colour)?;
        Ok((site, loaded))
    }

    fn run(&self, _: usize, (site, loaded): &(Site, Loaded), run: Run) -> Result<CrowdTrial> {
        let mut system = site.start_traced(loaded.clone(), run.seed);
        let mut watcher = Watcher::default();
        run_to(&mut system, self.request.until_us, |system| watcher.look(system));
        Ok(watcher.trial_of(&system))
    }

    fn head(&self, _: &CrowdTrial) -> String {
        "row,seed,looks,right,beams_blocked,way_m,false_alarms,contacts,was_lost,noticed_m,way_after_m".to_string()
    }

    fn lines(&self, series: &str, run: Run, trial: &CrowdTrial) -> String {
        let CrowdTrial { looks, right, counts, blocked, way_m, false_alarms, contacts, .. } = trial;
        let share = blocked / (*counts).max(1) as f64;
        let carried = trial.carried.map_or(",,".to_string(), |Carried { was_lost, noticed_m, way_m }| {
            let noticed = noticed_m.map_or(String::new(), |noticed_m| format!("{noticed_m:.2}"));
            format!("{was_lost},{noticed},{way_m:.2}")
        });
        format!("\"{series}\",{},{looks},{right},{share:.4},{way_m:.2},{false_alarms},{contacts},{carried}\n", run.seed)
    }

    fn findings(&self, tallies: Vec<Vec<CrowdTrial>>, _: bool) -> Result<Findings> {
        let rows: Vec<RowFigures> =
            self.rows.iter().zip(&tallies).map(|(row, trials)| RowFigures::of(row, trials)).collect();
        let is_measured = tallies.iter().flatten().all(|trial| trial.unmeasured.is_none());
        let status = if is_measured { Status::Succeeded } else { Status::Failed };
        Ok(Findings { status, blocks: blocks(&rows), figures: json!({ "rows": rows }), drawings: Vec::new() })
    }
}

/// Who looks at a run.
#[derive(Default)]
struct Watcher {
    due_us: u64,
    is_lost: bool,
    /// Driven when the robot was carried elsewhere.
    carried_after_m: Option<f64>,
    trial: CrowdTrial,
}

impl Watcher {
    fn look(&mut self, system: &mut System<Robot>) -> ControlFlow<()> {
        let events = system.machine.trace.take();
        let (Some(sight), Some(account)) = (system.outside.sight(), system.outside.account()) else {
            return Continue(());
        };
        let was_lost = self.is_lost;
        for kind in events.iter().filter_map(ReportKind::of) {
            match kind {
                ReportKind::PositionLost => self.lose(&sight),
                ReportKind::PositionFound => self.is_lost = false,
                ReportKind::CarriedByHand => {
                    self.carried_after_m = Some(account.distance_m);
                    self.trial.way_m = account.distance_m;
                    self.trial.carried = Some(Carried { was_lost, noticed_m: None, way_m: 0.0 });
                    // The robot has perceived nothing of it yet.
                    return Continue(());
                }
                _ => {}
            }
        }
        let (Some(since_m), Some(carried)) = (self.carried_after_m, &mut self.trial.carried) else {
            self.trial.way_m = account.distance_m;
            self.compare(system, &sight);
            return Continue(());
        };
        carried.way_m = account.distance_m - since_m;
        if self.is_lost || is_right(&sight) {
            carried.noticed_m = Some(carried.way_m);
        }
        let is_decided = carried.noticed_m.is_some() || carried.way_m > GIVEN_UP_AFTER_M;
        if is_decided { Break(()) } else { Continue(()) }
    }

    fn lose(&mut self, sight: &Sight) {
        self.is_lost = true;
        if self.carried_after_m.is_none() {
            self.trial.false_alarms += u32::from(off_m(sight) <= WRONG_ESTIMATE_M);
        }
    }

    /// Compares the estimate with the truth, and counts beams, if that is due.
    fn compare(&mut self, system: &System<Robot>, sight: &Sight) {
        let Robot::Office(robot) = &system.outside else { return };
        if system.machine.now_us < self.due_us {
            return;
        }
        self.due_us = system.machine.now_us + LOOK_US;
        let trial = &mut self.trial;
        trial.right += usize::from(is_right(sight));
        if trial.looks.is_multiple_of(BEAMS_EVERY) {
            let share = robot.host.model.blocked_share(&robot.host.state);
            trial.blocked += share;
            trial.counts += 1;
            trial.half_blocked += usize::from(share >= 0.5);
        }
        trial.looks += 1;
    }

    fn trial_of(self, system: &System<Robot>) -> CrowdTrial {
        let failed = system.outside.failed_scenario();
        let unmeasured = failed.map(|(scenario, failure)| described(&scenario.machine, &scenario.program, failure));
        let contacts = system.outside.account().and_then(|account| account.contacts).unwrap_or(0);
        CrowdTrial { unmeasured, contacts, ..self.trial }
    }
}

/// The figures of a row.
#[derive(Clone, Debug, Serialize)]
struct RowFigures {
    name: &'static str,
    people: usize,
    runs: usize,
    not_measured: usize,
    /// The mean share of the readings that people stand in; none without a look.
    beams_blocked: Option<f64>,
    /// The share of the time in which that is half of them or more.
    half_blocked: Option<f64>,
    right: Proportion,
    false_alarms_per_km: Option<PerKm>,
    noticed_within_3_m: Proportion,
    /// Robots that took themselves to be lost when they were carried elsewhere.
    lost_before: usize,
    contacts: u32,
}

impl RowFigures {
    fn of(row: &CrowdRow, trials: &[CrowdTrial]) -> Self {
        let measured: Vec<&CrowdTrial> = trials.iter().filter(|trial| trial.unmeasured.is_none()).collect();
        let carried = || measured.iter().filter_map(|trial| trial.carried);
        let noticed: Vec<bool> = carried().filter_map(|carried| carried.is_noticed()).collect();
        let looks: Vec<(usize, usize)> = measured.iter().map(|trial| (trial.right, trial.looks)).collect();
        let counts: usize = measured.iter().map(|trial| trial.counts).sum();
        let mean = |sum: f64| (counts > 0).then(|| sum / counts as f64);
        let way_m: f64 = measured.iter().map(|trial| trial.way_m).sum();
        let false_alarms = measured.iter().map(|trial| trial.false_alarms).sum();
        Self {
            name: row.name,
            people: row.people,
            runs: trials.len(),
            not_measured: trials.len() - measured.len(),
            beams_blocked: mean(measured.iter().map(|trial| trial.blocked).sum()),
            half_blocked: mean(measured.iter().map(|trial| trial.half_blocked as f64).sum()),
            right: Proportion::in_groups(&looks),
            false_alarms_per_km: PerKm::new(false_alarms, way_m / 1000.0),
            noticed_within_3_m: Proportion::new(noticed.iter().filter(|noticed| **noticed).count(), noticed.len()),
            lost_before: carried().filter(|carried| carried.was_lost).count(),
            contacts: measured.iter().map(|trial| trial.contacts).sum(),
        }
    }

    fn cells(&self) -> [String; 9] {
        let percent = |share: Option<f64>| share.map_or(NOTHING.to_string(), |share| format!("{:.1}", 100.0 * share));
        let range = |(low, high): (f64, f64)| format!(" ({:.1}–{:.1})", 100.0 * low, 100.0 * high);
        let alarms = |alarms: &PerKm| {
            let (low, high) = alarms.interval_95;
            format!("{:.2} ({low:.2}–{high:.2})", alarms.rate)
        };
        [
            self.name.to_string(),
            percent(self.beams_blocked),
            percent(self.half_blocked),
            percent(self.right.rate) + &range(self.right.interval_95),
            self.false_alarms_per_km.as_ref().map_or(NOTHING.to_string(), alarms),
            self.noticed_within_3_m.fraction(),
            self.noticed_within_3_m.interval(),
            self.lost_before.to_string(),
            self.contacts.to_string(),
        ]
    }
}

fn blocks(rows: &[RowFigures]) -> Vec<Block> {
    let heads = [
        "",
        "blocked [%]",
        "half [%]",
        "right [%] (95 %)",
        "alarms/km (95 %)",
        "noticed",
        "95 % interval",
        "lost",
        "contacts",
    ];
    let mut table = Table::new(&heads);
    rows.iter().for_each(|row| table.row(row.cells()));
    let not_measured = rows.iter().filter(|row| row.not_measured > 0);
    let mut blocks = vec![Block::Table(table)];
    blocks.extend(not_measured.map(|row| {
        Block::Lines(format!(
            "{}: {} of {} not measured, because the scenario failed",
            row.name, row.not_measured, row.runs
        ))
    }));
    blocks.push(Block::Lines(
        "blocked: the share of the readings that people stand in, the mean; half: the share of the time in which that \
         is half of them or more; right: the share of the time with the estimate within 0.5 m and 15° of the truth; \
         alarms: position lost while the estimate was right; noticed: of robots that were carried elsewhere those that \
         took themselves to be lost, or were right again, within 3 m; lost: robots that took themselves to be lost when \
         they were carried, which do not count there; contacts: caused by the robot, total"
            .into(),
    ));
    blocks
}
