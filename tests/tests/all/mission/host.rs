//! Hosts: the robot knows what its host tells it, and nothing else.

use rpl_robot::office::{Host, OfficeRobot, Report, SimulatedHost};
use rpl_robot::simulator::{Commands, Percept};
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
    fn step(&mut self, commands: &Commands, reports: &mut Vec<Report>) -> Percept {
        let percept = self.host.step(commands, reports);
        self.heard.push((commands.clone(), percept.clone()));
        percept
    }
}

/// Says what is in its script, and keeps what it is told to do; there is no world behind it.
struct Script {
    percepts: std::vec::IntoIter<Percept>,
    told: Vec<Commands>,
}

impl Host for Script {
    fn step(&mut self, commands: &Commands, _: &mut Vec<Report>) -> Percept {
        self.told.push(commands.clone());
        self.percepts.next().expect("the script is long enough")
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
