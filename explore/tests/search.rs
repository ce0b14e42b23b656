//! Plans with a fault in one order, and those without.

mod plans;

use plans::{BOUNDS, searched, started};
use rpl_explore::finding::{Fault, Finding};
use rpl_explore::search::{Bounds, Left};
use rpl_explore::story::story;
use rpl_runtime::state::trace::EventKind;

#[test]
fn a_wake_up_that_is_lost_is_found() {
    let found = searched(
        "(def-fluent bell nil)
         (par (wait-for (pulsed bell)) (pulse bell))",
        BOUNDS,
    );
    let finding = found.finding.expect("the bell may ring before anybody listens");
    assert!(matches!(&finding.fault, Fault::Fails(why) if why.contains("deadlock")), "{finding:?}");
    assert_eq!(finding.deviations.len(), 1);
}

#[test]
fn all_orders_of_a_plan_that_is_right_are_tried() {
    let found = searched("(def-fluent done nil) (par (wait-for done) (setf (value done) t))", BOUNDS);
    assert_eq!((found.finding, found.left), (None, Vec::new()));
    assert!(found.ends > 0);
}

#[test]
fn a_check_that_is_old_when_it_counts_needs_two_turns_between() {
    let text = |n| {
        format!(
            "(defvar free t) (defvar inside 0)
         (def-plan enter () (when free (wait-time 0) (setq free nil) (incf inside) (assert (= inside 1) \"two\")))
         (par {})",
            "(enter)".repeat(n)
        )
    };
    let found = searched(&text(2), BOUNDS);
    assert!(matches!(found.finding.expect("two enter").fault, Fault::Fails(_)));
}

#[test]
fn a_plan_that_never_ends_is_searched_to_its_end() {
    let found = searched(
        "(def-fluent flag nil)
         (par (loop (wait-for flag) (setf (value flag) nil) (wait-time 1))
              (loop (wait-time 2) (setf (value flag) t)))",
        BOUNDS,
    );
    assert!(found.states < 100, "{found:?}");
    assert_eq!((found.finding, found.left), (None, Vec::new()));
}

#[test]
fn the_time_counts_where_a_plan_can_see_it() {
    let bounds = Bounds { until_us: 10_000_000, ..BOUNDS };
    let found = searched("(loop (wait-time 1) (assert (< (now) 100)))", bounds);
    assert_eq!((found.finding, found.left), (None, vec![Left::Time]));
    let bounds = Bounds { until_us: 1_000_000_000, ..BOUNDS };
    let found = searched("(loop (wait-time 1) (assert (< (now) 100)))", bounds);
    assert_eq!(found.finding.expect("its time comes").deviations, Vec::new());
}

#[test]
fn ends_that_differ_are_found_where_they_must_not() {
    let text = "(defvar last nil) (par (setq last 'a) (setq last 'b)) last";
    assert_eq!(searched(text, BOUNDS).finding, None);
    let found = searched(text, Bounds { deterministic: true, ..BOUNDS });
    assert_eq!(
        found.finding.map(|finding| finding.fault),
        Some(Fault::Differs { usual: "b".into(), found: "a".into() })
    );
}

/// Philosophers, each with two forks, of whom the last takes the other one first if that is asked for.
fn philosophers(n: usize, is_last_left_handed: bool) -> String {
    let valves: String = (0..n).map(|fork| format!("(def-valve fork-{fork}) ")).collect();
    let eater = |one: usize| {
        let (first, second) = (one, (one + 1) % n);
        let is_swapped = is_last_left_handed && one + 1 == n;
        let (first, second) = if is_swapped { (second, first) } else { (first, second) };
        format!("(loop (with-valve fork-{first} (wait-time 0) (with-valve fork-{second} (wait-time 1))) (wait-time 1))")
    };
    format!("{valves} (par {})", (0..n).map(eater).collect::<String>())
}

#[test]
fn philosophers_starve_unless_one_is_left_handed() {
    let found = searched(&philosophers(3, false), BOUNDS);
    assert!(matches!(found.finding, Some(Finding { fault: Fault::Fails(why), .. }) if why.contains("deadlock")));
    let found = searched(&philosophers(3, true), BOUNDS);
    assert_eq!((found.finding, found.left), (None, Vec::new()), "{} states", found.states);
}

#[test]
fn ten_tasks_on_one_counter_are_searched() {
    let found = searched(&format!("(defvar n 0) (par {})", "(seq (incf n) nil)".repeat(10)), BOUNDS);
    assert_eq!((found.finding, found.left), (None, Vec::new()));
    // One for each set of those that have run, and not for each order; where one task is left there is no choice.
    assert_eq!(found.states, (1 << 10) - 11);
}

#[test]
fn a_story_names_what_came_first_and_what_followed() {
    let text = "(def-fluent bell nil)\n(par (wait-for (pulsed bell))\n     (pulse bell))";
    let finding = searched(text, BOUNDS).finding.expect("a lost wake-up");
    let (system, own) = started(text, true);
    let story = story(system, &finding.deviations, own, u64::MAX);
    let [turn] = &story.turns[..] else { panic!("{story:?}") };
    assert_eq!((turn.taken.path.as_str(), turn.before[0].path.as_str()), ("main/par[1]", "main/par[0]"));
    assert!(turn.events.iter().any(|event| event.kind == EventKind::Pulse), "{turn:?}");
}
