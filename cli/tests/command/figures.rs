//! The pictures that the README and the book show are what the command draws.
//!
//! `WRITE_FIGURES=1 cargo test -p rpl figures` draws them anew; look at each before keeping it.

use crate::folder::folder;
use crate::rpl::run_in;
use rpl_tests::repository;
use std::fs;

/// The run of the README.
const RUN: [&str; 9] =
    ["run", "delivery.rpl", "--world", "dept", "--scenario", "rotated.rpl", "--quiet", "--figures", "figures"];

/// The experiment of the book's page on routes.
const ROUTES: [&str; 8] = ["experiment", "routes", "--row", "literal", "--runs", "1", "--results", "figures"];

/// A picture of the book, and the figure that it is.
type Picture = (&'static str, &'static str);

/// What makes pictures of the book.
const PICTURES: [(&[&str], [Picture; 2]); 2] = [
    (&RUN, [("docs/rotated.svg", "paths.svg"), ("docs/belief.svg", "belief-02-localization-action.svg")]),
    (&ROUTES, [("docs/places.svg", "places.svg"), ("docs/adaptation.svg", "literal-1.svg")]),
];

#[test]
fn the_pictures_of_the_book_are_those_that_the_command_draws() {
    for (command, pictures) in PICTURES {
        let folder = folder(&format!("book-figures-{}", command[1]));
        let ended = run_in(&folder, command);
        assert_eq!(ended.status, 0, "{}", ended.errors);
        for (picture, figure) in pictures {
            let drawn = fs::read_to_string(folder.join("figures").join(figure)).expect("it is drawn");
            let kept = repository::root().join(picture);
            if std::env::var_os("WRITE_FIGURES").is_some() {
                fs::write(&kept, &drawn).expect("the book can be written");
            }
            let is_same = fs::read_to_string(&kept).is_ok_and(|kept| kept == drawn);
            let anew = "`WRITE_FIGURES=1 cargo test -p rpl figures` draws it anew";
            assert!(is_same, "`{picture}` is not what is drawn: {anew}");
        }
    }
}

#[test]
fn an_image_and_a_page_lie_beside_each_drawing() {
    let folder = folder("figure-images");
    let ended = run_in(&folder, &["worlds", "test-room", "--svg", "world.svg", "--map", "map"]);
    assert_eq!(ended.status, 0, "{}", ended.errors);
    crate::folder::put(&folder, "plan.rpl", "(wait-time 2)");
    // The map is one that can be read again.
    let ended = run_in(&folder, &["worlds", "map"]);
    assert!(ended.status == 0 && ended.out.contains("8.0 m by 6.0 m"), "{}{}", ended.out, ended.errors);
    let ended = run_in(&folder, &["run", "plan.rpl", "--world", "test-room", "--figures", "figures"]);
    assert_eq!(ended.status, 0, "{}", ended.errors);
    let drawing = fs::read_to_string(folder.join("figures/paths.svg")).expect("it is drawn");
    let image = fs::read(folder.join("figures/paths.png")).expect("it is drawn");
    let width: f64 = drawing
        .split(" width=\"")
        .nth(1)
        .and_then(|rest| rest.split('"').next())
        .expect("a width")
        .parse()
        .expect("a number");
    // The width stands after the signature, and the length and name of the first chunk.
    let pixels = u32::from_be_bytes(image[16..20].try_into().expect("four bytes"));
    assert_eq!(f64::from(pixels), (2.0 * width).ceil());
    // The page is as wide as browsers would print the drawing: 96 pixels are an inch, and an inch is 72 points.
    let page = fs::read(folder.join("figures/paths.pdf")).expect("it is drawn");
    let text = String::from_utf8_lossy(&page);
    assert!(text.starts_with("%PDF-") && text.ends_with("%<!-- drawn by rpl run -->\n"));
    let right = text.split("/MediaBox [").nth(1).and_then(|rest| rest.split(' ').nth(2)).expect("a page has a size");
    assert!((right.parse::<f64>().expect("a number") - width * 0.75).abs() < 0.1, "{right} for {width}");
    // They are drawn again, but what somebody else has put there stays.
    let run = ["run", "plan.rpl", "--world", "test-room", "--figures", "figures"];
    assert_eq!(run_in(&folder, &run).status, 0);
    crate::folder::put(&folder, "figures/paths.pdf", "mine");
    let ended = run_in(&folder, &run);
    assert!(
        ended.status == 2 && ended.errors.contains("`figures/paths.pdf` was not drawn by this command"),
        "{}",
        ended.errors
    );
    assert_eq!(fs::read(folder.join("figures/paths.pdf")).expect("it is there"), b"mine");
}
