//! Words that users bring from Lisp, CRAM, Python, behaviour trees and the shell, and what they are
//! called here.

/// Foreign words, and advice.
const WORDS: &[(&[&str], &str)] = &[
    (
        &["sleep", "delay", "pause", "wait", "sleep-for"],
        "`(wait-time SECONDS)` waits for a time, `(wait-for CONDITION)` until something is true",
    ),
    (
        &["printf", "println", "princ", "prin1", "echo", "puts", "display", "write-line", "terpri"],
        "`(print VALUE)` writes a line; `(print (format \"~a of ~a\" A B))` puts several values into one",
    ),
    (&["for", "foreach", "doseq"], "`(dolist (NAME LIST) FORM...)` runs forms for each element"),
    (&["repeat"], "`(n-times N FORM...)` runs forms so many times, `(loop FORM... until TEST)` until a test is true"),
    (&["transform"], "`(map FUNCTION LIST)` gives the list of the values"),
    (&["find-all", "where"], "`(filter FUNCTION LIST)` keeps the elements for which the function is true"),
    (&["fold", "foldl", "fold-left"], "`(reduce FUNCTION LIST)` combines the elements"),
    (
        &["define", "def", "defparameter"],
        "`(defvar NAME VALUE)` defines a variable, `(defun NAME (PARAMETER...) FORM...)` a function",
    ),
    (
        &["defn", "def-cram-function", "def-top-level-cram-function", "def-process-module"],
        "`(def-plan NAME (PARAMETER...) FORM...)` defines a plan, `(defun NAME (PARAMETER...) FORM...)` a function",
    ),
    (&["begin", "do-all", "sequence", "top-level"], "`(seq FORM...)` runs forms one after the other"),
    (
        &["selector", "fallback", "first-of"],
        "`(try-in-order FORM...)` tries forms one after the other until one succeeds",
    ),
    (&["parallel", "concurrently", "in-parallel"], "`(par FORM...)` runs forms concurrently"),
    (&["race", "any-of"], "`(pursue FORM...)` ends with the first of its forms"),
    (&["async", "thread", "fork", "start-task"], "`(spawn FORM...)` starts a task and goes on"),
    (&["await", "join"], "`(wait-for (end-task TASK))` waits for the end of a task"),
    (&["kill", "cancel", "abort"], "`(evaporate TASK)` ends a task, clean-ups included"),
    (&["timeout"], "`(with-timeout SECONDS FORM...)` fails with `timeout` when the time is over"),
    (
        &["try", "catch", "handler-case", "handler-bind", "try-catch", "rescue", "except"],
        "`(with-failure-handling ((CLASS (NAME) FORM...)) FORM...)` handles failures of its forms",
    ),
    (&["throw", "raise", "error", "signal"], "`(fail CLASS \"message\")` fails"),
    (&["finally", "ensure", "defer"], "`(unwind-protect FORM CLEAN-UP...)` runs the clean-up however the form ends"),
    (&["exit", "quit", "halt"], "a run ends with its last form; `(fail \"message\")` ends it at once"),
    (&["make-fluent"], "`(create-fluent VALUE)` makes a fluent, `(def-fluent NAME VALUE)` one with a name"),
    (&["fl-value", "get-value"], "`(value FLUENT)` is the value of a fluent"),
    (&["set", "set!"], "`(setf PLACE VALUE)` assigns"),
    (&["true"], "the true value is written `t`"),
    (&["false", "none"], "the false value is written `nil`"),
    (&["else", "elif", "elseif"], "`(cond (TEST FORM...) (t FORM...))` has several branches"),
    (&["len", "size"], "`(length LIST)` counts elements"),
    (&["concatenate", "string-concat", "strcat"], "`(string-append STRING...)` joins strings"),
    (&["time", "clock", "get-time", "current-time"], "`(now)` is the time in seconds"),
    (&["rand", "randint"], "`(random LIMIT)` is a random number from 0 to below the limit"),
    (&["%", "modulo"], "`(mod NUMBER DIVISOR)` is the remainder"),
    (&["**", "pow", "^"], "`(expt BASE EXPONENT)` is the power"),
    (&["=="], "`=` compares numbers, `equal` everything"),
    (&["+=", "-=", "++"], "`(incf NAME)` adds 1, `(incf NAME N)` adds N, `(decf NAME N)` takes N away"),
    (&["!=", "<>"], "`/=` compares numbers; for anything else write `(not (equal A B))`"),
    (&["!"], "`(not VALUE)` is true for nil"),
    (&["//", "--", "/*"], "a comment begins with `;`"),
    (&["&&"], "`(and FORM...)` is true if all forms are"),
    (&["then"], "`(if TEST THEN ELSE)` has no words between its parts"),
    (&["grasp", "grab", "pick", "take", "lift"], "`(pick-up 'THING)` takes a thing into the hand"),
    (&["release", "put", "drop", "place-down", "ungrasp"], "`(put-down)` lays down what is in the hand"),
    (
        &["move", "drive", "forward", "move-forward"],
        "`(go-to 'PLACE)` drives to a place, `(drive-ahead 1m)` straight on",
    ),
    (&["turn", "rotate", "turn-left", "turn-right"], "`(spin 90deg)` turns on the spot"),
    (
        &["stop", "stop-robot"],
        "`(evaporate TASK)` ends a task, and its behaviours stop with it; `(fail \"message\")` ends the run",
    ),
    (&["say", "speak", "ask"], "`(print VALUE)` writes a line"),
    (&["break"], "`(return)` leaves a loop"),
    (&["continue"], "`(when TEST FORM...)` around the rest of the loop passes over it"),
    (
        &["call", "invoke", "execute", "run"],
        "a plan is called by its name alone; `(execute-plan PLAN)` runs one that is data",
    ),
    (
        &["wait-until", "wait-while", "until"],
        "`(wait-for CONDITION)` waits until a condition is true, `(at-time SECONDS)` until a time of the run",
    ),
    (&["at", "after"], "`(at-time SECONDS)` waits until that time of the run, `(wait-time SECONDS)` for a while"),
    (&["import", "include", "use", "from"], "`(load \"FILE\")` loads the definitions of another file"),
    (&["assert-equal", "assert-eq", "is", "expect"], "`(assert (equal A B))` fails if the test is not true"),
    (&["class", "struct", "record"], "`(defstruct NAME SLOT...)` defines a kind of record"),
    (&["dict", "hashmap", "hash-map"], "`(make-hash-table)` makes a table"),
];

/// What a foreign word is called here.
pub(super) fn advice(word: &str) -> Option<&'static str> {
    WORDS.iter().find(|(words, _)| words.contains(&word)).map(|&(_, advice)| advice)
}

/// All foreign words and the advice on them.
pub fn foreign_words() -> impl Iterator<Item = (&'static str, &'static str)> {
    WORDS.iter().flat_map(|&(words, advice)| words.iter().map(move |&word| (word, advice)))
}
