//! Modules in other processes where there is no world: nothing of a robot of ours is there.

use crate::folder::{put, text_in};
use crate::modules::{folder_of_lamp, run_in};
use crate::rpl::Ended;
use std::path::Path;

/// The lamp's manifest without what only a robot can tell.
fn folder_of_lamp_alone(name: &str, plan: &str) -> std::path::PathBuf {
    let folder = folder_of_lamp(name, plan, ("wants = [\"position\"]\n", ""));
    put(&folder, "other.py", OTHER);
    folder
}

/// A module whose names are those of things of a robot.
const OTHER: &str = "
from rpl_module import Behaviour, Module
module = Module('base')

@module.each_tick
def sense(tick):
    module.set('battery*', 1.0 - tick.time_s / 10)

@module.behaviour('navigation')
class Drive(Behaviour):
    def start(self, to):
        self.left = to
    def step(self, tick):
        self.left -= 1
        if self.left <= 0:
            self.succeed()

module.run()
";

const OTHER_MANIFEST: &str = "
name = \"base\"
doc = \"A base of somebody else.\"
command = [\"python3\", \"other.py\"]
[[behaviour]]
name = \"navigation\"
doc = \"Drives.\"
parameters = [\":to\"]
[[fluent]]
name = \"battery*\"
doc = \"The charge, from 0 to 1.\"
type = \"number\"
";

fn trace(folder: &Path, name: &str) -> String {
    let Ended { errors, status, .. } =
        run_in(folder, &["run", "plan.rpl", "--module", "lamp.toml", "--trace", name, "-q"]);
    assert_eq!(status, 0, "{errors}");
    text_in(folder, name)
}

#[test]
fn a_run_has_what_its_modules_have_and_nothing_of_a_robot() {
    let folder = folder_of_lamp_alone("alone-run", "(pursue (whenever lamp-on?* (print 'on)) (blink-lamp 2))");
    let Ended { out, errors, status } = run_in(&folder, &["run", "plan.rpl", "--module", "lamp.toml"]);
    assert_eq!((out.as_str(), status), ("on\non\n", 0), "{errors}");
    assert!(!errors.contains("driven"), "{errors}");
    let first = trace(&folder, "a.jsonl");
    assert!(!first.contains("battery*") && !first.contains("contact"), "{first}");
    assert_eq!(trace(&folder, "b.jsonl"), first, "lock step is deterministic");
    put(&folder, "go.rpl", "(go-to 'desk)");
    let Ended { errors, .. } = run_in(&folder, &["run", "go.rpl", "--module", "lamp.toml"]);
    assert!(errors.contains("`go-to` belongs to the robot, and there is none"), "{errors}");
}

#[test]
fn what_needs_a_robot_is_refused_and_says_what_it_needs() {
    let folder = folder_of_lamp("alone-needs", "(print 1)", ("", ""));
    let alone = ["run", "plan.rpl", "--module", "lamp.toml"];
    let Ended { errors, status, .. } = run_in(&folder, &alone);
    let told = "the module `lamp` (lamp.toml) wants the robot's position, and there is none; add `--world dept`";
    assert!(errors.contains(told) && status == 2, "{errors}");
    let manifest = text_in(&folder, "lamp.toml").replace("wants = [\"position\"]\n", "");
    put(&folder, "lamp.toml", manifest.replace("valve = \"lamp\"", "valve = \"wheels\""));
    let Ended { errors, status, .. } = run_in(&folder, &alone);
    let told = "`blink` of the module `lamp` (lamp.toml:9:8) needs the robot's valve `wheels`, and there is none";
    assert!(errors.contains(told) && status == 2, "{errors}");
    // A plan that is only checked may still be for a robot.
    let Ended { out, errors, status } = run_in(&folder, &["check", "plan.rpl", "--module", "lamp.toml"]);
    assert_eq!(status, 0, "{out}{errors}");
}

#[test]
fn the_names_of_our_robot_are_free_for_modules_and_plans() {
    let plan = "(def-plan go-to (steps) (run-behaviour navigation :to steps)) (go-to 4) (print (value battery*))";
    let folder = folder_of_lamp_alone("alone-names", plan);
    put(&folder, "base.toml", OTHER_MANIFEST);
    let Ended { out, errors, status } = run_in(&folder, &["run", "plan.rpl", "--module", "base.toml"]);
    assert_eq!((out.as_str(), status), ("0.98\n", 0), "{errors}");
    put(&folder, "plan.rpl", "(def-fluent battery* 1)");
    let Ended { errors, status, .. } = run_in(&folder, &["run", "plan.rpl", "--module", "base.toml"]);
    assert!(errors.contains("`battery*`") && status == 2, "a plan takes no name of a module: {errors}");
}

#[test]
fn a_project_with_modules_needs_no_world() {
    let plan = "(deftest blinks (blink-lamp 1) (assert (not (value lamp-on?*)))) (measure 'times 1) (blink-lamp 1)";
    let folder = folder_of_lamp_alone("alone-project", plan);
    put(&folder, "rpl.toml", "plan = \"plan.rpl\"\nmodules = [\"lamp.toml\"]\nruns = 3\n");
    for (command, told) in [
        (&["run"][..], "0.2 s  blink is done"),
        (&["check"], "plan.rpl: no findings"),
        (&["test"], "1 test, all ok"),
        (&["experiment"], "succeeded 3 of 3"),
        (&["run", "--report", "report.html"], "0.2 s  blink is done"),
    ] {
        let Ended { out, errors, status } = run_in(&folder, command);
        assert!((out.clone() + &errors).contains(told) && status == 0, "{command:?}\n{out}{errors}");
    }
    assert!(folder.join("report.html").is_file());
}

#[test]
fn a_run_goes_on_from_its_journal_and_is_repeated_from_its_recording() {
    let plan = "(with-valve lamp
                  (with-failure-handling ((interrupted () (print 'again) (retry))) (run-behaviour blink :times 2)))";
    let folder = folder_of_lamp_alone("alone-journal", plan);
    let run = ["run", "plan.rpl", "--module", "lamp.toml"];
    let Ended { errors, status, .. } =
        run_in(&folder, &[&run[..], &["--until", "0.2s", "--journal", "journal"]].concat());
    assert!(errors.contains("cut off by --until"), "{status} {errors}");
    let Ended { out, errors, status } = run_in(&folder, &["resume", "journal"]);
    assert_eq!((out.as_str(), status), ("again\n", 0), "the module was started anew: {errors}");
    let recorded = [&run[..], &["--record", "r.jsonl", "--trace", "live.jsonl"]].concat();
    assert_eq!(run_in(&folder, &recorded).status, 0);
    std::fs::remove_file(folder.join("lamp.py")).expect("it was there");
    let Ended { errors, status, .. } = run_in(&folder, &["replay", "r.jsonl", "--trace", "again.jsonl"]);
    assert_eq!(status, 0, "{errors}");
    assert_eq!(text_in(&folder, "live.jsonl"), text_in(&folder, "again.jsonl"));
}

#[test]
fn with_a_live_module_time_passes_as_on_the_clock() {
    // If the run did not wait for the clock, its minute would be over before the module is.
    let plan = "
(with-timeout 60
  (wait-for slept*))";
    let folder = folder_of_lamp_alone("alone-live", plan);
    put(
        &folder,
        "slow.py",
        "
import time
from rpl_module import Module
module = Module('slow')

@module.each_tick
def work(tick):
    time.sleep(0.2)
    module.set('slept*', 1)

module.run()
",
    );
    put(
        &folder,
        "slow.toml",
        "
name = \"slow\"
doc = \"Works for longer than a tick.\"
command = [\"python3\", \"slow.py\"]
pace = \"live\"
[[fluent]]
name = \"slept*\"
doc = \"How often it has slept.\"
type = \"integer\"
",
    );
    let Ended { errors, status, .. } = run_in(&folder, &["run", "plan.rpl", "--module", "slow.toml"]);
    assert_eq!(status, 0, "{errors}");
    let Ended { errors, status, .. } = run_in(&folder, &["experiment", "plan.rpl", "--module", "slow.toml"]);
    assert!(errors.contains("write `pace = \"lock-step\"`") && status == 2, "{errors}");
}
