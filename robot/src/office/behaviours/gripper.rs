//! The gripper: it takes a thing, or lets go.

use super::body::ARM;
use crate::foresight::abstract_robot::AbstractRobot;
use crate::foresight::models::{GraspRecord, Missed};
use crate::geometry::Velocity;
use crate::office::functions::act;
use crate::office::model::OfficeModel;
use crate::office::module::{Module, ModuleSpec, Moment, Start, Telling};
use crate::office::position::Position;
use crate::simulator::{Commands, GripperCommand, GripperMotion};
use crate::world::TravelMode;
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::{BehaviourSpec, Ending, StopReason};
use rpl_runtime::state::activation::Phase;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Reply};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// What the gripper is doing for a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum GripperTask {
    Grasp(String),
    Release,
}

/// The state of the gripper's behaviour.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Gripping {
    task: Option<GripperTask>,
    /// What goes out with the next step.
    command: GripperCommand,
    /// What it has learned.
    record: GraspRecord,
    missed: Missed,
}

impl Gripping {
    /// What it has learned of grasping.
    pub(in crate::office) fn record(&self) -> GraspRecord {
        self.record
    }

    /// The thing to grasp that the arguments name; none for letting go.
    ///
    /// # Errors
    /// They name neither.
    pub(in crate::office) fn asked(machine: &Machine, arguments: &[(Symbol, Value)]) -> Result<Option<String>, Raise> {
        match arguments {
            [(key, Value::Symbol(item))] if machine.symbols.name(*key) == "grasp" => {
                Ok(Some(machine.symbols.name(*item).to_string()))
            }
            [(key, release)] if machine.symbols.name(*key) == "release" && release.is_true() => Ok(None),
            [(key, item)] if machine.symbols.name(*key) == "grasp" => {
                Err(machine.wrong_type("`:grasp` of `gripper`", "the name of a thing", *item))
            }
            _ => Err(Raise::type_error("`gripper` takes `:grasp NAME` or `:release t`")),
        }
    }

    /// Whether the gripper was asked to grasp and has not come to an end: the thing.
    pub(in crate::office) fn wanted(&self) -> Option<&str> {
        match &self.task {
            Some(GripperTask::Grasp(thing)) => Some(thing),
            Some(GripperTask::Release) | None => None,
        }
    }
}

fn foresee_thing(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let thing = call.name(0)?;
    if let Ok(robot) = call.part::<AbstractRobot>() {
        robot.expect_here(&thing);
    }
    Ok(Reply::Value(Value::Nil))
}

impl Module for Gripping {
    type Settings = ();

    fn specs((): &()) -> Vec<ModuleSpec> {
        vec![ModuleSpec {
            name: "gripper".into(),
            behaviours: vec![BehaviourSpec {
                name: Cow::Borrowed("gripper"),
                doc: Cow::Borrowed(
                    "Takes the thing named by `:grasp`, or lets go with `:release t`; both take time. Fails with grasp-failure.",
                ),
                valve: Some(ARM),
                parameters: Cow::Borrowed(":grasp :release"),
            }],
            functions: vec![act(
                "%foresee-thing",
                "name",
                "In a projection: people have brought a thing to where the robot is.",
                foresee_thing,
            )],
            ..ModuleSpec::default()
        }]
    }

    fn new((): &(), _: &OfficeModel, _: u64) -> Self {
        Self::default()
    }

    fn start(&mut self, _: usize, start: &Start<'_>, _: &mut Position, _: &mut Telling<'_>) -> Result<(), Raise> {
        let robot = &start.model.settings.robot;
        if robot.gripper.is_none() {
            return Err(Raise::new("grasp-failure", format!("the robot `{}` has no gripper", robot.name)));
        }
        let (task, command) = match Self::asked(start.machine, start.arguments)? {
            Some(item) => (GripperTask::Grasp(item.clone()), GripperCommand::Grasp(item)),
            None => (GripperTask::Release, GripperCommand::Release),
        };
        (self.task, self.command) = (Some(task), command);
        Ok(())
    }

    /// What was commanded goes out: a hand that has begun to close closes.
    fn stop(&mut self, _: usize, _: StopReason, _: &mut Telling<'_>) {
        self.task = None;
    }

    fn command(&mut self, _: TravelMode, _: &[Phase], commands: &mut Commands) {
        commands.gripper = std::mem::take(&mut self.command);
    }

    fn step(&mut self, now: &Moment<'_>, _: &mut Position, tell: &mut Telling<'_>) -> Option<Velocity> {
        let task = self.task.as_ref()?;
        let gripper = &now.percept.gripper;
        let ending = match (task, gripper.motion, &gripper.holding) {
            (_, GripperMotion::Moving, _) => return None,
            (GripperTask::Grasp(wanted), GripperMotion::Closed, Some(held)) if wanted == held => Ending::DONE,
            (GripperTask::Release, GripperMotion::Open, _) => Ending::DONE,
            (GripperTask::Grasp(wanted), ..) => {
                Ending::failure("grasp-failure", format!("the gripper does not hold `{wanted}`"))
            }
            (GripperTask::Release, ..) => Ending::failure("grasp-failure", "the gripper did not open"),
        };
        if let Some(GripperTask::Grasp(thing)) = self.task.take() {
            self.missed.note(&thing, ending == Ending::DONE, &mut self.record);
        }
        tell.end(0, ending);
        None
    }
}
