use super::*;
use crate::geometry::wrap_angle_rad;
use crate::sensors::{LaserScanner, SonarArray, SonarLayout, SonarMount};
use crate::simulator::surface::{SurfaceForm, forms_of};
use std::f64::consts::FRAC_PI_4;

#[test]
fn a_sonar_facing_a_wall_reads_its_distance() {
    let model = hall(exact("b21"), "");
    let mut state = model.start(1);
    let sonar_m = ring(&model, &mut state);
    for (sonar, wall_m) in [(0, 5.0), (6, 3.0), (12, 5.0), (18, 3.0)] {
        assert_eq!(sonar_m[sonar], wall_m);
    }
    // 45° off: the nearest point is on the side of the cone that is nearer to the normal.
    let slanted_m = 3.0 / libm::cos(FRAC_PI_4 - 7.5_f64.to_radians());
    assert!((f64::from(sonar_m[3]) - slanted_m).abs() < 1e-6);
}

#[test]
fn the_rest_of_the_ring_follows_counter_clockwise() {
    let model = hall(exact("b21"), "[[object]]\nname = \"pole\"\ncircle = [5.0, 4.5, 0.1]");
    let sonar_m = ring(&model, &mut model.start(1));
    assert!((sonar_m[6] - 1.4).abs() < 1e-6, "sonar 6 looks to the left");
    assert_eq!(sonar_m[18], 3.0);
}

#[test]
fn a_cone_catches_an_edge_off_its_axis() {
    let model = hall(exact("b21"), "");
    for (off_axis_deg, ahead_sees_it) in [(0.0_f64, true), (5.0, true), (7.4, true), (7.6, false), (12.0, false)] {
        let mut state = model.start(1);
        // The lower left corner of the crate is 2 m off; nothing else of it is nearer.
        let (sin, cos) = libm::sincos(off_axis_deg.to_radians());
        let crate_there = crate_at("crate", 5.0 + 2.0 * cos + 0.2, 3.0 + 2.0 * sin + 0.2, true, true);
        model.add_object(&mut state, crate_there).expect("nobody is there");
        let sonar_m = ring(&model, &mut state);
        assert_eq!((sonar_m[0] - 2.0).abs() < 1e-6, ahead_sees_it, "{off_axis_deg}: {sonar_m:?}");
        assert_eq!((sonar_m[1] - 2.0).abs() < 1e-6, !ahead_sees_it, "{off_axis_deg}: {sonar_m:?}");
    }
}

#[test]
fn sonars_look_through_an_open_door_only() {
    let model = model("test-room", exact("b21"));
    let mut state = model.start(1);
    model.teleport(&mut state, Pose::new(3.0, 3.0, 0.0)).expect("free");
    assert!((ring(&model, &mut state)[0] - 4.8).abs() < 1e-6, "the wall of the room behind");
    model.close_door(&mut state, "east").expect("nobody is in the door");
    assert!((ring(&model, &mut state)[0] - 1.98).abs() < 1e-6, "the leaf of the door");
    model.open_door(&mut state, "east").expect("it has a door");
    assert!((ring(&model, &mut state)[0] - 4.8).abs() < 1e-6);
}

/// All surfaces that are there, without any lookup.
fn present_forms(model: &SimulatorModel, state: &SimulatorState) -> Vec<SurfaceForm> {
    let fixed = model.surfaces.iter().filter(|surface| state.is_there(surface.origin)).map(|surface| surface.form);
    let mut forms: Vec<SurfaceForm> = fixed.collect();
    for object in &state.objects_added {
        forms.extend(forms_of(&object.outline(), model.world.bounds()));
    }
    forms
}

/// Points along all surfaces, at most `spacing_m` apart, corners included.
fn sample(forms: &[SurfaceForm], spacing_m: f64) -> Vec<Point> {
    let mut points = Vec::new();
    for form in forms {
        match form {
            SurfaceForm::Edge { a, b } => {
                let count = libm::ceil((b - a).norm_squared().sqrt() / spacing_m) as usize;
                points.extend((0..=count).map(|index| a + (b - a) * (index as f64 / count.max(1) as f64)));
            }
            SurfaceForm::Disc { centre, radius_m } => {
                let count = libm::ceil(radius_m * std::f64::consts::TAU / spacing_m) as usize;
                points.extend((0..count).map(|index| {
                    let (sin, cos) = libm::sincos(std::f64::consts::TAU * index as f64 / count as f64);
                    Point::new(centre.x + radius_m * cos, centre.y + radius_m * sin)
                }));
            }
        }
    }
    points
}

#[test]
fn each_cone_finds_the_nearest_of_all_surfaces() {
    const SPACING_M: f64 = 0.004;
    let arrays = arrays();
    let model = model("dept", exact("b21"));
    let mut stream = Stream::new(3, "test");
    for _ in 0..20 {
        let mut state = model.start(1);
        shuffle_doors(&mut state, &mut stream);
        let pose = free_pose(&model, &state, &mut stream);
        model.teleport(&mut state, pose).expect("free");
        while state.objects_added.is_empty() {
            let at = free_pose(&model, &state, &mut stream);
            if let Err(error) = model.add_object(&mut state, crate_at("crate", at.x_m, at.y_m, true, true)) {
                assert!(matches!(error, OracleError::InTheWay { .. }));
            }
        }
        let surfaces = sample(&present_forms(&model, &state), SPACING_M);
        let in_base: Vec<Point> = surfaces.into_iter().map(|point| pose.inverse().transform(point)).collect();
        for sonars in &arrays {
            let echoes = model.sonar_echoes(sonars, &state, pose);
            for (sonar, (echo, mount)) in echoes.iter().zip(&sonars.mounts).enumerate() {
                let nearest_m = nearest_in_cone_m(&in_base, mount, sonars.cone_rad);
                // A sample beside a cone's edge may be on either side.
                let excess_m = nearest_m - echo.range_m;
                let agrees = if nearest_m > sonars.range_m {
                    echo.range_m > sonars.range_m - SPACING_M
                } else {
                    (-1e-6..1.5 * SPACING_M).contains(&excess_m)
                };
                assert!(agrees, "sonar {sonar} at {pose:?}: {echo:?}, but {nearest_m}");
            }
        }
    }
}

/// The nearest of these points in a cone.
fn nearest_in_cone_m(points_in_base: &[Point], mount: &SonarMount, cone_rad: f64) -> f64 {
    let offsets = points_in_base.iter().map(|point| point - mount.at_in_base);
    let inside = offsets.filter(|off| {
        let bearing_rad = libm::atan2(off.y, off.x);
        wrap_angle_rad(bearing_rad - mount.heading_rad).abs() <= cone_rad / 2.0
    });
    inside.map(|off| off.norm()).fold(f64::INFINITY, f64::min)
}

/// The papers' ring; one whose cones overlap; and sonars off the middle with gaps between them, some with
/// one apex, one looking back.
fn arrays() -> [SonarArray; 3] {
    let mount = |(x, y, degrees): (f64, f64, f64)| SonarMount {
        at_in_base: Point::new(x, y),
        heading_rad: degrees.to_radians(),
    };
    let mounts = [(0.1, 0.13, 90.0), (0.19, 0.08, 30.0), (0.19, 0.08, 10.0), (0.2, 0.0, -15.0), (-0.2, 0.02, 170.0)];
    let layouts = [
        (SonarLayout::Ring(24), 15.0_f64, 5.0),
        (SonarLayout::Ring(16), 30.0, 4.0),
        (SonarLayout::Mounts(mounts.map(mount).to_vec()), 25.0, 3.0),
    ];
    layouts.map(|(layout, cone_deg, range_m)| SonarArray::new(&layout, cone_deg.to_radians(), range_m))
}

/// Where a ray meets a surface from any side, without any cleverness.
fn along_ray_m(form: &SurfaceForm, from: Point, direction: crate::geometry::Vector) -> f64 {
    let none = f64::INFINITY;
    match form {
        SurfaceForm::Edge { a, b } => {
            let (edge, offset) = (b - a, a - from);
            let denominator = direction.x * edge.y - direction.y * edge.x;
            let range_m = (offset.x * edge.y - offset.y * edge.x) / denominator;
            let share = (offset.x * direction.y - offset.y * direction.x) / denominator;
            if range_m > 0.0 && (0.0..=1.0).contains(&share) { range_m } else { none }
        }
        SurfaceForm::Disc { centre, radius_m } => {
            let offset = centre - from;
            let middle_m = offset.dot(&direction);
            let aside2 = offset.norm_squared() - middle_m * middle_m;
            if middle_m > 0.0 && aside2 < radius_m * radius_m {
                middle_m - (radius_m * radius_m - aside2).sqrt()
            } else {
                none
            }
        }
    }
}

#[test]
fn each_laser_reading_is_the_first_surface_along_its_ray() {
    let lasers = [(181, 1.0, 8.0), (360, 1.0, 3.5), (541, 0.5, 8.0)].map(|(readings, resolution_deg, range_m)| {
        let mut robot = builtin("b21-laser").without_errors();
        let scanner = LaserScanner { readings, resolution_deg, range_m };
        robot.laser.as_mut().expect("it has one").scanner = scanner;
        (scanner, model("dept", SimulatorSettings::of(robot)))
    });
    let mut stream = Stream::new(4, "test");
    for round in 0..40 {
        let (laser, model) = &lasers[round % lasers.len()];
        let mut state = model.start(1);
        shuffle_doors(&mut state, &mut stream);
        let pose = free_pose(model, &state, &mut stream);
        let forms = present_forms(model, &state);
        for (reading, range_m) in model.laser_ranges(&state, pose).into_iter().enumerate() {
            let (sin, cos) = libm::sincos(pose.heading_rad + laser.direction_rad(reading));
            let direction = crate::geometry::Vector::new(cos, sin);
            let brute_m =
                forms.iter().map(|form| along_ray_m(form, pose.point(), direction)).fold(laser.range_m, f64::min);
            assert!((range_m - brute_m).abs() < 1e-6, "reading {reading} at {pose:?}: {range_m}, but {brute_m}");
        }
    }
}

#[test]
fn an_object_is_seen_by_its_sensors_only() {
    let model = hall(exact("b21-laser"), "");
    for (sonar, laser) in [(true, false), (false, true)] {
        let mut state = model.start(1);
        model.add_object(&mut state, crate_at("crate", 7.2, 3.0, sonar, laser)).expect("nobody is there");
        let percept = model.step(&mut state, &drive(0.0, 0.0));
        let sonar_m = percept.sonar_m.expect("sonars are on")[0];
        let laser_m = percept.laser_m.expect("there is a laser")[90];
        assert_eq!(sonar_m, if sonar { 2.0 } else { 5.0 });
        assert_eq!(laser_m, if laser { 2.0 } else { 5.0 });
    }
}

#[test]
fn grazed_walls_give_no_echo_and_faced_walls_do() {
    let specular = with_sonars(|sonar| {
        sonar.specular_miss_probability = 1.0;
        sonar.specular_silence_probability = 1.0;
    });
    let limit_rad = 27_f64.to_radians();
    let model = hall(specular, "");
    let sonar_m = ring(&model, &mut model.start(1));
    // The walls to the left and right are 3 m off; the cone's edge nearer to them decides.
    for sonar in 7..11 {
        let incidence_rad = (15.0 * (sonar as f64 - 6.0) - 7.5).to_radians();
        let echo_m = (3.0 / libm::cos(incidence_rad)).min(5.0);
        let expected_m = if incidence_rad > limit_rad { 5.0 } else { echo_m };
        assert!((f64::from(sonar_m[sonar]) - expected_m).abs() < 1e-6, "sonar {sonar}: {sonar_m:?}");
    }
}

#[test]
fn errors_of_the_sonars_have_their_stated_rates() {
    let mut robot = builtin("b21");
    let sonar = robot.sonar.as_mut().expect("it has a ring");
    (sonar.dropout_probability, sonar.crosstalk_probability) = (0.05, 0.02);
    let settings = sonar.clone();
    let model = hall(SimulatorSettings::of(robot), "");
    let mut state = model.start(5);
    let count = 20_000;
    let (mut lost, mut short, mut sum, mut squares, mut good) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for _ in 0..count {
        let reading_m = f64::from(ring(&model, &mut state)[6]);
        if reading_m == settings.range_m {
            lost += 1.0;
        } else if reading_m < 2.7 {
            short += 1.0;
        } else {
            good += 1.0;
            sum += reading_m - 3.0;
            squares += (reading_m - 3.0) * (reading_m - 3.0);
        }
    }
    let rate = |times: f64| times / f64::from(count);
    let sigma_m = settings.noise_m + 3.0 * settings.noise_per_m;
    assert!((rate(lost) - 0.05).abs() < 4.0 * (0.05 * 0.95 / f64::from(count)).sqrt());
    // Cross-talk is uniform up to the true range, so a tenth of it hides among the good readings.
    assert!((rate(short) - 0.02 * (2.7 - 0.265) / (3.0 - 0.265)).abs() < 0.004);
    assert!((sum / good).abs() < 0.004);
    assert!(((squares / good).sqrt() / sigma_m - 1.0).abs() < 0.1);
}

#[test]
fn a_miss_stays_while_the_robot_stands() {
    let model = hall(with_sonars(|sonar| sonar.specular_miss_probability = 0.5), "");
    let mut state = model.start(5);
    let first_m = ring(&model, &mut state);
    assert_eq!(first_m, ring(&model, &mut state));
    let mut patterns = vec![first_m];
    for _ in 0..20 {
        state.rotate(std::f64::consts::FRAC_PI_2);
        patterns.push(ring(&model, &mut state));
    }
    patterns.dedup();
    assert!(patterns.len() > 2, "turning changes which walls are missed");
}

#[test]
fn sonars_are_silent_when_off_or_failed() {
    let model = hall(SimulatorSettings::default(), "");
    let mut state = model.start(1);
    assert!(model.step(&mut state, &Commands::default()).sonar_m.is_none());
    state.drop_sonars(1.0);
    // The failure covers the 50 ms steps that end before 50 ms + 1 s.
    let silent = (0..40).filter(|_| model.step(&mut state, &drive(0.0, 0.0)).sonar_m.is_none()).count();
    assert_eq!(silent, 19);
}
