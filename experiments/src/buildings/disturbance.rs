//! What happens on the way, as a scenario.

use rpl_random::Stream;
use rpl_robot::buildings::Building;
use rpl_robot::geometry::{Point, distance_m};
use rpl_robot::planning::path_length_m;
use rpl_robot::world::distance_to_segment_m;
use rpl_shell::files::plans::{Folder, PlanText};

/// Hands come at the latest when this share of the shortest way is driven, so that some is left.
const LATEST: f64 = 0.7;

/// A robot is carried at least so far.
const FAR_M: f64 = 3.0;

/// Where it may be put down: of some spots one that is far and free.
const SPOTS: usize = 16;

/// The shortest and the longest time for which a door stays closed.
const CLOSED_S: (f64, f64) = (20.0, 80.0);

/// A way leads through a door if it passes its middle so near.
const THROUGH_M: f64 = 0.5;

/// What happens on the way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbance {
    /// Nothing.
    None,
    /// Somebody turns the robot by 20 to 180 degrees.
    Turned,
    /// Somebody carries it elsewhere, and turns it.
    Carried,
    /// Nothing on the way: the furniture was moved before.
    Furniture,
    /// A door on the way is closed for a while.
    Doors,
    /// Nothing on the way: the wheels slip all the time.
    Slip,
}

impl Disturbance {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::None, Self::Turned, Self::Carried, Self::Furniture, Self::Doors, Self::Slip];

    /// What it is called.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Turned => "turned",
            Self::Carried => "carried",
            Self::Furniture => "furniture",
            Self::Doors => "doors",
            Self::Slip => "slip",
        }
    }

    /// The scenario of a seed in a building, if anything happens on the way.
    pub fn scenario(self, building: &Building, robot_radius_m: f64, seed: u64) -> Option<PlanText> {
        let mut stream = Stream::new(seed, "disturbance");
        let way = building.way(robot_radius_m);
        let moment_m = stream.uniform_in(0.0, LATEST * path_length_m(&way));
        let text = match self {
            Self::None | Self::Furniture | Self::Slip => return None,
            Self::Turned => {
                format!("(wait-for (>= true-distance* {moment_m:.3}))\n(rotate-robot! {:.4})", turn_rad(&mut stream))
            }
            Self::Carried => carried(building, robot_radius_m, moment_m, &mut stream),
            Self::Doors => closed(building, &way, &mut stream)?,
        };
        Some(PlanText { name: "disturbance.rpl".to_string(), text, folder: Folder::BuiltIn })
    }
}

fn turn_rad(stream: &mut Stream) -> f64 {
    let side = if stream.chance(0.5) { 1.0 } else { -1.0 };
    side * stream.uniform_in(20.0, 180.0).to_radians()
}

fn carried(building: &Building, robot_radius_m: f64, moment_m: f64, stream: &mut Stream) -> String {
    let turn_rad = turn_rad(stream);
    let spots = building.spots(SPOTS, robot_radius_m, stream);
    let spots: Vec<String> = spots.iter().map(|spot| format!("({:.3} {:.3})", spot.x_m, spot.y_m)).collect();
    format!(
        "(defun spots () '({}))
         (defun is-far (spot)
           (> (sqrt (+ (expt (- (first spot) (value true-x*)) 2) (expt (- (second spot) (value true-y*)) 2))) {FAR_M}))
         (wait-for (>= true-distance* {moment_m:.3}))
         (loop
           (let ((spot (nth (random (length (spots))) (spots))))
             (if (is-far spot)
                 (with-failure-handling ((plan-failure (f) (wait-time 0.5)))
                   (teleport-robot! (first spot) (second spot) (+ (value true-o*) {turn_rad:.4}))
                   (return nil))
                 (wait-time 0.5))))",
        spots.join(" ")
    )
}

/// A door on the way is closed before the robot is there, as soon as nobody stands in it; none if the way leads through
/// no door.
fn closed(building: &Building, way: &[Point], stream: &mut Stream) -> Option<String> {
    let doors = &building.mapped.doors;
    let passed = |at: Point| {
        let leg = way.windows(2).position(|leg| distance_to_segment_m(at, leg[0], leg[1]) < THROUGH_M)?;
        Some(path_length_m(&way[..=leg]) + distance_m(way[leg], at))
    };
    let on_way: Vec<(&str, f64)> =
        doors.iter().filter_map(|door| Some((door.room.as_str(), passed(door.at)?))).collect();
    if on_way.is_empty() {
        return None;
    }
    let (room, after_m) = on_way[stream.index(on_way.len())];
    let (moment_m, for_s) = (stream.uniform_in(0.0, after_m), stream.uniform_in(CLOSED_S.0, CLOSED_S.1));
    Some(format!(
        "(wait-for (>= true-distance* {moment_m:.3}))
         (with-failure-handling ((plan-failure (f) (wait-time 0.5) (retry)))
           (close-door! \"{room}\"))
         (wait-time {for_s:.3})
         (open-door! \"{room}\")"
    ))
}
