//! What came to a run, while it stood still, comes again where it came.

use super::intervention::Intervention;
use super::session::Session;
use rpl_shell::terminal::console::Console;

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
