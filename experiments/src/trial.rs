//! One run of an experiment: driven to its end, and measured.

use super::day::{AT_PLACE_M, Day};
use super::quantity::Quantity;
use super::samples::{ErrorTrack, Sample};
use anyhow::{Context, Result};
use rpl_drive::observed::{Incident, RunEnd};
use rpl_drive::run_driver::{Pace, drive};
use rpl_drive::run_record::Records;
use rpl_drive::show::failure_report::Reporter;
use rpl_lang::code::Program;
use rpl_lang::symbol::Symbol;
use rpl_mission::modules::SiteRobot;
use rpl_mission::robot::Robot;
use rpl_mission::sight::Sight;
use rpl_robot::geometry::{Point, Pose, distance_m, wrap_angle_rad};
use rpl_robot::office::ReportKind;
use rpl_robot::simulator::ItemPlace;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use rpl_shell::terminal::console::Console;
use serde::{Deserialize, Serialize};

/// How near to the goal the robot must really be.
pub const AT_GOAL_M: f64 = 0.5;

/// An estimate further off than this is wrong.
pub const WRONG_ESTIMATE_M: f64 = 1.0;

/// What the certainty is about: the estimate is within this distance of the truth ...
const RIGHT_M: f64 = 0.5;

/// ... and within this angle.
const RIGHT_RAD: f64 = 15.0 / 180.0 * std::f64::consts::PI;

/// A disturbance must be noticed within this way.
const NOTICED_WITHIN_M: f64 = 2.0;

/// One run of an experiment.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MissionTrial {
    /// Its seed.
    pub seed: u64,
    /// What went wrong, if anything: the plan failed, ended at the wrong place, or did less than its
    /// day asked for.
    pub fault: Option<String>,
    /// Why the run counts for nothing: its scenario failed, so that it was not what it was to be.
    pub unmeasured: Option<String>,
    /// What the plan returned, as it could be read again, if it succeeded.
    pub value: Option<String>,
    /// What was measured, if there was anything to measure in this run: the same quantities in every run, and behind
    /// them those that the plan measures itself.
    pub measures: Vec<(Quantity, Option<f64>)>,
    /// How far the estimate was off.
    pub error: ErrorTrack,
    /// The estimate and the truth, ten times a second, in experiments that look at each moment.
    pub samples: Vec<Sample>,
}

impl MissionTrial {
    /// Whether the plan succeeded, at the right place, in a run that counts.
    pub fn succeeded(&self) -> bool {
        self.fault.is_none() && self.is_measured()
    }

    /// Whether the run counts.
    pub fn is_measured(&self) -> bool {
        self.unmeasured.is_none()
    }

    /// Whether it succeeded, and why not, as two comma-separated values.
    pub fn outcome(&self) -> String {
        let unmeasured = self.unmeasured.as_ref().map(|why| format!("not measured: {why}"));
        let fault = self.fault.clone().or(unmeasured).unwrap_or_default().replace('"', "'");
        let succeeded = if self.is_measured() { self.succeeded().to_string() } else { String::new() };
        format!("{succeeded},\"{fault}\"")
    }

    /// What was measured of a quantity, if anything.
    pub fn measure(&self, quantity: &Quantity) -> Option<f64> {
        self.measures.iter().find(|(known, _)| known == quantity).and_then(|&(_, value)| value)
    }

    /// The same without the single moments.
    pub fn without_samples(self) -> Self {
        Self { samples: Vec::new(), ..self }
    }
}

/// Where the robot really is: the robots of experiments are simulated here.
fn truth_of(sight: &Sight) -> Pose {
    match sight.robot_in_map {
        Some(robot_in_map) => robot_in_map,
        None => unreachable!("an experiment has no host in another process"),
    }
}

/// How far the estimate is off.
pub fn off_m(sight: &Sight) -> f64 {
    sight.estimate_in_map.distance_m(truth_of(sight))
}

/// Whether the estimate is right.
pub fn is_right(sight: &Sight) -> bool {
    off_m(sight) <= RIGHT_M && off_rad(sight) <= RIGHT_RAD
}

/// Angle between the estimated and the true heading, at least 0.
fn off_rad(sight: &Sight) -> f64 {
    wrap_angle_rad(sight.estimate_in_map.heading_rad - truth_of(sight).heading_rad).abs()
}

/// Where a run is to end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Where the robot must really be ...
    pub pose_in_map: Pose,
    /// ... and this thing really lie, if anything.
    pub item: Option<&'static str>,
}

/// How far from a point a thing really lies; none if it lies nowhere.
fn item_off_m(robot: &SiteRobot, name: &str, point: Point) -> Option<f64> {
    let item = robot.host.state.gripper.items.iter().find(|item| item.name == name)?;
    match item.at {
        ItemPlace::Point(at) => Some(distance_m(at, point)),
        ItemPlace::Held => None,
    }
}

/// Drives a run to its end and measures it.
///
/// # Errors
/// The run cannot be driven.
pub fn one_trial(mut system: System<Robot>, seed: u64, until_us: u64, goal: Option<Goal>) -> Result<MissionTrial> {
    let mut records = Records::default();
    let mut silent = Console::silent();
    let pace = Pace { until_us: Some(until_us), ..Pace::default() };
    let ending = drive(&mut system, pace, &mut silent, &mut records).context("a run could not be driven")?;
    let observed = records.observed;
    let mut fault = fault_of(&system, ending);
    let mut measures: Vec<(Quantity, Option<f64>)> = vec![(Quantity::Time, Some(system.machine.now_s()))];
    if let (Some(account), Some(sight)) = (system.outside.account(), system.outside.sight()) {
        measures.push((Quantity::Distance, Some(account.distance_m)));
        measures.push((Quantity::ContactsCaused, account.contacts.map(f64::from)));
        measures.push((Quantity::MeanSpeed, Some(account.distance_m / system.machine.now_s().max(1e-9))));
        measures.push((Quantity::Relocalizations, Some(observed.relocalizations as f64)));
        let offs_m = || observed.track.iter().map(off_m);
        let mean = |sum: f64| (!observed.track.is_empty()).then(|| sum / observed.track.len() as f64);
        measures.push((Quantity::EstimateOff, mean(offs_m().sum::<f64>())));
        let astray = offs_m().filter(|off_m| *off_m > WRONG_ESTIMATE_M).count() as f64;
        measures.push((Quantity::Astray, mean(100.0 * astray)));
        measures.extend(disturbance(&observed.incidents, &observed.track, account.distance_m));
        if let Robot::Office(robot) = &system.outside
            && let Some(day) = Day::of(robot, &observed.logs)
        {
            fault = fault.or_else(|| day.fault());
            if account.contacts > Some(0) {
                fault.get_or_insert_with(|| "contact".to_string());
            }
            measures.extend(day.measures());
        }
        if let Some(Goal { pose_in_map, item }) = goal {
            let off_m = truth_of(&sight).distance_m(pose_in_map);
            if off_m > AT_GOAL_M {
                fault.get_or_insert_with(|| "wrong place".to_string());
            }
            measures.push((Quantity::OffTheGoal, Some(off_m)));
            if let (Some(item), Robot::Office(robot)) = (item, &system.outside) {
                let item_m = item_off_m(robot, item, pose_in_map.point());
                if item_m.is_none_or(|item_m| item_m > AT_PLACE_M) {
                    fault.get_or_insert_with(|| format!("not delivered: {item}"));
                }
                measures.push((Quantity::ThingOff, item_m));
            }
        }
    }
    if let Some((scenario, failure)) = system.outside.failed_scenario() {
        let unmeasured = Some(described(&scenario.machine, &scenario.program, failure));
        let measures = measures.into_iter().map(|(quantity, _)| (quantity, None)).collect();
        let (error, samples) = (ErrorTrack::default(), Vec::new());
        return Ok(MissionTrial { seed, fault: None, unmeasured, value: None, measures, error, samples });
    }
    let sample = |sight: &Sight| Sample {
        certainty: sight.certainty,
        off_m: off_m(sight) as f32,
        off_rad: off_rad(sight) as f32,
        is_right: is_right(sight),
    };
    let samples: Vec<Sample> = observed.track.iter().map(sample).collect();
    let machine = &system.machine;
    measures.extend(machine.measures.iter().map(|(name, number)| (own(machine, name), Some(number))));
    let value = match ending {
        RunEnd::Outcome(Outcome::Succeeded(value)) => Some(machine.write(&system.program, value)),
        _ => None,
    };
    Ok(MissionTrial { seed, fault, unmeasured: None, value, measures, error: ErrorTrack::of(&samples), samples })
}

fn own(machine: &Machine, name: Symbol) -> Quantity {
    Quantity::Own(machine.symbols.name(name).to_string())
}

/// Why a plan did not succeed, the class of the failure first.
fn fault_of(system: &System<Robot>, ending: RunEnd) -> Option<String> {
    match ending {
        RunEnd::Outcome(Outcome::Succeeded(_)) => None,
        RunEnd::Outcome(Outcome::Failed(failure)) => Some(described(&system.machine, &system.program, failure)),
        RunEnd::Outcome(Outcome::Evaporated) => Some("ended itself".to_string()),
        RunEnd::TimeUp => Some("time is up".to_string()),
        RunEnd::Interrupted | RunEnd::GivenUp => Some("interrupted by hand".to_string()),
    }
}

/// A failure, its class first.
pub fn described(machine: &Machine, program: &Program, failure: Value) -> String {
    match (Reporter { machine, program, colour: false }).record(failure) {
        Some(record) => format!("{}: {}", record.class, record.message),
        None => "plan-failure".to_string(),
    }
}

/// The way driven from a deed until the estimate was right again, if ever; the deed itself may
/// have been a jump.
fn righted_m(track: &[Sight]) -> Option<f64> {
    let righted = track.iter().position(is_right)?;
    let steps = track[..=righted].windows(2).map(|pair| truth_of(&pair[0]).distance_m(truth_of(&pair[1])));
    Some(steps.sum())
}

/// How far the robot drove from the scenario's deed until it noticed: it counted itself as lost,
/// or its estimate was right again. How often
/// it then believed to have found its position where it was not, and how often it thought itself
/// lost without reason.
fn disturbance(incidents: &[Incident], track: &[Sight], driven_m: f64) -> [(Quantity, Option<f64>); 4] {
    let deed = incidents.iter().position(|incident| incident.what.is_by_hand());
    let (before, after) = incidents.split_at(deed.unwrap_or(incidents.len()));
    let lost = |incident: &&Incident| incident.what == ReportKind::PositionLost;
    let noticed = after.iter().find(lost);
    let deed_m = deed.map(|deed| incidents[deed].distance_m);
    let lost_m = deed_m.zip(noticed).map(|(deed_m, noticed)| noticed.distance_m - deed_m);
    // One look later the deed is seen in the track.
    let seen = deed.and_then(|deed| track.get(incidents[deed].track_length + 1..));
    let noticed_m = match (lost_m, seen.and_then(righted_m)) {
        (Some(lost_m), Some(righted_m)) => Some(lost_m.min(righted_m)),
        (lost_m, righted_m) => lost_m.or(righted_m),
    };
    let within = match (deed_m, noticed_m) {
        (None, _) => None,
        (Some(_), Some(way_m)) => Some(way_m <= NOTICED_WITHIN_M),
        // A run that ends so soon had no way to notice.
        (Some(deed_m), None) => (driven_m - deed_m > NOTICED_WITHIN_M).then_some(false),
    };
    let is_wrong =
        |incident: &&Incident| incident.what == ReportKind::PositionFound && off_m(&incident.sight) > WRONG_ESTIMATE_M;
    let wrong = deed.map(|_| after.iter().filter(is_wrong).count() as f64);
    let alarms = before.iter().filter(lost).filter(|incident| off_m(&incident.sight) <= WRONG_ESTIMATE_M);
    [
        (Quantity::NoticedAfter, noticed_m),
        (Quantity::NoticedWithin2M, within.map(f64::from)),
        (Quantity::WrongRecoveries, wrong),
        (Quantity::FalseAlarms, Some(alarms.count() as f64)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_mission::site::{Setup, Site};
    use rpl_robot::description::RobotDescription;
    use rpl_shell::files::world_files;

    #[test]
    fn a_thing_is_as_far_off_as_it_lies_and_not_as_far_as_the_robot() {
        let world = world_files::for_all_seeds("test-room", &RobotDescription::papers()).expect("built in");
        let site = Site::new(Setup { world: Some(world), ..Setup::default() }).expect("a site");
        let Robot::Office(robot) = site.robot(1) else { panic!("a world has a robot") };
        let off_m = item_off_m(&robot, "cup", Point::new(3.0, 4.1)).expect("it lies on the table");
        assert!((off_m - 0.55).abs() < 1e-9, "{off_m}");
        assert_eq!(item_off_m(&robot, "saucer", Point::new(3.0, 4.1)), None);
    }
}
