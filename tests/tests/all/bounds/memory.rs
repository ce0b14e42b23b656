//! Whatever a plan makes counts: each program makes one kind of thing without end, in a process of its
//! own, whose memory the system measures.

#![cfg(target_os = "linux")]

use rpl_runtime::robot::NoRobot;
use rpl_runtime::run::system::{Progress, System};
use rpl_runtime::state::trace::EventKind;
use rpl_tests::{library, run, system, traced, transcript};
use std::process::Command;

/// What a program may make.
const LIMIT_BYTES: usize = 48 << 20;

/// The number of the program that a child process runs.
const CHILD: &str = "RPL_MEMORY_PROGRAM";

/// Kind of thing, and a program that makes it without end.
const PROGRAMS: &[(&str, &str)] = &[
    ("pairs", "(let ((l nil)) (loop (push 1 l)))"),
    ("lists of lists", "(let ((l nil)) (loop (push (list 1 2 3) l)))"),
    ("lists in the first half", "(let ((l nil)) (loop (setq l (list l))))"),
    ("short strings", "(let ((l nil)) (loop (push (format \"~a\" 7) l)))"),
    ("long strings", "(let ((l nil)) (loop (push (string-repeat \"x\" 100000) l)))"),
    ("a string doubled", "(let ((s \"x\")) (loop (setq s (string-append s s))))"),
    ("a text of itself", "(let ((s \"xy\")) (loop (setq s (concat s s))))"),
    ("a list doubled", "(let ((l (list 1))) (loop (setq l (append l l))))"),
    ("a list copied", "(let ((l (iota 100000)) (k nil)) (loop (push (reverse l) k)))"),
    ("a list of any length", "(make-list 1000000000 1)"),
    ("numbers of any count", "(range 100000000000)"),
    ("characters", "(let ((l nil)) (loop (push (string->list (string-repeat \"x\" 10000)) l)))"),
    ("closures", "(let ((l nil)) (loop (let ((x l)) (push (lambda () x) l))))"),
    ("cells", "(let ((l nil)) (loop (let ((x l)) (push (lambda () (setq x 2)) l))))"),
    ("hash tables", "(let ((l nil)) (loop (push (make-hash-table) l)))"),
    ("entries", "(let ((h (make-hash-table)) (i 0)) (loop (setf (gethash i h) i) (incf i)))"),
    ("entries of lists", "(let ((h (make-hash-table)) (i 0)) (loop (setf (gethash (list i i i) h) i) (incf i)))"),
    (
        "entries of strings",
        "(let ((h (make-hash-table)) (i 0)) (loop (setf (gethash (format \"~a\" i) h) i) (incf i)))",
    ),
    (
        "copies of entries",
        "(let ((h (alist->hash-table (map (lambda (i) (cons i i)) (iota 50000)))) (l nil)) (loop (push (hash-table->alist h) l)))",
    ),
    ("vectors", "(let ((l nil)) (loop (push (make-vector 1000 nil) l)))"),
    ("small vectors", "(let ((l nil)) (loop (push (vector 1) l)))"),
    ("vectors in vectors", "(let ((v #())) (loop (setq v (vector v))))"),
    ("vectors in the first half of vectors", "(let ((v #())) (loop (setq v (vector v 1))))"),
    ("lists in vectors in lists", "(let ((l nil)) (loop (push (vector (list (vector 1))) l)))"),
    ("a vector of any length", "(make-vector 1000000000000)"),
    ("copies of vectors", "(let ((v (make-vector 50000 1)) (l nil)) (loop (push (reverse v) l)))"),
    (
        "vectors of one another",
        "(let ((v (vector 1 2))) (loop (setq v (list->vector (append (vector->list v) (vector->list v))))))",
    ),
    ("sorted by a function", "(let ((l (iota 1000))) (loop (setq l (sort (lambda (a b) (< a b)) (append l l)))))"),
    ("keys that are vectors", "(let ((h (make-hash-table)) (i 0)) (loop (setf (gethash (vector i i) h) i) (incf i)))"),
    ("failures", "(let ((l nil)) (loop (with-failure-handling ((failure (f) (push f l))) (fail \"a message\"))))"),
    (
        "failures of failures",
        "(let ((x nil)) (loop (with-failure-handling ((failure (f) (setq x f))) (fail-composite (list x x x)))))",
    ),
    ("fluents", "(let ((l nil)) (loop (push (create-fluent 1) l)))"),
    ("networks", "(def-fluent f 1) (let ((l nil)) (loop (push (fluent (+ f 1)) l)))"),
    ("derived fluents", "(def-fluent f 1) (let ((l nil)) (loop (push (pulsed f) l)))"),
    ("watches", "(def-fluent f nil) (def-plan p () (loop (spawn (whenever f 1)))) (p)"),
    ("waits for conditions", "(def-fluent f nil) (def-plan p () (loop (spawn (wait-for (eq f 7))))) (p)"),
    ("tasks inside one another", "(def-plan p () (par (p))) (p)"),
    ("tasks beside one another", "(def-plan p () (loop (spawn (wait-time 9)))) (p)"),
    ("tasks of one construct", "(let ((l (iota 1000000))) (par-map (x l) (wait-time 1)))"),
    ("dead tasks", "(def-plan p () (let ((l nil)) (loop (push (spawn 1) l) (wait-time 0.001)))) (p)"),
    ("fluents about tasks", "(def-plan p () (let ((l nil)) (loop (push (status (spawn 1)) l) (wait-time 0.001)))) (p)"),
    (
        "tasks that wait deep",
        "(defun deep (n) (if (= n 0) (wait-time 9) (+ 1 (deep (- n 1))))) (def-plan p () (loop (spawn (deep 1000)))) (p)",
    ),
    ("policies", "(def-plan p () (loop (spawn (with-policy (wait-time 9) (wait-time 9))))) (p)"),
    ("priorities", "(def-plan p () (let ((i 0)) (loop (spawn (with-priority i (wait-time 9))) (incf i)))) (p)"),
    ("calls", "(defun deep (n) (+ 1 (deep n))) (deep 1)"),
    ("clean-ups", "(defun nest () (unwind-protect (nest) 1)) (nest)"),
    ("handlers", "(defun nest () (with-failure-handling ((timeout (f) 1)) (nest))) (nest)"),
    ("plan calls", "(def-plan p () (p) 1) (p)"),
    ("blocks", "(defun nest (f) (block b (nest (lambda () (return-from b f))))) (nest nil)"),
    ("symbols without names", "(loop (gensym))"),
    ("symbols", "(let ((i 0)) (loop (intern (format \"name-~a\" i)) (incf i)))"),
    ("output", "(loop (print \"a line that nobody takes\"))"),
    (
        "code that is kept",
        "(let ((l nil) (i 0)) (loop (push (execute-plan (list 'lambda nil (list 'quote (list i)))) l) (incf i)))",
    ),
    ("code that is not kept", "(let ((i 0)) (loop (execute-plan (list 'quote (list i i i i))) (incf i)))"),
    ("plans in plans", "(defun p (n) (+ 1 (execute-plan (list 'seq (list 'quote (list n)) (list 'p (+ n 1)))))) (p 1)"),
    ("large data as plans", "(let ((l (list 'seq))) (loop (setq l (append l l)) (execute-plan (list 'quote l))))"),
    ("sorted lists", "(let ((l (iota 1000))) (loop (setq l (sort < (append l l)))))"),
    ("sets", "(let ((l (map list (iota 100)))) (loop (setq l (union l (map (lambda (x) (list x x)) l)))))"),
    (
        "garbage of networks",
        "(def-fluent f 1) (defun g (x) (iota 20000) x) (def-fluent n (fluent (g f))) (loop (incf (value f)))",
    ),
    (
        "deep registers",
        "(defun f (n) (let ((a n) (b n) (c n) (d n) (e n)) (list a b c d e (f (list a b c d e))))) (f 1)",
    ),
    (
        "comparisons of plans in a large run",
        "(defvar l nil) (loop (setq l (append (iota 20000) l)) (compare-all '(push 1 l) (list '(push 2 l) '(push (random 9) l)) :runs 4))",
    ),
    (
        "macros that double",
        "(defmacro twice (n) (if (= n 0) 1 (list 'progn (list 'twice (- n 1)) (list 'twice (- n 1))))) (execute-plan '(twice 30))",
    ),
    (
        "macros that make much",
        "(defmacro grow () (let ((l nil)) (loop (push 1 l)))) (let ((l nil)) (loop (ignore-failures (error) (execute-plan '(grow))) (push (make-list 100000 1) l)))",
    ),
    (
        "long texts in plans",
        "(let ((s (string-repeat \"x\" 100000)) (l nil)) (loop (push s l) (execute-plan (list 'quote l))))",
    ),
    (
        "plans given to tasks",
        "(def-plan p () (par (:tag a (wait-time 100000)) (let ((l (list 1))) (loop (setq l (append l l)) (swap-plan a (list 'seq (list 'quote l) '(wait-time 100000))))))) (p)",
    ),
    ("timers", "(def-plan p () (let ((i 0)) (loop (spawn (at-time (+ 1000 i))) (incf i)))) (p)"),
    ("deadlines", "(def-plan p () (loop (spawn (with-timeout 9 (wait-time 8))))) (p)"),
    ("requests of a valve", "(def-valve v) (def-plan p () (with-valve v (loop (spawn (with-valve v 1))))) (p)"),
    ("formats", "(let ((s \"x\")) (loop (setq s (format \"~a~a\" s s))))"),
    ("records", "(defstruct r a b) (let ((l nil)) (loop (push (make-r :a 1 :b 2) l)))"),
    ("pairs of keys and values", "(let ((l nil) (i 0)) (loop (setq l (acons i (list i) l)) (incf i)))"),
    ("mapped lists", "(let ((l (iota 1000))) (loop (setq l (mapcar (lambda (x) (list x l)) (append l l)))))"),
    ("quorums", "(def-plan p () (quorum 1 1 (p) (wait-time 9))) (p)"),
];

/// Bytes of the memory of this process, by the name of the measure.
fn measured(what: &str) -> usize {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix(what));
    let kilobytes = line.and_then(|line| line.trim_start_matches(':').trim().strip_suffix(" kB"));
    kilobytes.and_then(|number| number.trim().parse::<usize>().ok()).unwrap_or(0) * 1024
}

/// The most memory the system has seen in the run of a program, and how it ended.
fn run_to_its_end(mut system: System<NoRobot>) -> (usize, String) {
    system.machine.limits.bytes = LIMIT_BYTES;
    system.machine.limits.steps = 10_000_000;
    system.machine.collect();
    while system.advance() == Progress::Running {}
    let most = measured("VmHWM");
    system.machine.output.clear();
    (most, transcript(&mut system))
}

/// Runs one program and tells the most memory it took, and its end.
#[test]
fn child() {
    let Some(number) = std::env::var(CHILD).ok().and_then(|number| number.parse::<usize>().ok()) else { return };
    let system = system(PROGRAMS[number].1);
    // The system starts to measure the highest anew.
    let is_reset = std::fs::write("/proc/self/clear_refs", "5").is_ok();
    let before = measured("VmRSS");
    assert!(is_reset && before > 0, "the system measures memory");
    let (most, ending) = run_to_its_end(system);
    let ending = ending.lines().rfind(|line| line.starts_with("failed: ") || line.starts_with("=> "));
    println!("TOOK {} {}", most.saturating_sub(before), ending.unwrap_or_default());
}

/// r[limit.memory]
#[test]
fn no_program_takes_much_more_than_the_limit() {
    let Ok(myself) = std::env::current_exe() else { panic!("the test knows where it is") };
    library();
    let mut faults = Vec::new();
    for (number, (kind, _)) in PROGRAMS.iter().enumerate() {
        let child = Command::new(&myself)
            .args(["--exact", "bounds::memory::child", "--nocapture"])
            .env(CHILD, number.to_string())
            // The command runs plans in its first thread; the arenas of the allocator for others are trimmed in other ways.
            .env("MALLOC_ARENA_MAX", "1")
            .output();
        let Ok(output) = child else { panic!("a child process starts") };
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let told = text.lines().find_map(|line| line.split_once("TOOK ")).map(|(_, told)| told.to_string());
        let Some(told) = told else {
            faults.push(format!("{kind}: {text} {}", String::from_utf8_lossy(&output.stderr)));
            continue;
        };
        let (bytes, ending) = told.split_once(' ').unwrap_or((&told, ""));
        let bytes: usize = bytes.parse().unwrap_or(usize::MAX);
        println!("{kind}: {:.2} of the limit, {:.60}", bytes as f64 / LIMIT_BYTES as f64, ending);
        let is_failure = ["out-of-memory", "stack-overflow", "runaway"].iter().any(|class| ending.contains(class));
        if bytes > LIMIT_BYTES / 10 * 13 || !is_failure {
            faults.push(format!("{kind}: {:.2} of the limit; {ending:.200}", bytes as f64 / LIMIT_BYTES as f64));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// What a text leaves behind when it has run and nothing refers to what it made: at most 300 kB more than one that
/// makes nothing.
#[track_caller]
fn leaves_nothing(text: &str) {
    let left = |text: &str| {
        let mut system = system(text);
        while system.advance() == Progress::Running {}
        let result = transcript(&mut system);
        assert!(result.ends_with("=> done"), "{text}\n{result:.300}");
        system.machine.collect();
        system.machine.used_bytes()
    };
    let (nothing, something) = (left("'done"), left(text));
    assert!(something < nothing + 300_000, "{text}\nleaves {} bytes", something - nothing);
}

/// r[limit.memory]
#[test]
fn what_nothing_refers_to_is_given_back() {
    leaves_nothing("(dotimes (i 100000) (list i i)) 'done");
    leaves_nothing("(dotimes (i 100000) (create-fluent i)) 'done");
    leaves_nothing("(def-fluent f 1) (dotimes (i 20000) (fluent (+ f i))) 'done");
    leaves_nothing("(dotimes (i 20000) (let ((h (make-hash-table))) (setf (gethash i h) h))) 'done");
    leaves_nothing("(def-plan p () (dotimes (i 20000) (spawn 1))) (p) 'done");
    leaves_nothing("(defun nest (n) (if (= n 0) (wait-time 1) (par (nest (- n 1))))) (nest 10000) 'done");
    leaves_nothing("(dotimes (i 20000) (with-priority i 1)) 'done");
    leaves_nothing("(dotimes (i 1000) (string-repeat \"x\" 100000)) 'done");
}

/// r[data.shared], r[limit.memory]
#[test]
fn code_that_nothing_refers_to_is_given_back() {
    let counts = |text: &str| {
        let mut system = system(text);
        while system.advance() == Progress::Running {}
        assert!(transcript(&mut system).ends_with("=> done"), "{text}");
        (system.program.codes.len(), system.program.sources.len(), system.program.constants.len())
    };
    let (codes, texts, constants) = counts("'done");
    let many = counts(
        "(dotimes (i 20000) (wait-time 0.1) (execute-plan (list 'seq (list 'quote (list i \"a text of the unit\"))))) 'done",
    );
    assert!(
        many.0 < codes + 10_000 && many.1 < texts + 5_000 && many.2 < constants + 5_000,
        "{many:?} are left, and there were {:?}",
        (codes, texts, constants)
    );
    // What is called later, or fails later, or runs on, is kept, and its place is its own.
    let churn =
        "(dotimes (i 20000) (wait-time 0.1) (execute-plan (list 'seq (list 'quote (list i \"a text of the unit\")))))";
    let kept = format!(
        "(def-fluent seven 7)
         (def-plan p ()
           (let ((f (execute-plan '(lambda (x) (list x \"kept\")))) (n (execute-plan '(fluent (+ seven 0)))) (failure nil))
             (with-failure-handling ((failure (g) (setq failure g))) (execute-plan '(fail \"in a unit\")))
             (spawn (execute-plan '(seq (wait-time 3000) (print 'spawned))))
             (execute-plan '(defun defined () \"defined\"))
             {churn}
             (wait-time 2000)
             (list (f 1) (value n) (failure-message failure) (execute-plan '(defined)))))
         (p)"
    );
    assert_eq!(run(&kept), "spawned\n=> ((1 \"kept\") 7 \"in a unit\" \"defined\")");
}

/// r[limit.memory]
#[test]
fn code_made_when_others_code_is_given_back_has_its_own_places() {
    let text = "(dotimes (i 6000) (wait-time 0.1)
                  (with-failure-handling ((error (f) nil)) (execute-plan (list '+ i ''x)))) 'done";
    let mut system = traced(text);
    let (mut failures, mut runs) = (0, true);
    while runs {
        runs = system.advance() == Progress::Running;
        for event in system.machine.trace.take().iter().filter(|event| event.kind == EventKind::Failed) {
            let has_place = event.details.iter().any(|(name, at)| name == "at" && at.starts_with("plan#"));
            assert!(has_place, "{event}");
            failures += 1;
        }
    }
    assert_eq!(failures, 6_000);
}
