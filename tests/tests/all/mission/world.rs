//! Small worlds, and what is asserted of most runs.

use rpl_mission::modules::SiteRobot;
use rpl_robot::office::OfficeModel;
use rpl_robot::world::World;
use rpl_runtime::run::system::System;
use rpl_tests::mission::{Grid, model};
use std::sync::{Arc, OnceLock};

/// The test room with the door between its rooms closed, on the map as well.
pub fn closed_room() -> Arc<OfficeModel> {
    static MODEL: OnceLock<Arc<OfficeModel>> = OnceLock::new();
    let build = || {
        let text = World::builtin_text("test-room").expect("built in").replace("open = true", "open = false");
        model(World::parse(&text, "closed.toml").expect("as good as the original"), Grid::Coarse.settings())
    };
    MODEL.get_or_init(build).clone()
}

/// Nobody holds the wheels, and nobody waits for them.
pub fn wheels_are_free(system: &System<SiteRobot>) -> bool {
    let machine = &system.machine;
    let wheels = machine.valves.iter().find(|valve| machine.symbols.name(valve.name) == "wheels").expect("a valve");
    wheels.waiters.is_empty() && wheels.places().all(|place| machine.places[place as usize].is_at_rest())
}
