//! Going on in another process: what was outside is interrupted, and `def-resume` runs first.

use rpl_lang::compile::NoFiles;
use rpl_lang::symbol::Symbol;
use rpl_mission::libraries::base_natives;
use rpl_runtime::robot::{BehaviourSpec, Outbox, Outside, RobotTables, StopReason};
use rpl_runtime::run::library::Library;
use rpl_runtime::run::system::{Progress, System};
use rpl_runtime::state::failure::Raise;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::value::Value;
use rpl_tests::{session, system, transcript};
use std::sync::Arc;

/// Walks on and on, somewhere outside.
struct Walker(RobotTables);

impl Walker {
    fn new() -> Self {
        let walking = BehaviourSpec {
            name: "walking".into(),
            doc: "Walks.".into(),
            valve: Some("legs".into()),
            parameters: "".into(),
        };
        Self(RobotTables { behaviours: vec![walking], valves: vec!["legs".into()], ..RobotTables::default() })
    }
}

impl Outside for Walker {
    fn tables(&self) -> &RobotTables {
        &self.0
    }

    fn start(&mut self, _: &Machine, _: u16, _: &[(Symbol, Value)], _: &mut Outbox) -> Result<(), Raise> {
        Ok(())
    }

    fn stop(&mut self, _: u16, _: StopReason, _: &mut Outbox) {}

    fn next_event_us(&self, stepped_us: u64) -> Option<u64> {
        Some(stepped_us + 1_000_000)
    }

    fn renew(&mut self, outbox: &mut Outbox) -> bool {
        outbox.interrupted.push(0);
        true
    }
}

fn walker(text: &str) -> System<Walker> {
    let robot = Walker::new();
    let library = Library::new(base_natives(), &[("prelude", rpl_stdlib::PRELUDE)], robot.tables())
        .unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
    let loaded = library.load("plan.rpl", text, &mut NoFiles).unwrap_or_else(|error| panic!("{}", error.render(false)));
    System::new(Arc::new(library), loaded, robot, 0)
}

/// What a plan prints that is gone on with elsewhere at these times, in seconds, and how it ends.
fn gone_on_with(text: &str, times_s: &[u64]) -> String {
    let mut system = walker(text);
    let mut times_s = times_s.iter().peekable();
    loop {
        let progress = system.advance();
        if times_s.next_if(|&&time_s| system.machine.now_us >= time_s * 1_000_000).is_some() {
            assert!(system.renew_outside(), "somebody walks outside");
        }
        system.machine.check_invariants().unwrap_or_else(|broken| panic!("{text}\n{broken}"));
        if progress == Progress::Ended {
            let value = *system.machine.tasks[system.machine.main].value();
            let ended = system.with_machine(|machine, around| machine.show(around.program, value));
            let printed = system.machine.output.iter().map(|line| line.text.clone());
            return printed.chain([ended]).collect::<Vec<_>>().join("\n");
        }
    }
}

/// r[resume.interrupted]
#[test]
fn a_behaviour_is_interrupted_and_can_begin_anew() {
    let plan = "
(with-valve legs
  (with-failure-handling ((interrupted (f) (print (list 'interrupted (now))) (retry)))
    (pursue (run-behaviour walking) (at-time 6))))
(holds-valve? legs)";
    assert_eq!(gone_on_with(plan, &[2, 4]), "(interrupted 2.0)\n(interrupted 4.0)\nnil");
}

/// r[resume.form] r[resume.first]
#[test]
fn what_is_defined_for_it_runs_before_all_else_in_its_order() {
    let plan = "
(def-resume look \"Looks.\" (print (list 'looks (now))))
(def-resume listen (print 'listens))
(with-priority 1000
  (ignore-failures (interrupted) (with-valve legs (run-behaviour walking)))
  (print 'goes-on))
(look)";
    assert_eq!(gone_on_with(plan, &[3]), "(looks 3.0)\nlistens\ngoes-on\n(looks 3.0)\n(looks 3.0)");
}

/// r[resume.holds]
#[test]
fn one_that_waits_lets_the_others_go_on_but_for_what_it_holds() {
    let plan = "
(def-resume look (with-valve legs (wait-time 2) (print (list 'looked (now)))))
(par
  (progn (wait-time 4) (print (list 'others (now))))
  (with-valve legs
    (with-failure-handling ((interrupted (f) (retry)))
      (pursue (run-behaviour walking) (at-time 6)))
    (print (list 'walked (now)))))
'done";
    assert_eq!(gone_on_with(plan, &[3]), "(others 4.0)\n(looked 5.0)\n(walked 6.0)\ndone");
}

/// r[resume.failure]
#[test]
fn one_that_fails_lets_the_others_run_and_fails_the_plan() {
    let plan = "
(def-resume look (fail plan-failure \"it is dark\"))
(def-resume listen (print 'listens))
(unwind-protect (wait-time 10) (print 'cleaned))";
    assert_eq!(gone_on_with(plan, &[3]), "listens\ncleaned\nplan-failure: it is dark");
    let handled = plan.replacen("(fail ", "(ignore-failures (failure) (fail ", 1).replacen("dark\"))", "dark\")))", 1);
    assert_eq!(gone_on_with(&handled, &[3]), "listens\ncleaned\nnil");
}

/// r[resume.when]
#[test]
fn nothing_runs_where_nothing_is_outside() {
    let mut alone = system("(def-resume look (print 'looks)) (wait-time 2) 'done");
    while alone.advance() == Progress::Running {
        assert!(!alone.renew_outside());
    }
    assert_eq!(transcript(&mut alone), "=> done");
}

/// r[resume.again]
#[test]
fn defined_again_it_keeps_its_turn() {
    let plan = "
(def-resume one (print 'one))
(def-resume two (print 'two))
(def-resume one (print 'other))
(wait-time 2)";
    assert_eq!(gone_on_with(plan, &[1]), "other\ntwo\nnil");
    let plan = "
(def-resume one (print 'one))
(def-resume two (print 'two))
(def-plan one () (print 'no-more))
(wait-time 2)";
    assert_eq!(gone_on_with(plan, &[1]), "two\nnil");
    let mut prompt = session();
    assert!(prompt.submit("<1>", "(def-resume)", &mut NoFiles).is_err());
    assert!(prompt.submit("<1>", "(progn (wait-time 1) (let () (def-resume x)))", &mut NoFiles).is_err());
}
