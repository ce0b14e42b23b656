//! `rpl localize` and worlds from recorded maps, on a small drive that is made here.

mod keys;

use serde_json::Value;
use std::f64::consts::TAU;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

const WIDTH: usize = 60;
const HEIGHT: usize = 40;
const CELL_M: f64 = 0.1;

/// A room of 6 m by 4 m with a niche and a pillar.
fn is_wall(column: usize, row: usize) -> bool {
    let edge = column == 0 || row == 0 || column == WIDTH - 1 || row == HEIGHT - 1;
    edge || (column > 45 && row < 10) || ((15..19).contains(&column) && (18..24).contains(&row))
}

/// The distance to a wall, in steps of a centimetre.
fn range_m(x_m: f64, y_m: f64, angle_rad: f64) -> f64 {
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

/// A folder of this test's own with a map and a log.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).expect("the folder can be made");
    let mut image = format!("P5\n# a room\n{WIDTH} {HEIGHT}\n255\n").into_bytes();
    for row in (0..HEIGHT).rev() {
        image.extend((0..WIDTH).map(|column| if is_wall(column, row) { 0 } else { 254 }));
    }
    fs::write(folder.join("room.pgm"), image).expect("the image can be written");
    let yaml = "image: room.pgm\nresolution: 0.1\norigin: [0.0, 0.0, 0.0]\nnegate: 0\n\
                occupied_thresh: 0.65\nfree_thresh: 0.196\n";
    fs::write(folder.join("map.yaml"), yaml).expect("the map can be written");
    fs::write(folder.join("drive.log"), log()).expect("the log can be written");
    folder
}

fn rpl(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_rpl")).current_dir(folder).args(arguments).output().expect("the command runs")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

const DRIVE: [&str; 5] = ["localize", "--map", ".", "--log", "drive.log"];

#[test]
fn a_recorded_drive_is_found_fitted_and_drawn() {
    let folder = folder("localize");
    // The drawings of an earlier run may not be there.
    fs::remove_dir_all(folder.join("figures")).ok();
    let fit = rpl(&folder, &[&DRIVE[..], &["--fit", "laser.json"]].concat());
    assert!(fit.status.success(), "{}", text(&fit.stderr));
    assert!(text(&fit.stdout).contains("depth of walls"), "{}", text(&fit.stdout));
    let windows = ["--windows", "2", "--window-length", "5", "--json"];
    let all = [&DRIVE[..], &windows, &["--parameters", "laser.json", "--figures", "figures"]].concat();
    let found = rpl(&folder, &all);
    assert!(found.status.success(), "{}", text(&found.stderr));
    let results: Value = serde_json::from_slice(&found.stdout).expect("JSON");
    assert_eq!((&results["found"], &results["of"]), (&2.into(), &2.into()));
    assert!(results["while_found"]["position_m"]["mean"].as_f64().is_some_and(|mean_m| mean_m < 0.1), "{results}");
    assert_eq!(keys::found(&results), keys::documented("rpl localize"));
    for (name, part) in [("paths.svg", "true-path"), ("errors.svg", "error of the heading")] {
        let drawing = fs::read_to_string(folder.join("figures").join(name)).expect("it was drawn");
        assert!(drawing.contains(part), "{name}");
    }
    let kept = rpl(&folder, &[&DRIVE[..], &["--from-truth"]].concat());
    assert!(text(&kept.stdout).contains("kept 1 of 1"), "{}", text(&kept.stdout));
}

#[test]
fn what_is_wrong_with_a_recording_is_told_and_nothing_is_written() {
    let folder = folder("localize-faults");
    // Nor may those of an earlier run.
    fs::remove_dir_all(folder.join("figures")).ok();
    let long = log();
    let cut = &long[..long.len() - 200];
    fs::write(folder.join("cut.log"), cut).expect("the log can be written");
    fs::write(folder.join("nan.log"), long.replacen(" 2.", " nan 2.", 1)).expect("the log can be written");
    let yaml = fs::read_to_string(folder.join("map.yaml")).expect("the map is there");
    let write = |name: &str, from: &str, to: &str| {
        fs::write(folder.join(name), yaml.replace(from, to)).expect("the map can be written");
    };
    write("elsewhere.yaml", "[0.0, 0.0", "[90.0, 0.0");
    write("zero.yaml", "0.1", "0");
    write("lost.yaml", "room.pgm", "no.pgm");
    write("short.yaml", "room.pgm", "short.pgm");
    let image = fs::read(folder.join("room.pgm")).expect("the image is there");
    fs::write(folder.join("short.pgm"), &image[..900]).expect("the image can be written");
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
        ([&DRIVE[..], &["--parameters", "room.pgm"]].concat(), "cannot read the parameters `room.pgm`"),
        ([&DRIVE[..], &["--parameters", "map.yaml"]].concat(), "`map.yaml` is no file of parameters"),
    ] {
        let output = rpl(&folder, &[&arguments[..], &["--figures", "figures"]].concat());
        let errors = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}\n{errors}");
        assert!(errors.contains(part), "{errors}\nshould say: {part}");
        assert!(!errors.contains("panicked"), "{errors}");
        assert!(!folder.join("figures").exists(), "{arguments:?}");
    }
}

#[test]
fn a_recorded_map_is_a_world() {
    let folder = folder("recorded-world");
    let shown = rpl(&folder, &["worlds", "map.yaml", "--png", "map.png"]);
    assert!(text(&shown.stdout).starts_with("map: 6.0 m by 4.0 m"), "{}{}", text(&shown.stdout), text(&shown.stderr));
    assert!(fs::read(folder.join("map.png")).is_ok_and(|bytes| bytes.starts_with(b"\x89PNG")));
    let toml = "name = \"lab\"\nmap = \"map.yaml\"\nstart = [1.0, 1.0, 0.0]\n";
    fs::write(folder.join("lab.toml"), toml).expect("the world can be written");
    for world in [".", "map.yaml", "lab.toml"] {
        let shown = rpl(&folder, &["worlds", world]);
        assert!(shown.status.success(), "{world}: {}", text(&shown.stderr));
    }
    let trap = fs::read_to_string(folder.join("map.yaml")).expect("the map is there").replace("0.196", "0.25");
    fs::write(folder.join("trap.yaml"), trap.replace("room.pgm", "grey.pgm")).expect("the map can be written");
    fs::write(folder.join("grey.pgm"), [&b"P5 10 10 255\n"[..], &[254; 50], &[205; 50]].concat()).expect("an image");
    let shown = rpl(&folder, &["worlds", "trap.yaml"]);
    assert!(text(&shown.stderr).contains("warning: trap.yaml: 50 pixels have the grey 205"), "{}", text(&shown.stderr));
}
