//! Valves: who has their places, and who waits for them in which order.

use super::Writer;
use crate::state::valve_place::{LinkKind, Place};

impl Writer<'_> {
    pub(super) fn valves(&mut self) {
        let machine = self.machine;
        for (number, valve) in machine.valves.iter().enumerate() {
            let is_at_rest = |place: u32| machine.places[place as usize].is_at_rest();
            if valve.waiters.is_empty() && valve.places().all(is_at_rest) {
                continue;
            }
            self.number(number as u64 + 1);
            let line = valve.in_line();
            self.number(line.len() as u64);
            for task in line {
                self.task(task);
                self.byte(u8::from(valve.waiters.get(&task).is_some_and(|waiter| waiter.line.is_some())));
            }
            for place in valve.places() {
                self.place(&machine.places[place as usize]);
            }
        }
        self.byte(0);
    }

    fn place(&mut self, place: &Place) {
        self.number(place.links.len() as u64);
        for link in &place.links {
            self.reference(link.task);
            match link.kind {
                LinkKind::Mark => self.byte(0),
                LinkKind::Hold { count, purpose } => {
                    self.byte(1);
                    self.plain(&(count, purpose));
                }
            }
        }
        self.plain(&place.handover);
        self.optional_task(place.claim.map(|claim| claim.root));
    }
}
