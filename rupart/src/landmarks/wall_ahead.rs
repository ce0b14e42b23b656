//! A wall before the robot, by what its sonars hear of it.

use rpl_robot::geometry::{Vector, wrap_angle_rad};
use rpl_robot::sensors::{SonarArray, SonarMount};

/// A straight wall, as the robot has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallAhead {
    /// From the middle of the robot, straight to the wall.
    pub off_m: f64,
    /// In which direction that is, counter-clockwise from ahead.
    pub bearing_rad: f64,
}

/// Sonars that look farther aside hear nothing of a wall ahead, or its echo is lost.
const ASIDE_RAD: f64 = 40.0 / 180.0 * std::f64::consts::PI;

/// A wall is looked for up to the first angle aside, in steps of the second.
const WIDEST_RAD: f64 = 20.0 / 180.0 * std::f64::consts::PI;
const STEP_RAD: f64 = 0.25 / 180.0 * std::f64::consts::PI;

/// The fewest sonars that hear a wall.
const FEWEST_SONARS: usize = 3;

/// Differences count up to this: a sonar that heard something else counts no more.
const MOST_OFF_M: f64 = 0.1;

/// The mean difference of a wall that was heard as one is less.
const FITTING_M: f64 = 0.05;

/// The wall that explains best what the sonars in front heard, reading by reading in the order of the array; of
/// several scans from one place the middle readings count. None if no wall does. Cost: a pass over the sonars for
/// each of 160 directions.
///
/// # Deviation
/// The paper says that the robot turns perpendicular to the wall and not how it knows. A cone tells the nearest
/// point in it: the wider a sonar looks past the foot of the perpendicular, the longer its reading, so that the
/// sonars left and right of the foot tell where it is.
pub fn wall_ahead(sonars: &SonarArray, scans_m: &[Vec<f32>]) -> Option<WallAhead> {
    let in_front = sonars.mounts.iter().enumerate().filter(|(_, mount)| mount.heading_rad.abs() <= ASIDE_RAD);
    let heard: Vec<(&SonarMount, f64)> =
        in_front.filter_map(|(sonar, mount)| Some((mount, middle_m(scans_m, sonar, sonars.range_m)?))).collect();
    if heard.len() < FEWEST_SONARS {
        return None;
    }
    let steps = libm::round(WIDEST_RAD / STEP_RAD) as i32;
    let fits = (-steps..=steps).map(|step| fit(sonars, &heard, f64::from(step) * STEP_RAD));
    let (wall, off_m) = fits.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (off_m < FITTING_M).then_some(wall)
}

/// The middle one of the readings of a sonar that heard something.
fn middle_m(scans_m: &[Vec<f32>], sonar: usize, range_m: f64) -> Option<f64> {
    let readings = scans_m.iter().filter_map(|scan_m| scan_m.get(sonar)).map(|&reading_m| f64::from(reading_m));
    let mut heard_m: Vec<f64> = readings.filter(|reading_m| *reading_m > 0.0 && *reading_m < range_m).collect();
    if 2 * heard_m.len() < scans_m.len() {
        return None;
    }
    heard_m.sort_by(f64::total_cmp);
    heard_m.get(heard_m.len() / 2).copied()
}

/// The wall in a direction, and the mean difference to what was heard.
fn fit(sonars: &SonarArray, heard: &[(&SonarMount, f64)], bearing_rad: f64) -> (WallAhead, f64) {
    let (sin, cos) = libm::sincos(bearing_rad);
    let towards = Vector::new(cos, sin);
    // Where the wall would be by each of them alone.
    let mut alone_m: Vec<f64> = heard
        .iter()
        .map(|(mount, reading_m)| {
            let aside_rad = wrap_angle_rad(mount.heading_rad - bearing_rad).abs() - sonars.cone_rad / 2.0;
            mount.at_in_base.coords.dot(&towards) + reading_m * libm::cos(aside_rad.max(0.0))
        })
        .collect();
    alone_m.sort_by(f64::total_cmp);
    let middle_m = alone_m[alone_m.len() / 2];
    let near: Vec<f64> = alone_m.iter().copied().filter(|off_m| (off_m - middle_m).abs() < MOST_OFF_M).collect();
    let off_m = near.iter().sum::<f64>() / near.len() as f64;
    let differences_m = alone_m.iter().map(|alone_m| (alone_m - off_m).abs().min(MOST_OFF_M));
    (WallAhead { off_m, bearing_rad }, differences_m.sum::<f64>() / alone_m.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_robot::description::RobotDescription;
    use rpl_robot::geometry::Pose;
    use rpl_robot::simulator::{Commands, SimulatorModel, SimulatorSettings};
    use rpl_robot::world::World;
    use std::sync::Arc;

    #[test]
    fn a_wall_is_heard_where_it_is() {
        let text = "name = \"hall\"\nsize = [8.0, 8.0]\nstart = [4.0, 4.0, 0]\n\
                    [[wall]]\nline = [[0.0, 0.0], [0.0, 8.0]]\nthickness = 0.2";
        let world = Arc::new(World::parse(text, "hall.toml").expect("a world"));
        let robot = RobotDescription::builtin("pioneer-2dx").expect("built in");
        let model = SimulatorModel::new(world, SimulatorSettings::of(robot));
        let sonars = model.sensors.sonars.as_ref().expect("it has sonars");
        for (seed, (off_m, turned_rad)) in (1..).zip([(0.9, 0.0), (1.0, 0.1), (0.8, -0.08), (1.2, 0.05), (1.1, -0.12)])
        {
            let mut state = model.start(seed);
            let heading_rad = std::f64::consts::PI - turned_rad;
            model.teleport(&mut state, Pose::new(0.1 + off_m, 4.0, heading_rad)).expect("nothing is there");
            let commands = Commands { sonars_on: true, ..Commands::default() };
            let scans_m: Vec<Vec<f32>> = (0..20).filter_map(|_| model.step(&mut state, &commands).sonar_m).collect();
            let wall = wall_ahead(sonars, &scans_m).expect("a wall");
            assert!((wall.off_m - off_m).abs() < 0.03, "{off_m} {turned_rad}: {wall:?}");
            assert!((wall.bearing_rad - turned_rad).abs() < 0.06, "{off_m} {turned_rad}: {wall:?}");
        }
        assert_eq!(wall_ahead(sonars, &[]), None);
    }
}
