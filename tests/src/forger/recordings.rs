//! Logs of drives, traces of runs, parameters of the filter.

use super::case::{Case, Expected, text, words};
use super::mangle;
use crate::generated::Dice;
use rpl_robot::localization::LocalizationParameters;

/// A drive of four scans through a room of 3 m by 2 m.
pub const LOG: &str = "FLASER 5 0.9 1.0 1.1 1.0 0.9 -0.5 3.0 0.0 0.0 0.0 0.0 0.0 host 0.0\n\
                       FLASER 5 0.9 1.0 1.0 1.0 0.9 -0.3 3.0 0.0 0.2 0.0 0.0 1.0 host 1.0\n\
                       FLASER 5 0.9 1.0 0.9 1.0 0.9 0.1 3.0 0.0 0.6 0.0 0.0 2.0 host 2.0\n\
                       FLASER 5 0.9 1.0 0.5 1.0 0.9 0.5 3.0 0.0 1.0 0.0 0.0 3.0 host 3.0\n";

const YAML: &str = "image: map.pgm\nresolution: 0.05\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.196\n";

const TRACE: &str = concat!(
    "{\"trace\":1,\"plan\":\"p.rpl\",\"world\":null,\"scenario\":null,\"seed\":1}\n",
    "{\"time_s\":0.0,\"seq\":0,\"task\":\"main\",\"kind\":\"begin\"}\n",
    "{\"time_s\":0.0,\"seq\":1,\"task\":\"main\",\"kind\":\"call\"}\n",
    "{\"time_s\":1.5,\"seq\":2,\"task\":\"main/a\",\"kind\":\"blocked\",\"on\":\"a fluent\",\"reads\":\"x\"}\n",
    "{\"time_s\":2.0,\"seq\":3,\"task\":\"main/a\",\"kind\":\"log\",\"text\":\"hello\"}\n",
    "{\"time_s\":2.5,\"seq\":4,\"task\":\"main\",\"kind\":\"end\"}\n",
);

fn room() -> Vec<u8> {
    let is_wall = |column: usize, row: usize| column == 0 || row == 0 || column == 59 || row == 39;
    let pixels = (0..2400).map(|index| if is_wall(index % 60, index / 60) { 0 } else { 254 });
    b"P5\n60 40\n255\n".iter().copied().chain(pixels).collect()
}

fn localized(kind: &'static str, log: Vec<u8>, parameters: Vec<u8>, dice: &mut Dice) -> Case {
    let files =
        vec![text("map.yaml", YAML), text("map.pgm", room()), text("drive.log", log), text("p.json", parameters)];
    let line = dice.pick(&[
        "localize --map . --log drive.log --beams 5 --window-length 0.5 --windows 2 --parameters p.json",
        "localize --map . --log drive.log --beams 3 --from-truth --parameters p.json --json",
        "localize --map . --log drive.log --beams 1 --window-length 0.3 --parameters p.json --figures out",
        "localize --map . --log drive.log --beams 5 --parameters p.json --fit fitted.json",
    ]);
    Case { kind, files, arguments: words(line), expected: Expected::Anything }
}

fn laser() -> String {
    serde_json::to_string(&LocalizationParameters::recorded(vec![0])).unwrap_or_default()
}

/// A log somebody damaged.
pub fn log(dice: &mut Dice) -> Case {
    let log = match dice.below(6) {
        0 => LOG.repeat(1 + dice.below(500)).into_bytes(),
        1 => format!("FLASER 100000 {}\n", "1 ".repeat(dice.below(200_000))).into_bytes(),
        2 => LOG.replace("FLASER 5", "ROBOTLASER1 0 -1.5 3.1 0.7 50 0.1 0 5").into_bytes(),
        _ => mangle::text(LOG, dice),
    };
    localized("log", log, laser().into_bytes(), dice)
}

/// Parameters somebody damaged.
pub fn parameters(dice: &mut Dice) -> Case {
    let parameters = match dice.below(4) {
        0 => format!("{{\"a\":{}", "[".repeat(60_000)).into_bytes(),
        1 => mangle::bytes(laser().as_bytes(), dice),
        _ => mangle::numbers(&laser(), 30, dice).into_bytes(),
    };
    localized("parameters", LOG.as_bytes().to_vec(), parameters, dice)
}

/// A trace somebody damaged.
pub fn trace(dice: &mut Dice) -> Case {
    let trace = match dice.below(6) {
        0 => [TRACE.as_bytes(), &b"{\"a\":[".repeat(100_000)].concat(),
        1 => format!("{TRACE}{{\"time_s\":3,\"x\":[{}]}}\n", "0,".repeat(3_000_000)).into_bytes(),
        2 => TRACE.replace("main", &"m/".repeat(20_000)).into_bytes(),
        3 => TRACE.lines().cycle().take(20_000).map(|line| line.to_string() + "\n").collect::<String>().into_bytes(),
        _ => mangle::text(TRACE, dice),
    };
    let line = dice.pick(&[
        "trace t.jsonl",
        "trace t.jsonl --why main",
        "trace t.jsonl --last 3",
        "trace t.jsonl --task main --json",
        "trace diff t.jsonl t.jsonl",
    ]);
    Case { kind: "trace", files: vec![text("t.jsonl", trace)], arguments: words(line), expected: Expected::Anything }
}
