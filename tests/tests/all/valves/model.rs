//! A part of the small programs that share valves, in the runtime and in the model. All of them are
//! compared by `cargo run --release -p rpl-tests --example valves`.

use rpl_tests::valves::program::programs;
use rpl_tests::valves::{Tally, judge};

/// r[valve.borrow], r[valve.preempt], r[valve.return], r[valve.clean-up], r[valve.evaporated], r[valve.places],
/// r[valve.places-preempt], r[valve.places-return], r[valve.places-borrow]
#[test]
fn small_programs_do_what_the_model_of_the_rules_says() {
    let mut tally = Tally::default();
    let parts = [(2, 1, 97, true), (3, 1, 997, false), (3, 2, 9_973, true), (3, 2, 499, false), (4, 3, 49_999, false)];
    for (width, places, every, with_blows) in parts {
        for program in programs(width, places, 6, every) {
            if let Err(finding) = judge(&program, with_blows, &mut tally) {
                panic!("{finding}");
            }
        }
    }
    assert!(tally.programs > 100 && tally.runs > 5_000, "{tally:?}");
}
