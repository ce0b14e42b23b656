//! How far the grains of projection are off: deliveries of the simulated robot, with its filter, each foretold in either
//! grain before it begins.

use super::drive_times::worlds;
use super::findings::Findings;
use super::kind::{ExperimentKind, Run};
use super::request::ExperimentRequest;
use super::statistics::Proportion;
use anyhow::{Result, anyhow, bail};
use rpl_lang::compile::NoFiles;
use rpl_mission::robot::Robot;
use rpl_mission::run::{Reached, run_to};
use rpl_mission::site::Site;
use rpl_random::Stream;
use rpl_robot::world::Place;
use rpl_runtime::run::system::Outcome;
use rpl_runtime::state::projected::Grain;
use rpl_shell::status::Status;
use rpl_shell::terminal::page::Block;
use rpl_shell::terminal::table::{NOTHING, Table};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::ops::ControlFlow::Continue;

/// Projected runs of which a forecast is made.
const RUNS: u32 = 20;

/// How far is projected; no delivery takes as long.
const HORIZON_US: u64 = 3_600_000_000;

/// What is delivered.
const THING: &str = "parcel";

/// What a grain has foretold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Forecast {
    /// The share of successes.
    success: f64,
    /// The median time of those; none if all failed.
    time_s: Option<f64>,
}

/// A delivery that was foretold and has run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Delivery {
    /// By each grain, in their order.
    forecasts: Vec<Forecast>,
    is_success: bool,
    took_s: f64,
}

impl Delivery {
    /// By what part the time was off that a grain has foretold, of a delivery that succeeded.
    fn error(&self, grain: usize) -> Option<f64> {
        let foretold_s = self.forecasts[grain].time_s.filter(|_| self.is_success)?;
        Some((foretold_s / self.took_s - 1.0).abs())
    }
}

/// Deliveries, world by world.
pub struct Grains {
    request: ExperimentRequest,
    worlds: Vec<&'static str>,
}

impl Grains {
    /// What is asked for.
    ///
    /// # Errors
    /// No row has the name.
    pub fn new(request: ExperimentRequest) -> Result<Self> {
        let worlds = worlds(&request)?;
        Ok(Self { request, worlds })
    }
}

impl ExperimentKind for Grains {
    type Ground = Site;
    /// None where no delivery was drawn.
    type Record = Option<Delivery>;
    type Tally = Vec<Option<Delivery>>;

    fn series(&self) -> Vec<String> {
        self.worlds.iter().map(|world| (*world).to_string()).collect()
    }

    fn ground(&self, series: usize) -> Result<Site> {
        self.request.office(self.worlds[series])
    }

    fn run(&self, _: usize, site: &Site, run: Run) -> Result<Option<Delivery>> {
        deliver(site, run.seed, self.request.until_us)
    }

    fn head(&self, _: &Option<Delivery>) -> String {
        let of = |grain: Grain| format!("{0}_success,{0}_time_s", grain.name());
        format!("world,seed,{},succeeded,took_s", Grain::ALL.map(of).join(","))
    }

    fn lines(&self, series: &str, run: Run, delivery: &Option<Delivery>) -> String {
        let Some(Delivery { forecasts, is_success, took_s }) = delivery else { return String::new() };
        let of = |forecast: &Forecast| {
            let time_s = forecast.time_s.map_or(String::new(), |time_s| format!("{time_s:.2}"));
            format!("{:.3},{time_s}", forecast.success)
        };
        let forecasts: Vec<String> = forecasts.iter().map(of).collect();
        format!("{series},{},{},{},{took_s:.2}\n", run.seed, forecasts.join(","), u8::from(*is_success))
    }

    fn findings(&self, tallies: Vec<Vec<Option<Delivery>>>, _: bool) -> Result<Findings> {
        let heads = ["world", "grain", "deliveries", "median error [%]", "90 % within [%]", "foretold", "succeeded"];
        let mut table = Table::new(&heads);
        let mut rows: Vec<Value> = Vec::new();
        for (world, deliveries) in self.worlds.iter().zip(&tallies) {
            rows.extend(tell(world, deliveries, &mut table));
        }
        if tallies.len() > 1 {
            rows.extend(tell("all", &tallies.concat(), &mut table));
        }
        let (blocks, figures) = (vec![Block::Table(table)], json!({ "rows": rows }));
        Ok(Findings { status: Status::Succeeded, blocks, figures, drawings: Vec::new() })
    }
}

/// A row for each grain.
fn tell(world: &str, drawn: &[Option<Delivery>], table: &mut Table) -> Vec<Value> {
    let deliveries: Vec<&Delivery> = drawn.iter().flatten().collect();
    let succeeded = Proportion::new(deliveries.iter().filter(|delivery| delivery.is_success).count(), deliveries.len());
    let row = |(number, grain): (usize, Grain)| {
        let mut errors: Vec<f64> = deliveries.iter().filter_map(|delivery| delivery.error(number)).collect();
        errors.sort_by(f64::total_cmp);
        let quantile = |share: f64| errors.get((share * errors.len() as f64) as usize).copied();
        let shares: f64 = deliveries.iter().map(|delivery| delivery.forecasts[number].success).sum();
        let foretold = (!deliveries.is_empty()).then(|| shares / deliveries.len() as f64);
        let percent = |part: Option<f64>| part.map_or(NOTHING.to_string(), |part| format!("{:.1}", 100.0 * part));
        table.row([
            world.to_string(),
            grain.name().to_string(),
            deliveries.len().to_string(),
            percent(quantile(0.5)),
            percent(quantile(0.9)),
            foretold.map_or(NOTHING.to_string(), |share| format!("{:.1} %", 100.0 * share)),
            succeeded.fraction(),
        ]);
        json!({
            "row": world, "grain": grain.name(), "deliveries": deliveries.len(), "median_error": quantile(0.5),
            "error_90": quantile(0.9), "foretold": foretold, "succeeded": succeeded
        })
    };
    Grain::ALL.into_iter().enumerate().map(row).collect()
}

/// One delivery from where the robot stands over a place to another, all drawn; none if two of them are the same, or
/// the robot cannot stand there.
fn deliver(site: &Site, seed: u64, until_us: u64) -> Result<Option<Delivery>> {
    let Some(office) = site.office() else { bail!("deliveries need a world") };
    let mut stream = Stream::new(seed, "delivery");
    let places = &office.world.places;
    let [start, from, to]: [&Place; 3] = std::array::from_fn(|_| &places[stream.index(places.len())]);
    let are_different = start.name != from.name && from.name != to.name && start.name != to.name;
    let robot = site.office_robot(seed).and_then(|robot| robot.starting_at(start.pose_in_map).ok());
    let (Some(mut robot), true) = (robot, are_different) else { return Ok(None) };
    robot.host.state.place_item(THING, from.pose_in_map.point());
    let plan = format!("(deliver '{THING} '{} '{})", from.name, to.name);
    let loaded = site.compile("delivery.rpl", &plan, &mut NoFiles)?;
    let mut system = site.start_traced_with(Robot::Office(Box::new(robot)), loaded, seed);
    let forecasts = Grain::ALL.into_iter().map(|grain| {
        let figures = system.project_rest(RUNS, HORIZON_US, grain, seed);
        let figures = figures.map_err(|why| anyhow!("`{plan}` is not projected: {why}"))?;
        Ok(Forecast { success: figures.success[0], time_s: figures.time_s.map(|[_, median_s, _]| median_s) })
    });
    let forecasts = forecasts.collect::<Result<Vec<Forecast>>>()?;
    let reached = run_to(&mut system, until_us, |system| {
        system.machine.trace.take();
        Continue(())
    });
    let is_success = matches!(reached, Reached::End(Outcome::Succeeded(_)));
    Ok(Some(Delivery { forecasts, is_success, took_s: system.machine.now_s() }))
}
