//! The special forms, by name.

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

/// Every name of a special form.
pub(crate) const TABLE: &[(&str, Special)] = &[
    ("quote", Special::Quote),
    ("quasiquote", Special::Quasiquote),
    ("if", Special::If),
    ("and", Special::And),
    ("or", Special::Or),
    ("let", Special::Let),
    ("let*", Special::LetStar),
    ("letrec", Special::Letrec),
    ("lambda", Special::Lambda),
    ("fn", Special::Lambda),
    ("setq", Special::Setq),
    ("setf", Special::Setf),
    ("progn", Special::Progn),
    ("seq", Special::Progn),
    ("block", Special::Block),
    ("return-from", Special::ReturnFrom),
    ("return", Special::Return),
    ("loop", Special::Loop),
    ("defvar", Special::Defvar),
    ("defconstant", Special::Defconstant),
    ("defun", Special::Defun),
    ("defmacro", Special::Defmacro),
    ("def-plan", Special::DefPlan),
    ("def-interp-proc", Special::DefPlan),
    ("def-goal", Special::DefGoal),
    ("def-fluent", Special::DefFluent),
    ("global-fluent", Special::DefFluent),
    ("def-valve", Special::DefValve),
    ("def-failure", Special::DefFailure),
    ("load", Special::Load),
    ("par", Special::Par),
    ("pursue", Special::Pursue),
    ("try-all", Special::TryAll),
    ("plan", Special::Plan),
    ("partial-order", Special::Plan),
    ("par-map", Special::ParMap),
    ("pursue-map", Special::PursueMap),
    ("try-all-map", Special::TryAllMap),
    ("with-policy", Special::WithPolicy),
    ("with-priority", Special::WithPriority),
    ("with-timeout", Special::WithTimeout),
    ("process", Special::Process),
    ("spawn", Special::Spawn),
    ("with-failure-handling", Special::WithFailureHandling),
    ("retry", Special::Retry),
    ("refail", Special::Refail),
    ("evap-protect", Special::EvapProtect),
    ("unwind-protect", Special::UnwindProtect),
    ("with-valve", Special::WithValve),
    ("on-interrupt", Special::OnInterrupt),
    ("on-resume", Special::OnResume),
    ("with-task-suspended", Special::WithTaskSuspended),
    ("wait-for", Special::WaitFor),
    ("whenever", Special::Whenever),
    ("fluent", Special::Fluent),
];
