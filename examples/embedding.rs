//! A plan in a program of one's own: the robot brings the mail, and reports what it holds over a
//! channel of the program.
//!
//! `cargo run --release -p rpl-mission --example embedding`

use rpl_lang::compile::NoFiles;
use rpl_mission::run::{Reached, run_to};
use rpl_mission::sight::PositionBelief;
use rpl_mission::site::{Setup, Site};
use rpl_robot::world::World;
use rpl_runtime::run::system::Outcome;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Effect, Native, NativeCode, Reply};
use std::error::Error;
use std::ops::ControlFlow::Continue;
use std::sync::{Arc, mpsc};

/// The delivery, and beside it what reports; `report` is a function of this program.
const PLAN: &str =
    concat!("(spawn (whenever (changed holding*) (report (value holding*))))\n", include_str!("delivery.rpl"));
const HALF_AN_HOUR_US: u64 = 1_800_000_000;

/// Lets the robot deliver the mail, hands on each report with its time in seconds, and gives what the
/// robot believes of its position at the end.
fn deliver(mut hear: impl FnMut(f64, String)) -> Result<PositionBelief, Box<dyn Error>> {
    let (sender, reports) = mpsc::channel();
    let report = Native {
        name: "report",
        parameters: "value",
        doc: "Tells the program around the plan of a value.",
        effect: Effect::Acts,
        code: NativeCode::Capturing(Arc::new(move |call| {
            // That nobody listens any more is no concern of the plan.
            sender.send(call.machine.write(call.around.program, call.argument(0))).ok();
            Ok(Reply::Value(Value::Nil))
        })),
    };
    let site = Site::new(Setup { world: World::builtin("dept"), natives: vec![report], ..Setup::default() })?;
    let plan = site.compile("delivery.rpl", PLAN, &mut NoFiles)?;
    let mut run = site.start(plan, 7);
    let reached = run_to(&mut run, HALF_AN_HOUR_US, |run| {
        reports.try_iter().for_each(|held| hear(run.machine.now_s(), held));
        Continue(())
    });
    match reached {
        Reached::End(Outcome::Succeeded(_)) => Ok(run.outside.belief().ok_or("without a map there is no belief")?),
        other => Err(format!("the mail is not there: {other:?}").into()),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let belief = deliver(|time_s, held| println!("{time_s:.1} s: the robot holds {held}"))?;
    let likeliest = belief.cells.iter().copied().fold(0.0, f64::max);
    println!("of {} cells, the likeliest one has a probability of {likeliest:.2}", belief.cells.len());
    Ok(())
}

#[test]
fn the_program_hears_what_the_robot_holds_and_reads_its_belief() {
    let mut heard = Vec::new();
    let belief = deliver(|_, held| heard.push(held)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(heard, ["mail", "nil"]);
    assert!((belief.cells.iter().sum::<f64>() - 1.0).abs() < 1e-6);
}
