//! A part of the small programs that share valves, in the runtime and in the model. All of them are
//! compared by `cargo run --release -p rpl-tests --example valves`.

use rpl_tests::valves::program::programs;
use rpl_tests::valves::{Tally, judge};

/// r[valve.borrow], r[valve.preempt], r[valve.return], r[valve.clean-up], r[valve.evaporated]
#[test]
fn small_programs_do_what_the_model_of_the_rules_says() {
    let mut tally = Tally::default();
    for (width, every, with_blows) in [(2, 97, true), (3, 997, false)] {
        for program in programs(width, 6).step_by(every) {
            if let Err(finding) = judge(&program, with_blows, &mut tally) {
                panic!("{finding}");
            }
        }
    }
    assert!(tally.programs > 100 && tally.runs > 5_000, "{tally:?}");
}
