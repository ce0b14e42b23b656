//! The gripper: it takes a thing, or lets go.

use super::body::ARM;
use crate::geometry::Velocity;
use crate::office::model::OfficeModel;
use crate::office::module::{Module, ModuleSpec, Moment, Start, Telling};
use crate::office::position::Position;
use crate::simulator::{Commands, GripperCommand, GripperMotion};
use crate::world::TravelMode;
use rpl_runtime::robot::{BehaviourSpec, Ending, StopReason};
use rpl_runtime::state::activation::Phase;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
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
        let symbols = &start.machine.symbols;
        let (task, command) = match (start.argument("grasp"), start.argument("release")) {
            (Some(Value::Symbol(item)), None) => {
                let item = symbols.name(item).to_string();
                (GripperTask::Grasp(item.clone()), GripperCommand::Grasp(item))
            }
            (None, Some(release)) if release.is_true() => (GripperTask::Release, GripperCommand::Release),
            _ => return Err(Raise::type_error("`gripper` takes `:grasp NAME` or `:release t`")),
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
            (GripperTask::Grasp(wanted), GripperMotion::Closed, Some(held)) if wanted == held => Ending::Success,
            (GripperTask::Release, GripperMotion::Open, _) => Ending::Success,
            (GripperTask::Grasp(wanted), ..) => {
                Ending::failure("grasp-failure", format!("the gripper does not hold `{wanted}`"))
            }
            (GripperTask::Release, ..) => Ending::failure("grasp-failure", "the gripper did not open"),
        };
        self.task = None;
        tell.end(0, ending);
        None
    }
}
