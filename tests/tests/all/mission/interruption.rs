//! The plan of the paper while somebody turns the robot by hand: what must happen, in its order.

use rpl_robot::office::ReportKind;
use rpl_runtime::run::system::Outcome;
use rpl_runtime::state::trace::EventKind::{Behaviour, End, Fluent, Pulse, Robot, Signal, Valve};
use rpl_runtime::state::trace::{Event, EventKind};
use rpl_tests::detail;
use rpl_tests::mission::{Mission, Run, dept, is, lines};
use std::sync::OnceLock;

const PAPER: &str = include_str!("../../../../examples/paper.rpl");
const ROTATED: &str = include_str!("../../../../examples/scenarios/rotated.rpl");

fn rotated() -> &'static Run {
    static RUN: OnceLock<Run> = OnceLock::new();
    RUN.get_or_init(|| Mission::new(dept(), PAPER).with_scenario(ROTATED).run(SEED, 600.0))
}

const SEED: u64 = 3;

/// The targets of the navigation plans, in the order in which they were made.
fn targets(run: &Run) -> Vec<String> {
    let sources = &run.system.program.sources;
    (0..sources.len())
        .map(|number| sources.get(rpl_lang::source::SourceId(number as u32)))
        .filter(|source| source.name.starts_with("plan#"))
        .filter_map(|source| Some(source.text.split_once(":targets")?.1.to_string()))
        .collect()
}

fn by_policy(event: &Event) -> bool {
    event.path.contains("relocalize-when-necessary")
}

/// r[behaviour.paper]
#[test]
fn a_turn_by_hand_interrupts_and_the_navigation_goes_on_from_the_new_pose() {
    let run = rotated();
    let find = |from: usize, what: &str, holds: &dyn Fn(&Event) -> bool| run.find(from, what, holds);
    let turned = find(0, "the turn", &|event| ReportKind::of(event) == Some(ReportKind::RotatedByHand));
    let lost = find(turned, "the loss of certainty", &|event| ReportKind::of(event) == Some(ReportKind::PositionLost));
    assert!(detail(&run.events[lost], "certainty").parse::<f64>().expect("a number") <= 0.8);
    // The policy of the paper asks for more certainty than a robot that is not lost has.
    let requested = find(turned, "the request of the policy", &|event| {
        by_policy(event) && is(event, Valve, &[("valve", "wheels"), ("what", "requested")])
    });
    let pre_empted = find(requested, "the pre-emption", &|event| {
        event.path.contains("navigation-proc") && is(event, Valve, &[("what", "pre-empted")])
    });
    let no_goals = find(requested, "the end of the goals", &|event| {
        is(event, Fluent, &[("fluent", "nr-of-nav-goals*"), ("value", "0")])
    });
    let pulse = find(no_goals, "the pulse", &|event| is(event, Pulse, &[("fluent", "execution-interrupted?")]));
    let granted = find(pre_empted, "the grant", &|event| by_policy(event) && is(event, Valve, &[("what", "granted")]));
    let localizing = |what: &'static str| {
        move |event: &Event| is(event, Behaviour, &[("behaviour", "active-localization"), ("what", what)])
    };
    let activated = find(granted, "active localization", &localizing("activated"));
    let woken = find(pulse, "the wake-up of the wait-for", &|event| {
        event.kind == EventKind::Woken && event.path.ends_with("navigation-proc/try-all[0]")
    });
    let found = find(activated.max(woken), "the wake-up of the policy", &|event| {
        event.kind == EventKind::Woken && by_policy(event)
    });
    let deactivated = find(found, "its end", &localizing("deactivated"));
    let released =
        find(deactivated, "the release", &|event| by_policy(event) && is(event, Valve, &[("what", "released")]));
    let returned = find(released, "the return of the wheels", &|event| {
        event.path.contains("navigation-proc") && is(event, Valve, &[("what", "returned")])
    });
    let evaporated = find(returned, "the end of the old navigation plan", &|event| {
        event.path.ends_with("try-all[1]") && is(event, End, &[("state", "evaporated")])
    });
    let again = find(evaporated, "the new navigation", &|event| {
        is(event, Behaviour, &[("behaviour", "navigation"), ("what", "activated")])
    });
    let arrived =
        find(again, "the arrival", &|event| is(event, Signal, &[("behaviour", "navigation"), ("signal", "success")]));
    find(arrived, "the end of main", &|event| event.path == "main" && is(event, End, &[("state", "succeeded")]));

    let pulses = run.events[turned..again].iter().filter(|event| event.kind == Pulse).count();
    assert_eq!(pulses, 1, "one interruption, one pulse");
    assert!(matches!(run.system.outcome(), Some(Outcome::Succeeded(_))), "{}", run.outcome());
}

/// Turned after the first target, the robot does not go back to it.
/// r[behaviour.paper]
#[test]
fn the_new_plan_starts_from_the_new_pose() {
    let run = Mission::new(dept(), PAPER).with_scenario("(wait-time 20) (rotate-robot! 70deg)").run(SEED, 600.0);
    assert!(matches!(run.system.outcome(), Some(Outcome::Succeeded(_))), "{}", run.outcome());
    let targets = targets(&run);
    assert!(targets.len() >= 2, "{targets:?}");
    let first = |text: &String| text.split(')').next().map(str::to_owned);
    assert_ne!(first(&targets[0]), first(&targets[1]), "{targets:?}");
}

#[test]
fn the_interrupted_delivery_ends_at_the_shelf() {
    let robot = &rotated().system.outside;
    let shelf = robot.model().world.place("wolframs-shelf").expect("a place of the department").pose_in_map;
    let pose = robot.true_pose_in_map();
    assert!(libm::hypot(pose.x_m - shelf.x_m, pose.y_m - shelf.y_m) < 0.5, "{pose:?}");
    assert_eq!(robot.contacts().caused, 0);
}

#[test]
fn the_trace_of_the_interrupted_delivery() {
    let told = |event: &&Event| match event.kind {
        Valve | Behaviour | Pulse | Robot | Signal => true,
        Fluent => detail(event, "fluent") == "nr-of-nav-goals*",
        EventKind::Begin
        | End
        | EventKind::Call
        | EventKind::Return
        | EventKind::Blocked
        | EventKind::Woken
        | EventKind::Suspended
        | EventKind::Resumed
        | EventKind::Failed
        | EventKind::Handled
        | EventKind::Swapped
        | EventKind::Decided
        | EventKind::Log
        | EventKind::Measured
        | EventKind::Warning => false,
    };
    let events: Vec<Event> = rotated().events.iter().filter(told).cloned().collect();
    insta::assert_snapshot!(lines(&events));
}
