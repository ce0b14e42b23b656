//! What looks on at a run, and changes nothing of it.

use crate::events::ToldLine;
use anyhow::Result;
use rpl_mission::robot::Robot;
use rpl_mission::sight::Sight;
use rpl_runtime::state::trace::Event;

/// What happened in an instant, or in a part of one that is long.
pub struct Happened<'a> {
    /// When, in virtual time.
    pub now_us: u64,
    /// The events in their order.
    pub events: &'a [Event],
    /// What a person is told of them and what the plan wrote, in the order of happening.
    pub told: &'a [ToldLine],
    /// Whether the robot does not know its position.
    pub is_lost: bool,
}

/// Something that looks on at a run: a recording, a page in a browser, figures. The driver calls it, and it sees no
/// more of the driver. Another one is a file that implements this, and a line where the run is prepared.
pub trait Onlooker {
    /// Takes in what happened.
    ///
    /// # Errors
    /// It cannot be written down; the run is stopped then.
    fn happened(&mut self, happened: &Happened<'_>, robot: &mut Robot) -> Result<()>;

    /// The run has come to another instant, in which the robot may have made a step.
    ///
    /// # Errors
    /// As for [`Onlooker::happened`].
    fn stepped(&mut self, _now_us: u64, _robot: &mut Robot) -> Result<()> {
        Ok(())
    }

    /// Ten times a second: where the robot is.
    ///
    /// # Errors
    /// As for [`Onlooker::happened`].
    fn seen(&mut self, _now_us: u64, _sight: &Sight, _robot: &mut Robot) -> Result<()> {
        Ok(())
    }

    /// The run is over.
    ///
    /// # Errors
    /// What is written at the end cannot be.
    fn ends(&mut self) -> Result<()> {
        Ok(())
    }
}
