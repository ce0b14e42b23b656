//! The day at the office, cut short: what comes in between must not lose or double an order.

use rpl_robot::geometry::distance_m;
use rpl_robot::simulator::{ItemPlace, ItemState};
use rpl_tests::mission::{Mission, Run, dept};

const OFFICE: &str = include_str!("../../../../examples/office.rpl");

/// Two orders; the battery is low on the way with the first, a visitor comes while it is charged,
/// somebody turns the robot while it leads the visitor, and a door is closed before the second.
const DAY: &str = "
(place-item! 'letter-0 13.5 8.2)
(send-message! 'deliver 'letter-0 'mail-slots 'c-centre)
(place-item! 'letter-1 13.5 8.2)
(send-message! 'deliver 'letter-1 'mail-slots 'wolframs-shelf)
(wait-time 45)
(set-battery! 0.2)
(wait-time 30)
(send-message! 'guide 'east-end 'c-centre)
(wait-time 330)
(rotate-robot! 70deg)
(close-door! 'b)
(wait-time 120)
(open-door! 'b)";

fn item<'r>(run: &'r Run, name: &str) -> &'r ItemState {
    let items = &run.system.outside.host.state.gripper.items;
    items.iter().find(|item| item.name == name).expect("the thing exists")
}

#[test]
fn orders_are_delivered_once_whatever_comes_in_between() {
    let run = Mission::new(dept(), OFFICE).with_scenario(DAY).run(4, 1500.0);
    for (name, place) in [("letter-0", "c-centre"), ("letter-1", "wolframs-shelf")] {
        let item = item(&run, name);
        let goal = dept().world.place(place).expect("a place of dept").pose_in_map.point();
        let is_there = matches!(item.at, ItemPlace::Point(point) if distance_m(point, goal) <= 1.0);
        assert!(is_there && item.put_down == 1, "{item:?}: {:#?}", run.output);
    }
    let order = |what: &str| {
        run.output.iter().position(|line| line.contains(what)).unwrap_or_else(|| panic!("{what}: {:#?}", run.output))
    };
    assert!(order("interrupted: the battery") < order("continued: the battery"));
    assert!(order("continued: the battery") < order("letter-0 is at"));
    assert!(order("interrupted: a visitor") < order("continued: the visitor"));
    assert!(order("letter-0 is at") < order("letter-1 is at"));
    assert_eq!(run.system.outside.contacts().caused, 0);
    assert!(run.system.outside.percept().is_some_and(|percept| percept.battery > 0.3));
}
