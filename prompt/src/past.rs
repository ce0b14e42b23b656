//! Earlier instants of a run, and runs that are kept side by side.

use super::Prompt;
use super::session::Branch;
use anyhow::Result;
use rpl_drive::show::why::shortened;
use rpl_drive::stopping::breakpoint::FAILURE;
use rpl_drive::stopping::own_text::is_shown;
use rpl_lang::code::GlobalKind;
use rpl_lang::suggest::suggest;
use rpl_mission::robot::Robot;
use rpl_runtime::run::system::System;
use rpl_runtime::run::timeline::Past;
use rpl_shell::arguments::duration::parse_duration_us;
use rpl_shell::interrupt;
use std::collections::BTreeMap;

/// What is said where nothing is earlier.
const START: &str = "this is the start";

/// The definitions of a run that can be called, as they are written.
fn texts(system: &System<Robot>) -> BTreeMap<String, String> {
    let (program, symbols) = (&system.program, &system.machine.symbols);
    let own = program.globals.iter().skip(program.library_globals as usize);
    let functions = own.filter_map(|global| match global.kind {
        GlobalKind::Function(code) => Some((global.name, code)),
        _ => None,
    });
    let codes = functions.chain(program.macros.iter().map(|(&name, &code)| (name, code)));
    let written = codes.filter_map(|(name, code)| {
        let text = program.sources.text_of(program.codes.get(code as usize)?.span);
        Some((symbols.name(name).to_string(), text.to_string()))
    });
    written.collect()
}

impl Prompt<'_> {
    pub(super) fn back(&mut self, rest: &str) -> Result<()> {
        let now_us = self.session.branch.system.machine.now_us;
        if rest == FAILURE {
            return self.back_to_failure();
        }
        let timeline = &self.session.branch.timeline;
        let past = match (rest.parse::<usize>(), parse_duration_us(rest)) {
            _ if rest.is_empty() => timeline.steps_before(timeline.position, 1, is_shown, &interrupt::is_asked),
            (Ok(0), _) => return self.show_stop(),
            (Ok(steps), _) => timeline.steps_before(timeline.position, steps, is_shown, &interrupt::is_asked),
            (_, Ok(time_us)) => {
                if time_us > now_us {
                    self.console.note(START);
                }
                timeline.at_time(now_us.saturating_sub(time_us), &interrupt::is_asked)
            }
            _ => {
                let rest = shortened(rest);
                return self.wrong(&format!(
                    "`{rest}` is neither a number of steps nor a time such as 10s; `:back failure` goes to the last failure"
                ));
            }
        };
        self.go_back(past)
    }

    /// To where the last failure was raised, with everything alive that it ended.
    pub(super) fn back_to_failure(&mut self) -> Result<()> {
        let Some(failure) = self.failure.clone() else {
            return self.wrong("no form has failed yet; `:back failure` goes to where the last failure was raised");
        };
        let past = self.session.branch.timeline.before_failure(&failure, &interrupt::is_asked);
        if past.is_none() && !interrupt::is_asked() {
            return self.wrong("the last failure is none of this run, or of a form that was typed beside it");
        }
        let past = past.map(|mut past| {
            // Inside the library: the form of the plan that called it.
            if let (Some(stop), Some(span)) = (&mut past.stop, failure.span) {
                stop.span = span;
            }
            past
        });
        self.go_back(past)?;
        self.console.note("about to fail; `:why`, `:task` and variables tell more, `:back` goes further back");
        Ok(())
    }

    pub(super) fn at(&mut self, rest: &str) -> Result<()> {
        match parse_duration_us(rest) {
            Ok(time_us) if time_us > self.session.branch.system.machine.now_us => {
                self.wrong(&format!("{rest} has not come yet; `:until {rest}` goes there"))
            }
            Ok(time_us) => {
                let past = self.session.branch.timeline.at_time(time_us, &interrupt::is_asked);
                self.go_back(past)
            }
            Err(reason) => self.wrong(&reason),
        }
    }

    /// Takes an earlier state; none if Ctrl-C came first.
    fn go_back(&mut self, past: Option<Past<Robot>>) -> Result<()> {
        let Some(past) = past else {
            self.console.note("interrupted on the way back; the run stands where it stood");
            return self.show_stop();
        };
        let is_start = past.position.segment == 0;
        let texts = texts(&self.session.branch.system);
        self.session.go_back_to(past);
        self.tell_other_texts(&texts);
        if is_start {
            self.console.note(START);
        }
        self.show_stop()
    }

    /// Tells which definitions are others than in the state that was left: they belong to the run
    /// and its time, as everything does.
    fn tell_other_texts(&mut self, left: &BTreeMap<String, String>) {
        let here = texts(&self.session.branch.system);
        let differs = left.iter().filter_map(|(name, text)| match here.get(name) {
            None => Some(format!("`{name}` is not defined")),
            Some(other) if other != text => Some(format!("`{name}` has another text")),
            Some(_) => None,
        });
        let differs: Vec<String> = differs.collect();
        if !differs.is_empty() {
            self.console.note(&format!("definitions are those of this instant: here {}", differs.join(", ")));
        }
    }

    /// Keeps this run as it stands under another name.
    pub(super) fn fork(&mut self, name: &str) -> Result<()> {
        if name.is_empty() {
            return self.wrong("`:fork NAME`: a name is expected");
        }
        if name == self.session.name {
            return self.wrong(&format!("this run is called `{name}` already"));
        }
        if self.session.others.contains_key(name) {
            return self.wrong(&format!("a run is kept as `{name}` already; another name is needed"));
        }
        self.session.others.insert(name.to_string(), self.session.branch.clone());
        self.console.note(&format!("kept as `{name}`; `:switch {name}` goes there"));
        Ok(())
    }

    /// The runs there are, this one first.
    pub(super) fn forks(&self) -> Vec<String> {
        let line =
            |mark: char, name: &str, branch: &Branch| format!("{mark} {name}  {:.1} s", branch.system.machine.now_s());
        let mut lines = vec![line('*', &self.session.name, &self.session.branch)];
        lines.extend(self.session.others.iter().map(|(name, branch)| line(' ', name, branch)));
        lines
    }

    /// Goes to a run that is kept, and keeps this one.
    pub(super) fn switch(&mut self, name: &str) -> Result<()> {
        let Some(branch) = self.session.others.remove(name) else {
            let near = suggest(name, self.session.others.keys().map(String::as_str));
            let meant = near.map_or(String::new(), |near| format!("did you mean `{near}`? "));
            return self.wrong(&format!("no run is called `{name}`; {meant}`:forks` lists them"));
        };
        let texts = texts(&self.session.branch.system);
        let left = std::mem::replace(&mut self.session.branch, branch);
        let left_name = std::mem::replace(&mut self.session.name, name.to_string());
        self.session.others.insert(left_name, left);
        self.session.restore_conditions();
        self.tell_other_texts(&texts);
        self.show_stop()
    }
}
