//! `rpl test FILE...`: runs the tests in plans, each in a system of its own.

mod junit;
mod report;

use anyhow::{Context, Result, bail};
use clap::ValueHint;
use clap_complete::engine::ArgValueCompleter;
use report::{FaultyFile, TestRecord, TestReport};
use rpl_drive::observed::RunEnd;
use rpl_drive::run_driver::{Pace, drive};
use rpl_drive::run_record::Records;
use rpl_drive::show::failure_report::{FailureRecord, Reporter, SCENARIO_FAILED};
use rpl_lang::compile::Test;
use rpl_lang::diagnostic::render;
use rpl_mission::robot::Robot;
use rpl_mission::site::{Setup, Site};
use rpl_protocol::module::process_modules::ModuleSource;
use rpl_robot::description::RobotDescription;
use rpl_robot::office::OfficeSettings;
use rpl_runtime::run::library::{Loaded, Rejected};
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::time::{LAST_INSTANT_US, microseconds};
use rpl_shell::arguments::duration::parse_duration_us;
use rpl_shell::arguments::site::FIRST_SEED;
use rpl_shell::arguments::{completion, plan_files};
use rpl_shell::files::module_files::{self, GoingBack, ModuleVoices};
use rpl_shell::files::outputs::OutputFile;
use rpl_shell::files::plans::{self, PlanText};
use rpl_shell::files::project_file::{Project, ProjectFile};
use rpl_shell::files::roles::{self, Role, Roles};
use rpl_shell::files::{robot_files, world_files};
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use rpl_shell::{interrupt, sites};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;

/// Run the tests in plans
#[derive(clap::Args, Clone, Debug)]
pub struct Arguments {
    /// Plan files with `deftest` forms, folders with plans, or the `rpl.toml` of a project; `-` for standard input
    /// (default: the plans and the world of the nearest `rpl.toml`, in this folder or above)
    #[arg(value_name = "FILE", add = ArgValueCompleter::new(completion::plans))]
    files: Vec<String>,
    /// Run only the tests whose name contains this text
    #[arg(long, value_name = "TEXT")]
    filter: Option<String>,
    /// World of the tests that name none
    #[arg(long, value_name = "W", add = ArgValueCompleter::new(completion::worlds))]
    world: Option<String>,
    /// Robot: a built-in name or a .toml file (default: b21)
    #[arg(long, value_name = "R", add = ArgValueCompleter::new(completion::robots))]
    robot: Option<String>,
    /// Manifest of a module in another process, for the tests in a world; can be repeated
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    module: Vec<String>,
    /// Whether they were named elsewhere than on the command line, so that it is told what is started.
    #[arg(skip)]
    tells_modules: bool,
    /// Seed of the tests that name none (default: 1)
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Time limit of the tests that name none, in the plan's time
    #[arg(long, value_name = "TIME", value_parser = parse_duration_us, default_value = "1h")]
    until: u64,
    /// Print one JSON object to standard output instead
    #[arg(long)]
    json: bool,
    /// Also write a report to this file, as JUnit XML
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    junit: Option<PathBuf>,
}

/// The arguments, with what the project of the files says. What they say themselves holds.
fn in_project(arguments: &Arguments, console: &mut Console) -> Result<(Arguments, Option<ProjectFile>)> {
    let mut arguments = arguments.clone();
    let Some(project) = Project::of(&arguments.files, ("test", "test"), console)? else {
        return Ok((arguments, None));
    };
    if project.is_meant {
        arguments.files = vec![project.folder()];
    }
    let says = project.says;
    arguments.world = arguments.world.or_else(|| says.world.clone());
    arguments.robot = arguments.robot.or_else(|| says.robot.clone());
    if arguments.module.is_empty() {
        arguments.module.clone_from(&says.modules);
        arguments.tells_modules = true;
    }
    arguments.seed = arguments.seed.or(says.seed);
    Ok((arguments, Some(says)))
}

/// Runs the tests of all files.
///
/// # Errors
/// There is no test, or no file and no project, or standard output is closed.
pub fn run(arguments: &Arguments, console: &mut Console) -> Result<Status> {
    let (arguments, project) = &in_project(arguments, console)?;
    let junit = arguments.junit.as_deref().map(|path| OutputFile::open(path, "the report")).transpose()?;
    let _stops = interrupt::stops_runs();
    let began = Instant::now();
    let files = plan_files::named(&arguments.files);
    let colour = console.out_colour();
    let robot = robot_files::named(arguments.robot.as_deref())?;
    let (modules, sources) = module_files::named(&arguments.module, ModuleVoices::Processes(GoingBack::Never))?;
    let mut session = TestSession {
        arguments,
        robot,
        colour,
        is_one: false,
        sites: BTreeMap::new(),
        without_world: Site::without_world(sources.clone())?,
        modules: sources,
        starts_modules: false,
        report: TestReport::default(),
    };
    let texts: Vec<_> = files.iter().map(read).collect();
    refuse_tests_as_files(&files, &arguments.files, &texts)?;
    let roles = Roles::of(project.as_ref(), texts.iter().flatten());
    // Scenarios and the plans of modules have no tests, and cannot be read as plans.
    let is_plan = |(_, text): &(_, Result<PlanText, String>)| {
        text.as_ref().map_or(true, |text| roles.role(&text.name) == Role::Plan)
    };
    let (files, plans): (Vec<_>, Vec<_>) = files.into_iter().zip(texts).filter(is_plan).unzip();
    session.is_one = files.len() == 1;
    // Nothing is started for texts that have errors.
    session.starts_modules = !session.modules.is_empty() && session.are_all_right(&plans);
    if session.starts_modules && arguments.tells_modules {
        modules.tell(console);
    }
    for (name, plan) in files.into_iter().zip(plans) {
        match plan {
            Ok(plan) => session.file(&plan, console)?,
            // The tests of the other files can still run.
            Err(reason) => {
                console.note(&format!("error: {reason}"));
                session.report.faulty_files.push(FaultyFile { file: name.unwrap_or_default(), reason });
            }
        }
        if interrupt::is_asked() {
            break;
        }
    }
    let mut report = session.report;
    report.interrupted = interrupt::is_asked();
    report.wall_s = to_milliseconds(began);
    if let Some(file) = junit {
        file.write(junit::xml(&report).as_bytes())?;
    }
    if arguments.json {
        console.print(&serde_json::to_string(&report).context("the report cannot be written as JSON")?)?;
    } else if !report.tests.is_empty() {
        console.print(&report.summary())?;
    }
    if report.interrupted {
        return Ok(Status::Interrupted);
    }
    let is_wrong = !report.faulty_files.is_empty();
    if report.tests.is_empty() && !is_wrong {
        match &arguments.filter {
            Some(filter) => bail!("no test has a name with `{filter}` in it"),
            None => bail!("there is no test: `(deftest NAME FORM...)` at the top level of a plan makes one"),
        }
    }
    Ok(match (is_wrong, report.failed) {
        (true, _) => Status::Wrong,
        (false, 0) => Status::Succeeded,
        (false, _) => Status::Failed,
    })
}

/// Tells a name among the files that is the name of a test in one of them.
fn refuse_tests_as_files(
    files: &[Result<String, String>],
    named: &[String],
    texts: &[Result<PlanText, String>],
) -> Result<()> {
    let missing = files.iter().zip(texts).filter(|(_, text)| text.is_err()).filter_map(|(file, _)| file.as_ref().ok());
    for name in missing {
        let mut known = texts.iter().flatten();
        let defines = |text: &str| {
            let behind = text.split("(deftest").skip(1).map(str::trim_start);
            let words = behind.map(|rest| rest.split(|c: char| c.is_whitespace() || c == ')').next());
            words.into_iter().any(|word| word == Some(name.as_str()))
        };
        if let Some(plan) = known.find(|plan| defines(&plan.text)) {
            let others: Vec<&str> = named.iter().map(String::as_str).filter(|other| other != name).collect();
            let others = if others.is_empty() { plan.name.clone() } else { others.join(" ") };
            bail!("`{name}` is a test of `{}`, and no file: write `rpl test {others} --filter {name}`", plan.name);
        }
    }
    Ok(())
}

/// Seconds since then.
fn to_milliseconds(began: Instant) -> f64 {
    (began.elapsed().as_secs_f64() * 1e3).round() / 1e3
}

/// The world of a test with the seed it is drawn from, 0 if it is drawn from none, and the scenario.
type TestPlace = (Option<String>, u64, Option<String>);

struct TestSession<'a> {
    arguments: &'a Arguments,
    robot: Arc<RobotDescription>,
    colour: bool,
    /// The name of a single file need not be told.
    is_one: bool,
    /// Building the models of a world takes longer than most tests.
    sites: BTreeMap<TestPlace, Site>,
    /// Where tests run that name no world.
    without_world: Vec<Site>,
    /// Those in other processes, and whether they may be started.
    modules: Vec<ModuleSource>,
    starts_modules: bool,
    report: TestReport,
}

/// A text that is named, or why it cannot be read.
fn read(name: &Result<String, String>) -> Result<PlanText, String> {
    name.as_ref().map_err(Clone::clone).and_then(|name| plans::plan(name).map_err(|error| format!("{error:#}")))
}

impl TestSession<'_> {
    /// Whether all texts are there, and none has an error.
    fn are_all_right(&self, plans: &[Result<PlanText, String>]) -> bool {
        for plan in plans {
            let Ok(plan) = plan else { return false };
            if load_without_world(plan, &self.without_world).is_err() {
                return false;
            }
        }
        true
    }

    /// Runs the tests of a file.
    fn file(&mut self, plan: &PlanText, console: &mut Console) -> Result<()> {
        let (site, loaded) = match load_without_world(plan, &self.without_world) {
            Ok(found) => found,
            Err(rejected) => {
                console.note(rejected.render(console.colour).trim_end());
                let reason = rejected.render(false).trim_end().to_string();
                self.report.faulty_files.push(FaultyFile { file: plan.name.clone(), reason });
                return Ok(());
            }
        };
        if !loaded.warnings.is_empty() {
            console.note(render(&loaded.warnings, &loaded.program.sources, console.colour).trim_end());
        }
        let filter = self.arguments.filter.as_deref().unwrap_or_default();
        let tests: Vec<&Test> = loaded.tests.iter().filter(|test| test.name.contains(filter)).collect();
        let width = tests.iter().map(|test| test.name.chars().count()).max().unwrap_or(0);
        if !self.is_one && !tests.is_empty() && !self.arguments.json {
            console.explain(&plan.name)?;
        }
        for test in tests {
            let record = self.test(plan, test, (&site, &loaded))?;
            if record.outcome == "interrupted" {
                return Ok(());
            }
            self.report.succeeded += usize::from(record.has_succeeded());
            self.report.failed += usize::from(!record.has_succeeded());
            if !self.arguments.json {
                self.tell(&record, width, console)?;
            }
            self.report.tests.push(record);
            if interrupt::is_asked() {
                break;
            }
        }
        Ok(())
    }

    /// Runs a test in its world, or else where its file was compiled. What keeps it from running is
    /// its failure; the others can still run.
    fn test(&mut self, plan: &PlanText, test: &Test, without_world: (&Site, &Loaded)) -> Result<TestRecord> {
        let world = test.options.world.as_deref().map(str::to_string).or_else(|| self.arguments.world.clone());
        let scenario = test.options.scenario.as_deref().map(|scenario| roles::beside(&plan.name, scenario));
        let (site, loaded) = without_world;
        if !self.modules.is_empty() && !self.starts_modules {
            let reason = "it cannot run: its modules are not started while there are texts with errors";
            return Ok(self.never_run(test, loaded, world, reason));
        }
        if world.is_none() && scenario.is_none() {
            return self.run_test(site, loaded.clone(), test, None);
        }
        let is_drawn = world.as_deref().is_some_and(world_files::is_drawn);
        let drawn_from = if is_drawn { self.seed_of(test) } else { 0 };
        match self.set_up(plan, (world.clone(), drawn_from, scenario)) {
            Ok((site, loaded)) => self.run_test(&site, loaded, test, world),
            Err(error) => Ok(self.never_run(test, loaded, world, &format!("it cannot run: {error:#}"))),
        }
    }

    fn set_up(&mut self, plan: &PlanText, place: TestPlace) -> Result<(Site, Loaded)> {
        let site = self.site(place)?;
        match site.library.load(&plan.name, &plan.text, &mut plan.folder.clone()) {
            Ok(loaded) => Ok((site, loaded)),
            // With a robot, names of the file's own may be the robot's.
            Err(rejected) => bail!("in a world its text is wrong\n{}", rejected.render(self.colour).trim_end()),
        }
    }

    fn never_run(&self, test: &Test, loaded: &Loaded, world: Option<String>, reason: &str) -> TestRecord {
        let (file, line) = place(test, loaded);
        TestRecord {
            name: test.name.to_string(),
            file,
            line,
            outcome: "failed",
            time_s: 0.0,
            wall_s: 0.0,
            seed: self.seed_of(test),
            world,
            failure: Some(FailureRecord::of_set_up(reason)),
            output: Vec::new(),
            reason: reason.to_string(),
        }
    }

    fn seed_of(&self, test: &Test) -> u64 {
        test.options.seed.unwrap_or(self.arguments.seed.unwrap_or(FIRST_SEED))
    }

    fn site(&mut self, place: TestPlace) -> Result<Site> {
        if let Some(site) = self.sites.get(&place) {
            return Ok(site.clone());
        }
        let (world, seed, scenario) = &place;
        let world = world.as_deref().map(|name| world_files::named(name, &self.robot, *seed)).transpose()?;
        let scenario = scenario.as_deref().map(plans::scenario).transpose()?;
        let settings = OfficeSettings::of(self.robot.clone());
        let site = sites::build(Setup { world, settings, ..Setup::default() }, scenario, self.modules.clone())?;
        self.sites.insert(place, site.clone());
        Ok(site)
    }

    fn run_test(&self, site: &Site, mut loaded: Loaded, test: &Test, world: Option<String>) -> Result<TestRecord> {
        // The same text at another site: its tests are the same but for the numbers of their code.
        let code = loaded.tests.iter().find(|known| known.name == test.name).map_or(test.code, |known| known.code);
        loaded.main = code;
        let (file, line) = place(test, &loaded);
        let seed = self.seed_of(test);
        let until_us = match test.options.until_s {
            // The clock goes no further.
            Some(until_s) => microseconds(until_s).unwrap_or(LAST_INSTANT_US),
            None => self.arguments.until,
        };
        let mut system = site.start(loaded, seed);
        let mut output = Console::keeping();
        let began = Instant::now();
        let pace = Pace { until_us: Some(until_us), factor: Pace::factor_at(site, None), ..Pace::default() };
        let ending = drive(&mut system, pace, &mut output, &mut Records::default())?;
        let (outcome, failure, reason) = self.judge(&system, ending, until_us);
        let reason = match world {
            None if site.lacks_world() && failure.as_ref().is_some_and(FailureRecord::may_miss_robot) => {
                format!(
                    "{reason}\nit ran without a robot: write `:world \"dept\"` behind its name, or add `--world dept`"
                )
            }
            _ => reason,
        };
        Ok(TestRecord {
            name: test.name.to_string(),
            file,
            line,
            outcome,
            time_s: system.machine.now_s(),
            seed,
            world,
            failure,
            output: output.take_kept(),
            wall_s: to_milliseconds(began),
            reason,
        })
    }

    fn judge(
        &self,
        system: &System<Robot>,
        ending: RunEnd,
        until_us: u64,
    ) -> (&'static str, Option<FailureRecord>, String) {
        let colour = self.colour;
        let of_scenario = system.outside.failed_scenario().map(|(scenario, failure)| {
            let reporter = Reporter { machine: &scenario.machine, program: &scenario.program, colour };
            (reporter.record(failure), reporter.text(SCENARIO_FAILED, failure).trim_end().to_string())
        });
        // What a test finds wrong is often what comes of a scenario that has failed before.
        let with_scenario = |reason: String| match &of_scenario {
            Some((_, text)) => format!("{text}\n{reason}"),
            None => reason,
        };
        match ending {
            RunEnd::Outcome(Outcome::Succeeded(_)) => match of_scenario {
                None => ("succeeded", None, String::new()),
                Some((record, text)) => ("failed", record, text),
            },
            RunEnd::Outcome(Outcome::Failed(failure)) => {
                let reporter = Reporter { machine: &system.machine, program: &system.program, colour };
                let reason = reporter.text("", failure).trim_end().to_string();
                ("failed", reporter.record(failure), with_scenario(reason))
            }
            RunEnd::Outcome(Outcome::Evaporated) => ("failed", None, "it was evaporated".to_string()),
            RunEnd::TimeUp => {
                let reason = format!("it had not ended after {} s", until_us as f64 / 1e6);
                ("timeout", None, with_scenario(reason))
            }
            RunEnd::Interrupted | RunEnd::GivenUp => ("interrupted", None, String::new()),
        }
    }

    fn tell(&self, record: &TestRecord, width: usize, console: &mut Console) -> Result<()> {
        let (word, colour) = if record.has_succeeded() { ("ok    ", 32) } else { ("FAILED", 31) };
        let word = if self.colour { format!("\u{1b}[{colour}m{word}\u{1b}[0m") } else { word.to_string() };
        console.explain(&format!("{word}  {:width$}  {:>8.1} s", record.name, record.time_s))?;
        if !record.has_succeeded() {
            let printed = record.output.iter().flat_map(|text| text.lines()).map(|line| format!("printed: {line}"));
            for line in record.reason.lines().map(str::to_string).chain(printed) {
                console.explain(format!("        {line}").trim_end())?;
            }
        }
        Ok(console.flush()?)
    }
}

/// The file and the line a test stands in.
fn place(test: &Test, loaded: &Loaded) -> (String, usize) {
    let sources = &loaded.program.sources;
    let (line, _) = sources.line_column(test.span);
    (sources.get(test.span.source).name.to_string(), line)
}

/// The plan compiled at the first site that has all it needs, or at the last one.
fn load_without_world(plan: &PlanText, sites: &[Site]) -> Result<(Site, Loaded), Rejected> {
    let (last, before) = sites.split_last().expect("one is for checking");
    let load = |site: &Site| {
        let loaded = site.library.load(&plan.name, &plan.text, &mut plan.folder.clone());
        loaded.map(|loaded| (site.clone(), loaded))
    };
    for site in before {
        match load(site) {
            Err(rejected) if rejected.diagnostics.iter().any(|finding| finding.code == "needs-a-world") => {}
            found => return found,
        }
    }
    load(last)
}
