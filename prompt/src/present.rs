//! What stands where in the run of the prompt, asked of the run itself.

use super::session::Session;
use rpl_drive::show::situation::{Situation, Standing, ValveStanding};
use rpl_drive::stopping::own_text::is_own;
use rpl_mission::robot::Robot;
use rpl_runtime::run::system::System;
use rpl_runtime::state::task::State;
use rpl_runtime::state::value::TaskRef;
use std::collections::BTreeMap;

/// The events of the run, and how the living stand now: asked of the run, but for who suspended a
/// task by `suspend`, which only the events tell.
pub fn situation(session: &Session) -> Situation {
    let branch = &session.branch;
    let mut situation = Situation::after(&branch.log);
    let machine = &branch.system.machine;
    situation.now_us = machine.now_us;
    let told = std::mem::take(&mut situation.tasks);
    let (ends_us, suspensions) = (machine.wait_ends_us(), machine.suspended_by());
    let lives = machine.living_tasks().into_iter().enumerate().map(|(number, task)| {
        let path = machine.own_path(task);
        let suspended_by = match (suspensions.get(&task), told.get(&path)) {
            _ if !machine.tasks[task].is_held() => Vec::new(),
            (Some(by), _) => by.iter().map(|&other| machine.own_path(other)).collect(),
            (None, Some(told)) => told.suspended_by.clone(),
            (None, None) => Vec::new(),
        };
        let standing = Standing { number, suspended_by, ..standing(&branch.system, &ends_us, task) };
        (path, standing)
    });
    situation.tasks = lives.collect();
    let path = |task: TaskRef| machine.tasks.find(task).map(|task| machine.own_path(task));
    situation.valves = machine
        .valves
        .iter()
        .map(|valve| {
            let places = valve.places().map(|place| &machine.places[place as usize]);
            let holders = places.clone().flat_map(|place| place.holders()).filter_map(path).collect();
            let interrupted = places.flat_map(|place| place.interrupted()).filter_map(path).collect();
            let standing = ValveStanding { holders, interrupted };
            (machine.symbols.name(valve.name).to_string(), standing)
        })
        .collect();
    situation
}

/// How a task stands now; `ends_us` as [`rpl_runtime::state::machine::Machine::wait_ends_us`] gives them.
pub fn standing(system: &System<Robot>, ends_us: &BTreeMap<u32, u64>, task: u32) -> Standing {
    let machine = &system.machine;
    let record = &machine.tasks[task];
    let place = machine.form_of(&system.program, task).filter(|&span| is_own(system, span));
    let is_blocked = record.state() == State::Blocked;
    let on = match is_blocked {
        true if task == machine.main && system.is_waiting_for_form() => Some("the next form".to_string()),
        true => Some(machine.describe(&system.program, record.waiting())),
        false => None,
    };
    Standing {
        number: 0,
        path: machine.path(task),
        on,
        is_created: record.state() == State::Created,
        until_us: ends_us.get(&task).copied(),
        is_suspended: record.is_held(),
        suspended_by: Vec::new(),
        at: place.filter(|_| is_blocked).map(|span| system.program.sources.place(span)),
        readings: machine.readings(&system.program, record.waiting()),
        told: u64::MAX,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rpl_drive::stopping::halt::Until;
    use rpl_mission::site::Site;
    use rpl_runtime::run::session::Answer;
    use rpl_runtime::step::tasks::condition::FluentReading;
    use rpl_shell::terminal::console::Console;

    const PLANS: &[&str] = &[
        // Calls in calls, tags, spawned tasks, one name twice.
        "(def-plan inner () (wait-time 2)) (def-plan outer () (inner) (par (:tag x (inner)) (inner)))
         (spawn (outer)) (outer)",
        // Valves: in line, borrowed, pre-empted with hooks, and given back.
        "(def-valve arm) (def-fluent bell nil)
         (def-plan serve () (with-valve arm (on-interrupt (wait-time 0.5) (wait-time 5))))
         (with-policy (whenever bell (with-valve arm (wait-time 1)))
           (par (serve) (seq (wait-time 1) (setf (value bell) t) (wait-time 0.2) (pulse bell)) (with-valve arm (wait-time 1))))",
        // Conditions that come to read more.
        "(def-fluent a nil) (def-fluent b nil) (def-fluent both (fluent (and a b)))
         (spawn (wait-for (and both (changed a)))) (spawn (whenever (pulsed b) (wait-time 1)))
         (wait-time 1) (setf (value a) t) (wait-time 1) (setf (value b) t) (wait-time 1) (pulse b) (wait-time 2)",
        // Failures, clean-ups that wait, departures.
        "(def-fluent never nil)
         (ignore-failures (timeout) (with-timeout 1 (unwind-protect (wait-for never) (wait-time 2))))
         (pursue (seq (wait-time 1) 'won) (evap-protect (wait-for never) (wait-time 3)))",
        // Waits that a timer ends, while the condition comes to read more.
        "(def-fluent a nil) (def-fluent b nil) (def-fluent both (fluent (and a b)))
         (spawn (wait-for both :timeout 5)) (wait-time 1) (setf (value a) t) (wait-time 1)",
        // Suspension by a plan.
        "(def-plan work () (loop (wait-time 0.3)))
         (let ((task (spawn (work)))) (wait-time 1) (suspend task) (wait-time 1) (resume task) (wait-time 1))",
        "(def-plan work () (loop (wait-time 0.3)))
         (let ((task (spawn (work)))) (wait-time 1) (with-task-suspended (task) (wait-time 1)) (wait-time 1))",
    ];

    /// What can be compared: not the values of fluents, which events tell as they were.
    fn shape(mut situation: Situation) -> (Vec<(String, Standing)>, BTreeMap<String, ValveStanding>) {
        fn forget_values(readings: &mut [FluentReading]) {
            for reading in readings {
                reading.value.clear();
                forget_values(&mut reading.from);
            }
        }
        // A session begins before its events are kept.
        situation.tasks.remove("main");
        situation.valves.retain(|_, valve| !valve.holders.is_empty());
        let mut tasks: Vec<(String, Standing)> = situation.tasks.into_iter().collect();
        tasks.sort_by_key(|(_, task)| task.number);
        for (_, task) in &mut tasks {
            (task.number, task.told) = (0, 0);
            task.suspended_by.retain(|by| by != "main");
            forget_values(&mut task.readings);
        }
        tasks.sort_by(|(left, _), (right, _)| left.cmp(right));
        (tasks, situation.valves)
    }

    #[test]
    fn events_tell_what_the_run_tells_at_every_instant() {
        for plan in PLANS {
            let site = Site::without_robot().expect("a site");
            let mut session = Session::new(&site, site.robot(1), 1).expect("a session");
            let forms = session.typed(plan);
            session.submit(forms).unwrap_or_else(|rejected| panic!("{}", rejected.render(false)));
            let mut instants = 0;
            while session.branch.is_running {
                let next_us = session.branch.system.next_instant_us().unwrap_or(0);
                session.go_on(&Until::Time(next_us), &mut Console::silent()).expect("nobody reads");
                let told = shape(Situation::after(&session.branch.log));
                let lives = shape(situation(&session));
                let time_s = session.branch.system.machine.now_s();
                assert_eq!(told, lives, "at {time_s} s of {plan}");
                instants += 1;
            }
            assert!(instants > 1, "{plan}");
            assert!(matches!(session.branch.system.answer(), Some(Answer::Succeeded(_))), "{plan}");
        }
    }
}
