//! Drives along single hallways: what the robot perceived, and where that really was.

use super::setting::Ground;
use crate::failed_runs::FailedRun;
use crate::trial::described;
use anyhow::{Result, bail};
use rpl_lola::Hallway as KnownHallway;
use rpl_lola::arena::{ArenaSettings, SingleHallway};
use rpl_lola::feature::{Feature, HiddenWall, Percept, Side};
use rpl_lola::features::score::{BEHIND_M, Confusion, TrueFeature};
use rpl_mission::modules::SiteRobot;
use rpl_mission::robot::Robot;
use rpl_mission::run::{Reached, run_to};
use rpl_robot::geometry::wrap_angle_rad;
use rpl_runtime::run::system::Outcome;
use std::ops::ControlFlow;

/// To the hallway's end, perceiving what is beside it.
const PLAN: &str = "(with-valve wheels (run-behaviour registration)) (go-hallway-end)";

/// Way between two looks at the axis.
const BETWEEN_LOOKS_M: f64 = 0.25;

/// A robot that is so far behind where it was has begun with another hallway: it backs up less.
const BEGUN_ANEW_M: f64 = 3.0;

/// A drive along a hallway. Along it is metres from where the detection was started, by the truth.
#[derive(Clone, Debug, PartialEq)]
pub struct Course {
    /// Its seed.
    pub seed: u64,
    /// What was perceived, with `from` and `to` where they really were when the robot was there.
    pub percepts: Vec<Percept>,
    /// Where something stood before the walls, in the same way.
    pub hidden: Vec<HiddenWall>,
    /// What really is on both sides, in order.
    pub truth: Vec<TrueFeature>,
    /// The way driven.
    pub driven_m: f64,
    /// How far the axis was off, at equal distances along the way; nothing before it was registered.
    pub axis_off_deg: Vec<f64>,
    /// What the sonars told of the sides.
    pub contour: Vec<ContourSample>,
    /// Contacts the robot caused.
    pub contacts: u32,
    /// Why it did not get to the end, if it did not.
    pub fault: Option<String>,
}

/// A point of the contour line: along the hallway, and to the left of its middle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContourSample {
    /// Where the robot was.
    pub along_m: f64,
    /// On which side.
    pub side: Side,
    /// How far from the middle of the hallway it heard something; infinite if it heard nothing.
    pub aside_m: f64,
}

/// What is written down on the way.
#[derive(Default)]
struct Log {
    /// What the robot takes for its way along, and what it is.
    along: Vec<(f64, f64)>,
    axis_off_deg: Vec<f64>,
    contour: Vec<ContourSample>,
    percepts: Vec<Percept>,
    hidden: Vec<HiddenWall>,
}

/// Drives along the hallway of a seed.
///
/// # Errors
/// The robot cannot be simulated there.
pub fn drive(ground: &Ground, arena: &ArenaSettings, seed: u64, until_us: u64) -> Result<Course> {
    let hallway = SingleHallway::draw(seed, arena);
    let middle_m = (hallway.hallway.across_mm.0 + hallway.hallway.across_mm.1) as f64 / 2000.0;
    let (site, loaded) = ground.site(hallway.world, PLAN)?;
    let mut system = site.start(loaded, seed);
    let mut log = Log::default();
    let mut lost = None;
    let reached = run_to(&mut system, until_us, |system| {
        if let Robot::Office(robot) = &system.outside {
            lost = log.look(robot, middle_m);
        }
        if lost.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let Robot::Office(robot) = &system.outside else { bail!("a world has a robot") };
    let fault = match reached {
        Reached::End(Outcome::Succeeded(_)) => None,
        Reached::End(Outcome::Failed(failure)) => Some(described(&system.machine, &system.program, failure)),
        Reached::End(Outcome::Evaporated) => Some("the plan ended itself".to_string()),
        Reached::Time => Some("time is up".to_string()),
        Reached::Stop => lost.map(str::to_string),
    };
    let (first_m, last_m) = (log.along.first().map_or(0.0, |at| at.1), log.along.last().map_or(0.0, |at| at.1));
    let truth = Side::ALL.into_iter().flat_map(|side| {
        hallway.hallway.side(side).iter().map(move |found| TrueFeature {
            side,
            is: found.feature,
            from_m: found.from_mm as f64 / 1000.0 - first_m,
            to_m: found.to_mm as f64 / 1000.0 - first_m,
        })
    });
    let really_m = |along_m: f64| log.really_m(along_m) - first_m;
    let really =
        |percept: &Percept| Percept { from_m: really_m(percept.from_m), to_m: really_m(percept.to_m), ..*percept };
    let hidden = |wall: &HiddenWall| HiddenWall { from_m: really_m(wall.from_m), to_m: really_m(wall.to_m), ..*wall };
    Ok(Course {
        seed,
        percepts: log.percepts.iter().map(really).collect(),
        hidden: log.hidden.iter().map(hidden).collect(),
        truth: truth.collect(),
        driven_m: last_m - first_m,
        contacts: robot.contacts().caused,
        contour: log.contour.iter().map(|at| ContourSample { along_m: at.along_m - first_m, ..*at }).collect(),
        axis_off_deg: log.axis_off_deg,
        fault,
    })
}

impl Log {
    /// Answers why nothing more is to be seen, if so.
    fn look(&mut self, robot: &SiteRobot, middle_m: f64) -> Option<&'static str> {
        let hallway = robot.controller.modules.lola.hallway()?;
        let detection = hallway.detection()?;
        let truth = robot.true_pose_in_map();
        match self.along.last() {
            Some(last) if detection.along_m() < last.0 - BEGUN_ANEW_M => return Some("it began with another hallway"),
            Some(last) if detection.along_m() <= last.0 => return None,
            Some(_) | None => {}
        }
        let driven_m = self.along.first().map_or(0.0, |first| truth.x_m - first.1);
        self.along.push((detection.along_m(), truth.x_m));
        if driven_m >= BETWEEN_LOOKS_M * self.axis_off_deg.len() as f64
            && let Some(off_deg) = axis_off_deg(robot, hallway)
        {
            self.axis_off_deg.push(off_deg);
        }
        for side in Side::ALL {
            let heard = detection.contour(side).iter().rfind(|point| point.is_nearest);
            let heard_m = heard.map(|point| point.reading.apex_aside_m + point.reading.perpendicular_m());
            if let Some(heard_m) = heard_m {
                let aside_m = truth.y_m - middle_m + side.sign() * heard_m;
                self.contour.push(ContourSample { along_m: truth.x_m, side, aside_m });
            }
        }
        self.percepts.clone_from(&hallway.percepts);
        self.hidden = hallway.hidden();
        None
    }

    /// Where on the map's x axis the robot really was when it took itself to be so far along.
    fn really_m(&self, along_m: f64) -> f64 {
        let after = self.along.partition_point(|at| at.0 < along_m);
        let (Some(&first), Some(&last)) = (self.along.first(), self.along.last()) else { return along_m };
        match (after.checked_sub(1).and_then(|before| self.along.get(before)), self.along.get(after)) {
            (Some(before), Some(after)) => {
                before.1 + (after.1 - before.1) * (along_m - before.0) / (after.0 - before.0)
            }
            (None, _) => first.1 + along_m - first.0,
            (_, None) => last.1 + along_m - last.0,
        }
    }
}

/// The angle between the axis the robot believes in and the hallway's, which runs along x.
fn axis_off_deg(robot: &SiteRobot, hallway: &KnownHallway) -> Option<f64> {
    let axis_in_odom_rad = hallway.axis()?.heading_in_odom_rad;
    let robot_in_odom_rad = robot.estimate().pose_in_map.heading_rad;
    let axis_in_map_rad = axis_in_odom_rad + robot.true_pose_in_map().heading_rad - robot_in_odom_rad;
    Some(wrap_angle_rad(axis_in_map_rad).abs().to_degrees())
}

impl Course {
    /// What went wrong, if it did not get to the end.
    pub fn failure(&self) -> Option<FailedRun> {
        Some(FailedRun { seed: self.seed, fault: self.fault.clone()? })
    }

    /// What its percepts were worth.
    pub fn confusion(&self) -> Confusion {
        Confusion::of(&self.percepts, &self.truth, &[], self.driven_m)
    }

    /// The same without closed doors before which something stood.
    pub fn shown(&self) -> Confusion {
        Confusion::of(&self.percepts, &self.truth, &self.hidden, self.driven_m)
    }

    /// What is counted on a side and was driven past, in order.
    pub fn openings(&self, side: Side) -> Vec<TrueFeature> {
        let is_passed = |found: &&TrueFeature| found.from_m > 0.0 && found.to_m + BEHIND_M <= self.driven_m;
        let on_side = self.truth.iter().filter(|found| found.side == side).filter(is_passed);
        on_side.filter(|found| Feature::OPENINGS.contains(&found.is)).copied().collect()
    }
}
