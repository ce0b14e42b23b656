//! What the abstract robot draws from.

use rpl_random::Stream;

/// Streams by what is drawn from them, so that a plan that grasps once more still meets the same people.
#[derive(Clone, Debug)]
pub(super) struct Streams {
    pub drives: Stream,
    pub doors: u64,
    pub grasps: Stream,
    pub things: u64,
    pub searches: Stream,
    pub acts: Stream,
}

impl Streams {
    pub fn of(seed: u64) -> Self {
        Self {
            drives: Stream::new(seed, "foreseen drives"),
            doors: seed,
            grasps: Stream::new(seed, "foreseen grasps"),
            things: seed,
            searches: Stream::new(seed, "foreseen searches"),
            acts: Stream::new(seed, "foreseen acts"),
        }
    }
}
