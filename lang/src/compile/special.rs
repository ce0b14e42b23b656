//! The special forms: names, documentation, and what the compiler takes them for.

/// Forms the compiler itself understands; everything else is a macro or a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Special {
    Quote,
    Quasiquote,
    If,
    And,
    Or,
    Let,
    LetStar,
    Letrec,
    Lambda,
    Setq,
    Setf,
    Progn,
    Block,
    ReturnFrom,
    Return,
    Loop,
    Defvar,
    Defconstant,
    Defun,
    Defmacro,
    DefPlan,
    DefGoal,
    DefFluent,
    DefValve,
    DefFailure,
    Load,
    Deftest,
    Par,
    Pursue,
    TryAll,
    Plan,
    ParMap,
    PursueMap,
    TryAllMap,
    WithPolicy,
    WithPriority,
    WithTimeout,
    Process,
    Spawn,
    WithFailureHandling,
    Retry,
    Refail,
    EvapProtect,
    UnwindProtect,
    WithValve,
    OnInterrupt,
    OnResume,
    WithTaskSuspended,
    WaitFor,
    Whenever,
    Fluent,
}

impl Special {
    /// Whether it may only stand at top level.
    pub(crate) fn is_definition(self) -> bool {
        matches!(
            self,
            Special::Defvar
                | Special::Defconstant
                | Special::Defun
                | Special::Defmacro
                | Special::DefPlan
                | Special::DefGoal
                | Special::DefFluent
                | Special::DefValve
                | Special::DefFailure
                | Special::Load
                | Special::Deftest
        )
    }

    /// Whether it waits, assigns or starts tasks, which a network may not.
    pub(crate) fn is_effect(self) -> bool {
        matches!(
            self,
            Special::Par
                | Special::Pursue
                | Special::TryAll
                | Special::Plan
                | Special::ParMap
                | Special::PursueMap
                | Special::TryAllMap
                | Special::WithPolicy
                | Special::WithPriority
                | Special::WithTimeout
                | Special::Process
                | Special::Spawn
                | Special::WithValve
                | Special::WithTaskSuspended
                | Special::WaitFor
                | Special::Whenever
                | Special::OnInterrupt
                | Special::OnResume
        )
    }
}

/// A special form: its names, how it is written, and what it does.
#[derive(Clone, Copy, Debug)]
pub struct SpecialForm {
    /// Its name and its other names.
    pub names: &'static [&'static str],
    /// How it is written.
    pub form: &'static str,
    /// When it succeeds, when it fails, what its value is.
    pub doc: &'static str,
    /// Plan text that shows it; empty where the form says it all.
    pub example: &'static str,
}

/// All special forms.
pub fn special_forms() -> impl Iterator<Item = &'static SpecialForm> {
    TABLE.iter().map(|(_, form)| form)
}

/// Every name of a special form.
pub(crate) fn names() -> impl Iterator<Item = (&'static str, Special)> {
    TABLE.iter().flat_map(|&(special, form)| form.names.iter().map(move |&name| (name, special)))
}

macro_rules! forms {
    ($($special:ident [$($name:literal),+] $form:literal $doc:literal $example:literal;)*) => {
        &[$((Special::$special, SpecialForm { names: &[$($name),+], form: $form, doc: $doc, example: $example })),*]
    };
}

const TABLE: &[(Special, SpecialForm)] = forms! {
    Quote ["quote"] "(quote DATUM), 'DATUM" "The datum itself." "";
    Quasiquote ["quasiquote"] "`DATUM" "The datum with the values of its ,EXPR and the elements of its ,@LIST." "(let ((room 'hall)) `(go-to ,room))";
    If ["if"] "(if TEST THEN [ELSE])" "The value of THEN if the test is true, else that of ELSE, or nil." "";
    And ["and"] "(and FORM...)" "Nil at the first form that is nil, else the last value." "";
    Or ["or"] "(or FORM...)" "The first value that is not nil, else nil." "";
    Let ["let"] "(let ((NAME VALUE)...) FORM...)" "Runs the forms with the names bound; the values do not see the names." "(let ((a 1) (b 2))\n  (print (+ a b)))";
    LetStar ["let*"] "(let* ((NAME VALUE)...) FORM...)" "Runs the forms with the names bound one after the other." "";
    Letrec ["letrec"] "(letrec ((NAME FUNCTION)...) FORM...)" "Runs the forms with functions bound that may call each other." "";
    Lambda ["lambda", "fn"] "(lambda (PARAMETER...) FORM...)" "A function that remembers the variables around it." "(map (lambda (n) (* n n)) '(1 2 3))";
    Setq ["setq"] "(setq NAME VALUE...)" "Assigns variables; gives the last value." "";
    Setf ["setf"] "(setf PLACE VALUE...)" "Assigns places: a variable, (value F), (nth I LIST), (gethash KEY TABLE), a slot of a `defstruct`; gives the last value." "";
    Progn ["progn", "seq"] "(seq FORM...)" "Succeeds if all forms did, in order; fails at the first failure. The value is the last." "";
    Block ["block"] "(block NAME FORM...)" "Runs the forms; `(return-from NAME VALUE)` leaves them." "";
    ReturnFrom ["return-from"] "(return-from NAME [VALUE])" "Leaves the block of that name with a value; clean-ups run." "";
    Return ["return"] "(return [VALUE])" "Leaves the nearest loop with a value; clean-ups run." "";
    Loop ["loop"] "(loop FORM... [until E] [while E] FORM...)" "Runs the forms again and again until E is true, or while it is. The value is nil." "(let ((n 0))\n  (loop (incf n)\n    until (= n 3)\n    (print n)))";
    Defvar ["defvar"] "(defvar NAME [VALUE [\"DOC\"]])" "Defines a variable." "";
    Defconstant ["defconstant"] "(defconstant NAME VALUE [\"DOC\"])" "Defines a name that is never assigned." "";
    Defun ["defun"] "(defun NAME (PARAMETER...) [\"DOC\"] FORM...)" "Defines a function." "";
    Defmacro ["defmacro"] "(defmacro NAME (PARAMETER...) [\"DOC\"] FORM...)" "Defines a form that is replaced by what its body returns." "";
    DefPlan ["def-plan", "def-interp-proc"] "(def-plan NAME (PARAMETER...) [\"DOC\"] FORM...)" "Defines a plan: called like a function, and each call is a node of the task tree." "(def-plan wash (number)\n  \"Washes cups, one after the other.\"\n  (n-times number (wait-time 20)))";
    DefGoal ["def-goal"] "(def-goal (achieve (NAME PARAMETER...)) FORM...)" "Defines how goals of this name are achieved, by `(achieve (NAME ARGUMENT...))`. Several definitions of one goal are methods, tried in their order." "(def-goal (achieve (clean room))\n  (print room))\n(achieve (clean 'hall))";
    DefFluent ["def-fluent", "global-fluent"] "(def-fluent NAME VALUE [\"DOC\"])" "Defines a fluent: a value that changes over time and wakes tasks." "(def-fluent cups 0 \"How many cups are washed.\")\n(par (wait-for (>= cups 1))\n     (setf (value cups) 1))";
    DefValve ["def-valve"] "(def-valve NAME [\"DOC\"])" "Defines a valve: a pre-emptible semaphore that guards an effector." "";
    DefFailure ["def-failure"] "(def-failure NAME (PARENT) (SLOT...))" "Defines a class of failure with slots." "(def-failure slipped (plan-failure) (object))\n(ignore-failures (slipped)\n  (fail slipped \"the cup slipped\" :object 'cup))";
    Load ["load"] "(load \"FILE\")" "Reads another file, relative to this one and within the main file's folder tree." "";
    Deftest ["deftest"] "(deftest NAME [\"DOC\"] [:world \"NAME\"] [:scenario \"FILE\"] [:seed N] [:until TIME] FORM...)" "Defines a test, run by `rpl test` after the definitions of its text in a system of its own. It passes if its forms succeed." "(deftest adding\n  \"Numbers are added.\"\n  (assert (= (+ 1 2) 3)))";
    Par ["par"] "(par FORM...)" "Runs the forms concurrently. Succeeds if all did; fails at the first failure, and the others are evaporated. The value is the last child's." "(par (wait-time 2)\n     (print \"meanwhile\"))";
    Pursue ["pursue"] "(pursue FORM...)" "Runs the forms concurrently. Ends as the first of them ends, and the others are evaporated." "(pursue (wait-time 10)\n        (seq (wait-time 2) (print \"first\")))";
    TryAll ["try-all"] "(try-all FORM...)" "Runs the forms concurrently. Succeeds at the first success, and the others are evaporated; fails with a composite-failure when all failed." "(try-all (fail \"no\")\n         (seq (wait-time 1) 'yes))";
    Plan ["plan", "partial-order"] "(plan (STEP...) (:order A B)...)" "Runs the steps concurrently, B only when A is dead. Succeeds if all did; fails at the first failure." "(plan ((:tag paint (print \"paint\"))\n       (:tag clean (print \"clean\")))\n  (:order clean paint))";
    ParMap ["par-map"] "(par-map (NAME LIST) FORM...)" "As `par`, one child for each element." "(par-map (seconds '(3 1 2))\n  (wait-time seconds)\n  (print seconds))";
    PursueMap ["pursue-map"] "(pursue-map (NAME LIST) FORM...)" "As `pursue`, one child for each element." "";
    TryAllMap ["try-all-map"] "(try-all-map (NAME LIST) FORM...)" "As `try-all`, one child for each element." "";
    WithPolicy ["with-policy"] "(with-policy POLICY FORM...)" "Runs the forms such that the policy, a concurrent task of higher priority, is kept. Ends as the forms end; fails if the policy fails." "(def-fluent battery 20)\n(with-policy (whenever (< battery 30) (setf (value battery) 100))\n  (wait-time 5))";
    WithPriority ["with-priority"] "(with-priority N FORM...)" "Runs the forms as a task with another priority." "";
    WithTimeout ["with-timeout"] "(with-timeout SECONDS [:active] FORM...)" "Succeeds if the forms do in time; fails with `timeout` at the deadline, and they are evaporated. With `:active` only the time counts in which they are not suspended." "(with-failure-handling ((timeout (f) 'late))\n  (with-timeout 3 (wait-time 10)))";
    Process ["process", ":tag"] "(process NAME FORM...), (:tag NAME FORM...)" "Runs the forms as a task of that name, bound in the whole plan." "(par (process worker (wait-time 5))\n     (wait-for (end-task worker)))";
    Spawn ["spawn"] "(spawn FORM...)" "Starts a task and gives it at once; it lives at most as long as the plan call around it." "(let ((task (spawn (wait-time 5))))\n  (wait-for (end-task task)))";
    WithFailureHandling ["with-failure-handling"] "(with-failure-handling ((CLASS (NAME) FORM...)...) FORM...)" "Runs the forms; the first clause whose class fits takes their failure, after they have been cleaned up." "(with-failure-handling\n    ((arithmetic-error (f) (print (failure-message f))))\n  (/ 1 0))";
    Retry ["retry"] "(retry)" "In a clause of `with-failure-handling`: starts the forms again." "";
    Refail ["refail"] "(refail)" "In a clause of `with-failure-handling`: passes the failure on." "";
    EvapProtect ["evap-protect"] "(evap-protect FORM CLEAN-UP...)" "Runs the form; if it is cut short, the clean-up runs before the task dies." "(evap-protect (wait-time 5)\n  (print \"cut short\"))";
    UnwindProtect ["unwind-protect"] "(unwind-protect FORM CLEAN-UP...)" "Runs the form, and the clean-up however it ends. The value is the form's." "(unwind-protect (print \"work\")\n  (print \"clean up\"))";
    WithValve ["with-valve"] "(with-valve VALVE FORM...)" "Runs the forms holding the valve; it is given back however they end." "(def-valve arm-1)\n(with-valve arm-1\n  (wait-time 1))";
    OnInterrupt ["on-interrupt"] "(on-interrupt HOOK FORM...)" "Runs the forms; the hook runs when their valve is taken away." "";
    OnResume ["on-resume"] "(on-resume HOOK FORM...)" "Runs the forms; the hook runs when their valve comes back." "";
    WithTaskSuspended ["with-task-suspended"] "(with-task-suspended (TASK) FORM...)" "Runs the forms while a task rests." "";
    WaitFor ["wait-for"] "(wait-for CONDITION [:timeout SECONDS])" "Waits until the condition, a fluent or an expression over fluents, is true; gives its value, or nil when the time is over before." "(def-fluent level 0)\n(par (wait-for (> level 2))\n     (setf (value level) 3))";
    Whenever ["whenever"] "(whenever CONDITION [:missed :once|:always|:never] FORM...)" "Runs the forms each time the condition becomes true; ends by `(return)` only. What becomes true during the forms counts once by default." "(def-fluent level 0)\n(pursue (whenever (> level 2) (print \"high\"))\n        (seq (setf (value level) 3) (wait-time 1)))";
    Fluent ["fluent"] "(fluent EXPR)" "A fluent whose value is that of the expression over other fluents." "(def-fluent level 0)\n(let ((high (fluent (> level 2))))\n  (value high))";
};
