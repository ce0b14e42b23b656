//! The delivery of the mail, turned by hand on the way.

use rpl_robot::geometry::distance_m;
use rpl_robot::simulator::ItemPlace;
use rpl_tests::mission::{Mission, Run, dept};
use std::sync::OnceLock;

const DELIVERY: &str = include_str!("../../../../examples/delivery.rpl");
const ROTATED: &str = include_str!("../../../../examples/scenarios/rotated.rpl");

fn rotated() -> &'static Run {
    static RUN: OnceLock<Run> = OnceLock::new();
    RUN.get_or_init(|| Mission::new(dept(), DELIVERY).with_scenario(ROTATED).run(1, 900.0))
}

#[test]
fn the_mail_lies_at_the_shelf() {
    let run = rotated();
    assert!(run.outcome().contains("mail delivered"), "{}", run.outcome());
    let robot = &run.system.outside;
    let shelf = robot.model().world.place("wolframs-shelf").expect("a place of the department").pose_in_map.point();
    assert!(distance_m(robot.true_pose_in_map().point(), shelf) < 0.5, "{:?}", robot.true_pose_in_map());
    let mail = robot.host.state.gripper.items.iter().find(|item| item.name == "mail").expect("the world has mail");
    match mail.at {
        ItemPlace::Point(point) => assert!(distance_m(point, shelf) < 1.0, "{point:?}"),
        ItemPlace::Held => panic!("the mail is still in the gripper"),
    }
}

#[test]
fn the_delivery_touches_nothing() {
    let contacts = rotated().system.outside.contacts();
    assert_eq!((contacts.caused, contacts.unseen), (0, 0));
}
