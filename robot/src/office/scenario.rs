//! Scenarios: the experimenter's plan, which alone sees the truth and can meddle with the world.

use super::functions::act;
use super::report::Report;
use crate::geometry::{Point, Pose};
use crate::simulator::{SimulatorModel, SimulatorState};
use crate::world::{Object, Rect, SeenBy, Shape, World};
use rpl_lang::symbol::Symbol;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{FluentSpec, ForeseenRobot, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::state::activation::Phases;
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::projected::Grain;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Native, Reply};
use std::any::{Any, TypeId};
use std::borrow::Cow;
use std::sync::{Arc, LazyLock};

/// The truth about the simulated world, and the hands that change it.
#[derive(Clone, Debug)]
pub struct Oracle {
    /// What does not change.
    pub model: Arc<SimulatorModel>,
    /// The world; swapped in while the scenario runs.
    pub state: SimulatorState,
    /// What the scenario has done since the last step.
    pub deeds: Vec<Report>,
}

impl Oracle {
    /// The oracle of a world.
    pub fn new(model: Arc<SimulatorModel>, seed: u64) -> Self {
        let state = model.start(seed);
        Self { model, state, deeds: Vec::new() }
    }
}

/// What a scenario sees of the world.
pub fn oracle_tables() -> &'static RobotTables {
    static TABLES: LazyLock<RobotTables> = LazyLock::new(new_oracle_tables);
    &TABLES
}

fn new_oracle_tables() -> RobotTables {
    let fluent =
        |name, doc| FluentSpec { name: Cow::Borrowed(name), doc: Cow::Borrowed(doc), continuous: true, first: None };
    let fluents = vec![
        fluent("true-x*", "The robot's true x, in metres."),
        fluent("true-y*", "The robot's true y, in metres."),
        fluent("true-o*", "The robot's true heading, in radians."),
        fluent("true-distance*", "Metres driven so far."),
    ];
    RobotTables { fluents, ..RobotTables::default() }
}

impl Outside for Oracle {
    fn tables(&self) -> &RobotTables {
        oracle_tables()
    }

    fn start(&mut self, _: &Machine, _: u16, _: &[(Symbol, Value)], _: &mut Outbox) -> Result<(), Raise> {
        Err(Raise::new("behaviour-failure", "a scenario has no behaviours"))
    }

    fn stop(&mut self, _: u16, _: StopReason, _: &mut Outbox) {}

    fn stream(&self) -> &'static str {
        "scenario"
    }

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        Some(stepped_us + self.model.robot().step_us)
    }

    fn step(&mut self, _: u64, _: Phases<'_>, outbox: &mut Outbox) {
        let pose = self.state.true_pose();
        let values = [pose.x_m, pose.y_m, pose.heading_rad, self.state.distance_driven_m()];
        outbox.fluents.extend(values.into_iter().map(Reading::Float).enumerate());
    }

    fn foresee(&self, _: u64, _: Phases<'_>, _: Grain) -> Result<ForeseenRobot, Raise> {
        Err(Raise::new("projection-failure", "a scenario cannot project; it is what the robot's plans cannot foresee"))
    }

    fn part(&mut self, of: TypeId) -> Option<&mut dyn Any> {
        (of == TypeId::of::<Self>()).then_some(self)
    }
}

fn oracle<'a>(call: &'a mut Call<'_, '_>) -> Result<&'a mut Oracle, Raise> {
    call.part().map_err(|_| Raise::new("error", "only a scenario can do this; run it with `--scenario`"))
}

/// Functions of scenarios.
pub fn oracle_natives() -> Vec<Native> {
    vec![
        act("true-pose", "", "The robot's true pose: x, y in metres, heading in radians.", true_pose),
        act("rotate-robot!", "angle", "Turns the robot by hand.", rotate),
        act("teleport-robot!", "x y heading", "Carries the robot to another pose.", teleport),
        act("open-door!", "room", "Opens the door of a room.", |call| door(call, true)),
        act("close-door!", "room", "Closes the door of a room.", |call| door(call, false)),
        act("add-object!", "name x0 y0 x1 y1", "Puts a box into the world that is in no map.", add_object),
        act("remove-object!", "name", "Takes an object out of the world.", remove_object),
        act(
            "gather-people!",
            "",
            "The people of the world gather about the robot, and walk along with it from now on.",
            gather_people,
        ),
        act("drop-sonars!", "seconds", "The sonars fail for a time.", drop_sonars),
        act(
            "hold-wheels!",
            "seconds",
            "The wheels do not turn for a time, as when the emergency stop is pressed.",
            hold_wheels,
        ),
        act("place-item!", "name x y", "Puts a thing that can be carried somewhere.", place_item),
        act("set-battery!", "charge", "Sets the charge of the battery, from 0 to 1.", set_battery),
        act("send-message!", "&rest words", "Sends the robot a message, a list of names.", send_message),
    ]
}

/// The number of an argument, which must be finite: nothing in the world is where no number tells.
fn finite(call: &Call<'_, '_>, at: usize) -> Result<f64, Raise> {
    let number = call.number(at)?;
    if number.is_finite() {
        return Ok(number);
    }
    let (what, found) = (call.which(at), call.machine.described(call.argument(at)));
    Err(Raise::new("arithmetic-error", format!("{what} must be finite, and it is {found}")))
}

fn done(oracle: &mut Oracle, deed: Report) -> Reply {
    oracle.deeds.push(deed);
    Reply::Value(Value::Nil)
}

fn refused(error: impl std::fmt::Display) -> Raise {
    Raise::new("plan-failure", error.to_string())
}

fn true_pose(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let pose = oracle(call)?.state.true_pose();
    let values = [pose.x_m, pose.y_m, pose.heading_rad].map(Value::Float);
    Ok(Reply::Value(call.machine.heap.list(&values)))
}

fn rotate(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let angle_rad = finite(call, 0)?;
    let oracle = oracle(call)?;
    oracle.state.rotate(angle_rad);
    Ok(done(oracle, Report::RotatedByHand { angle_rad }))
}

fn teleport(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let pose = Pose::new(finite(call, 0)?, finite(call, 1)?, finite(call, 2)?);
    let oracle = oracle(call)?;
    oracle.model.clone().teleport(&mut oracle.state, pose).map_err(refused)?;
    Ok(done(oracle, Report::CarriedByHand { point_in_map: pose.point() }))
}

/// A room's name as the world writes it, by which reports call it; an unknown name as it is.
fn own_name(world: &World, room: String) -> String {
    world.room(&room).map_or(room, |known| known.name.clone())
}

fn door(call: &mut Call<'_, '_>, open: bool) -> Result<Reply, Raise> {
    let room = call.name(0)?;
    let oracle = oracle(call)?;
    let model = oracle.model.clone();
    let room = own_name(&model.world, room);
    let deed = if open {
        model.open_door(&mut oracle.state, &room).map_err(refused)?;
        Report::DoorOpened { room }
    } else {
        model.close_door(&mut oracle.state, &room).map_err(refused)?;
        Report::DoorClosed { room }
    };
    Ok(done(oracle, deed))
}

fn add_object(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let name = call.name(0)?;
    let rect = Rect {
        min: Point::new(finite(call, 1)?, finite(call, 2)?),
        max: Point::new(finite(call, 3)?, finite(call, 4)?),
    };
    if !(rect.min.x < rect.max.x && rect.min.y < rect.max.y) {
        return Err(refused("the corners of an object are written `X0 Y0 X1 Y1`, with X0 < X1 and Y0 < Y1"));
    }
    let seen_by = SeenBy { sonar: true, laser: true };
    let object = Object { name: name.clone(), shape: Shape::Rect(rect), mapped: false, seen_by };
    let oracle = oracle(call)?;
    oracle.model.clone().add_object(&mut oracle.state, object).map_err(refused)?;
    Ok(done(oracle, Report::ObjectAdded { object: name }))
}

fn remove_object(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let name = call.name(0)?;
    let oracle = oracle(call)?;
    oracle.model.clone().remove_object(&mut oracle.state, &name).map_err(refused)?;
    Ok(done(oracle, Report::ObjectRemoved { object: name }))
}

fn gather_people(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let oracle = oracle(call)?;
    let people = oracle.model.clone().gather(&mut oracle.state);
    Ok(done(oracle, Report::PeopleGathered { people }))
}

fn drop_sonars(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    call.machine.instant_after(call.argument(0), || call.which(0))?;
    let seconds = call.number(0)?;
    let oracle = oracle(call)?;
    oracle.state.drop_sonars(seconds);
    Ok(done(oracle, Report::SonarsFailed { seconds }))
}

fn hold_wheels(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    call.machine.instant_after(call.argument(0), || call.which(0))?;
    let seconds = call.number(0)?;
    let oracle = oracle(call)?;
    oracle.state.hold_wheels(seconds);
    Ok(done(oracle, Report::WheelsHeld { seconds }))
}

fn place_item(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let name = call.name(0)?;
    let point = Point::new(finite(call, 1)?, finite(call, 2)?);
    let oracle = oracle(call)?;
    let bounds = oracle.model.world.bounds();
    if !bounds.contains(point) {
        let (min, max) = (bounds.min, bounds.max);
        return Err(refused(format!(
            "({}, {}) lies outside the world, which goes from ({}, {}) to ({}, {})",
            point.x, point.y, min.x, min.y, max.x, max.y
        )));
    }
    oracle.state.place_item(&name, point);
    Ok(done(oracle, Report::ItemPlaced { item: name }))
}

fn set_battery(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let charge = finite(call, 0)?;
    if !(0.0..=1.0).contains(&charge) {
        return Err(refused(format!(
            "the charge of a battery is from 0 to 1, and it is {charge}; write half of it as `50%`"
        )));
    }
    let oracle = oracle(call)?;
    oracle.state.set_battery(charge);
    Ok(done(oracle, Report::BatterySet { charge }))
}

fn send_message(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let words = (0..call.arguments.len()).map(|index| call.name(index)).collect::<Result<Vec<_>, _>>()?;
    let oracle = oracle(call)?;
    let text = words.join(" ");
    oracle.state.send_message(words);
    Ok(done(oracle, Report::MessageSent { text }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_room_is_called_what_the_world_calls_it_however_it_is_written() {
        let text = "name = \"small\"\nsize = [4.0, 3.0]\nstart = [2.0, 1.5, 0.0]\n\
                    [[room]]\nname = \"Küche\"\nrect = [0, 2, 4, 3]\n";
        let world = World::parse(text, "w.toml").unwrap_or_else(|error| panic!("{error}"));
        for name in ["Küche", "küche", "KÜCHE"] {
            assert_eq!(own_name(&world, name.to_string()), "Küche");
        }
        assert_eq!(own_name(&world, "Bad".to_string()), "Bad");
    }
}
