//! The simulated host: the robot behind `step(commands) -> percept`, and the scenario beside it.

use super::scenario::Oracle;
use crate::simulator::{Commands, Percept, SimulatorModel, SimulatorState};
use rpl_runtime::behaviour::Outbox;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::value::Value;
use std::sync::Arc;

/// A simulated robot, and the experimenter's plan that runs beside it.
#[derive(Clone)]
pub struct SimulatedHost {
    /// What does not change.
    pub model: Arc<SimulatorModel>,
    /// The simulated world.
    pub state: SimulatorState,
    /// A system of its own: only it sees the oracle.
    pub scenario: Option<Box<System<Oracle>>>,
}

impl SimulatedHost {
    /// A host at the start of its world.
    pub fn new(model: Arc<SimulatorModel>, seed: u64, scenario: Option<System<Oracle>>) -> Self {
        let state = model.start(seed);
        Self { model, state, scenario: scenario.map(Box::new) }
    }

    /// One step: the scenario acts, then the robot moves and senses.
    pub fn step(&mut self, commands: &Commands, outbox: &mut Outbox) -> Percept {
        if let Some(scenario) = &mut self.scenario {
            std::mem::swap(&mut scenario.outside.state, &mut self.state);
            let was_over = scenario.outcome().is_some();
            scenario.advance_to(scenario.outside.state.time_us);
            std::mem::swap(&mut scenario.outside.state, &mut self.state);
            for (what, details) in scenario.outside.deeds.drain(..) {
                outbox.events.push((what, details));
            }
            for line in scenario.machine.output.drain(..) {
                outbox.events.push(("scenario".into(), vec![("text".into(), line.text)]));
            }
            if !was_over && let Some(Outcome::Failed(failure)) = scenario.outcome() {
                outbox.events.push(("scenario failed".into(), failure_details(scenario, failure)));
            }
        }
        self.model.step(&mut self.state, commands)
    }
}

/// What became of a scenario that failed, and where in its text.
fn failure_details(scenario: &System<Oracle>, failure: Value) -> Vec<(String, String)> {
    let (machine, program) = (&scenario.machine, &scenario.program);
    let mut details = vec![("failure".into(), machine.show(program, failure))];
    if let Value::Failure(index) = failure
        && let Some(span) = machine.heap.failures[index].span
    {
        details.push(("at".into(), program.sources.place(span)));
    }
    details
}
