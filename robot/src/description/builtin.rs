//! The robots in the binary.

use super::RobotDescription;
use crate::file_text::FileFaults;
use std::sync::{Arc, LazyLock};

/// A robot's name, its text, and what it is if it is another with more to it.
const ROBOTS: [(&str, &str, &str); 7] = [
    ("b21", include_str!("../../robots/b21.toml"), ""),
    (
        "b21-camera",
        concat!(include_str!("../../robots/b21.toml"), include_str!("../../robots/camera-of-b21.toml")),
        "`b21` with a colour camera besides, on a pan unit.",
    ),
    (
        "b21-laser",
        concat!(include_str!("../../robots/b21.toml"), include_str!("../../robots/laser-of-b21.toml")),
        "`b21` with a laser range finder besides, which sees the front half turn.",
    ),
    ("nomad-200", include_str!("../../robots/nomad-200.toml"), ""),
    ("pioneer-2dx", include_str!("../../robots/pioneer-2dx.toml"), ""),
    ("pioneer-front", include_str!("../../robots/pioneer-front.toml"), ""),
    ("turtlebot", include_str!("../../robots/turtlebot.toml"), ""),
];

static BUILTIN: LazyLock<Vec<Arc<RobotDescription>>> =
    LazyLock::new(|| ROBOTS.iter().filter_map(|(name, ..)| builtin(name)?.ok().map(Arc::new)).collect());

fn builtin(name: &str) -> Option<Result<RobotDescription, FileFaults>> {
    let (name, text, variation) = *entry(name)?;
    let read = RobotDescription::parse(text, &format!("{name}.toml"));
    let named = |robot: RobotDescription| {
        let purpose = if variation.is_empty() { robot.purpose } else { variation.to_string() };
        // Some are the text of another with more to it, its name included.
        RobotDescription { name: name.to_string(), purpose, ..robot }
    };
    Some(read.map(named))
}

fn entry(name: &str) -> Option<&'static (&'static str, &'static str, &'static str)> {
    ROBOTS.iter().find(|(known, ..)| *known == name)
}

impl RobotDescription {
    /// The name of the papers' robot, which drives where nobody names another.
    pub const PAPERS: &'static str = "b21";

    /// The papers' robot.
    pub fn papers() -> Arc<Self> {
        match Self::builtin(Self::PAPERS) {
            Some(robot) => robot,
            None => unreachable!("a test reads all built-in robots"),
        }
    }

    /// A robot by its name: `b21`, the papers' robot, with 24 sonars; `b21-camera` and `b21-laser`, the same
    /// with a camera or a laser besides; `nomad-200` with 16 sonars and a camera; `pioneer-2dx` with sonars before
    /// and behind and a camera, `pioneer-front` with those before alone; `turtlebot`, small, with a laser.
    pub fn builtin(name: &str) -> Option<Arc<Self>> {
        BUILTIN.iter().find(|robot| robot.name == name).cloned()
    }

    /// The names `builtin` knows.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        ROBOTS.iter().map(|(name, ..)| *name)
    }

    /// The text of a built-in robot, to start one's own from.
    pub fn builtin_text(name: &str) -> Option<&'static str> {
        entry(name).map(|(_, text, _)| *text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_robot_is_free_of_faults() {
        for name in RobotDescription::builtin_names() {
            let robot = builtin(name).expect("it is in the list").unwrap_or_else(|error| panic!("{error}"));
            assert!(robot.purpose.len() > 20 && robot.purpose.ends_with('.'), "{name}: {}", robot.purpose);
            assert_eq!(RobotDescription::builtin(name).as_deref(), Some(&robot));
        }
    }
}
