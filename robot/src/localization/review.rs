//! When the tracked pose is compared with all places that there are.

use super::contest::{Claim, KEPT_UPDATES};
use serde::{Deserialize, Serialize};

/// All places are compared at the latest after this many updates, if scans have been explained badly.
const LONGEST_REVIEW_UPDATES: usize = 640;

/// When the tracked pose is compared with all places that there are, not only with those that the coarse belief objects
/// with: what a robot at a wrong place hears is laid to the map time and again, and what is usual is learned there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Review {
    /// Whether the robot gets no nearer where the map shows a way.
    is_held_up: bool,
    /// Updates until then, if the scans ask for it.
    due_in_updates: usize,
    /// Updates from then to the next time: where the map has aged they always ask.
    interval_updates: usize,
}

impl Default for Review {
    fn default() -> Self {
        Self { is_held_up: false, due_in_updates: KEPT_UPDATES, interval_updates: KEPT_UPDATES }
    }
}

impl Review {
    /// Takes in whether the robot gets no nearer. As soon as it does not, the review is due.
    pub fn note_held_up(&mut self, is_held_up: bool) {
        if is_held_up && !self.is_held_up {
            *self = Self { due_in_updates: 0, ..Self::default() };
        }
        self.is_held_up = is_held_up;
    }

    /// Why places are compared, if not for the robot being held up.
    pub fn claim(&self, otherwise: Claim) -> Claim {
        if self.is_held_up { Claim::HeldUp } else { otherwise }
    }

    /// Takes in an update; whether it is due at this one.
    pub fn pass_update(&mut self) -> bool {
        self.due_in_updates = self.due_in_updates.saturating_sub(1);
        self.due_in_updates == 0
    }

    /// Nothing asked for it, or nothing is tracked any more.
    pub fn begin_anew(&mut self) {
        *self = Self { is_held_up: self.is_held_up, ..Self::default() };
    }

    /// No place has won: the next one comes later.
    pub fn put_off(&mut self) {
        self.due_in_updates = self.interval_updates;
        if !self.is_held_up {
            self.interval_updates = (2 * self.interval_updates).min(LONGEST_REVIEW_UPDATES);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_places_are_compared_when_the_robot_is_held_up_and_ever_more_seldom_where_none_wins() {
        let mut review = Review::default();
        let updates = |review: &mut Review| 1 + (0..10_000).take_while(|_| !review.pass_update()).count();
        assert_eq!(updates(&mut review), KEPT_UPDATES);
        let intervals = [0; 6].map(|_| {
            review.put_off();
            updates(&mut review)
        });
        assert_eq!(intervals, [40, 80, 160, 320, 640, 640]);
        review.note_held_up(true);
        assert_eq!(updates(&mut review), 1);
        for _ in 0..3 {
            review.put_off();
            review.note_held_up(true);
            assert_eq!(updates(&mut review), KEPT_UPDATES, "as long as it is held up");
        }
    }
}
