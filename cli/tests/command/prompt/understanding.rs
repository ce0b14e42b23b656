//! Tasks, valves, causes, events, missions looked at.

use super::session;

#[test]
fn causes_are_followed_from_task_to_fluent() {
    let lines = "(def-fluent open? nil)\n(def-valve arm)\n\
                 (spawn (with-valve arm (wait-for open?)))\n(spawn (with-valve arm 1))\n(wait-time 1)\n\
                 :tasks\n:valves\n:why spawn.2\n:why no-such\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.contains("main  waits for the next form"), "{}", shown.out);
    assert!(shown.out.contains("  spawn  waits for fluent open?, holds arm\n"), "{}", shown.out);
    assert!(shown.out.contains("arm  held by main/spawn\n    in line: main/spawn.2"), "{}", shown.out);
    let why = "main/spawn.2  waits for valve arm\n";
    assert!(shown.out.contains(why) && shown.out.contains("the valve is held by\n"), "{}", shown.out);
    assert!(shown.out.contains("open? = nil"), "{}", shown.out);
    assert!(shown.out.contains("no task has the path `no-such`"), "{}", shown.out);
}

/// r[valve.places]
#[test]
fn the_places_of_a_valve_are_shown_with_who_has_them() {
    let lines = "(def-valve docks 2)\n(def-fluent open? nil)\n\
                 (spawn (with-valve docks (wait-for open?)))\n(wait-time 1)\n:valves\n\
                 (spawn (with-valve docks (wait-for open?)))\n(spawn (with-valve docks 1))\n(wait-time 1)\n\
                 :tasks\n:valves\n:why spawn.3\n\
                 (spawn (with-priority 1 (with-valve docks (wait-time 9))))\n(wait-time 1)\n:why spawn.2\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.contains("docks  1 of 2 places free\n    held by main/spawn\n"), "{}", shown.out);
    assert!(shown.out.contains("  spawn.2  waits for fluent open?, holds docks\n"), "{}", shown.out);
    let full = "docks  0 of 2 places free\n    held by main/spawn\n    held by main/spawn.2\n    in line: main/spawn.3";
    assert!(shown.out.contains(full), "{}", shown.out);
    for holder in ["    main/spawn  waits for fluent open?", "    main/spawn.2  waits for fluent open?"] {
        assert!(shown.out.contains(&format!("  the valve is held by\n{holder}")), "{}", shown.out);
    }
    let taken = "docks was taken from it; main/spawn and main/spawn.4";
    assert!(shown.out.contains(taken), "{}", shown.out);
}

#[test]
fn a_mission_is_stopped_looked_at_and_finished() {
    let lines = ":break (eq holding* 'mail)\n:load delivery.rpl\n:map\n:valves\n:watch (value holding*)\n:back 5s\n:delete\n:continue\n";
    let shown = session(&["repl", "--world", "dept"], lines);
    assert!(shown.out.contains("estimate, certainty"), "{}", shown.out);
    assert!(shown.out.contains("held by main/"), "{}", shown.out);
    assert!(shown.out.contains("(value holding*) = nil"), "{}", shown.out);
    assert!(shown.out.contains("mail delivered after"), "{}", shown.out);
    assert_eq!(shown.status, 0);
}

#[test]
fn who_suspended_a_task_and_until_when_one_waits_is_told() {
    let lines = "(defvar painter (spawn (wait-time 10)))\n\
                 (spawn (with-task-suspended (painter) (wait-time 4)))\n\
                 (def-fluent open? nil)\n(spawn (wait-for open? :timeout 7))\n(wait-time 1)\n\
                 :why main/spawn\n:why spawn.2\n:why spawn.3\n:tasks\n\
                 (suspend painter)\n(wait-time 5)\n:why main/spawn\n";
    let shown = session(&["repl"], lines);
    for text in [
        "main/spawn  suspended (was waiting for time until 10.000 s, in 9.000 s)\n",
        "  it is suspended by\n    main/spawn.2  waits for time until 4.000 s, in 3.000 s\n",
        "main/spawn.3  waits for fluent open?, at most until 7.000 s, in 6.000 s\n",
        "\n  spawn.2  waits for time until 4.000 s, in 3.000 s\n",
        "main/spawn  suspended (was waiting for time until 10.000 s, in 4.000 s)\n",
    ] {
        assert!(shown.out.contains(text), "{text}{}", shown.out);
    }
    let last = shown.out.rfind("main/spawn  suspended").expect("it is told");
    assert!(shown.out[last..].contains("  it was suspended by `suspend`, or a task above it was"), "{}", shown.out);
}

#[test]
fn events_and_documentation_are_looked_up() {
    let lines = "(def-fluent level 0)\n(setf (value level) 7)\n(setf (value level) 8)\n:trace level 7\n:trace nothing-such\n:doc wait-for\n:doc\n";
    let shown = session(&["repl"], lines);
    assert!(shown.out.contains("fluent     main  level = 7\nno such event\n"), "{}", shown.out);
    assert!(shown.out.contains("(wait-for "), "{}", shown.out);
}

#[test]
fn a_form_is_projected_and_what_is_under_way() {
    let lines = ":project\n:project (go-to 'table-side)\n:break (> (now) 2)\n(go-to 'table-side)\n:project\n\
                 :project (go-to 'desk)\n:delete\n:continue\n";
    let shown = session(&["repl", "--world", "test-room"], lines);
    assert!(shown.errors.contains("nothing runs; type `:project FORM`"), "{}", shown.errors);
    assert!(shown.errors.contains("a form is under way; `:project` alone tells"), "{}", shown.errors);
    assert_eq!(shown.out.matches("runs succeed").count(), 2, "{}", shown.out);
}
