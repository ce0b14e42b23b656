//! A step of whatever has the wheels, and how it ends.

use super::behaviour_places::{
    DIRECTION_FOLLOW, FEATURE_DETECTION, GOAL_SEEK, MARKER_DETECTION, REGISTRATION, WALL_FOLLOW,
};
use super::drive::Drive;
use super::hallway_drive::{DriveEnd, Perceiving};
use super::seeing::Seeing;
use super::state::Lola;
use rpl_robot::navigation::{DriveStatus, LocalDrive, NavigationEvent};
use rpl_robot::office::{Moment, Phase, Telling, TravelMode, Velocity};
use rpl_runtime::robot::Ending;

/// The longest time for which a wall that is followed holds the robot up.
const WALL_PATIENCE_S: f64 = 20.0;

impl Lola {
    /// One step of whatever has the wheels.
    pub(super) fn drive_on(&mut self, now: &Moment<'_>, tell: &mut Telling<'_>) -> Option<Velocity> {
        let is_active = |behaviour: usize| now.phases[behaviour] == Phase::Active;
        let driving = [DIRECTION_FOLLOW, WALL_FOLLOW, GOAL_SEEK, REGISTRATION].into_iter().find(|&one| is_active(one));
        let behaviour = driving?;
        let (velocity, ending) = match &mut self.drive {
            Drive::Idle => return None,
            Drive::Hallway(drive) => {
                let hallway = self.hallway.as_mut()?;
                let seen = self.markers.as_ref().filter(|_| is_active(MARKER_DETECTION)).map(Seeing::markers_in_odom);
                // Where there are no markers at all, none beside a door says nothing.
                let markers = seen.as_deref().filter(|markers| !markers.is_empty());
                let perceiving = Perceiving {
                    registers: self.settings.registers,
                    detects: is_active(FEATURE_DETECTION),
                    markers_in_odom: markers,
                };
                let was_known = hallway.axis().is_some();
                let (velocity, end) = drive.step(hallway, now, perceiving);
                if was_known && hallway.axis().is_none() {
                    self.markers.iter_mut().for_each(Seeing::forget_places);
                }
                (velocity, end.map(DriveEnd::ending))
            }
            Drive::Wall { drive, stuck_s } => follow_wall(drive, stuck_s, now),
            Drive::Goal { navigation, doorways } => {
                let limits = &now.model.limits;
                // In a room it drives as among furniture, and hears the posts of the door for longer.
                let mode = if doorways.is_some() { TravelMode::Office } else { now.mode };
                let output = navigation.step(limits, &now.input(), limits.speed_limit_mps(mode));
                let sonar = now.input().sonar;
                let through = doorways
                    .as_mut()
                    .zip(sonar)
                    .and_then(|(doorways, scan)| doorways.take_in(now.percept.odometry_in_odom, scan));
                self.doorway = through.or(self.doorway);
                let ending = match through {
                    Some(_) => Some(Ending::DONE),
                    None => sought(output.event, doorways.is_some()),
                };
                (output.velocity, ending)
            }
        };
        let Some(ending) = ending else { return Some(velocity) };
        self.drive = Drive::Idle;
        self.has_news = true;
        tell.end(behaviour, ending);
        Some(Velocity::default())
    }
}

fn follow_wall(drive: &mut LocalDrive, stuck_s: &mut f64, now: &Moment<'_>) -> (Velocity, Option<Ending>) {
    let limits = &now.model.limits;
    let output = drive.step(limits, &now.input(), limits.speed_limit_mps(now.mode));
    *stuck_s = if output.status == DriveStatus::Stuck { *stuck_s + limits.step_s } else { 0.0 };
    let is_blocked = *stuck_s > WALL_PATIENCE_S;
    (output.velocity, is_blocked.then(|| Ending::failure("blocked", "the robot does not get on along the wall")))
}

fn sought(event: Option<NavigationEvent>, through_door: bool) -> Option<Ending> {
    match event? {
        NavigationEvent::Arrived if through_door => {
            Some(Ending::failure("unreachable", "the robot came far without coming through a door"))
        }
        NavigationEvent::Arrived => Some(Ending::DONE),
        NavigationEvent::Unreachable => {
            Some(Ending::failure("unreachable", "what has been seen leaves no way to the goal"))
        }
        NavigationEvent::Blocked => Some(Ending::failure("blocked", "the way to the goal stays blocked")),
        NavigationEvent::TargetReached => None,
    }
}
