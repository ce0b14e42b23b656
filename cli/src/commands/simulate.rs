//! `rpl simulate`: our simulator as a host in a process of its own, at the pace of the clock on the wall.

use crate::commands::run::parse_factor;
use anyhow::{Context, Result};
use clap_complete::engine::ArgValueCompleter;
use rpl_drive::show::service::{ServiceSummary, notice_line};
use rpl_link::tcp_server::{Service, serve};
use rpl_mission::site::Setup;
use rpl_protocol::host::SILENCE_US;
use rpl_robot::office::OfficeSettings;
use rpl_shell::arguments::completion;
use rpl_shell::arguments::duration::parse_duration_us;
use rpl_shell::arguments::token::TokenArgument;
use rpl_shell::files::{plans, robot_files, world_files};
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use rpl_shell::{interrupt, sites};
use std::net::TcpListener;
use std::time::Duration;

/// Serve the simulated robot to a mission in another process (`rpl run --host`), in real time
///
/// The world waits for the first commands of the first mission. The robot stops when no commands come for
/// 0.3 s, or when the mission disconnects. Then another mission can take over.
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// World that the robot is in: a built-in name or a .toml file
    #[arg(long, value_name = "W", add = ArgValueCompleter::new(completion::worlds))]
    pub world: String,
    /// Robot: a built-in name or a .toml file (default: b21)
    #[arg(long, value_name = "R", add = ArgValueCompleter::new(completion::robots))]
    pub robot: Option<String>,
    /// A scenario: a second plan that disturbs the world (turns the robot, closes doors, sends messages)
    #[arg(long, value_name = "FILE", add = ArgValueCompleter::new(completion::scenarios))]
    pub scenario: Option<String>,
    /// Seed of the noise of sensors and wheels, and of people
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// Address where missions connect; with port 0 the system chooses one, and the first line says which
    #[arg(long, value_name = "ADDRESS", default_value = "127.0.0.1:7300")]
    pub listen: String,
    /// Run FACTOR times as fast as real time
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0, value_parser = parse_factor)]
    pub speed: f64,
    /// Stop at this time of the world, such as 90s or 5min
    #[arg(long, value_name = "TIME", value_parser = parse_duration_us)]
    pub until: Option<u64>,
    /// Release the robot if a mission gives no commands for this time, for example at a stopped prompt
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = parse_patience_us)]
    pub patience: u64,
    #[command(flatten)]
    pub token: TokenArgument,
    /// Exit when the first mission has disconnected
    #[arg(long)]
    pub once: bool,
    /// Print one JSON object to standard output at the end
    #[arg(long)]
    pub json: bool,
}

/// How long a mission may be silent.
///
/// # Errors
/// It is no time, or shorter than the silence for which the motors are cut.
fn parse_patience_us(text: &str) -> Result<u64, String> {
    match parse_duration_us(text)? {
        short if short < SILENCE_US => Err("it is 300ms at least: only then are the motors cut".to_string()),
        patience => Ok(patience),
    }
}

/// Serves the world until it is told to stop.
///
/// # Errors
/// The world or the scenario is wrong, or nobody can be listened to.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let robot = robot_files::named(arguments.robot.as_deref())?;
    let world = world_files::named(&arguments.world, &robot, arguments.seed)?;
    let scenario = arguments.scenario.as_deref().map(plans::scenario).transpose()?;
    // The host needs no map: it has the world.
    let settings = OfficeSettings { map_known: false, ..OfficeSettings::of(robot.clone()) };
    let setup = Setup { world: Some(world), settings, ..Setup::default() };
    let site = sites::build(setup, scenario, Vec::new())?;
    let mut host = site.office_robot(arguments.seed).context("a world has a robot")?.host;
    let service = Service {
        robot: robot.name.clone(),
        period_us: robot.step_us,
        factor: arguments.speed,
        until_us: arguments.until,
        once: arguments.once,
        start_known: true,
        patience: Duration::from_micros(arguments.patience),
        token: arguments.token.read()?,
    };
    let cannot_listen = || format!("cannot listen at `{}`", arguments.listen);
    let listener = TcpListener::bind(&arguments.listen).with_context(cannot_listen)?;
    console.print(&format!("listening at {}", listener.local_addr().with_context(cannot_listen)?))?;
    console.flush()?;
    let record = {
        // A signal ends the service and is no reason to hurry: the summary is told.
        let _ends = interrupt::gives_prompt_back();
        let mut tell = |notice| console.note(&notice_line(&notice));
        serve(&mut host, listener, service, &interrupt::is_asked, &mut tell).with_context(cannot_listen)?
    };
    let summary = ServiceSummary::new(&host.state, &record);
    console.note(&summary.told());
    if arguments.json {
        console.print(&summary.as_json()?)?;
    }
    console.flush()?;
    Ok(Status::Succeeded)
}
