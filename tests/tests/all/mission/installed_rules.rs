//! Rules of the library where they pay: a robot in an abstract world is given the plan that a rule makes.

use rpl_robot::foresight::abstract_robot::Experience;
use rpl_robot::foresight::models::{Chances, DriveRecord};
use rpl_robot::office::{AbstractSetting, Forecast, OfficeModel};
use rpl_runtime::run::system::Outcome;
use rpl_runtime::state::trace::EventKind;
use rpl_tests::detail;
use rpl_tests::mission::{Grid, builtin, dept, in_abstract_world};
use std::sync::Arc;

const NOTHING_BETWEEN: Chances =
    Chances { grasp_misses: 0.0, release_fails: 0.0, thing_missing: 0.0, door_closed: 0.0, held_up: 0.0 };

/// Where nothing comes between, for a robot that has learned nothing else.
fn quiet() -> AbstractSetting {
    let forecast = Forecast::Learned(Experience::default());
    AbstractSetting { chances: NOTHING_BETWEEN, battery: 0.9, messages: Vec::new(), forecast }
}

/// Runs a plan in which foresight may use one rule; the plan's value must be `t`, and the rule's plan must have been
/// begun.
fn is_installed(rule: &str, setting: AbstractSetting, plan: &str) {
    is_installed_in(dept(), rule, setting, plan);
}

fn is_installed_in(model: Arc<OfficeModel>, rule: &str, setting: AbstractSetting, plan: &str) {
    let mut system = in_abstract_world(model, setting, plan);
    let events = system.machine.trace.take();
    let taken = events.iter().any(|event| {
        event.kind == EventKind::Decided
            && detail(event, "what") == "takes another plan"
            && detail(event, "rules") == rule
    });
    let told: Vec<String> =
        events.iter().filter(|event| event.kind == EventKind::Decided).map(ToString::to_string).collect();
    assert!(taken, "{rule} is not taken:\n{}", told.join("\n"));
    assert!(events.iter().any(|event| event.kind == EventKind::Swapped), "{rule} is not begun");
    match system.outcome() {
        Some(Outcome::Succeeded(value)) => assert_eq!(system.machine.write(&system.program, value), "t", "{rule}"),
        Some(Outcome::Failed(failure)) => panic!("{rule}: {}", system.machine.show(&system.program, failure)),
        Some(Outcome::Evaporated) | None => panic!("{rule}: no value"),
    }
}

// r[rule.library]
#[test]
fn rules_of_the_library_are_taken_where_they_pay() {
    is_installed(
        "last-step-first",
        quiet(),
        "(def-plan post () (if (> (now) 100) (fail \"closed\") (wait-time 10)))
         (with-foresight (:rules (last-step-first) :horizon 10min)
           (seq (:tag stroll (wait-time 120)) (:tag mail (post))))
         (< 129 (now) 131)",
    );
    is_installed(
        "first-step-last",
        quiet(),
        "(def-plan shop () (wait-time 5) (when (< (now) 60) (fail \"not open yet\")))
         (with-foresight (:rules (first-step-last) :horizon 10min)
           (seq (:tag buy (shop)) (:tag stroll (wait-time 90))))
         (< 94 (now) 96)",
    );
    is_installed(
        "side-by-side",
        quiet(),
        "(with-foresight (:rules (side-by-side)) (seq (:tag a (wait-time 300)) (:tag b (wait-time 300))))
         (< 299 (now) 301)",
    );
    is_installed(
        "one-after-the-other",
        quiet(),
        "(def-fluent busy nil)
         (def-plan use ()
           (when (value busy) (fail \"somebody else has it\"))
           (setf (value busy) t)
           (unwind-protect (wait-time 20) (setf (value busy) nil)))
         (with-foresight (:rules (one-after-the-other) :horizon 10min)
           (par (:tag a (use)) (:tag b (seq (wait-time 5) (use)))))
         (< 44 (now) 46)",
    );
    is_installed(
        "other-way-first",
        quiet(),
        "(with-foresight (:rules (other-way-first) :horizon 10min)
           (try-in-order (seq (wait-time 200) (fail \"in vain\")) (wait-time 10)))
         (< 9 (now) 11)",
    );
    is_installed(
        "try-once-more",
        quiet(),
        "(defvar tries 0)
         (def-plan flaky () (wait-time 1) (incf tries) (when (= tries 1) (fail \"flaky\")))
         (with-foresight (:rules (try-once-more)) (seq (:tag a (wait-time 1)) (:tag b (flaky))))
         (= tries 2)",
    );
}

// r[rule.robot]
#[test]
fn rules_of_order_are_taken_where_they_pay() {
    is_installed(
        "nearest-delivery-next",
        quiet(),
        "(with-foresight (:rules (nearest-delivery-next) :horizon 10min :margin 0.01)
           (seq (:tag far (deliver 'a 'd-centre 'c-centre)) (:tag near (deliver 'b 'mail-slots 'd-centre))))
         (< (now) 140)",
    );
    // Behind the one door of the room somebody has just closed it, and it stays closed for a minute or so.
    let closed = Chances { door_closed: 1.0, ..NOTHING_BETWEEN };
    is_installed(
        "elsewhere-meanwhile",
        AbstractSetting { chances: closed, ..quiet() },
        "(ignore-failures (behaviour-failure) (go-to 'a-desk :patience 5))
         (with-foresight (:rules (elsewhere-meanwhile) :horizon 20min)
           (seq (:tag think (wait-time 5)) (:tag desk (go-to 'a-desk)) (:tag meanwhile (wait-time 400))))
         t",
    );
    // Class-room and workshop have two doors each, and most doors are closed, some for longer than the robot waits.
    let mostly_closed = Chances { door_closed: 0.9, ..NOTHING_BETWEEN };
    let mut experience = Experience::default();
    experience.drives = DriveRecord { doors_open: 20, doors_closed: 180, ..DriveRecord::default() };
    is_installed_in(
        builtin("school", Grid::Coarse),
        "another-way",
        AbstractSetting { chances: mostly_closed, forecast: Forecast::Learned(experience), ..quiet() },
        "(with-foresight (:rules (another-way) :horizon 20min)
           (seq (:tag lesson (go-to 'board-2)) (:tag work (go-to 'lathe-side))))
         t",
    );
    is_installed(
        "what-becomes-impossible-first",
        quiet(),
        "(def-plan closing () (if (> (now) 60) (fail \"closed\") (wait-time 1)))
         (with-foresight (:rules (what-becomes-impossible-first) :horizon 10min)
           (seq (:tag rest (wait-time 50)) (:tag drive (go-to 'c-centre)) (:tag post (closing))))
         (> (now) 60)",
    );
}

// r[rule.robot]
#[test]
fn rules_of_battery_position_and_giving_up_are_taken_where_they_pay() {
    is_installed(
        "charge-before",
        AbstractSetting { battery: 0.012, ..quiet() },
        "(with-foresight (:rules (charge-before) :horizon 30min)
           (seq (:tag a (deliver 'a 'd-centre 'c-centre)) (:tag b (deliver 'b 'wolframs-shelf 'a-desk))))
         (> (value battery*) 0.3)",
    );
    is_installed(
        "position-before",
        quiet(),
        "(doubt-position)
         (wait-for (<= pos-certainty* 0.8))
         (with-foresight (:rules (position-before) :horizon 10min)
           (seq (:tag wait (wait-time 1)) (:tag cup (pick-up 'cup))))
         (eq (value holding*) 'cup)",
    );
    // Half of the things that it looked for so far were not there; whether people bring one is even.
    let mut experience = Experience::default();
    (0..20).for_each(|thing| experience.grasps.note(if thing % 2 == 0 { 3 } else { 0 }, thing % 2 != 0));
    is_installed(
        "ask-somebody",
        AbstractSetting { forecast: Forecast::Learned(experience), ..quiet() },
        "(with-foresight (:rules (ask-somebody) :horizon 20min :margin 0.02) (fetch 'cup 'a-desk))
         (eq (value holding*) 'cup)",
    );
    is_installed(
        "give-up-in-time",
        quiet(),
        "(def-fluent done 0)
         (with-failure-handling ((given-up () nil))
           (with-foresight (:rules (give-up-in-time) :horizon 10min :worth done)
             (seq (:tag a (seq (wait-time 10) (incf (value done))))
                  (:tag b (seq (wait-time 100) (fail \"in vain\")))
                  (:tag c (seq (wait-time 10) (incf (value done)))))))
         (= (value done) 2)",
    );
}
