//! Going on with a run, to wherever it is to stop, and what is shown there.

use super::Prompt;
use super::listings::value_text;
use super::standpoint::standpoint;
use anyhow::Result;
use rpl_drive::show::why::shortened;
use rpl_drive::stopping::breakpoint::Breakpoint;
use rpl_drive::stopping::halt::{Halt, Until};
use rpl_lang::compile::NoFiles;
use rpl_runtime::run::session::Answer;
use rpl_shell::arguments::duration::parse_duration_us;
use rpl_shell::terminal::layout::terminal_size;

impl Prompt<'_> {
    pub(super) fn go_on(&mut self, until: &Until) -> Result<()> {
        if !self.session.branch.is_running {
            return self.wrong("nothing runs; type a form, or `:step FORM` to go through one");
        }
        if let Some(stop) = self.session.branch.stop.clone() {
            self.session.branch.system.want_value(&stop);
        }
        let halt = self.session.go_on(until, self.console)?;
        self.halted(halt)
    }

    pub(super) fn halted(&mut self, halt: Halt) -> Result<()> {
        let value = self.session.branch.system.wanted_value();
        // Where the stepper stands again: at the end the value itself is shown.
        if let (Some(value), true) = (value, self.session.branch.stop.is_some()) {
            self.console.print(&format!("=> {}", shortened(&value)))?;
        }
        match halt {
            Halt::Answered(Answer::Succeeded(value)) => self.show_value(value, self.session.number)?,
            Halt::Answered(Answer::Failed(failure)) => {
                self.show_failure(failure);
                if self.session.breakpoints.contains(&Breakpoint::Failure) {
                    self.back_to_failure()?;
                }
            }
            Halt::Answered(Answer::GivenUp) => self.console.note("given up, clean-ups done"),
            Halt::Arrived => self.show_stop()?,
            Halt::Breakpoint(place) => {
                self.console.note(&format!("stopped at {place}"));
                self.show_stop()?;
            }
            Halt::Interrupted => {
                self.console.note("interrupted; `:continue` goes on, `:abort` gives up, `:why` tells what it does");
                self.show_stop()?;
            }
        }
        Ok(())
    }

    /// Where the run stands, and what is watched.
    pub(super) fn show_stop(&mut self) -> Result<()> {
        let lines = match self.session.branch.stop.clone() {
            Some(stop) => {
                let width = if self.is_interactive { terminal_size().0 } else { usize::MAX };
                standpoint(&self.session.branch.system, &stop, self.console.colour, width)
            }
            None => vec![format!("{:.3} s", self.session.branch.system.machine.now_s())],
        };
        self.explain(&lines)?;
        for watch in self.session.watches.clone() {
            // In a copy: what is watched must not touch the run.
            let mut copy = self.session.branch.system.clone();
            let shown = match copy.inspect("watch", &watch, &[], &mut NoFiles) {
                Ok((_, Ok(value))) => value_text(&copy, value),
                Ok((_, Err(failure))) => copy.machine.show(&copy.program, failure),
                Err(_) => "not a form that can be evaluated here".to_string(),
            };
            self.console.explain(&format!("    {watch} = {shown}"))?;
        }
        Ok(())
    }

    pub(super) fn until(&mut self, rest: &str) -> Result<()> {
        let until = match parse_duration_us(rest) {
            Ok(time_us) if !rest.chars().all(|c| c.is_ascii_digit()) => Until::Time(time_us),
            _ if rest.is_empty() => {
                return self.wrong("`:until` needs a time such as 12.5s, a line, a name or a condition");
            }
            _ => match self.breakpoint(rest) {
                Ok(place) => Until::Place(place),
                Err(reason) => return self.wrong(&reason),
            },
        };
        self.go_on(&until)
    }

    fn breakpoint(&mut self, text: &str) -> Result<Breakpoint, String> {
        let file = self.session.file.as_deref();
        Breakpoint::parse(text, file, &mut self.session.branch.system, self.console.colour)
    }

    pub(super) fn set_break(&mut self, rest: &str) -> Result<()> {
        if rest.is_empty() {
            let places = self.session.breakpoints.iter().enumerate();
            let mut lines: Vec<String> = places.map(|(index, place)| format!("{}  {place}", index + 1)).collect();
            if lines.is_empty() {
                lines.push(
                    "no breakpoints; `:break NAME`, `:break 12` or `:break (< pos-certainty* 0.5)` sets one".into(),
                );
            }
            return self.explain(&lines);
        }
        match self.breakpoint(rest) {
            Ok(place) => {
                self.session.breakpoints.push(place);
                Ok(())
            }
            Err(reason) => self.wrong(&reason),
        }
    }

    pub(super) fn delete(&mut self, rest: &str) -> Result<()> {
        let count = self.session.breakpoints.len();
        match rest.parse::<usize>() {
            _ if rest.is_empty() => self.session.breakpoints.clear(),
            Ok(number) if (1..=count).contains(&number) => drop(self.session.breakpoints.remove(number - 1)),
            _ => {
                let rest = shortened(rest);
                return self.wrong(&format!("there is no breakpoint `{rest}`; `:break` lists them"));
            }
        }
        Ok(())
    }

    pub(super) fn abort(&mut self) -> Result<()> {
        if !self.session.branch.is_running {
            return self.wrong("nothing runs");
        }
        let halt = self.session.give_up(self.console)?;
        self.halted(halt)
    }
}
