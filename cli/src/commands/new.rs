//! `rpl new NAME`: a folder with a plan, its tests, a scenario and `rpl.toml`, that runs as it is.

use anyhow::{Result, anyhow, bail};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use rpl_shell::arguments::completion;
use rpl_shell::files::project_file::PROJECT_FILE;
use rpl_shell::files::shown::Shown;
use rpl_shell::files::{outputs, robot_files, world_files};
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::fs;
use std::path::{Path, PathBuf};

/// The plan of a project, and the texts that are put into it.
const PLAN: &str = include_str!("new/main.rpl");
const TESTS: &str = include_str!("new/tests.rpl");
const SCENARIO: &str = include_str!("new/turned.rpl");
const README: &str = include_str!("new/README.md");

/// What commands write into a project, and nobody keeps.
const GITIGNORE: &str = "*.jsonl\n*.mcap\n*.part\nfigures/\njournal/\nresults/\n";
const NAME: &str = "NAME";
const PLACE: &str = "PLACE";
const WORLD: &str = "WORLD";

/// Create a project: a folder with a plan, tests, a scenario and `rpl.toml`
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Folder to create
    #[arg(value_name = "NAME", value_hint = ValueHint::DirPath)]
    name: PathBuf,
    /// World that the robot is in: a built-in name, or a .toml file, which is copied into the project
    #[arg(long, value_name = "W", default_value = "test-room", add = ArgValueCompleter::new(completion::worlds))]
    world: String,
}

/// Makes the project. What is there already stays as it is.
///
/// # Errors
/// There is such a folder with something in it, no such world, one without a place to drive to, or nothing can be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let folder = &arguments.name;
    let shown = folder.shown();
    if fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()) || folder.is_file() {
        bail!("`{shown}` is there already, and nothing in it is overwritten; name another folder");
    }
    let world = world_files::named(&arguments.world, &*robot_files::named(None)?, 1)?;
    let Some(place) = world.places.last().map(|place| place.name.clone()) else {
        bail!("the world `{}` has no place to drive to; choose one with places, such as `test-room`", world.name);
    };
    let is_file = Path::new(&arguments.world).extension().is_some_and(|extension| extension == "toml");
    let world = if is_file { "world.toml" } else { arguments.world.as_str() };
    let name = folder.file_name().unwrap_or_default().to_string_lossy();
    let filled = |text: &str| text.replace(NAME, &name).replace(PLACE, &place).replace(WORLD, world);
    let project = format!(
        "# What commands take for the plans of this folder.\nplan = \"main.rpl\"\nworld = \"{world}\"\n\
         # robot = \"b21\"          # `rpl robots`\n\
         # scenario = \"turned.rpl\"\n\
         scenarios = [\"turned.rpl\"]\n\
         # seed = 1\n"
    );
    let mut files = vec![
        ("main.rpl", filled(PLAN)),
        ("tests.rpl", filled(TESTS)),
        ("turned.rpl", SCENARIO.to_string()),
        ("README.md", filled(README)),
        (".gitignore", GITIGNORE.to_string()),
        (PROJECT_FILE, project),
    ];
    if is_file {
        files.push(("world.toml", world_files::text(&arguments.world, 1)?));
    }
    fs::create_dir_all(folder).map_err(|error| anyhow!("cannot make the folder `{shown}`: {error}"))?;
    for (name, text) in files {
        let path = folder.join(name);
        outputs::write_new(&path, &text, false).map_err(|why| anyhow!("cannot write `{}`: {why}", path.shown()))?;
    }
    let told = format!(
        "`{shown}` has a plan, main.rpl, that drives to `{place}`, tests of it, tests.rpl, and a scenario, turned.rpl. \
         In that folder,\n\
         \x20 rpl run     runs the plan in the world that rpl.toml names\n\
         \x20 rpl test    runs the tests\n\
         \x20 rpl check   looks for faults without running anything"
    );
    console.explain_hanging(&told, 0)?;
    Ok(Status::Succeeded)
}
