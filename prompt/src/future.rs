//! Looking ahead: how what runs, or a form, would go.

use super::Prompt;
use super::projecting::{Projected, Projecting, projected};
use anyhow::Result;
use rpl_drive::show::projection::blocks;
use rpl_runtime::state::projected::Grain;

impl Prompt<'_> {
    /// `:project`. A further one takes the place of one that is under way.
    pub(super) fn project(&mut self, words: &str) -> Result<()> {
        let (grain, form) = grain_of(words);
        let system = &self.session.branch.system;
        let is_idle = system.is_waiting_for_form();
        let (text, told) = match (form.is_empty(), is_idle) {
            (true, true) => (None, Some("nothing runs; type `:project FORM`")),
            (false, false) => (None, Some("a form is under way; `:project` alone tells how it would go on")),
            (true, false) => (None, None),
            (false, true) => (Some(("projected", form)), None),
        };
        if let Some(told) = told {
            self.console.note(told);
            return Ok(());
        }
        let seed = system.machine.now_us;
        match system.fork_to_project(text, grain) {
            Err(why) => self.tell_projected(Some(Err(why))),
            Ok(run) if self.clock.is_some() => {
                self.projecting = Some(Projecting::begin(run, seed));
                Ok(())
            }
            Ok(run) => self.tell_projected(projected(run, seed, &|| false)),
        }
    }

    /// Tells what came of a projection under way, if it has ended; when the clock has stopped, nothing else is to do
    /// until it has.
    pub(super) fn look_at_projecting(&mut self) -> Result<()> {
        let is_last = self.clock.is_none();
        let projecting = self.projecting.take_if(|projecting| is_last || projecting.has_ended());
        projecting.map_or(Ok(()), |projecting| self.tell_projected(projecting.end()))
    }

    fn tell_projected(&mut self, projected: Projected) -> Result<()> {
        match projected {
            None => {}
            Some(Ok(figures)) => blocks(&figures).iter().try_for_each(|block| self.console.block(block))?,
            Some(Err(why)) => self.console.note(why.trim_end()),
        }
        Ok(())
    }
}

/// The grain that is asked for before a form, and the form.
fn grain_of(words: &str) -> (Grain, &str) {
    let named = Grain::ALL.into_iter().find_map(|grain| {
        let form = words.strip_prefix(':')?.strip_prefix(grain.name())?;
        (form.is_empty() || form.starts_with([' ', '('])).then(|| (grain, form.trim_start()))
    });
    named.unwrap_or((Grain::default(), words))
}
