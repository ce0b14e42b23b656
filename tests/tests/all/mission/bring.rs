//! A delivery is done when the thing is known to lie at its place.

use super::world::wheels_are_free;
use rpl_robot::geometry::{Point, distance_m};
use rpl_robot::office::ReportKind;
use rpl_robot::simulator::ItemPlace;
use rpl_tests::mission::{Mission, Run, dept, test_room};

const DELIVERY: &str = "(deliver 'mail 'mail-slots 'wolframs-shelf)";

/// From so near to the shelf the robot only turns to it; the gripper opens some three seconds later.
const AT_THE_SHELF: &str = "(wait-for (< (hypot (- true-x* 17.0) (- true-y* 17.0)) 0.2))";

fn item_at(run: &Run, name: &str) -> Point {
    let items = &run.system.outside.host.state.gripper.items;
    match items.iter().find(|item| item.name == name).expect("the world has the thing").at {
        ItemPlace::Point(point) => point,
        ItemPlace::Held => panic!("`{name}` is still in the gripper\n{}", run.trace()),
    }
}

fn place(run: &Run, name: &str) -> Point {
    run.system.outside.model().world.place(name).expect("the world has the place").pose_in_map.point()
}

#[track_caller]
fn check_delivered(run: &Run) {
    assert!(run.outcome().starts_with("=>"), "{}\n{}", run.outcome(), run.trace());
    let shelf = place(run, "wolframs-shelf");
    assert!(distance_m(item_at(run, "mail"), shelf) < 1.0, "{}", run.trace());
    assert!(distance_m(run.system.outside.true_pose_in_map().point(), shelf) < 0.5, "{}", run.trace());
    assert!(wheels_are_free(&run.system));
}

fn was_carried(run: &Run) -> bool {
    run.count(|event| ReportKind::of(event) == Some(ReportKind::CarriedByHand)) > 0
}

/// Carried away on the last metre, while the gripper opens, and after that.
#[test]
fn what_was_set_down_elsewhere_is_fetched_again() {
    for delay_s in [0.1, 1.5, 2.5, 3.5] {
        let scenario = format!("{AT_THE_SHELF} (wait-time {delay_s}) (teleport-robot! 23.6 4.2 1.0)");
        let run = Mission::new(dept(), DELIVERY).with_scenario(&scenario).run(1, 900.0);
        assert!(was_carried(&run), "the delivery was done before {delay_s} s");
        check_delivered(&run);
    }
}

#[test]
fn carried_away_while_it_grasps_the_robot_goes_back() {
    let scenario = "(wait-for (< (hypot (- true-x* 13.5) (- true-y* 8.6)) 0.5)) (wait-time 3)
                    (teleport-robot! 3.4 15.3 1.0)";
    let run = Mission::new(dept(), DELIVERY).with_scenario(scenario).run(1, 900.0);
    assert!(was_carried(&run));
    check_delivered(&run);
}

#[test]
fn an_undisturbed_delivery_takes_two_seconds_more_than_its_parts() {
    let seconds = |plan: &str| {
        let run = Mission::new(dept(), plan).run(1, 300.0);
        check_delivered(&run);
        run.system.machine.now_s()
    };
    let parts = seconds("(fetch 'mail 'mail-slots) (go-to 'wolframs-shelf) (put-down)");
    assert!((0.0..=2.0).contains(&(seconds(DELIVERY) - parts)));
}

/// The bell rings while the gripper opens.
#[test]
fn nobody_drives_a_robot_that_lets_go() {
    let plan = "(go-to 'table-side)
                (pick-up 'cup)
                (let ((begin (now)))
                  (with-policy (seq (at-time (+ begin 0.5)) (with-valve wheels (log (format \"~,1f\" (- (now) begin)))))
                    (put-down)))";
    let run = Mission::new(test_room(), plan).run(1, 60.0);
    assert!(run.outcome().starts_with("=>"), "{}", run.outcome());
    let rung_s: f64 = run.output[0].trim_start_matches("log: ").parse().expect("a time");
    assert!(rung_s >= 2.0, "the wheels were given away after {rung_s} s");
}

#[test]
fn a_pose_of_the_odometry_lies_in_the_map_where_the_robot_believes_it_to_lie() {
    let plan = "(go-to 'table-side)
                (let ((there (odometry-pose)) (x (value x*)) (y (value y*)))
                  (go-to-point 2.0 2.0)
                  (list (odometry-in-map there) x y
                        (odometry-in-map (odometry-pose)) (value x*) (value y*)))";
    let numbers = |text: &str| -> Vec<f64> {
        let text = text.replace(['(', ')'], " ");
        text.split_whitespace().filter_map(|word| word.parse().ok()).collect()
    };
    let run = Mission::new(test_room(), plan).run(1, 60.0);
    let found = numbers(&run.outcome());
    let &[then_x, then_y, _, x, y, now_x, now_y, _, here_x, here_y] = found.as_slice() else { panic!("{found:?}") };
    assert!((then_x - x).hypot(then_y - y) < 0.3, "{found:?}");
    assert!((now_x - here_x).hypot(now_y - here_y) < 1e-9, "{found:?}");
}
