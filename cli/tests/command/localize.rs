//! `rpl localize` and worlds from recorded maps, on a small drive that is made here.

use crate::folder::{folder, put, text_in};
use crate::keys;
use crate::rpl::run_in;
use flate2::Compression;
use flate2::write::GzEncoder;
use serde_json::Value;
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

const WIDTH: usize = 60;
const HEIGHT: usize = 40;
const CELL_M: f64 = 0.1;

/// A room of 6 m by 4 m with a niche and a pillar.
fn is_wall(column: usize, row: usize) -> bool {
    let edge = column == 0 || row == 0 || column == WIDTH - 1 || row == HEIGHT - 1;
    edge || (column > 45 && row < 10) || ((15..19).contains(&column) && (18..24).contains(&row))
}

/// The distance to a wall, in steps of a centimetre.
pub fn range_m(x_m: f64, y_m: f64, angle_rad: f64) -> f64 {
    let mut range_m = 0.0;
    let wall_at = |range_m: f64| {
        let (x, y) = (x_m + range_m * angle_rad.cos(), y_m + range_m * angle_rad.sin());
        is_wall((x / CELL_M) as usize, (y / CELL_M) as usize)
    };
    while !wall_at(range_m) {
        range_m += 0.01;
    }
    range_m
}

/// Rounds of 7 m around the pillar.
fn log() -> String {
    let mut text = String::new();
    for step in 0..140 {
        let turn = TAU * f64::from(step) / 70.0;
        let (x_m, y_m) = (2.6 + 1.8 * turn.cos(), 2.1 + 0.9 * turn.sin());
        let heading_rad = (0.9 * turn.cos()).atan2(-1.8 * turn.sin());
        text += "FLASER 61";
        for reading in 0..61 {
            let bearing_rad = (f64::from(reading) * 3.0 - 90.0).to_radians();
            text += &format!(" {:.2}", range_m(x_m, y_m, heading_rad + bearing_rad));
        }
        // Odometry has another origin, and no drift.
        text += &format!(" {x_m:.4} {y_m:.4} {heading_rad:.4} {:.4} {:.4} {heading_rad:.4}", x_m + 40.0, y_m - 7.0);
        text += &format!(" {step}.0 robot {step}.0\n");
    }
    text
}

/// A folder with a map and a log.
fn folder_of_drive(name: &str) -> PathBuf {
    let folder = folder(name);
    put_room(&folder);
    put(&folder, "drive.log", log());
    folder
}

/// Writes the map of the room into a folder.
pub fn put_room(folder: &Path) {
    let mut image = format!("P5\n# a room\n{WIDTH} {HEIGHT}\n255\n").into_bytes();
    for row in (0..HEIGHT).rev() {
        image.extend((0..WIDTH).map(|column| if is_wall(column, row) { 0 } else { 254 }));
    }
    put(folder, "room.pgm", image);
    let yaml = "image: room.pgm\nresolution: 0.1\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n\
                occupied_thresh: 0.65\nfree_thresh: 0.196\n";
    put(folder, "map.yaml", yaml);
}

const DRIVE: [&str; 5] = ["localize", "--map", ".", "--log", "drive.log"];

#[test]
fn a_recorded_drive_is_found_fitted_and_drawn() {
    let folder = folder_of_drive("localize");
    let fit = run_in(&folder, &[&DRIVE[..], &["--fit", "laser.json"]].concat());
    assert_eq!(fit.status, 0, "{}", fit.errors);
    assert!(fit.out.contains("depth of walls"), "{}", fit.out);
    let windows = ["--windows", "2", "--window-length", "5", "--phases", "2", "--json"];
    let all = [&DRIVE[..], &windows, &["--parameters", "laser.json", "--figures", "figures"]].concat();
    let found = run_in(&folder, &all);
    assert_eq!(found.status, 0, "{}", found.errors);
    let results: Value = serde_json::from_str(&found.out).expect("JSON");
    assert_eq!((&results["found"]["count"], &results["found"]["of"]), (&4.into(), &4.into()));
    let starts: Vec<[Option<f64>; 2]> = results["windows"]
        .as_array()
        .expect("windows")
        .iter()
        .map(|window| ["phase", "start_m"].map(|key| window[key].as_f64()))
        .collect();
    assert_eq!(starts.iter().map(|start| start[0]).collect::<Vec<_>>(), [0.5, 0.5, 0.0, 0.0].map(Some));
    assert_eq!(starts[2][1], Some(0.0));
    // The rows go where they are no part of the JSON.
    assert_eq!(found.errors.lines().filter(|line| line.contains(" yes ")).count(), 4, "{}", found.errors);
    assert!(results["while_found"]["position_m"]["mean"].as_f64().is_some_and(|mean_m| mean_m < 0.1), "{results}");
    // With few beams there are scans after which the filter is not sure, and so there are bins of these.
    let unsure = run_in(&folder, &[&all[..], &["--beams", "3"]].concat());
    let unsure: Value = serde_json::from_str(&unsure.out).expect("JSON");
    let found: BTreeSet<String> = keys::found(&results).into_iter().chain(keys::found(&unsure)).collect();
    assert_eq!(found, keys::documented("rpl localize"));
    for (name, part) in [
        ("paths.svg", "true-path"),
        ("errors.svg", "heading off [°]"),
        ("certainty.svg", "How often the position is right"),
    ] {
        let drawing = text_in(&folder.join("figures"), name);
        assert!(drawing.contains(part), "{name}");
    }
    let kept = run_in(&folder, &[&DRIVE[..], &["--from-truth"]].concat());
    assert!(kept.out.contains("kept 1 of 1"), "{}", kept.out);
    assert!(kept.out.contains("certainty of 0.9 and above: "), "{}", kept.out);
}

#[test]
fn a_log_may_be_packed_and_begin_at_the_left() {
    let folder = folder_of_drive("localize-packed");
    let pack = |text: &str| {
        let mut packed = GzEncoder::new(Vec::new(), Compression::default());
        packed.write_all(text.as_bytes()).expect("it is in memory");
        packed.finish().expect("it is in memory")
    };
    let plain = log();
    put(&folder, "drive.log.gz", pack(&plain));
    let mirrored = plain.lines().map(|line| {
        let mut fields: Vec<&str> = line.split(' ').collect();
        fields[2..63].reverse();
        fields.join(" ") + "\n"
    });
    put(&folder, "left.log.gz", pack(&mirrored.collect::<String>()));
    let tracked = |name: &str, more: &[&str]| {
        let found = run_in(&folder, &[&["localize", "--map", ".", "--log", name, "--from-truth"], more].concat());
        assert_eq!(found.status, 0, "{name} {}{}", found.out, found.errors);
        let without_time = |line: &str| line.rsplit_once(' ').map_or(String::new(), |(cells, _)| cells.to_string());
        found.out.lines().map(without_time).collect::<Vec<_>>()
    };
    let told = tracked("drive.log", &[]);
    assert_eq!(tracked("drive.log.gz", &[]), told);
    assert_eq!(tracked("left.log.gz", &["--first-reading", "left"]), told);
    let cut = pack(&log());
    put(&folder, "cut.log.gz", &cut[..cut.len() / 2]);
    let damaged = run_in(&folder, &["localize", "--map", ".", "--log", "cut.log.gz"]);
    assert_eq!(damaged.status, 2);
    assert!(
        damaged.errors.contains("cannot read the log `cut.log.gz`: it is packed by gzip, and damaged"),
        "{}",
        damaged.errors
    );
}

#[test]
fn what_is_wrong_with_a_recording_is_told_and_nothing_is_written() {
    let folder = folder_of_drive("localize-faults");
    let long = log();
    let cut = &long[..long.len() - 200];
    put(&folder, "cut.log", cut);
    put(&folder, "nan.log", long.replacen(" 2.", " nan 2.", 1));
    let yaml = text_in(&folder, "map.yaml");
    let write = |name: &str, from: &str, to: &str| {
        put(&folder, name, yaml.replace(from, to));
    };
    write("elsewhere.yaml", "[0.0, 0.0", "[90.0, 0.0");
    write("zero.yaml", "0.1", "0");
    write("lost.yaml", "room.pgm", "no.pgm");
    write("short.yaml", "room.pgm", "short.pgm");
    let image = fs::read(folder.join("room.pgm")).expect("the image is there");
    put(&folder, "short.pgm", &image[..900]);
    let change = |at: usize, what: &'static str| {
        let mut arguments = DRIVE;
        arguments[at] = what;
        arguments.to_vec()
    };
    for (arguments, part) in [
        (change(4, "no.log"), "cannot read the log `no.log`: there is no such file"),
        (change(4, "cut.log"), "the log `cut.log` has a fault: line 140: the FLASER line ends before"),
        (change(4, "nan.log"), "reading"),
        (change(4, "map.yaml"), "no laser scan in it"),
        (change(2, "no.yaml"), "cannot read the map `no.yaml`: there is no such file"),
        (
            change(2, "elsewhere.yaml"),
            "the log `drive.log` does not belong to the map `elsewhere.yaml`: 140 of its 140",
        ),
        (change(2, "zero.yaml"), "`resolution` must be a length above 0 m, found 0"),
        (change(2, "lost.yaml"), "no.pgm`, the image of the map `lost.yaml`: there is no such file"),
        (change(2, "short.yaml"), "truncated"),
        ([&DRIVE[..], &["--beams", "0"]].concat(), "at least one beam is needed"),
        ([&DRIVE[..], &["--beams", "500"]].concat(), "500 beams are more than the scan has"),
        ([&DRIVE[..], &["--memory", "0.001"]].concat(), "more than the 0.0 GiB of --memory"),
        ([&DRIVE[..], &["--window-length", "100"]].concat(), "a window of 100 m does not fit into a path of"),
        (
            [&DRIVE[..], &["--from-truth", "--phases", "2"]].concat(),
            "with --from-truth there is one window, the whole drive; `--phases` needs `--windows`",
        ),
        ([&DRIVE[..], &["--parameters", "room.pgm"]].concat(), "cannot read the parameters `room.pgm`"),
        ([&DRIVE[..], &["--parameters", "map.yaml"]].concat(), "`map.yaml` is no file of parameters"),
    ] {
        let found = run_in(&folder, &[&arguments[..], &["--figures", "figures"]].concat());
        assert_eq!(found.status, 2, "{arguments:?}\n{}", found.errors);
        assert!(found.errors.contains(part), "{}\nshould say: {part}", found.errors);
        assert!(!folder.join("figures").exists(), "{arguments:?}");
    }
}

#[test]
fn a_recorded_map_is_a_world() {
    let folder = folder_of_drive("recorded-world");
    let shown = run_in(&folder, &["worlds", "map.yaml", "--png", "map.png"]);
    assert!(shown.out.starts_with("map: 6.0 m by 4.0 m"), "{}{}", shown.out, shown.errors);
    assert!(fs::read(folder.join("map.png")).is_ok_and(|bytes| bytes.starts_with(b"\x89PNG")));
    let toml = "name = \"lab\"\nmap = \"map.yaml\"\nstart = [1.0, 1.0, 0.0]\n";
    put(&folder, "lab.toml", toml);
    for world in [".", "map.yaml", "lab.toml"] {
        let shown = run_in(&folder, &["worlds", world]);
        assert_eq!(shown.status, 0, "{world}: {}", shown.errors);
    }
    let trap = text_in(&folder, "map.yaml").replace("0.196", "0.25");
    put(&folder, "trap.yaml", trap.replace("room.pgm", "grey.pgm"));
    fs::write(folder.join("grey.pgm"), [&b"P5 10 10 255\n"[..], &[254; 50], &[205; 50]].concat()).expect("an image");
    let shown = run_in(&folder, &["worlds", "trap.yaml"]);
    assert!(shown.errors.contains("warning: trap.yaml: 50 pixels have the grey 205"), "{}", shown.errors);
}
