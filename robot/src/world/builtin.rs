//! The worlds in the binary.

use super::{World, WorldError};

const WORLDS: [(&str, &str); 5] = [
    ("dept", include_str!("../../worlds/dept.toml")),
    (
        "dept-furnished",
        concat!(include_str!("../../worlds/dept.toml"), include_str!("../../worlds/dept-furnished.toml")),
    ),
    ("corridor", include_str!("../../worlds/corridor.toml")),
    ("sensing", concat!(include_str!("../../worlds/corridor.toml"), include_str!("../../worlds/sensing.toml"))),
    ("test-room", include_str!("../../worlds/test-room.toml")),
];

impl World {
    /// A world by its name: `dept`, the department of Beetz, Burgard, Fox and Cremers;
    /// `dept-furnished`, the same with people, and furniture that is in no map; `corridor`, its
    /// corridor with all doors closed; `sensing`, that corridor with a box only the sonars see;
    /// `test-room`, two small rooms for quick trials.
    pub fn builtin(name: &str) -> Option<World> {
        let mut world = Self::parse_builtin(name)?.ok()?;
        // The text of `dept-furnished` begins with that of `dept`, that of `sensing` with `corridor`.
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
