//! The worlds in the binary.

use super::World;
use crate::file_text::FileFaults;

/// A world's name, its text, and what it is if it is another with more to it.
const WORLDS: [(&str, &str, &str); 20] = [
    ("dept", include_str!("../../worlds/dept.toml"), ""),
    (
        "dept-furnished",
        concat!(include_str!("../../worlds/dept.toml"), include_str!("../../worlds/dept-furnished.toml")),
        "`dept` with four people, and furniture that is in no map.",
    ),
    (
        "dept-staffed",
        concat!("people = 6\n\n", include_str!("../../worlds/dept.toml")),
        "`dept` with six people who come and go.",
    ),
    ("dept-crowded", concat!("people = 20\n\n", include_str!("../../worlds/dept.toml")), "`dept` with twenty people."),
    ("corridor", include_str!("../../worlds/corridor.toml"), ""),
    (
        "corridor-crowded",
        concat!("people = 20\n\n", include_str!("../../worlds/corridor.toml")),
        "`corridor` with twenty people.",
    ),
    (
        "sensing",
        concat!(include_str!("../../worlds/corridor.toml"), include_str!("../../worlds/sensing.toml")),
        "`corridor` with a box that only the sonars see.",
    ),
    ("long-corridor", include_str!("../../worlds/long-corridor.toml"), ""),
    ("two-wings", include_str!("../../worlds/two-wings.toml"), ""),
    ("hall", include_str!("../../worlds/hall.toml"), ""),
    ("flat", include_str!("../../worlds/flat.toml"), ""),
    ("small-office", include_str!("../../worlds/small-office.toml"), ""),
    ("lab", include_str!("../../worlds/lab.toml"), ""),
    ("warehouse", include_str!("../../worlds/warehouse.toml"), ""),
    ("gallery", include_str!("../../worlds/gallery.toml"), ""),
    ("ring", include_str!("../../worlds/ring.toml"), ""),
    ("school", include_str!("../../worlds/school.toml"), ""),
    ("olin-rice", include_str!("../../worlds/olin-rice.toml"), ""),
    (
        "olin-rice-crowded",
        concat!("people = 20\n\n", include_str!("../../worlds/olin-rice.toml")),
        "`olin-rice` with twenty people.",
    ),
    ("test-room", include_str!("../../worlds/test-room.toml"), ""),
];

impl World {
    /// A world by its name: `dept`, the department of Beetz, Burgard, Fox and Cremers;
    /// `dept-furnished`, the same with people, and furniture that is in no map; `dept-staffed` and
    /// `dept-crowded`, the same with six and with twenty people; `corridor`, its corridor with all
    /// doors closed, `corridor-crowded` with twenty people in it, and `sensing` with a box only the
    /// sonars see; ten other buildings from `flat` to `warehouse`; `test-room`, two small rooms for
    /// quick trials.
    pub fn builtin(name: &str) -> Option<World> {
        let mut world = Self::parse_builtin(name)?.ok()?;
        // Some are the text of another with more to it, its name included.
        world.name = name.to_string();
        Some(world)
    }

    /// The names `builtin` knows.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        WORLDS.iter().map(|(name, ..)| *name)
    }

    /// The text of a built-in world, to start one's own from.
    pub fn builtin_text(name: &str) -> Option<&'static str> {
        Self::entry(name).map(|(_, text, _)| *text)
    }

    /// What a built-in world is, in a sentence: the first of its text, if it is not a variation.
    pub fn builtin_purpose(name: &str) -> Option<String> {
        let (_, text, variation) = Self::entry(name)?;
        if !variation.is_empty() {
            return Some((*variation).to_string());
        }
        let comment: Vec<&str> = text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim).collect();
        let comment = comment.join(" ");
        Some(comment.split_once(". ").map_or(comment.clone(), |(first, _)| format!("{first}.")))
    }

    fn entry(name: &str) -> Option<&'static (&'static str, &'static str, &'static str)> {
        WORLDS.iter().find(|(known, ..)| *known == name)
    }

    fn parse_builtin(name: &str) -> Option<Result<World, FileFaults>> {
        Some(World::parse(Self::builtin_text(name)?, &format!("{name}.toml")))
    }
}
