//! Active localization: it drives to where the robot learns most about its position.

use super::body::WHEELS;
use crate::active::{ActiveLocalization, Exploration, Intent};
use crate::geometry::Velocity;
use crate::navigation::{DriveStatus, DriveTask, LocalDrive};
use crate::office::model::OfficeModel;
use crate::office::module::{Module, ModuleSpec, Moment, Start, Telling};
use crate::office::position::Position;
use crate::office::report::Report;
use crate::office::words::no_belief;
use crate::simulator::Commands;
use crate::world::TravelMode;
use rpl_random::Stream;
use rpl_runtime::robot::{BehaviourSpec, Ending, StopReason};
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
    /// The search, while it is activated.
    pub fn search(&self) -> Option<&ActiveLocalization> {
        self.search.as_ref()
    }

    /// Goes on moving about, or begins to.
    fn explore(&mut self, how: Exploration) {
        let begun = match (how, &self.drive.task) {
            (Exploration::Active | Exploration::Wander, DriveTask::Wander { .. })
            | (Exploration::WallFollow, DriveTask::WallFollow { .. })
            | (Exploration::SpinAndBackUp, DriveTask::SpinAndBackUp { .. }) => return,
            (Exploration::Active | Exploration::Wander, _) => {
                DriveTask::Wander { stream: self.wander.clone(), heading_in_odom_rad: None, left_s: 0.0 }
            }
            (Exploration::WallFollow, _) => DriveTask::WallFollow { side: -1 },
            (Exploration::SpinAndBackUp, _) => DriveTask::SpinAndBackUp { elapsed_s: 0.0 },
        };
        self.drive.task = begun;
    }
}

impl Module for Localizing {
    type Settings = ();

    fn specs((): &()) -> Vec<ModuleSpec> {
        vec![ModuleSpec {
            name: NAME.into(),
            behaviours: vec![BehaviourSpec {
                name: Cow::Borrowed(NAME),
                doc: Cow::Borrowed(
                    "Drives to where the robot learns most about its position; gives up most of the belief where the position is lost. Succeeds when the position is known, fails with localization-failure after ten minutes.",
                ),
                valve: Some(WHEELS),
                parameters: Cow::Borrowed(""),
            }],
            ..ModuleSpec::default()
        }]
    }

    fn new((): &(), _: &OfficeModel, seed: u64) -> Self {
        let wander = Stream::new(seed, "wander");
        Self { search: None, drive: LocalDrive::wander(wander.clone()), drive_status: DriveStatus::Driving, wander }
    }

    fn start(
        &mut self,
        _: usize,
        start: &Start<'_>,
        position: &mut Position,
        _: &mut Telling<'_>,
    ) -> Result<(), Raise> {
        let odometry_in_odom = position.odometry_in_odom();
        let (Some(map), Some(localization)) = (&start.model.map, position.begin_search()) else {
            return Err(no_belief(start.model, "there is nothing to localize in"));
        };
        let parameters = start.model.settings.active.clone();
        let search =
            ActiveLocalization::start(&map.localization, localization, odometry_in_odom, start.time_us, parameters);
        self.search = Some(search);
        self.drive_status = DriveStatus::Driving;
        self.drive = LocalDrive::wander(self.wander.clone());
        Ok(())
    }

    fn stop(&mut self, _: usize, why: StopReason, _: &mut Telling<'_>) {
        match why {
            StopReason::Deactivated => self.search = None,
            StopReason::Interrupted => {}
        }
    }

    /// Who does not know where the robot is needs to see.
    fn command(&mut self, _: TravelMode, phases: &[Phase], commands: &mut Commands) {
        commands.sonars_on |= phases == [Phase::Active];
    }

    fn step(&mut self, now: &Moment<'_>, position: &mut Position, tell: &mut Telling<'_>) -> Option<Velocity> {
        let ([Phase::Active], Some(search)) = (now.phases, &mut self.search) else { return None };
        let (Some(map), Some(localization)) = (&now.model.map, position.searched()) else { return None };
        let blocked = self.drive_status == DriveStatus::Stuck;
        let chosen_before = search.last_choice().map(|choice| choice.target_in_base);
        let (odometry_in_odom, time_us) = (now.percept.odometry_in_odom, now.percept.time_us);
        let intent = search.step(&map.localization, localization, odometry_in_odom, blocked, time_us);
        if let Some(choice) = search.last_choice()
            && Some(choice.target_in_base) != chosen_before
        {
            self.drive.forget_being_held_up();
            tell.event(Report::LocalizationAction { target_in_base: choice.target_in_base });
        }
        match intent {
            Intent::Explore(how) => self.explore(how),
            Intent::FollowPath { path_in_odom } => {
                if let DriveTask::Wander { stream, .. } = &self.drive.task {
                    self.wander = stream.clone();
                }
                self.drive.task = DriveTask::Follow { path_in_odom };
            }
            Intent::Done => {
                tell.end(0, Ending::DONE);
                return None;
            }
            Intent::Failed => {
                tell.end(0, Ending::failure("localization-failure", "the position is still not known"));
                return None;
            }
        }
        let output = self.drive.step(&now.model.limits, &now.input(), LOST_SPEED_MPS);
        self.drive_status = output.status;
        Some(output.velocity)
    }
}
