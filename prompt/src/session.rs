//! What the prompt works on: a run, its history, the forks of it, and where it is to stop.

use super::intervention::Intervention;
use anyhow::{Result, anyhow};
use rpl_drive::events::{self, LineKind};
use rpl_drive::show::failure_report::Reporter;
use rpl_drive::stopping::breakpoint::Breakpoint;
use rpl_lang::symbol::Symbol;
use rpl_mission::robot::Robot;
use rpl_mission::site::Site;
use rpl_runtime::run::library::Rejected;
use rpl_runtime::run::session::{Answer, Submitted};
use rpl_runtime::run::stepping::Stop;
use rpl_runtime::run::system::System;
use rpl_runtime::run::timeline::{Past, Timeline};
use rpl_runtime::state::trace::Event;
use rpl_runtime::state::value::TaskRef;
use rpl_shell::files::plans::{Folder, KeptLoad};
use rpl_shell::interrupt;
use rpl_shell::terminal::console::Console;
use std::collections::{BTreeMap, VecDeque};
use std::io;

/// Events that are kept: hours of a mission, and no more than a plan that never rests may take.
const MOST_EVENTS: usize = 200_000;

/// One line of history, from the start to a present.
#[derive(Clone)]
pub struct Branch {
    /// The present.
    pub system: System<Robot>,
    /// The past.
    pub timeline: Timeline<Robot>,
    /// What happened last.
    pub log: VecDeque<Event>,
    /// The form a task stands before, if a stepper stopped there.
    pub stop: Option<Stop>,
    /// Whether a form is under way.
    pub is_running: bool,
    /// The segments of the timeline that began when what came to the run that is repeated came again.
    pub interventions: Vec<u64>,
}

/// What came of forms beside the one that runs.
pub struct Aside {
    /// The task that runs them.
    pub task: TaskRef,
    /// How they ended; none if they wait.
    pub answer: Option<Answer>,
    /// Variables of the stopped call that have another value now.
    pub assigned: Vec<Symbol>,
}

/// Forms to be run.
pub struct HandedIn {
    /// The name errors call them by.
    pub name: String,
    /// The text.
    pub text: String,
    /// What they may load from.
    pub folder: Folder,
    /// The number of the text, if it was typed: its value is kept by it.
    pub number: Option<u32>,
}

/// The variable that keeps the value of a typed text.
pub fn kept_name(number: u32) -> String {
    format!("_{number}")
}

/// Everything a user of the prompt has.
pub struct Session {
    /// The history being worked on.
    pub branch: Branch,
    /// Its name.
    pub name: String,
    /// Other histories, by name.
    pub others: BTreeMap<String, Branch>,
    /// Where a run stops.
    pub breakpoints: Vec<Breakpoint>,
    /// Expressions shown whenever a run stops.
    pub watches: Vec<String>,
    /// The file that `:break LINE` means.
    pub file: Option<String>,
    folder: Folder,
    texts: u32,
    /// The number of the text whose form is under way, if it was typed.
    pub number: Option<u32>,
    /// What came to the run that is repeated while it stood still, in order.
    pub interventions: Vec<Intervention>,
    /// Whether what is outside does not wait for the run.
    pub goes_by_clock: bool,
    /// Where the session that is repeated was stopped by hand, or typed at, next.
    pub horizon_us: Option<u64>,
}

impl Session {
    /// A session on a site, before the first form.
    ///
    /// # Errors
    /// The session's own text does not compile.
    pub fn new(site: &Site, robot: Robot, seed: u64) -> Result<Self> {
        let mut system = site
            .session(robot, seed)
            .map_err(|rejected: Rejected| anyhow!("the session cannot start\n{}", rejected.render(false)))?;
        system.machine.trace.take();
        let timeline = Timeline::new(&system, Robot::bytes_apart);
        let branch =
            Branch { system, timeline, log: VecDeque::new(), stop: None, is_running: false, interventions: Vec::new() };
        Ok(Self {
            branch,
            name: "main".to_string(),
            others: BTreeMap::new(),
            breakpoints: Vec::new(),
            watches: Vec::new(),
            file: None,
            folder: Folder::Disk(".".into()),
            texts: 0,
            number: None,
            interventions: Vec::new(),
            goes_by_clock: site.goes_by_clock(),
            horizon_us: None,
        })
    }

    /// What the texts of a session that is repeated have loaded; without any, they load from the working folder.
    pub fn give_loads(&mut self, loads: Vec<KeptLoad>) {
        self.folder = match loads.is_empty() {
            true => Folder::Disk(".".into()),
            false => Folder::kept(loads, false),
        };
    }

    /// What typed texts load from.
    pub fn folder(&self) -> Folder {
        self.folder.clone()
    }

    /// The next text that is typed.
    pub fn typed(&mut self, text: &str) -> HandedIn {
        self.texts += 1;
        let (name, folder) = (format!("<{}>", self.texts), self.folder.clone());
        HandedIn { name, text: text.to_string(), folder, number: Some(self.texts) }
    }

    /// Hands in forms to be run.
    ///
    /// # Errors
    /// The findings in the text.
    pub fn submit(&mut self, forms: HandedIn) -> Result<Submitted, Rejected> {
        let HandedIn { name, text, mut folder, number } = forms;
        let branch = &mut self.branch;
        branch.system.keep_value_as(number.map(kept_name).as_deref());
        let submitted = branch.system.submit(&name, &text, &mut folder)?;
        branch.is_running = true;
        branch.stop = None;
        branch.timeline.handed_in(&branch.system);
        self.number = number;
        Ok(submitted)
    }

    /// Runs forms beside the one that runs, as far as they come at once; they see and assign the
    /// variables of the call it stands in.
    ///
    /// # Errors
    /// The findings in the text.
    pub fn beside(&mut self, forms: HandedIn) -> Result<(Submitted, Aside), Rejected> {
        let HandedIn { name, text, mut folder, number } = forms;
        let branch = &mut self.branch;
        let stop = branch.stop.as_ref();
        branch.system.keep_value_as(number.map(kept_name).as_deref());
        let (submitted, beside) = branch.system.submit_beside(&name, &text, stop, &mut folder)?;
        // Told to stop, it goes on with the run.
        while !interrupt::is_asked() && branch.system.step_beside(&beside) {}
        let answers = branch.system.take_beside_answers();
        let answer = answers.into_iter().find(|answer| answer.number == beside.number);
        let assigned = answer.as_ref().map_or(Vec::new(), |answer| branch.system.assign_seen(&beside, answer));
        branch.timeline.handed_in(&branch.system);
        Ok((submitted, Aside { task: beside.task, answer: answer.map(|answer| answer.answer), assigned }))
    }

    /// Whether something can run at once.
    pub fn has_work(&self) -> bool {
        !self.branch.system.machine.is_idle()
    }

    /// Shows what was printed, and keeps what happened.
    pub fn hand_on(&mut self, console: &mut Console) -> io::Result<()> {
        let machine = &mut self.branch.system.machine;
        let (happened, output) = (machine.trace.take(), std::mem::take(&mut machine.output));
        let is_lost = !happened.is_empty() && self.branch.system.outside.is_lost();
        for told in events::in_order(&happened, output, is_lost) {
            match told.kind {
                LineKind::Print => console.print(&told.line())?,
                LineKind::Event | LineKind::Log => console.note(&told.line()),
            }
        }
        let log = &mut self.branch.log;
        log.extend(happened);
        log.drain(..log.len().saturating_sub(MOST_EVENTS));
        self.tell_answers(console)?;
        console.flush()
    }

    /// How forms ended that had to wait beside the one that runs.
    fn tell_answers(&mut self, console: &mut Console) -> io::Result<()> {
        let system = &mut self.branch.system;
        for answer in system.take_beside_answers() {
            let name = answer.path();
            match answer.answer {
                Answer::Succeeded(value) => {
                    let value = system.machine.write(&system.program, value);
                    console.print(&format!("{name} => {value}"))?;
                }
                Answer::Failed(failure) => {
                    let (machine, program) = (&system.machine, &system.program);
                    let reporter = Reporter { machine, program, colour: console.colour };
                    console.note(reporter.text(&format!("{name} failed: "), failure).trim_end());
                }
                Answer::GivenUp => {}
            }
        }
        Ok(())
    }

    /// Takes an earlier state for the present one. What came after it is forgotten.
    pub fn go_back_to(&mut self, past: Past<Robot>) {
        let Past { system, position, stop } = past;
        let branch = &mut self.branch;
        branch.system = system;
        // They were told when it happened.
        branch.system.take_beside_answers();
        branch.timeline.go_back_to(position);
        branch.stop = stop;
        branch.is_running = branch.system.answer().is_none() && !branch.system.is_waiting_for_form();
        branch.interventions.retain(|&segment| segment <= position.segment);
        let next = branch.system.machine.trace.next_sequence;
        branch.log.retain(|event| event.sequence < next);
        self.restore_conditions();
    }

    /// Compiles the conditions of breakpoints into the present program, which may be another one.
    pub fn restore_conditions(&mut self) {
        let system = &mut self.branch.system;
        self.breakpoints.iter_mut().for_each(|place| place.restore(system));
    }
}
