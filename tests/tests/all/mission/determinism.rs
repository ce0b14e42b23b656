//! Same program, world and seed: the same trace, byte for byte.

use rpl_robot::office::ReportKind;
use rpl_tests::detail;
use rpl_tests::mission::{Mission, Run, test_room};

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

/// CRC-32 of the trace of the errand with this seed, as a release build writes it. After a change that
/// is meant to change traces, run this test in release and put the number it reports here; debug
/// builds must then agree.
const TRACE_OF_RELEASE: u32 = 3_105_109_729;

#[test]
fn every_profile_writes_the_trace_of_a_release_build() {
    let found = crc32fast::hash(trace(SEED).as_bytes());
    assert_eq!(found, TRACE_OF_RELEASE, "{found}: the trace has changed, or depends on how it was built");
}
