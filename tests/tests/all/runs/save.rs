//! A run that is saved and loaded, or forked, at every step goes on as if nothing had happened.

use proptest::prelude::*;
use rpl_lang::compile::NoFiles;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::disturbance::Disturbance;
use rpl_runtime::run::save::SaveError;
use rpl_runtime::run::system::System;
use rpl_tests::{library, system, transcript};
use std::sync::OnceLock;

/// Programs that between them put every kind of thing into the state.
const PROGRAMS: &[(&str, &str)] = &[
    (
        "fluents",
        "(def-fluent level 0)
         (defvar reached (fluent (> level 2)))
         (par (seq (wait-for reached) (print (list 'reached (value level))))
              (loop while (< (value level) 4) (wait-time 0.5) (setf (value level) (+ (value level) 1)) (print (value level))))",
    ),
    (
        "pulses and watches",
        "(def-fluent bell nil)
         (defvar count (count-pulses bell))
         (pursue (whenever (pulsed bell) (print (list 'rang (value count))) (wait-time 0.1))
                 (seq (n-times 5 (wait-time 0.05) (pulse bell)) (wait-time 1)))",
    ),
    (
        "valves",
        "(def-valve wheels)
         (def-plan drive (who seconds) (with-valve wheels (print (list who 'drives)) (wait-time seconds) (print (list who 'stops))))
         (par (drive 'a 2) (drive 'b 1)
              (with-priority 1 (wait-time 0.5) (on-resume (lambda () (print 'never)) (drive 'c 0.25))))",
    ),
    (
        "places",
        "(def-valve docks 2)
         (def-plan hold (name seconds)
           (with-valve docks
             (on-interrupt (wait-time 0.5) (on-resume (wait-time 0.5) (wait-time seconds) (print (list name (now)))))))
         (par (hold 'a 2) (hold 'b 3) (hold 'c 1)
              (with-priority 1 (wait-time 1) (with-valve docks (par (with-valve docks (wait-time 1)) (with-valve docks)))))",
    ),
    (
        "timers",
        "(try-in-order (with-timeout 1 (wait-time 5)) (with-timeout 2s (wait-time 1.5) (print (now)) 'done))",
    ),
    (
        "policies",
        "(def-fluent tilt 0)
         (def-plan keep-upright () (whenever (> tilt 3) (print 'upright) (setf (value tilt) 0)))
         (with-policy (keep-upright)
           (n-times 6 (setf (value tilt) (+ (value tilt) 2)) (wait-time 0.5)))
         (value tilt)",
    ),
    (
        "clean-ups",
        "(pursue (unwind-protect (evap-protect (wait-time 9) (print 'inner) (wait-time 1) (print 'inner-done))
                   (print 'outer) (par (wait-time 0.5) (print 'child)))
                 (seq (wait-time 1) (print 'won) 'winner))",
    ),
    (
        "plans as data",
        "(def-plan step (name) (print name) (wait-time 0.5))
         (dolist (name '(one two one))
           (execute-plan (list 'seq (list 'step (list 'quote name)) '(let ((text \"made at run time\")) (print text)))))
         (execute-plan '(par (wait-time 1) (seq (step 'three) (%fail 'plan-failure \"from data\"))))",
    ),
    (
        "failures",
        "(def-failure spilled (plan-failure) (where))
         (def-plan pour (n) (wait-time 0.1) (if (< n 3) (%fail 'spilled \"at\" :where n)) n)
         (let ((n 0))
           (with-failure-handling ((composite-failure (f) (print (map failure-message (failure-parts f))) (setq n (+ n 1)) (retry)))
             (try-all (pour n) (seq (wait-time 0.05) (%fail 'plan-failure \"worse\")))))",
    ),
    (
        "tags and suspension",
        "(def-plan work () (dotimes (i 4) (wait-time 1) (print i)))
         (par (:tag worker (work))
              (seq (wait-time 1.5) (with-task-suspended (worker) (print 'pause) (wait-time 3)) (wait-for (end-task worker)) (print (value (status worker)))))",
    ),
    (
        "spawned tasks and closures",
        "(defvar table (make-hash-table))
         (def-plan supervise ()
           (let ((total 0))
             (dolist (i '(1 2 3)) (spawn (wait-time i) (setq total (+ total i)) (setf (gethash i table) (format \"~a\" total))))
             (wait-time 2.5)
             (print total)))
         (supervise)
         (print (hash-table->alist table))",
    ),
    (
        "partial order",
        "(plan ((:tag a (wait-time 1) (print 'a)) (:tag b (print 'b)) (:tag c (wait-time 0.5) (print 'c) 'last))
           (:order a b) (:order c b))",
    ),
    (
        "calls and lists",
        "(defun fib (n) (if (< n 2) n (+ (fib (- n 1)) (fib (- n 2)))))
         (defvar squares (map (lambda (i) (* i i)) '(1 2 3 4)))
         (par-map (n squares) (wait-time (/ n 10.0)) (print (list n (fib n) \"text\" 0.1)))
         (reduce + squares)",
    ),
    (
        "deadlock",
        "(def-fluent never nil)
         (unwind-protect (par (wait-for never) (wait-time 1)) (par (print 'clean) (wait-time 1) (print 'gone)))",
    ),
];

fn start(text: &str) -> System<NoRobot> {
    let mut system = system(text);
    system.machine.trace.enabled = true;
    system
}

/// One task's turn or, if all are blocked, the next instant; tells whether the run goes on.
fn step(system: &mut System<NoRobot>) -> bool {
    if system.step_task() {
        return true;
    }
    if system.outcome().is_some() {
        return false;
    }
    system.next_instant();
    true
}

fn end(mut system: System<NoRobot>) -> (String, String) {
    let trace: Vec<String> = system.machine.trace.take().iter().map(ToString::to_string).collect();
    (transcript(&mut system), trace.join("\n"))
}

fn uninterrupted(text: &str) -> (String, String) {
    let mut system = start(text);
    while step(&mut system) {}
    end(system)
}

fn load(text: &str, bytes: &[u8]) -> Result<System<NoRobot>, SaveError> {
    let loaded = library().load("test.rpl", text, &mut NoFiles).expect("it compiled before");
    System::load(bytes, library().clone(), loaded, NoRobot)
}

#[test]
fn a_run_replaced_by_its_saved_copy_at_every_step_goes_on_alike() {
    for (name, text) in PROGRAMS {
        let expected = uninterrupted(text);
        let mut system = start(text);
        let mut steps = 0;
        loop {
            let saved = system.save();
            let again = load(text, &saved).unwrap_or_else(|error| panic!("{name}, step {steps}: {error}"));
            let difference = again.difference(&system).map(|difference| difference.to_string());
            assert_eq!(difference, None, "{name}, step {steps}");
            assert!(again.program == system.program, "{name}, step {steps}: the loaded program differs");
            assert!(again.save() == saved, "{name}, step {steps}: saved again, the bytes differ");
            system = again;
            if !step(&mut system) {
                break;
            }
            steps += 1;
        }
        assert!(steps > 3, "{name} makes {steps} steps only");
        assert_eq!(end(system), expected, "{name}");
    }
}

#[test]
fn a_main_task_that_would_be_forgotten_at_its_end_is_refused() {
    let text = "(print 1)";
    let mut system = start(text);
    let main = system.machine.main;
    system.machine.tasks[main].exposed = false;
    let refused = load(text, &system.save()).err();
    assert_eq!(refused, Some(SaveError::Inconsistent("there is no main task".to_string())));
}

#[test]
fn the_programs_do_what_they_are_for() {
    let last = |name: &str| {
        let (_, text) = PROGRAMS.iter().find(|(known, _)| *known == name).expect("a program of the list");
        uninterrupted(text).0.lines().last().unwrap_or_default().to_string()
    };
    assert_eq!(last("timers"), "=> done");
    assert_eq!(last("clean-ups"), "=> winner");
    assert_eq!(last("calls and lists"), "=> 30");
    assert_eq!(last("partial order"), "=> last");
    assert_eq!(last("failures"), "=> 3");
    for (name, text) in PROGRAMS {
        let (transcript, _) = uninterrupted(text);
        let fails = ["plans as data", "deadlock"].contains(name);
        assert_eq!(transcript.contains("\n=> ") || transcript.starts_with("=> "), !fails, "{name}:\n{transcript}");
    }
}

#[test]
fn forks_go_on_alike_and_apart() {
    for (name, text) in PROGRAMS {
        let expected = uninterrupted(text);
        let mut system = start(text);
        let mut forks = Vec::new();
        loop {
            forks.push(system.fork());
            if !step(&mut system) {
                break;
            }
        }
        assert_eq!(end(system), expected, "{name}");
        for (at, mut fork) in forks.into_iter().enumerate().step_by(3) {
            while step(&mut fork) {}
            assert_eq!(end(fork), expected, "{name}, forked at step {at}");
        }
    }
}

/// Texts of plans in the other tests and the examples: what stands between quotes there and compiles.
fn texts_elsewhere() -> Vec<String> {
    let files = [
        include_str!("../tasks/constructs.rs"),
        include_str!("../tasks/failures.rs"),
        include_str!("../waiting/fluents.rs"),
        include_str!("../tasks/policies.rs"),
        include_str!("../valves/rules.rs"),
        include_str!("../tasks/life.rs"),
        include_str!("../disturbed/evaporation.rs"),
        include_str!("../language/plans_as_data.rs"),
        include_str!("../language/evaluation.rs"),
        include_str!("../bounds/limits.rs"),
    ];
    let examples = [
        include_str!("../../../../examples/evap-protect.rpl"),
        include_str!("../../../../examples/failure-handling.rpl"),
        include_str!("../../../../examples/first-steps.rpl"),
        include_str!("../../../../examples/fluents.rpl"),
        include_str!("../../../../examples/plan-as-data.rpl"),
        include_str!("../../../../examples/policy.rpl"),
        include_str!("../../../../examples/try-all.rpl"),
        include_str!("../../../../examples/valve.rpl"),
    ];
    let quoted = files.iter().flat_map(|file| {
        let file = file.replace("\\\"", "\u{1}").replace("\\n", "\n");
        let strings: Vec<String> = file.split('"').skip(1).step_by(2).map(|text| text.replace('\u{1}', "\"")).collect();
        strings
    });
    let compiles = |text: &String| text.contains('(') && library().load("test.rpl", text, &mut NoFiles).is_ok();
    quoted.chain(examples.map(str::to_string)).filter(compiles).collect()
}

#[test]
fn every_program_of_the_tests_and_examples_is_reloaded_alike() {
    let limits = rpl_runtime::state::limits::Limits { steps: 5_000, frames: 200, bytes: 1 << 24 };
    let texts = texts_elsewhere();
    assert!(texts.len() > 150, "{} programs were found", texts.len());
    for text in texts {
        let (mut plain, mut reloaded) = (start(&text), start(&text));
        plain.machine.limits = limits;
        reloaded.machine.limits = limits;
        for at in 0..120 {
            let saved = reloaded.save();
            let again = load(&text, &saved).unwrap_or_else(|error| panic!("{text}\nstep {at}: {error}"));
            assert!(again.save() == saved, "{text}\nstep {at}: saved again, the bytes differ");
            reloaded = again;
            let goes_on = step(&mut plain);
            assert_eq!(step(&mut reloaded), goes_on, "{text}\nstep {at}");
            if reloaded.machine != plain.machine {
                panic!("{text}\nafter step {at}: {}", plain.difference(&reloaded).expect("a difference has a name"));
            }
            if !goes_on {
                break;
            }
        }
    }
}

#[test]
fn a_difference_names_the_part() {
    let (_, text) = PROGRAMS[0];
    let mut system = start(text);
    for _ in 0..4 {
        step(&mut system);
    }
    let told = |change: &dyn Fn(&mut System<NoRobot>)| {
        let mut other = system.fork();
        change(&mut other);
        system.difference(&other).map(|difference| difference.path)
    };
    assert_eq!(told(&|_| {}), None);
    assert_eq!(told(&|other| other.machine.now_us += 1).as_deref(), Some("machine.now_us"));
    assert_eq!(told(&|other| other.machine.tasks[1].wait_number += 1).as_deref(), Some("machine.tasks[1].wait_number"));
    assert_eq!(told(&|other| other.machine.fluents[0].height = 7).as_deref(), Some("machine.fluents[0].height"));
    let place = system.machine.heap.pairs.places();
    let longer = told(&|other| {
        let value = other.machine.globals[0];
        other.machine.globals[0] = other.machine.heap.cons(value, value);
    });
    assert_eq!(longer.as_deref(), Some("machine.heap.pairs.cars"), "{place} pairs");
}

#[test]
fn only_the_program_it_was_saved_from_can_go_on() {
    let saved = start("(print 'a)").save();
    assert_eq!(load("(print 'b)", &saved).err(), Some(SaveError::Program));
    assert_eq!(load("(print 'a)", b"(print 'a)").err(), Some(SaveError::Foreign));
    let mut newer = saved.clone();
    newer[7] += 1;
    let Some(SaveError::Version(version)) = load("(print 'a)", &newer).err() else { panic!("another version is read") };
    assert_ne!(version, u32::from(saved[7]));
}

/// A run in the midst of its work, and its text.
fn sample() -> &'static (&'static str, Vec<u8>) {
    static SAMPLE: OnceLock<(&str, Vec<u8>)> = OnceLock::new();
    SAMPLE.get_or_init(|| {
        let (_, text) = PROGRAMS[6];
        let mut system = start(text);
        for _ in 0..6 {
            step(&mut system);
        }
        (text, system.save())
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn changed_bytes_are_refused(places in prop::collection::vec((any::<prop::sample::Index>(), 1..=255u8), 1..4)) {
        let (text, saved) = sample();
        let mut bytes = saved.clone();
        for (at, flip) in places {
            bytes[at.index(saved.len())] ^= flip;
        }
        prop_assume!(bytes != *saved);
        prop_assert!(load(text, &bytes).is_err());
    }

    #[test]
    fn cut_or_foreign_bytes_are_refused(at in any::<prop::sample::Index>(), tail in prop::collection::vec(any::<u8>(), 0..64)) {
        let (text, saved) = sample();
        let cut = at.index(saved.len());
        prop_assert!(load(text, &saved[..cut]).is_err());
        prop_assert!(load(text, &tail).is_err());
        prop_assert!(load(text, &[saved.as_slice(), &tail, b"."].concat()).is_err());
    }

    /// Even with a checksum that fits, bytes that make no sense are an error and no panic.
    #[test]
    fn nonsense_with_a_right_checksum_is_damaged(payload in prop::collection::vec(any::<u8>(), 0..512)) {
        let (text, saved) = sample();
        let mut bytes = saved[..15].to_vec();
        bytes.extend_from_slice(&crc32fast::hash(&payload).to_le_bytes());
        bytes.extend_from_slice(&payload);
        prop_assert_eq!(load(text, &bytes).err(), Some(SaveError::Damaged));
    }
}

#[test]
fn a_task_whose_record_is_gone_may_still_be_named() {
    // Its timer still names the second child.
    let text = "(pursue (wait-time 1) (wait-time 9)) (wait-time 5)";
    let mut system = start(text);
    system.advance_to(3_000_000);
    system.machine.collect();
    let copy = load(text, &system.save()).expect("what was saved is loaded");
    assert_eq!(end(copy), end(system));
}

#[test]
fn a_save_right_after_a_disturbance_knows_what_it_changed() {
    let text = "(par (:tag a (wait-time 9)) (seq (value (status a)) (wait-time 2) (print (value (status a)))))";
    let mut system = start(text);
    system.advance_to(1_000_000);
    let task =
        *system.machine.living_tasks().iter().find(|&&task| system.machine.path(task) == "main/a").expect("it lives");
    let task = system.machine.tasks.reference(task);
    system.disturb(Disturbance::Suspend(task));
    let mut copy = load(text, &system.save()).expect("what was saved is loaded");
    for run in [&mut system, &mut copy] {
        run.advance_to(3_000_000);
        assert_eq!(run.machine.output[0].text, "suspended");
    }
}
