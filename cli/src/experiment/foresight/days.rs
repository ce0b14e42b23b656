//! The days: kinds by what comes between, and what happens on one, drawn from its seed.

use rpl_random::Stream;
use rpl_robot::foresight::models::Chances;
use rpl_robot::office::{AbstractSetting, Forecast};

/// A kind of days, by up to three contingencies.
pub(super) struct DayKind {
    /// What it is called.
    pub name: &'static str,
    /// How long after it came an order is due: at least, at most, in seconds.
    due_s: [f64; 2],
    /// Orders come together, a handful at a time.
    has_bursts: bool,
    /// The charge at the start.
    battery: f64,
    /// Two rooms close at some time.
    has_closings: bool,
    /// How often a thing is not where it should be.
    missing: f64,
}

const DEADLINES: DayKind = DayKind {
    name: "deadlines",
    due_s: [150.0, 600.0],
    has_bursts: false,
    battery: 0.9,
    has_closings: false,
    missing: 0.01,
};

/// The first has no contingency; then each alone, two and three together.
pub(super) const KINDS: [DayKind; 8] = [
    DayKind { name: "no contingencies", due_s: [1200.0, 2400.0], ..DEADLINES },
    DEADLINES,
    DayKind { name: "bursts", has_bursts: true, ..DEADLINES },
    DayKind { name: "low battery", battery: 0.06, ..DEADLINES },
    DayKind { name: "closings", has_closings: true, ..DEADLINES },
    DayKind { name: "missing things", missing: 0.25, ..DEADLINES },
    DayKind { name: "bursts, closings", has_bursts: true, has_closings: true, ..DEADLINES },
    DayKind {
        name: "bursts, low battery, missing things",
        has_bursts: true,
        battery: 0.06,
        missing: 0.25,
        ..DEADLINES
    },
];

/// Where things are fetched and brought.
const PLACES: [&str; 6] = ["east-end", "mail-slots", "a-desk", "c-centre", "d-centre", "wolframs-shelf"];

/// Rooms that may close.
const ROOMS: [&str; 4] = ["a-desk", "c-centre", "d-centre", "wolframs-shelf"];

/// Orders come for so long, so many in an hour.
const DAY_S: f64 = 2400.0;
const ORDERS_AN_HOUR: [f64; 2] = [30.0, 55.0];

/// Orders of a burst.
const BURST: usize = 5;

/// What comes between on all days.
const USUAL: Chances =
    Chances { grasp_misses: 0.03, release_fails: 0.005, thing_missing: 0.01, door_closed: 0.02, held_up: 0.1 };

/// An order, as the world keeps account of it.
#[derive(Clone, Debug)]
pub(super) struct Order {
    /// The thing.
    pub thing: String,
    /// From where to where, places of the world.
    pub from: &'static str,
    pub to: &'static str,
}

/// What happens on a day.
pub(super) struct Day {
    /// What comes between.
    pub chances: Chances,
    battery: f64,
    /// What people say, the earliest first.
    messages: Vec<(u64, Vec<String>)>,
    /// What they order.
    pub orders: Vec<Order>,
}

fn microseconds(seconds: f64) -> u64 {
    (seconds * 1e6).round() as u64
}

impl Day {
    /// One of a kind.
    pub fn drawn(kind: &DayKind, stream: &mut Stream) -> Self {
        let mut messages = Vec::new();
        if kind.has_closings {
            let first = stream.index(ROOMS.len());
            for room in [ROOMS[first], ROOMS[(first + 1 + stream.index(ROOMS.len() - 1)) % ROOMS.len()]] {
                let closes_s = stream.uniform_in(0.3, 0.9) * DAY_S;
                messages.push((0, vec!["closes".to_string(), room.to_string(), format!("{closes_s:.0}")]));
            }
        }
        let count = (stream.uniform_in(ORDERS_AN_HOUR[0], ORDERS_AN_HOUR[1]) * DAY_S / 3600.0).round() as usize;
        let mut comes_s = 0.0;
        let mut orders = Vec::new();
        for number in 0..count {
            if !kind.has_bursts || number % BURST == 0 {
                comes_s = stream.uniform_in(0.0, 0.95) * DAY_S;
            }
            let from = stream.index(PLACES.len());
            let to = (from + 1 + stream.index(PLACES.len() - 1)) % PLACES.len();
            let due_s = comes_s + stream.uniform_in(kind.due_s[0], kind.due_s[1]);
            let order = Order { thing: format!("thing-{number}"), from: PLACES[from], to: PLACES[to] };
            let words = ["deliver", &order.thing, order.from, order.to, &format!("{due_s:.0}")].map(str::to_string);
            messages.push((microseconds(comes_s), words.to_vec()));
            orders.push(order);
        }
        messages.sort_by_key(|&(at_us, _)| at_us);
        let chances = Chances { thing_missing: kind.missing, ..USUAL };
        Self { chances, battery: kind.battery, messages, orders }
    }

    /// The world of the day, for a robot that foresees by something.
    pub fn setting(&self, forecast: Forecast) -> AbstractSetting {
        AbstractSetting { chances: self.chances, battery: self.battery, messages: self.messages.clone(), forecast }
    }
}
