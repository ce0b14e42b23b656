//! Its functions.

use super::counting::Counting;
use super::data::{
    instruction_data, instruction_of, judgement_data, percept_data, percept_of, pose_data, said, side_named,
};
use super::hallway::Hallway;
use super::seeing::Seeing;
use super::state::Lola;
use crate::feature::Feature;
use crate::instruction::parse;
use crate::judgement::{Expectation, Judgement};
use crate::state_set::Inference;
use rpl_robot::file_text::FileFaults;
use rpl_robot::geometry::Pose;
use rpl_robot::office::{act, look, model};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native, Reply};

/// The table.
pub(super) fn functions() -> Vec<Native> {
    vec![
        look(
            "parse-instructions",
            "instructions",
            "A list of instructions as data, from words in a text or a message, such as \"take the third left, then it is the second door on the right\"; or from data, which is checked: (leave left), (turn 3 left), (enter 2 right), (past foyer), (hallway-end).",
            parse_instructions,
        ),
        act(
            "start-state-set",
            "instruction &optional from",
            "Begins to count for an instruction, given as data: (turn 3 left), (enter 2 right), (past foyer); openings count that begin at `from` metres along the hallway or beyond, without it at its beginning. Others need no counting.",
            start_state_set,
        ),
        act(
            "progress-state-set",
            "",
            "Takes into the state set what was perceived since, each opening once. The value is the percept that is most likely the goal of the instruction, a list (number side kind from to), or nil as long as the robot is more likely on the way.",
            progress_state_set,
        ),
        look(
            "explain-instruction",
            "instruction &optional from",
            "Judges an instruction that counts openings by all that was seen of the hallway from `from` metres on: a list (verdict sentence probability kind opening meant). The verdict is right, wrong or look-again; the probability is that it is wrong; the kind of fault is no-such-opening or other-kind; the opening is its goal as a percept, or nil; what was likeliest meant instead is an instruction, or nil.",
            explain_instruction,
        ),
        look(
            "absence-probability",
            "kind",
            "How likely an instruction is wrong that asks for something beside the hallway, a foyer, hallway, open-door or closed-door, where nothing was seen.",
            absence_probability,
        ),
        look(
            "instruction-in-words",
            "instruction",
            "An instruction, given as data, as people say it: \"take the third left\" for (turn 3 left).",
            instruction_in_words,
        ),
        look(
            "seen-both-ways?",
            "",
            "Whether the robot has come along its hallway more than once: there, and back after `turn-hallway-round`.",
            seen_both_ways,
        ),
        act(
            "turn-hallway-round",
            "",
            "The hallway is from now on one that the robot goes along the other way; what was seen of it is kept for `explain-instruction`. The value is how far it is back to its beginning, in metres, or nil if the robot goes along it the first way again.",
            turn_hallway_round,
        ),
        look(
            "opening-at-end",
            "side",
            "The percept on this side of the robot that reaches to the end of the hallway, before which the robot stands; nil if there is none.",
            opening_at_end,
        ),
        look(
            "opening-pose",
            "percept",
            "The middle of a perceived opening on the line of the wall, looking in: x, y, heading in the frame of the odometry.",
            opening_pose,
        ),
        look(
            "pose-from",
            "pose ahead left &optional turn",
            "The pose so far ahead and to the left of another one, turned by so much: x, y, heading.",
            pose_from,
        ),
        look("has-camera?", "", "Whether the robot has a camera.", has_camera),
        look(
            "hallway-position",
            "",
            "How far the robot is along its hallway, in metres from its beginning.",
            hallway_position,
        ),
    ]
}

fn parse_instructions(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let instructions = match said(call.machine, call.argument(0)) {
        Some(text) => {
            call.burn_text(text.len());
            parse(&text).map_err(unclear)?
        }
        None => {
            let given = call.list(0)?;
            given.into_iter().map(|data| instruction_of(call.machine, data)).collect::<Result<_, _>>()?
        }
    };
    let data: Vec<Value> = instructions.into_iter().map(|one| instruction_data(call.machine, one)).collect();
    Ok(Reply::Value(call.machine.heap.list(&data)))
}

/// All that was not understood, in one line each.
fn unclear(faults: FileFaults) -> Raise {
    let told: Vec<String> = faults.findings.iter().map(|found| format!("{}; {}", found.message, found.help)).collect();
    Raise::new("unclear-instruction", told.join("\n"))
}

/// What leads off at the end of a hallway is no farther before the robot, who stands there, than its end.
fn opening_at_end(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let name = call.name(0)?;
    let side =
        side_named(&name).ok_or_else(|| Raise::type_error(format!("`{name}` is no side; there are left and right")))?;
    let hallway = call.part::<Lola>()?.hallway.as_ref().ok_or_else(no_hallway)?;
    let percept = hallway.percepts.iter().rev().find(|one| one.side == side && one.to_m > hallway.along_m()).copied();
    Ok(Reply::Value(percept.map_or(Value::Nil, |percept| percept_data(call.machine, &percept))))
}

fn start_state_set(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let instruction = instruction_of(call.machine, call.argument(0))?;
    let from_m = if call.arguments.len() > 1 { call.number(1)? } else { 0.0 };
    let lola = call.part::<Lola>()?;
    lola.counting = Counting::start(instruction, from_m);
    lola.has_news = true;
    Ok(Reply::Value(Value::Nil))
}

fn progress_state_set(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let inference = inference(call)?;
    let lola = call.part::<Lola>()?;
    let arrived = match (&mut lola.counting, &lola.hallway) {
        (Some(counting), Some(hallway)) => counting.progress(&inference, &hallway.percepts, &hallway.hidden()),
        _ => None,
    };
    lola.has_news = true;
    Ok(Reply::Value(arrived.map_or(Value::Nil, |percept| percept_data(call.machine, &percept))))
}

/// What percepts are judged by: as was set, or else by what the robot sees with.
fn inference(call: &mut Call<'_, '_>) -> Result<Inference, Raise> {
    let lola = call.part::<Lola>()?;
    let with_markers = lola.markers.as_ref().is_some_and(Seeing::has_found);
    Ok(lola.settings.inference.clone().unwrap_or_else(|| Inference::of_robot(with_markers)))
}

fn explain_instruction(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let instruction = instruction_of(call.machine, call.argument(0))?;
    let Some(goal) = instruction.goal() else {
        return Err(Raise::type_error(
            "`explain-instruction` takes an instruction that counts openings, a turn or an enter",
        ));
    };
    let from_m = if call.arguments.len() > 1 { call.number(1)? } else { 0.0 };
    let expectation = Expectation::of_event(inference(call)?.matrix);
    let hallway = call.part::<Lola>()?.hallway.as_ref().ok_or_else(no_hallway)?;
    let (looks, end_m) = hallway.looks(from_m);
    let judgement = Judgement::of(goal, &looks, end_m, &expectation);
    let opening = judgement.at.map(|percept| hallway.as_seen_now(&percept));
    Ok(Reply::Value(judgement_data(call.machine, &judgement, opening)))
}

fn absence_probability(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let name = call.name(0)?;
    let kind = Feature::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| {
        let names = Feature::ALL.map(Feature::name).join(", ");
        Raise::type_error(format!("nothing beside a hallway is called `{name}`; there are {names}"))
    })?;
    let expectation = Expectation::of_event(inference(call)?.matrix);
    Ok(Reply::Value(Value::Float(expectation.wrong_if_unseen(kind))))
}

fn instruction_in_words(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let instruction = instruction_of(call.machine, call.argument(0))?;
    Ok(Reply::Value(call.machine.heap.string(&instruction.to_string())))
}

fn seen_both_ways(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let is_seen = call.part::<Lola>()?.hallway.as_ref().is_some_and(Hallway::is_looked_back_at);
    Ok(Reply::Value(if is_seen { Value::True } else { Value::Nil }))
}

fn turn_hallway_round(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let lola = call.part::<Lola>()?;
    let hallway = lola.hallway.as_ref().ok_or_else(no_hallway)?;
    let back_m = hallway.along_m();
    let turned = hallway.turned_round();
    let value = if turned.is_gone_back() { Value::Float(back_m) } else { Value::Nil };
    lola.hallway = Some(turned);
    lola.has_news = true;
    Ok(Reply::Value(value))
}

fn opening_pose(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let percept = percept_of(call.machine, call.argument(0))?;
    let hallway = call.part::<Lola>()?.hallway.as_ref().ok_or_else(no_hallway)?;
    let pose = hallway.opening_in_odom(&percept);
    Ok(Reply::Value(pose_data(call.machine, pose)))
}

fn hallway_position(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let along_m = call.part::<Lola>()?.hallway.as_ref().ok_or_else(no_hallway)?.along_m();
    Ok(Reply::Value(Value::Float(along_m)))
}

fn has_camera(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let has_camera = model(call)?.settings.robot.camera.is_some();
    Ok(Reply::Value(if has_camera { Value::True } else { Value::Nil }))
}

fn no_hallway() -> Raise {
    Raise::new("registration-failure", "the robot is in no hallway that it knows; `registration` comes first")
}

fn pose_from(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let wrong =
        || Raise::type_error("`pose-from` takes a pose `(x y heading)`, metres ahead and to the left, and an angle");
    let numbers: Option<Vec<f64>> = call.list(0).map_err(|_| wrong())?.into_iter().map(Value::as_f64).collect();
    let Some(&[x_m, y_m, heading_rad]) = numbers.as_deref() else { return Err(wrong()) };
    let turn_rad = if call.arguments.len() > 3 { call.number(3)? } else { 0.0 };
    let pose = Pose::new(x_m, y_m, heading_rad).compose(Pose::new(call.number(1)?, call.number(2)?, turn_rad));
    Ok(Reply::Value(pose_data(call.machine, pose)))
}
