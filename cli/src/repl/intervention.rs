//! What came to a run, while it stood still, that is repeated at the prompt.

use super::session::Session;
use crate::journal::Change;
use crate::terminal::console::Console;

/// What came to a run from outside its plan, at the end of an instant.
#[derive(Clone, Debug)]
pub enum Intervention {
    /// New definitions.
    Change(Change),
    /// It was gone on with after its process had died, at the instant of this number.
    Resumption(u32),
}

impl Intervention {
    /// The number of the instant; none if it has not come to that.
    pub fn instant(&self) -> Option<u32> {
        match self {
            Intervention::Change(change) => change.instant,
            Intervention::Resumption(instant) => Some(*instant),
        }
    }
}

impl Session {
    /// What came at the end of this instant comes again. Whether anything did, and something may run now.
    pub fn intervene(&mut self, console: &mut Console) -> bool {
        let branch = &mut self.branch;
        let now = branch.system.machine.instant;
        let next = self.interventions.get(branch.interventions.len());
        let Some(next) = next.filter(|next| next.instant().is_some_and(|instant| instant <= now)) else { return false };
        match next {
            Intervention::Change(change) => {
                if let Err(error) = change.apply(&mut branch.system) {
                    console.note(&format!("error: {error:#}"));
                }
            }
            Intervention::Resumption(_) => _ = branch.system.renew_outside(),
        }
        branch.timeline.handed_in(&branch.system);
        branch.interventions.push(branch.timeline.position.segment);
        true
    }
}
