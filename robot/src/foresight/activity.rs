//! What a projected robot is asked to do, and how that ends.

use super::act_model::ActModel;
use crate::navigation::MoveGoal;
use crate::planning::Target;
use std::sync::Arc;

/// How something that the robot does ends.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// As it should.
    Done,
    /// The map leaves no way.
    Unreachable,
    /// Its battery was empty before it arrived.
    Empty,
    /// A door kept it from coming through for all its patience.
    DoorClosed(usize),
    /// Something stands in the way of a move by the odometry.
    Hindered(MoveGoal),
    /// The gripper closed on nothing.
    NotHeld(String),
    /// The gripper did not open.
    NotOpened,
    /// The position was not found.
    NotFound,
    /// What another module does has ended with a failure of this class.
    Failed(String),
}

/// What the robot can do, one at a time each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Doing {
    /// It drives over targets.
    Driving,
    /// Its gripper moves.
    Gripping,
    /// It looks around.
    Looking,
    /// It moves by its odometry.
    Moving,
    /// It searches for its position.
    Searching,
    /// Another module does something: the behaviour of this number.
    Acting(u16),
}

/// What the robot was asked to do and has not come to the end of.
#[derive(Clone, Debug, PartialEq)]
pub enum UnderWay {
    /// To drive over targets, in order.
    Driving {
        /// Those that are left.
        targets: Vec<Target>,
        /// How long it stands before what is closed.
        patience_s: f64,
        /// Whether it moves already, so that setting off takes no more time.
        has_set_off: bool,
    },
    /// To grasp a thing.
    Grasping(String),
    /// To let go.
    Releasing,
    /// To look around.
    Looking,
    /// To turn, or to drive straight on.
    Moving(MoveGoal),
    /// To search for its position.
    Searching,
    /// What the behaviour of this number does, as its module declares it.
    Acting(u16, Arc<ActModel>),
}

impl UnderWay {
    /// What of the robot does it.
    pub fn doing(&self) -> Doing {
        match self {
            Self::Driving { .. } => Doing::Driving,
            Self::Grasping(_) | Self::Releasing => Doing::Gripping,
            Self::Looking => Doing::Looking,
            Self::Moving(_) => Doing::Moving,
            Self::Searching => Doing::Searching,
            Self::Acting(behaviour, _) => Doing::Acting(*behaviour),
        }
    }
}
