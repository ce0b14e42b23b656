//! `rpl localize`: the filter on a recorded drive, in windows, as a table and a figure.

mod arguments;
mod figure;
mod findings;
mod log_file;
mod mcap_log;
mod mcap_messages;
mod once;
mod table;
mod topics;
mod windows;

use anyhow::{Context, Result, anyhow, bail};
pub use arguments::Arguments;
use findings::Findings;
use log_file::Log;
use mcap_log::{McapDrive, McapReader};
use rpl_experiments::chart;
use rpl_robot::geometry::Vector;
use rpl_robot::localization::{Calibration, LocalizationModel, LocalizationParameters};
use rpl_robot::occupancy::{Cell, OccupancyGrid};
use rpl_robot::recording::{BeamChoice, Recording, fit_odometry, fit_sensor, localize};
use rpl_shell::files::maps::MapFile;
use rpl_shell::files::outputs::{OutputFile, OutputFolder};
use rpl_shell::files::shown::Shown;
use rpl_shell::files::{inputs, maps, robot_files, world_files};
use rpl_shell::interrupt;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use rpl_shell::terminal::progress;
use std::ops::ControlFlow;
use std::time::Instant;
use windows::{Placed, Timed, windows};

/// A log belongs to a map if this share of its poses lies on free space.
const ON_THE_MAP: f64 = 0.5;

/// Cells of the map of a world, as `rpl worlds --map` writes it.
const WORLD_CELL_M: f64 = 0.05;

/// Runs the trials, or fits the parameters.
///
/// # Errors
/// A file that is missing or has faults, a log that does not belong to the map, a grid that does not
/// fit into memory, no beams or windows, a result that cannot be written.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let map = map(arguments, console)?.around_free();
    let recording = read_log(arguments, console)?;
    check_on_map(&recording, &map, arguments)?;
    let beams = BeamChoice::spread(&recording.geometry, arguments.beams)?;
    let mut parameters = parameters(arguments, beams.bearings_deg.clone())?;
    if let Some(range_m) = recording.range_m {
        let beam = &mut parameters.sensors[0].beam;
        beam.max_range_m = beam.max_range_m.min(range_m);
    }
    parameters.check().map_err(|error| anyhow!("{error}"))?;
    if let Some(count) = arguments.once {
        return once::run(arguments, count, &map, &recording, &parameters, console);
    }
    let size_m = Vector::new(map.columns as f64, map.rows as f64) * map.resolution_m;
    let needed = LocalizationModel::needed_bytes(size_m, &parameters);
    let allowed = (arguments.memory * f64::from(1 << 30)) as u64;
    if needed > allowed {
        let gib = |bytes: u64| bytes as f64 / f64::from(1 << 30);
        bail!(
            "the belief over this map would take {:.1} GiB, more than the {:.1} GiB of --memory; \
             allow more, or set a larger `cell_m` or `angle_step_deg` with --parameters",
            gib(needed),
            gib(allowed)
        );
    }
    if let Some(path) = &arguments.fit {
        let file = OutputFile::open(path, "the parameters")?;
        return fit(file, LocalizationModel::new(&map, parameters)?, &recording, &beams, console);
    }
    let windows = windows(arguments, &recording)?;
    let figures = arguments.figures.as_deref();
    let figures =
        figures.map(|path| OutputFolder::open_for(path, "localize", &[PATHS, ERRORS, CERTAINTY])).transpose()?;
    let model = LocalizationModel::new(&map, parameters)?;
    let wanted = windows.len();
    let trials = all_trials(arguments, console, &model, &recording, &beams, windows)?;
    let used = model.parameters.calibration.clone().unwrap_or_else(|| Calibration::new(&[]));
    let findings = Findings::of(&trials, &used);
    if let Some(mut folder) = figures {
        folder.draw(PATHS, &figure::paths(&map, &trials))?;
        folder.draw(ERRORS, &figure::errors(&trials))?;
        folder.draw(CERTAINTY, &chart::reliability(&findings.certainty.bins))?;
    }
    if arguments.json {
        console.print(&table::json(&trials, &findings))?;
    } else {
        table::summary(&findings, arguments.start()).iter().try_for_each(|block| console.block(block))?;
    }
    if trials.len() < wanted {
        console.note(&format!("interrupted: {} of {wanted} windows are done", trials.len()));
        return Ok(Status::Interrupted);
    }
    let all_found = trials.iter().all(|timed| timed.trial.succeeded);
    Ok(if all_found { Status::Succeeded } else { Status::Failed })
}

/// The map that is named, or that of the world that is.
fn map(arguments: &Arguments, console: &mut Console) -> Result<OccupancyGrid> {
    let Some(path) = &arguments.map else {
        let world = arguments.world.as_deref().unwrap_or_default();
        let robot = robot_files::named(None)?;
        return Ok(world_files::for_all_seeds(world, &robot)?.map(WORLD_CELL_M));
    };
    let MapFile { grid, warnings } = maps::ros_map(path)?;
    for warning in warnings {
        console.note(&warning);
    }
    Ok(grid)
}

/// Names of the figures.
const PATHS: &str = "paths.svg";
const ERRORS: &str = "errors.svg";
const CERTAINTY: &str = "certainty.svg";

fn read_log(arguments: &Arguments, console: &mut Console) -> Result<Recording> {
    let name = arguments.log.shown();
    let fault = || format!("the log `{name}` has a fault");
    let mut reader = McapReader::default();
    if arguments.log.is_dir() {
        for file in log_file::in_folder(&arguments.log)? {
            match log_file::read(&file)? {
                Log::Mcap(bytes) => {
                    reader.read(&bytes).with_context(|| format!("the log `{}` has a fault", file.shown()))?;
                }
                Log::Carmen(_) => bail!("`{}` is no MCAP file; name a log, or a folder with MCAP alone", file.shown()),
            }
        }
    } else {
        match log_file::read(&arguments.log)? {
            Log::Mcap(bytes) => reader.read(&bytes).with_context(fault)?,
            Log::Carmen(text) => return carmen(&text, arguments),
        }
    }
    let McapDrive { recording, notes } = reader.drive(arguments.topics(), arguments.mount).with_context(fault)?;
    notes.iter().for_each(|note| console.note(note));
    Ok(recording)
}

fn carmen(text: &str, arguments: &Arguments) -> Result<Recording> {
    let name = arguments.log.shown();
    let topics = [("--scan", &arguments.scan), ("--odom", &arguments.odom), ("--truth", &arguments.truth)];
    if let Some((option, _)) = topics.iter().find(|(_, topic)| topic.is_some()) {
        bail!("`{option}` names a topic, and the log `{name}` is a text of CARMEN, which has none; leave it out");
    }
    Recording::parse_carmen(text, &arguments.laser()).map_err(|error| anyhow!("the log `{name}` has a fault: {error}"))
}

fn check_on_map(recording: &Recording, map: &OccupancyGrid, arguments: &Arguments) -> Result<()> {
    let off: Vec<usize> = (recording.scans.iter())
        .filter(|scan| map.at(scan.laser_in_map.point()) != Cell::Free)
        .map(|scan| scan.line)
        .collect();
    let total = recording.scans.len();
    if (total - off.len()) as f64 >= ON_THE_MAP * total as f64 {
        return Ok(());
    }
    let first = off.first().copied().unwrap_or(0);
    let far = |cells: usize| cells as f64 * map.resolution_m;
    let origin = map.origin_in_frame;
    bail!(
        "the log `{}` does not belong to the map `{}`: {} of its {total} corrected poses (the first in line {first}) \
         are not on the map's free space, which lies within ({:.1}, {:.1}) and ({:.1}, {:.1})",
        arguments.log.shown(),
        arguments.map_name(),
        off.len(),
        origin.x,
        origin.y,
        origin.x + far(map.columns),
        origin.y + far(map.rows)
    )
}

/// The parameters, for scans of these beams.
fn parameters(arguments: &Arguments, beams_deg: Vec<i32>) -> Result<LocalizationParameters> {
    let Some(path) = &arguments.parameters else { return Ok(LocalizationParameters::recorded(beams_deg)) };
    let name = path.shown();
    let text = inputs::short_text(path).map_err(|reason| anyhow!("cannot read the parameters `{name}`: {reason}"))?;
    let mut parameters: LocalizationParameters = serde_json::from_str(&text)
        .with_context(|| format!("`{name}` is no file of parameters; write one with `rpl localize --fit {name}`"))?;
    let [laser] = parameters.sensors.as_mut_slice() else {
        bail!("the parameters `{name}` have {} `sensors`; a recorded drive has one", parameters.sensors.len());
    };
    laser.beams_deg = beams_deg;
    Ok(parameters)
}

/// Fits sensor and odometry and writes the parameters.
fn fit(
    file: OutputFile,
    model: LocalizationModel,
    recording: &Recording,
    beams: &BeamChoice,
    console: &mut Console,
) -> Result<Status> {
    let beam = fit_sensor(&model, recording, beams)?;
    let odometry = fit_odometry(recording)?;
    console.print(&table::fitted(&beam, &odometry))?;
    let mut parameters = LocalizationParameters { odometry, ..model.parameters };
    parameters.sensors[0].beam = beam;
    let text = serde_json::to_string_pretty(&parameters)?;
    file.write((text + "\n").as_bytes())?;
    Ok(Status::Succeeded)
}

/// The trials in all windows, each told as soon as it is done. A signal leaves out the one under way and those after it.
fn all_trials(
    arguments: &Arguments,
    console: &mut Console,
    model: &LocalizationModel,
    recording: &Recording,
    beams: &BeamChoice,
    windows: Vec<Placed>,
) -> Result<Vec<Timed>> {
    let _ends_with_this = interrupt::ends_experiment();
    let scans: usize = windows.iter().map(|placed| placed.window.scans.len()).sum();
    let bar = progress::bar(scans as u64, "{bar:30} {pos}/{len} scans {eta}", console);
    let table = table::table();
    let mut tell = |line: String| {
        bar.suspend(|| match arguments.json {
            true => {
                console.note(&line);
                Ok(())
            }
            false => console.say(&line),
        })
    };
    tell(table.head_text())?;
    let mut trials = Vec::with_capacity(windows.len());
    for (index, Placed { phase, window }) in windows.into_iter().enumerate() {
        let began = Instant::now();
        let after_scan = || {
            bar.inc(1);
            if interrupt::is_asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let Some(trial) = localize(model, recording, beams, &window, arguments.start(), after_scan) else { break };
        let last = recording.scans[window.scans.clone()].last();
        let timed = Timed {
            phase,
            ends_s: last.and_then(|scan| scan.stamp_s),
            window,
            trial,
            wall_s: began.elapsed().as_secs_f64(),
        };
        tell(table.row_text(&table::row(index, &timed)))?;
        trials.push(timed);
    }
    bar.finish_and_clear();
    Ok(trials)
}
