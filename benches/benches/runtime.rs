//! Runtime: how fast plans are read and run, how many tasks there can be, and what each costs.

use rpl_benches::{Question, Report, in_fresh_process, median_ms, resident_bytes};
use rpl_lang::source::SourceId;
use rpl_lang::symbol::Symbols;
use rpl_lang::syntax::Tree;
use rpl_mission::libraries::library_without_robot;
use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::library::Library;
use rpl_runtime::run::system::{Outcome, Progress, System};
use rpl_runtime::state::value::Value;
use std::hint::black_box;
use std::sync::Arc;

const RUNS: usize = 9;

const SPAWN: &str = include_str!("../rpl/spawn.rpl");

const BLOCKED: &str = "(defvar numbers (let ((l nil)) (dotimes (i COUNT) (push i l)) l))
    (def-fluent never nil)
    (wait-time 1)
    (pursue (par-map (n numbers) (wait-for never))
            (n-times 1000 (wait-time 1)))
    'done";

const MONITORS: &str = "(defvar fluents (let ((l nil)) (dotimes (i 1000) (push (create-fluent 0) l)) l))
    (defvar reactions 0)
    (pursue
      (par-map (f fluents) (whenever (> f 5) (setq reactions (+ reactions 1))))
      (seq (wait-time 1)
           (n-times 100
             (dolist (f fluents) (setf (value f) 10) (wait-time 0) (setf (value f) 0)))
           reactions))";

/// Twenty lines of a plan; the name of each definition ends in its number.
const CHECKED: &str = "(def-fluent level-NUMBER 0 \"How full it is.\")
(def-valve tap-NUMBER)
(def-failure leak-NUMBER (plan-failure) (place))

(defun high-NUMBER? (bound)
  (let ((level (value level-NUMBER)))
    (and (> level bound) (< level (* 2 bound)))))

(def-plan fill-NUMBER (litres &key (step 1))
  (with-valve tap-NUMBER
    (with-retry-counters ((again 3))
      (with-failure-handling ((leak-NUMBER (f) (print (failure-message f)) (do-retry again) (refail)))
        (dotimes (i litres)
          (wait-time (if (= 0 (mod i 3)) 2 1))
          (incf (value level-NUMBER) step)
          (when (> i 90) (fail leak-NUMBER \"at litre ~a\" i :place 'tap)))))))


(with-policy (whenever (high-NUMBER? 5) (print (format \"high at ~a\" (now))))
  (par (fill-NUMBER 3 :step 2) (try-all (wait-for (>= level-NUMBER 6)) (wait-time 60))))
";

fn library() -> Arc<Library> {
    library_without_robot(Vec::new()).unwrap_or_else(|error| panic!("{error}"))
}

/// A run of a text up to the first moment at which every task is blocked.
fn settled(library: &Arc<Library>, text: &str) -> System<NoRobot> {
    match System::without_robot(library, "bench.rpl", text, 0) {
        Ok(mut system) => {
            system.settle();
            system
        }
        Err(rejected) => panic!("{}", rejected.render(false)),
    }
}

fn to_the_end(mut system: System<NoRobot>) -> System<NoRobot> {
    while system.advance() == Progress::Running {}
    system
}

/// Median milliseconds from the first block to the end; the value at the end must be the integer.
fn run_ms(library: &Arc<Library>, text: &str, value: i64) -> f64 {
    let expected = Some(Outcome::Succeeded(Value::Int(value)));
    let system = settled(library, text);
    median_ms(
        RUNS,
        || system.fork(),
        |system| {
            let system = to_the_end(system);
            assert_eq!(system.outcome(), expected, "{}", describe(&system));
            system
        },
    )
}

fn describe(system: &System<NoRobot>) -> String {
    match system.outcome() {
        Some(Outcome::Failed(failure)) => system.machine.show(&system.program, failure),
        other => format!("{other:?}"),
    }
}

fn with_count(text: &str, count: usize) -> String {
    text.replace("COUNT", &count.to_string())
}

/// A run in which `count` tasks wait for a fluent.
fn with_blocked(library: &Arc<Library>, count: usize) -> System<NoRobot> {
    let mut system = settled(library, &with_count(BLOCKED, count));
    system.advance();
    assert!(system.machine.tasks.iter().count() > count);
    system
}

fn main() {
    let report = Report::from_arguments();
    let library = library();
    texts(&report, &library);
    tasks(&report, &library);
    state(&report, &library);
}

fn texts(report: &Report, library: &Arc<Library>) {
    let read = Question::new("read", "read 1 MB of plan text", "ms", 300.0, "hand-written reader 25");
    report.row(read, || {
        let text = rpl_stdlib::PRELUDE.repeat(1_000_000 / rpl_stdlib::PRELUDE.len() + 1);
        let text = &text[..text[..1_000_000].rfind("\n\n").unwrap_or(1_000_000)];
        median_ms(
            RUNS,
            || (Symbols::default(), Tree::default()),
            |(mut symbols, mut tree)| {
                let (forms, diagnostics) = rpl_lang::reader::read(text, SourceId(0), &mut symbols, &mut tree);
                assert!(forms.len() > 1_000 && diagnostics.is_empty());
                (tree, symbols)
            },
        )
    });
    let check = Question::new("check", "check 2,000 lines", "ms", 50.0, "nobody checks plans");
    report.row(check, || {
        let text: String = (0..100).map(|number| CHECKED.replace("NUMBER", &number.to_string())).collect();
        assert_eq!(text.lines().count(), 2_000);
        median_ms(
            RUNS,
            || (),
            |()| {
                let (findings, program) = library.check("bench.rpl", &text, None, &mut rpl_lang::compile::NoFiles);
                assert!(findings.is_empty(), "{}", rpl_lang::diagnostic::render(&findings, &program.sources, false));
                program
            },
        )
    });
}

fn tasks(report: &Report, library: &Arc<Library>) {
    let million = Question::new(
        "million",
        "spawn, run and join a million tasks",
        "ms",
        150.0,
        "ten times what `--bench language` has",
    );
    report.row(million, || run_ms(library, &SPAWN.replace("100000", "1000000"), 1_000_000));
    let react = Question::new(
        "react",
        "react to one changed fluent in a plan of 1,000 monitors",
        "us",
        2.0,
        "BehaviorTree.CPP 214 a tick, py_trees 12,000",
    );
    report.row(react, || {
        let system = settled(library, MONITORS);
        let ms = median_ms(
            RUNS,
            || system.fork(),
            |system| {
                let system = to_the_end(system);
                assert_eq!(system.outcome(), Some(Outcome::Succeeded(Value::Int(100_000))), "{}", describe(&system));
                system
            },
        );
        ms * 1e3 / 100_000.0
    });
}

fn state(report: &Report, library: &Arc<Library>) {
    let bytes = Question::new("bytes", "bytes a blocked task", "bytes", 150.0, "Guile 275, Lua 1,253; CRAM 314,000");
    let bytes = Question { anchors: Some("bytes"), ..bytes };
    report.row(bytes, || {
        const COUNT: usize = 200_000;
        in_fresh_process("bytes", || {
            let mut system = settled(library, &with_count(BLOCKED, COUNT));
            let before = resident_bytes().unwrap_or(f64::NAN);
            system.advance();
            let after = resident_bytes().unwrap_or(f64::NAN);
            assert!(system.machine.tasks.iter().count() > COUNT);
            (after - before) / COUNT as f64
        })
    });
    let idle = Question::new(
        "idle",
        "what 100,000 blocked tasks add to an instant",
        "ns",
        100.0,
        "CRAM: 1,000 take 1.6 cores",
    );
    report.row(idle, || {
        let per_instant = |count| {
            let system = with_blocked(library, count);
            median_ms(
                RUNS,
                || system.fork(),
                |mut system| {
                    for _ in 0..900 {
                        system.advance();
                    }
                    system
                },
            ) * 1e6
                / 900.0
        };
        per_instant(100_000) - per_instant(1)
    });
    let small = Question::new("fork-small", "fork a run of ten blocked tasks", "µs", 2.0, "nobody can");
    report.row(small, || {
        let system = with_blocked(library, 10);
        let forks = |()| (0..1_000).for_each(|_| drop(black_box(system.fork())));
        median_ms(RUNS, || (), forks)
    });
    let fork = Question::new("fork", "fork the whole state, 100,000 blocked tasks", "ms", 10.0, "nobody can");
    report.row(fork, || {
        let system = with_blocked(library, 100_000);
        median_ms(RUNS, || (), |()| black_box(system.fork()))
    });
    let save = Question::new("save", "save and load the whole state, 100,000 blocked tasks", "ms", 200.0, "nobody can");
    report.row(save, || {
        let system = with_blocked(library, 100_000);
        let text = with_count(BLOCKED, 100_000);
        let load = || match library.load("bench.rpl", &text, &mut rpl_lang::compile::NoFiles) {
            Ok(loaded) => loaded,
            Err(rejected) => panic!("{}", rejected.render(false)),
        };
        median_ms(RUNS, load, |loaded| match System::load(&system.save(), library.clone(), loaded, NoRobot) {
            Ok(again) => again,
            Err(error) => panic!("{error}"),
        })
    });
}
