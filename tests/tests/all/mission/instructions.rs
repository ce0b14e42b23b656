//! Rooms found by instructions in offices that the robot has never seen.

use rpl_lola::arena::{Arena, ArenaSettings};
use rpl_lola::feature::Side;
use rpl_lola::instruction::Instruction;
use rpl_mission::modules::SiteRobot;
use rpl_robot::geometry::Pose;
use rpl_robot::office::{OfficeModel, OfficeSettings};
use rpl_robot::world::World;
use rpl_runtime::run::system::{Progress, System};
use rpl_tests::deliveries::{PassedDoor, counted_along_m, delivery, door_beside, with_person_before};
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
    assert_delivered(&arena().0, run, what);
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

/// Goes on until the robot counts beside a door, looking every so often.
fn beside_door(
    arena: &Arena,
    system: &mut System<SiteRobot>,
    mut is_meant: impl FnMut(&PassedDoor) -> bool,
) -> PassedDoor {
    let mut found = None;
    let is_there = run_until(system, UNTIL_S, |system| {
        let here = system.outside.true_pose_in_map();
        found = counted_along_m(system).and_then(|_| door_beside(arena, here)).filter(&mut is_meant);
        found.is_some()
    });
    found.filter(|_| is_there).expect("the robot passes such a door")
}

fn assert_delivered(arena: &Arena, run: &Run, what: &str) {
    let robot = &run.system.outside;
    assert!(run.outcome().starts_with("=>"), "{what}: {}\n{}", run.outcome(), run.output.join("\n"));
    assert!(arena.is_goal(robot.true_pose_in_map()), "{what}: {}", run.output.join("\n"));
    assert_eq!(robot.contacts().caused, 0, "{what}");
}

fn finished(mut system: System<SiteRobot>) -> Run {
    system.run_until((UNTIL_S * 1e6) as u64);
    Run::of(system)
}

/// The odometry does not notice; the walls at the sides are not where they were.
#[test]
fn a_robot_turned_by_hand_in_a_hallway_registers_again_and_counts_nothing_twice() {
    for (seed, by_deg) in [(4000, 70.0), (4004, -70.0), (4007, 70.0)] {
        let arena = Arena::draw(seed, &ArenaSettings::CALM);
        let mut system = delivery(&arena, arena.world.clone()).start(seed);
        assert!(run_until(&mut system, UNTIL_S, |system| fluent_text(system, "percept-count*") != "0"));
        system.outside.host.state.rotate(f64::to_radians(by_deg));
        let is_lost = |system: &mut System<SiteRobot>| fluent_text(system, "hallway-registered?*") == "nil";
        let turned_at_s = system.machine.now_s();
        assert!(run_until(&mut system, turned_at_s + 5.0, is_lost), "arena {seed}: it does not notice");
        assert_delivered(&arena, &finished(system), &format!("arena {seed}, turned by {by_deg}°"));
    }
}

/// Somebody stands before an open door while the robot comes past. A closed one is hidden by who stands before it.
#[test]
fn who_stands_before_an_open_door_does_not_hide_it() {
    for seed in [4000, 4001, 4002] {
        let arena = Arena::draw(seed, &ArenaSettings::CALM);
        let door = beside_door(&arena, &mut delivery(&arena, arena.world.clone()).start(seed), |door| door.is_open);
        let system = delivery(&arena, with_person_before(&arena, &door)).start(seed);
        assert_delivered(&arena, &finished(system), &format!("arena {seed}, a person before {}", door.room));
    }
}

/// One half of the contour has it open.
#[test]
fn a_door_that_is_closed_while_the_robot_passes_is_one_opening() {
    for seed in [4000, 4001, 4002] {
        let arena = Arena::draw(seed, &ArenaSettings::CALM);
        let mut system = delivery(&arena, arena.world.clone()).start(seed);
        let door = beside_door(&arena, &mut system, |door| door.is_open);
        let host = &mut system.outside.host;
        host.model.close_door(&mut host.state, &door.room).expect("nobody stands in it");
        assert_delivered(&arena, &finished(system), &format!("arena {seed}, {} closed", door.room));
    }
}

/// A hallway that turns left at its end, and nothing else.
const CORNER: &str = "name = \"corner\"\nsize = [13.0, 14.0]\nstart = [1.8, 5.1, 0]\n\
    [[wall]]\nline = [[8.725, 13.8], [8.725, 6.275], [0.925, 6.275], [0.925, 3.925], [11.075, 3.925], [11.075, 13.8]]\n";

fn in_corner(plan: &str) -> Run {
    let world = World::parse(CORNER, "corner.toml").expect("a world");
    let settings = OfficeSettings { map_known: false, ..Grid::Coarse.settings() };
    let plan = format!("(begin-hallway (odometry-pose))\n(go-hallway-end)\n{plan}");
    Mission::new(model(world, settings), &plan).run(1, UNTIL_S)
}

#[test]
fn at_the_end_of_a_hallway_there_is_one_opening_on_a_side() {
    let named = |instruction: &str| {
        in_corner(&format!(
            "(with-failure-handling ((faulty-instruction (f) (failure-slot f 'kind))) (opening-ahead 1 '{instruction}))"
        ))
    };
    assert!(named("(turn 1 left)").outcome().contains("left hallway"), "{}", named("(turn 1 left)").outcome());
    for wrong in ["(turn 2 left)", "(turn 1 right)"] {
        assert_eq!(named(wrong).outcome(), "=> no-such-opening", "{wrong}");
    }
}

#[test]
fn who_looks_again_comes_back_all_the_way() {
    let run = in_corner("(let ((there (hallway-position))) (look-again) (- there (hallway-position)))");
    let left_m: f64 = run.outcome().trim_start_matches("=> ").parse().expect("metres");
    let start_m = 1.8;
    let back_m = run.system.outside.true_pose_in_map().x_m - start_m;
    assert!(back_m < 1.0, "it stands {back_m} m before its start; {left_m} m are left");
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
