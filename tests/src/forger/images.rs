//! Maps: their YAML files and their images, and what is no file at all.

use super::case::{Case, Content, Expected, plan, text, words};
use super::mangle;
use crate::generated::Dice;
use png::{BitDepth, ColorType, Encoder};

const YAML: &str = "image: map.pgm\nresolution: 0.05\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: trinary\n";

/// The pixels of a room of 60 by 40.
fn pixels() -> Vec<u8> {
    let is_wall = |column: usize, row: usize| column == 0 || row == 0 || column == 59 || row == 39;
    (0..2400).map(|index| if is_wall(index % 60, index / 60) { 0 } else { 254 }).collect()
}

fn image(header: &str) -> Vec<u8> {
    [header.as_bytes(), &pixels()].concat()
}

fn uses(dice: &mut Dice) -> Vec<String> {
    words(dice.pick(&[
        "worlds map.yaml",
        "worlds . --png out.png",
        "run plan.rpl --world map.yaml --until 1s",
        "run plan.rpl --world . --map none --until 1s",
        "localize --map . --log drive.log",
    ]))
}

fn map(kind: &'static str, yaml: impl Into<Vec<u8>>, image: Vec<u8>, expected: Expected, dice: &mut Dice) -> Case {
    let files = vec![text("map.yaml", yaml), text("map.pgm", image), plan()];
    Case { kind, files, arguments: uses(dice), expected }
}

/// A map file somebody damaged.
pub fn map_file(dice: &mut Dice) -> Case {
    let laughs = || {
        let level = |at: usize| format!("l{at}: [*l{0},*l{0},*l{0},*l{0},*l{0},*l{0},*l{0},*l{0},*l{0}]\n", at - 1);
        format!("l0: &l0 lol\n{}{YAML}", (1..30).map(level).collect::<String>())
    };
    let yaml = match dice.below(8) {
        0 => laughs().into_bytes(),
        1 => (0..100_000).map(|at| format!("k{at}: 1\n")).collect::<String>().into_bytes(),
        2 => YAML.replace("[-1.0, 2.0, 0.0]", &format!("[{}]", "1,".repeat(40_000))).into_bytes(),
        3 => YAML.replace("[-1.0, 2.0, 0.0]", &format!("\n{}", "- 1\n".repeat(10_000))).into_bytes(),
        _ => mangle::text(YAML, dice),
    };
    map("map file", yaml, image("P5\n60 40\n255\n"), Expected::Anything, dice)
}

/// A PGM with a header that lies, or damaged pixels.
pub fn pgm(dice: &mut Dice) -> Case {
    let number = |dice: &mut Dice| dice.pick(mangle::NUMBERS).to_string();
    let image = match dice.below(6) {
        0 => image(&format!("P5 {} {} {}\n", number(dice), number(dice), number(dice))),
        1 => image(dice.pick(&[
            "P5 1000000000 1000000000 255\n",
            "P2 1000000000 1000000000 255\n",
            "P5 8192 8192 255\n",
        ])),
        2 => {
            image(dice.pick(&["P5 60 40 65535\n", "P5 60 40 1\n", "P5 60 40 0\n", "P2 60 40 255\n", "P6 60 40 255\n"]))
        }
        3 => format!("P5 #{}\n60 40 255\n", "c".repeat(3_000_000)).into_bytes(),
        4 => [&b"P2 1000 1000 15\n"[..], &b"7 ".repeat(dice.below(1_200_000))].concat(),
        _ => mangle::bytes(&image("P5\n60 40\n255\n"), dice),
    };
    map("PGM", YAML, image, Expected::Anything, dice)
}

fn encoded(columns: u32, rows: u32, colour: ColorType, depth: BitDepth, text: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, columns, rows);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    if colour == ColorType::Indexed {
        encoder.set_palette(vec![0, 0, 0, 250, 250, 250]);
    }
    if text > 0 {
        // It shrinks to a thousandth, and is not what a map is made of.
        encoder.add_ztxt_chunk("Comment".to_string(), "a".repeat(text)).ok();
    }
    let row = (columns as usize * colour.samples() * depth as usize).div_ceil(8);
    if let Ok(mut writer) = encoder.write_header() {
        writer.write_image_data(&vec![255; row * rows as usize]).ok();
    }
    bytes
}

/// A PNG of any kind, some of them bombs.
pub fn png(dice: &mut Dice) -> Case {
    let kinds = [
        (ColorType::Grayscale, BitDepth::One),
        (ColorType::Grayscale, BitDepth::Sixteen),
        (ColorType::GrayscaleAlpha, BitDepth::Eight),
        (ColorType::Rgb, BitDepth::Sixteen),
        (ColorType::Rgba, BitDepth::Eight),
        (ColorType::Indexed, BitDepth::Eight),
    ];
    let (colour, depth) = kinds[dice.below(kinds.len())];
    let image = match dice.below(6) {
        0 => encoded(60, 40, colour, depth, 0),
        1 => encoded(60, 40, colour, depth, 32 << 20),
        // Eight million pixels in some kilobytes.
        2 => encoded(4_000, 2_000, ColorType::Grayscale, BitDepth::One, 0),
        3 => with_size(encoded(60, 40, colour, depth, 0), dice),
        _ => mangle::bytes(&encoded(60, 40, colour, depth, 0), dice),
    };
    map("PNG", YAML, image, Expected::Anything, dice)
}

/// The image under a header with another size, the checksum of which is right.
fn with_size(mut png: Vec<u8>, dice: &mut Dice) -> Vec<u8> {
    let sizes = [0, 1, 61, 30_000, 1_000_000_000, u32::MAX];
    let (columns, rows) = (sizes[dice.below(sizes.len())], sizes[dice.below(sizes.len())]);
    png[16..20].copy_from_slice(&columns.to_be_bytes());
    png[20..24].copy_from_slice(&rows.to_be_bytes());
    // Interlaced, now and then.
    png[28] = u8::from(dice.once_in(2));
    let checksum = crc32fast::hash(&png[12..29]).to_be_bytes();
    png[29..33].copy_from_slice(&checksum);
    png
}

/// Folders, devices, endless pipes and loops of links in the place of a file.
pub fn no_file(dice: &mut Dice) -> Case {
    let there = match dice.below(6) {
        0 => Content::Link("/dev/zero"),
        1 => Content::Link("/dev/full"),
        2 => Content::Link("/dev/urandom"),
        3 => Content::Folder,
        4 => Content::Link("here"),
        _ => Content::EndlessPipe,
    };
    let lines = [
        ("here", "run here"),
        ("here", "check here"),
        ("here", "fmt --check here"),
        ("here", "test here"),
        ("here", "run plan.rpl --world here"),
        ("here", "run plan.rpl --world test-room --scenario here"),
        ("here", "trace here"),
        ("here", "trace diff here here"),
        ("here", "localize --map . --log here"),
        ("here", "localize --map . --log drive.log --parameters here"),
        ("map.yaml", "worlds map.yaml"),
        ("map.pgm", "worlds map.yaml"),
        ("w.toml", "worlds w.toml"),
    ];
    let (name, line) = lines[dice.below(lines.len())];
    let there = if there == Content::Link("here") { Content::Link("loop") } else { there };
    let mut files = vec![
        text("map.yaml", YAML),
        text("map.pgm", image("P5\n60 40\n255\n")),
        text("drive.log", super::recordings::LOG),
        ("loop".to_string(), Content::Link("loop")),
        plan(),
    ];
    files.retain(|(known, _)| known != name);
    files.push((name.to_string(), there));
    Case { kind: "no file", files, arguments: words(line), expected: Expected::Refused }
}
