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
    /// How many orders come together.
    burst: usize,
    /// The charge at the start.
    battery: f64,
    /// How many rooms close at some time.
    closings: usize,
    /// How often a thing is not where it should be.
    missing: f64,
    /// How often a drive is held up.
    held_up: f64,
}

const DEADLINES: DayKind = DayKind {
    name: "deadlines",
    due_s: [150.0, 600.0],
    burst: 1,
    battery: 0.9,
    closings: 0,
    missing: USUAL.thing_missing,
    held_up: USUAL.held_up,
};
const BURSTS: DayKind = DayKind { name: "bursts", due_s: [150.0, 900.0], burst: 12, ..DEADLINES };
const CLOSINGS: DayKind = DayKind { name: "closings", due_s: [1200.0, 2400.0], closings: 4, ..DEADLINES };
const LOW: f64 = 0.06;
const MISSING: f64 = 0.25;
const BUSY: f64 = 0.5;

/// The first has no contingency; then each alone, two and three together.
pub(super) const KINDS: [DayKind; 10] = [
    DayKind { name: "no contingencies", due_s: [1200.0, 2400.0], ..DEADLINES },
    DEADLINES,
    BURSTS,
    CLOSINGS,
    DayKind { name: "low battery", battery: LOW, ..DEADLINES },
    DayKind { name: "missing things", missing: MISSING, ..DEADLINES },
    DayKind { name: "busy hallways", held_up: BUSY, ..DEADLINES },
    DayKind { name: "bursts, closings", burst: BURSTS.burst, ..CLOSINGS },
    DayKind { name: "bursts, closings, busy hallways", burst: BURSTS.burst, held_up: BUSY, ..CLOSINGS },
    DayKind { name: "bursts, low battery, missing things", battery: LOW, missing: MISSING, ..BURSTS },
];

/// Where things are fetched and brought.
const PLACES: [&str; 6] = ["east-end", "mail-slots", "a-desk", "c-centre", "d-centre", "wolframs-shelf"];

/// Rooms that may close, and how long before nobody orders anything from or to one any more.
const ROOMS: [&str; 4] = ["a-desk", "c-centre", "d-centre", "wolframs-shelf"];
const BEFORE_CLOSING_S: f64 = 240.0;

/// How long orders come, and the fewest and the most of them in an hour.
const DAY_S: f64 = 2400.0;
const ORDERS_AN_HOUR: [f64; 2] = [30.0, 55.0];

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

/// `count` rooms, each with when it closes, in seconds.
fn drawn_closings(count: usize, stream: &mut Stream) -> Vec<(&'static str, f64)> {
    let mut left = ROOMS.to_vec();
    let mut drawn = |_| (left.swap_remove(stream.index(left.len())), stream.uniform_in(0.3, 0.9) * DAY_S);
    (0..count.min(ROOMS.len())).map(&mut drawn).collect()
}

impl Day {
    /// One of a kind.
    pub fn drawn(kind: &DayKind, stream: &mut Stream) -> Self {
        let mut messages = Vec::new();
        let closings = drawn_closings(kind.closings, stream);
        for (room, closes_s) in &closings {
            messages.push((0, vec!["closes".to_string(), room.to_string(), format!("{closes_s:.0}")]));
        }
        let count = (stream.uniform_in(ORDERS_AN_HOUR[0], ORDERS_AN_HOUR[1]) * DAY_S / 3600.0).round() as usize;
        let mut comes_s = 0.0;
        let mut orders = Vec::new();
        for number in 0..count {
            if number % kind.burst == 0 {
                comes_s = stream.uniform_in(0.0, 0.9) * DAY_S;
            }
            let is_closing =
                |place: &str| closings.iter().any(|&(room, at_s)| room == place && at_s < comes_s + BEFORE_CLOSING_S);
            let mut open: Vec<&'static str> = PLACES.into_iter().filter(|place| !is_closing(place)).collect();
            let from = open.swap_remove(stream.index(open.len()));
            let to = open[stream.index(open.len())];
            let due_s = comes_s + stream.uniform_in(kind.due_s[0], kind.due_s[1]);
            let order = Order { thing: format!("thing-{number}"), from, to };
            let words = ["deliver", &order.thing, order.from, order.to, &format!("{due_s:.0}")].map(str::to_string);
            messages.push((microseconds(comes_s), words.to_vec()));
            orders.push(order);
        }
        messages.sort_by_key(|&(at_us, _)| at_us);
        let chances = Chances { thing_missing: kind.missing, held_up: kind.held_up, ..USUAL };
        Self { chances, battery: kind.battery, messages, orders }
    }

    /// The world of the day, for a robot that foresees by something.
    pub fn setting(&self, forecast: Forecast) -> AbstractSetting {
        AbstractSetting { chances: self.chances, battery: self.battery, messages: self.messages.clone(), forecast }
    }
}
