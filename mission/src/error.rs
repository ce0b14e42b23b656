//! Why a mission cannot be put together: values with what was found, where, and what would be right.

use crate::cost::TooLarge;
use rpl_robot::localization::ModelError;
use rpl_robot::world::StartTaken;
use rpl_runtime::run::library::Rejected;
use thiserror::Error;

/// Why there is no such site, or no such plan on it.
#[derive(Debug, Error)]
pub enum SiteError {
    /// The world would take more memory than it may.
    #[error(transparent)]
    TooLarge(#[from] Box<TooLarge>),
    /// The robot cannot be put into the world.
    #[error("the robot cannot be put into the world `{world}`")]
    Unfit {
        /// The world.
        world: String,
        /// What is wrong with it.
        source: ModelError,
    },
    /// The robot has no room where it is to start.
    #[error("the robot cannot start in the world `{world}`")]
    NoRoom {
        /// The world.
        world: String,
        /// What is in its way.
        source: StartTaken,
    },
    /// A scenario, of this name, where there is no robot.
    #[error("the scenario `{0}` needs a robot")]
    ScenarioWithoutRobot(String),
    /// A scenario with faults in its text.
    #[error("the scenario `{name}` is wrong\n{}", .rejected.render(false).trim_end())]
    Scenario {
        /// The scenario.
        name: String,
        /// What was found in it.
        rejected: Rejected,
    },
    /// A plan with faults in its text.
    #[error("the plan cannot run\n{}", .0.render(false).trim_end())]
    Plan(Rejected),
    /// A native function of the program around has a name that is taken.
    #[error("`{0}` has a meaning already; give the native function another name")]
    NativeTaken(&'static str),
    /// Modules in other processes do not fit together, or not with the robot and the language.
    #[error("{0}")]
    Modules(String),
    /// A module in another process needs a robot, and there is none; as a clause about it.
    #[error("{0}, and there is none; add `--world dept`")]
    ModuleWithoutRobot(String),
    /// The plans of a module in another process have faults in their text.
    #[error("the plans of a module are wrong\n{}", .0.render(false).trim_end())]
    ModulePlans(Rejected),
    /// The prelude does not compile.
    #[error("the prelude does not compile, which is a fault of rpl\n{}", .0.render(false))]
    Prelude(Rejected),
}
