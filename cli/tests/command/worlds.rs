//! Worlds and maps as a user hands them in, and forged inputs, a few of each kind; `cargo run -p
//! rpl-tests --example forged` tries many.

use crate::folder::{folder, put};
use crate::rpl::{Ended, run_in};
use rpl_tests::forger::{Case, judge::judge};
use std::path::Path;

/// Runs a command line of words.
fn rpl(folder: &Path, line: &str) -> Ended {
    run_in(folder, &line.split_whitespace().collect::<Vec<_>>())
}

const LAB: &str = "name = \"lab\"\nsize = [6.0, 4.0]\nstart = [1.0, 2.0, 0]\n\
    [[wall]]\nline = [[0, 0], [6, 0], [6, 4], [0, 4], [0, 0]]\n\
    [[object]]\nname = \"stove\"\nrect = [3, 1, 4, 3]\n\
    [[place]]\nname = \"Stove\"\npose = [3.5, 2.0, 0]\n";

#[test]
fn what_is_wrong_with_a_place_is_told_in_its_line_and_when_it_is_gone_to() {
    let folder = folder("places");
    put(&folder, "lab.toml", LAB);
    let Ended { out: shown, errors: told, status } = rpl(&folder, "worlds lab.toml");
    assert_eq!((status, shown.starts_with("lab: 6.0 m by 4.0 m")), (0, true), "{told}");
    let why = "at (3.50, 2.00) the robot does not fit: that is inside the object `stove`";
    let place = "warning: lab.toml:11:8: the robot cannot get from the start to the place `Stove`: ";
    assert!(told.starts_with(&format!("{place}{why}\n  11 | pose = [3.5, 2.0, 0]\n")), "{told}");
    put(&folder, "go.rpl", "(go-to 'Stove)");
    let Ended { errors: told, status, .. } = rpl(&folder, "run go.rpl --world lab.toml --grid coarse");
    assert!(status == 1 && told.contains(&format!("unreachable: no way to `Stove`: {why}")), "{told}");
    let Ended { errors: told, status, .. } = rpl(&folder, "worlds flat");
    assert_eq!((status, told.as_str()), (0, ""));
}

#[test]
fn a_world_that_is_too_large_says_so_with_what_it_takes() {
    let folder = folder("large");
    let sized = |size: &str| format!("name = \"field\"\nsize = [{size}, {size}]\nstart = [1.0, 1.0, 0]\n");
    put(&folder, "large.toml", sized("600"));
    put(&folder, "plan.rpl", "(print 1)");
    let Ended { out: shown, errors: told, status } = rpl(&folder, "run plan.rpl --world large.toml");
    assert_eq!((status, shown.as_str()), (2, ""));
    for part in [
        "of 600 m by 600 m is too large",
        " GiB of memory, and 12 s before the first step",
        "crop it",
        "--grid coarse",
        "--map none",
    ] {
        assert!(told.contains(part), "{told}\nshould say: {part}");
    }
    assert_eq!(rpl(&folder, "run plan.rpl --world large.toml --map none").out, "1\n");
    let Ended { out: shown, errors: told, status } = rpl(&folder, "worlds large.toml");
    assert!(status == 0 && shown.starts_with("field: 600.0 m") && told.contains("too large"), "{told}");
    let Ended { out: shown, errors: told, status } = rpl(&folder, "worlds large.toml --map large");
    assert!(status == 2 && shown.is_empty() && told.contains("144 million pixels"), "{told}");
}

#[test]
fn a_map_says_how_its_greys_are_read() {
    let folder = folder("greys");
    let pixel =
        |index: usize| if index % 100 < 2 || index < 200 || index % 100 > 97 || index > 7_799 { 100 } else { 254 };
    let image: Vec<u8> = b"P5 100 80 255\n".iter().copied().chain((0..8_000).map(pixel)).collect();
    put(&folder, "map.pgm", image);
    let yaml =
        "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
    put(&folder, "map.yaml", yaml);
    let Ended { out: shown, errors: told, status } = rpl(&folder, "worlds map.yaml");
    assert!(shown.contains("map     100 by 80 cells of 0.05 m: 91.2 % free, 0.0 % occupied, 8.8 % unknown"), "{shown}");
    assert!(status == 0 && told.contains("warning: map.yaml: nothing in the map is occupied"), "{told}");
    assert!(told.contains("write `occupied_thresh: 0.4` (91.2 % free"), "{told}");
    put(&folder, "map.yaml", yaml.replace("0.65", "0.4"));
    assert_eq!(rpl(&folder, "worlds map.yaml").errors, "");
}

#[test]
fn forged_inputs_are_refused_in_words_or_used() {
    let folder = folder("forged");
    let mut refused = 0;
    for seed in 0..50 {
        let case = Case::new(seed);
        match judge(&case, Path::new(env!("CARGO_BIN_EXE_rpl")), &folder) {
            Ok(output) => refused += usize::from(output.status.code() == Some(2)),
            Err(finding) => panic!("seed {seed}, {}: rpl {:?}\n{finding}", case.kind, case.arguments),
        }
    }
    assert!(refused > 20, "{refused} of 50 were refused");
}

#[test]
fn an_arena_is_drawn_from_the_seed_and_its_file_is_the_same_building() {
    let folder = folder("arena");
    let Ended { out: shown, errors: told, status } = rpl(&folder, "worlds arena --seed 2 --toml two.toml");
    assert_eq!((status, told.as_str()), (0, ""));
    let (building, way) = shown.rsplit_once("the way from `start` into `goal`: ").expect("the way is told");
    let file = rpl(&folder, "worlds two.toml");
    assert_eq!((file.status, file.out.as_str()), (0, building));
    let book = include_str!("../../../docs/instructions.md");
    let told_twice = book.matches(way.trim()).count();
    assert_eq!(told_twice, 2, "docs/instructions.md tells another way than {way}");

    put(&folder, "drive.rpl", "(with-valve wheels (run-behaviour goal-seek :to '(0.2 0)))");
    let drive =
        |line: &str| rpl(&folder, &format!("run drive.rpl --map none --seed 2 {line} --trace t --trace-poses 1"));
    let traced = || {
        let text = std::fs::read_to_string(folder.join("t")).expect("there is a trace");
        text.lines().skip(1).map(str::to_string).collect::<Vec<String>>()
    };
    drive("--world arena");
    let drawn = traced();
    drive("--world two.toml");
    assert!(drawn.len() > 10 && drawn == traced());

    assert_ne!(rpl(&folder, "worlds arena --seed 3").out, shown);
    let refused = rpl(&folder, "experiment rotated --world arena --runs 1");
    assert!(
        refused.status == 2 && refused.errors.contains("`arena` is another world for each seed"),
        "{}",
        refused.errors
    );
    let suggested = rpl(&folder, "worlds arenas").errors;
    assert!(suggested.contains("did you mean `arena`?"), "{suggested}");
}

/// A map of `cells` cells along each side, 5 mm each, in a folder of the test's own.
#[cfg(target_os = "linux")]
fn map_of(name: &str, cells: usize, is_occupied: impl Fn(usize, usize) -> bool) -> std::path::PathBuf {
    let folder = folder(name);
    let yaml =
        "image: map.pgm\nresolution: 0.005\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";
    put(&folder, "map.yaml", yaml);
    let mut image = format!("P5 {cells} {cells} 255\n").into_bytes();
    image.extend((0..cells * cells).map(|at| if is_occupied(at % cells, at / cells) { 0 } else { 255 }));
    put(&folder, "map.pgm", image);
    folder
}

#[cfg(target_os = "linux")]
#[test]
fn a_map_takes_little_memory_for_each_pixel() {
    // Nine million pixels, and memory for 16 bytes of each: that of the rest is there too.
    let folder = map_of("worlds-map-memory", 3000, |_, _| false);
    let limited = format!("ulimit -d {}; exec \"$0\" worlds map.yaml", 9_000_000 * 16 / 1024);
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &limited, env!("CARGO_BIN_EXE_rpl")]).env("RAYON_NUM_THREADS", "1").current_dir(&folder);
    let output = shell.output().expect("it starts");
    let (out, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success() && out.contains("3000 by 3000 cells"), "{out}{errors}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_map_of_noise_is_refused_before_it_becomes_bodies() {
    let is_room = |column: usize, row: usize| column < 300 && row < 300;
    let folder = map_of("worlds-map-noise", 1600, |column, row| (column + row) % 2 == 0 && !is_room(column, row));
    let Ended { errors, status, .. } = run_in(&folder, &["worlds", "map.yaml"]);
    assert!(status == 2 && errors.contains("in more than 1048576 pieces"), "{errors}");
}
