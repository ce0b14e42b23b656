//! What became of the orders of a day at the office.

use super::quantity::Quantity;
use rpl_mission::modules::SiteRobot;
use rpl_robot::geometry::{Point, distance_m};
use rpl_robot::simulator::ItemPlace;

/// A thing is at a place if it lies this near to where the robot stands there: it is put down, and
/// laid ready, within the gripper's reach.
pub(super) const AT_PLACE_M: f64 = 1.0;

/// The orders of a run, by the truth about the things at its end.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Day {
    due: u32,
    delivered: u32,
    lost: u32,
    doubled: u32,
    in_time: u32,
    interruptions: u32,
    continued: u32,
}

impl Day {
    /// The account of a run; none if nobody ordered anything.
    pub fn of(robot: &SiteRobot, logs: &[String]) -> Option<Self> {
        let state = &robot.host.state;
        let begin_with = |word: &str| logs.iter().filter(|log| log.starts_with(word)).count() as u32;
        let mut day = Self {
            in_time: begin_with("in time"),
            interruptions: begin_with("interrupted"),
            continued: begin_with("continued"),
            ..Self::default()
        };
        let orders = state.messages.iter().filter_map(|words| match words.as_slice() {
            [what, item, from, to, ..] if what == "deliver" => Some((item, from, to)),
            _ => None,
        });
        let is_at = |point: Point, place: &str| {
            let place = robot.model().world.place(place);
            place.is_ok_and(|place| distance_m(place.pose_in_map.point(), point) <= AT_PLACE_M)
        };
        for (item, from, to) in orders {
            day.due += 1;
            let Some(item) = state.gripper.items.iter().find(|known| known.name == *item) else {
                day.lost += 1;
                continue;
            };
            day.doubled += u32::from(item.put_down > 1);
            match item.at {
                ItemPlace::Point(point) if is_at(point, to) => day.delivered += 1,
                ItemPlace::Point(point) if !is_at(point, from) => day.lost += 1,
                ItemPlace::Point(_) | ItemPlace::Held => {}
            }
        }
        (day.due > 0).then_some(day)
    }

    /// What is not as it should be: all delivered once, and all gone on with that was interrupted.
    pub fn fault(&self) -> Option<String> {
        let faults = [
            (self.lost, "lost"),
            (self.doubled, "doubled"),
            (self.due.saturating_sub(self.delivered + self.lost), "not delivered"),
            (self.interruptions.saturating_sub(self.continued), "not continued"),
        ];
        faults.iter().find(|(count, _)| *count > 0).map(|(count, what)| format!("{what}: {count}"))
    }

    /// The rows of the table.
    pub fn measures(&self) -> [(Quantity, Option<f64>); 7] {
        [
            (Quantity::OrdersDue, self.due),
            (Quantity::OrdersDelivered, self.delivered),
            (Quantity::OrdersLost, self.lost),
            (Quantity::OrdersDoubled, self.doubled),
            (Quantity::OrdersInTime, self.in_time),
            (Quantity::Interruptions, self.interruptions),
            (Quantity::Continued, self.continued),
        ]
        .map(|(quantity, count)| (quantity, Some(f64::from(count))))
    }
}
