//! What keeps the prompt alive: no command ends it but the one that is to.

use super::{AfterLine, Prompt};
use anyhow::Result;
use rpl_shell::interrupt;
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Whether nobody reads any more: only that ends the prompt from outside. All else that goes wrong
/// is told as a text, so that no other input or output error gets here.
pub(super) fn is_output_gone(error: &anyhow::Error) -> bool {
    error.is::<io::Error>()
}

impl Prompt<'_> {
    /// Does what a line asks for, and survives it: what goes wrong is told, and after a fault of the
    /// program itself the run stands again where it stood before.
    ///
    /// # Errors
    /// Standard output is closed.
    pub(super) fn guarded(&mut self, act: impl FnOnce(&mut Self) -> Result<AfterLine>) -> Result<AfterLine> {
        let position = self.session.branch.timeline.position;
        let breakpoints = self.session.breakpoints.clone();
        match catch_unwind(AssertUnwindSafe(|| act(self))) {
            Ok(Err(error)) if !is_output_gone(&error) => {
                self.wrong(&format!("{error:#}"))?;
                Ok(AfterLine::Another)
            }
            Ok(done) => done,
            Err(_) => {
                self.console.end_status();
                self.clock = None;
                interrupt::forget();
                if let Some(past) = self.session.branch.timeline.at(position, &|| false) {
                    self.session.go_back_to(past);
                }
                self.session.breakpoints = breakpoints;
                self.session.restore_conditions();
                let fault = self.faults.take();
                self.wrong(&format!(
                    "a fault of rpl itself: {fault}\nthe run stands where it stood before; please report what was typed"
                ))?;
                Ok(AfterLine::Another)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::faults::Faults;
    use crate::session::Session;
    use rpl_drive::stopping::halt::Until;
    use rpl_mission::site::Site;
    use rpl_shell::terminal::console::Console;

    fn with_prompt(act: impl FnOnce(&mut Prompt<'_>)) -> Vec<String> {
        let site = Site::without_robot().expect("a site");
        let mut console = Console::keeping();
        let mut prompt = Prompt::new(Session::new(&site, site.robot(1), 1).expect("a session"), &mut console, false);
        act(&mut prompt);
        console.take_kept()
    }

    #[test]
    fn a_fault_of_the_program_ends_neither_the_prompt_nor_the_run() {
        let kept = with_prompt(|prompt| {
            let before = prompt.faults.catch();
            prompt.forms("(defvar n 1)", &Until::End).expect("it is written");
            prompt.forms("(wait-time 2)", &Until::End).expect("it is written");
            let next = prompt.guarded(|prompt| {
                prompt.forms("(setf n 2)", &Until::End)?;
                panic!("a made-up fault")
            });
            assert_eq!(next.expect("it goes on"), AfterLine::Another);
            Faults::let_go(before);
            prompt.forms("(list n (now))", &Until::End).expect("it is written");
        });
        assert!(kept.iter().any(|line| line.contains("a made-up fault (prompt/src/guard.rs:")), "{kept:?}");
        assert_eq!(kept.last().map(String::as_str), Some("(1 2.0)"), "what it did is undone");
    }

    #[test]
    fn any_error_but_a_closed_output_is_told() {
        let kept = with_prompt(|prompt| {
            let next = prompt.guarded(|_| anyhow::bail!("something is missing"));
            assert_eq!(next.expect("it goes on"), AfterLine::Another);
            let closed = prompt.guarded(|_| Err(io::Error::from(io::ErrorKind::BrokenPipe).into()));
            assert!(closed.is_err());
        });
        assert_eq!(kept, ["error: something is missing"]);
    }
}
