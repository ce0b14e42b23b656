//! A mission that is saved and loaded on the way goes on as if nothing had happened.

use super::determinism::{ERRAND, TURN, errand};
use rpl_mission::modules::SiteRobot;
use rpl_runtime::run::save::SaveError;
use rpl_runtime::run::system::{Progress, System};
use rpl_tests::mission::{Grid, Mission, builtin, lines, test_room};

const SEED: u64 = 1;

/// The trace of a run that is replaced by its reloaded copy whenever a number of instants have passed.
fn reloaded(mission: &Mission, every: usize, until_s: f64) -> String {
    let mut system = mission.start(SEED);
    let mut events = Vec::new();
    let mut instants = 0;
    while system.machine.now_s() < until_s && system.advance() == Progress::Running {
        events.append(&mut system.machine.trace.take());
        instants += 1;
        if instants % every == 0 {
            let bytes = system.save();
            system = mission.load(&bytes, SEED);
            assert!(bytes == system.save(), "the copy differs at {} s", system.machine.now_s());
        }
    }
    events.append(&mut system.machine.trace.take());
    lines(&events)
}

fn undisturbed(mission: &Mission, until_s: f64) -> String {
    mission.run(SEED, until_s).trace()
}

#[test]
fn reloading_at_every_step_changes_nothing() {
    assert_eq!(reloaded(&errand(), 1, 60.0), undisturbed(&errand(), 60.0));
}

/// The delivery in the department, with a turn by hand on the way.
fn delivery(grid: Grid) -> Mission {
    let plan = include_str!("../../../../examples/delivery.rpl");
    Mission::new(builtin("dept", grid), plan).with_scenario("(wait-time 4) (rotate-robot! 150deg)")
}

#[test]
fn reloading_a_delivery_changes_nothing() {
    for (grid, every) in [(Grid::Coarse, 1), (Grid::Full, 100)] {
        let mission = delivery(grid);
        let trace = undisturbed(&mission, 300.0);
        assert!(trace.contains("position lost") && trace.contains("mail delivered"), "{trace}");
        assert_eq!(reloaded(&mission, every, 300.0), trace);
    }
}

#[test]
fn a_fork_goes_its_own_way() {
    let mut system = errand().start(SEED);
    system.run_until(3_000_000);
    let mut fork = system.fork();
    fork.stop();
    fork.run_until(4_000_000);
    system.run_until(60_000_000);
    assert_eq!(lines(&system.machine.trace.take()), undisturbed(&errand(), 60.0));
}

fn refusal(mission: &Mission, bytes: &[u8]) -> String {
    match System::<SiteRobot>::load(bytes, mission.start(SEED).library, mission.plan.clone(), mission.robot(SEED)) {
        Ok(_) => panic!("these bytes fit"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn a_run_does_not_fit_another_world_grid_or_scenario() {
    let bytes = errand().start(SEED).save();
    let elsewhere = Mission::new(super::world::closed_room(), ERRAND).with_scenario(TURN);
    assert!(refusal(&elsewhere, &bytes).contains("the world `test-room`"));
    let finer = Mission::new(builtin("test-room", Grid::Full), ERRAND).with_scenario(TURN);
    assert!(refusal(&finer, &bytes).contains("other settings of localization"));
    let alone = Mission::new(test_room(), ERRAND);
    assert!(refusal(&alone, &bytes).contains("saved with a scenario"));
    assert!(refusal(&errand(), &alone.start(SEED).save()).contains("saved without a scenario"));
    let another = Mission::new(test_room(), ERRAND).with_scenario("(wait-time 1)");
    assert!(refusal(&another, &bytes).contains("in the scenario"));
    assert_eq!(refusal(&errand(), &bytes[..bytes.len() - 1]), SaveError::Damaged.to_string());
}
