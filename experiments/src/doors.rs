//! Deliveries on whose way a door is closed for a while, world by world.

use super::request::ExperimentRequest;
use super::trial::{Goal, MissionTrial};
use super::worlds::{DRAWS, TestGround, WorldDrives, draw_place, draw_start, no_errand, robot_at, run_errand};
use anyhow::{Result, bail};
use rpl_mission::modules::SiteRobot;
use rpl_random::Stream;
use rpl_robot::geometry::{Point, Pose, distance_m};
use rpl_robot::planning::path_length_m;
use rpl_robot::world::{Place, World};
use rpl_shell::files::plans::{Folder, PlanText};
use rpl_shell::sites;

/// The worlds with doors between their places.
pub(super) const WORLDS: [&str; 10] = [
    "long-corridor",
    "two-wings",
    "flat",
    "small-office",
    "lab",
    "gallery",
    "ring",
    "school",
    "dept",
    "dept-furnished",
];

/// The shortest and the longest time for which a door stays closed.
const CLOSED_S: (f64, f64) = (20.0, 80.0);

/// It is closed before the robot could be at its goal at this speed.
const SLOW_MPS: f64 = 0.4;

/// A way leads through a door if it passes its middle so near.
const THROUGH_M: f64 = 0.5;

/// One delivery: from a place to another, the robot anywhere at first.
struct Errand<'w> {
    robot: SiteRobot,
    from: &'w Place,
    to: &'w Place,
    optimum_m: f64,
}

/// The deliveries of all worlds, or of the one that is asked for.
///
/// # Errors
/// No row has the name.
pub fn drives(request: ExperimentRequest) -> Result<WorldDrives> {
    WorldDrives::of(request, &WORLDS, deliver)
}

fn deliver(ground: &TestGround, request: &ExperimentRequest, seed: u64) -> Result<MissionTrial> {
    let errand = draw(ground, seed)?;
    let goal = Goal { pose_in_map: errand.to.pose_in_map, item: Some("parcel") };
    let text = format!("(deliver 'parcel '{} '{})", errand.from.name, errand.to.name);
    run_errand(ground, errand.robot, &text, request, seed, goal, errand.optimum_m)
}

/// A start, two places, and a door on the way, drawn from the seed.
fn draw(ground: &TestGround, seed: u64) -> Result<Errand<'_>> {
    let mut stream = Stream::new(seed, "errand");
    for _ in 0..DRAWS {
        let (from, to) = (draw_place(&ground.world, &mut stream), draw_place(&ground.world, &mut stream));
        let Some(start) = draw_start(ground, from, &mut stream) else { continue };
        let Some(on) = ground.floor.cost_to_go(to.pose_in_map.point()).path(from.pose_in_map.point()) else {
            continue;
        };
        let doors = doors_on(&ground.world, &[&start.path[..], &on].concat());
        if from.name == to.name || doors.is_empty() {
            continue;
        }
        let room = &ground.world.doors[doors[stream.index(doors.len())]].room;
        let optimum_m = path_length_m(&start.path) + path_length_m(&on);
        let (after_s, for_s) =
            (stream.uniform_in(0.0, optimum_m / SLOW_MPS), stream.uniform_in(CLOSED_S.0, CLOSED_S.1));
        let site = sites::with_scenario(&ground.site, scenario(from, room, after_s, for_s))?;
        if let Some(robot) = robot_at(&site, seed, &start) {
            return Ok(Errand { robot, from, to, optimum_m });
        }
    }
    bail!("{}", no_errand(ground, seed))
}

/// A thing is laid ready; later the door of a room is closed, as soon as nobody stands in it, and
/// opened again.
fn scenario(from: &Place, room: &str, after_s: f64, for_s: f64) -> PlanText {
    let Pose { x_m, y_m, .. } = from.pose_in_map;
    let text = format!(
        "(place-item! 'parcel {x_m:.3} {y_m:.3})
         (wait-time {after_s:.3})
         (with-failure-handling ((plan-failure (f) (wait-time 0.5) (retry)))
           (close-door! \"{room}\"))
         (wait-time {for_s:.3})
         (open-door! \"{room}\")"
    );
    PlanText { name: "door.rpl".to_string(), text, folder: Folder::BuiltIn }
}

/// The open doors that a way leads through, by their numbers.
fn doors_on(world: &World, path: &[Point]) -> Vec<usize> {
    let passes = |at: Point| path.windows(2).any(|leg| distance_to_leg_m(at, leg[0], leg[1]) < THROUGH_M);
    (0..world.doors.len()).filter(|&door| world.doors[door].open && passes(world.doors[door].at)).collect()
}

fn distance_to_leg_m(point: Point, from: Point, to: Point) -> f64 {
    let way = to - from;
    let share = (point - from).dot(&way) / way.norm_squared().max(1e-12);
    distance_m(point, from + way * share.clamp(0.0, 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_leads_through_the_doors_it_passes() {
        let world = World::builtin("test-room").expect("built in");
        let through = [Point::new(1.5, 3.0), Point::new(4.0, 3.1), Point::new(6.0, 3.0)];
        assert_eq!(doors_on(&world, &through), [0]);
        assert!(doors_on(&world, &through[..2]).is_empty());
    }
}
