//! Files of worlds, robots and modules: they are taken, or refused with the file and a place in it.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rpl_protocol::module::manifest::Manifest;
use rpl_robot::description::RobotDescription;
use rpl_robot::file_text::FileFaults;
use rpl_robot::world::World;

fn told<T>(read: Result<T, FileFaults>) {
    if let Err(faults) = read {
        let told = faults.to_string();
        assert!(told.contains("file.toml:"), "it is not told where: {told}");
    }
}

fuzz_target!(|text: &str| {
    told(World::parse(text, "file.toml"));
    told(RobotDescription::parse(text, "file.toml"));
    told(Manifest::parse(text, "file.toml"));
});
