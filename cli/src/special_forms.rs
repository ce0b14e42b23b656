//! Documentation of the forms the compiler itself understands.

/// A special form: its names, how it is written, and what it does.
#[derive(Clone, Copy, Debug)]
pub struct SpecialForm {
    /// Its name and its other names.
    pub names: &'static [&'static str],
    /// How it is written.
    pub form: &'static str,
    /// When it succeeds, when it fails, what its value is.
    pub doc: &'static str,
}

macro_rules! forms {
    ($([$($name:literal),+] $form:literal $doc:literal)*) => {
        &[$(SpecialForm { names: &[$($name),+], form: $form, doc: $doc }),*]
    };
}

/// All special forms.
pub const SPECIAL_FORMS: &[SpecialForm] = forms! {
    ["quote"] "(quote DATUM), 'DATUM" "The datum itself."
    ["quasiquote"] "`DATUM" "The datum with the values of its ,EXPR and the elements of its ,@LIST."
    ["if"] "(if TEST THEN [ELSE])" "The value of THEN if the test is true, else that of ELSE, or nil."
    ["and"] "(and FORM...)" "Nil at the first form that is nil, else the last value."
    ["or"] "(or FORM...)" "The first value that is not nil, else nil."
    ["let"] "(let ((NAME VALUE)...) FORM...)" "Runs the forms with the names bound; the values do not see the names."
    ["let*"] "(let* ((NAME VALUE)...) FORM...)" "Runs the forms with the names bound one after the other."
    ["letrec"] "(letrec ((NAME FUNCTION)...) FORM...)" "Runs the forms with functions bound that may call each other."
    ["lambda", "fn"] "(lambda (PARAMETER...) FORM...)" "A function that remembers the variables around it."
    ["setq"] "(setq NAME VALUE...)" "Assigns variables; gives the last value."
    ["setf"] "(setf PLACE VALUE...)" "Assigns places: a variable, (value F), (nth I LIST), (gethash KEY TABLE), a slot of a `defstruct`; gives the last value."
    ["progn", "seq"] "(seq FORM...)" "Succeeds if all forms did, in order; fails at the first failure. The value is the last."
    ["block"] "(block NAME FORM...)" "Runs the forms; `(return-from NAME VALUE)` leaves them."
    ["return-from"] "(return-from NAME [VALUE])" "Leaves the block of that name with a value; clean-ups run."
    ["return"] "(return [VALUE])" "Leaves the nearest loop with a value; clean-ups run."
    ["loop"] "(loop FORM... [until E] [while E] FORM...)" "Runs the forms again and again until E is true, or while it is. The value is nil."
    ["defvar"] "(defvar NAME VALUE [\"DOC\"])" "Defines a variable."
    ["defconstant"] "(defconstant NAME VALUE [\"DOC\"])" "Defines a name that is never assigned."
    ["defun"] "(defun NAME (PARAMETER...) [\"DOC\"] FORM...)" "Defines a function."
    ["defmacro"] "(defmacro NAME (PARAMETER...) [\"DOC\"] FORM...)" "Defines a form that is written out as what its body gives."
    ["def-plan", "def-interp-proc"] "(def-plan NAME (PARAMETER...) [\"DOC\"] FORM...)" "Defines a plan: called like a function, and each call is a node of the task tree."
    ["def-goal"] "(def-goal (achieve (NAME PARAMETER...)) FORM...)" "Defines how goals of this name are achieved, by `(achieve (NAME ARGUMENT...))`. Several definitions of one goal are methods, tried in their order."
    ["def-fluent", "global-fluent"] "(def-fluent NAME VALUE [\"DOC\"])" "Defines a fluent: a value that changes over time and wakes tasks."
    ["def-valve"] "(def-valve NAME [\"DOC\"])" "Defines a valve: a pre-emptible semaphore that guards an effector."
    ["def-failure"] "(def-failure NAME (PARENT) (SLOT...))" "Defines a class of failure with slots."
    ["load"] "(load \"FILE\")" "Reads another file, relative to this one and within the main file's folder tree."
    ["par"] "(par FORM...)" "Runs the forms concurrently. Succeeds if all did; fails at the first failure, and the others are evaporated. The value is the last child's."
    ["pursue"] "(pursue FORM...)" "Runs the forms concurrently. Ends as the first of them ends, and the others are evaporated."
    ["try-all"] "(try-all FORM...)" "Runs the forms concurrently. Succeeds at the first success, and the others are evaporated; fails with a composite-failure when all failed."
    ["plan", "partial-order"] "(plan (STEP...) (:order A B)...)" "Runs the steps concurrently, B only when A is dead. Succeeds if all did; fails at the first failure."
    ["par-map"] "(par-map (NAME LIST) FORM...)" "As `par`, one child for each element."
    ["pursue-map"] "(pursue-map (NAME LIST) FORM...)" "As `pursue`, one child for each element."
    ["try-all-map"] "(try-all-map (NAME LIST) FORM...)" "As `try-all`, one child for each element."
    ["with-policy"] "(with-policy POLICY FORM...)" "Runs the forms such that the policy, a concurrent task of higher priority, is kept. Ends as the forms end; fails if the policy fails."
    ["with-priority"] "(with-priority N FORM...)" "Runs the forms as a task with another priority."
    ["with-timeout"] "(with-timeout SECONDS FORM...)" "Succeeds if the forms do in time; fails with `timeout` at the deadline, and they are evaporated."
    ["process"] "(process NAME FORM...)" "Runs the forms as a task of that name, bound in the whole plan."
    ["spawn"] "(spawn FORM...)" "Starts a task and gives it at once; it lives at most as long as the plan call around it."
    ["with-failure-handling"] "(with-failure-handling ((CLASS (NAME) FORM...)...) FORM...)" "Runs the forms; the first clause whose class fits takes their failure, after they have been cleaned up."
    ["retry"] "(retry)" "In a clause of `with-failure-handling`: starts the forms again."
    ["refail"] "(refail)" "In a clause of `with-failure-handling`: passes the failure on."
    ["evap-protect"] "(evap-protect FORM CLEAN-UP...)" "Runs the form; if it is cut short, the clean-up runs before the task dies."
    ["unwind-protect"] "(unwind-protect FORM CLEAN-UP...)" "Runs the form, and the clean-up however it ends. The value is the form's."
    ["with-valve"] "(with-valve VALVE FORM...)" "Runs the forms holding the valve; it is given back however they end."
    ["on-interrupt"] "(on-interrupt HOOK FORM...)" "Runs the forms; the hook runs when their valve is taken away."
    ["on-resume"] "(on-resume HOOK FORM...)" "Runs the forms; the hook runs when their valve comes back."
    ["with-task-suspended"] "(with-task-suspended (TASK) FORM...)" "Runs the forms while a task rests."
    ["wait-for"] "(wait-for CONDITION)" "Waits until the condition, a fluent or an expression over fluents, is true; gives its value."
    ["whenever"] "(whenever CONDITION FORM...)" "Runs the forms each time the condition becomes true; ends by `(return)` only."
    ["fluent"] "(fluent EXPR)" "A fluent whose value is that of the expression over other fluents."
};
