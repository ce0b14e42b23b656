use super::*;
use crate::geometry::distance_m;

/// A person who walks past the robot's east and west.
const WALKER: &str = "[[person]]\npath = [[1.0, 3.0], [9.0, 3.0]]\nspeed = 0.8\n";

fn stand(model: &SimulatorModel, state: &mut SimulatorState, count: usize) {
    steps(model, state, &drive(0.0, 0.0), count);
}

/// Smallest and largest x of a person over some steps.
fn reach(model: &SimulatorModel, state: &mut SimulatorState, count: usize) -> (f64, f64) {
    let seen = (0..count).map(|_| {
        stand(model, state, 1);
        state.people[0].at_in_map.x
    });
    seen.fold((f64::INFINITY, 0.0_f64), |(least, most), x| (least.min(x), most.max(x)))
}

#[test]
fn people_walk_around_the_robot() {
    let model = hall(SimulatorSettings::default(), WALKER);
    let mut state = model.start(1);
    let (mut nearest_m, mut farthest_x_m) = (f64::INFINITY, 0.0_f64);
    for _ in 0..300 {
        stand(&model, &mut state, 1);
        farthest_x_m = farthest_x_m.max(state.people[0].at_in_map.x);
        nearest_m = nearest_m.min(distance_m(state.people[0].at_in_map, state.true_pose().point()));
    }
    assert!(farthest_x_m > 8.8, "{farthest_x_m}");
    let touch_m = model.robot().radius_m + PERSON_RADIUS_M;
    assert!(nearest_m > touch_m + model.settings.person_clearance_m - 0.05, "{nearest_m}");
    assert_eq!(state.contacts(), Contacts::default());
}

/// A gap that the robot fills, between the walls of a passage 1 m wide.
const PASSAGE: &str =
    "[[wall]]\nline = [[0.0, 2.425], [10.0, 2.425]]\n[[wall]]\nline = [[0.0, 3.575], [10.0, 3.575]]\n";

#[test]
fn a_person_who_cannot_pass_turns_back() {
    let model = hall(SimulatorSettings::default(), &format!("{PASSAGE}{WALKER}"));
    let mut state = model.start(1);
    let (_, most) = reach(&model, &mut state, 200);
    let touch_m = model.robot().radius_m + PERSON_RADIUS_M;
    assert!(most < 5.0 - touch_m - 0.04 && most > 5.0 - touch_m - 0.5, "{most}");
    let (least, _) = reach(&model, &mut state, 200);
    assert!(least < 1.3, "{least}");
    assert_eq!(state.contacts(), Contacts::default());
}

#[test]
fn a_person_steps_back_from_a_robot_that_comes_near() {
    let standing = "[[person]]\npath = [[7.0, 3.0], [7.0, 3.01]]\nspeed = 0.8\n";
    let model = hall(SimulatorSettings::default(), standing);
    let mut state = model.start(1);
    steps(&model, &mut state, &drive(0.4, 0.0), 120);
    assert!(state.true_pose().x_m > 7.0);
    assert_eq!(state.contacts(), Contacts::default());
}

#[test]
fn people_who_do_not_mind_the_robot_run_into_it_once() {
    let model = hall(SimulatorSettings { person_clearance_m: 0.0, ..SimulatorSettings::default() }, WALKER);
    let mut state = model.start(1);
    assert!(steps(&model, &mut state, &drive(0.0, 0.0), 130).bumped);
    assert_eq!(state.contacts(), Contacts { run_into: 1, ..Contacts::default() });
}

#[test]
fn a_robot_that_drives_into_somebody_who_cannot_give_way_caused_it() {
    // A person in a dead end.
    let end = "[[wall]]\nline = [[8.0, 2.0], [8.0, 4.0]]\n[[person]]\npath = [[7.6, 3.0], [7.6, 3.01]]\nspeed = 0.8\n";
    let model = hall(SimulatorSettings::default(), &format!("{PASSAGE}{end}"));
    let mut state = model.start(1);
    steps(&model, &mut state, &drive(0.5, 0.0), 150);
    assert_eq!(state.contacts(), Contacts { caused: 1, ..Contacts::default() });
}

/// Somebody steps 8 cm before a robot that drives at 0.5 m/s, and cannot give way.
#[test]
fn a_person_who_steps_before_a_robot_that_cannot_stop_was_not_touched_by_its_fault() {
    let end =
        "[[wall]]\nline = [[8.0, 2.0], [8.0, 4.0]]\n[[person]]\npath = [[7.74, 3.0], [7.74, 3.01]]\nspeed = 0.8\n";
    let model = hall(SimulatorSettings::default(), &format!("{PASSAGE}{end}"));
    let touch_m = model.robot().radius_m + PERSON_RADIUS_M;
    let contacts_when_told = |translation_mps: f64, came_from_m: f64| {
        let mut state = model.start(1);
        steps(&model, &mut state, &drive(0.5, 0.0), 20);
        let person = state.people[0].at_in_map;
        state.robot_in_map = Pose::new(person.x - touch_m - 0.08, 3.0, 0.0);
        model.notice_step(&mut state, 0, Point::new(person.x, person.y + came_from_m));
        steps(&model, &mut state, &drive(translation_mps, 0.0), 40);
        state.contacts()
    };
    let (caused, run_into) =
        (Contacts { caused: 1, ..Contacts::default() }, Contacts { run_into: 1, ..Contacts::default() });
    assert_eq!(contacts_when_told(0.0, 0.8), run_into, "it braked, and he came too near");
    assert_eq!(contacts_when_told(0.5, 0.8), caused, "it had to brake all the same");
    assert_eq!(contacts_when_told(0.0, 0.01), caused, "he was so near before: it came too fast itself");
}

#[test]
fn a_crowd_keeps_moving_and_off_each_other_the_walls_and_the_robot() {
    let model = model("dept-crowded", SimulatorSettings::default());
    let mut state = model.start(3);
    assert_eq!(state.people.len(), 20);
    let begun: Vec<Point> = state.people.iter().map(|person| person.at_in_map).collect();
    let mut farthest_m = vec![0.0_f64; 20];
    let (mut overlap_m, mut walked_m) = (0.0_f64, 0.0);
    const STEPS: usize = 6000;
    for _ in 0..STEPS {
        let before: Vec<Point> = state.people.iter().map(|person| person.at_in_map).collect();
        stand(&model, &mut state, 1);
        for (index, person) in state.people.iter().enumerate() {
            walked_m += distance_m(before[index], person.at_in_map);
            farthest_m[index] = farthest_m[index].max(distance_m(begun[index], person.at_in_map));
            for other in &state.people[..index] {
                overlap_m = overlap_m.max(2.0 * PERSON_RADIUS_M - distance_m(person.at_in_map, other.at_in_map));
            }
            let wall = model.solids.iter().find(|solid| {
                state.is_there(solid.origin) && solid.outline.distance_m(person.at_in_map) < PERSON_RADIUS_M - 1e-6
            });
            assert!(wall.is_none(), "{person:?} stands in {wall:?}");
        }
    }
    assert!(overlap_m < 0.05, "{overlap_m}");
    assert_eq!(state.contacts(), Contacts::default());
    let mean_mps = walked_m / (20.0 * STEPS as f64 * model.robot().step_s());
    assert!(mean_mps > 0.35, "{mean_mps}");
    assert!(farthest_m.iter().all(|way_m| *way_m > 3.0), "{farthest_m:?}");
}

#[test]
fn the_crowd_depends_on_the_seed_alone() {
    let model = model("corridor-crowded", SimulatorSettings::default());
    let places = |seed: u64| {
        let mut state = model.start(seed);
        stand(&model, &mut state, 400);
        state.people
    };
    assert_eq!(places(1), places(1));
    assert_ne!(places(1), places(2));
}

#[test]
fn a_shut_door_is_nobodys_goal_for_long() {
    let model = model("dept-crowded", SimulatorSettings::default());
    let mut state = model.start(5);
    for room in ["A", "B", "C", "D"] {
        let shut = (0..2000).any(|_| {
            stand(&model, &mut state, 1);
            model.close_door(&mut state, room).is_ok()
        });
        assert!(shut, "the door of {room} is never free");
    }
    let in_rooms = |state: &SimulatorState| {
        state.people.iter().map(|person| model.world.room_at(person.at_in_map).is_some()).collect::<Vec<_>>()
    };
    let before = in_rooms(&state);
    stand(&model, &mut state, 4000);
    assert_eq!(in_rooms(&state), before, "nobody walks through a closed door");
    let outside = before.iter().filter(|inside| !**inside).count();
    assert!(outside > 0);
    for room in ["A", "B", "C", "D"] {
        model.open_door(&mut state, room).expect("it has a door");
    }
    stand(&model, &mut state, 4000);
    assert_ne!(in_rooms(&state), before, "with open doors they walk in and out");
}

/// Distances of all people from the robot.
fn away_m(state: &SimulatorState) -> Vec<f64> {
    let robot = state.true_pose().point();
    state.people.iter().map(|person| distance_m(person.at_in_map, robot)).collect()
}

#[test]
fn people_who_gather_stand_around_the_robot_and_walk_along_with_it() {
    let model = hall(SimulatorSettings::default(), "people = 8\n");
    let mut state = model.start(1);
    assert!(model.blocked_share(&state) < 0.9);
    assert_eq!(model.gather(&mut state), 8);
    let nobody_touches = |state: &SimulatorState| {
        for (index, person) in state.people.iter().enumerate() {
            let nearest_m = state.people[..index].iter().map(|other| distance_m(person.at_in_map, other.at_in_map));
            assert!(nearest_m.fold(f64::INFINITY, f64::min) > 2.0 * PERSON_RADIUS_M - 0.05, "{:?}", state.people);
        }
    };
    nobody_touches(&state);
    assert!(away_m(&state).into_iter().all(|away_m| away_m < 3.0), "{:?}", away_m(&state));
    let blocked = model.blocked_share(&state);
    assert!((0.3..0.8).contains(&blocked), "{blocked}");
    for _ in 0..6 {
        // Two metres ahead, and on the spot half round: the hall is ten metres long.
        steps(&model, &mut state, &drive(0.4, 0.0), 100);
        nobody_touches(&state);
        let left_behind = away_m(&state).into_iter().filter(|away_m| *away_m > 3.0).count();
        assert!(left_behind <= 1, "{:?}", away_m(&state));
        steps(&model, &mut state, &drive(0.0, 0.5), 126);
    }
    assert!(state.distance_driven_m() > 8.0, "they let it drive: {}", state.distance_driven_m());
    assert_eq!(state.contacts(), Contacts::default());
    state.people.clear();
    assert!(model.blocked_share(&state) == 0.0);
}

#[test]
fn people_who_gather_come_to_a_robot_that_was_carried_away() {
    let model = model("dept-crowded", SimulatorSettings::default());
    let mut state = model.start(3);
    model.gather(&mut state);
    model.teleport(&mut state, Pose::new(8.9, 3.6, 0.0)).expect("nobody is there");
    let far = away_m(&state).into_iter().filter(|away_m| *away_m > 5.0).count();
    assert!(far >= 15, "{:?}", away_m(&state));
    stand(&model, &mut state, 1200);
    let near = away_m(&state).into_iter().filter(|away_m| *away_m < 4.0).count();
    assert!(near >= 12, "through the door of the room: {:?}", away_m(&state));
}
