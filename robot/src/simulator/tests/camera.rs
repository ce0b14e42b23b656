use super::*;
use crate::geometry::Vector;
use crate::sensors::{CameraImage, CameraView, Pixel, Rgb};
use crate::world::Marker;

const CAMERA: &str = "b21-camera";

/// A marker of 40 cm, 2 m ahead of the robot and half a metre to its left.
const MARKER: &str = "[[marker]]\nat = [7.0, 3.5]\nsize = 0.4";

fn looking(pan_radps: f64) -> Commands {
    Commands { camera: Some(CameraCommand { pan_radps }), ..Commands::default() }
}

fn image(model: &SimulatorModel, state: &mut SimulatorState) -> CameraImage {
    let images = std::iter::from_fn(|| Some(model.step(state, &looking(0.0)).camera.expect("it is on").image));
    images.take(10).flatten().next().expect("an image each fifth of a second")
}

fn view(model: &SimulatorModel) -> CameraView {
    model.robot().camera.expect("it has one").view
}

/// Pink: more red than blue, more blue than green.
fn is_pink([red, green, blue]: Rgb) -> bool {
    i32::from(red) > i32::from(blue) + 10 && i32::from(blue) > i32::from(green) + 30
}

/// The pixels that show a marker, by asking each pixel where it looks; the robot stands at its start.
fn pixels_on(view: &CameraView, marker: &Marker) -> Vec<(usize, usize)> {
    let pixels = (0..view.rows).flat_map(|row| (0..view.columns).map(move |column| (column, row)));
    let is_on = |&(column, row): &(usize, usize)| {
        let middle = Pixel { column: column as f64 + 0.5, row: row as f64 + 0.5 };
        let floor = view.floor_point(middle).expect("its camera sees no horizon") + Vector::new(5.0, 3.0);
        (floor.x - marker.at.x).abs() <= marker.size_m / 2.0 && (floor.y - marker.at.y).abs() <= marker.size_m / 2.0
    };
    pixels.filter(is_on).collect()
}

fn pink_pixels(image: &CameraImage) -> Vec<(usize, usize)> {
    let pixels = (0..image.rows()).flat_map(|row| (0..image.columns).map(move |column| (column, row)));
    pixels.filter(|&(column, row)| is_pink(image.at(column, row))).collect()
}

#[test]
fn a_marker_is_in_the_pixels_that_look_at_it() {
    let model = hall(exact(CAMERA), MARKER);
    let shown = pixels_on(&view(&model), &model.world.markers[0]);
    assert!(shown.len() > 50, "{}", shown.len());
    for seed in 0..20 {
        assert_eq!(pink_pixels(&image(&model, &mut model.start(seed))), shown, "whatever the light, {seed}");
    }
    // Its middle is 2 m ahead and 0.5 m to the left.
    let middle = view(&model).pixel_of(Point::new(2.0, 0.5)).expect("ahead");
    let mean =
        |part: fn(&(usize, usize)) -> usize| shown.iter().map(part).sum::<usize>() as f64 / shown.len() as f64 + 0.5;
    assert!((mean(|pixel| pixel.0) - middle.column).abs() < 1.0 && (mean(|pixel| pixel.1) - middle.row).abs() < 1.0);
}

#[test]
fn what_stands_before_a_marker_hides_it() {
    let model = hall(exact(CAMERA), MARKER);
    let mut state = model.start(1);
    model.add_object(&mut state, crate_at("box", 6.2, 3.3, true, true)).expect("nobody is there");
    assert_eq!(pink_pixels(&image(&model, &mut state)), []);
    let mut state = model.start(1);
    model.add_object(&mut state, crate_at("box", 8.0, 3.5, true, true)).expect("nobody is there");
    assert_eq!(pink_pixels(&image(&model, &mut state)), pixels_on(&view(&model), &model.world.markers[0]));
    let person = "[[person]]\npath = [[6.4, 3.35], [6.4, 3.351]]\nspeed = 0.01";
    let model = hall(exact(CAMERA), &format!("{MARKER}\n{person}"));
    assert!(pink_pixels(&image(&model, &mut model.start(1))).len() < 5, "a person in the line of sight");
}

#[test]
fn a_wall_stands_on_the_floor_where_it_is() {
    let settings = exact(CAMERA);
    let model = hall(settings, "[[wall]]\nline = [[7.0, 0.5], [7.0, 5.5]]\nthickness = 0.0");
    let mut state = model.start(1);
    let image = image(&model, &mut state);
    // Straight ahead its foot is seen where the floor is 2 m off: above the wall is lighter than the floor.
    let foot = view(&model).pixel_of(Point::new(2.0, 0.0)).expect("ahead").row;
    let (column, row) = (image.columns / 2, libm::floor(foot) as usize);
    let green = |row: usize| i32::from(image.at(column, row)[1]);
    assert!(green(row - 1) > green(row + 1) * 5 / 4, "{} over {}", green(row - 1), green(row + 1));
    assert!((green(row - 5) - green(row - 1)).abs() < 10 && (green(row + 5) - green(row + 1)).abs() < 25);
}

#[test]
fn images_come_once_a_period_and_only_while_the_camera_is_on() {
    let model = hall(exact(CAMERA), MARKER);
    let mut state = model.start(1);
    let told: Vec<_> = (0..40).map(|_| model.step(&mut state, &looking(0.0)).camera.expect("it is on").image).collect();
    assert_eq!(told.iter().flatten().count(), 10, "2 s");
    assert_eq!(model.step(&mut state, &drive(0.0, 0.0)).camera, None);
    let blind = hall(exact("b21"), MARKER);
    assert_eq!(blind.step(&mut blind.start(1), &looking(1.0)).camera, None);
}

#[test]
fn the_pan_unit_turns_as_fast_and_as_far_as_it_can() {
    let model = hall(exact(CAMERA), MARKER);
    let camera = model.robot().camera.expect("it has one");
    let mut state = model.start(1);
    let mut last = state.pan;
    for step in 0..200 {
        model.step(&mut state, &looking(if step < 60 { 99.0 } else { -99.0 }));
        let change_radps = state.pan.speed_radps - last.speed_radps;
        assert!(change_radps.abs() <= camera.pan_acceleration_radps2 * 0.05 + 1e-9 || state.pan.speed_radps == 0.0);
        assert!(state.pan.speed_radps.abs() <= camera.max_pan_radps + 1e-9);
        assert!(state.pan.angle_rad.abs() <= camera.pan_range_rad);
        if step == 59 {
            assert_eq!(state.pan.angle_rad, camera.pan_range_rad);
        }
        last = state.pan;
    }
    assert_eq!(state.pan.angle_rad, -camera.pan_range_rad);
    // Whoever wants nothing of it lets it stand.
    steps(&model, &mut state, &drive(0.0, 0.0), 5);
    assert_eq!(state.pan.speed_radps, 0.0);
}

#[test]
fn a_camera_that_is_turned_sees_what_is_there() {
    let model = hall(exact(CAMERA), "[[marker]]\nat = [5.0, 5.0]\nsize = 0.4");
    let mut state = model.start(1);
    assert_eq!(pink_pixels(&image(&model, &mut state)), []);
    state.pan.angle_rad = std::f64::consts::FRAC_PI_2;
    let seen = pink_pixels(&image(&model, &mut state));
    let middle = view(&model).pixel_of(Point::new(2.0, 0.0)).expect("ahead");
    assert!(seen.contains(&(middle.column as usize, middle.row as usize)), "{seen:?}");
}

#[test]
fn light_differs_from_place_to_place_and_noise_from_image_to_image() {
    let model = hall(SimulatorSettings::of(builtin(CAMERA)), "");
    let mut state = model.start(1);
    let (one, other) = (image(&model, &mut state), image(&model, &mut state));
    let brightness = |image: &CameraImage| image.rgb.iter().map(|&value| u64::from(value)).sum::<u64>() as f64;
    assert_ne!(one, other);
    assert!((brightness(&one) / brightness(&other) - 1.0).abs() < 0.01);
    let of_seed = |seed| brightness(&image(&model, &mut model.start(seed)));
    let lights: Vec<f64> = (0..20).map(of_seed).collect();
    let (least, most) =
        lights.iter().fold((f64::MAX, 0.0_f64), |(least, most), &light| (least.min(light), most.max(light)));
    assert!(most > 1.4 * least, "{least} to {most}");
    let noise = model.robot().camera.expect("it has one").noise * 255.0;
    let off = one.rgb.iter().zip(&other.rgb).map(|(&a, &b)| f64::from(a) - f64::from(b));
    let off2 = off.map(|off| off * off);
    let deviation = (off2.sum::<f64>() / one.rgb.len() as f64 / 2.0).sqrt();
    assert!((deviation / noise - 1.0).abs() < 0.1, "{deviation} for {noise}");
}

#[test]
fn a_camera_leaves_the_numbers_of_all_other_sensors_alone() {
    let with = hall(SimulatorSettings::of(builtin(CAMERA)), "people = 3");
    let without = hall(SimulatorSettings::of(builtin("b21")), "people = 3");
    let (mut seeing, mut blind) = (with.start(3), without.start(3));
    for _ in 0..100 {
        let commands = drive(0.3, 0.4);
        let blind = without.step(&mut blind, &commands);
        let seen = with.step(&mut seeing, &Commands { camera: Some(CameraCommand { pan_radps: 1.0 }), ..commands });
        assert!(seen.camera.is_some());
        assert_eq!(Percept { camera: None, ..seen }, blind);
    }
}
