//! What belongs to a run that is driven: what looks on at it, writes it down, and steers it.

use crate::journal::RunJournal;
use crate::observed::Observed;
use crate::onlooker::Onlooker;
use crate::seen::Steering;
use crate::trace::TraceFile;
use rpl_link::recording::Recorder;
use std::sync::Arc;

/// What belongs to a run while it goes on.
#[derive(Default)]
pub struct Records {
    /// Where the trace goes. It is no onlooker: a journal goes on with it.
    pub trace: Option<TraceFile>,
    /// Where the run is written down so that it can be gone on with.
    pub journal: Option<RunJournal>,
    /// Where it is written that the run was told to stop.
    pub recorder: Option<Arc<Recorder>>,
    /// How often the trace tells where the robot is, if it does.
    pub pose_every_us: Option<u64>,
    /// When it does so next.
    pub pose_due_us: u64,
    /// The page's hand on the run, if there is one.
    pub steering: Option<Steering>,
    /// What was observed of it so far.
    pub observed: Observed,
    /// What else looks on.
    pub onlookers: Vec<Box<dyn Onlooker>>,
}

impl Records {
    /// All that look on.
    pub fn onlookers(&mut self) -> impl Iterator<Item = &mut dyn Onlooker> {
        let observed: &mut dyn Onlooker = &mut self.observed;
        std::iter::once(observed).chain(self.onlookers.iter_mut().map(|onlooker| &mut **onlooker as &mut dyn Onlooker))
    }
}
