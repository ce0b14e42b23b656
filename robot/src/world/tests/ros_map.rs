//! Maps of the ROS map_server, made here.

use crate::geometry::Point;
use crate::occupancy::Cell::{Free, Occupied, Unknown};
use crate::occupancy::OccupancyGrid;
use crate::world::{GreyImage, Greys, MapMode, RosMap, World};

const YAML: &str = "image: map.pgm\nresolution: 0.5\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.196\n";

fn map(text: &str) -> RosMap {
    RosMap::parse(text, "map.yaml").unwrap_or_else(|error| panic!("{error}"))
}

fn fault(text: &str) -> String {
    RosMap::parse(text, "map.yaml").expect_err("the map has a fault").to_string()
}

/// One row of shades, from 0 to 255.
fn row(shades: &[u8]) -> GreyImage {
    let mut bytes = format!("P5\n{} 1\n255\n", shades.len()).into_bytes();
    bytes.extend_from_slice(shades);
    GreyImage::decode(&bytes).expect("a fine image")
}

#[test]
fn every_way_to_write_a_map_file_means_the_same() {
    let other = "%YAML 1.2\n---\n# a map\nimage: \"map.pgm\"   # beside this\nresolution: 5e-1\norigin:\n  - -1.0\n  - 2.0\n  - 0\n\
                 negate: false\noccupied_thresh: 0.65\nfree_thresh: 0.196\nmode: 'trinary'\r\n";
    assert_eq!(map(other), map(YAML));
    let split = YAML.replace("[-1.0, 2.0, 0.0]", "[-1.0,\n  2.0, 0.0]");
    assert_eq!(map(&split), map(YAML));
}

#[test]
fn thresholds_are_strict_and_205_is_the_trap() {
    let image = row(&[0, 89, 90, 128, 205, 206, 254, 255]);
    // Occupancies 1, 0.651, 0.647, 0.498, 0.19608, 0.192, 0.004, 0.
    let strict = map(YAML);
    assert_eq!(strict.grid(&image).cells, [Occupied, Occupied, Unknown, Unknown, Unknown, Free, Free, Free]);
    assert!(!Greys::of(&strict, &image).warnings().iter().any(|warning| warning.contains("205 that")));
    let lenient = map(&YAML.replace("0.196", "0.25"));
    assert_eq!(lenient.grid(&image).cells[4], Free);
    let trapped = Greys::of(&lenient, &image).warnings();
    assert!(trapped.iter().any(|warning| warning.contains("1 pixels have the grey 205")), "{trapped:?}");
    let untrapped = Greys::of(&lenient, &row(&[0, 254, 0])).warnings();
    assert!(!untrapped.iter().any(|warning| warning.contains("205")), "{untrapped:?}");
    let exact = map(&YAML.replace("0.65", "1.0").replace("0.196", "0.0"));
    assert_eq!(exact.grid(&row(&[0, 255])).cells, [Unknown, Unknown]);
}

#[test]
fn negation_and_modes_read_shades_in_their_way() {
    let negated = map(&YAML.replace("negate: 0", "negate: 1"));
    assert_eq!(negated.grid(&row(&[0, 128, 255])).cells, [Free, Unknown, Occupied]);
    let raw = map(&format!("{YAML}mode: raw\n"));
    assert_eq!(raw.mode, MapMode::Raw);
    assert_eq!(
        raw.grid(&row(&[0, 19, 20, 65, 66, 100, 101, 255])).cells,
        [Free, Free, Unknown, Unknown, Occupied, Occupied, Unknown, Unknown]
    );
    let scale = map(&format!("{YAML}mode: scale\n"));
    assert_eq!(scale.grid(&row(&[0, 128, 255])).cells, [Occupied, Unknown, Free]);
}

#[test]
fn the_lowest_row_of_the_image_is_the_first_of_the_map() {
    let image = GreyImage::decode(b"P2\n# made by hand\n2 2 # two by two\n15\n15 15\n0 15\n").expect("a fine image");
    let grid = map(YAML).grid(&image);
    assert_eq!(grid.cells, [Occupied, Free, Free, Free]);
    assert_eq!(grid.at(Point::new(-0.75, 2.25)), Occupied);
}

#[test]
fn all_formats_of_an_image_give_the_same_shades() {
    let plain = GreyImage::decode(b"P2 3 1 1000\n0 500 1000").expect("plain");
    let mut wide = b"P5 3 1 1000\n".to_vec();
    [0u16, 500, 1000].iter().for_each(|value| wide.extend(value.to_be_bytes()));
    assert_eq!(GreyImage::decode(&wide), Ok(plain));
    let bytes = [0u8, 205, 255];
    let mut png = Vec::new();
    let mut encoder = png::Encoder::new(&mut png, 3, 1);
    encoder.set_color(png::ColorType::Rgba);
    let mut writer = encoder.write_header().expect("a header");
    let pixels: Vec<u8> = bytes.iter().flat_map(|&byte| [byte, byte, byte, 255]).collect();
    writer.write_image_data(&pixels).expect("pixels");
    writer.finish().expect("an end");
    let read = GreyImage::decode(&png).expect("a PNG");
    let shades = |image: &GreyImage| image.values.iter().map(|&value| image.shade(value)).collect::<Vec<f32>>();
    assert_eq!(shades(&read), shades(&row(&bytes)));
    assert!(GreyImage::decode(&png[..png.len() / 2]).is_err());
}

#[test]
fn broken_images_are_refused() {
    for (bytes, part) in [
        (&b""[..], "empty"),
        (b"GIF89a", "neither PGM"),
        (b"P5 2 2 255\nabc", "truncated: 3 bytes of pixels, 4 expected"),
        (b"P5 2 2", "ends before the maximal value"),
        (b"P5 2 2 0\nabcd", "from 1 to 65535, found 0"),
        (b"P5 2 2 70000\nabcd", "from 1 to 65535, found 70000"),
        (b"P2 2 1 15\n3 16", "a pixel of 16 is above"),
        (b"P2 2 1 15\n3", "ends before pixel 2 of 2"),
        (b"P5 0 2 255\n", "0 by 2 pixels is no map"),
        (b"P2 99999999999 9999999999 255\n1", "is no map"),
        (b"P5 two 2 255\n", "the width of the PGM image is not a number"),
        (b"\x89PNG\r\n\x1a\nxx", "truncated or damaged"),
    ] {
        let error = GreyImage::decode(bytes).expect_err(part).to_string();
        assert!(error.contains(part), "{error}\nshould say: {part}");
    }
}

#[test]
fn faults_of_a_map_file_are_told_with_their_place() {
    for (from, to, part) in [
        ("resolution: 0.5", "resolution: 0", "map.yaml:2:13: `resolution` must be a length above 0 m, found 0"),
        ("resolution: 0.5", "resolution: .nan", "found .nan"),
        ("resolution", "resolutoin", "unknown key `resolutoin`, did you mean `resolution`?"),
        ("image: map.pgm\n", "", "`image` is missing"),
        ("negate: 0", "negate: 2", "`negate` must be 0 or 1, found 2"),
        ("free_thresh: 0.196", "free_thresh: 0.8", "`free_thresh` is 0.8, above `occupied_thresh`, 0.65"),
        ("free_thresh: 0.196", "free_thresh: 1.8", "must be from 0 to 1, found 1.8"),
        ("[-1.0, 2.0, 0.0]", "[-1.0, 2.0]", "`origin` must be three finite numbers up to 1,000,000, found [-1.0, 2.0]"),
        ("[-1.0, 2.0, 0.0]", "[-1.0, 2.0, 0.0", "a list that is not closed"),
        ("[-1.0, 2.0, 0.0]", "", "`origin` must be three finite numbers"),
        ("negate: 0", "mode: trinery\nnegate: 0", "unknown mode `trinery`, did you mean `trinary`?"),
        ("negate: 0", "negate: 0\nnegate: 0", "`negate` stands here a second time"),
        ("negate: 0", "  negate: 0", "keys stand at the beginning"),
        ("negate: 0", "hello", "no `key: value` in this line"),
    ] {
        let error = fault(&YAML.replace(from, to));
        assert!(error.contains(part), "{error}\nshould say: {part}");
    }
}

#[test]
fn a_turned_map_keeps_its_walls_where_they_are() {
    // A wall along the lower edge of the image; turned by 90° it stands along x = -1.
    let mut bytes = b"P5 6 4 255\n".to_vec();
    bytes.extend([255; 18]);
    bytes.extend([0; 6]);
    let image = GreyImage::decode(&bytes).expect("a fine image");
    let grid = map(&YAML.replace("2.0, 0.0]", "2.0, 1.5707963267948966]")).grid(&image);
    assert_eq!((grid.columns, grid.rows), (4, 6));
    for step in 0..6 {
        let along = 2.25 + 0.5 * f64::from(step);
        assert_eq!(grid.at(Point::new(-1.25, along)), Occupied);
        assert_eq!(grid.at(Point::new(-2.25, along)), Free);
    }
    let slanted = map(&YAML.replace("2.0, 0.0]", "2.0, 0.5]")).grid(&image);
    let occupied = slanted.cells.iter().filter(|&&cell| cell == Occupied).count();
    assert!((6..=20).contains(&occupied), "{occupied}");
}

/// A room of 6 m by 4 m with unknown space to its right.
fn recorded() -> OccupancyGrid {
    let mut grid = OccupancyGrid::filled(Point::new(-3.0, 5.0), 0.1, 80, 40, Free);
    for row in 0..40 {
        for column in 0..80 {
            let is_wall = row == 0 || row == 39 || column == 0 || column == 59;
            grid.set(
                column,
                row,
                if column > 59 {
                    Unknown
                } else if is_wall {
                    Occupied
                } else {
                    Free
                },
            );
        }
    }
    grid
}

#[test]
fn a_recorded_map_is_a_world_in_its_own_frame() {
    let world = World::from_map("lab", recorded(), 0.265).expect("there is room");
    assert_eq!(world.map(0.1).cells, recorded().cells);
    assert!(world.start_in_map.point().x > -2.0 && world.bounds().contains(world.start_in_map.point()));
    let walls: f64 = world
        .solids()
        .iter()
        .map(|solid| {
            let bounds = solid.outline.bounds();
            (bounds.max.x - bounds.min.x) * (bounds.max.y - bounds.min.y)
        })
        .sum();
    let cells = recorded().cells.iter().filter(|&&cell| cell == Occupied).count();
    assert!((walls - cells as f64 * 0.01).abs() < 1e-9);
    let full = OccupancyGrid::filled(Point::origin(), 0.1, 10, 10, Occupied);
    assert!(World::from_map("full", full, 0.265).is_err());
}

#[test]
fn a_world_file_may_take_its_walls_from_a_map() {
    let text = "name = \"lab\"\nmap = \"map.yaml\"\nstart = [-1.0, 7.0, 0.0]\n";
    let load = |name: &str| if name == "map.yaml" { Ok(recorded()) } else { Err(format!("no file {name}")) };
    let world = World::parse_with_map(text, "lab.toml", load).expect("a fine world");
    assert_eq!(world.origin_in_map, Point::new(-3.0, 5.0));
    let faults = |text: &str| World::parse_with_map(text, "lab.toml", load).expect_err("a fault").to_string();
    assert!(faults(&text.replace("map.yaml", "x.yaml")).contains("lab.toml:2:7: no file x.yaml"));
    assert!(faults(&format!("size = [1.0, 1.0]\n{text}")).contains("either `size` or `map`"));
    assert!(faults(&text.replace("-1.0, 7.0", "0.0, 0.0")).contains("reaches from (-3, 5) to (5, 9)"));
    let text = text.replace("-1.0, 7.0", "-2.8, 7.0");
    let beside = World::parse_with_map(&text, "lab.toml", load).expect("a small robot has room there");
    assert!(beside.room_at_start(0.05).is_ok());
    let taken = beside.room_at_start(0.265).expect_err("a large one has not");
    let told = taken.in_file("lab.toml", &text).to_string();
    assert!(told.starts_with("lab.toml:3:9: the start is in the way of a wall"), "{told}");
    assert!(told.contains("leave 0.265 m around the start free"), "{told}");
}

/// A building of 12 m by 10 m in a field of 20 m by 16 m, drawn in three greys.
fn building(wall: u8, outside: u8, floor: u8) -> GreyImage {
    let mut bytes = b"P5 200 160 255\n".to_vec();
    bytes.extend((0..160 * 200).map(|index| {
        let (column, row) = (index % 200, index / 200);
        let is_inside = (40..160).contains(&column) && (30..130).contains(&row);
        let is_wall = is_inside && !((42..158).contains(&column) && (32..128).contains(&row));
        if is_wall {
            wall
        } else if is_inside {
            floor
        } else {
            outside
        }
    }));
    GreyImage::decode(&bytes).expect("a fine image")
}

fn warnings(map: &RosMap, image: &GreyImage) -> String {
    Greys::of(map, image).warnings().join("\n")
}

#[test]
fn greys_that_mean_something_else_are_told_with_what_to_write() {
    let usual = map(YAML);
    assert_eq!(warnings(&usual, &building(0, 205, 254)), "");
    // Each pair: what is said, and the keys that mend it.
    for (greys, said, mended) in [
        ((100, 205, 254), "nothing in the map is occupied", "occupied_thresh: 0.4"),
        ((0, 211, 255), "the map is free along 100 % of its edge", "free_thresh: 0.09"),
        ((0, 60, 128), "nothing in the map is free", "free_thresh: 0.57"),
        ((255, 128, 0), "more of the map is occupied, 35 %, than free, 3 %; if black is free", "negate: 1"),
    ] {
        let image = building(greys.0, greys.1, greys.2);
        let told = warnings(&usual, &image);
        assert!(told.contains(said) && told.contains(mended), "{greys:?}: {told}");
        let (key, value) = mended.split_once(": ").expect("a key and a value");
        let lines = YAML.lines().map(|line| match line.starts_with(key) {
            true => format!("{key}: {value}\n"),
            false => format!("{line}\n"),
        });
        let again = map(&lines.collect::<String>());
        assert!(!warnings(&again, &image).contains(said), "{greys:?}: {}", warnings(&again, &image));
    }
    let raw = map(&format!("{YAML}mode: raw\n"));
    assert!(warnings(&raw, &building(110, 205, 254)).contains("an ordinary map has `mode: trinary`"));
    let legend = Greys::of(&usual, &building(0, 205, 254)).legend();
    assert!(legend.ends_with("greys: 0 occupied, 205 unknown, 254 free"), "{legend}");
}

#[test]
fn the_robot_starts_in_the_largest_piece_of_floor_and_off_what_is_not_known() {
    let small = YAML.replace("0.5", "0.05").replace("-1.0, 2.0", "0, 0");
    // Walls that are not dark enough, and a field around them that is free: the start is not in its corner.
    for greys in [(100, 255, 255), (100, 205, 254), (0, 205, 254)] {
        let grid = map(&small).grid(&building(greys.0, greys.1, greys.2));
        let start = World::from_map("w", grid, 0.265).expect("there is room").start_in_map.point();
        assert!((start.x - 5.0).abs() < 3.0 && (start.y - 4.0).abs() < 2.5, "{greys:?}: {start}");
    }
}

#[test]
fn a_map_no_robot_can_drive_in_is_refused_with_its_size() {
    let image = building(0, 205, 254);
    for (resolution, part) in
        [("1e300", "m are a map of"), ("1e-9", "map of 0.000 m by 0.000 m"), ("20", "map of 4000.000 m")]
    {
        let error = map(&YAML.replace("0.5", resolution)).check_size(&image).expect_err(resolution).to_string();
        assert!(error.contains(part) && error.contains("set `resolution`"), "{error}");
    }
    assert_eq!(map(YAML).check_size(&image), Ok(()));
    assert!(fault(&YAML.replace("-1.0, 2.0", "1e308, 2.0")).contains("up to 1,000,000"));
}

#[test]
fn an_image_that_claims_more_than_it_has_takes_no_memory() {
    let png = |columns: u32, rows: u32, color: png::ColorType, extra: Option<&[u8]>| {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, columns, rows);
        encoder.set_color(color);
        let mut writer = encoder.write_header().expect("a header");
        if let Some(text) = extra {
            writer.write_chunk(png::chunk::zTXt, text).expect("a chunk");
        }
        drop(writer);
        bytes
    };
    for (columns, rows) in [(1_000_000_000, 1_000_000_000), (30_000, 30_000), (1, 2_000_000_000)] {
        let error =
            GreyImage::decode(&png(columns, rows, png::ColorType::Rgba, None)).expect_err("too large").to_string();
        assert!(error.contains("crop or shrink it"), "{error}");
    }
    // Text in an image is not read, whatever it inflates to.
    let mut bomb = b"Comment\0\0".to_vec();
    bomb.extend([0x78, 0x9c, 0xff, 0xff]);
    let error =
        GreyImage::decode(&png(4, 4, png::ColorType::Grayscale, Some(&bomb))).expect_err("no pixels").to_string();
    assert!(error.contains("truncated or damaged"), "{error}");
}
