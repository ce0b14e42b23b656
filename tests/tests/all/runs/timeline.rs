//! Earlier instants of a run, also when copies of it have been given up.

use rpl_lang::compile::NoFiles;
use rpl_robot::office::{OfficeRobot, SimulatedHost};
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::stepping::Stop;
use rpl_runtime::run::system::System;
use rpl_runtime::run::timeline::{Timeline, TimelinePosition};
use rpl_tests::mission::{robot_library, test_room};
use rpl_tests::session;
use std::cell::Cell;
use std::time::Duration;

/// A plan in which every instant differs from all others.
const PLAN: &str = "
(def-fluent level 0)
(def-plan fill () (loop (wait-time 0.1) (setf (value level) (+ (random 1000) (* 2 (value level))))
                        (if (> (value level) 1000000) (setf (value level) 0))))
(with-policy (whenever (changed level) (wait-time 0.05))
  (fill))";

/// A run of a number of instants, its history, and what each instant was at its end.
fn recorded(instants: u64, bytes_apart: fn(&NoRobot, &NoRobot) -> usize) -> (Timeline<NoRobot>, Vec<(u64, Vec<u8>)>) {
    let mut system = session();
    let mut timeline = Timeline::new(&system, bytes_apart);
    system.submit("plan", PLAN, &mut NoFiles).unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
    timeline.handed_in(&system);
    let mut ends = Vec::new();
    for _ in 0..instants {
        system.settle();
        timeline.position.step = TimelinePosition::END;
        ends.push((system.machine.now_us, state(&system)));
        system.next_instant();
        // A fifth of them takes long.
        let ms = if system.machine.now_us.is_multiple_of(500_000) { 80 } else { 15 };
        timeline.next_instant(&system, Duration::from_millis(ms));
    }
    (timeline, ends)
}

/// The end of the last instant up to a time.
fn at_time(timeline: &Timeline<NoRobot>, time_us: u64) -> System<NoRobot> {
    timeline.at_time(time_us, &|| false).expect("nobody gives it up").system
}

/// All that can differ, but what was printed and traced.
fn state(system: &System<NoRobot>) -> Vec<u8> {
    let mut system = system.clone();
    system.machine.output.clear();
    system.machine.trace.take();
    system.save()
}

#[test]
fn every_earlier_instant_is_given_back_as_it_was() {
    let (timeline, ends) = recorded(100, |_, _| 0);
    assert!(timeline.copies() > 20, "{}", timeline.copies());
    for (time_us, end) in &ends {
        assert!(state(&at_time(&timeline, *time_us)) == *end, "at {time_us} µs");
    }
}

#[test]
fn copies_that_hold_too_much_are_given_up_and_nothing_else_changes() {
    let (timeline, ends) = recorded(100, |_, _| 60 << 20);
    // Seven of them fit beside the start.
    assert!((5..=8).contains(&timeline.copies()), "{}", timeline.copies());
    assert!(timeline.held_bytes() <= 448 << 20, "{}", timeline.held_bytes());
    for (time_us, end) in &ends {
        assert!(state(&at_time(&timeline, *time_us)) == *end, "at {time_us} µs");
    }
}

#[test]
fn what_was_handed_in_is_never_given_up() {
    let mut system = session();
    let mut timeline = Timeline::new(&system, |_, _| 300 << 20);
    for number in 0..10 {
        system.submit("form", &format!("(wait-time 1) {number}"), &mut NoFiles).unwrap_or_else(|rejected| {
            panic!("{}", rejected.render(false));
        });
        timeline.handed_in(&system);
        loop {
            system.settle();
            if system.answer().is_some() {
                break;
            }
            system.next_instant();
            timeline.next_instant(&system, Duration::from_millis(100));
        }
    }
    for second in 0..10 {
        let past = at_time(&timeline, second * 1_000_000 + 500_000);
        assert_eq!(past.machine.now_us, second * 1_000_000);
        assert!(past.answer().is_none(), "form {second} is under way");
    }
}

/// The history of a robot that rests for a minute, which is more than a thousand instants.
fn rest() -> Timeline<OfficeRobot> {
    let model = test_room();
    let robot = OfficeRobot::new(model.clone(), SimulatedHost::new(model.simulator.clone(), 1, None), 1);
    let session = System::session(&robot_library(), robot, 1);
    let mut system = session.unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
    let mut timeline = Timeline::new(&system, OfficeRobot::bytes_apart);
    let text = "(seq (wait-time 60) (setf (value travel-mode*) 'office))";
    system.submit("rest", text, &mut NoFiles).unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
    timeline.handed_in(&system);
    loop {
        system.settle();
        timeline.position.step = TimelinePosition::END;
        if system.answer().is_some() {
            return timeline;
        }
        system.next_instant();
        timeline.next_instant(&system, Duration::from_millis(1));
    }
}

#[test]
fn a_step_back_goes_over_a_long_rest_without_replaying_it() {
    let timeline = rest();
    assert!(timeline.position.segment > 1000, "{:?}", timeline.position);
    let is_typed =
        |system: &System<OfficeRobot>, stop: &Stop| &*system.program.sources.get(stop.span.source).name == "rest";
    let replayed = Cell::new(0);
    let count = || {
        replayed.set(replayed.get() + 1);
        false
    };
    let past = timeline.steps_before(timeline.position, 2, is_typed, &count).expect("nobody gives up");
    assert_eq!(past.system.machine.now_us, 0);
    assert!(past.stop.is_some(), "it stands before the wait");
    assert!(replayed.get() < 200, "{} instants were replayed", replayed.get());
}

#[test]
fn a_way_back_can_be_given_up() {
    let timeline = rest();
    assert!(timeline.at_time(30_100_000, &|| true).is_none());
    assert!(timeline.at_time(30_100_000, &|| false).is_some());
}
