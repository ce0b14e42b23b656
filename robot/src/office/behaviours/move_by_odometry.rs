//! Moves by the odometry alone: a turn on the spot, or a straight stretch ahead or back.

use super::body::WHEELS;
use super::navigation::patience_argument;
use crate::geometry::{Pose, Velocity};
use crate::navigation::{MoveGoal, MoveHindrance, MoveStatus, RelativeMove};
use crate::office::model::OfficeModel;
use crate::office::module::{Module, ModuleSpec, Moment, Start, Telling};
use crate::office::position::Position;
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{BehaviourSpec, Ending, StopReason};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Its name.
pub(in crate::office) const NAME: &str = "move-by-odometry";

/// The state of moving by odometry: the move that is under way.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MovingByOdometry {
    moving: Option<RelativeMove>,
}

impl MovingByOdometry {
    /// What is left of the move that is under way.
    pub(in crate::office) fn left(&self, odometry_in_odom: Pose) -> Option<MoveGoal> {
        self.moving.as_ref().map(|moving| moving.left(odometry_in_odom))
    }
}

impl Module for MovingByOdometry {
    type Settings = ();

    fn specs((): &()) -> Vec<ModuleSpec> {
        vec![ModuleSpec {
            name: NAME.into(),
            behaviours: vec![BehaviourSpec {
                name: Cow::Borrowed(NAME),
                doc: Cow::Borrowed(
                    "Turns on the spot by the angle `:turn`, to the left if it is positive, full turns included, or drives straight by `:ahead` metres, back if it is negative. It goes by the odometry, needs no position, and keeps off what it sees. Succeeds once it stands there; fails with blocked if for the time of `:patience`, without it 5 seconds, it gets no further.",
                ),
                valve: Some(WHEELS),
                parameters: Cow::Borrowed(":turn :ahead :patience"),
            }],
            ..ModuleSpec::default()
        }]
    }

    fn new((): &(), _: &OfficeModel, _: u64) -> Self {
        Self::default()
    }

    fn start(
        &mut self,
        _: usize,
        start: &Start<'_>,
        position: &mut Position,
        _: &mut Telling<'_>,
    ) -> Result<(), Raise> {
        let (goal, patience_s) = arguments(start.machine, start.arguments)?;
        self.moving = Some(RelativeMove::from(position.odometry_in_odom(), goal, patience_s));
        Ok(())
    }

    fn stop(&mut self, _: usize, _: StopReason, _: &mut Telling<'_>) {
        self.moving = None;
    }

    fn step(&mut self, now: &Moment<'_>, position: &mut Position, tell: &mut Telling<'_>) -> Option<Velocity> {
        let moving = self.moving.as_mut()?;
        let ending = match moving.step(&now.model.limits, &now.input(), now.model.limits.speed_limit_mps(now.mode)) {
            MoveStatus::Moving(velocity) => return Some(velocity),
            MoveStatus::Done => Ending::DONE,
            MoveStatus::Blocked(hindrance) => {
                let here = position.estimate(now.model.map.as_ref()).pose_in_map;
                blocked(hindrance, moving.left(now.percept.odometry_in_odom), here)
            }
        };
        self.moving = None;
        tell.end(0, ending);
        Some(Velocity::default())
    }
}

/// What a robot says that gets no further; where it believes itself to be stands in the slots.
pub(in crate::office) fn blocked(hindrance: MoveHindrance, left: MoveGoal, here: Pose) -> Ending {
    let (left, side) = match left {
        MoveGoal::Turn { turn_rad } => (format!("{:.0}°", turn_rad.to_degrees().abs()), "on its way"),
        MoveGoal::Straight { ahead_m } if ahead_m < 0.0 => (format!("{:.2} m", -ahead_m), "behind it"),
        MoveGoal::Straight { ahead_m } => (format!("{ahead_m:.2} m"), "ahead of it"),
    };
    let (why, obstacle) = match hindrance {
        MoveHindrance::Obstacle => (format!("something stands {side}"), Reading::Symbol("thing".to_string())),
        MoveHindrance::Unseen => (format!("none of its sensors sees what is {side}"), Reading::Truth(false)),
        MoveHindrance::Unknown => ("nothing is seen that hinders it".to_string(), Reading::Truth(false)),
    };
    Ending::Failure {
        class: "blocked".to_string(),
        message: format!("the robot gets no further, and {left} are left: {why}"),
        slots: vec![
            ("obstacle".to_string(), obstacle),
            ("room".to_string(), Reading::Truth(false)),
            ("x".to_string(), Reading::Float(here.x_m)),
            ("y".to_string(), Reading::Float(here.y_m)),
        ],
    }
}

/// `:turn`, an angle, or `:ahead`, metres, and `:patience` in seconds.
pub(in crate::office) fn arguments(machine: &Machine, arguments: &[(Symbol, Value)]) -> Result<(MoveGoal, f64), Raise> {
    let (mut goal, mut patience_s) = (None, None);
    for &(key, value) in arguments {
        let asked = match machine.symbols.name(key) {
            "turn" => MoveGoal::Turn { turn_rad: finite(value)? },
            "ahead" => MoveGoal::Straight { ahead_m: finite(value)? },
            "patience" => {
                patience_s = patience_argument(value)?;
                continue;
            }
            _ => return Err(no_move()),
        };
        if goal.replace(asked).is_some() {
            return Err(no_move());
        }
    }
    Ok((goal.ok_or_else(no_move)?, patience_s.unwrap_or(RelativeMove::PATIENCE_S)))
}

fn finite(value: Value) -> Result<f64, Raise> {
    value.as_f64().filter(|number| number.is_finite()).ok_or_else(no_move)
}

fn no_move() -> Raise {
    Raise::type_error(
        "`move-by-odometry` takes either `:turn`, an angle, or `:ahead`, metres, and `:patience`, a time: `:turn 90deg`, `:ahead -30cm`",
    )
}
