use super::*;

const ROOM: &str = "name = \"w\"\nsize = [4.0, 3.0]\nstart = [2.0, 1.5, \"90deg\"]\n[[wall]]\nline = [[0.1, 0.1], [3.9, 0.1], [3.9, 2.9], [0.1, 2.9], [0.1, 0.1]]\nthickness = 0.2\n";

fn hung(pose: &str, more: &str) -> String {
    format!("{ROOM}[[landmark]]\nname = \"sheet\"\npose = {pose}\n{more}")
}

#[test]
fn a_landmark_hangs_on_a_wall_with_both_edges() {
    let world = World::parse(&hung("[2.0, 0.2, \"90deg\"]", ""), "w.toml").expect("fine");
    let landmark = &world.landmarks[0];
    let sizes = (landmark.width_m, landmark.height_m, landmark.bottom_m, landmark.colour);
    assert_eq!(sizes, (0.3, 0.3, 0.2, MarkerColour::Pink));
    let [left, right] = landmark.edges_in_map();
    assert!((left - Point::new(2.15, 0.2)).norm() < 1e-9 && (right - Point::new(1.85, 0.2)).norm() < 1e-9);
    let found = |pose: &str, more: &str| faults(&hung(pose, more));
    let place = "9:8 pose: the landmark `sheet`, 0.3 m wide, hangs on no wall at";
    for (pose, at) in [
        ("[2.0, 1.0, \"90deg\"]", "(2, 1)"),
        ("[2.0, 0.2, \"80deg\"]", "(2, 0.2)"),
        ("[2.0, 0.2, \"270deg\"]", "(2, 0.2)"),
        ("[0.1, 0.2, \"90deg\"]", "(0.1, 0.2)"),
    ] {
        assert_eq!(found(pose, ""), [format!("{place} {at}")]);
    }
    let doorway = "[[room]]\nname = \"r\"\nrect = [0.2, 0.2, 3.8, 2.8]\n[[door]]\nroom = \"r\"\nat = [2.0, 0.1]\nwidth = 0.9\naxis = \"x\"";
    assert_eq!(found("[2.0, 0.2, \"90deg\"]", doorway), [format!("{place} (2, 0.2)")], "that is a door");
    let error = World::parse(&hung("[2.1, 0.4, \"90deg\"]", ""), "w.toml").expect_err("in the air");
    assert!(error.to_string().contains("the nearest is at [2.100, 0.200, \"90deg\"]"), "{error}");
}

#[test]
fn landmarks_have_names_and_sizes() {
    let found = |more: &str| faults(&hung("[2.0, 0.2, \"90deg\"]", more));
    assert_eq!(found("width = 3"), ["10:9 width: the `width` of a landmark must be at most 2 m, found 3 m"]);
    assert_eq!(found("bottom = -1"), ["10:10 bottom: `bottom` must be 0 or more, found -1"]);
    assert_eq!(found("colour = \"grean\""), ["10:10 colour: \"grean\" is no `colour`, did you mean \"green\"?"]);
    assert_eq!(found("facing = 0").len(), 1);
    let twice = "[[landmark]]\nname = \"Sheet\"\npose = [2.0, 2.8, \"270deg\"]";
    assert_eq!(found(twice), ["11:8 name: the landmark `Sheet` has the name of a landmark above"]);
}
