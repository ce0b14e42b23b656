//! What is said to a module in another process and what it says: JSON Lines, each an object with a `type`.

use crate::host::PerceptMessage;
use crate::value::Spoken;
use rpl_lang::visible::clause;
use rpl_robot::geometry::Pose;
use rpl_robot::localization::Estimate;
use rpl_runtime::robot::StopReason;
#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// The version of what is said here. A module that speaks another one is refused.
pub const VERSION: u32 = 2;

/// A longer line is no message.
pub const MOST_BYTES: usize = 1 << 20;

/// Who says more messages in one turn floods.
pub const MOST_MESSAGES: usize = 1_000;

/// Nor may all of one turn together be longer.
pub const MOST_BYTES_A_TURN: usize = 8 << 20;

/// What a module is told of the run when it is greeted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Greeting {
    /// Microseconds between two steps of the robot.
    pub period_us: u64,
    /// The seed of the run.
    pub seed: u64,
}

/// When the messages of a module take effect.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Pace {
    /// Each step of the robot waits for the answer of the module.
    #[default]
    LockStep,
    /// At the robot's next step after they come.
    Live,
}

impl Greeting {
    /// How a module of a name is greeted.
    pub fn hello(self, module: &str, pace: Pace) -> ToModule {
        let Self { period_us, seed } = self;
        let rpl = env!("CARGO_PKG_VERSION").to_string();
        ToModule::Hello { protocol: VERSION, rpl, module: module.to_string(), period_us, pace, seed }
    }
}

/// What a module is told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
pub enum ToModule {
    /// The first message: who speaks. The module answers with its own `hello`.
    Hello {
        /// The version of this protocol.
        protocol: u32,
        /// The version of rpl.
        rpl: String,
        /// The name of the module in its manifest.
        module: String,
        /// Microseconds between two ticks.
        period_us: u64,
        /// When its messages take effect.
        pace: Pace,
        /// The seed of the run, for whatever the module leaves to chance.
        seed: u64,
    },
    /// A plan activates a behaviour.
    Start {
        /// Names this activation; no other has it.
        id: u64,
        /// The behaviour.
        behaviour: String,
        /// Values by the names of parameters, those that the plan gives.
        arguments: BTreeMap<String, Spoken>,
        /// Time since the start of the run.
        time_us: u64,
    },
    /// A behaviour is to end: it says nothing more of this activation.
    Stop {
        /// The activation.
        id: u64,
        /// The behaviour.
        behaviour: String,
        /// Why.
        reason: Stopped,
    },
    /// A plan asks something: the module answers at once, with `success` or `failure`.
    Query {
        /// Names this question; no other has it, nor an activation.
        id: u64,
        /// The query.
        query: String,
        /// Values by position.
        arguments: Vec<Spoken>,
        /// Time since the start of the run.
        time_us: u64,
    },
    /// The robot has made a step, or its time has passed where there is none. The module says what is new, and then `done`.
    Tick {
        /// Time since the start of the run.
        time_us: u64,
        /// Where the robot believes itself to be, if the manifest wants it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        position: Option<Position>,
        /// What the robot perceives, if the manifest wants it: as a host in another process says it.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        percept: Option<Box<PerceptMessage>>,
    },
    /// The run is over: the module ends.
    Bye,
}

/// What a module says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(tag = "type", rename_all = "kebab-case", deny_unknown_fields)]
pub enum FromModule {
    /// The answer to `hello`.
    Hello {
        /// The version of this protocol that it speaks.
        protocol: u32,
        /// Its name.
        module: String,
    },
    /// New values of its fluents, as one assignment.
    Fluents {
        /// By name.
        values: BTreeMap<String, Spoken>,
    },
    /// A behaviour has done what it was asked to, or a query is answered.
    Success {
        /// The activation or the question.
        id: u64,
        /// The value of the call in the plan; without one, that of a behaviour is `t`, and that of a query `nil`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        value: Option<Spoken>,
    },
    /// A behaviour cannot do what it was asked to, or a query has no answer.
    Failure {
        /// The activation or the question.
        id: u64,
        /// The class of the failure, which a plan has defined; any other is told as `behaviour-failure`.
        class: String,
        /// One sentence.
        message: String,
        /// Values of the class's slots.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        slots: BTreeMap<String, Spoken>,
    },
    /// Something worth a line in the trace.
    Event {
        /// What happened.
        what: String,
        /// Details by name.
        #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
        details: BTreeMap<String, Spoken>,
    },
    /// The answer to a tick is complete.
    Done {
        /// The time of that tick.
        time_us: u64,
        /// What a behaviour that holds the valve `wheels` wants of them until the next `done`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        drive: Option<Drive>,
    },
}

/// Why a behaviour is to end.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Stopped {
    /// Its plan wants no more of it.
    Deactivated,
    /// Its valve is lent to somebody else, or its goals are removed.
    Interrupted,
}

impl From<StopReason> for Stopped {
    fn from(reason: StopReason) -> Self {
        match reason {
            StopReason::Deactivated => Stopped::Deactivated,
            StopReason::Interrupted => Stopped::Interrupted,
        }
    }
}

/// Speeds of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Ahead, negative backwards.
    pub translation_mps: f64,
    /// Counter-clockwise.
    pub rotation_radps: f64,
}

/// Where the robot believes itself to be, in the map; without a map, from where it was switched on.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Position {
    /// Along x.
    pub x_m: f64,
    /// Along y.
    pub y_m: f64,
    /// Counter-clockwise from x.
    pub heading_rad: f64,
    /// From 0 to 1.
    pub certainty: f64,
}

impl From<Estimate> for Position {
    fn from(Estimate { pose_in_map: Pose { x_m, y_m, heading_rad }, certainty }: Estimate) -> Self {
        Self { x_m, y_m, heading_rad, certainty }
    }
}

/// One turn of a conversation with a module: starts and stops, and a tick or a query at the end; `bye` alone; or `hello`
/// alone, for a module that was lost and is to start again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModuleWords(pub Vec<ToModule>);

/// What came back: all messages of the turn, and whether they were the last.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModuleAnswer {
    /// In the order they were said.
    pub messages: Vec<FromModule>,
    /// There will be no more of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loss: Option<Loss>,
}

/// How a module was lost.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Loss {
    /// What it did, as the rest of a sentence about it: "it ended with exit status 3".
    pub why: String,
    /// The last lines it wrote to its standard error, if it wrote any.
    pub last_words: String,
}

impl FromModule {
    /// The message in a line.
    ///
    /// # Errors
    /// What is wrong with it, as a clause.
    pub fn read(line: &[u8]) -> Result<Self, String> {
        let text = std::str::from_utf8(line)
            .map_err(|error| format!("said something that is not UTF-8 (at byte {})", error.valid_up_to()))?;
        serde_json::from_str(text).map_err(|error| match serde_json::from_str::<serde_json::Value>(text) {
            Ok(serde_json::Value::Object(_)) | Err(_) => {
                let kind = if error.is_data() { "a wrong message" } else { "something that is no JSON" };
                format!("said {kind}: {}: {}", clause(&error.to_string()), clause(text))
            }
            Ok(_) => {
                format!("said something that is no message, which is an object with a `type`: {}", clause(text))
            }
        })
    }
}
