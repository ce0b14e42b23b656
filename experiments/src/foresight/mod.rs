//! What foresight is worth: days at an abstract office with orders that are due, each gone through by several plans.
//! The world is the one of projections, with chances that no plan knows and orders that nobody foresees.

mod days;
mod rows;
mod table;

use super::conduct::chosen;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::request::ExperimentRequest;
use anyhow::{Result, anyhow, bail};
use days::{Day, DayKind, KINDS};
use rows::{FORESIGHT, ForesightDay, REACTIVE, ROWS, RowDay, TRUTH};
use rpl_lang::compile::NoFiles;
use rpl_mission::modules::SiteModules;
use rpl_mission::run::{Reached, run_to};
use rpl_mission::site::Site;
use rpl_random::Stream;
use rpl_robot::foresight::abstract_robot::Experience;
use rpl_robot::geometry::distance_m;
use rpl_robot::office::{AbstractWorld, Forecast};
use rpl_runtime::run::library::Loaded;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::value::Value;
use rpl_shell::files::plans;
use std::ops::ControlFlow::Continue;

/// What the plans have in common.
const PLAN: &str = "experiments/foresight-day.rpl";

/// The world of the days.
const WORLD: &str = "dept";

/// A thing lies at a place that it lies this near to.
const AT_PLACE_M: f64 = 1.0;

/// Days, kind by kind.
pub struct Foresight {
    request: ExperimentRequest,
    kinds: Vec<&'static DayKind>,
}

impl Foresight {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let kinds = chosen(&request, &KINDS, |kind| kind.name)?;
        Ok(Self { request, kinds })
    }
}

/// The kinds of days.
pub fn row_names() -> Vec<&'static str> {
    KINDS.iter().map(|kind| kind.name).collect()
}

/// A site with the plan of each row.
pub struct Office {
    site: Site,
    plans: Vec<Loaded>,
}

impl ExperimentKind for Foresight {
    type Ground = Office;
    type Record = ForesightDay;
    type Tally = Vec<ForesightDay>;

    fn series(&self) -> Vec<String> {
        self.kinds.iter().map(|kind| kind.name.to_string()).collect()
    }

    fn ground(&self, _: usize) -> Result<Office> {
        let site = self.request.office(WORLD)?;
        let text = plans::plan(PLAN)?.text;
        let loaded = |work: &str| {
            let text = format!("{text}\n(with-policy (take-messages) {work})\nkept\n");
            Ok(site.compile("day.rpl", &text, &mut NoFiles)?)
        };
        let plans = ROWS.iter().map(|(_, work)| loaded(work)).collect::<Result<_>>()?;
        Ok(Office { site, plans })
    }

    fn run(&self, series: usize, office: &Office, run: Run) -> Result<ForesightDay> {
        let kind = self.kinds[series];
        let mut stream = Stream::new(run.seed, kind.name);
        // The day before, from which the robot has learned what this office is like.
        let yesterday = Day::drawn(kind, &mut stream);
        let (_, experience) =
            office.work(REACTIVE, &yesterday, Forecast::Undisturbed, stream.seed(), self.request.until_us)?;
        let day = Day::drawn(kind, &mut stream);
        let seed = stream.seed();
        let forecast = |row: usize| match row {
            FORESIGHT => Forecast::Learned(experience.clone()),
            TRUTH => Forecast::Truth,
            _ => Forecast::Undisturbed,
        };
        let rows = (0..ROWS.len()).map(|row| Ok(office.work(row, &day, forecast(row), seed, self.request.until_us)?.0));
        Ok(ForesightDay { seed: run.seed, orders: day.orders.len() as u32, rows: rows.collect::<Result<_>>()? })
    }

    fn head(&self, _: &ForesightDay) -> String {
        "kind,seed,row,orders,kept,ended [s],on the floor,twice,valves held,failure".to_string()
    }

    fn lines(&self, series: &str, run: Run, day: &ForesightDay) -> String {
        let line = |((name, _), row): (&(&str, &str), &RowDay)| {
            let RowDay { kept, ended_s, on_floor, twice, held, failure } = row;
            format!(
                "\"{series}\",{},{name},{},{kept},{ended_s:.1},{on_floor},{twice},{held},\"{}\"\n",
                run.seed,
                day.orders,
                failure.as_deref().unwrap_or_default().replace('"', "'")
            )
        };
        ROWS.iter().zip(&day.rows).map(line).collect()
    }

    fn findings(&self, tallies: Vec<Vec<ForesightDay>>, _: bool) -> Result<Findings> {
        Ok(table::findings(&self.series(), &tallies))
    }
}

impl Office {
    /// A day as a row goes through it, and what the robot has learned on it.
    fn work(
        &self,
        row: usize,
        day: &Day,
        forecast: Forecast,
        seed: u64,
        until_us: u64,
    ) -> Result<(RowDay, Experience)> {
        let Some(robot) = self.site.office_robot(seed) else { bail!("days need a world") };
        let world = robot.abstract_world(day.setting(forecast), seed).map_err(|_| anyhow!("days need a map"))?;
        let mut system = System::new(self.site.library.clone(), self.plans[row].clone(), world, seed);
        let reached = run_to(&mut system, until_us, |system| {
            system.machine.output.clear();
            Continue(())
        });
        Ok((account(&system, day, reached), system.outside.robot().experience.clone()))
    }
}

/// How a day went, by the truth at its end.
fn account(system: &System<AbstractWorld<SiteModules>>, day: &Day, reached: Reached) -> RowDay {
    let robot = system.outside.robot();
    let (mut on_floor, mut twice) = (0, 0);
    for order in &day.orders {
        let Some(thing) = robot.things.get(&order.thing) else { continue };
        let is_at = |place: &str| {
            let place = system.outside.world().place(place);
            place.is_ok_and(|place| {
                thing.lies_in_map.is_some_and(|at| distance_m(place.pose_in_map.point(), at) <= AT_PLACE_M)
            })
        };
        let is_nowhere = thing.lies_in_map.is_none();
        on_floor += u32::from(!is_nowhere && !is_at(order.from) && !is_at(order.to));
        twice += u32::from(thing.put_down > 1);
    }
    let is_held = |valve: &&rpl_runtime::state::valve::Valve| {
        valve.places().any(|place| !system.machine.places[place as usize].links.is_empty())
    };
    let (kept, failure) = match reached {
        Reached::End(Outcome::Succeeded(Value::Int(kept))) => (kept as u32, None),
        Reached::End(Outcome::Failed(failure)) => (0, Some(system.machine.show(&system.program, failure))),
        Reached::End(Outcome::Succeeded(_) | Outcome::Evaporated) | Reached::Time | Reached::Stop => {
            (0, Some("it had not ended in time".to_string()))
        }
    };
    RowDay {
        kept,
        ended_s: system.machine.now_s(),
        on_floor,
        twice,
        held: system.machine.valves.iter().filter(is_held).count() as u32,
        failure,
    }
}
