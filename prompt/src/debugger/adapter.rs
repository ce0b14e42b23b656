//! The adapter: what a debugger asks, done to a session.

use super::heard::{Heard, Requests};
use super::places::{Counting, meant, stopping_lines};
use super::standing::{Frames, scopes, thread_of, threads};
use crate::listings::value_text;
use crate::session::{HandedIn, Session};
use anyhow::{Context, Result, anyhow, bail};
use clap::Parser;
use rpl_drive::show::failure_report::Reporter;
use rpl_drive::stopping::breakpoint::Breakpoint;
use rpl_drive::stopping::halt::{Halt, Until};
use rpl_drive::stopping::own_text::{is_own, is_shown};
use rpl_editor::dap::messages::{
    self, Evaluate, Launch, Numbered, OfThread, Request, Said, Scopes, SetBreakpoints, SetExceptionBreakpoints,
    SetFunctionBreakpoints, SourceRequest, StackTrace, Variables,
};
use rpl_editor::frames;
use rpl_lang::compile::NoFiles;
use rpl_lang::source::SourceId;
use rpl_runtime::run::session::Answer;
use rpl_runtime::run::stepping::Stop;
use rpl_runtime::run::timeline::{Past, TimelinePosition};
use rpl_runtime::state::value::Value;
use rpl_shell::arguments::site::SiteArguments;
use rpl_shell::files::module_files::{GoingBack, ModuleVoices, Modules};
use rpl_shell::files::plans;
use rpl_shell::interrupt;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::{self, Console};
use serde::de::DeserializeOwned;
use serde_json::{Value as Json, json};
use std::io;

/// The filter of exceptions by which a failure that ends the plan is stopped at.
const FAILURES: &str = "failure";

/// Words that say where a plan runs.
#[derive(Parser)]
#[command(name = "args", no_binary_name = true)]
struct SiteWords {
    #[command(flatten)]
    site: SiteArguments,
}

/// A line to stop at, and what must be true there.
struct LineBreakpoint {
    place: Breakpoint,
    source: SourceId,
    condition: Option<String>,
}

/// What is debugged.
struct Debugged {
    session: Session,
    /// Voices of modules end with them.
    _modules: Modules,
    lines: Vec<LineBreakpoint>,
    named: Vec<Breakpoint>,
    /// Whether it stops before a failure ends it.
    stops_at_failures: bool,
    stops_on_entry: bool,
    /// Where the plan has been handed in and nothing of it has run: nothing is earlier.
    start: TimelinePosition,
    frames: Frames,
}

/// What is done after a request was answered.
enum Next {
    /// The next request.
    Listen,
    /// The run goes on.
    GoOn(Until),
    /// The run stands elsewhere.
    Stopped(&'static str),
    /// The conversation is over.
    End,
}

/// A conversation with a debugger.
pub struct Adapter {
    requests: Requests,
    said: i64,
    counting: Counting,
    debugged: Option<Debugged>,
    console: Console,
    status: Status,
}

fn arguments<T: DeserializeOwned>(request: &Request) -> Result<T> {
    serde_json::from_value(request.arguments.clone()).map_err(|error| anyhow!("`{}`: {error}", request.command))
}

impl Adapter {
    pub(super) fn new(requests: Requests) -> Self {
        let counting = Counting { first_line: 1, first_column: 1 };
        let console = Console::keeping();
        Self { requests, said: 0, counting, debugged: None, console, status: Status::Failed }
    }

    /// Answers until the debugger disconnects or is gone.
    ///
    /// # Errors
    /// Standard output is closed.
    pub(super) fn serve(&mut self) -> io::Result<Status> {
        while let Some(heard) = self.requests.next() {
            match (self.hear(&heard)?, heard) {
                (Next::Listen, _) => {}
                (Next::Stopped(reason), _) => self.tell_stopped(reason, None)?,
                (Next::GoOn(until), _) => self.go_on(until)?,
                (Next::End, Heard::End(why)) => {
                    console::note(&format!("error: {why}"));
                    break;
                }
                (Next::End, Heard::Request(_) | Heard::Malformed(_)) => return Ok(Status::Succeeded),
            }
        }
        Ok(self.status)
    }

    fn hear(&mut self, heard: &Heard) -> io::Result<Next> {
        match heard {
            Heard::Request(request) => self.answer(request),
            Heard::Malformed(told) => self.say(told.clone()).map(|()| Next::Listen),
            Heard::End(_) => Ok(Next::End),
        }
    }

    fn say(&mut self, said: Said) -> io::Result<()> {
        self.said += 1;
        frames::write(&Numbered { seq: self.said, said }, &mut io::stdout().lock())
    }

    fn event(&mut self, event: &'static str, body: Option<Json>) -> io::Result<()> {
        self.say(Said::Event { event, body })
    }

    fn answer(&mut self, request: &Request) -> io::Result<Next> {
        let done = self.done(request);
        let (success, message, body, next) = match done {
            Ok((body, next)) => (true, None, body, next),
            Err(error) => (false, Some(format!("{error:#}")), None, Next::Listen),
        };
        let (request_seq, command) = (request.seq, request.command.clone());
        self.say(Said::Response { request_seq, success, command, message, body })?;
        // Breakpoints can be set when the text is there.
        if success && request.command == "launch" {
            self.event("initialized", None)?;
        }
        Ok(next)
    }

    /// Does what is asked for; gives the answer, and what comes next.
    fn done(&mut self, request: &Request) -> Result<(Option<Json>, Next)> {
        let answered = |body: Json| Ok((Some(body), Next::Listen));
        match request.command.as_str() {
            "initialize" => answered(self.initialize(&request.arguments)),
            "launch" => {
                self.debugged = Some(launch(arguments(request)?)?);
                Ok((None, Next::Listen))
            }
            "disconnect" | "terminate" => Ok((None, Next::End)),
            "evaluate" => answered(self.debugged()?.evaluate(&arguments(request)?)?),
            _ => {
                let counting = self.counting;
                let debugged = self.debugged()?;
                let goes = |until: Until| Ok((Some(json!({ "allThreadsContinued": true })), Next::GoOn(until)));
                match request.command.as_str() {
                    "configurationDone" => {
                        Ok((None, Next::GoOn(if debugged.stops_on_entry { Until::Step } else { Until::End })))
                    }
                    "setBreakpoints" => answered(debugged.set_lines(&arguments(request)?, counting)),
                    "setFunctionBreakpoints" => answered(debugged.set_named(arguments(request)?)),
                    "setExceptionBreakpoints" => {
                        let SetExceptionBreakpoints { filters } = arguments(request)?;
                        debugged.stops_at_failures = filters.iter().any(|filter| filter == FAILURES);
                        answered(json!({}))
                    }
                    "threads" => answered(json!({ "threads": threads(&debugged.session.branch.system) })),
                    "stackTrace" => answered(debugged.stack(arguments(request)?, counting)),
                    "scopes" => {
                        let Scopes { frame_id } = arguments(request)?;
                        answered(json!({ "scopes": scopes(frame_id) }))
                    }
                    "variables" => {
                        let Variables { variables_reference } = arguments(request)?;
                        let shown = debugged.frames.variables(&debugged.session.branch.system, variables_reference);
                        answered(json!({ "variables": shown }))
                    }
                    "source" => {
                        let SourceRequest { source_reference } = arguments(request)?;
                        let asked = messages::Source { source_reference: Some(source_reference), ..Default::default() };
                        let system = &debugged.session.branch.system;
                        let id = meant(system, &asked).context("there is no such text")?;
                        answered(json!({ "content": &*system.program.sources.get(id).text }))
                    }
                    "continue" => goes(Until::End),
                    "next" => goes(Until::Next),
                    "stepIn" => goes(Until::Into),
                    "stepOut" => goes(Until::Out),
                    "pause" => {
                        let OfThread { .. } = arguments(request)?;
                        Ok((None, Next::Stopped("pause")))
                    }
                    "stepBack" => {
                        debugged.step_back()?;
                        Ok((None, Next::Stopped("step")))
                    }
                    "reverseContinue" => Ok((None, Next::Stopped(debugged.run_back()?))),
                    other => bail!("there is no request `{other}`"),
                }
            }
        }
    }

    fn debugged(&mut self) -> Result<&mut Debugged> {
        self.debugged.as_mut().context("nothing is debugged; `launch` comes first")
    }

    fn initialize(&mut self, said: &Json) -> Json {
        let first = |key: &str| i64::from(said[key].as_bool().unwrap_or(true));
        self.counting = Counting { first_line: first("linesStartAt1"), first_column: first("columnsStartAt1") };
        json!({
            "supportsConfigurationDoneRequest": true,
            "supportsConditionalBreakpoints": true,
            "supportsFunctionBreakpoints": true,
            "supportsEvaluateForHovers": true,
            "supportsStepBack": true,
            "supportsTerminateRequest": true,
            "exceptionBreakpointFilters": [{
                "filter": FAILURES, "label": "Failures",
                "description": "Stops where a failure is raised that ends the plan", "default": true,
            }],
        })
    }

    /// Lets the run go on until it has a reason to stop, and tells it.
    fn go_on(&mut self, until: Until) -> io::Result<()> {
        loop {
            interrupt::forget();
            while let Some(heard) = self.requests.next_now() {
                match self.hear(&heard)? {
                    Next::Listen => {}
                    Next::Stopped(reason) => return self.tell_stopped(reason, None),
                    // The run goes on as it was told first.
                    Next::GoOn(_) => {}
                    Next::End => {
                        self.requests.keep(heard);
                        return Ok(());
                    }
                }
            }
            let Some(debugged) = self.debugged.as_mut() else { return Ok(()) };
            debugged.frames.clear();
            let stood = (debugged.session.branch.timeline.position, debugged.session.branch.stop.clone());
            debugged.session.breakpoints =
                debugged.lines.iter().map(|line| &line.place).chain(&debugged.named).cloned().collect();
            let halt = debugged.session.go_on(&until, &mut self.console)?;
            debugged.keep_conditions();
            let is_unmoved = debugged.session.branch.timeline.position == stood.0;
            let is_untrue = matches!(halt, Halt::Breakpoint(_))
                && (!debugged.is_condition_met() || debugged.is_same_visit(stood.1.as_ref()));
            if halt == Halt::Interrupted && is_unmoved {
                debugged.session.branch.stop = stood.1;
            }
            self.tell_output()?;
            match halt {
                // Somebody has something to say.
                Halt::Interrupted if is_unmoved || until == Until::End => {}
                Halt::Breakpoint(_) if is_untrue && until == Until::End => {}
                Halt::Interrupted => return self.tell_stopped("pause", None),
                Halt::Arrived if matches!(until, Until::Step) => return self.tell_stopped("entry", None),
                Halt::Arrived => return self.tell_stopped("step", None),
                Halt::Breakpoint(place) => return self.tell_stopped("breakpoint", Some(place)),
                Halt::Answered(answer) => return self.tell_answer(answer),
            }
        }
    }

    fn tell_stopped(&mut self, reason: &'static str, text: Option<String>) -> io::Result<()> {
        let Some(debugged) = &mut self.debugged else { return Ok(()) };
        debugged.frames.clear();
        let machine = &debugged.session.branch.system.machine;
        let stopped = debugged.session.branch.stop.as_ref().and_then(|stop| machine.tasks.find_alive(stop.task));
        let thread = thread_of(stopped.unwrap_or(machine.main));
        let description = format!("{reason} at {:.3} s", machine.now_s());
        let body = json!({ "reason": reason, "description": description, "text": text, "threadId": thread, "allThreadsStopped": true });
        self.event("stopped", Some(body))
    }

    fn tell_answer(&mut self, answer: Answer) -> io::Result<()> {
        let Some(debugged) = &mut self.debugged else { return Ok(()) };
        let system = &debugged.session.branch.system;
        let status = match answer {
            Answer::Succeeded(value) => {
                self.console.note(&format!("=> {}", value_text(system, value)));
                Status::Succeeded
            }
            Answer::Failed(failure) => {
                let reporter = Reporter { machine: &system.machine, program: &system.program, colour: false };
                self.console.note(reporter.text("the plan failed: ", failure).trim_end());
                if debugged.stops_at_failures && debugged.back_to_failure(failure) {
                    self.tell_output()?;
                    return self.tell_stopped("exception", None);
                }
                Status::Failed
            }
            Answer::GivenUp => Status::Interrupted,
        };
        self.status = status;
        self.tell_output()?;
        self.event("exited", Some(json!({ "exitCode": status.code() })))?;
        self.event("terminated", None)
    }

    fn tell_output(&mut self) -> io::Result<()> {
        for line in self.console.take_kept() {
            self.event("output", Some(json!({ "category": "stdout", "output": format!("{line}\n") })))?;
        }
        Ok(())
    }
}

/// Puts together what is to be debugged.
fn launch(launch: Launch) -> Result<Debugged> {
    let SiteWords { site: arguments } = SiteWords::try_parse_from(&launch.args).map_err(|error| anyhow!("{error}"))?;
    let plan = plans::plan(&launch.program)?;
    let (site, _, modules) = arguments.build(ModuleVoices::Processes(GoingBack::Session))?;
    modules.start(&site, arguments.seed(), None)?;
    let mut session = Session::new(&site, site.robot(arguments.seed()), arguments.seed())?;
    session.file = Some(plan.name.clone());
    let forms = HandedIn { name: plan.name, text: plan.text, folder: plan.folder, number: None };
    session.submit(forms).map_err(|rejected| anyhow!("the plan cannot run\n{}", rejected.render(false)))?;
    let start = session.branch.timeline.position;
    Ok(Debugged {
        session,
        start,
        _modules: modules,
        lines: Vec::new(),
        named: Vec::new(),
        stops_at_failures: false,
        stops_on_entry: launch.stop_on_entry,
        frames: Frames::default(),
    })
}

impl Debugged {
    fn set_lines(&mut self, asked: &SetBreakpoints, counting: Counting) -> Json {
        let Some(source) = meant(&self.session.branch.system, &asked.source) else {
            let message = Some("the plan has not loaded this text".to_string());
            let unknown = messages::Breakpoint { verified: false, message, line: None };
            return json!({ "breakpoints": vec![unknown; asked.breakpoints.len()] });
        };
        self.lines.retain(|line| line.source != source);
        let stopping = stopping_lines(&self.session.branch.system, source);
        let told = asked.breakpoints.iter().map(|asked| {
            let system = &mut self.session.branch.system;
            let wanted = asked.line.saturating_sub(counting.first_line).saturating_add(1);
            let wanted = usize::try_from(wanted).unwrap_or_default();
            let name = system.program.sources.get(source).name.to_string();
            let place = stopping
                .range(wanted..)
                .next()
                .copied()
                .ok_or_else(|| "there is no form at this line or below".to_string())
                .and_then(|line| Ok((line, Breakpoint::parse(&format!("{name}:{line}"), None, system, false)?)));
            match place {
                Ok((line, place)) => {
                    self.lines.push(LineBreakpoint { place, source, condition: asked.condition.clone() });
                    let line = Some(line as i64 - 1 + counting.first_line);
                    messages::Breakpoint { verified: true, message: None, line }
                }
                Err(message) => messages::Breakpoint { verified: false, message: Some(message), line: None },
            }
        });
        let told: Vec<messages::Breakpoint> = told.collect();
        json!({ "breakpoints": told })
    }

    fn set_named(&mut self, SetFunctionBreakpoints { breakpoints }: SetFunctionBreakpoints) -> Json {
        self.named.clear();
        let told = breakpoints.iter().map(|asked| {
            match Breakpoint::parse(asked.name.trim(), None, &mut self.session.branch.system, false) {
                Ok(place) => {
                    self.named.push(place);
                    messages::Breakpoint { verified: true, message: None, line: None }
                }
                Err(message) => messages::Breakpoint { verified: false, message: Some(message), line: None },
            }
        });
        let told: Vec<messages::Breakpoint> = told.collect();
        json!({ "breakpoints": told })
    }

    /// Whether conditions hold is known from one stretch of the run to the next.
    fn keep_conditions(&mut self) {
        let named = self.session.breakpoints.split_off(self.lines.len());
        self.named = named;
    }

    /// Whether the run stands at a line whose condition is true, or at another breakpoint.
    fn is_condition_met(&self) -> bool {
        let Some(stop) = &self.session.branch.stop else { return true };
        let system = &self.session.branch.system;
        let is_at = |place: &Breakpoint| place.is_at(system, stop, self.session.file.as_deref());
        let is_true = |line: &LineBreakpoint| match &line.condition {
            None => true,
            // What cannot be evaluated is shown by stopping.
            Some(condition) => self.value(condition, None).is_none_or(|(_, is_true)| is_true),
        };
        self.named.iter().any(is_at) || self.lines.iter().any(|line| is_at(&line.place) && is_true(line))
    }

    /// Whether the run stands in a line that it has not left since it stood before another form of it: a line
    /// is stopped at once, however many forms stand in it.
    fn is_same_visit(&self, before: Option<&Stop>) -> bool {
        let (Some(before), Some(now)) = (before, &self.session.branch.stop) else { return false };
        let sources = &self.session.branch.system.program.sources;
        let line = |stop: &Stop| sources.line_column(stop.span).0;
        let is_same_call = (before.task, before.depth, before.body) == (now.task, now.depth, now.body);
        // Parts come before the form around them, and from left to right; what comes otherwise comes again.
        let is_later = now.span.start > before.span.start || now.span.end >= before.span.end && now.span != before.span;
        is_same_call && before.span.source == now.span.source && line(before) == line(now) && is_later
    }

    /// The value of a form in a copy of the run, and whether it is true; none if it has none.
    fn value(&self, form: &str, frame: Option<i64>) -> Option<(String, bool)> {
        self.look(form, frame).ok()
    }

    fn look(&self, form: &str, frame: Option<i64>) -> Result<(String, bool)> {
        let system = &self.session.branch.system;
        let variables = match frame {
            Some(_) => self.frames.variables_of(system, frame),
            None => {
                let stop = self.session.branch.stop.as_ref();
                let task = stop.and_then(|stop| system.machine.tasks.find_alive(stop.task));
                let calls = task.map_or_else(Vec::new, |task| system.machine.calls(&system.program, task));
                calls.into_iter().next().map_or_else(Vec::new, |call| call.variables)
            }
        };
        // What is looked at must not touch the run.
        let mut copy = system.clone();
        match copy.inspect("watch", form, &variables, &mut NoFiles) {
            Ok((_, Ok(value))) => Ok((value_text(&copy, value), value != Value::Nil)),
            Ok((_, Err(failure))) => bail!("{}", copy.machine.show(&copy.program, failure)),
            Err(rejected) => {
                let message = rejected.diagnostics.first().map(|found| found.message.clone());
                bail!("{}", message.unwrap_or_else(|| "not a form that can be evaluated here".to_string()))
            }
        }
    }

    fn evaluate(&self, asked: &Evaluate) -> Result<Json> {
        let (result, _) = self.look(&asked.expression, asked.frame_id)?;
        Ok(json!({ "result": result, "variablesReference": 0 }))
    }

    fn stack(&mut self, asked: StackTrace, counting: Counting) -> Json {
        let branch = &self.session.branch;
        let frames = self.frames.stack(&branch.system, asked.thread_id, branch.stop.as_ref(), counting);
        let total = frames.len();
        let wanted = asked.levels.filter(|&levels| levels > 0).unwrap_or(usize::MAX);
        let frames: Vec<_> = frames.into_iter().skip(asked.start_frame).take(wanted).collect();
        json!({ "stackFrames": frames, "totalFrames": total })
    }

    fn step_back(&mut self) -> Result<()> {
        let timeline = &self.session.branch.timeline;
        let past = timeline.steps_before(timeline.position, 1, is_shown, &interrupt::is_asked);
        self.go_back(past)
    }

    /// Goes back to the last breakpoint in a text, or to the start; gives the reason to stop there.
    fn run_back(&mut self) -> Result<&'static str> {
        let timeline = &self.session.branch.timeline;
        let file = self.session.file.as_deref();
        let places: Vec<&Breakpoint> = self.lines.iter().map(|line| &line.place).chain(&self.named).collect();
        let past = timeline.steps_before(
            timeline.position,
            1,
            |system, stop| is_own(system, stop.span) && places.iter().any(|place| place.is_at(system, stop, file)),
            &interrupt::is_asked,
        );
        self.go_back(past)?;
        let is_start = self.session.branch.timeline.position == self.start;
        Ok(if is_start { "entry" } else { "breakpoint" })
    }

    /// Goes back to where a failure was raised; whether that is known.
    fn back_to_failure(&mut self, failure: Value) -> bool {
        let branch = &self.session.branch;
        let Value::Failure(index) = failure else { return false };
        let Some(failure) = branch.system.machine.heap.failures.get(index).cloned() else { return false };
        let Some(mut past) = branch.timeline.before_failure(&failure, &interrupt::is_asked) else { return false };
        if let (Some(stop), Some(span)) = (&mut past.stop, failure.span) {
            stop.span = span;
        }
        self.session.go_back_to(past);
        true
    }

    fn go_back(&mut self, past: Option<Past<rpl_mission::robot::Robot>>) -> Result<()> {
        let past = match past {
            Some(past) if past.position < self.start => {
                self.session.branch.timeline.at(self.start, &interrupt::is_asked)
            }
            other => other,
        };
        let past = past.context("interrupted on the way back; the run stands where it stood")?;
        self.session.go_back_to(past);
        self.named.iter_mut().for_each(|place| place.restore(&mut self.session.branch.system));
        Ok(())
    }
}
