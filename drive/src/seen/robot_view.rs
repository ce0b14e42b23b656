//! The robot in the words of the page: how often it is looked at, and what of it has changed.
//!
//! What takes much room is shown as often as room comes in, some for each second of the plan, and more in advance: a
//! robot that is lost for a while is seen well, and one that is lost for hours does not fill its report.

use super::head::{drawn_solid, sectors};
use super::measures::{mm, mrad, pose, spot};
use rpl_mission::robot::Robot;
use rpl_mission::sight::Sight;
use rpl_page::belief::{DrawnBelief, PositionGrid};
use rpl_page::place::Spot;
use rpl_page::series::{self, DrawnSolid, Seen, SolidKind};
use rpl_robot::office::Navigating;
use rpl_robot::simulator::SimulatorState;
use rpl_robot::world::World;

/// How often the robot is shown, its rays, and where it may be.
const ROBOT_EVERY_US: u64 = 200_000;
const RAYS_EVERY_US: u64 = 1_000_000;
const BELIEF_EVERY_US: u64 = 1_000_000;

/// Remembered obstacles are drawn on a grid of this.
const OBSTACLE_CM: i32 = 10;

/// The most bytes that a belief, people and the obstacles take for each second, and in advance.
const BELIEF_ROOM: Room = Room { bytes_per_s: 250, most_bytes: 400_000, left_bytes: 400_000, at_us: 0 };
const PEOPLE_ROOM: Room = Room { bytes_per_s: 60, most_bytes: 20_000, left_bytes: 20_000, at_us: 0 };
const OBSTACLE_ROOM: Room = Room { bytes_per_s: 120, most_bytes: 20_000, left_bytes: 20_000, at_us: 0 };

/// Where the robot is said to be, as the page has it; where it really is only if that is to be seen.
pub fn drawn_sight(sight: &Sight, truth: bool) -> series::Robot {
    let thousandths = |share: f64| (share * 1000.0).round() as i32;
    series::Robot {
        estimate: pose(sight.estimate_in_map),
        certainty: thousandths(sight.certainty),
        speed: sight.velocity.map(|velocity| [mm(velocity.translation_mps), mrad(velocity.rotation_radps)]),
        battery: sight.battery.map(thousandths),
        truth: sight.robot_in_map.filter(|_| truth).map(pose),
    }
}

/// Room that comes in with time.
#[derive(Clone, Copy, Debug)]
struct Room {
    bytes_per_s: u64,
    most_bytes: u64,
    left_bytes: u64,
    at_us: u64,
}

impl Room {
    /// Whether there is room for something, which is then taken.
    fn takes(&mut self, now_us: u64, bytes: usize) -> bool {
        let came = self.bytes_per_s * now_us.saturating_sub(self.at_us) / 1_000_000;
        if came > 0 {
            self.left_bytes = (self.left_bytes + came).min(self.most_bytes);
            self.at_us = now_us;
        }
        let fits = self.left_bytes >= bytes as u64;
        self.left_bytes -= if fits { bytes as u64 } else { 0 };
        fits
    }
}

/// The robot, as far as the page has been told of it.
pub struct RobotView {
    truth: bool,
    robot_due_us: u64,
    rays_due_us: u64,
    belief_due_us: u64,
    robot: Option<series::Robot>,
    ranges: Vec<i32>,
    targets: Vec<Spot>,
    obstacles: Vec<i32>,
    belief: Option<DrawnBelief>,
    closed: Option<Vec<usize>>,
    things: Option<Vec<DrawnSolid>>,
    people: Vec<i32>,
    people_room: Room,
    belief_room: Room,
    obstacle_room: Room,
}

impl RobotView {
    /// Nothing has been told.
    pub fn new(truth: bool) -> Self {
        Self {
            truth,
            robot_due_us: 0,
            rays_due_us: 0,
            belief_due_us: 0,
            robot: None,
            ranges: Vec::new(),
            targets: Vec::new(),
            obstacles: Vec::new(),
            belief: None,
            closed: None,
            things: None,
            people: Vec::new(),
            people_room: PEOPLE_ROOM,
            belief_room: BELIEF_ROOM,
            obstacle_room: OBSTACLE_ROOM,
        }
    }

    /// Looks at a robot, which is seen as said; tells what has changed. Cost: once a second a pass over the belief, else next
    /// to nothing.
    pub fn look(&mut self, now_us: u64, sight: &Sight, robot: &mut Robot) -> Vec<Seen> {
        let mut seen = Vec::new();
        if now_us < self.robot_due_us {
            return seen;
        }
        self.robot_due_us = now_us + ROBOT_EVERY_US;
        self.note_robot(drawn_sight(sight, self.truth), &mut seen);
        if now_us >= self.rays_due_us {
            self.rays_due_us = now_us + RAYS_EVERY_US;
            changed(&mut self.ranges, ranges(robot), Seen::Ranges, &mut seen);
            self.look_at_ways(now_us, sight, robot, &mut seen);
            self.look_around(now_us, robot, &mut seen);
        }
        if now_us >= self.belief_due_us {
            self.belief_due_us = now_us + BELIEF_EVERY_US;
            self.look_at_belief(now_us, robot, &mut seen);
        }
        seen
    }

    /// Takes in where a robot was said to be that is not there to be looked at.
    pub fn note(&mut self, sight: &Sight) -> Vec<Seen> {
        let mut seen = Vec::new();
        self.note_robot(drawn_sight(sight, self.truth), &mut seen);
        seen
    }

    fn note_robot(&mut self, drawn: series::Robot, seen: &mut Vec<Seen>) {
        if self.robot.as_ref() != Some(&drawn) {
            seen.push(Seen::Robot(drawn.clone()));
            self.robot = Some(drawn);
        }
    }

    fn look_at_ways(&mut self, now_us: u64, sight: &Sight, robot: &mut Robot, seen: &mut Vec<Seen>) {
        let (Some(model), Some(percept)) = (robot.model(), robot.percept()) else { return };
        let is_mapped = model.map.is_some();
        let odom_in_map = sight.estimate_in_map.compose(percept.odometry_in_odom.inverse());
        let Some(navigation) = robot.navigation() else { return };
        let in_map = |point| if is_mapped { point } else { odom_in_map.transform(point) };
        let targets = navigation.remaining_targets().map(|point| spot(in_map(point))).collect();
        changed(&mut self.targets, targets, Seen::Targets, seen);
        let mut obstacles: Vec<[i32; 2]> = navigation
            .obstacles_in_odom()
            .map(|point| {
                spot(odom_in_map.transform(point))
                    .map(|mm| (mm + 5 * OBSTACLE_CM).div_euclid(10 * OBSTACLE_CM) * OBSTACLE_CM)
            })
            .collect();
        obstacles.sort_unstable();
        obstacles.dedup();
        let obstacles = obstacles.into_iter().flatten().collect::<Vec<i32>>();
        if obstacles != self.obstacles && self.obstacle_room.takes(now_us, 5 * obstacles.len()) {
            changed(&mut self.obstacles, obstacles, Seen::Obstacles, seen);
        }
    }

    /// The doors that are closed; with the truth also people, and objects that the robot's map lacks.
    fn look_around(&mut self, now_us: u64, robot: &mut Robot, seen: &mut Vec<Seen>) {
        if let Some((world, state)) = robot.simulated_world().filter(|_| self.truth) {
            newly(&mut self.closed, closed_doors(&state.doors_open), Seen::Closed, seen);
            newly(&mut self.things, things(world, state), Seen::Things, seen);
            let people = state.people.iter().flat_map(|person| [cm(person.at_in_map.x), cm(person.at_in_map.y)]);
            let people = people.collect::<Vec<i32>>();
            if people != self.people && self.people_room.takes(now_us, 5 * people.len()) {
                changed(&mut self.people, people, Seen::People, seen);
            }
        } else if let Some(model) = robot.model().cloned() {
            let found = robot.navigation().map_or(Vec::new(), Navigating::closed_doors);
            let doors = model.world.doors.iter().enumerate();
            let open: Vec<bool> = doors.map(|(number, door)| door.mapped_open && !found.contains(&number)).collect();
            newly(&mut self.closed, closed_doors(&open), Seen::Closed, seen);
        }
    }

    fn look_at_belief(&mut self, now_us: u64, robot: &Robot, seen: &mut Vec<Seen>) {
        let Some(belief) = robot.belief() else { return };
        let drawn = DrawnBelief::of(PositionGrid {
            corner_m: [belief.origin_in_map.x, belief.origin_in_map.y],
            cell_m: belief.resolution_m,
            columns: belief.columns,
            cells: &belief.cells,
        });
        if self.belief.as_ref() != Some(&drawn) && self.belief_room.takes(now_us, drawn.steps.len()) {
            seen.push(Seen::Belief(drawn.clone()));
            self.belief = Some(drawn);
        }
    }
}

/// Centimetres.
fn cm(length_m: f64) -> i32 {
    (length_m * 100.0).round() as i32
}

fn closed_doors(open: &[bool]) -> Vec<usize> {
    open.iter().enumerate().filter(|(_, is_open)| !**is_open).map(|(number, _)| number).collect()
}

/// Objects in a world that are not in the robot's map.
fn things(world: &World, state: &SimulatorState) -> Vec<DrawnSolid> {
    let of_world = world.objects.iter().zip(&state.objects_removed);
    let left = of_world.filter(|(object, is_removed)| !object.mapped && !**is_removed).map(|(object, _)| object);
    let all = left.chain(&state.objects_added);
    all.map(|object| drawn_solid(&object.outline(), SolidKind::Unmapped, Some(object.name.clone()))).collect()
}

/// Tells of something that is different now, or was not told yet.
fn newly<T: PartialEq + Clone>(known: &mut Option<T>, now: T, tell: impl Fn(T) -> Seen, seen: &mut Vec<Seen>) {
    if known.as_ref() != Some(&now) {
        *known = Some(now.clone());
        seen.push(tell(now));
    }
}

/// Tells of a list that is another one now.
fn changed<T: PartialEq + Clone>(known: &mut Vec<T>, now: Vec<T>, tell: impl Fn(Vec<T>) -> Seen, seen: &mut Vec<Seen>) {
    if *known != now {
        known.clone_from(&now);
        seen.push(tell(now));
    }
}

/// What the sharpest range sensor says, in centimetres; of a fan the nearest of the readings that are one ray.
fn ranges(robot: &Robot) -> Vec<i32> {
    let (Some(model), Some(percept)) = (robot.model(), robot.percept()) else { return Vec::new() };
    let cm = |range_m: f32, most_m: f64| if f64::from(range_m) < most_m { (range_m * 100.0).round() as i32 } else { 0 };
    if let (Some(laser), Some(scan)) = (&model.sensors.laser, &percept.laser_m) {
        let nearest =
            |(from, to): (usize, usize)| scan.get(from..to).into_iter().flatten().copied().fold(f32::MAX, f32::min);
        return sectors(scan.len()).map(|sector| cm(nearest(sector), laser.range_m)).collect();
    }
    match (&model.sensors.sonars, &percept.sonar_m) {
        (Some(sonars), Some(heard)) => heard.iter().map(|&range_m| cm(range_m, sonars.range_m)).collect(),
        _ => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_comes_in_with_time_and_is_never_more_than_its_most() {
        let mut room = Room { bytes_per_s: 100, most_bytes: 250, left_bytes: 250, at_us: 0 };
        assert!(room.takes(0, 250));
        assert!(!room.takes(500_000, 51));
        assert!(room.takes(500_000, 50));
        assert!(!room.takes(3_600_000_000, 251), "an hour of silence is no more than its most");
        assert!(room.takes(3_600_000_000, 250));
    }
}
