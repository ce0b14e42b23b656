//! A module that does nothing wrong.

use crate::module::{Played, play, reason};
use rpl_runtime::robot::Ending;
use rpl_runtime::robot::reading::Reading;
use rpl_runtime::state::value::Value;

fn right(mode: &str, keys: &str) -> Played {
    play(mode, keys).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn its_fluents_are_readings() {
    let news = right("right", "").step();
    let of = |place: usize| &news.fluents[&place];
    assert_eq!((of(0), of(1)), (&Reading::Float(0.5), &Reading::Int(2)));
    assert_eq!(of(3), &Reading::Symbol("sink".into()), "a text is taken for the symbol that is declared");
    let Reading::List(seen) = of(2) else { panic!("{:?}", of(2)) };
    assert_eq!(seen.items()[..2], [Reading::Symbol("cup".into()), Reading::Text("two words".into())]);
    assert_eq!(news.events, []);
}

#[test]
fn a_failure_of_a_behaviour_is_no_failure_of_the_module() {
    let mut played = right("no-cup", "");
    assert_eq!(played.start(), None);
    let news = played.step();
    let [(0, Ending::Failure { class, message, slots })] = news.endings.as_slice() else { panic!("{news:?}") };
    assert_eq!((&**class, &**message), ("no-cup", "there is none"));
    assert_eq!(slots[..], [("place".to_string(), Reading::Symbol("sink".into()))]);
    assert_eq!(played.start(), None, "it can be started again");
}

#[test]
fn arguments_that_cannot_be_told_are_refused_by_their_name() {
    let mut played = right("right", "");
    for (key, value, reason) in [
        ("colour", Value::Nil, "`sweep` has no parameter `:colour`; it has :area :times"),
        (
            "times",
            Value::Float(f64::NAN),
            "`:times` of `sweep` cannot be told to its module: it is a number that is not finite",
        ),
        ("times", Value::Fluent(0), "`:times` of `sweep` cannot be told to its module: only truths, numbers, symbols"),
    ] {
        let raise = played.start_with(key, value).expect_err(key);
        assert!(format!("{raise:?}").contains(reason), "{raise:?}");
    }
}

#[test]
fn a_copy_hears_the_same_again_and_what_it_would_say_anew_is_told() {
    let mut one = right("right", "");
    let mut copy = one.copy();
    let mut other = one.copy();
    let first = one.step();
    assert_eq!(copy.step(), first);
    assert_eq!(other.start(), None);
    let news = other.step();
    let [(0, failure)] = news.endings.as_slice() else { panic!("{news:?}") };
    let why = reason(failure);
    assert!(why.starts_with("cannot be asked: `faulty` cannot answer: at turn 0 it was told "), "{why}");
}

#[test]
fn a_live_module_is_not_waited_for() {
    // It never answers, and its time is not over.
    let mut played = right("never-done", "pace = \"live\"\nanswer_within = \"60s\"");
    assert_eq!(played.start(), None);
    for _ in 0..50 {
        assert_eq!(played.step().endings, []);
    }
}
