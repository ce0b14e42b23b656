//! Robots as a user names them and hands them in.

use crate::folder::{folder, put};
use crate::rpl::{Ended, run_in};
use std::path::Path;

/// Runs a command line of words.
fn rpl(folder: &Path, line: &str) -> Ended {
    run_in(folder, &line.split_whitespace().collect::<Vec<_>>())
}

const PLAN: &str = "(with-valve arm
  (with-failure-handling ((grasp-failure (f) (print (failure-message f))))
    (run-behaviour gripper :release t)))
\
                    (wait-time 1)
(print (list (value bumped?*) (value battery*)))";

#[test]
fn robots_are_listed_shown_and_written_to_start_from() {
    let folder = folder("robots");
    let list = rpl(&folder, "robots").out;
    for name in ["b21", "b21-camera", "b21-laser", "nomad-200", "pioneer-2dx", "pioneer-front", "turtlebot"] {
        assert!(list.lines().any(|line| line.split_whitespace().next() == Some(name)), "{list}");
    }
    let shown = rpl(&folder, "robots pioneer-front").out;
    assert!(shown.contains("sonars    8, cones of 30°, 5 m; they look at 90° 50° 30° 10° -10°"), "{shown}");
    put(&folder, "mine.toml", rpl(&folder, "robots nomad-200 --toml").out.replace("ring = 16", "ring = 12"));
    let shown = rpl(&folder, "robots mine.toml").out;
    assert!(shown.contains("12 in a ring, cones of 25°, 6.48 m"), "{shown}");
}

#[test]
fn an_unknown_robot_and_one_with_faults_are_refused_in_words() {
    let folder = folder("no-robots");
    let Ended { errors: told, status, .. } = rpl(&folder, "robots nomad");
    assert!(status == 2 && told.contains("no robot is called `nomad`"), "{told}");
    let blind = rpl(&folder, "robots turtlebot --toml").out.replace("[laser]", "[lasr]");
    put(&folder, "blind.toml", blind);
    put(&folder, "plan.rpl", "(print 1)");
    let Ended { errors: told, status, .. } = rpl(&folder, "run plan.rpl --world test-room --robot blind.toml");
    assert_eq!(status, 2);
    for part in ["unknown key `lasr`, did you mean `laser`?", "the robot sees nothing", "add [sonar] or [laser]"] {
        assert!(told.contains(part), "{told}\nshould say: {part}");
    }
    let Ended { errors: told, status, .. } = rpl(&folder, "run plan.rpl --robot b21");
    assert!(status == 2 && told.contains("--world"), "{told}");
}

#[test]
fn what_a_robot_does_not_have_is_missed_by_plans_alone() {
    let folder = folder("bare");
    let text = rpl(&folder, "robots b21 --toml").out.replace("bumper = true", "");
    let (before, rest) = text.split_once("[gripper]").expect("it has one");
    let (_, odometry) = rest.split_once("[odometry]").expect("it strays");
    put(&folder, "bare.toml", format!("{before}[odometry]{odometry}"));
    put(&folder, "plan.rpl", PLAN);
    let Ended { out: shown, errors: told, status } =
        rpl(&folder, "run plan.rpl --world test-room --grid coarse --robot bare.toml");
    assert_eq!((status, shown.as_str()), (0, "the robot `b21` has no gripper\n(nil 1.0)\n"), "{told}");
}

#[test]
fn whether_there_is_room_depends_on_the_robot() {
    let folder = folder("narrow");
    let world = "name = \"cell\"\nsize = [4.0, 4.0]\nstart = [0.3, 2.0, 0]\n[[wall]]\n\
                 line = [[0, 0], [0, 4], [4, 4], [4, 0], [0, 0]]\nthickness = 0.1\n[[wall]]\nline = [[2, 0], [2, 4]]\n[[room]]\nname = \"r\"\nrect = [2.1, 0, 4, 4]\n\
                 [[door]]\nroom = \"r\"\nat = [2, 2]\nwidth = 0.5\naxis = \"y\"\n";
    put(&folder, "cell.toml", world);
    let Ended { errors: told, status, .. } = rpl(&folder, "worlds cell.toml");
    assert_eq!(status, 2);
    assert!(told.contains("cell.toml:3:9: the start is in the way of a wall"), "{told}");
    assert!(told.contains("leave 0.265 m around the start free"), "{told}");
    let small = rpl(&folder, "worlds cell.toml --robot turtlebot");
    assert_eq!((small.status, small.errors.as_str()), (0, ""), "a door of half a metre is wide enough");
    put(&folder, "cell.toml", world.replace("[0.3, 2.0", "[0.6, 2.0"));
    let large = rpl(&folder, "worlds cell.toml");
    assert!(large.status == 0 && large.errors.contains("0.50 m wide, too narrow for the robot"), "{}", large.errors);
}

#[test]
fn a_trace_says_of_which_robot_it_is_if_one_was_named() {
    let folder = folder("robot-traces");
    put(&folder, "plan.rpl", "(wait-time 1)");
    let header = |options: &str| {
        let line = format!("run plan.rpl --world test-room --grid coarse --trace t.jsonl {options}");
        assert_eq!(rpl(&folder, &line).status, 0);
        let trace = std::fs::read_to_string(folder.join("t.jsonl")).expect("it was written");
        trace.lines().next().unwrap_or_default().to_string()
    };
    assert!(header("--robot nomad-200").contains("\"robot\":\"nomad-200\""));
    assert!(!header("").contains("robot"));
}

#[test]
fn an_experiment_with_a_robot_of_its_own_takes_no_other() {
    let folder = folder("robot-of-its-own");
    for name in ["sensing", "behaviours", "rupart"] {
        let found = rpl(&folder, &format!("experiment {name} --runs 1 --robot nomad-200"));
        assert!(found.errors.contains("has a robot of its own; leave `--robot` away"), "{name}: {}", found.errors);
        assert_eq!(found.status, 2);
    }
}
