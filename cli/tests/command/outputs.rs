//! Files and folders that are written: never what is read, and tried before the run.

use crate::folder::{folder, put};
use crate::rpl::{Ended, run_in};
use std::fs;
use std::path::Path;

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").flatten();
    let mut names: Vec<String> = entries.map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// A world of one room, and its map as an image.
fn put_world(folder: &Path) {
    assert_eq!(run_in(folder, &["worlds", "test-room", "--map", "map"]).status, 0);
    fs::rename(folder.join("map/map.pgm"), folder.join("map.pgm")).expect("it is written");
    fs::remove_dir_all(folder.join("map")).expect("it is there");
    let yaml =
        "image: map.pgm\nresolution: 0.05\norigin: [0, 0, 0]\noccupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\n";
    put(folder, "map.yaml", yaml);
}

#[cfg(unix)]
#[test]
fn a_trial_behind_a_link_that_leads_nowhere_leaves_the_link() {
    let folder = folder("outputs-dangling");
    std::os::unix::fs::symlink("nowhere", folder.join("link")).expect("a link can be made");
    let Ended { errors, status, .. } = run_in(&folder, &["worlds", "test-room", "--svg", "link", "--png", "no/x.png"]);
    assert!(status == 2 && errors.contains("there is no folder `no`"), "{errors}");
    assert_eq!(names(&folder), ["link"]);
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
    let here = folder.join("plan.rpl").to_string_lossy().into_owned();
    let before: Vec<Vec<u8>> =
        names(&folder).iter().map(|name| fs::read(folder.join(name)).expect("it is there")).collect();
    let run = ["run", "plan.rpl", "--world", "map.yaml", "--scenario", "scenario.rpl"];
    for output in ["plan.rpl", "./plan.rpl", &here, "link", "part.rpl", "twin", "scenario.rpl", "map.yaml", "map.pgm"] {
        let Ended { out, errors, status } = run_in(&folder, &[&run[..], &["--trace", output]].concat());
        assert_eq!((out.as_str(), status), ("", 2), "{output}: {errors}");
        assert!(errors.contains(output) && errors.contains("which this command reads"), "{output}: {errors}");
    }
    for kind in ["--svg", "--png", "--pdf"] {
        let Ended { errors, status, .. } = run_in(&folder, &["worlds", "map.yaml", kind, "map.pgm"]);
        assert!(status == 2 && errors.contains("which this command reads"), "{kind}: {errors}");
    }
    let after: Vec<Vec<u8>> =
        names(&folder).iter().map(|name| fs::read(folder.join(name)).expect("it is there")).collect();
    assert_eq!(before, after, "{:?}", names(&folder));
    let Ended { errors, status, .. } = run_in(&folder, &["worlds", "test-room", "--svg", "one", "--png", "./one"]);
    assert!(status == 2 && errors.contains("is written already"), "{errors}");
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
        let Ended { out, errors, status } = run_in(&folder, arguments);
        assert_eq!((out.as_str(), status), ("", 2), "{arguments:?}: {errors}");
        assert!(errors.contains(said), "{arguments:?}: {errors}");
    }
    assert_eq!(names(&folder), ["file", "plan.rpl"], "nothing is left of what was tried");
}

#[test]
fn old_figures_do_not_stay_among_the_new_ones() {
    let folder = folder("outputs-figures");
    put(&folder, "plan.rpl", "(wait-time 8)");
    put(&folder, "turn.rpl", "(wait-time 1) (rotate-robot! 170deg)");
    let run = ["run", "plan.rpl", "--world", "test-room", "--figures", "figures"];
    let Ended { errors, status, .. } = run_in(&folder, &[&run[..], &["--scenario", "turn.rpl"]].concat());
    assert_eq!(status, 0, "{errors}");
    let figures = folder.join("figures");
    let first = names(&figures);
    // What stands for figures at turning points, drawn by us and by somebody else.
    let paths = fs::read_to_string(figures.join("paths.svg")).expect("it is there");
    put(&figures, "belief-07-position-lost.svg", &paths);
    put(&figures, "mine.svg", "<svg/>");
    put(&figures, "notes.txt", "keep");
    let Ended { errors, status, .. } = run_in(&folder, &run);
    assert_eq!(status, 0, "{errors}");
    assert_eq!(
        names(&figures),
        ["belief.pdf", "belief.png", "belief.svg", "mine.svg", "notes.txt", "paths.pdf", "paths.png", "paths.svg"],
        "before: {first:?}"
    );
    // Somebody's drawing of the same name is not overwritten, and that is said before the run.
    put(&figures, "belief.svg", "<svg/>");
    let Ended { errors, status, .. } = run_in(&folder, &run);
    assert!(status == 2 && errors.contains("was not drawn by this command"), "{errors}");
    assert!(!errors.contains("succeeded"), "{errors}");
}
