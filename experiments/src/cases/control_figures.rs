//! What the control does: when a case is retrieved on the way and what then drives (Fox and Anderson-Sprecher, Fig. 1),
//! and its states with what leads from one to another (Fig. 2).

use rpl_drawing::palette::{self, SERIES};
use rpl_drawing::writing::{
    FAMILY, SMALL_PX, TEXT_PX, TITLE_PX, centred, ending, rounded, shortened, text, width_px, with_halo,
};
use rpl_rupart::control::{State, TRANSITIONS, Trigger};
use rpl_rupart::memory::CaseNumber;
use rpl_rupart::trial::{CourseMoment, Driven};
use std::f64::consts::TAU;
use svg::Document;
use svg::node::element::{Ellipse, Group, Line, Path, Rectangle};

/// A sheet with its margins.
const WIDTH_PX: f64 = 960.0;
const LEFT_PX: f64 = 90.0;
const RIGHT_PX: f64 = 24.0;

/// A band of the course, and from one to the next.
const BAND_PX: f64 = 26.0;
const BANDS_PX: f64 = 44.0;
const TOP_PX: f64 = 56.0;

/// Ticks of the time are one of these apart, so that there are no more than this many.
const TICKS_S: [f64; 8] = [1.0, 2.0, 5.0, 10.0, 20.0, 60.0, 120.0, 300.0];
const MOST_TICKS: f64 = 10.0;

/// The states stand on an ellipse around this point, with these half axes.
const MIDDLE_PX: (f64, f64) = (480.0, 330.0);
const AXES_PX: (f64, f64) = (350.0, 215.0);

/// The size of a state, and how much an edge bows beside the straight line.
const STATE_PX: (f64, f64) = (78.0, 34.0);
const BOW: f64 = 0.13;

/// The states with their share of the time of all drives, and the course of the first.
pub fn files(row: &str, driven: &[Option<Driven>]) -> Vec<(String, String)> {
    let all: Vec<&Driven> = driven.iter().flatten().collect();
    let mut files = vec![("states.svg".to_string(), states(row, &all))];
    files.extend(all.first().map(|first| ("course.svg".to_string(), course(row, first))));
    files
}

/// Stretches of a drive in which what is told of its moments stays the same.
fn stretches<T: PartialEq>(driven: &Driven, told: impl Fn(&CourseMoment) -> T) -> Vec<(f64, f64, T)> {
    let mut stretches: Vec<(f64, f64, T)> = Vec::new();
    for moment in &driven.course {
        let is = told(moment);
        if let Some(last) = stretches.last_mut() {
            last.1 = moment.time_s;
            if last.2 == is {
                continue;
            }
        }
        stretches.push((moment.time_s, driven.time_s, is));
    }
    if let Some(last) = stretches.last_mut() {
        last.1 = driven.time_s;
    }
    stretches
}

fn sheet(title: &str, height_px: f64) -> Document {
    Document::new()
        .set("viewBox", (0, 0, WIDTH_PX, height_px))
        .set("width", WIDTH_PX)
        .set("height", height_px)
        .set("font-family", FAMILY)
        .add(Rectangle::new().set("width", "100%").set("height", "100%").set("fill", palette::PAPER))
        .add(text(title, 18.0, 28.0, TITLE_PX).set("font-weight", "bold"))
}

/// A drive over time: the state of the control, the case it drives by, and the stop it drives to.
fn course(row: &str, driven: &Driven) -> String {
    let x = |time_s: f64| LEFT_PX + (WIDTH_PX - LEFT_PX - RIGHT_PX) * time_s / driven.time_s.max(f64::MIN_POSITIVE);
    let top_px = |band: f64| TOP_PX + BANDS_PX * band;
    let bar = |from_s: f64, to_s: f64, band: f64, colour: &str| {
        let bar = Rectangle::new().set("x", rounded(x(from_s))).set("y", top_px(band)).set("height", BAND_PX);
        bar.set("width", rounded(x(to_s) - x(from_s))).set("fill", colour).set("stroke", palette::PAPER)
    };
    let told = |from_s: f64, to_s: f64, band: f64, words: &str| {
        let room_px = x(to_s) - x(from_s) - 4.0;
        let fits = width_px(words, SMALL_PX) <= room_px;
        let y_px = top_px(band) + BAND_PX / 2.0 + 4.0;
        fits.then(|| centred(words, x((from_s + to_s) / 2.0), y_px, SMALL_PX).set("fill", palette::PAPER))
    };
    let mut document = sheet(&format!("{row}: what the control does on a drive, and by which case"), 262.0);
    let bands: [(&str, Vec<Bar>); 3] = [
        ("state", stretches(driven, |moment| moment.state).into_iter().map(named_state).collect()),
        (
            "case",
            stretches(driven, |moment| moment.case)
                .into_iter()
                .map(numbered(|case: Option<CaseNumber>| case.map(|case| case.0)))
                .collect(),
        ),
        (
            "stops left",
            stretches(driven, |moment| moment.stops_left)
                .into_iter()
                .map(numbered(|left: usize| Some(left as u32)))
                .collect(),
        ),
    ];
    for (band, (name, stretches)) in (0..).map(f64::from).zip(bands) {
        document = document.add(ending(name, LEFT_PX - 10.0, top_px(band) + BAND_PX / 2.0 + 4.0, TEXT_PX));
        for Bar { from_s, to_s, words, colour } in stretches {
            document = document.add(bar(from_s, to_s, band, colour));
            document = told(from_s, to_s, band, &words).into_iter().fold(document, Document::add);
        }
    }
    // A retrieval is a tick below the case.
    for retrieved in driven.course.iter().filter(|moment| moment.has_retrieved) {
        let (x_px, y_px) = (rounded(x(retrieved.time_s)), top_px(1.0) + BAND_PX);
        let tick = Line::new().set("x1", x_px).set("x2", x_px).set("y1", y_px + 1.0).set("y2", y_px + 8.0);
        document = document.add(tick.set("stroke", palette::INK).set("stroke-width", 1.5));
    }
    let axis_px = top_px(3.0) + 2.0;
    let apart_s = TICKS_S.into_iter().find(|apart_s| driven.time_s <= MOST_TICKS * apart_s).unwrap_or(driven.time_s);
    for tick in 0..=(driven.time_s / apart_s) as u32 {
        let time_s = apart_s * f64::from(tick);
        document = document.add(centred(&format!("{time_s:.0} s"), x(time_s), axis_px, SMALL_PX));
    }
    let says = "a tick below the case is a retrieval: at each new short-term goal, and every three seconds";
    document.add(text(says, LEFT_PX, axis_px + 24.0, SMALL_PX).set("fill", palette::QUIET)).to_string()
}

/// A stretch of a drive as it is drawn.
struct Bar {
    from_s: f64,
    to_s: f64,
    words: String,
    colour: &'static str,
}

fn named_state((from_s, to_s, state): (f64, f64, State)) -> Bar {
    Bar { from_s, to_s, words: format!("{state:?}"), colour: SERIES[state as usize % SERIES.len()] }
}

/// Neighbours differ in colour.
fn numbered<T>(number: impl Fn(T) -> Option<u32>) -> impl Fn((f64, f64, T)) -> Bar {
    move |(from_s, to_s, told)| match number(told) {
        Some(number) => Bar { from_s, to_s, words: number.to_string(), colour: SERIES[number as usize % SERIES.len()] },
        None => Bar { from_s, to_s, words: String::new(), colour: palette::GRID },
    }
}

/// The states and what leads from one to another, with the share of the time that drives spend in them.
fn states(row: &str, driven: &[&Driven]) -> String {
    let whole_s: f64 = driven.iter().map(|drive| drive.time_s).sum();
    let in_state_s = |state: State| -> f64 {
        let of_drive = |drive: &&Driven| -> f64 {
            let stretches = stretches(drive, |moment| moment.state);
            stretches.iter().filter(|stretch| stretch.2 == state).map(|(from_s, to_s, _)| to_s - from_s).sum()
        };
        // The sum of nothing is −0.
        driven.iter().map(of_drive).fold(0.0, |sum, time_s| sum + time_s)
    };
    let title = format!("{row}: states of the control, and their share of the time of {} drives", driven.len());
    let mut document = sheet(&title, 620.0);
    let (mut lines, mut labels) = (Group::new(), Group::new());
    for from in State::ALL {
        for to in State::ALL {
            let triggers: Vec<Trigger> =
                TRANSITIONS.iter().filter(|one| (one.0, one.2) == (from, to)).map(|one| one.1).collect();
            if !triggers.is_empty() {
                let (line, label) = edge(from, to, &triggers);
                (lines, labels) = (lines.add(line), labels.add(label));
            }
        }
    }
    document = document.add(lines);
    for state in State::ALL {
        let share = if whole_s > 0.0 { in_state_s(state) / whole_s } else { 0.0 };
        document = document.add(node(state, share));
    }
    let beside = "Track is active beside any of them: it turns the camera, and keeps in view what it finds";
    document.add(labels).add(text(beside, 18.0, 604.0, SMALL_PX).set("fill", palette::QUIET)).to_string()
}

fn at_px(state: State) -> (f64, f64) {
    let order = [State::Wander, State::Bump, State::NoGoal, State::NewGoal, State::Loc2, State::Loc1];
    let place = order.iter().position(|one| *one == state).unwrap_or(0);
    let (sin, cos) = (TAU * place as f64 / order.len() as f64).sin_cos();
    (MIDDLE_PX.0 + AXES_PX.0 * cos, MIDDLE_PX.1 - AXES_PX.1 * sin)
}

fn node(state: State, share: f64) -> Group {
    let (x_px, y_px) = at_px(state);
    let blend = if state == State::Wander { "Avoid, Escape, ToGoal" } else { "" };
    let line_px = if blend.is_empty() { 4.0 } else { -4.0 };
    let outline = Ellipse::new().set("cx", rounded(x_px)).set("cy", rounded(y_px)).set("rx", STATE_PX.0);
    let outline = outline.set("ry", STATE_PX.1).set("fill", palette::PAPER).set("stroke-width", 2);
    Group::new()
        .add(outline.set("stroke", SERIES[state as usize % SERIES.len()]))
        .add(centred(&format!("{state:?}"), x_px, y_px + line_px - 4.0, TEXT_PX).set("font-weight", "bold"))
        .add(centred(&shortened(blend, SMALL_PX, 2.0 * STATE_PX.0), x_px, y_px + 7.0, SMALL_PX))
        .add(centred(&format!("{:.1} %", 100.0 * share), x_px, y_px + 20.0, SMALL_PX).set("fill", palette::QUIET))
}

/// An arrow that bows to the left of its way, and what it is called.
fn edge(from: State, to: State, triggers: &[Trigger]) -> (Group, Group) {
    let (start, end) = (at_px(from), at_px(to));
    let across = (-(end.1 - start.1) * BOW, (end.0 - start.0) * BOW);
    let bow = ((start.0 + end.0) / 2.0 + across.0, (start.1 + end.1) / 2.0 + across.1);
    let (start, end) = (on_rim(start, bow), on_rim(end, bow));
    let (x, y) = (rounded(end.0), rounded(end.1));
    let data = format!("M{} {}Q{} {} {x} {y}", rounded(start.0), rounded(start.1), rounded(bow.0), rounded(bow.1));
    let heading_rad = (end.1 - bow.1).atan2(end.0 - bow.0);
    let wing = |off_rad: f64| {
        let (sin, cos) = (heading_rad + off_rad).sin_cos();
        format!("{} {}", rounded(end.0 - 9.0 * cos), rounded(end.1 - 9.0 * sin))
    };
    let head = Path::new().set("d", format!("M{}L{x} {y}L{}Z", wing(0.4), wing(-0.4))).set("fill", palette::PLACE);
    let line = Path::new().set("d", data).set("fill", "none").set("stroke", palette::PLACE).set("stroke-width", 1.2);
    let middle = ((start.0 + 2.0 * bow.0 + end.0) / 4.0, (start.1 + 2.0 * bow.1 + end.1) / 4.0);
    let words: Vec<String> = triggers.iter().map(|trigger| format!("{trigger:?}")).collect();
    let label = with_halo(centred(&words.join(", "), middle.0, middle.1 + 4.0, SMALL_PX));
    (Group::new().add(line).add(head), Group::new().add(label))
}

/// Where the way from the middle of a state leaves it.
fn on_rim(middle: (f64, f64), to: (f64, f64)) -> (f64, f64) {
    let (dx, dy) = (to.0 - middle.0, to.1 - middle.1);
    let share = 1.0 / (dx / STATE_PX.0).hypot(dy / STATE_PX.1).max(1.0);
    (middle.0 + dx * share, middle.1 + dy * share)
}
