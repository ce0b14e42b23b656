use super::{Notice, PATIENCE, Service, ServiceRecord, serve};
use crate::message_lines::{LINE, MessageLines, ReadLine};
use crossbeam::channel::{Sender, bounded};
use rpl_protocol::guard::Halt;
use rpl_protocol::host::{Bye, CommandsMessage, FromHost, MissionHello, PROTOCOL, ToHost, read, written};
use rpl_protocol::token::Token;
use rpl_robot::geometry::Pose;
use rpl_robot::office::{Host, HostLost, Report};
use rpl_robot::simulator::{Commands, GripperMotion, GripperStatus, Percept};
use std::collections::VecDeque;
use std::io::Write;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::thread;
use std::time::Duration;

/// A host that makes one step.
struct Mayfly {
    steps: u64,
}

impl Host for Mayfly {
    fn step(&mut self, _: &Commands, _: &mut Vec<Report>) -> Result<Percept, HostLost> {
        self.steps += 1;
        if self.steps > 1 {
            return Err(HostLost("the wheels say nothing".to_string()));
        }
        Ok(Percept {
            time_us: 1_000,
            odometry_in_odom: Pose::default(),
            translation_mps: 0.0,
            rotation_radps: 0.0,
            sonar_m: None,
            laser_m: None,
            camera: None,
            failed: Default::default(),
            bumped: false,
            gripper: GripperStatus { motion: GripperMotion::Open, holding: None },
            battery: 1.0,
            messages: Vec::new(),
            others: Default::default(),
        })
    }
}

/// A host whose robot drives as it is told, at once, and notes whether its motors are off.
#[derive(Default)]
struct Obedient {
    steps: u64,
    drove: u64,
}

impl Host for Obedient {
    fn step(&mut self, commands: &Commands, _: &mut Vec<Report>) -> Result<Percept, HostLost> {
        self.steps += 1;
        self.drove += u64::from(!commands.motors_off);
        Ok(Percept { time_us: self.steps * 1_000, ..Mayfly { steps: 0 }.step(commands, &mut Vec::new())? })
    }
}

fn service(patience: Duration) -> Service {
    Service {
        robot: "fly".to_string(),
        period_us: 1_000,
        factor: 1.0,
        until_us: None,
        once: false,
        start_known: false,
        patience,
        token: None,
    }
}

fn hello() -> MissionHello {
    let (rpl, robot) = ("1".to_string(), "fly".to_string());
    MissionHello { protocol: PROTOCOL, rpl, robot, mission: Some("a\nb".to_string()), token: None }
}

/// A host that is served in a thread of its own until somebody says that it is to end.
struct Served {
    address: SocketAddr,
    ends: Sender<()>,
    serving: thread::JoinHandle<(Obedient, ServiceRecord, Vec<Notice>)>,
}

impl Served {
    fn start(service: Service) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address");
        let (ends, ended) = bounded::<()>(1);
        let serving = thread::spawn(move || {
            let (mut host, mut notices) = (Obedient::default(), Vec::new());
            let tell = &mut |notice| notices.push(notice);
            let record = serve(&mut host, listener, service, &|| !ended.is_empty(), tell).expect("a listener");
            (host, record, notices)
        });
        Self { address, ends, serving }
    }

    fn connect(&self) -> Client {
        let stream = TcpStream::connect(self.address).expect("somebody listens");
        let lines = MessageLines::new(stream.try_clone().expect("a second handle"), LINE);
        Client { stream, lines }
    }

    fn end(self) -> (Obedient, ServiceRecord, Vec<Notice>) {
        self.ends.send(()).expect("it serves");
        self.serving.join().expect("it ends")
    }
}

struct Client {
    stream: TcpStream,
    lines: MessageLines,
}

impl Client {
    fn say(&mut self, message: &ToHost) {
        self.stream.write_all(written(message).as_bytes()).expect("it hears");
    }

    /// Wants to drive; whether that can still be said.
    fn command(&mut self, number: u64) -> bool {
        let driving = Commands { translation_mps: 1.0, ..Commands::default() };
        let message = ToHost::Commands(CommandsMessage::new(number, &driving));
        self.stream.write_all(written(&message).as_bytes()).is_ok()
    }

    fn hear(&mut self) -> Option<FromHost> {
        match self.lines.next(None) {
            ReadLine::Text(line) => Some(read(&line).expect("a message")),
            ReadLine::End | ReadLine::Silence | ReadLine::Fault(_) => None,
        }
    }

    /// Why it has to go, whatever it hears before.
    fn goodbye(&mut self) -> String {
        loop {
            match self.hear().expect("it says why") {
                FromHost::Bye(bye) => return bye.reason.expect("there is a reason"),
                FromHost::Hello(_) | FromHost::Percept(_) => {}
            }
        }
    }

    /// Says nothing whole, a byte now and then, until it has to go.
    fn drip(&mut self) -> String {
        self.stream.set_nonblocking(true).expect("it may be set");
        while self.stream.write_all(b"x").is_ok() && self.stream.peek(&mut [0]).is_err() {
            thread::park_timeout(Duration::from_millis(3));
        }
        self.stream.set_nonblocking(false).expect("it may be set");
        self.goodbye()
    }
}

/// As long as tests wait for what has to come.
const SHORT: Duration = Duration::from_millis(120);

#[test]
fn who_is_silent_or_drips_before_a_greeting_keeps_nobody_from_the_robot() {
    let served = Served::start(service(SHORT));
    let (mut silent, mut dripping) = (served.connect(), served.connect());
    let mut mission = served.connect();
    mission.say(&ToHost::Hello(hello()));
    assert!(matches!(mission.hear(), Some(FromHost::Hello(_))), "the robot is free");
    let why = silent.goodbye();
    assert!(why.contains("has not greeted within 0.1 s"), "{why}");
    let why = dripping.drip();
    assert!(why.contains("within 0.1 s"), "{why}");
    served.end();
}

#[test]
fn a_mission_that_is_silent_or_drips_loses_the_robot() {
    let served = Served::start(service(SHORT));
    for drips in [false, true] {
        let mut mission = served.connect();
        mission.say(&ToHost::Hello(hello()));
        mission.command(0);
        let why = if drips { mission.drip() } else { mission.goodbye() };
        let either = ["has given no commands for 0.1 s", "a line that has not ended within 0.1 s"];
        assert!(either.iter().any(|expected| why.contains(expected)), "{why}");
    }
    let (_, record, _) = served.end();
    assert_eq!((record.missions, record.halts.closed_lines), (2, 2));
}

#[test]
fn a_mission_that_does_not_take_in_what_the_robot_perceives_does_not_drive_it_on() {
    let served = Served::start(Service { period_us: 10_000, ..service(Duration::from_millis(400)) });
    let mut mission = served.connect();
    mission.say(&ToHost::Hello(hello()));
    mission.command(0);
    assert!(matches!(mission.hear(), Some(FromHost::Hello(_))));
    // It reads, and decides by the first percept for ever: the line shows nothing of that.
    while let Some(FromHost::Percept(_)) = mission.hear()
        && mission.command(1)
    {}
    let (host, record, notices) = served.end();
    assert!(notices.contains(&Notice::Halted(Halt::Silence)), "{notices:?}");
    assert!(record.halts.silences == 1 && host.drove < 100, "it drove for {} steps of 0.01 s", host.drove);
    let has_lost_it = |notice: &Notice| matches!(notice, Notice::Went(why) if why.contains("given no commands"));
    assert!(notices.iter().any(has_lost_it), "{notices:?}");
}

#[test]
fn what_was_never_said_is_not_answered() {
    let served = Served::start(service(SHORT));
    let mut mission = served.connect();
    mission.say(&ToHost::Hello(hello()));
    mission.command(1_000_000);
    let why = mission.goodbye();
    assert!(why.contains("it answers up to percept 1000000"), "{why}");
    served.end();
}

#[test]
fn who_finds_the_robot_in_use_hears_by_whom_and_nothing_is_forged() {
    let served = Served::start(service(Duration::from_secs(60)));
    let mut mission = served.connect();
    mission.say(&ToHost::Hello(hello()));
    assert!(matches!(mission.hear(), Some(FromHost::Hello(_))));
    let mut second = served.connect();
    second.say(&ToHost::Hello(hello()));
    let (why, from) = (second.goodbye(), mission.stream.local_addr().expect("it has one"));
    assert!(why.contains(&format!("another mission is here: `a\\nb` from {from}, since 0 s")), "{why}");
    mission.say(&ToHost::Bye(Bye { reason: Some("\u{1b}[2J\nerror: forged\u{202e}".to_string()) }));
    mission.goodbye();
    let (_, _, notices) = served.end();
    let told = "it says goodbye: \\u{1b}[2J\\nerror: forged\\u{202e}";
    assert!(notices.contains(&Notice::Went(told.to_string())), "{notices:?}");
}

#[test]
fn only_who_knows_the_token_is_served_and_nobody_else_learns_who_is() {
    let token = |text: &str| Some(Token::new(text).expect("a token"));
    let served = Served::start(Service { token: token("0123456789abcdef"), ..service(Duration::from_secs(60)) });
    let mut mission = served.connect();
    mission.say(&ToHost::Hello(MissionHello { token: token("0123456789abcdef"), ..hello() }));
    assert!(matches!(mission.hear(), Some(FromHost::Hello(_))));
    for (said, expected) in [(None, "has no token"), (token("0123456789abcdeF"), "has another token")] {
        let mut stranger = served.connect();
        stranger.say(&ToHost::Hello(MissionHello { token: said, ..hello() }));
        let why = stranger.goodbye();
        assert!(why.contains(expected) && !why.contains("another mission"), "{why}");
    }
    served.end();
}

#[test]
fn hundreds_who_connect_and_say_nothing_keep_no_mission_out_and_are_told_of_in_a_few_lines() {
    let served = Served::start(service(Duration::from_secs(60)));
    // More than may stand at the door.
    let mut silent = VecDeque::new();
    let mut connect = |count| {
        for _ in 0..count {
            silent.push_back(TcpStream::connect(served.address).expect("it listens"));
            if silent.len() > 200 {
                silent.pop_front();
            }
        }
    };
    connect(400);
    let mut mission = served.connect();
    mission.say(&ToHost::Hello(hello()));
    assert!(matches!(mission.hear(), Some(FromHost::Hello(_))));
    connect(400);
    mission.command(0);
    assert!(matches!(mission.hear(), Some(FromHost::Percept(_))), "it still has the robot");
    let (_, _, notices) = served.end();
    let lines = notices.iter().filter(|notice| matches!(notice, Notice::Refused(_) | Notice::RefusedMore(_)));
    assert!(lines.count() < 100, "{notices:?}");
}

#[test]
fn a_line_of_a_thousand_megabytes_is_refused_after_one() {
    let served = Served::start(service(Duration::from_secs(60)));
    let mut client = served.connect();
    let sent = (0..1_000).take_while(|_| client.stream.write_all(&[b'x'; 1 << 20]).is_ok()).count();
    assert!(sent < 100, "{sent} MiB were taken");
    served.end();
}

#[test]
fn a_mission_is_told_why_its_host_is_lost() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address");
    let mission = thread::spawn(move || {
        let mut stream = TcpStream::connect(address).expect("somebody listens");
        let commands = CommandsMessage::new(0, &Commands::default());
        for message in [ToHost::Hello(hello()), ToHost::Commands(commands)] {
            stream.write_all(written(&message).as_bytes()).expect("it hears");
        }
        let mut lines = MessageLines::new(stream, LINE);
        std::iter::from_fn(|| match lines.next(None) {
            ReadLine::Text(line) => Some(read(&line).expect("a message")),
            ReadLine::End | ReadLine::Silence | ReadLine::Fault(_) => None,
        })
        .collect::<Vec<FromHost>>()
    });
    let service = service(PATIENCE);
    let record = serve(&mut Mayfly { steps: 0 }, listener, service, &|| false, &mut |_| {}).expect("a listener");
    let told = mission.join().expect("a mission");
    assert!(matches!(&told[0], FromHost::Hello(hello) if !hello.start_known), "{told:?}");
    assert!(matches!(&told[1], FromHost::Percept(percept) if percept.number == 0), "{told:?}");
    let why = "the wheels say nothing".to_string();
    assert_eq!(told[2..], [FromHost::Bye(Bye { reason: Some(why.clone()) })]);
    assert_eq!((record.percepts, record.lost), (1, Some(HostLost(why))));
}
