//! What came to a run, while it stood still, that is repeated at the prompt.

use rpl_drive::journal::Change;

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
