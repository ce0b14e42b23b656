use super::*;

fn grasp(name: &str) -> Commands {
    Commands { gripper: GripperCommand::Grasp(name.to_owned()), ..Commands::default() }
}

fn release() -> Commands {
    Commands { gripper: GripperCommand::Release, ..Commands::default() }
}

#[test]
fn a_grasp_takes_its_time_and_the_thing() {
    let model = hall(exact("b21"), "");
    let mut state = model.start(1);
    state.place_item("letter", Point::new(5.5, 3.0));
    let closing = model.step(&mut state, &grasp("letter")).gripper;
    assert_eq!(closing, GripperStatus { motion: GripperMotion::Moving, holding: None });
    let mut taken = 1;
    while model.step(&mut state, &Commands::default()).gripper.motion == GripperMotion::Moving {
        taken += 1;
    }
    assert_eq!(taken * model.robot().step_us, model.robot().gripper.expect("it has one").grasp_us);
    assert_eq!(state.gripper.holding(), Some("letter"));

    let opened = steps(&model, &mut state, &release(), 41).gripper;
    assert_eq!(opened, GripperStatus { motion: GripperMotion::Open, holding: None });
    let ItemPlace::Point(at) = state.gripper.items[0].at else { panic!("the letter is put down") };
    assert!((at.x - 5.415).abs() < 1e-9 && (at.y - 3.0).abs() < 1e-9);
}

#[test]
fn things_out_of_reach_or_of_another_name_stay() {
    let model = hall(exact("b21"), "");
    let mut state = model.start(1);
    state.place_item("letter", Point::new(5.81, 3.0));
    state.place_item("book", Point::new(5.5, 3.0));
    let closed = GripperStatus { motion: GripperMotion::Closed, holding: None };
    assert_eq!(steps(&model, &mut state, &grasp("letter"), 61).gripper, closed);
}

#[test]
fn a_share_of_grasps_fails() {
    let mut robot = builtin("b21").without_errors();
    robot.gripper.as_mut().expect("it has one").grasp_failure_probability = 0.25;
    let model = hall(SimulatorSettings::of(robot), "");
    let failures = (0..400).filter(|seed| {
        let mut state = model.start(*seed);
        state.place_item("letter", Point::new(5.5, 3.0));
        steps(&model, &mut state, &grasp("letter"), 61).gripper.holding.is_none()
    });
    let failures = failures.count();
    assert!((100 - 35..=100 + 35).contains(&failures), "{failures} of 400");
}

#[test]
fn a_turn_by_hand_is_not_in_the_odometry() {
    let model = hall(SimulatorSettings::default(), "");
    let mut state = model.start(1);
    let before = state.odometry_in_odom;
    state.rotate(1.2);
    assert_eq!(state.odometry_in_odom, before);
    assert!((state.true_pose().heading_rad - 1.2).abs() < 1e-12);
    model.teleport(&mut state, Pose::new(2.0, 2.0, 0.0)).expect("free");
    assert_eq!(state.odometry_in_odom, before);
}

#[test]
fn the_robot_is_not_put_into_things() {
    let model = model("dept", SimulatorSettings::default());
    let mut state = model.start(1);
    let before = state.clone();
    let into = |state: &mut SimulatorState, x: f64, y: f64| {
        model.teleport(state, Pose::new(x, y, 0.0)).expect_err("something is there").to_string()
    };
    assert!(into(&mut state, 13.5, 12.3).contains("the door of `N3`"));
    assert!(into(&mut state, 11.2, 15.0).contains("a wall"));
    assert!(into(&mut state, 19.6, 15.2).contains("`b-table`"));
    assert!(into(&mut state, -3.0, 15.2).contains("the edge of the world"));
    assert!(into(&mut state, f64::NAN, 15.2).contains("the edge of the world"));
    assert_eq!(state, before);
}

#[test]
fn nothing_is_put_into_the_robot() {
    let model = model("dept", SimulatorSettings::default());
    let mut state = model.start(1);
    model.teleport(&mut state, Pose::new(18.1, 12.3, 0.0)).expect("the door of B is open");
    let before = state.clone();
    assert!(matches!(model.close_door(&mut state, "B"), Err(OracleError::InTheWay { .. })));
    assert!(matches!(
        model.add_object(&mut state, crate_at("crate", 18.1, 12.7, true, true)),
        Err(OracleError::InTheWay { .. })
    ));
    assert_eq!(state, before);
    assert!(model.close_door(&mut state, "Z").expect_err("no room Z").to_string().contains("door `Z`"));
}

#[test]
fn objects_come_and_go() {
    let model = hall(exact("b21"), "[[object]]\nname = \"bin\"\ncircle = [7.0, 3.0, 0.2]");
    let mut state = model.start(1);
    let ahead = |state: &mut SimulatorState| ring(&model, state)[0];
    assert_eq!(ahead(&mut state), 1.8);
    model.remove_object(&mut state, "bin").expect("it is there");
    assert_eq!(ahead(&mut state), 5.0);
    assert_eq!(model.remove_object(&mut state, "bin"), Err(OracleError::NoObject("bin".to_owned())));
    model.add_object(&mut state, crate_at("bin", 8.2, 3.0, true, true)).expect("its name is free again");
    assert_eq!(ahead(&mut state), 3.0);
    let again = model.add_object(&mut state, crate_at("bin", 2.0, 3.0, true, true));
    assert_eq!(again, Err(OracleError::SameName("bin".to_owned())));
}
