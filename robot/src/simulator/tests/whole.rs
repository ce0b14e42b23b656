use super::*;
use proptest::prelude::*;

fn busy_model() -> SimulatorModel {
    let text = World::builtin_text("dept").expect("built in");
    let text = format!("{text}[[person]]\npath = [[5.0, 9.0], [20.0, 11.0]]\nspeed = 0.9\n");
    let world = World::parse(&text, "dept.toml").expect("no faults");
    let robot = RobotDescription { camera: builtin("b21-camera").camera, ..builtin("b21-laser") };
    SimulatorModel::new(Arc::new(world), SimulatorSettings::of(robot))
}

/// A drive with everything in it.
fn command(step: usize) -> Commands {
    let gripper = match step % 200 {
        10 => GripperCommand::Grasp("letter".to_owned()),
        120 => GripperCommand::Release,
        _ => GripperCommand::None,
    };
    let turn_radps = if step % 80 < 40 { 0.4 } else { -0.4 };
    Commands {
        translation_mps: 0.5,
        rotation_radps: turn_radps,
        sonars_on: !step.is_multiple_of(7),
        gripper,
        camera: (step % 50 > 5).then_some(CameraCommand { pan_radps: 2.0 * turn_radps }),
        ..Commands::default()
    }
}

fn started(model: &SimulatorModel, seed: u64) -> SimulatorState {
    let mut state = model.start(seed);
    state.place_item("letter", Point::new(23.5, 10.0));
    state
}

fn run(model: &SimulatorModel, state: &mut SimulatorState, steps: std::ops::Range<usize>) -> Vec<Percept> {
    steps.map(|step| model.step(state, &command(step))).collect()
}

#[test]
fn the_same_seed_gives_the_same_percepts() {
    let (one, other) = (busy_model(), busy_model());
    let (mut a, mut b) = (started(&one, 7), started(&other, 7));
    assert_eq!(run(&one, &mut a, 0..300), run(&other, &mut b, 0..300));
    assert_eq!(a, b);
    let mut c = started(&one, 8);
    assert_ne!(run(&one, &mut c, 0..300).last(), run(&other, &mut b, 300..301).last());
}

#[test]
fn a_fork_goes_on_like_its_origin() {
    let model = busy_model();
    let mut state = started(&model, 7);
    run(&model, &mut state, 0..100);
    let mut fork = state.clone();
    assert_eq!(run(&model, &mut fork, 100..300), run(&model, &mut state, 100..300));
    assert_eq!(fork, state);
}

#[test]
fn a_state_written_and_read_back_at_every_step_changes_nothing() {
    let model = busy_model();
    let (mut kept, mut saved) = (started(&model, 7), started(&model, 7));
    let chair = crate_at("crate", 20.0, 9.0, true, false);
    model.add_object(&mut kept, chair.clone()).expect("nobody is there");
    model.add_object(&mut saved, chair).expect("nobody is there");
    for step in 0..300 {
        let bytes = postcard::to_allocvec(&saved).expect("a state can be written");
        let read: SimulatorState = postcard::from_bytes(&bytes).expect("and read");
        assert_eq!(read, saved, "step {step}");
        saved = read;
        assert_eq!(model.step(&mut saved, &command(step)), model.step(&mut kept, &command(step)), "step {step}");
    }
    assert_eq!(saved, kept);
}

#[test]
fn time_passes_in_steps() {
    let model = busy_model();
    let mut state = model.start(1);
    assert_eq!(steps(&model, &mut state, &Commands::default(), 20).time_us, 1_000_000);
}

#[test]
fn streams_of_one_consumer_do_not_depend_on_another() {
    let model = busy_model();
    let (mut listening, mut deaf) = (model.start(3), model.start(3));
    for step in 0..100 {
        let commands = command(step);
        let a = model.step(&mut listening, &commands);
        let b = model.step(&mut deaf, &Commands { sonars_on: false, ..commands });
        assert_eq!(a.odometry_in_odom, b.odometry_in_odom);
        assert_eq!(a.laser_m, b.laser_m);
    }
}

#[test]
fn a_state_fits_its_own_world_only() {
    let (dept, room) = (busy_model(), model("test-room", SimulatorSettings::default()));
    assert!(dept.fits(&dept.start(1)) && room.fits(&room.start(1)));
    assert!(!dept.fits(&room.start(1)) && !room.fits(&dept.start(1)));
}
proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn a_world_file_with_typing_errors_is_refused_or_can_be_lived_in(
        at in 0.0..1.0, length in 0_usize..12, typed in "[-0-9.a-z\\[\\]=\", \n]{0,6}",
    ) {
        let text = World::builtin_text("test-room").expect("built in");
        let start = (at * text.len() as f64) as usize;
        let end = (start + length).min(text.len());
        let text = format!("{}{typed}{}", &text[..start], &text[end..]);
        if let Ok(world) = World::parse(&text, "typo.toml") {
            let small = world.size_m.x <= 100.0 && world.size_m.y <= 100.0;
            prop_assume!(small);
            world.map_centred(0.5);
            let model = SimulatorModel::new(Arc::new(world), SimulatorSettings::default());
            let mut state = model.start(1);
            steps(&model, &mut state, &drive(0.9, 0.3), 40);
            prop_assert!(state.true_pose().x_m.is_finite());
        }
    }
}
