//! What is wrong with a run.

use rpl_runtime::robot::Outside;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::output::{Channel, Output};
use rpl_runtime::state::schedule::Deviation;

/// What a line of output begins with that tells of a failure nobody handles.
const WARNING: &str = "warning: ";

/// What is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Fault {
    /// The run fails, with this text.
    Fails(String),
    /// A clean-up of a task that was ended fails, or something else that the run only warns of.
    Warns(String),
    /// It comes to another end than in the usual order: that, and this.
    Differs {
        /// The value and the output in the usual order.
        usual: String,
        /// Those in this one.
        found: String,
    },
}

/// A fault and the deviations that lead to it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// What is wrong.
    pub fault: Fault,
    /// In the order of their turns; none if it is so in the usual order.
    pub deviations: Vec<Deviation>,
    /// When it shows, in the plan's time.
    pub time_us: u64,
}

/// A warning among lines of output.
pub(crate) fn warning(output: &[Output]) -> Option<Fault> {
    let is_warning = |line: &&Output| line.channel == Channel::Log && line.text.starts_with(WARNING);
    output.iter().find(is_warning).map(|line| Fault::Warns(line.text[WARNING.len()..].to_string()))
}

/// What is wrong with how a run has ended.
pub(crate) fn failure<O: Outside>(system: &System<O>) -> Option<Fault> {
    match system.outcome()? {
        Outcome::Failed(failure) => Some(Fault::Fails(system.machine.show(&system.program, failure))),
        Outcome::Succeeded(_) | Outcome::Evaporated => None,
    }
}
