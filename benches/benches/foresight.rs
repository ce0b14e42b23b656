//! What it costs to look ahead: sixty projections of an hour at the office with eight orders, half as many, and as many
//! of half an hour.

use rpl_benches::{Question, Report, median};
use rpl_lang::compile::NoFiles;
use rpl_mission::site::{Setup, Site};
use rpl_robot::world::World;
use std::time::Instant;

/// Runs of which the median counts.
const RUNS: usize = 9;

/// Eight orders, delivered one after the other, and then nothing; the battery is kept charged.
const HOUR: &str = "
    (def-fluent orders '((l1 mail-slots wolframs-shelf) (l2 a-desk c-centre) (l3 d-centre wolframs-shelf)
                         (l4 mail-slots c-centre) (l5 a-desk wolframs-shelf) (l6 d-centre c-centre)
                         (l7 mail-slots a-desk) (l8 c-centre d-centre)))
    (def-plan work ()
      (loop while (value orders)
        (let ((order (pop (value orders))))
          (ignore-failures (failure) (deliver (first order) (second order) (third order))))))
    (pursue (at-time 3600)
            (with-policy (whenever (< battery* 0.25)
                           (with-valve wheels (go-to 'west-end) (wait-for (> battery* 0.5))))
              (work)
              (wait-for (create-fluent nil))))";

fn main() {
    let report = Report::from_arguments();
    let site = Site::new(Setup { world: World::builtin("dept"), ..Setup::default() }).expect("the robot has room");
    let system = site.start(site.compile("hour.rpl", HOUR, &mut NoFiles).expect("the plan is right"), 1);
    let question = |name, what, target| Question::new(name, what, "ms", target, "–");
    let project = |runs: u32, horizon_s: u64| {
        let one_run = |_| {
            let began = Instant::now();
            let figures = system.project_rest(runs, horizon_s * 1_000_000, 1).expect("all has models");
            assert!(figures.runs == runs as usize, "all are projected");
            began.elapsed().as_secs_f64() * 1e3
        };
        median((0..RUNS).map(one_run).collect())
    };
    report.row(question("foresight-60", "sixty projections of an hour with eight orders", 50.0), || project(60, 3600));
    report.row(question("foresight-30", "thirty of them", 25.0), || project(30, 3600));
    report.row(question("foresight-half", "sixty of half an hour", 25.0), || project(60, 1800));
}
