//! `rpl experiment`: tables, figures, charts, rows.

use crate::folder::{folder, put, text_in};
use crate::rpl::run;
use serde_json::Value;
use std::path::Path;

#[test]
fn an_experiment_makes_a_table_however_many_jobs() {
    let tables = ["1", "4"].map(|jobs| {
        let found = run(&["experiment", "first-steps", "--runs", "6", "--jobs", jobs]);
        assert_eq!(found.status, 0, "{}", found.errors);
        found.out.to_string()
    });
    assert_eq!(tables[0], tables[1]);
    assert!(tables[0].contains("succeeded 6 of 6: 100.0 %"), "{}", tables[0]);
    assert!(tables[0].contains("time [s]     6  90.00    0.00"), "{}", tables[0]);
}

#[test]
fn an_experiment_writes_its_figures_as_json() {
    let folder = folder("experiment-json");
    let text = "(wait-time (random 10.0)) (when (< (now) 5) (fail \"too \\\"soon\\\"\"))";
    let plan = put(&folder, "coin & \"toss\".rpl", text);
    let found = run(&["experiment", &plan, "--runs", "20", "--seed", "3", "--json"]);
    let figures: Value = serde_json::from_str(&found.out).expect("one JSON object");
    assert_eq!(
        (&figures["experiment"], &figures["runs"], &figures["seed"]),
        (&plan.as_str().into(), &20.into(), &3.into())
    );
    let row = &figures["rows"][0];
    let failures = row["failures"].as_array().expect("a list");
    assert_eq!(row["succeeded"]["count"].as_u64().map(|count| count as usize), Some(20 - failures.len()));
    assert!(!failures.is_empty() && failures.len() < 20, "{row}");
    assert_eq!(
        (&row["seeds"], &failures[0]["fault"]),
        (&serde_json::json!([3, 22]), &"plan-failure: too \"soon\"".into())
    );
    let interval = row["succeeded"]["interval_95"].as_array().expect("two numbers");
    let rate = row["succeeded"]["rate"].as_f64().expect("a number");
    assert!(interval[0].as_f64() < Some(rate) && interval[1].as_f64() > Some(rate), "{row}");
    // The same figures as in the table.
    let time = &row["measures"][0];
    let table = run(&["experiment", &plan, "--runs", "20", "--seed", "3"]);
    let number = |key: &str| format!("{:.2}", time[key].as_f64().expect("a number"));
    for key in ["mean", "half_95", "deviation", "min", "median", "max"] {
        assert!(table.out.contains(&number(key)), "{key}\n{}", table.out);
    }
}

#[test]
fn an_experiment_on_a_plan_of_ones_own_draws_charts() {
    let folder = folder("experiment-charts");
    let plan = put(&folder, "a & b.rpl", "(wait-time (random 10.0))");
    let results = folder.join("results");
    let found = run(&["experiment", &plan, "--runs", "3", "--results", &results.to_string_lossy()]);
    assert_eq!(found.status, 0, "{}", found.errors);
    let chart = text_in(&results, "success.svg");
    assert!(chart.contains("<polyline") && chart.contains("a &amp; b"), "{chart}");
    assert_eq!(text_in(&results, "runs.csv").lines().count(), 4);
    // Without a robot there is no estimate that could be off.
    assert!(!results.join("error.svg").exists());
}

/// A plan whose runs differ by their seed, with a variable, a measure of its own, and a failure in some runs.
const DRAW: &str = "(defvar most 6)
(let ((drawn (random most)))
  (wait-time (+ 10 (random 5.0)))
  (measure 'drawn drawn)
  (when (> drawn 4) (measure '|high, really| drawn))
  (if (= drawn 5) (fail \"five\") (list drawn \"a, b\")))";

#[test]
fn what_a_plan_measures_and_returns_is_a_column_of_every_run() {
    let folder = folder("experiment-measures");
    let plan = put(&folder, "draw.rpl", DRAW);
    let results = folder.join("results");
    let found = run(&["experiment", &plan, "--runs", "20", "--results", &results.to_string_lossy()]);
    assert_eq!(found.status, 1, "{}", found.errors);
    assert!(found.out.contains("drawn        "), "{}", found.out);
    let runs = text_in(&results, "runs.csv");
    let lines: Vec<&str> = runs.lines().collect();
    assert_eq!(lines[0], "row,seed,succeeded,fault,value,time [s],drawn,\"high, really\"");
    // A column that comes up late is empty in the runs before.
    assert!(lines[1].ends_with(','), "{}", lines[1]);
    assert!(
        lines.iter().any(|line| line.contains("false,\"plan-failure: five\",\"\",") && line.ends_with(",5,5")),
        "{runs}"
    );
    assert!(lines.iter().any(|line| line.contains("true,\"\",\"(3 \"\"a, b\"\")\",")), "{runs}");
    assert!(!results.join(".runs.csv.new").exists());
}

#[test]
fn variants_are_compared_seed_by_seed() {
    let folder = folder("experiment-variants");
    let plan = put(&folder, "draw.rpl", "(defvar far 0) (wait-time (+ far (random 100.0))) (measure 'far far)");
    let vary = ["experiment", &plan, "--runs", "12", "--vary", "far=10,30,(+ 10 5)"];
    let found = run(&vary);
    assert_eq!(found.status, 0, "{}", found.errors);
    assert!(found.out.contains("far=10: 12 runs, seeds 1 to 12"), "{}", found.out);
    // Chance is the same with the same seed: the variable alone makes the difference, and it has no spread.
    let beside = found.out.split("far=30 beside far=10, seed by seed").nth(1).expect("a comparison");
    assert!(beside.contains("succeeded     12      +0.0 %"), "{beside}");
    assert!(beside.contains("time [s]      12      +20.00  +20.00 to +20.00"), "{beside}");
    assert!(found.out.contains("far=(+ 10 5) beside far=10"), "{}", found.out);
    // What is kept for the comparison has a limit, which one variant alone does not have.
    let many = run(&["experiment", &plan, "--runs", "400000", "--vary", "far=1,2,3"]);
    assert!(many.status == 2 && many.errors.contains("have 1200000 runs together"), "{}", many.errors);
    // One variant, and an unknown one.
    let row = run(&[&vary[..], &["--row", "far=30"]].concat());
    assert!(row.out.contains("far=30: 12 runs") && !row.out.contains("beside"), "{}", row.out);
    let unknown = run(&[&vary[..], &["--row", "far=31"]].concat());
    assert!(unknown.errors.contains("has no row `far=31`; did you mean `far=30`?"), "{}", unknown.errors);
    // Shards make the same table.
    let parts = ["1", "2"].map(|shard| {
        let part = folder.join(format!("{shard}.part")).to_string_lossy().into_owned();
        let written = run(&[&vary[..], &["--shard", &format!("{shard}/2"), "--out", &part]].concat());
        assert_eq!(written.status, 0, "{}", written.errors);
        part
    });
    let merged = run(&["experiment", "merge", &parts[0], &parts[1]]);
    assert_eq!((merged.status, &merged.out), (0, &found.out));
}

#[test]
fn an_experiment_file_has_variants_with_plans_of_their_own() {
    let folder = folder("experiment-file");
    put(&folder, "slow.rpl", "(defvar pause 10) (wait-time pause)");
    put(&folder, "fast.rpl", "(wait-time 4)");
    let text = "plan = \"slow.rpl\"\nruns = 3\nseed = 7\nuntil = \"1min\"\n[[variant]]\nname = \"slow\"\n\
                set = { pause = 12 }\n[[variant]]\nname = \"fast\"\nplan = \"fast.rpl\"\n";
    let file = put(&folder, "compare.toml", text);
    let found = run(&["experiment", &file, "--json"]);
    assert_eq!(found.status, 0, "{}", found.errors);
    let figures: Value = serde_json::from_str(&found.out).expect("one JSON object");
    assert_eq!(figures["rows"][0]["seeds"], serde_json::json!([7, 9]));
    let paired = &figures["paired"][0];
    assert_eq!((&paired["name"], &paired["against"]), (&"fast".into(), &"slow".into()));
    assert_eq!((&paired["measures"][0]["name"], &paired["measures"][0]["mean"]), (&"time [s]".into(), &(-8.0).into()));
    let figures = folder.join("figures").to_string_lossy().into_owned();
    assert_eq!(run(&["experiment", &file, "--results", &figures]).status, 0);
    let chart = std::fs::read_to_string(folder.join("figures/differences.svg")).expect("it is drawn");
    assert!(chart.contains("Difference from `slow`") && chart.contains("time [s]"), "{chart}");
    let many: String = (0..100_000).map(|at| format!("[[variant]]\nname = \"{at}\"\n")).collect();
    for (wrong, told) in [
        (format!("plan = \"slow.rpl\"\n{many}"), "there are 100000 variants"),
        (text.replace("runs", "rums"), "there is no key `rums`"),
        (format!("vary = {{ pause = [1, 2] }}\n{text}"), "each value is a variant: `[[variant]]`"),
        (format!("seeds = 5\n{text}"), "`runs = 20` makes 20 runs"),
        (text.replace("1min", "soon"), "until = \"soon\": a time such as 90s"),
        (text.replace("\"fast\"\nplan", "\"slow\"\nplan"), "two variants are called `slow`"),
        (text.replace("pause", "pauze"), "the plan has no variable `pauze` to set; did you mean `pause`?"),
    ] {
        let file = put(&folder, "wrong.toml", &wrong);
        let found = run(&["experiment", &file]);
        assert_eq!(found.status, 2, "{}", found.errors);
        assert!(found.errors.contains(told), "{}", found.errors);
    }
}

#[test]
fn a_row_that_is_not_there_is_told_with_those_that_are() {
    for (experiment, row, meant) in
        [("rotated", "undisturbd", "undisturbed"), ("barn", "seen so fer", "seen so far"), ("worlds", "rign", "ring")]
    {
        let found = run(&["experiment", experiment, "--row", row, "--runs", "1"]);
        assert!(found.errors.contains(&format!("did you mean `{meant}`?")), "{}", found.errors);
        assert_eq!(found.status, 2);
    }
    let found = run(&["experiment", "first-steps", "--row", "rotated"]);
    assert!(found.errors.contains("a plan of your own has one row"), "{}", found.errors);
    assert_eq!(found.status, 2);
}

#[test]
fn a_door_closed_on_the_way_holds_a_delivery_up_and_no_more() {
    let found = run(&["experiment", "doors", "--row", "flat", "--runs", "1", "--seed", "9001"]);
    assert_eq!(found.status, 0, "{}{}", found.out, found.errors);
    assert!(found.out.lines().any(|line| line.starts_with("flat ") && line.contains(" 1/1 ")), "{}", found.out);
    let unknown = run(&["experiment", "doors", "--row", "flt"]);
    assert!(unknown.errors.contains("the experiment `doors` has no row `flt`; did you mean `flat`?"));
}

#[test]
fn buildings_are_driven_in_however_many_jobs() {
    let folder = folder("experiment-buildings");
    let results = folder.join("results").to_string_lossy().into_owned();
    let of = |jobs: &str| {
        let row = ["experiment", "buildings", "--row", "flats/turned", "--runs", "2", "--seed", "700001"];
        run(&[&row[..], &["--until", "3min", "--jobs", jobs, "--results", &results]].concat())
    };
    let found = of("1");
    assert_eq!(found.status, 0, "{}{}", found.out, found.errors);
    assert_eq!(found.out, of("2").out);
    assert!(found.out.lines().any(|line| line.starts_with("flats/turned ") && line.contains("/2 ")), "{}", found.out);
    assert!(found.out.lines().take_while(|line| !line.starts_with("arrived: ")).all(|line| line.chars().count() <= 80));
    let runs = text_in(&folder.join("results"), "runs.csv");
    assert_eq!(runs.lines().filter(|line| line.starts_with("\"flats/turned\",70000")).count(), 2, "{runs}");
}

#[test]
fn a_row_of_buildings_is_a_kind_or_a_disturbance_or_both() {
    let unknown = run(&["experiment", "buildings", "--row", "flats/turnd"]);
    assert_eq!(unknown.status, 2);
    assert!(unknown.errors.contains("did you mean `flats/turned`?"), "{}", unknown.errors);
    let doorless = run(&["experiment", "buildings", "--row", "halls/doors"]);
    assert!(doorless.errors.contains("has no row `halls/doors`"), "{}", doorless.errors);
}

#[test]
fn buildings_on_recorded_maps_are_rows_of_their_own() {
    let folder = folder("experiment-maps");
    let maps = folder.to_string_lossy().into_owned();
    let empty = run(&["experiment", "buildings", "--maps", &maps]);
    assert_eq!(empty.status, 2);
    assert!(empty.errors.contains("there is no map below"), "{}", empty.errors);
    let absent = run(&["experiment", "buildings", "--maps", &folder.join("absent").to_string_lossy()]);
    assert!(absent.status == 2 && absent.errors.contains("cannot read the folder"), "{}", absent.errors);
    let elsewhere = run(&["experiment", "worlds", "--maps", &maps]);
    assert!(elsewhere.errors.contains("`--maps` is for `buildings`"), "{}", elsewhere.errors);
    put_map(&folder.join("cellar"), "map.yaml");
    put_map(&folder, "attic.yaml");
    let found = run(&["experiment", "buildings", "--maps", &maps, "--runs", "1", "--until", "20s", "--row", "none"]);
    assert_eq!(found.status, 0, "{}{}", found.out, found.errors);
    for name in ["attic ", "cellar "] {
        assert!(found.out.lines().any(|line| line.starts_with(name)), "{}", found.out);
    }
}

/// A map of a room of 12 by 10 m with a wall that half divides it.
fn put_map(folder: &Path, yaml: &str) {
    std::fs::create_dir_all(folder).expect("the folder can be made");
    let (columns, rows) = (120, 100);
    let mut image = format!("P5\n{columns} {rows}\n255\n").into_bytes();
    for row in 0..rows {
        for column in 0..columns {
            let is_wall = row < 2 || row >= rows - 2 || column < 2 || column >= columns - 2;
            let divides = (68..71).contains(&column) && row < 60;
            image.push(if is_wall || divides { 0 } else { 254 });
        }
    }
    put(folder, "floor.pgm", image);
    let text = "image: floor.pgm\nresolution: 0.1\norigin: [0.0, 0.0, 0.0]\nnegate: 0\noccupied_thresh: 0.65\n\
                free_thresh: 0.196\n";
    put(folder, yaml, text);
}
