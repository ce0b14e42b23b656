//! The worlds in the binary.

use super::{World, WorldError};

const WORLDS: [(&str, &str); 18] = [
    ("dept", include_str!("../../worlds/dept.toml")),
    (
        "dept-furnished",
        concat!(include_str!("../../worlds/dept.toml"), include_str!("../../worlds/dept-furnished.toml")),
    ),
    ("dept-staffed", concat!("people = 6\n\n", include_str!("../../worlds/dept.toml"))),
    ("dept-crowded", concat!("people = 20\n\n", include_str!("../../worlds/dept.toml"))),
    ("corridor", include_str!("../../worlds/corridor.toml")),
    ("corridor-crowded", concat!("people = 20\n\n", include_str!("../../worlds/corridor.toml"))),
    ("long-corridor", include_str!("../../worlds/long-corridor.toml")),
    ("two-wings", include_str!("../../worlds/two-wings.toml")),
    ("hall", include_str!("../../worlds/hall.toml")),
    ("flat", include_str!("../../worlds/flat.toml")),
    ("small-office", include_str!("../../worlds/small-office.toml")),
    ("lab", include_str!("../../worlds/lab.toml")),
    ("warehouse", include_str!("../../worlds/warehouse.toml")),
    ("gallery", include_str!("../../worlds/gallery.toml")),
    ("ring", include_str!("../../worlds/ring.toml")),
    ("school", include_str!("../../worlds/school.toml")),
    ("sensing", concat!(include_str!("../../worlds/corridor.toml"), include_str!("../../worlds/sensing.toml"))),
    ("test-room", include_str!("../../worlds/test-room.toml")),
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
        WORLDS.iter().map(|(name, _)| *name)
    }

    /// The text of a built-in world, to start one's own from.
    pub fn builtin_text(name: &str) -> Option<&'static str> {
        WORLDS.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    fn parse_builtin(name: &str) -> Option<Result<World, WorldError>> {
        Some(World::parse(Self::builtin_text(name)?, &format!("{name}.toml")))
    }
}
