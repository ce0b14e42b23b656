//! `rpl` and `rpl step`: the prompt at which plans are written, run, stopped, looked at, stepped through and taken
//! back. `rpl dap`, the debug adapter, is another front of the same session.
//!
//! The prompt goes back in time with copies of the whole system, and with replay from the last one before the instant
//! (`timeline` of the runtime). At a terminal, lines are edited in a thread of their own and handed in between two
//! instants; so a run paced by the clock stays what it would be without a prompt.
//!
//! Read in this order:
//!
//! - `session` and `runner`: a run, its history, its forks; going on with it;
//! - `command` (the table of the commands) and `forms` (texts handed in);
//! - `steering`, `standpoint`, `timing`: going on; `past`: going back; `projecting`, `future`: looking ahead;
//! - `inspection`, `present`, `listings`: looking; `documenting`, `definitions`, `writing`, `external_editor`: texts;
//! - `vocabulary`, `margins`, `line_editor`, `line_thread`, `live_prompt`, `clock`, `conversation`: a person at a
//!   terminal;
//! - `intervention`, `repetition`: sessions that are repeated; `faults`, `guard`: keeping the prompt alive;
//! - `debugger`.

mod clock;
mod command;
mod conversation;
mod debugger;
mod definitions;
mod documenting;
mod external_editor;
mod faults;
mod forms;
mod future;
mod guard;
mod inspection;
mod intervention;
mod line_editor;
mod line_thread;
mod listings;
mod live_prompt;
mod margins;
mod past;
mod present;
mod projecting;
mod repetition;
mod runner;
mod session;
mod standpoint;
mod steering;
mod timing;
mod vocabulary;
mod writing;

use anyhow::Result;
use clock::Clock;
use command::Verb;
pub use debugger::debug;
use faults::Faults;
pub use intervention::Intervention;
use projecting::Projecting;
use rpl_drive::journal::{KeptText, PastSession, SessionJournal};
use rpl_drive::stopping::halt::Halt;
pub use rpl_drive::stopping::halt::Until;
use rpl_lang::lexer::{Token, lex};
use rpl_lang::reader::{Completeness, completeness};
use rpl_lang::source::SourceId;
use rpl_link::recording::{Recorder, Typed};
use rpl_mission::robot::Robot;
use rpl_mission::site::Site;
use rpl_robot::occupancy::OccupancyGrid;
use rpl_robot::world::World;
use rpl_runtime::state::failure::Failure;
use rpl_shell::files::inputs;
use rpl_shell::files::plans::{self, PlanText};
use rpl_shell::interrupt;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use session::Session;
use std::collections::{BTreeMap, VecDeque};
use std::io::{self, IsTerminal, Read};
use std::sync::Arc;
use std::time::{Duration, Instant};

/// No stretch of a session that is repeated takes this long.
const LONGEST_REPEAT: Duration = Duration::from_secs(24 * 3600);

/// Edge of a cell of the map that `:map` draws.
const MAP_CELL_M: f64 = 0.1;

/// What a session begins with.
pub struct SessionStart {
    /// The world of the site, if it has one.
    pub world: Option<World>,
    /// The robot of the run.
    pub robot: Robot,
    /// The seed of every run.
    pub seed: u64,
    /// A plan that is loaded first.
    pub plan: Option<PlanText>,
    /// How far that plan is run.
    pub until: Until,
    /// Where what is typed is written, if anywhere.
    pub recorder: Option<Arc<Recorder>>,
    /// Where what is typed is written so that the session can be gone on with, if anywhere.
    pub journal: Option<SessionJournal>,
    /// What was typed in the session that is repeated, and what it loaded.
    pub past: PastSession,
    /// What came to the run that is repeated while it stood still.
    pub interventions: Vec<Intervention>,
    /// Whether more is read, from standard input.
    pub reads: bool,
    /// The commands that `:doc` documents beside the names of the language.
    pub command_line: clap::Command,
}

/// Runs a session at a site to the end of standard input.
///
/// # Errors
/// Standard output is closed.
pub fn run(site: &Site, opening: SessionStart, console: &mut Console) -> Result<Status> {
    let SessionStart { world, robot, seed, plan, until, recorder, journal, past, interventions, reads, command_line } =
        opening;
    let places = world.as_ref().map_or_else(Vec::new, |world| {
        let rooms = world.rooms.iter().map(|room| room.name.to_string());
        rooms.chain(world.places.iter().map(|place| place.name.to_string())).collect()
    });
    let map = world.map(|world| world.map(MAP_CELL_M));
    let mut session = Session::new(site, robot, seed)?;
    session.interventions = interventions;
    let mut prompt =
        Prompt { map, places, recorder, command_line, ..Prompt::new(session, console, io::stdin().is_terminal()) };
    let usual = prompt.faults.catch();
    let ended = prompt.all(plan, until, past, journal, reads);
    Faults::let_go(usual);
    ended?;
    prompt.console.flush()?;
    Ok(prompt.worst)
}

/// Whether the session goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AfterLine {
    Another,
    Quit,
}

/// Whether a text has nothing but comments.
fn is_blank(text: &str) -> bool {
    let is_comment = |token| matches!(token, Token::LineComment | Token::BlockComment);
    lex(text, SourceId(0)).0.into_iter().all(|(token, _)| is_comment(token))
}

struct Prompt<'a> {
    session: Session,
    map: Option<OccupancyGrid>,
    /// Names of rooms and places in the world.
    places: Vec<String>,
    command_line: clap::Command,
    console: &'a mut Console,
    /// The clock by which the run goes on while something is typed.
    clock: Option<Clock>,
    /// What is projected while the clock runs.
    projecting: Option<Projecting>,
    /// Somebody sits at a terminal.
    is_interactive: bool,
    /// The stepping command that an empty line repeats.
    repeated: Option<String>,
    /// What the exit status says when nobody sat at the prompt.
    worst: Status,
    /// Where what is typed is written.
    recorder: Option<Arc<Recorder>>,
    /// The same, for a session that is to be gone on with.
    journal: Option<SessionJournal>,
    /// Texts that the session that is repeated has loaded by name.
    plans: VecDeque<KeptText>,
    /// The forms typed last.
    typed: String,
    /// The last failure that was told.
    failure: Option<Failure>,
    /// What was saved, by the name of the file.
    saved: BTreeMap<String, String>,
    faults: Faults,
}

impl<'a> Prompt<'a> {
    /// The prompt of a session without a world, which documents no command.
    fn new(session: Session, console: &'a mut Console, is_interactive: bool) -> Self {
        Self {
            session,
            map: None,
            places: Vec::new(),
            command_line: clap::Command::default(),
            console,
            clock: None,
            projecting: None,
            is_interactive,
            repeated: None,
            worst: Status::Succeeded,
            recorder: None,
            journal: None,
            plans: VecDeque::new(),
            typed: String::new(),
            failure: None,
            saved: BTreeMap::new(),
            faults: Faults::default(),
        }
    }
}

impl Prompt<'_> {
    /// From the file that is loaded first to the end.
    fn all(
        &mut self,
        plan: Option<PlanText>,
        until: Until,
        mut past: PastSession,
        journal: Option<SessionJournal>,
        reads: bool,
    ) -> Result<()> {
        self.session.horizon_us = past.typed.first().map(|typed| typed.time_us);
        self.plans = std::mem::take(&mut past.plans);
        // What somebody has seen is not shown again, but for what was done last.
        let last = past.typed.iter().rposition(|typed| !is_blank(&typed.typed)).filter(|_| journal.is_some());
        self.console.keep(last.is_some());
        if let Some(plan) = plan {
            self.guarded(|prompt| prompt.load(plan, until).map(|()| AfterLine::Another))?;
        }
        self.repeat(&past, last)?;
        self.console.keep(false);
        if let Some(mut journal) = journal {
            journal.knows_loads();
            self.journal = Some(journal);
            self.note_reached();
            if last.is_some() {
                let now_s = self.session.branch.system.machine.now_s();
                self.console.note(&format!("the session goes on at {now_s:.1} s"));
                // What went wrong then was told then.
                self.worst = Status::Succeeded;
            }
        }
        match (reads, self.is_interactive) {
            (false, _) => Ok(()),
            (true, true) => self.converse(),
            (true, false) => self.read_all(),
        }
    }

    /// What was typed takes effect when it did.
    fn repeat(&mut self, past: &PastSession, shown_from: Option<usize>) -> Result<()> {
        let lines = past.typed.iter().enumerate();
        let ends = past.typed.iter().skip(1).map(|next| Some(next.time_us)).chain([None]);
        for ((at, Typed { typed, time_us }), end_us) in lines.zip(ends) {
            if shown_from == Some(at) {
                self.console.keep(false);
            }
            self.session.give_loads(past.loads_at(at + 1));
            // By the clock it came to here.
            let before = Instant::now() + LONGEST_REPEAT;
            let began_us = self.session.branch.system.machine.now_us;
            if began_us < *time_us {
                let halt = self.session.go_on(&Until::Clock { due_us: *time_us, before }, self.console)?;
                if let Halt::Answered(_) = halt {
                    self.halted(halt)?;
                }
            }
            self.session.horizon_us = end_us;
            if is_blank(typed) {
                continue;
            }
            self.console.note(&format!("> {}", typed.trim_end()));
            let is_of_clock = matches!(command::parse(typed), Ok((Verb::Go | Verb::Stop, _))) && typed.starts_with(':');
            if !is_of_clock && self.handle(typed)? == AfterLine::Quit {
                break;
            }
        }
        self.session.horizon_us = None;
        self.session.give_loads(Vec::new());
        Ok(())
    }

    /// Everything from standard input, form by form, without a person.
    fn read_all(&mut self) -> Result<()> {
        let mut bytes = Vec::new();
        io::stdin().read_to_end(&mut bytes)?;
        let text = inputs::text_of(bytes).map_err(|reason| anyhow::anyhow!("cannot read standard input: {reason}"))?;
        let _stops = interrupt::stops_runs();
        let mut waiting = String::new();
        for line in text.lines() {
            let is_command = line.trim_start().starts_with(':');
            // A comment belongs to the form below it, unless a line is left empty between them.
            if is_blank(&waiting) && (is_command || line.trim().is_empty()) {
                waiting.clear();
            }
            if waiting.is_empty() && line.trim().is_empty() {
                continue;
            }
            waiting.push_str(line);
            waiting.push('\n');
            if is_blank(&waiting) {
                continue;
            }
            let is_command = waiting.trim_start().starts_with(':');
            if !is_command && completeness(&waiting) != Completeness::Complete {
                continue;
            }
            if self.handle(&std::mem::take(&mut waiting))? == AfterLine::Quit {
                return Ok(());
            }
            if interrupt::is_asked() {
                return self.stop();
            }
        }
        if !waiting.trim().is_empty() {
            self.handle(&waiting)?;
        }
        if interrupt::is_asked() { self.stop() } else { Ok(()) }
    }

    /// Told to stop where nobody sits at the prompt: what runs is given up.
    fn stop(&mut self) -> Result<()> {
        interrupt::forget();
        if self.session.branch.is_running {
            self.session.give_up(self.console)?;
        }
        self.worst = Status::Interrupted;
        Ok(())
    }

    fn prompt_text(&self) -> String {
        if self.clock.is_some() {
            return self.live_prompt();
        }
        let branch = &self.session.branch;
        let name = if self.session.name == "main" { String::new() } else { format!(" {}", self.session.name) };
        let time = match branch.system.machine.now_us {
            0 => String::new(),
            _ => format!(" {:.1}s", branch.system.machine.now_s()),
        };
        let state = if branch.is_running { " stopped" } else { "" };
        format!("rpl{name}{time}{state}> ")
    }

    /// Does what a line asks for.
    ///
    /// # Errors
    /// Standard output is closed.
    fn handle(&mut self, text: &str) -> Result<AfterLine> {
        if let Some(recorder) = &self.recorder {
            let time_us = self.session.branch.system.machine.now_us;
            recorder.typed(&Typed { typed: text.to_string(), time_us });
        }
        // What is written elsewhere, or comes from an editor, is not done again.
        let is_kept = !matches!(command::parse(text), Ok((Verb::Edit | Verb::Save | Verb::Quit, _)));
        if is_kept || !text.trim_start().starts_with(':') {
            self.note_typed(text);
        }
        let after = self.guarded(|prompt| prompt.obey(text))?;
        self.note_reached();
        Ok(after)
    }

    /// What is typed stands in the journal before it takes effect.
    fn note_typed(&mut self, text: &str) {
        let time_us = self.session.branch.system.machine.now_us;
        let written = self.journal.as_mut().map_or(Ok(()), |journal| journal.typed(text, time_us));
        self.tell_journal(written);
    }

    /// So does how far the session has come.
    fn note_reached(&mut self) {
        let time_us = self.session.branch.system.machine.now_us;
        let written = self.journal.as_mut().map_or(Ok(()), |journal| journal.reached(time_us));
        self.tell_journal(written);
    }

    fn tell_journal(&mut self, written: io::Result<()>) {
        if let Err(error) = written {
            self.console.note(&format!(
                "the journal cannot be written: {error}; it goes on up to here, and what is typed from now on is not in it"
            ));
        }
    }

    /// The plan of a name; that which was loaded then, if the session is repeated.
    fn plan(&mut self, name: &str) -> Result<PlanText> {
        if let Some(KeptText { name, text, .. }) = self.plans.pop_front() {
            return Ok(PlanText { name, text, folder: self.session.folder() });
        }
        let plan = plans::plan(name)?;
        let written = self.journal.as_mut().map_or(Ok(()), |journal| journal.plan(&plan));
        self.tell_journal(written);
        Ok(plan)
    }

    fn obey(&mut self, text: &str) -> Result<AfterLine> {
        if !text.trim_start().starts_with(':') {
            if !is_blank(text) {
                self.forms(text, &Until::End)?;
            }
            return Ok(AfterLine::Another);
        }
        match command::parse(text) {
            Ok((Verb::Quit, _)) => return Ok(AfterLine::Quit),
            Ok((verb, rest)) => {
                let repeats = matches!(verb, Verb::Step | Verb::Next | Verb::Into | Verb::Out) && rest.is_empty();
                self.repeated = repeats.then(|| text.to_string());
                if verb.steers() && self.clock.take().is_some() {
                    self.console.keep(false);
                }
                self.command(verb, rest)?;
            }
            Err(reason) => self.wrong(&reason)?,
        }
        Ok(AfterLine::Another)
    }

    fn command(&mut self, verb: Verb, rest: &str) -> Result<()> {
        match verb {
            Verb::Load => match self.plan(rest) {
                Ok(plan) => self.load(plan, Until::End)?,
                Err(error) => self.wrong(&format!("{error:#}"))?,
            },
            Verb::Run if rest.is_empty() => {
                self.wrong("`:run FORM`: a form is expected, such as `:run (deliver 'mail)`")?
            }
            Verb::Run => {
                let breakpoints = std::mem::take(&mut self.session.breakpoints);
                let done = self.forms(rest, &Until::End);
                self.session.breakpoints = breakpoints;
                done?;
            }
            Verb::Step if !rest.is_empty() => self.forms(rest, &Until::Step)?,
            Verb::Step => self.go_on(&Until::Step)?,
            Verb::Next => self.go_on(&Until::Next)?,
            Verb::Into => self.go_on(&Until::Into)?,
            Verb::Out => self.go_on(&Until::Out)?,
            Verb::Time => self.time(rest)?,
            Verb::Continue => self.go_on(&Until::End)?,
            Verb::Until => self.until(rest)?,
            Verb::Go => self.go(rest)?,
            Verb::Stop => self.stop_clock()?,
            Verb::Break => self.set_break(rest)?,
            Verb::Delete => self.delete(rest)?,
            Verb::Watch if rest.is_empty() => self.session.watches.clear(),
            Verb::Watch => self.session.watches.push(rest.to_string()),
            Verb::Abort => self.abort()?,
            Verb::Back => self.back(rest)?,
            Verb::At => self.at(rest)?,
            Verb::Fork => self.fork(rest)?,
            Verb::Forks => self.explain(&self.forks())?,
            Verb::Switch => self.switch(rest)?,
            Verb::Why => self.explain(&self.why(rest))?,
            Verb::Tasks => self.explain(&self.tasks())?,
            Verb::Task => self.explain(&self.task(rest))?,
            Verb::Fluents => self.explain(&self.fluents(rest))?,
            Verb::Valves => self.explain(&self.valves())?,
            Verb::Map => self.explain(&self.drawn_map())?,
            Verb::Project => self.project(rest)?,
            Verb::Trace => self.explain(&self.last_events(rest))?,
            Verb::Doc => self.document(rest)?,
            Verb::Source => self.source(rest)?,
            Verb::Edit => self.edit(rest)?,
            Verb::Save => self.save(rest)?,
            Verb::Help => self.help(rest)?,
            Verb::Quit => {}
        }
        Ok(())
    }

    /// What was asked for.
    fn explain(&mut self, lines: &[String]) -> Result<()> {
        Ok(lines.iter().try_for_each(|line| self.console.explain(line))?)
    }

    /// A command that cannot be done.
    fn wrong(&mut self, reason: &str) -> Result<()> {
        self.console.note(&format!("error: {reason}"));
        self.worst = Status::Wrong;
        Ok(())
    }
}
