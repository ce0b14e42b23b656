//! The missions whose success is foretold: plans of six kinds over places and deadlines that are drawn, in an abstract
//! world where up to three kinds of things come between more often than usual.

use anyhow::Result;
use rpl_lang::compile::NoFiles;
use rpl_mission::site::Site;
use rpl_random::Stream;
use rpl_robot::foresight::models::Chances;
use rpl_runtime::run::library::Loaded;

/// The kinds of missions, each with its plan. `~0` to `~3` are places.
pub(super) const KINDS: [(&str, &str); 6] = [
    ("fetch", "(fetch 'letter '~0)"),
    ("deliver", "(deliver 'letter '~0 '~1)"),
    ("two deliveries", "(seq (deliver 'letter '~0 '~1) (deliver 'parcel '~2 '~3))"),
    ("round", "(seq (go-to '~0) (go-to '~1) (go-to '~2) (go-to '~3))"),
    ("either of two", "(seq (try-in-order (fetch 'letter '~0) (fetch 'parcel '~1)) (bring (value holding*) '~2))"),
    ("impatient", "(deliver 'letter '~0 '~1 :patience 10)"),
];

/// How many times as late as the end of the mission a deadline is if nothing comes between.
const DEADLINES: [f64; 2] = [1.02, 1.5];

/// What comes between where nothing is drawn to come between more often.
const USUAL: Chances =
    Chances { grasp_misses: 0.03, release_fails: 0.005, thing_missing: 0.01, door_closed: 0.01, held_up: 0.03 };

/// What comes between nowhere.
pub(super) const NOTHING_BETWEEN: Chances =
    Chances { grasp_misses: 0.0, release_fails: 0.0, thing_missing: 0.0, door_closed: 0.0, held_up: 0.0 };

/// The most kinds of things that come between more often.
pub(super) const MOST_CONTINGENCIES: usize = 3;

/// A world as it is drawn: what comes between, and how many kinds of that more often than usual.
pub(super) fn drawn_chances(stream: &mut Stream) -> (Chances, usize) {
    let mut chances = USUAL;
    let count = stream.index(MOST_CONTINGENCIES + 1);
    let mut left = vec![
        (&mut chances.grasp_misses, 0.35),
        (&mut chances.thing_missing, 0.4),
        (&mut chances.door_closed, 0.25),
        (&mut chances.held_up, 0.5),
    ];
    for _ in 0..count {
        let (chance, most) = left.swap_remove(stream.index(left.len()));
        *chance = stream.uniform_in(*chance, most);
    }
    (chances, count)
}

/// A mission: its plan over places of the world.
pub(super) fn drawn_plan(kind: usize, site: &Site, stream: &mut Stream) -> String {
    let mut left: Vec<&str> =
        site.office().map_or_else(Vec::new, |office| office.world.places.iter().map(|place| &*place.name).collect());
    (0..4).fold(KINDS[kind].1.to_string(), |plan, number| {
        let place = left.swap_remove(stream.index(left.len()));
        plan.replace(&format!("~{number}"), place)
    })
}

/// How many times as late as without contingencies its deadline is.
pub(super) fn drawn_deadline(stream: &mut Stream) -> f64 {
    stream.uniform_in(DEADLINES[0], DEADLINES[1])
}

/// A plan compiled at a site.
///
/// # Errors
/// It is none.
pub(super) fn compiled(site: &Site, plan: &str) -> Result<Loaded> {
    Ok(site.compile("mission.rpl", plan, &mut NoFiles)?)
}
