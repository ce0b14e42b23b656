//! What keeps the prompt alive: no command ends it but the one that is to.

use super::{AfterLine, Prompt};
use crate::interrupt;
use anyhow::Result;
use std::any::Any;
use std::io;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::sync::{Arc, Mutex};

/// Where the last fault of the program was, for the user; nothing is written of it by itself.
#[derive(Clone, Default)]
pub struct Faults(Arc<Mutex<Option<String>>>);

type Hook = Box<dyn Fn(&PanicHookInfo<'_>) + Sync + Send>;

impl Faults {
    /// Notes faults of the present thread from now on, instead of writing them between the lines
    /// of the prompt; what it gives back is to be set when the prompt has ended.
    pub fn catch(&self) -> Arc<Hook> {
        let before: Arc<Hook> = Arc::new(take_hook());
        let (faults, usual) = (self.0.clone(), before.clone());
        let prompt = std::thread::current().id();
        set_hook(Box::new(move |panic| {
            if std::thread::current().id() != prompt {
                return usual(panic);
            }
            let place = panic.location().map_or(String::new(), |place| format!(" ({}:{})", place.file(), place.line()));
            if let Ok(mut last) = faults.lock() {
                *last = Some(format!("{}{place}", message(panic.payload())));
            }
        }));
        before
    }

    /// Writes faults as before.
    pub fn let_go(before: Arc<Hook>) {
        drop(take_hook());
        set_hook(Box::new(move |panic| before(panic)));
    }

    fn take(&self) -> String {
        let last = self.0.lock().map_or(None, |mut last| last.take());
        last.unwrap_or_else(|| "of an unknown kind".to_string())
    }
}

fn message(payload: &(dyn Any + Send)) -> &str {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| payload.downcast_ref::<&str>().copied()).unwrap_or("of an unknown kind")
}

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
    use crate::repl::halt::Until;
    use crate::repl::session::Session;
    use crate::terminal::console::Console;
    use rpl_mission::site::Site;

    fn with_prompt(act: impl FnOnce(&mut Prompt<'_>)) -> Vec<String> {
        let site = Site::without_robot().expect("a site");
        let mut console = Console::keeping();
        let mut prompt = Prompt::new(Session::new(&site, 1).expect("a session"), &mut console, false);
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
        assert!(kept.iter().any(|line| line.contains("a made-up fault (cli/src/repl/guard.rs:")), "{kept:?}");
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
