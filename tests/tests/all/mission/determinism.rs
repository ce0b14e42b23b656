//! Same program, world and seed: the same trace, byte for byte.

use rpl_mission::modules::SiteRobot;
use rpl_robot::office::ReportKind;
use rpl_runtime::run::system::{System, Turn};
use rpl_tests::detail;
use rpl_tests::mission::{Mission, Run, fluent_text, run_until, test_room};

/// A cup is fetched and brought while somebody turns the robot.
pub const ERRAND: &str = "(deliver 'cup 'table-side 'corner)";

/// Turns it on the way from one room to the other.
pub const TURN: &str = "(wait-time 14) (rotate-robot! (if (= (random 2) 0) 70deg -70deg))";

/// A short delivery with a turn by hand.
pub fn errand() -> Mission {
    Mission::new(test_room(), ERRAND).with_scenario(TURN)
}

fn trace(seed: u64) -> String {
    errand().run(seed, 300.0).trace()
}

fn in_pool(threads: usize, seed: u64) -> String {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| trace(seed))
}

#[test]
fn the_errand_is_done_after_an_interruption() {
    let run: Run = errand().run(SEED, 300.0);
    assert!(run.outcome().starts_with("=>"), "{}\n{}", run.outcome(), run.trace());
    assert!(run.trace().contains("active-localization"), "{}", run.trace());
}

/// With which the robot loses its position by the turn; with some it follows it.
const SEED: u64 = 3;

/// r[determinism.same]
#[test]
fn the_same_seed_gives_the_same_trace() {
    assert_eq!(trace(SEED), trace(SEED));
}

#[test]
fn another_seed_gives_another_trace() {
    assert_ne!(trace(SEED), trace(SEED + 1));
}

/// r[determinism.same]
#[test]
fn the_number_of_threads_changes_nothing() {
    assert_eq!(in_pool(1, SEED), in_pool(2, SEED));
}

/// r[determinism.streams]
#[test]
fn plan_and_scenario_draw_from_streams_of_their_own() {
    const DRAW: &str = "(dotimes (i 20) (print (random 1000000)))";
    for seed in 0..4 {
        let run = Mission::new(test_room(), &format!("{DRAW} (wait-time 1)"))
            .with_scenario(&format!("(wait-time 0.5) {DRAW}"))
            .run(seed, 10.0);
        let scenario: Vec<&str> = run
            .events
            .iter()
            .filter(|event| ReportKind::of(event) == Some(ReportKind::Scenario))
            .map(|event| detail(event, "text"))
            .collect();
        assert_eq!((run.output.len(), scenario.len()), (20, 20), "{}", run.trace());
        let alike = run.output.iter().zip(&scenario).filter(|(plan, scenario)| plan == *scenario).count();
        assert_eq!(alike, 0, "seed {seed}: {:?} and {scenario:?}", run.output);
        // What the scenario draws leaves alone what the plan does.
        let alone = Mission::new(test_room(), DRAW).run(seed, 10.0);
        assert_eq!(alone.output, run.output);
    }
}

/// Control comes back after every few steps of a task, and the run cannot tell.
#[test]
fn slices_of_an_instant_change_nothing() {
    let mut system = errand().start(SEED);
    system.slice_steps = 7;
    let mut cuts = 0;
    while system.outcome().is_none() {
        match system.step_slice() {
            Turn::Idle => system.next_instant(),
            Turn::Over => {}
            Turn::Cut => cuts += 1,
        }
    }
    assert!(cuts > 0, "nothing was cut");
    assert_eq!(Run::of(system).trace(), trace(SEED));
}

/// r[determinism.value]
#[test]
fn a_fork_in_the_middle_of_it_goes_on_alike() {
    let mut system = errand().start(SEED);
    // The robot has been turned and has lost its position.
    let is_lost = |system: &mut System<SiteRobot>| {
        system.machine.now_s() > 14.0
            && fluent_text(system, "pos-certainty*").parse().is_ok_and(|certainty: f64| certainty <= 0.8)
    };
    assert!(run_until(&mut system, 300.0, is_lost), "it does not notice");
    system.machine.trace.take();
    let mut fork = system.fork();
    for run in [&mut system, &mut fork] {
        run.run_until(300_000_000);
    }
    assert_eq!(system.difference(&fork), None);
    let (rest, of_fork) = (Run::of(system).trace(), Run::of(fork).trace());
    assert!(rest.contains("position found"), "{rest}");
    assert_eq!(of_fork, rest);
}
