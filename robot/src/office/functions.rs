//! What the functions of modules are made with, and what they work on beside the state of their module.

use super::board::Board;
use super::model::OfficeModel;
use crate::geometry::Pose;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Effect, Native, NativeCode, NativeFunction, Reply};
use std::sync::Arc;

/// A function that looks at something and changes nothing.
pub const fn look(name: &'static str, parameters: &'static str, doc: &'static str, code: NativeFunction) -> Native {
    Native { name, parameters, doc, effect: Effect::None, code: NativeCode::Plain(code) }
}

/// A function that acts on the robot or on its world.
pub const fn act(name: &'static str, parameters: &'static str, doc: &'static str, code: NativeFunction) -> Native {
    Native { name, parameters, doc, effect: Effect::Acts, code: NativeCode::Plain(code) }
}

/// What was built from the world.
///
/// # Errors
/// There is no robot.
pub fn model(call: &mut Call<'_, '_>) -> Result<Arc<OfficeModel>, Raise> {
    call.part::<Arc<OfficeModel>>().cloned()
}

/// What the modules share.
///
/// # Errors
/// There is no robot.
pub fn board<'a>(call: &'a mut Call<'_, '_>) -> Result<&'a mut Board, Raise> {
    call.part()
}

/// A pose as plans have it: a list (x y heading).
pub(super) fn pose_list(call: &mut Call<'_, '_>, pose: Pose) -> Reply {
    let values = [pose.x_m, pose.y_m, pose.heading_rad].map(Value::Float);
    Reply::Value(call.machine.heap.list(&values))
}
