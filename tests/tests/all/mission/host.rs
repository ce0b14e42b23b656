//! Hosts: the robot knows what its host tells it, and nothing else.

use rpl_lang::compile::NoFiles;
use rpl_robot::office::{Host, HostLost, OfficeRobot, Report, SimulatedHost};
use rpl_robot::simulator::{Commands, Percept};
use rpl_runtime::run::session::Answer;
use rpl_runtime::run::system::{Outcome, System};
use rpl_runtime::state::trace::Event;
use rpl_tests::mission::{Mission, robot_library, test_room};

const SEED: u64 = 5;

/// Listens to what a simulated robot perceives and is told to do.
struct Listener {
    host: SimulatedHost,
    heard: Vec<(Commands, Percept)>,
}

impl Host for Listener {
    fn step(&mut self, commands: &Commands, reports: &mut Vec<Report>) -> Result<Percept, HostLost> {
        let percept = self.host.step(commands, reports)?;
        self.heard.push((commands.clone(), percept.clone()));
        Ok(percept)
    }
}

/// Says what is in its script, and keeps what it is told to do; there is no world behind it. When it has
/// said all it is gone.
struct Script {
    percepts: std::vec::IntoIter<Percept>,
    told: Vec<Commands>,
}

impl Host for Script {
    fn step(&mut self, commands: &Commands, _: &mut Vec<Report>) -> Result<Percept, HostLost> {
        self.told.push(commands.clone());
        self.percepts.next().ok_or_else(|| HostLost("the host `script` has no more to say".to_string()))
    }
}

/// Runs a plan to its end on a host; gives its trace and the run.
fn run<H: Host + 'static>(plan: &str, host: H) -> (Vec<Event>, System<OfficeRobot<H>>) {
    let mission = Mission::new(test_room(), plan);
    let robot = OfficeRobot::new(test_room(), host, SEED);
    let mut system = System::traced(robot_library(), mission.plan, robot, SEED);
    system.run_until(120_000_000);
    (system.machine.trace.take(), system)
}

fn listener() -> Listener {
    let simulator = test_room().simulator.clone();
    Listener { host: SimulatedHost::new(simulator, SEED, None), heard: Vec::new() }
}

#[test]
fn what_was_perceived_once_makes_the_same_run_again() {
    let plan = "(deliver 'cup 'table-side 'corner)";
    let (trace, system) = run(plan, listener());
    assert!(matches!(system.outcome(), Some(Outcome::Succeeded(_))));
    let (commands, percepts): (Vec<_>, Vec<_>) = system.outside.host.heard.into_iter().unzip();
    assert!(percepts.len() > 500 && commands.iter().any(|command| command.translation_mps > 0.3));

    let (again, system) = run(plan, Script { percepts: percepts.into_iter(), told: Vec::new() });
    assert_eq!(system.outside.host.told, commands);
    assert_eq!(again, trace);
}

#[test]
fn plans_see_what_the_script_says() {
    let (_, system) = run("(wait-time 0.1)", listener());
    let (_, quiet) = system.outside.host.heard.into_iter().next().expect("a step");
    let mut percepts = vec![quiet.clone(); 20];
    percepts[10] = Percept { messages: vec![vec!["come".to_string(), "here".to_string()]], ..quiet.clone() };
    percepts[11] = Percept { bumped: true, battery: 0.25, ..quiet };
    let plan = "(wait-for (> messages* 0)) (wait-for bumped?*) (list (read-message) (value battery*))";
    let (_, system) = run(plan, Script { percepts: percepts.into_iter(), told: Vec::new() });
    let Some(Outcome::Succeeded(value)) = system.outcome() else { panic!("{:?}", system.outcome()) };
    assert_eq!(system.machine.write(&system.program, value), "((come here) 0.25)");
    assert!(system.outside.host.told.iter().all(|commands| commands.translation_mps == 0.0));
}

/// A host that says for a number of steps that nothing happens, and is gone then.
fn gone_after(steps: usize) -> Script {
    let (_, system) = run("(wait-time 0.1)", listener());
    let (_, quiet) = system.outside.host.heard.into_iter().next().expect("a step");
    Script { percepts: vec![quiet; steps].into_iter(), told: Vec::new() }
}

/// How a run ended, and what it printed.
fn ended(system: &System<OfficeRobot<Script>>) -> (String, Vec<&str>) {
    let printed = system.machine.output.iter().map(|line| line.text.as_str()).collect();
    let Some(Outcome::Failed(failure)) = system.outcome() else { panic!("{:?}", system.outcome()) };
    (system.machine.show(&system.program, failure), printed)
}

/// r[fail.host]
#[test]
fn a_host_that_is_gone_ends_the_run_whatever_its_handlers() {
    let plan = "(loop (with-failure-handling ((failure (f) (print 'handled) nil))
                  (unwind-protect (go-to 'corner) (print 'cleaned) (wait-time 3) (print 'up))))";
    let (trace, system) = run(plan, gone_after(40));
    let (failure, printed) = ended(&system);
    assert!(failure.contains("host-failure") && failure.contains("the host `script`"), "{failure}");
    assert_eq!(printed, ["cleaned", "up"]);
    assert_eq!(system.outside.host.told.len(), 41, "nobody is told anything any more");
    assert_eq!(system.machine.now_s(), 40.0 * 0.05 + 3.0, "the clean-ups have their time");
    let is_loss = |event: &&Event| event.to_string().contains("host lost");
    assert_eq!(trace.iter().filter(is_loss).count(), 1);
}

#[test]
fn behaviours_of_a_lost_robot_stop_and_none_starts() {
    let plan = "(unwind-protect (go-to 'corner)
                  (with-failure-handling ((host-failure (f) (print (failure-class f)))) (go-to 'table-side)))";
    let (_, system) = run(plan, gone_after(40));
    let (_, printed) = ended(&system);
    assert_eq!(printed.last(), Some(&"host-failure"), "{printed:?}");
}

#[test]
fn a_host_that_never_speaks_fails_the_run_before_its_first_form() {
    let (_, system) = run("(print 'begun)", gone_after(0));
    let (failure, printed) = ended(&system);
    assert!(failure.contains("host-failure") && printed.is_empty(), "{failure} {printed:?}");
}

#[test]
fn clean_ups_of_a_lost_robot_wait_for_nothing_that_cannot_come() {
    let (_, system) = run("(unwind-protect (wait-time 100) (wait-for bumped?*))", gone_after(40));
    let (failure, _) = ended(&system);
    assert!(failure.contains("host-failure"), "{failure}");
}

#[test]
fn a_session_outlives_its_host() {
    let robot = OfficeRobot::new(test_room(), gone_after(40), SEED);
    let mut system = System::session(&robot_library(), robot, SEED).expect("its own text is right");
    let mut submit = |text: &str| {
        system.submit("typed", text, &mut NoFiles).expect("the form is right");
        system.settle();
        while system.answer().is_none() {
            system.next_instant();
            system.settle();
        }
        match system.answer() {
            Some(Answer::Failed(value)) => system.machine.show(&system.program, value),
            Some(Answer::Succeeded(value)) => system.machine.write(&system.program, value),
            other => panic!("{other:?}"),
        }
    };
    assert!(submit("(go-to 'corner)").contains("host-failure"));
    assert!(submit("(go-to 'corner)").contains("host-failure"));
    assert_eq!(submit("(+ 1 2)"), "3");
}
