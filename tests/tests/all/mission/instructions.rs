//! Rooms found by instructions in offices that the robot has never seen.

use rpl_lola::arena::{Arena, ArenaSettings};
use rpl_lola::feature::Side;
use rpl_lola::instruction::Instruction;
use rpl_mission::modules::SiteRobot;
use rpl_robot::geometry::Pose;
use rpl_robot::office::{OfficeModel, OfficeSettings};
use rpl_runtime::run::system::{Progress, System};
use rpl_tests::mission::{Grid, Mission, Run, fluent_text, lines, model, run_until};
use std::sync::{Arc, OnceLock};

/// An office with a short route.
const SEED: u64 = 5;
const UNTIL_S: f64 = 900.0;

fn arena() -> &'static (Arena, Arc<OfficeModel>) {
    static ARENA: OnceLock<(Arena, Arc<OfficeModel>)> = OnceLock::new();
    ARENA.get_or_init(|| drawn(SEED))
}

fn drawn(seed: u64) -> (Arena, Arc<OfficeModel>) {
    let arena = Arena::draw(seed, &ArenaSettings::CALM);
    let settings = OfficeSettings { map_known: false, ..Grid::Coarse.settings() };
    let model = model(arena.world.clone(), settings);
    (arena, model)
}

fn in_words(instructions: &[Instruction]) -> String {
    instructions.iter().map(Instruction::to_string).collect::<Vec<_>>().join(", ")
}

fn route() -> Mission {
    let (arena, model) = arena();
    Mission::new(model.clone(), &format!("(follow-instructions \"{}\")", in_words(&arena.instructions)))
}

/// The run has ended well, in the goal room, and the robot has touched nothing.
fn assert_arrived(run: &Run, what: &str) {
    let robot = &run.system.outside;
    let here = robot.true_pose_in_map();
    assert!(run.outcome().starts_with("=>"), "{what}: {}\n{}", run.outcome(), run.output.join("\n"));
    assert!(arena().0.is_goal(here), "{what}: {here:?}\n{}", run.output.join("\n"));
    assert_eq!(robot.contacts().caused, 0, "{what}");
}

#[test]
fn a_route_in_words_ends_in_the_goal_room() {
    assert_arrived(&route().run(SEED, UNTIL_S), "calm");
}

#[test]
fn the_same_seed_gives_the_same_trace() {
    let trace = || route().run(SEED, 60.0).trace();
    assert_eq!(trace(), trace());
}

/// Saved and loaded at every step of the first half minute, and at every two hundredth after that.
#[test]
fn reloading_on_the_way_changes_nothing() {
    let mission = route();
    let mut system = mission.start(SEED);
    let (mut events, mut instants) = (Vec::new(), 0);
    while system.machine.now_s() < UNTIL_S && system.advance() == Progress::Running {
        events.append(&mut system.machine.trace.take());
        instants += 1;
        if system.machine.now_s() < 30.0 || instants % 200 == 0 {
            let bytes = system.save();
            system = mission.load(&bytes, SEED);
            assert!(bytes == system.save(), "the copy differs at {} s", system.machine.now_s());
        }
    }
    events.append(&mut system.machine.trace.take());
    assert_eq!(lines(&events), mission.run(SEED, UNTIL_S).trace());
}

/// Another errand takes the wheels at twenty moments of the route, drives away and comes back.
#[test]
fn an_errand_at_any_moment_only_delays_it() {
    let (arena, model) = arena();
    let way = in_words(&arena.instructions);
    let moments_s: Vec<f64> = (0..20).map(|moment| 4.0 + 4.5 * f64::from(moment)).collect();
    let failed: Vec<String> = moments_s
        .iter()
        .filter_map(|moment_s| {
            let plan = format!(
                "(with-policy (seq (wait-time {moment_s})
                                   (with-valve wheels
                                     (let ((here (odometry-pose)))
                                       (ignore-failures (plan-failure)
                                         (seek-goal (pose-from here 0.8 0) :patience 5)
                                         (seek-goal here :patience 20)))))
                   (follow-instructions \"{way}\"))"
            );
            let run = Mission::new(model.clone(), &plan).run(SEED, UNTIL_S);
            let is_there = run.outcome().starts_with("=>") && arena.is_goal(run.system.outside.true_pose_in_map());
            let is_clean = run.system.outside.contacts().caused == 0;
            (!is_there || !is_clean).then(|| format!("{moment_s} s: {}", run.outcome()))
        })
        .collect();
    assert!(failed.is_empty(), "{failed:?}");
}

/// Goes on until the robot counts openings for an instruction and has driven a little.
fn counting(mission: &Mission) -> System<SiteRobot> {
    let mut system = mission.start(SEED);
    let is_counting = |system: &mut System<SiteRobot>| fluent_text(system, "percept-count*") != "0";
    assert!(run_until(&mut system, UNTIL_S, is_counting), "nothing is perceived");
    system
}

fn disturbed(scenario: &str) -> Run {
    let mission = route().with_scenario(scenario);
    let mut system = mission.start(SEED);
    system.run_until((UNTIL_S * 1e6) as u64);
    Run::of(system)
}

/// When the first opening is perceived, and where the robot is then.
fn first_percept() -> (f64, Pose) {
    let system = counting(&route());
    (system.machine.now_s(), system.outside.true_pose_in_map())
}

#[test]
fn a_robot_pushed_back_finds_the_room() {
    let (at_s, Pose { x_m, y_m, heading_rad }) = first_percept();
    let back = Pose::new(x_m, y_m, heading_rad).compose(Pose::new(-0.4, 0.0, 0.0));
    let run =
        disturbed(&format!("(wait-time {at_s}) (teleport-robot! {} {} {})", back.x_m, back.y_m, back.heading_rad));
    assert_arrived(&run, "pushed back");
}

/// Somebody stands before the next opening while the robot comes past, and goes on after a while.
#[test]
fn who_stands_before_an_opening_only_delays_it() {
    let (at_s, here) = first_percept();
    let ahead = here.compose(Pose::new(1.2, 0.9, 0.0));
    let (x0, y0, x1, y1) = (ahead.x_m - 0.2, ahead.y_m - 0.2, ahead.x_m + 0.2, ahead.y_m + 0.2);
    let run = disturbed(&format!(
        "(wait-time {at_s}) (add-object! 'visitor {x0} {y0} {x1} {y1}) (wait-time 20) (remove-object! 'visitor)"
    ));
    assert_arrived(&run, "somebody before the opening");
}

/// What is wrong is told, and the answer is followed, after something that nobody understands too.
#[test]
fn a_wrong_instruction_is_asked_back_and_the_answer_followed() {
    let (arena, model) = arena();
    let Some((last, before)) = arena.instructions.split_last() else { panic!("a route has instructions") };
    let wrong = in_words(&[before, &[Instruction::Enter { ordinal: 9, side: Side::Right }]].concat());
    let plan = format!("(follow-instructions \"{wrong}\" :on-fault ask-back)");
    let answers = format!("(wait-time 200) (send-message! \"the big one\") (wait-time 5) (send-message! \"{last}\")");
    let run = Mission::new(model.clone(), &plan).with_scenario(&answers).run(SEED, UNTIL_S);
    assert_arrived(&run, "asked back");
    let told = run.output.join("\n");
    assert!(told.contains("`enter the ninth door on the right`, cannot be right: there is no ninth right"), "{told}");
    assert!(told.contains("`big` is not understood"), "{told}");
}
