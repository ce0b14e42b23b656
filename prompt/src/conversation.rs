//! A person at the prompt: lines are typed, and with `:go` the run goes on by the clock meanwhile.

use super::clock::{Clock, parse_factor};
use super::line_editor::Typed;
use super::line_thread::LineThread;
use super::vocabulary::Vocabulary;
use super::{AfterLine, Prompt};
use anyhow::Result;
use rpl_drive::stopping::halt::{Halt, Until};
use rpl_shell::interrupt;
use rpl_shell::status::Status;
use std::io::{self, IsTerminal};
use std::time::{Duration, Instant};

/// How long the run may keep the prompt waiting for what is typed.
const SLICE: Duration = Duration::from_millis(50);

/// How often the prompt shows another time.
const PROMPT_EVERY: Duration = Duration::from_millis(500);

impl Prompt<'_> {
    /// Line by line, with a person.
    pub(super) fn converse(&mut self) -> Result<()> {
        let mut terminal = LineThread::open(self.console.colour)?;
        self.console.note(&format!(
            "rpl {}  `:help` lists the commands, `:doc NAME` documents a name, Ctrl-D ends",
            env!("CARGO_PKG_VERSION")
        ));
        loop {
            self.console.flush()?;
            terminal.print_above(&self.console.take_kept())?;
            terminal.ask(self.prompt_text(), Vocabulary::of(&self.session, &self.places))?;
            let text = match self.typed(&mut terminal)? {
                Typed::Text(text) => text,
                Typed::Cancelled { was_empty } => {
                    if was_empty && self.clock.is_some() {
                        self.stop_clock()?;
                    }
                    continue;
                }
                Typed::End => break,
            };
            let text = match (text.trim(), &self.repeated) {
                ("", Some(repeated)) => repeated.clone(),
                (word, _) => self.meant_by(word).map_or(text, str::to_string),
            };
            self.console.keep(self.clock.is_some());
            let _gives_back = interrupt::gives_prompt_back();
            if self.handle(&text)? == AfterLine::Quit {
                break;
            }
        }
        self.console.keep(false);
        // Somebody was there to see what went wrong.
        self.worst = Status::Succeeded;
        Ok(())
    }

    /// The command that is meant by a word of other prompts, unless the session gives the word a meaning.
    fn meant_by(&self, word: &str) -> Option<&'static str> {
        let command = match word {
            "help" | "?" => ":help",
            "exit" | "quit" => ":quit",
            _ => return None,
        };
        let system = &self.session.branch.system;
        let is_defined = system.machine.symbols.find(word).is_some_and(|name| system.program.names.contains_key(&name));
        (!is_defined).then_some(command)
    }

    /// The next line; until it is there the run goes on if the clock does.
    fn typed(&mut self, terminal: &mut LineThread) -> Result<Typed> {
        let mut shown = Instant::now();
        let gives_back = self.clock.map(|_| interrupt::gives_prompt_back());
        while let Some(clock) = self.clock {
            let next_us = self.session.branch.system.next_instant_us();
            let has_work = self.session.has_work();
            let wait = if has_work { Duration::ZERO } else { clock.wait_for(next_us) };
            if let Some(line) = terminal.line_within(wait)? {
                return Ok(line);
            }
            self.tick(clock)?;
            self.look_at_projecting()?;
            let lines = self.console.take_kept();
            terminal.print_above(&lines)?;
            if !lines.is_empty() || self.clock.is_none() || shown.elapsed() >= PROMPT_EVERY {
                terminal.show_prompt(&self.live_prompt())?;
                self.note_reached();
                shown = Instant::now();
            }
        }
        drop(gives_back);
        self.look_at_projecting()?;
        terminal.print_above(&self.console.take_kept())?;
        terminal.line()
    }

    /// Goes on to what is due.
    fn tick(&mut self, clock: Clock) -> Result<()> {
        let until = Until::Clock { due_us: clock.due_us(), before: Instant::now() + SLICE };
        match self.session.go_on(&until, self.console)? {
            Halt::Arrived => {
                let now_us = self.session.branch.system.machine.now_us;
                if matches!(until, Until::Clock { before, .. } if Instant::now() >= before) {
                    self.clock = Some(clock.restarted(now_us));
                }
                Ok(())
            }
            halt @ Halt::Answered(_) => self.halted(halt),
            halt @ (Halt::Breakpoint(_) | Halt::Interrupted) => {
                self.clock = None;
                self.halted(halt)
            }
        }
    }

    /// `:go`: from now on the run goes on by the clock.
    pub(super) fn go(&mut self, rest: &str) -> Result<()> {
        let Some(factor) = parse_factor(rest) else {
            return self.wrong(&format!("`{rest}` is no number above 0; `:go 10` goes ten times as fast as the clock"));
        };
        if !self.is_interactive || !io::stdout().is_terminal() {
            return self.wrong("`:go` needs somebody at a terminal; `:continue` and `:until` go on without");
        }
        self.clock = Some(Clock::new(factor, self.session.branch.system.machine.now_us));
        self.console.keep(true);
        Ok(())
    }

    /// `:stop`, and Ctrl-C on an empty line.
    pub(super) fn stop_clock(&mut self) -> Result<()> {
        if self.clock.take().is_none() {
            return self.wrong("the clock does not run; `:go` starts it");
        }
        let now_s = self.session.branch.system.machine.now_s();
        self.console.note(&format!("stopped at {now_s:.3} s; `:go` goes on by the clock, `:continue` at once"));
        Ok(())
    }

    /// The prompt while the clock runs, and when it has just stopped: always as wide.
    pub(super) fn live_prompt(&self) -> String {
        let state = if self.clock.is_some() { "running" } else { "stopped" };
        format!("rpl {:>6.1}s {state}> ", self.session.branch.system.machine.now_s())
    }
}
