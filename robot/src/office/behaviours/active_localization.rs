//! Active localization: it drives to where the robot learns most about its position.

use super::body::WHEELS;
use super::module::{Module, ModuleSpec, Moment, Start, Work};
use super::position::Position;
use super::position_tracking::POS_CERTAINTY;
use crate::active::{ActiveLocalization, Exploration, Intent};
use crate::navigation::{DriveStatus, DriveTask, LocalDrive};
use crate::office::model::OfficeModel;
use crate::office::report::Report;
use crate::office::words::no_map;
use crate::simulator::Commands;
use crate::world::TravelMode;
use rpl_random::Stream;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::robot::{BehaviourSpec, Ending, Outbox, RobotEvent, StopReason};
use rpl_runtime::state::activation::Phase;
use rpl_runtime::state::failure::Raise;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Its name.
pub const NAME: &str = "active-localization";

/// Speed limit while the robot does not know where it is: its sonars see everything it can hit.
const LOST_SPEED_MPS: f64 = 0.45;

/// The state of active localization, and of the driving it does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Localizing {
    /// The search, while it is activated.
    search: Option<ActiveLocalization>,
    drive: LocalDrive,
    drive_status: DriveStatus,
    /// Where it wanders to, carried on from one search to the next.
    wander: Stream,
}

impl Localizing {
    pub(super) const SPEC: ModuleSpec = ModuleSpec {
        behaviour: Some(BehaviourSpec {
            name: Cow::Borrowed(NAME),
            doc: Cow::Borrowed(
                "Drives to where the robot learns most about its position; gives up the belief first if the certainty is at or below 0.8. Succeeds when the position is known, fails with localization-failure after ten minutes.",
            ),
            valve: Some(WHEELS),
            parameters: Cow::Borrowed(""),
        }),
        fluents: &[],
        valves: &[],
    };

    pub(super) fn new(_: &OfficeModel, seed: u64) -> Self {
        let wander = Stream::new(seed, "wander");
        Self { search: None, drive: LocalDrive::wander(wander.clone()), drive_status: DriveStatus::Driving, wander }
    }

    /// Goes on moving about, or begins to.
    fn explore(&mut self, how: Exploration) {
        let begun = match (how, &self.drive.task) {
            (Exploration::Active | Exploration::Wander, DriveTask::Wander { .. })
            | (Exploration::WallFollow, DriveTask::WallFollow)
            | (Exploration::SpinAndBackUp, DriveTask::SpinAndBackUp { .. }) => return,
            (Exploration::Active | Exploration::Wander, _) => {
                DriveTask::Wander { stream: self.wander.clone(), heading_in_odom_rad: None, left_s: 0.0 }
            }
            (Exploration::WallFollow, _) => DriveTask::WallFollow,
            (Exploration::SpinAndBackUp, _) => DriveTask::SpinAndBackUp { elapsed_s: 0.0 },
        };
        self.drive.task = begun;
    }
}

impl Module for Localizing {
    fn start(&mut self, start: &Start<'_>, position: &mut Position, outbox: &mut Outbox) -> Result<(), Raise> {
        let odometry_in_odom = position.odometry_in_odom();
        let (Some(map), Some(localization)) = (&start.model.map, position.begin_search()) else {
            return Err(no_map("there is nothing to localize in"));
        };
        let parameters = start.model.settings.active.clone();
        let search =
            ActiveLocalization::start(&map.localization, localization, odometry_in_odom, start.time_us, parameters);
        self.search = Some(search);
        self.drive_status = DriveStatus::Driving;
        self.drive = LocalDrive::wander(self.wander.clone());
        outbox.fluents.push((POS_CERTAINTY, Reading::Float(position.estimate(Some(map)).certainty)));
        Ok(())
    }

    fn stop(&mut self, how: StopReason, _: &mut Outbox) {
        match how {
            StopReason::Deactivated => self.search = None,
            StopReason::Interrupted => {}
        }
    }

    /// Who does not know where the robot is needs to see.
    fn command(&mut self, _: TravelMode, phase: Phase, commands: &mut Commands) {
        commands.sonars_on |= phase == Phase::Active;
    }

    fn step(&mut self, now: &Moment<'_>, position: &mut Position, events: &mut Vec<RobotEvent>) -> Work {
        let (Phase::Active, Some(search)) = (now.phase, &mut self.search) else { return Work::default() };
        let (Some(map), Some(localization)) = (&now.model.map, position.localization()) else {
            return Work::default();
        };
        let blocked = self.drive_status == DriveStatus::Stuck;
        let chosen_before = search.last_choice().map(|choice| choice.target_in_base);
        let (odometry_in_odom, time_us) = (now.percept.odometry_in_odom, now.percept.time_us);
        let intent = search.step(&map.localization, localization, odometry_in_odom, blocked, time_us);
        if let Some(choice) = search.last_choice()
            && Some(choice.target_in_base) != chosen_before
        {
            self.drive.forget_being_held_up();
            events.push(Report::LocalizationAction { target_in_base: choice.target_in_base }.into());
        }
        match intent {
            Intent::Explore(how) => self.explore(how),
            Intent::FollowPath { path_in_odom } => {
                if let DriveTask::Wander { stream, .. } = &self.drive.task {
                    self.wander = stream.clone();
                }
                self.drive.task = DriveTask::Follow { path_in_odom };
            }
            Intent::Done => return Work { velocity: None, ending: Some(Ending::Success) },
            Intent::Failed => {
                let ending = Ending::failure("localization-failure", "the position is still not known");
                return Work { velocity: None, ending: Some(ending) };
            }
        }
        let output = self.drive.step(&now.model.limits, &now.input(), LOST_SPEED_MPS);
        self.drive_status = output.status;
        Work { velocity: Some(output.velocity), ending: None }
    }
}
