//! `rpl localize` on recordings as robots write them: one small drive in many variants, each of which must give the same
//! table.

use crate::folder::{folder, put, text_in};
use crate::localize::{put_room, range_m};
use crate::rpl::run_in;
use flate2::Compression;
use flate2::write::GzEncoder;
use lz4_flex::frame::FrameEncoder;
use mcap::records::{self, MessageHeader};
use mcap::{WriteOptions, Writer};
use rpl_ros_messages::messages::{
    Header, LaserScan, Odometry, Point, Pose, PoseStamped, PoseWithCovariance, PoseWithCovarianceStamped, Quaternion,
    Time,
};
use rpl_ros_messages::{Message, cdr};
use ruzstd::encoding::{CompressionLevel, compress_to_vec};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fs;
use std::io::{Cursor, Write};
use std::path::Path;

/// The clock of the robot at the start.
const START_NS: u64 = 1_700_000_000_000_000_000;

/// How far the laser sees: some of the walls are farther away.
const RANGE_M: f32 = 3.5;

const READINGS: usize = 181;

/// Where the robot is after a while: rounds of 7 m around the pillar, at half a metre a second.
fn pose_at(after_ns: u64) -> (f64, f64, f64) {
    let turn = TAU * after_ns as f64 / 14e9;
    let (x_m, y_m) = (2.6 + 1.8 * turn.cos(), 2.1 + 0.9 * turn.sin());
    (x_m, y_m, (0.9 * turn.cos()).atan2(-1.8 * turn.sin()))
}

fn header(after_ns: u64, frame: &str) -> Header {
    let stamp_ns = START_NS + after_ns;
    let stamp = Time { sec: (stamp_ns / 1_000_000_000) as i32, nanosec: (stamp_ns % 1_000_000_000) as u32 };
    Header { stamp, frame_id: frame.to_string() }
}

fn pose((x, y, heading_rad): (f64, f64, f64)) -> Pose {
    let (sin, cos) = (heading_rad / 2.0).sin_cos();
    let orientation = Quaternion { z: sin, w: cos, ..Quaternion::default() };
    Pose { position: Point { x, y, z: 0.0 }, orientation }
}

/// A message as it stands in a file.
#[derive(Clone)]
struct Written {
    topic: &'static str,
    kind: &'static str,
    definition: String,
    time_ns: u64,
    bytes: Vec<u8>,
}

fn written<M: Message + Serialize>(topic: &'static str, after_ns: u64, message: &M) -> Written {
    let time_ns = START_NS + after_ns;
    Written { topic, kind: M::NAME, definition: M::definition(), time_ns, bytes: cdr(message) }
}

/// How a variant differs from the plain recording.
struct Variant {
    scan: fn(usize, LaserScan) -> LaserScan,
    truth: fn(&'static str, u64) -> Written,
    topics: [&'static str; 3],
    /// Between two references.
    truth_every_ns: u64,
}

impl Variant {
    const PLAIN: Self = Self {
        scan: |_, scan| scan,
        truth: stamped,
        topics: ["/scan", "/odom", "/ground_truth"],
        truth_every_ns: 100_000_000,
    };

    /// The messages in order of time; the scans lie between those of odometry and reference.
    fn messages(&self) -> Vec<Written> {
        let [scan_topic, odom_topic, truth_topic] = self.topics;
        let mut messages = Vec::new();
        for tick in 0..=280_u64 {
            let after_ns = tick * 100_000_000;
            let (x_m, y_m, heading_rad) = pose_at(after_ns);
            // Another origin, and no drift.
            let in_odom = pose((y_m + 40.0, 7.0 - x_m, heading_rad - TAU / 4.0));
            let odom = Odometry {
                header: header(after_ns, "odom"),
                pose: PoseWithCovariance { pose: in_odom, ..PoseWithCovariance::default() },
                ..Odometry::default()
            };
            messages.push(written(odom_topic, after_ns, &odom));
            if after_ns.is_multiple_of(self.truth_every_ns) {
                messages.push((self.truth)(truth_topic, after_ns));
            }
            if tick % 2 == 0 && tick < 280 {
                let taken_ns = after_ns + 60_000_000;
                messages.push(written(scan_topic, taken_ns, &(self.scan)(tick as usize / 2, scan(taken_ns))));
            }
        }
        messages
    }
}

/// What the laser says: no echo is infinite.
fn scan(after_ns: u64) -> LaserScan {
    let (x_m, y_m, heading_rad) = pose_at(after_ns);
    let ranges = (0..READINGS).map(|reading| {
        let bearing_rad = (reading as f64 - 90.0).to_radians();
        let range_m = range_m(x_m, y_m, heading_rad + bearing_rad) as f32;
        if range_m < RANGE_M { range_m } else { f32::INFINITY }
    });
    LaserScan {
        header: header(after_ns, "base_scan"),
        angle_min: (-90.0f32).to_radians(),
        angle_max: 90.0f32.to_radians(),
        angle_increment: 1.0f32.to_radians(),
        scan_time: 0.2,
        range_min: 0.12,
        range_max: RANGE_M,
        ranges: ranges.collect(),
        ..LaserScan::default()
    }
}

fn stamped(topic: &'static str, after_ns: u64) -> Written {
    written(topic, after_ns, &PoseStamped { header: header(after_ns, "map"), pose: pose(pose_at(after_ns)) })
}

fn as_odometry(topic: &'static str, after_ns: u64) -> Written {
    let pose = PoseWithCovariance { pose: pose(pose_at(after_ns)), ..PoseWithCovariance::default() };
    written(topic, after_ns, &Odometry { header: header(after_ns, "map"), pose, ..Odometry::default() })
}

fn with_covariance(topic: &'static str, after_ns: u64) -> Written {
    let pose = PoseWithCovariance { pose: pose(pose_at(after_ns)), ..PoseWithCovariance::default() };
    written(topic, after_ns, &PoseWithCovarianceStamped { header: header(after_ns, "map"), pose })
}

fn echoless(scan: LaserScan, no_echo_m: f32) -> LaserScan {
    let ranges = scan.ranges.iter().map(|&range_m| if range_m.is_finite() { range_m } else { no_echo_m });
    LaserScan { ranges: ranges.collect(), ..scan }
}

/// An MCAP file in chunks.
fn file(messages: &[Written]) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    let options = WriteOptions::new().compression(None).profile("ros2").chunk_size(Some(100_000));
    let mut writer: Writer<_> = options.create(&mut bytes).expect("it is in memory");
    let mut channels = BTreeMap::new();
    for (sequence, message) in messages.iter().enumerate() {
        let channel_id = *channels.entry((message.topic, message.kind)).or_insert_with(|| {
            let definition = message.definition.as_bytes();
            let schema = writer.add_schema(message.kind, "ros2msg", definition).expect("it is in memory");
            writer.add_channel(schema, message.topic, "cdr", &BTreeMap::new()).expect("it is in memory")
        });
        let (log_time, publish_time) = (message.time_ns, message.time_ns);
        let header = MessageHeader { channel_id, sequence: sequence as u32, log_time, publish_time };
        writer.write_to_known_channel(&header, &message.bytes).expect("it is in memory");
    }
    writer.finish().expect("it is in memory");
    drop(writer);
    bytes.into_inner()
}

/// The same file with its chunks packed, and without an index, whose offsets would be those of before.
fn with_packed_chunks(file: &[u8], compression: &str, pack: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let mut packed = mcap::MAGIC.to_vec();
    let mut put = |opcode: u8, body: &[u8]| {
        packed.push(opcode);
        packed.extend_from_slice(&(body.len() as u64).to_le_bytes());
        packed.extend_from_slice(body);
    };
    let text = |text: &str| [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat();
    put(records::op::HEADER, &[text("ros2"), text("")].concat());
    for record in mcap::read::LinearReader::new(file).expect("it is whole") {
        if let records::Record::Chunk { header, data } = record.expect("it is whole") {
            let data = pack(&data);
            let body = [
                &header.message_start_time.to_le_bytes()[..],
                &header.message_end_time.to_le_bytes(),
                &header.uncompressed_size.to_le_bytes(),
                &header.uncompressed_crc.to_le_bytes(),
                &text(compression),
                &(data.len() as u64).to_le_bytes(),
                &data,
            ];
            put(records::op::CHUNK, &body.concat());
        }
    }
    put(records::op::DATA_END, &[0; 4]);
    put(records::op::FOOTER, &[0; 20]);
    packed.extend_from_slice(mcap::MAGIC);
    packed
}

fn zstd(bytes: &[u8]) -> Vec<u8> {
    compress_to_vec(bytes, CompressionLevel::Fastest)
}

fn lz4(bytes: &[u8]) -> Vec<u8> {
    let mut packed = FrameEncoder::new(Vec::new());
    packed.write_all(bytes).expect("it is in memory");
    packed.finish().expect("it is in memory")
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packed = GzEncoder::new(Vec::new(), Compression::default());
    packed.write_all(bytes).expect("it is in memory");
    packed.finish().expect("it is in memory")
}

/// What is said of a log, without the time it took.
fn told(folder: &Path, log: &str, more: &[&str]) -> (Value, String) {
    let all = [&["localize", "--map", ".", "--log", log, "--from-truth", "--json"], more].concat();
    let ended = run_in(folder, &all);
    assert_eq!(ended.status, 0, "{log}: {}{}", ended.out, ended.errors);
    let mut told: Value = serde_json::from_str(&ended.out).expect("JSON");
    told["windows"][0]["time_s"] = Value::Null;
    (told, ended.errors)
}

fn number(told: &Value, path: &str) -> f64 {
    told.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {told}"))
}

/// The figures of both are the same within a centimetre.
fn assert_near(name: &str, told: &Value, plain: &Value) {
    for path in
        ["/while_found/position_m/mean", "/windows/0/final_error_m", "/windows/0/ends_at/0", "/windows/0/ends_at/1"]
    {
        let (one, other) = (number(told, path), number(plain, path));
        assert!((one - other).abs() < 0.01, "{name}: {path} is {one} and not {other}");
    }
    assert_eq!(number(told, "/windows/0/scans"), number(plain, "/windows/0/scans"), "{name}");
}

#[test]
fn a_recording_gives_the_same_table_however_a_robot_writes_it() {
    let folder = folder("recordings");
    put_room(&folder);
    let plain_messages = Variant::PLAIN.messages();
    put(&folder, "plain.mcap", file(&plain_messages));
    let (plain, errors) = told(&folder, "plain.mcap", &[]);
    assert!(
        errors.contains(
            "taken: scans of `/scan` (LaserScan, 140), odometry of `/odom` (Odometry, 281), corrected poses of \
             `/ground_truth` (PoseStamped, 281)"
        ),
        "{errors}"
    );
    // Where the robot was when the last scan was taken, and not at a message before it.
    let (x_m, y_m, heading_rad) = pose_at(27_860_000_000);
    let ends_at = [0, 1, 2].map(|at| number(&plain, &format!("/windows/0/ends_at/{at}")));
    let off = [ends_at[0] - x_m, ends_at[1] - y_m, (ends_at[2] - heading_rad).sin()];
    assert!(off.iter().all(|off| off.abs() < 2e-3), "{off:?}");
    // The range is that of this laser: what has no echo is no wall.
    let fitted = run_in(&folder, &["localize", "--map", ".", "--log", "plain.mcap", "--fit", "laser.json"]);
    assert_eq!(fitted.status, 0, "{}", fitted.errors);
    let fitted: Value = serde_json::from_str(&text_in(&folder, "laser.json")).expect("JSON");
    assert_eq!(number(&fitted, "/sensors/0/beam/max_range_m"), 3.5);

    let same: [(&str, Variant); 5] = [
        ("zeros", Variant { scan: |_, scan| echoless(scan, 0.0), ..Variant::PLAIN }),
        ("nan", Variant { scan: |_, scan| echoless(scan, f32::NAN), ..Variant::PLAIN }),
        ("beyond", Variant { scan: |_, scan| echoless(scan, RANGE_M + 1.0), ..Variant::PLAIN }),
        ("odometry as truth", Variant { truth: as_odometry, ..Variant::PLAIN }),
        ("covariance", Variant { truth: with_covariance, ..Variant::PLAIN }),
    ];
    for (name, variant) in same {
        put(&folder, "same.mcap", file(&variant.messages()));
        assert_eq!(told(&folder, "same.mcap", &[]).0, plain, "{name}");
    }
    let near: [(&str, Variant); 4] = [
        (
            "clockwise",
            Variant {
                scan: |_, scan| LaserScan {
                    angle_min: scan.angle_max,
                    angle_max: scan.angle_min,
                    angle_increment: -scan.angle_increment,
                    ranges: scan.ranges.iter().rev().copied().collect(),
                    ..scan
                },
                ..Variant::PLAIN
            },
        ),
        (
            "one reading less",
            Variant {
                scan: |number, mut scan| {
                    scan.ranges.truncate(if number % 3 == 1 { READINGS - 1 } else { READINGS });
                    scan
                },
                ..Variant::PLAIN
            },
        ),
        ("a reference each second", Variant { truth_every_ns: 1_000_000_000, ..Variant::PLAIN }),
        (
            "other topics",
            Variant { topics: ["/laser", "/wheels", "/mocap/robot"], truth: with_covariance, ..Variant::PLAIN },
        ),
    ];
    for (name, variant) in near {
        put(&folder, "near.mcap", file(&variant.messages()));
        assert_near(name, &told(&folder, "near.mcap", &[]).0, &plain);
    }

    let bytes = file(&plain_messages);
    let mut disordered = plain_messages.clone();
    disordered.sort_by_key(|message| (message.kind, u64::MAX - message.time_ns));
    let cut = [&bytes[..bytes.len() - 300]].concat();
    for (name, file) in [
        ("disordered.mcap", file(&disordered)),
        ("packed.mcap.gz", gzip(&bytes)),
        ("packed.log", zstd(&bytes)),
        ("zstd.mcap", with_packed_chunks(&bytes, "zstd", zstd)),
        ("lz4.mcap", with_packed_chunks(&bytes, "lz4", lz4)),
        ("cut.mcap", cut),
    ] {
        put(&folder, name, file);
        let (said, errors) = told(&folder, name, &[]);
        assert_eq!(said, plain, "{name}");
        assert_eq!(errors.contains("was not written to its end"), name == "cut.mcap", "{errors}");
    }
    let bag = folder.join("bag");
    fs::create_dir(&bag).expect("the folder can be made");
    put(&bag, "metadata.yaml", "rosbag2_bagfile_information: {}\n");
    let (first, second) = plain_messages.split_at(300);
    put(&bag, "bag_0.mcap", file(first));
    put(&bag, "bag_1.mcap", with_packed_chunks(&file(second), "zstd", zstd));
    assert_eq!(told(&folder, "bag", &[]).0, plain, "a folder");
}

#[test]
fn topics_are_listed_where_several_fit_and_named_by_options() {
    let folder = folder("recordings-topics");
    put_room(&folder);
    let mut messages = Variant { topics: ["/front", "/odom", "/ground_truth"], ..Variant::PLAIN }.messages();
    let rear = Variant { topics: ["/rear", "/odom", "/goal_pose"], ..Variant::PLAIN }.messages();
    messages.extend(rear.into_iter().filter(|message| message.topic != "/odom"));
    put(&folder, "two.mcap", file(&messages));
    let log = ["localize", "--map", ".", "--log", "two.mcap"];
    let several = run_in(&folder, &log);
    assert_eq!(several.status, 2);
    let said = "it has 2 topics of scans; say which: `--scan /front` (LaserScan), `--scan /rear` (LaserScan)";
    assert!(several.errors.contains(said), "{}", several.errors);
    let (told, errors) = told(&folder, "two.mcap", &["--scan", "/rear", "--truth", "goal_pose", "--odom", "/odom"]);
    assert!(errors.contains("scans of `/rear`") && errors.contains("corrected poses of `/goal_pose`"), "{errors}");
    assert_eq!(number(&told, "/windows/0/scans"), 140.0);
    let none = run_in(&folder, &[&log[..], &["--truth", "/pose"]].concat());
    assert!(none.errors.contains("it has 2 topics of scans"), "{}", none.errors);
    let text = run_in(&folder, &["localize", "--map", ".", "--log", "map.yaml", "--odom", "/odom"]);
    assert!(text.errors.contains("`--odom` names a topic"), "{}", text.errors);
}

#[test]
fn a_container_that_is_not_read_is_named_and_so_is_what_to_type() {
    let folder = folder("recordings-containers");
    put_room(&folder);
    let bag = folder.join("bag");
    fs::create_dir(&bag).expect("the folder can be made");
    put(&bag, "metadata.yaml", "rosbag2_bagfile_information: {}\n");
    put(&bag, "bag_0.db3", b"SQLite format 3\0\x10\0\x01");
    fs::create_dir(folder.join("empty")).expect("the folder can be made");
    let unknown = with_packed_chunks(&file(&Variant::PLAIN.messages()[..50]), "brotli", |bytes| bytes.to_vec());
    let mut apart = Variant::PLAIN.messages();
    apart.retain(|message| message.topic != "/scan" || message.time_ns < START_NS + 100_000_000);
    let damaged = gzip(&file(&Variant::PLAIN.messages()[..50]));
    for (name, content, part) in [
        ("a.log", b"SQLite format 3\0\xff".to_vec(), "ros2 bag convert -i a.log -o to-mcap.yaml"),
        ("b.log", b"#ROSBAG V2.0\n\xff".to_vec(), "rosbags-convert --src b.log --dst b-mcap --dst-storage mcap"),
        ("c.log", gzip(b"SQLite format 3\0\xff"), "ros2 bag convert -i c.log"),
        ("d.log", b"BZh9\xff\xff".to_vec(), "it is packed by bzip2; type `bunzip2 -k d.log`"),
        ("e.log", gzip(&gzip(b"FLASER")), "it is packed twice, by gzip and gzip"),
        ("f.log", unknown, "mcap compress --compression none"),
        ("g.log", damaged[..damaged.len() / 2].to_vec(), "it is packed by gzip, and damaged"),
        ("h.log", file(&apart), "the robot never moves in this log"),
        ("bag", Vec::new(), "ros2 bag convert -i bag -o to-mcap.yaml"),
        ("empty", Vec::new(), "the folder has no MCAP file"),
    ] {
        if !content.is_empty() {
            put(&folder, name, content);
        }
        let ended = run_in(&folder, &["localize", "--map", ".", "--log", name]);
        assert_eq!(ended.status, 2, "{name}");
        assert!(ended.errors.contains(part), "{name}: {}\nshould say: {part}", ended.errors);
        assert!(!ended.errors.contains("UTF-8"), "{}", ended.errors);
    }
}

/// Rounds in the room, with turns at the corners.
const PLAN: &str = "(go-to-point 3.8 1)\n(go-to-point 4.5 3)\n(go-to-point 1 3.2)\n(go-to-point 1 1)\n";

/// The true position in a trace at a time.
fn traced(lines: &[Value], time_s: f64) -> (f64, f64) {
    let poses = lines.iter().filter(|line| line["kind"] == "pose");
    let poses: Vec<[f64; 3]> =
        poses.map(|line| ["/time_s", "/true/0", "/true/1"].map(|path| number(line, path))).collect();
    let after = poses.iter().position(|pose| pose[0] >= time_s).expect("the run is longer").max(1);
    let ([before_s, x0_m, y0_m], [after_s, x1_m, y1_m]) = (poses[after - 1], poses[after]);
    let share = (time_s - before_s) / (after_s - before_s);
    (x0_m + share * (x1_m - x0_m), y0_m + share * (y1_m - y0_m))
}

#[test]
fn a_recording_of_a_run_says_where_the_robot_was_as_its_trace_does() {
    let folder = folder("recordings-run");
    put_room(&folder);
    put(&folder, "lab.toml", "name = \"lab\"\nmap = \"map.yaml\"\nstart = [1.0, 1.0, 0.0]\n");
    put(&folder, "drive.rpl", PLAN);
    let run = ["run", "drive.rpl", "--world", "lab.toml", "--robot", "b21-laser", "-q", "--mcap", "run.mcap"];
    let ended = run_in(&folder, &[&run[..], &["--trace", "run.jsonl", "--trace-poses", "20"]].concat());
    assert_eq!(ended.status, 0, "{}{}", ended.out, ended.errors);
    let trace = text_in(&folder, "run.jsonl");
    let lines: Vec<Value> = trace.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let windows = ["localize", "--world", "lab.toml", "--log", "run.mcap", "--json", "--windows", "8"];
    let ended = run_in(&folder, &[&windows[..], &["--window-length", "0.5"]].concat());
    let told: Value = serde_json::from_str(&ended.out).unwrap_or_else(|_| panic!("{}{}", ended.out, ended.errors));
    for window in told["windows"].as_array().expect("windows") {
        let (ends_s, at) = (number(window, "/ends_s"), ["/ends_at/0", "/ends_at/1"].map(|path| number(window, path)));
        let (x_m, y_m) = traced(&lines, ends_s);
        assert!((at[0] - x_m).hypot(at[1] - y_m) < 0.02, "{window}: the trace has {x_m}, {y_m}");
    }
}
