//! `rpl robots [NAME]`: the built-in robots, and what one of them can do.

use anyhow::Result;
use clap_complete::engine::ArgValueCompleter;
use rpl_robot::description::{BatteryDescription, Driving, Motors, RobotDescription, Sonar};
use rpl_robot::sensors::SonarLayout;
use rpl_shell::arguments::completion;
use rpl_shell::files::robot_files;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;

/// Columns of the names in the list.
const NAME_COLUMNS: usize = 16;

/// Columns of what is told of a robot.
const KEY_COLUMNS: usize = 10;

/// List the robots, or show one
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Built-in robot or .toml file
    #[arg(value_name = "NAME", add = ArgValueCompleter::new(completion::robots))]
    name: Option<String>,
    /// Print the robot's file instead, as a start for one of your own
    #[arg(long, requires = "name")]
    toml: bool,
}

/// Lists the robots, or shows one.
///
/// # Errors
/// No robot has the name, or its file has faults.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let Some(name) = &arguments.name else {
        for robot in RobotDescription::builtin_names().filter_map(RobotDescription::builtin) {
            let line = format!("{:NAME_COLUMNS$}  {}", robot.name, robot.purpose);
            console.explain_hanging(&line, NAME_COLUMNS + 2)?;
        }
        return Ok(Status::Succeeded);
    };
    if arguments.toml {
        console.print(robot_files::text(name)?.trim_end())?;
        return Ok(Status::Succeeded);
    }
    let robot = robot_files::named(Some(name))?;
    console.explain(&describe(&robot))?;
    Ok(Status::Succeeded)
}

fn describe(robot: &RobotDescription) -> String {
    let mut lines = vec![format!("{}: {}", robot.name, robot.purpose)];
    let mut tell = |key: &str, what: String| lines.push(format!("{key:KEY_COLUMNS$}{what}"));
    tell("body", format!("{:.2} m across", 2.0 * robot.radius_m));
    tell("step", format!("{} ms", robot.step_us / 1_000));
    tell("motors", motors(&robot.motors));
    tell("driving", driving(&robot.driving));
    tell("sonars", robot.sonar.as_ref().map_or("none".into(), sonars));
    let laser = robot.laser.map(|laser| laser.scanner);
    tell(
        "laser",
        laser.map_or("none".into(), |laser| {
            format!("{} readings, {}° apart, {} m", laser.readings, laser.resolution_deg, laser.range_m as f32)
        }),
    );
    tell("bumper", if robot.bumper { "yes".into() } else { "none".into() });
    tell("gripper", robot.gripper.map_or("none".into(), |gripper| format!("reaches {} m", gripper.reach_m)));
    tell("battery", robot.battery.map_or("none: it drives for ever".into(), battery));
    lines.join("\n")
}

fn motors(motors: &Motors) -> String {
    format!(
        "{} m/s, {:.0}°/s; speeds up by {} and brakes by {} m/s²",
        motors.max_translation_mps,
        motors.max_rotation_radps.to_degrees(),
        motors.translation_acceleration_mps2,
        motors.translation_deceleration_mps2
    )
}

fn driving(driving: &Driving) -> String {
    let Driving { hallway_mps, office_mps, doorway_mps, .. } = driving;
    format!("{hallway_mps} m/s in hallways, {office_mps} m/s in offices, {doorway_mps} m/s through doors")
}

fn sonars(sonar: &Sonar) -> String {
    let cone_deg = sonar.cone_rad.to_degrees();
    let reach = format!("cones of {cone_deg:.0}°, {} m", sonar.range_m as f32);
    match &sonar.layout {
        SonarLayout::Ring(count) => format!("{count} in a ring, {reach}"),
        SonarLayout::Mounts(mounts) => {
            let degrees: Vec<String> =
                mounts.iter().map(|mount| format!("{:.0}°", mount.heading_rad.to_degrees())).collect();
            format!("{}, {reach}; they look at {}", mounts.len(), degrees.join(" "))
        }
    }
}

fn battery(battery: BatteryDescription) -> String {
    let hours = |time_s: f64| time_s / 3600.0;
    format!("{:.1} h driving, {:.1} h standing", hours(battery.driving_s), hours(battery.standing_s))
}
