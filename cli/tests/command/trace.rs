//! `rpl trace`: recorded runs, shown, filtered, explained and compared; and files that are none.

use crate::folder::{folder, put, text_in};
use crate::rpl::{Ended, rpl, run_in};
use std::path::PathBuf;
use std::process::Stdio;

const PLAN: &str = "(def-fluent open? nil)
(def-fluent level 0)
(def-fluent ready (fluent (and open? (> level 2))))
(def-valve arm)
(def-plan fill () (loop (wait-time 1) (setf (value level) (1+ (value level)))))
(def-plan waiter () (wait-for (and ready (> level 5))))
(def-plan stuck () (with-valve arm (wait-for open?)))
(def-plan breaks () (wait-time 1) (fail \"no luck\"))
(ignore-failures (plan-failure) (breaks))
(par (fill)
        (waiter)
        (:tag holder (stuck))
        (:tag second (with-valve arm (print 'mine)))
        (seq (wait-time 3.5) (setf (value open?) t)))
";

struct Recorded {
    folder: PathBuf,
    trace: String,
}

/// The plan, run once and recorded in a folder of the test's own.
fn recorded(name: &str) -> Recorded {
    let folder = folder(&format!("trace-{name}"));
    put(&folder, "plan.rpl", PLAN);
    let found = run_in(&folder, &["run", "plan.rpl", "--trace", "run.jsonl", "-q", "--until", "5s"]);
    assert_eq!(found.status, 3, "{}", found.errors);
    let trace = text_in(&folder, "run.jsonl");
    Recorded { folder, trace }
}

impl Recorded {
    fn ask(&self, arguments: &[&str]) -> String {
        let found = run_in(&self.folder, &[&["trace", "run.jsonl"], arguments].concat());
        assert_eq!((found.errors.as_str(), found.status), ("", 0));
        found.out
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) {
        put(&self.folder, name, bytes);
    }
}

/// r[trace.file]
#[test]
fn every_event_is_a_line() {
    let run = recorded("lines");
    let header = run.trace.lines().next().expect("there is a header");
    let version = env!("CARGO_PKG_VERSION");
    assert_eq!(
        header,
        format!(
            "{{\"trace\":1,\"rpl\":\"{version}\",\"plan\":\"plan.rpl\",\"world\":null,\"map\":null,\"scenario\":null,\"seed\":1}}"
        )
    );
    let shown = run.ask(&[]);
    assert_eq!(shown.lines().count(), run.trace.lines().count() - 1);
    for line in [
        "     0.000  begin      main\n",
        "     1.000  failed     main/breaks  plan-failure: no luck  at plan.rpl:8:35\n",
        "     1.000  blocked    main/par[1]/waiter  waits for (and ready (> level 5))  at plan.rpl:6:21\n",
        "     1.000  valve      main/holder/stuck  arm granted\n",
        "     3.000  fluent     main/par[0]/fill  level = 2\n",
    ] {
        assert!(shown.contains(line), "{line}{shown}");
    }
    assert!(!shown.contains('\x1b'), "a pipe gets no colours");
}

#[test]
fn filters_narrow_together() {
    let run = recorded("filters");
    let levels = run.ask(&["--fluent", "level", "--task", "fill"]);
    let values: Vec<&str> = levels.lines().filter_map(|line| line.split("level = ").nth(1)).collect();
    assert_eq!(values, ["1", "2", "3", "4"]);
    let some = run.ask(&["--fluent", "level", "--task", "fill", "--from", "3s", "--to", "4s"]);
    assert_eq!(some.lines().count(), 2);
    // Who waits for a fluent belongs to it.
    assert!(run.ask(&["--fluent", "open?"]).contains("main/holder/stuck  waits for fluent open?"));
    let last = run.ask(&["--last", "2"]);
    assert_eq!(last.lines().count(), 2);
    assert!(run.ask(&[]).ends_with(&last));
    let raw = run.ask(&["--json", "--fluent", "ready"]);
    assert!(!raw.is_empty() && raw.lines().all(|line| run.trace.contains(line)), "{raw}");
}

#[test]
fn causes_are_followed_through_the_recorded_events() {
    let run = recorded("why");
    assert_eq!(
        run.ask(&["--why", "waiter", "--to", "3s"]),
        "main/par[1]/waiter  waits for (and ready (> level 5))
  at plan.rpl:6:21
  ready = nil
    open? = nil
"
    );
    // By then the condition has come to read the level too.
    let later = run.ask(&["--why", "waiter", "--to", "4.6s"]);
    assert!(later.contains("  ready = t, since 4.500 s, by main/par[4]\n"), "{later}");
    assert!(later.contains("    open? = t, since 4.500 s, by main/par[4]\n"), "{later}");
    assert!(later.contains("  level = 3, since 4.000 s, by main/par[0]/fill\n"), "{later}");
}

#[test]
fn a_valve_leads_to_its_holder_and_a_failure_to_its_origin() {
    let run = recorded("valve");
    assert_eq!(
        run.ask(&["--why", "second", "--to", "3s"]),
        "main/second  waits for valve arm
  at plan.rpl:13:22
  the valve is held by
    main/holder/stuck  waits for fluent open?
      at plan.rpl:7:36
      open? = nil
"
    );
    assert_eq!(
        run.ask(&["--why", "breaks"]),
        "main/breaks  failed at 1.000 s
  raised in main/breaks at 1.000 s, at plan.rpl:8:35: plan-failure: no luck
"
    );
    let wrong = run_in(&run.folder, &["trace", "run.jsonl", "--why", "waitr"]);
    assert_eq!(
        (wrong.errors.as_str(), wrong.status),
        ("error: no task has the path `waitr`; did you mean `waiter`?\n", 2)
    );
}

#[test]
fn equal_traces_are_the_same() {
    let run = recorded("same");
    let again = recorded("same-again");
    run.write("b.jsonl", &again.trace);
    let found = run_in(&run.folder, &["trace", "diff", "run.jsonl", "b.jsonl"]);
    let events = run.trace.lines().count() - 1;
    assert_eq!((found.out, found.status), (format!("the same: {events} events\n"), 0));
}

#[test]
fn the_first_event_that_differs_is_named_with_what_comes_before() {
    let run = recorded("diff");
    run.write("b.jsonl", run.trace.replace("\"level\",\"value\":\"3\"", "\"level\",\"value\":\"33\""));
    let line = 1 + run.trace.lines().position(|line| line.contains("\"level\",\"value\":\"3\"")).expect("it rises");
    let found = run_in(&run.folder, &["trace", "diff", "run.jsonl", "b.jsonl"]);
    assert_eq!(found.status, 1);
    let shown: Vec<&str> = found.out.lines().collect();
    let place = format!("they differ from run.jsonl:{line} and b.jsonl:{line} on, at 4.000 s, in main/par[0]/fill");
    assert_eq!(shown[0], place);
    assert_eq!(shown.len(), 6, "{}", found.out);
    assert_eq!(shown[4], "<      4.000  fluent     main/par[0]/fill  level = 3");
    assert_eq!(shown[5], ">      4.000  fluent     main/par[0]/fill  level = 33");
    // Where one ends, the other goes on.
    let whole: Vec<&str> = run.trace.lines().collect();
    run.write("short.jsonl", whole[..10].join("\n") + "\n");
    let found = run_in(&run.folder, &["trace", "diff", "run.jsonl", "short.jsonl"]);
    assert!(found.out.contains("from run.jsonl:11 and the end of short.jsonl on"), "{}", found.out);
    assert!(found.out.ends_with("> (here ends short.jsonl)\n"), "{}", found.out);
    assert_eq!(found.status, 1);
    // Another run is said to be one.
    run.write("seed.jsonl", run.trace.replace("\"seed\":1", "\"seed\":2").replace("level = 3", "level = 4"));
    run.write("seed.jsonl", whole[0].replace("\"seed\":1", "\"seed\":2") + "\n");
    let found = run_in(&run.folder, &["trace", "diff", "run.jsonl", "seed.jsonl"]);
    assert!(found.out.starts_with("the runs are not the same: plan.rpl, seed 1; plan.rpl, seed 2\n"), "{}", found.out);
}

#[test]
fn a_trace_that_is_cut_off_is_read_as_far_as_it_goes() {
    let run = recorded("cut");
    let lines = run.trace.lines().count();
    let cut = &run.trace[..run.trace.len() - 20];
    run.write("cut.jsonl", cut);
    let found = run_in(&run.folder, &["trace", "cut.jsonl"]);
    let whole = run.ask(&[]);
    assert_eq!(found.out.lines().count(), lines - 2);
    assert!(whole.starts_with(&found.out));
    assert_eq!(found.errors, format!("note: `cut.jsonl`: line {lines} is cut off; what stands before it is used\n"));
    assert_eq!(found.status, 2);
    let why = run_in(&run.folder, &["trace", "cut.jsonl", "--why", "breaks"]);
    assert!(why.out.contains("failed at 1.000 s") && why.errors.contains("is cut off"), "{}", why.errors);
    let found = run_in(&run.folder, &["trace", "diff", "run.jsonl", "cut.jsonl"]);
    let said = format!("the same, as far as both can be read: {} events\n", lines - 2);
    assert_eq!((found.out, found.status), (said, 2));
}

#[test]
fn damage_in_the_middle_is_named_with_its_line() {
    let run = recorded("damage");
    let mut lines: Vec<String> = run.trace.lines().map(str::to_string).collect();
    for (damage, reason) in [
        ("nonsense", "line 5 is no JSON object"),
        ("{\"time_s\":0}", "line 5 is no event"),
        ("{\"time_s\":0.0,\"seq\":9,\"task\":\"\",\"kind\":\"dream\"}", "of the kind \"dream\", which is not known"),
    ] {
        lines[4] = damage.to_string();
        run.write("damaged.jsonl", lines.join("\n") + "\n");
        let found = run_in(&run.folder, &["trace", "damaged.jsonl"]);
        assert_eq!((found.out.lines().count(), found.status), (3, 2), "{}", found.out);
        assert!(found.errors.contains(reason), "{reason}: {}", found.errors);
    }
    let mut bytes = run.trace.clone().into_bytes();
    let middle = run.trace.lines().take(5).map(|line| line.len() + 1).sum::<usize>() + 3;
    bytes[middle] = 0xff;
    run.write("bytes.jsonl", bytes);
    assert!(run_in(&run.folder, &["trace", "bytes.jsonl"]).errors.contains("line 6 is not text"));
}

#[test]
fn another_version_is_read_with_a_caution() {
    let run = recorded("version");
    run.write("new.jsonl", run.trace.replacen("\"trace\":1", "\"trace\":7", 1));
    let found = run_in(&run.folder, &["trace", "new.jsonl"]);
    assert_eq!((found.out, found.status), (run.ask(&[]), 0));
    assert!(found.errors.contains("is a trace of version 7, and this rpl knows version 1"), "{}", found.errors);
    let (_, events) = run.trace.split_once('\n').expect("a header and events");
    run.write("old.jsonl", events);
    let found = run_in(&run.folder, &["trace", "old.jsonl"]);
    assert_eq!((found.out, found.status), (run.ask(&[]), 0));
    assert!(found.errors.contains("does not begin with the header of a trace"), "{}", found.errors);
}

#[test]
fn what_is_no_trace_is_refused() {
    let run = recorded("none");
    run.write("empty.jsonl", "");
    run.write("zeros.jsonl", [0; 100]);
    for (file, reason) in [
        ("plan.rpl", "`plan.rpl` is no trace: line 1 is no JSON object"),
        ("empty.jsonl", "the trace `empty.jsonl` is empty"),
        ("zeros.jsonl", "is no trace"),
        ("nowhere.jsonl", "cannot read the trace `nowhere.jsonl`"),
        (".", "cannot read the trace `.`"),
    ] {
        for arguments in
            [&["trace", file][..], &["trace", "diff", file, "run.jsonl"], &["trace", "diff", "run.jsonl", file]]
        {
            let found = run_in(&run.folder, arguments);
            assert!(found.errors.contains(reason), "{file}: {}", found.errors);
            assert_eq!((found.out.as_str(), found.status), ("", 2), "{file}");
        }
    }
}

#[test]
fn a_closed_pipe_ends_quietly() {
    let run = recorded("pipe");
    let (header, events) = run.trace.split_once('\n').expect("a header and events");
    run.write("long.jsonl", format!("{header}\n{}", events.repeat(200)));
    let mut command = rpl(&["trace", "long.jsonl"]);
    command.current_dir(&run.folder).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("it starts");
    drop(child.stdout.take());
    let found = Ended::of(child);
    assert_eq!((found.errors.as_str(), found.status), ("", 0));
}

#[test]
fn a_mission_explains_itself_from_its_trace() {
    let run = recorded("mission");
    let mission = ["run", "delivery.rpl", "--world", "dept", "--scenario", "rotated.rpl", "-q", "--until", "10s"];
    let found = run_in(&run.folder, &[&mission[..], &["--trace", "mission.jsonl"]].concat());
    assert_eq!(found.status, 3, "{}", found.errors);
    let ask = |arguments: &[&str]| run_in(&run.folder, &[&["trace", "mission.jsonl"], arguments].concat());
    let lost = ask(&["--fluent", "position-lost*"]);
    assert!(lost.out.contains("relocalize-when-necessary"), "{}", lost.out);
    let main = ask(&["--why", ""]);
    assert!(main.out.starts_with("main  waits for children\n"), "{}", main.out);
}

/// The commands of a page, each with what is shown below it.
fn commands(page: &str) -> Vec<(String, String)> {
    let (mut commands, mut is_inside): (Vec<(String, String)>, bool) = (Vec::new(), false);
    for line in page.lines() {
        if line.starts_with("```") {
            is_inside = line == "```terminal";
        } else if let Some(command) = line.strip_prefix("$ ").filter(|_| is_inside) {
            commands.push((command.to_string(), String::new()));
        } else if let Some((_, shown)) = commands.last_mut().filter(|_| is_inside) {
            *shown += &format!("{line}\n");
        }
    }
    commands
}

#[test]
fn the_commands_of_the_page_about_traces_run_as_printed() {
    let folder = folder("trace-page");
    let commands = commands(include_str!("../../../docs/trace.md"));
    assert!(commands.len() > 5);
    for (command, shown) in commands {
        let arguments: Vec<&str> = command.strip_prefix("rpl ").expect("it is ours").split(' ').collect();
        let found = run_in(&folder, &arguments);
        assert_eq!(found.out, shown, "{command}: {}", found.errors);
    }
}

#[test]
fn a_name_the_trace_does_not_tell_of_is_an_error_with_a_suggestion() {
    let run = recorded("names");
    for (arguments, said) in [
        (&["--task", "nosuch"][..], "the trace tells of no task or plan call `nosuch`"),
        (&["--task", "main/stuk"], "did you mean `stuck`?"),
        (&["--fluent", "nosuch"], "the trace tells of no fluent `nosuch`"),
        (&["--fluent", "lvel"], "did you mean `level`?"),
        (&["--fluent", "x*"], "`x*` changes in every step"),
        (&["--task", "nosuch", "-n", "3"], "no task or plan call `nosuch`"),
        (&["--fluent", "nosuch", "--to", "1s", "--json"], "no fluent `nosuch`"),
    ] {
        let found = run_in(&run.folder, &[&["trace", "run.jsonl"], arguments].concat());
        assert_eq!((found.out.as_str(), found.status), ("", 2), "{arguments:?}");
        assert!(found.errors.contains(said), "{arguments:?}: {}", found.errors);
    }
    // What comes later is there, and has only nothing to show yet.
    assert_eq!(run.ask(&["--task", "holder", "--to", "0.5s"]), "");
    assert_eq!(run.ask(&["--fluent", "open?", "--to", "0.5s"]), "");
}

/// Pixels of a metre in a drawing of `test-room`: the largest with which 8 m by 6 m fit on a sheet.
const PX_PER_M: f64 = 120.0;

/// The points of all lines of a class in a drawing, in metres from its corner.
fn points(drawing: &str, class: &str) -> Vec<Vec<[f64; 2]>> {
    let tags = drawing.split('<').filter(|tag| tag.starts_with("path") && tag.contains(&format!("class=\"{class}\"")));
    let point = |pair: &str| {
        let numbers: Vec<f64> = pair.split(' ').map(|number| number.parse().expect("a number")).collect();
        [numbers[0] / PX_PER_M, numbers[1] / PX_PER_M]
    };
    let of_tag = |tag: &str| {
        let points = tag.split(" d=\"M").nth(1).and_then(|rest| rest.split('"').next()).expect("points");
        points.split('L').map(point).collect()
    };
    tags.map(of_tag).collect()
}

fn distance_to_path_m(point: [f64; 2], path: &[[f64; 2]]) -> f64 {
    let to_segment = |pair: &[[f64; 2]]| {
        let ([x0, y0], [x1, y1], [x, y]) = (pair[0], pair[1], point);
        let (dx, dy) = (x1 - x0, y1 - y0);
        let length_2 = dx * dx + dy * dy;
        let share = if length_2 > 0.0 { (((x - x0) * dx + (y - y0) * dy) / length_2).clamp(0.0, 1.0) } else { 0.0 };
        (x0 + share * dx - x).hypot(y0 + share * dy - y)
    };
    path.windows(2).map(to_segment).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_run_is_redrawn_from_its_trace() {
    let folder = folder("trace-poses");
    put(&folder, "plan.rpl", "(go-to 'corner)");
    let run = ["run", "plan.rpl", "--world", "test-room", "-q", "--trace"];
    let found = run_in(&folder, &[&run[..], &["run.jsonl", "--trace-poses", "5", "--figures", "of-the-run"]].concat());
    assert_eq!((found.errors.as_str(), found.status), ("", 0));
    let trace = text_in(&folder, "run.jsonl");
    let header = trace.lines().next().expect("a header");
    assert!(header.contains("\"world\":\"test-room\",\"map\":\"world\",\"scenario\":null"), "{header}");
    let times: Vec<f64> = trace
        .lines()
        .filter(|line| line.contains("\"kind\":\"pose\""))
        .map(|line| {
            serde_json::from_str::<serde_json::Value>(line).expect("an object")["time_s"].as_f64().expect("a time")
        })
        .collect();
    assert_eq!(times[0], 0.0, "the start is there");
    let apart = times.windows(2).map(|pair| pair[1] - pair[0]);
    assert!(times.len() > 20 && apart.clone().all(|apart| apart < 0.2001), "{times:?}");
    let found = run_in(&folder, &["trace", "run.jsonl", "--figures", "of-the-trace"]);
    assert_eq!((found.out.as_str(), found.errors.as_str(), found.status), ("", "", 0));
    let drawn = |figures: &str| text_in(&folder.join(figures), "paths.svg");
    let (of_run, of_trace) = (drawn("of-the-run"), drawn("of-the-trace"));
    for class in ["true-path", "estimated-path"] {
        let redrawn = points(&of_trace, class).concat();
        let original = points(&of_run, class).concat();
        assert!(original.len() > 5, "{class}");
        // At 5 a second a robot of 1 m/s is never further than 10 cm from the line between two looks.
        let furthest_m = original.iter().map(|&point| distance_to_path_m(point, &redrawn)).fold(0.0, f64::max);
        assert!(furthest_m < 0.1, "{class}: {furthest_m} m");
        let (first, last) = (original[0], original[original.len() - 1]);
        let ends_m = distance_to_path_m(first, &redrawn[..2]) + distance_to_path_m(last, &redrawn[redrawn.len() - 2..]);
        assert!(ends_m < 0.05, "{class}: {ends_m} m");
    }
    // The poses are no events: the run is the same without them, and reads the same.
    let found = run_in(&folder, &[&run[..], &["without.jsonl"]].concat());
    assert_eq!(found.status, 0, "{}", found.errors);
    let found = run_in(&folder, &["trace", "diff", "run.jsonl", "without.jsonl"]);
    assert!(found.status == 0 && found.out.starts_with("the same: "), "{}", found.out);
    let shown = ["run.jsonl", "without.jsonl"].map(|trace| run_in(&folder, &["trace", trace]).out);
    assert_eq!(shown[0], shown[1]);
    let found = run_in(&folder, &["trace", "without.jsonl", "--figures", "nothing"]);
    assert!(found.status == 2 && found.errors.contains("has no poses"), "{}", found.errors);
    for wrong in [&["--trace-poses", "0"][..], &["--trace-poses", "21"], &["--trace-poses", "often"]] {
        assert_eq!(run_in(&folder, &[&run[..], &["x.jsonl"], wrong].concat()).status, 2, "{wrong:?}");
    }
}

#[test]
fn why_tells_what_foresight_has_decided_about_a_task() {
    let folder = folder("trace-decisions");
    let plan = "(def-plan slow () (wait-time 100) (fail \"too slow\"))
(def-plan quick () (wait-time 10) 'done)
(def-revision quickly (projection plan)
  (when (< (first (projection-success projection)) 0.5))
  (plan-replace '(slow) '(quick) plan)
  \"Does it quickly.\")
(with-foresight (:rules (quickly)) (slow))
";
    put(&folder, "plan.rpl", plan);
    let ran = run_in(&folder, &["run", "plan.rpl", "--trace", "run.jsonl", "-q"]);
    assert_eq!(ran.status, 0, "{}", ran.errors);
    let told = run_in(&folder, &["trace", "run.jsonl", "--why", "main/with-policy[1]"]);
    assert_eq!(told.status, 0, "{}", told.errors);
    // In the order in which it went: what was seen, compared, decided, and done.
    let story = [
        "looks ahead: success is probable to 3 %, by 30 projected runs; most that fail: too slow",
        "with quickly: success is probable to 90 % instead of 10 %, by 8 runs; gain 1.00 ± 0.00: better",
        "takes the plan of quickly",
        "begins another plan, given by main/with-policy[0]",
    ];
    let places = story.map(|what| told.out.find(what).unwrap_or_else(|| panic!("{what}\n{}", told.out)));
    assert!(places.is_sorted(), "{}", told.out);
}
