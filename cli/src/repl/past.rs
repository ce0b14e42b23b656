//! Earlier instants of a run, and runs that are kept side by side.

use super::command::Verb;
use super::{Prompt, session, view};
use crate::interrupt;
use crate::mission::Robot;
use crate::time::parse_duration_us;
use anyhow::Result;
use rpl_runtime::timeline::Past;

impl Prompt<'_> {
    pub(super) fn back(&mut self, rest: &str) -> Result<()> {
        interrupt::forget();
        let timeline = &self.session.branch.timeline;
        let now_us = self.session.branch.system.machine.now_us;
        let past = match (rest.parse::<usize>(), parse_duration_us(rest)) {
            _ if rest.is_empty() => timeline.steps_before(timeline.position, 1, view::is_shown, &interrupt::is_asked),
            (Ok(steps), _) => timeline.steps_before(timeline.position, steps, view::is_shown, &interrupt::is_asked),
            (_, Ok(time_us)) => timeline.at_time(now_us.saturating_sub(time_us), &interrupt::is_asked),
            _ => return self.wrong(&format!("`{rest}` is neither a number of steps nor a time such as 10s")),
        };
        self.go_back(past)
    }

    pub(super) fn at(&mut self, rest: &str) -> Result<()> {
        interrupt::forget();
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
        self.session.go_back_to(past);
        if is_start {
            self.console.note("this is the start");
        }
        self.show_stop()
    }

    pub(super) fn forks(&mut self, verb: Verb, rest: &str) -> Result<()> {
        match verb {
            Verb::Fork if rest.is_empty() => return self.wrong("`:fork NAME`: a name is expected"),
            Verb::Fork if rest == self.session.name => {
                return self.wrong(&format!("this run is called `{rest}` already"));
            }
            Verb::Fork => {
                self.session.others.insert(rest.to_string(), self.session.branch.clone());
                self.console.note(&format!("kept as `{rest}`; `:switch {rest}` goes there"));
            }
            Verb::Switch => match self.session.others.remove(rest) {
                Some(branch) => {
                    let left = std::mem::replace(&mut self.session.branch, branch);
                    let name = std::mem::replace(&mut self.session.name, rest.to_string());
                    self.session.others.insert(name, left);
                    self.session.restore_conditions();
                    self.show_stop()?;
                }
                None => return self.wrong(&format!("no run is called `{rest}`; `:forks` lists them")),
            },
            _ => {
                let line = |mark: char, name: &str, branch: &session::Branch| {
                    format!("{mark} {name}  {:.1} s", branch.system.machine.now_s())
                };
                let mut lines = vec![line('*', &self.session.name, &self.session.branch)];
                lines.extend(self.session.others.iter().map(|(name, branch)| line(' ', name, branch)));
                self.explain(&lines)?;
            }
        }
        Ok(())
    }
}
