//! Files and folders that are written: never what is read, and tried before the run.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    // The one before may not be there.
    fs::remove_dir_all(&folder).ok();
    fs::create_dir_all(&folder).expect("the folder can be made");
    folder
}

fn put(folder: &Path, name: &str, text: &str) {
    fs::write(folder.join(name), text).expect("the text can be written");
}

fn rpl(folder: &Path, arguments: &[&str]) -> (String, String, Option<i32>) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rpl"));
    let Output { status, stdout, stderr } =
        command.current_dir(folder).args(arguments).output().expect("the command runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    (text(stdout), text(stderr), status.code())
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A world of one room, and its map as an image.
fn put_world(folder: &Path) {
    let world = Command::new(env!("CARGO_BIN_EXE_rpl"))
        .current_dir(folder)
        .args(["worlds", "test-room", "--png", "map.png"])
        .output()
        .expect("the command runs");
    assert!(world.status.success());
    let yaml =
        "image: map.png\nresolution: 0.05\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\n";
    put(folder, "map.yaml", yaml);
}

#[cfg(unix)]
#[test]
fn no_output_takes_the_place_of_an_input() {
    let folder = folder("outputs-inputs");
    put(&folder, "plan.rpl", "(load \"part.rpl\") (print 'never)");
    put(&folder, "part.rpl", "(defvar part 1)");
    put(&folder, "scenario.rpl", "(wait-time 1)");
    put_world(&folder);
    std::os::unix::fs::symlink("plan.rpl", folder.join("link")).expect("a link can be made");
    fs::hard_link(folder.join("part.rpl"), folder.join("twin")).expect("a link can be made");
    let here = folder.join("plan.rpl").display().to_string();
    let before: Vec<Vec<u8>> =
        names(&folder).iter().map(|name| fs::read(folder.join(name)).expect("it is there")).collect();
    let run = ["run", "plan.rpl", "--world", "map.yaml", "--scenario", "scenario.rpl"];
    for output in ["plan.rpl", "./plan.rpl", &here, "link", "part.rpl", "twin", "scenario.rpl", "map.yaml", "map.png"] {
        let (out, err, status) = rpl(&folder, &[&run[..], &["--trace", output]].concat());
        assert_eq!((out.as_str(), status), ("", Some(2)), "{output}: {err}");
        assert!(err.contains(output) && err.contains("which this command reads"), "{output}: {err}");
    }
    for kind in ["--svg", "--png"] {
        let (_, err, status) = rpl(&folder, &["worlds", "map.yaml", kind, "map.png"]);
        assert!(status == Some(2) && err.contains("which this command reads"), "{kind}: {err}");
    }
    let after: Vec<Vec<u8>> =
        names(&folder).iter().map(|name| fs::read(folder.join(name)).expect("it is there")).collect();
    assert_eq!(before, after, "{:?}", names(&folder));
    let (_, err, status) = rpl(&folder, &["worlds", "test-room", "--svg", "one", "--png", "./one"]);
    assert!(status == Some(2) && err.contains("is written already"), "{err}");
}

#[test]
fn outputs_are_tried_before_the_run() {
    let folder = folder("outputs-tried");
    put(&folder, "plan.rpl", "(print 'ran)");
    put(&folder, "file", "not a folder");
    for (arguments, said) in [
        (&["run", "plan.rpl", "--trace", "nowhere/t.jsonl"][..], "there is no folder `nowhere`"),
        (&["run", "plan.rpl", "--trace", "."], "cannot write the trace `.`"),
        (&["run", "plan.rpl", "--world", "test-room", "--figures", "file"], "`file`"),
        (&["run", "plan.rpl", "--world", "test-room", "--figures", "file/below"], "`file/below`"),
        (&["experiment", "plan.rpl", "--runs", "2", "--results", "file"], "`file`"),
        (&["worlds", "test-room", "--svg", "nowhere/map.svg"], "there is no folder `nowhere`"),
        (&["worlds", "test-room", "--png", "."], "cannot write the drawing `.`"),
    ] {
        let (out, err, status) = rpl(&folder, arguments);
        assert_eq!((out.as_str(), status), ("", Some(2)), "{arguments:?}: {err}");
        assert!(err.contains(said), "{arguments:?}: {err}");
    }
    assert_eq!(names(&folder), ["file", "plan.rpl"], "nothing is left of what was tried");
}

#[test]
fn old_figures_do_not_stay_among_the_new_ones() {
    let folder = folder("outputs-figures");
    put(&folder, "plan.rpl", "(wait-time 8)");
    put(&folder, "turn.rpl", "(wait-time 1) (rotate-robot! 170deg)");
    let run = ["run", "plan.rpl", "--world", "test-room", "--figures", "figures"];
    let (_, err, status) = rpl(&folder, &[&run[..], &["--scenario", "turn.rpl"]].concat());
    assert_eq!(status, Some(0), "{err}");
    let figures = folder.join("figures");
    let first = names(&figures);
    // What stands for figures at turning points, drawn by us and by somebody else.
    let paths = fs::read_to_string(figures.join("paths.svg")).expect("it is there");
    put(&figures, "belief-07-position-lost.svg", &paths);
    put(&figures, "mine.svg", "<svg/>");
    put(&figures, "notes.txt", "keep");
    let (_, err, status) = rpl(&folder, &run);
    assert_eq!(status, Some(0), "{err}");
    assert_eq!(names(&figures), ["belief.svg", "mine.svg", "notes.txt", "paths.svg"], "before: {first:?}");
    // Somebody's drawing of the same name is not overwritten, and that is said before the run.
    put(&figures, "belief.svg", "<svg/>");
    let (_, err, status) = rpl(&folder, &run);
    assert!(status == Some(2) && err.contains("was not drawn by this command"), "{err}");
    assert!(!err.contains("succeeded"), "{err}");
}
