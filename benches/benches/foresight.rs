//! What it costs to look ahead: sixty projections of an hour at the office with eight orders and with thirty, half as
//! many, and as many of half an hour; sixty deliveries in the simulated grain; and what each run costs that does
//! nothing, which is a fork.

use rpl_benches::{Question, Report, median};
use rpl_lang::compile::NoFiles;
use rpl_mission::robot::Robot;
use rpl_mission::site::{Setup, Site};
use rpl_robot::world::World;
use rpl_runtime::run::system::System;
use rpl_runtime::state::projected::Grain;
use std::time::Instant;

/// Runs of which the median counts.
const RUNS: usize = 9;

/// Where orders lead from and to.
const PLACES: [&str; 5] = ["mail-slots", "a-desk", "d-centre", "wolframs-shelf", "c-centre"];

/// The example of a delivery.
const DELIVERY: &str = include_str!("../../examples/delivery.rpl");

/// An hour in which orders come at even intervals and are delivered one after the other; the battery is kept charged.
fn hour(orders: usize) -> String {
    let order = |number: usize| {
        let (from, to) =
            (PLACES[number % PLACES.len()], PLACES[(number + 1 + number / PLACES.len() % 4) % PLACES.len()]);
        format!("({} l{number} {from} {to})", 3600 * number / orders)
    };
    let orders: Vec<String> = (0..orders).map(order).collect();
    format!(
        "(def-fluent orders '({}))
         (def-plan work ()
           (loop while (value orders)
             (let ((order (pop (value orders))))
               (when (< (now) (first order)) (at-time (first order)))
               (ignore-failures (failure) (deliver (second order) (third order) (fourth order))))))
         (pursue (at-time 3600)
                 (with-policy (whenever (< battery* 0.25)
                                (with-valve wheels (go-to 'west-end) (wait-for (> battery* 0.5))))
                   (work)
                   (wait-for (create-fluent nil))))",
        orders.join(" ")
    )
}

/// Milliseconds of projecting, the median of some times.
fn project_ms(system: &System<Robot>, runs: u32, horizon_s: u64, grain: Grain) -> f64 {
    let once = |_| {
        let began = Instant::now();
        let figures = system.project_rest(runs, horizon_s * 1_000_000, grain, 1).expect("all has models");
        assert!(figures.runs == runs as usize, "all are projected");
        began.elapsed().as_secs_f64() * 1e3
    };
    median((0..RUNS).map(once).collect())
}

fn main() {
    let report = Report::from_arguments();
    let site = Site::new(Setup { world: World::builtin("dept"), ..Setup::default() }).expect("the robot has room");
    let start =
        |name: &str, text: &str| site.start(site.compile(name, text, &mut NoFiles).expect("the plan is right"), 1);
    let (eight, thirty) = (start("hour.rpl", &hour(8)), start("hour.rpl", &hour(30)));
    let (delivery, nothing) = (start("delivery.rpl", DELIVERY), start("nothing.rpl", "(random 1.0)"));
    let question = |name, what, target| Question::new(name, what, "ms", target, "–");
    let events = |system, runs, horizon_s| move || project_ms(system, runs, horizon_s, Grain::Abstract);
    report.row(
        question("foresight-60", "sixty projections of an hour with eight orders", 50.0),
        events(&eight, 60, 3600),
    );
    report.row(question("foresight-30", "thirty of them", 25.0), events(&eight, 30, 3600));
    report.row(question("foresight-half", "sixty of half an hour", 25.0), events(&eight, 60, 1800));
    report.row(
        question("foresight-30-orders", "sixty projections of an hour with thirty orders", 150.0),
        events(&thirty, 60, 3600),
    );
    report.row(question("simulated-60", "sixty simulated deliveries", 1000.0), || {
        project_ms(&delivery, 60, 3600, Grain::Simulated)
    });
    for (name, what, grain, target_us) in [
        ("fork", "a simulated run that does nothing", Grain::Simulated, 50.0),
        ("fork-abstract", "an abstract run that does nothing", Grain::Abstract, 10.0),
    ] {
        report.row(Question::new(name, what, "µs", target_us, "–"), || project_ms(&nothing, 1000, 3600, grain));
    }
}
