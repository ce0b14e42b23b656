//! What does not change of a run that is seen: its map, its robot, the texts of its plan.

use super::measures::{mm, mrad, spot};
use crate::trace::Header;
use rpl_lang::code::Program;
use rpl_lang::source::SourceId;
use rpl_page::series::{DrawnDoor, DrawnMap, DrawnRobot, DrawnSolid, Head, SolidKind, Text, VERSION};
use rpl_robot::avoidance::{DriveLimits, WINDOW_S};
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::Point;
use rpl_robot::sensors::RangeSensors;
use rpl_robot::world::{Door, Outline, SolidOrigin, World};
use std::f64::consts::TAU;

/// More rays than this are one picture with as many.
const MOST_RAYS: usize = 36;

/// Longer texts are not part of what is seen.
const MOST_TEXT_BYTES: usize = 1 << 20;

/// The head of what is seen of a run; the robot has these sensors.
pub fn head(
    run: &Header,
    texts: Vec<Text>,
    world: Option<&World>,
    robot: Option<(&RangeSensors, &DriveLimits)>,
    truth: bool,
) -> Head {
    Head {
        series: VERSION,
        rpl: run.rpl.clone().unwrap_or_default(),
        plan: run.plan.clone(),
        seed: run.seed,
        scenario: run.scenario.clone(),
        map: world.map(|world| drawn_map(world, truth)),
        robot: robot.map(|(sensors, limits)| {
            drawn_robot(run.robot.as_deref().unwrap_or(RobotDescription::PAPERS), sensors, limits)
        }),
        texts,
        truth,
    }
}

/// What a run is called above its page.
pub fn title(run: &Header) -> String {
    let world = run.world.as_ref().map_or(String::new(), |world| format!(" in {world}"));
    format!("{}{world}, seed {} – RPL", run.plan, run.seed)
}

/// The texts that a plan was compiled from; those of the library are left out.
pub fn plan_texts(program: &Program) -> Vec<Text> {
    let own =
        (program.library_sources..program.sources.len() as u32).map(|number| program.sources.get(SourceId(number)));
    let mut left = MOST_TEXT_BYTES;
    let fits = own.filter(|source| {
        let fits = source.text.len() <= left;
        left -= if fits { source.text.len() } else { 0 };
        fits
    });
    fits.map(|source| Text { name: source.name.to_string(), text: source.text.to_string() }).collect()
}

/// A world as its robot's map shows it; what is there besides is a matter of the truth.
fn drawn_map(world: &World, truth: bool) -> DrawnMap {
    let kind = |origin| match origin {
        SolidOrigin::Wall => Some(SolidKind::Wall),
        SolidOrigin::Door(_) => None,
        SolidOrigin::Object(object) if world.objects[object].mapped => Some(SolidKind::Object),
        SolidOrigin::Object(_) => truth.then_some(SolidKind::Unmapped),
    };
    let solids = world.solids();
    let name = |origin| match origin {
        SolidOrigin::Object(object) if !world.objects[object].mapped => Some(world.objects[object].name.clone()),
        SolidOrigin::Wall | SolidOrigin::Door(_) | SolidOrigin::Object(_) => None,
    };
    let drawn =
        solids.iter().filter_map(|solid| Some(drawn_solid(&solid.outline, kind(solid.origin)?, name(solid.origin))));
    let bounds = world.bounds();
    DrawnMap {
        name: world.name.clone(),
        corner: spot(bounds.min),
        size: [mm(world.size_m.x), mm(world.size_m.y)],
        solids: drawn.collect(),
        doors: world.doors.iter().map(|door| drawn_door(door, truth)).collect(),
        rooms: world.rooms.iter().map(|room| (room.name.clone(), spot(room.rect.centre()))).collect(),
        places: world.places.iter().map(|place| (place.name.clone(), spot(place.pose_in_map.point()))).collect(),
    }
}

/// An outline as it is drawn.
pub(super) fn drawn_solid(outline: &Outline, kind: SolidKind, name: Option<String>) -> DrawnSolid {
    match outline {
        Outline::Polygon(corners) => {
            DrawnSolid { kind, outline: corners.iter().copied().map(spot).collect(), radius: None, name }
        }
        Outline::Disc { centre, radius_m } => {
            DrawnSolid { kind, outline: vec![spot(*centre)], radius: Some(mm(*radius_m)), name }
        }
    }
}

fn drawn_door(door: &Door, truth: bool) -> DrawnDoor {
    let half = door.along() * (door.width_m / 2.0);
    DrawnDoor {
        room: door.room.clone(),
        jambs: [spot(door.at - half), spot(door.at + half)],
        open: if truth { door.open } else { door.mapped_open },
    }
}

fn drawn_robot(name: &str, sensors: &RangeSensors, limits: &DriveLimits) -> DrawnRobot {
    let gained_mps = limits.translation_acceleration_mps2.max(limits.translation_deceleration_mps2) * WINDOW_S;
    DrawnRobot {
        name: name.to_string(),
        radius: mm(limits.robot_radius_m),
        rays: rays(sensors),
        range: mm(range_m(sensors)),
        fastest: [mm(limits.hallway_mps), mrad(limits.max_rotation_radps)],
        window: [mm(gained_mps), mrad(limits.rotation_acceleration_radps2 * WINDOW_S)],
    }
}

fn range_m(sensors: &RangeSensors) -> f64 {
    let laser_m = sensors.laser.as_ref().map(|laser| laser.range_m);
    laser_m.or_else(|| sensors.sonars.as_ref().map(|sonars| sonars.range_m)).unwrap_or(0.0)
}

/// The rays of the sharpest sensor.
fn rays(sensors: &RangeSensors) -> Vec<[i32; 3]> {
    let ray = |at: Point, heading_rad: f64| [mm(at.x), mm(at.y), mrad(heading_rad.rem_euclid(TAU))];
    if let Some(laser) = &sensors.laser {
        return sectors(laser.readings)
            .map(|(from, to)| ray(Point::origin(), laser.direction_rad((from + to - 1) / 2)))
            .collect();
    }
    let mounts = sensors.sonars.iter().flat_map(|sonars| &sonars.mounts);
    mounts.take(MOST_RAYS).map(|mount| ray(mount.at_in_base, mount.heading_rad)).collect()
}

/// Readings of a fan that are one ray: from, up to.
pub(super) fn sectors(readings: usize) -> impl Iterator<Item = (usize, usize)> {
    let count = readings.min(MOST_RAYS);
    (0..count).map(move |at| (at * readings / count, (at + 1) * readings / count))
}
