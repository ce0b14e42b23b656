//! Position tracking: it takes each percept into the belief, and tells where the robot is and whether
//! that is known.

use crate::geometry::{Pose, Velocity};
use crate::localization::{Estimate, ScanParameters};
use crate::navigation::NavigationInput;
use crate::office::functions::{act, board, look, model, pose_list};
use crate::office::model::OfficeModel;
use crate::office::module::{Module, ModuleSpec, Moment, Telling, continuous, fluent, fluent_number};
use crate::office::one_scan::{LOCATE, SET_POSITION, locate, set_position};
use crate::office::position::Position;
use crate::office::report::Report;
use crate::office::words::no_map;
use crate::sensors::RangeSensor;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{BehaviourSpec, FluentSpec};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::value::Value;
use rpl_runtime::step::native::{Call, Reply};
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The estimated x.
pub(in crate::office) const X: &str = "x*";

/// The estimated y.
pub(in crate::office) const Y: &str = "y*";

/// Whether the position is lost.
const LOST: &str = "position-lost*";

/// How much farther odometry errs than it should.
const SLIP: &str = "odometry-slip*";

/// Odometry that errs this many times as far as it should is reported ...
const REPORTED_SLIP: f64 = 3.0;

/// ... once, until it errs less than this.
const USUAL_SLIP: f64 = 1.5;

/// How much of what is seen is not in the map.
const MISFIT: &str = "map-misfit*";

/// A map that differs by this share is reported ...
const REPORTED_MISFIT: f64 = 0.1;

/// ... once, until it is less than this.
const USUAL_MISFIT: f64 = 0.05;

const FLUENTS: &[FluentSpec] = &[
    continuous(X, "Estimated x, in metres, map frame."),
    continuous(Y, "Estimated y, in metres, map frame."),
    continuous("o*", "Estimated heading, in radians counter-clockwise from the map's x axis."),
    continuous(
        "pos-certainty*",
        "Probability that the position is within 0.5 m and 15° of the estimate; calibrated, so that 0.8 is right four times in five.",
    ),
    fluent(
        LOST,
        "Whether something speaks against the estimate: where nothing is in reach of its sensors a robot gets uncertain, and is not lost.",
    ),
    continuous(
        SLIP,
        "How many times as far as the robot's description says its odometry errs, by what its sensors tell of the last ways; 1 if no farther.",
    ),
    continuous(
        MISFIT,
        "Share of what the sensors have seen of late, where the position was sure, that is not as in the map: things that are gone, moved or new.",
    ),
];

const POS_CERTAINTY: usize = fluent_number(FLUENTS, "pos-certainty*");
const POSITION_LOST: usize = fluent_number(FLUENTS, LOST);
const ODOMETRY_SLIP: usize = fluent_number(FLUENTS, SLIP);
const MAP_MISFIT: usize = fluent_number(FLUENTS, MISFIT);

/// The state of position tracking.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PositionTracking {
    /// Whether the position was lost in the last step.
    was_lost: bool,
    /// Whether it was reported that odometry errs farther than it should.
    is_slip_reported: bool,
    /// Whether it was reported that much is not as in the map.
    is_misfit_reported: bool,
}

impl Module for PositionTracking {
    type Settings = ();

    fn specs((): &()) -> Vec<ModuleSpec> {
        vec![ModuleSpec {
            name: "position-tracking".into(),
            behaviours: vec![BehaviourSpec {
                name: Cow::Borrowed("position-tracking"),
                doc: Cow::Borrowed(
                    "Keeps the belief about the position up to date; active from the start, needs no valve.",
                ),
                valve: None,
                parameters: Cow::Borrowed(""),
            }],
            fluents: FLUENTS.to_vec(),
            functions: vec![
                look(
                    "belief-maxima",
                    "&optional count",
                    "Local maxima of the belief: lists (x y heading mass), the heaviest first.",
                    belief_maxima,
                ),
                look(
                    "odometry-pose",
                    "",
                    "Where the robot is by its odometry: x, y in metres, heading in radians, from where it was switched on.",
                    odometry_pose,
                ),
                look(
                    "odometry-in-map",
                    "pose",
                    "Where a pose of the odometry lies in the map by what the robot believes now: x, y, heading.",
                    odometry_in_map,
                ),
                act(
                    "doubt-position",
                    "",
                    "Discards the whole belief about the position in the next step: for when the estimate leads to a contradiction.",
                    doubt_position,
                ),
                look("locate", "&optional count", LOCATE, locate),
                act("set-position", "pose", SET_POSITION, set_position),
            ],
            ..ModuleSpec::default()
        }]
    }

    fn new((): &(), model: &OfficeModel, _: u64) -> Self {
        let was_lost = !model.settings.start_known && model.map.is_some();
        Self { was_lost, is_slip_reported: false, is_misfit_reported: false }
    }

    /// A doubt comes after the percept, and so does a pose that a plan has set: otherwise one scan that fits could make the robot certain
    /// again before anybody has seen it uncertain.
    fn step(&mut self, now: &Moment<'_>, position: &mut Position, tell: &mut Telling<'_>) -> Option<Velocity> {
        let (Some(map), Some(localization)) = (&now.model.map, &mut position.localization) else { return None };
        let (input, sensors) = (now.input(), &map.localization.parameters.sensors);
        let scans_m: Vec<_> = sensors.iter().map(|sensor| scan_m(sensor, &input)).collect();
        let scans_m: Vec<_> = scans_m.iter().map(Option::as_deref).collect();
        localization.observe(&map.localization, now.percept.odometry_in_odom, &scans_m);
        if std::mem::take(&mut position.is_doubted) {
            localization.refute(&map.localization);
            tell.event(Report::PositionDoubted);
        }
        position.take_set(map);
        None
    }

    fn publish(&mut self, now: &Moment<'_>, position: &Position, tell: &mut Telling<'_>) {
        let Estimate { pose_in_map, certainty } = position.estimate(now.model.map.as_ref());
        let active = &now.model.settings.active;
        let tracking = position.tracking(now.model.map.as_ref());
        let is_lost = tracking <= if self.was_lost { active.found_certainty } else { active.certainty };
        if is_lost != self.was_lost {
            self.was_lost = is_lost;
            tell.event(if is_lost { Report::PositionLost { certainty } } else { Report::PositionFound { certainty } });
        }
        let values = [pose_in_map.x_m, pose_in_map.y_m, pose_in_map.heading_rad, certainty];
        values.into_iter().map(Reading::Float).enumerate().for_each(|(fluent, value)| tell.fluent(fluent, value));
        tell.fluent(POSITION_LOST, Reading::Truth(is_lost));
        let slip = position.slip();
        if slip >= REPORTED_SLIP && !self.is_slip_reported {
            tell.event(Report::OdometrySlips { times: slip });
        }
        self.is_slip_reported = slip >= if self.is_slip_reported { USUAL_SLIP } else { REPORTED_SLIP };
        tell.fluent(ODOMETRY_SLIP, Reading::Float(slip));
        let share = position.map_misfit();
        if share >= REPORTED_MISFIT && !self.is_misfit_reported {
            let room = position.room_of_misfit(&now.model.world).map(str::to_string);
            tell.event(Report::MapDoesNotFit { share, room });
        }
        self.is_misfit_reported = share >= if self.is_misfit_reported { USUAL_MISFIT } else { REPORTED_MISFIT };
        tell.fluent(MAP_MISFIT, Reading::Float(share));
    }

    fn publish_position(&mut self, model: &OfficeModel, position: &Position, tell: &mut Telling<'_>) {
        let map = model.map.as_ref();
        tell.fluent(POS_CERTAINTY, Reading::Float(position.estimate(map).certainty));
        tell.fluent(POSITION_LOST, Reading::Truth(position.tracking(map) <= model.settings.active.certainty));
        tell.fluent(ODOMETRY_SLIP, Reading::Float(position.slip()));
        tell.fluent(MAP_MISFIT, Reading::Float(position.map_misfit()));
    }
}

/// What a sensor of the filter has read, beam by beam; none if it is off.
fn scan_m<'p>(sensor: &ScanParameters, input: &NavigationInput<'p>) -> Option<Cow<'p, [f32]>> {
    match sensor.source {
        RangeSensor::Sonar => input.sonar.map(|scan| scan.ranges_from_middle_m()),
        RangeSensor::Laser => input.laser.map(|scan| scan.ranges_towards_m(&sensor.beams_deg)),
    }
}

fn belief_maxima(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let count = if call.arguments.is_empty() { 10 } else { call.integer(0)?.clamp(1, 100) as usize };
    let model = model(call)?;
    let position = &board(call)?.position;
    let maxima: Vec<(Pose, f64)> = match (&model.map, position.localization()) {
        (Some(map), Some(localization)) => {
            let maxima = localization.maxima(&map.localization, count, 0.001);
            maxima.iter().map(|maximum| (maximum.pose_in_map, maximum.mass)).collect()
        }
        _ => vec![(position.estimate(model.map.as_ref()).pose_in_map, 1.0)],
    };
    let lists: Vec<Value> = maxima
        .iter()
        .map(|(pose, mass)| call.machine.heap.list(&[pose.x_m, pose.y_m, pose.heading_rad, *mass].map(Value::Float)))
        .collect();
    Ok(Reply::Value(call.machine.heap.list(&lists)))
}

fn odometry_pose(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let odometry_in_odom = board(call)?.position.odometry_in_odom();
    Ok(pose_list(call, odometry_in_odom))
}

fn odometry_in_map(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    let expected =
        || Raise::type_error("`odometry-in-map` takes a pose `(x y heading)`, as `(odometry-pose)` gives it");
    let elements = call.machine.heap.elements(call.argument(0)).map_err(|_| expected())?;
    let numbers: Option<Vec<f64>> = elements.into_iter().map(Value::as_f64).collect();
    let Some(&[x_m, y_m, heading_rad]) = numbers.as_deref() else { return Err(expected()) };
    let model = model(call)?;
    let position = &board(call)?.position;
    let robot_in_map = position.estimate(model.map.as_ref()).pose_in_map;
    let odom_in_map = robot_in_map.compose(position.odometry_in_odom().inverse());
    Ok(pose_list(call, odom_in_map.compose(Pose::new(x_m, y_m, heading_rad))))
}

fn doubt_position(call: &mut Call<'_, '_>) -> Result<Reply, Raise> {
    if model(call)?.map.is_none() {
        return Err(no_map("there is no belief to give up"));
    }
    board(call)?.position.doubt();
    Ok(Reply::Value(Value::Nil))
}
