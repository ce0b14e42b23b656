//! Hosts: who moves the robot and senses for it. The truth about the world, if there is any, lives in
//! the host alone.
//!
//! A host takes commands and gives a percept, or it is lost. Then the main task fails as if something it had spawned
//! had failed, past all handlers, and the robot makes no further step. The simulated host has the truth and the
//! scenario behind it. The controller has percepts from it and gives commands, so that a plan cannot learn where the
//! robot really is.

use super::report::Report;
use super::scenario::Oracle;
use crate::simulator::{Commands, Percept, SimulatorModel, SimulatorState};
use rpl_runtime::robot::thinking::{Insight, Thought, Ticket};
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Who moves the robot and senses for it: the simulator, another process, or a replay of what was once
/// perceived.
pub trait Host {
    /// One step: the commands take effect, and at its end the robot perceives. What else happened goes
    /// into the reports.
    ///
    /// # Errors
    /// The host is gone: no step can follow.
    fn step(&mut self, commands: &Commands, reports: &mut Vec<Report>) -> Result<Percept, HostLost>;

    /// Takes a question that is to be thought about while the world goes on, or gives it back: the world stands still
    /// while the run computes, and it is answered at once.
    ///
    /// # Errors
    /// There are too many.
    fn think(&mut self, _ticket: Ticket, thought: Arc<dyn Thought>) -> Result<Option<Arc<dyn Thought>>, Raise> {
        Ok(Some(thought))
    }

    /// Which of the questions that were taken are answered after this step; one without an answer is to be asked again.
    /// Those that nobody waits for any more are given up.
    fn answers(&mut self, _is_awaited: &dyn Fn(Ticket) -> bool) -> Vec<(Ticket, Option<Insight>)> {
        Vec::new()
    }

    /// Gives all questions up that were taken: who waits for an answer.
    fn forget_questions(&mut self) -> Vec<Ticket> {
        Vec::new()
    }

    /// The process of the run had ended, and another one goes on with it. Whether the world has gone on
    /// meanwhile; one that is a part of the run has not.
    fn renew(&mut self) -> bool {
        false
    }
}

/// A host whose part of a run can be written down.
pub trait SaveHost: Host {
    /// What changes.
    fn save(&self) -> Vec<u8>;

    /// Takes over what [`SaveHost::save`] gave.
    ///
    /// # Errors
    /// One sentence on why the bytes do not fit this host.
    fn load(&mut self, bytes: &[u8]) -> Result<(), String>;
}

/// Why nobody moves the robot any more: one sentence that names the host.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HostLost(pub String);

/// A simulated robot, and the experimenter's plan that runs beside it.
#[derive(Clone)]
pub struct SimulatedHost {
    /// What does not change.
    pub model: Arc<SimulatorModel>,
    /// The simulated world: the experimenter looks into it, the robot never.
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

    /// Lets the scenario act, up to now.
    fn step_scenario(&mut self, reports: &mut Vec<Report>) {
        let Some(scenario) = &mut self.scenario else { return };
        std::mem::swap(&mut scenario.outside.state, &mut self.state);
        let was_over = scenario.outcome().is_some();
        scenario.advance_to(scenario.outside.state.time_us);
        std::mem::swap(&mut scenario.outside.state, &mut self.state);
        reports.append(&mut scenario.outside.deeds);
        reports.extend(scenario.machine.output.drain(..).map(|line| Report::Scenario { text: line.text }));
        if !was_over && let Some(Outcome::Failed(failure)) = scenario.outcome() {
            reports.push(failed(scenario, failure));
        }
    }
}

impl Host for SimulatedHost {
    /// The scenario acts, then the robot moves and senses.
    fn step(&mut self, commands: &Commands, reports: &mut Vec<Report>) -> Result<Percept, HostLost> {
        self.step_scenario(reports);
        Ok(self.model.step(&mut self.state, commands))
    }
}

/// What became of a scenario that failed, and where in its text.
fn failed(scenario: &System<Oracle>, failure: Value) -> Report {
    let (machine, program) = (&scenario.machine, &scenario.program);
    let span = match failure {
        Value::Failure(index) => machine.heap.failures[index].span,
        _ => None,
    };
    Report::ScenarioFailed { failure: machine.show(program, failure), at: span.map(|span| program.sources.place(span)) }
}
