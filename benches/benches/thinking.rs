//! What thinking costs a mission whose host is in another process: the longest that commands come behind the percept they
//! answer, by the clock on the wall, while nine plans are compared again and again.

use rpl_benches::{Question, Report};
use rpl_lang::compile::NoFiles;
use rpl_link::tcp_client::TcpHost;
use rpl_link::tcp_server::{PATIENCE, Service, serve};
use rpl_link::thinker::Thinker;
use rpl_link::transcript::{Kept, Transcript};
use rpl_mission::site::{Setup, Site};
use rpl_protocol::host::{MissionHello, PROTOCOL};
use rpl_protocol::remote_host::RemoteHost;
use rpl_robot::world::World;
use rpl_runtime::run::system::{Outcome, Progress};
use std::net::TcpListener;
use std::sync::Arc;
use std::thread;

/// Drives, and compares nine plans again and again meanwhile, each by sixty runs of up to an hour.
const THINK: &str = "
    (defvar work '(seq (go-to 'mail-slots) (go-to 'a-desk) (go-to 'c-centre) (go-to 'mail-slots) (go-to 'a-desk)
                       (go-to 'c-centre) (go-to 'mail-slots) (go-to 'a-desk) (go-to 'c-centre) (wait-time 30min)))
    (defun others ()
      (map (lambda (n) (list 'seq (list 'wait-time n) work)) (range 1 9)))
    (defvar thought 0)
    (pursue (wait-time 10)
            (loop (go-to 'mail-slots) (go-to 'a-desk))
            (loop (compare-all work (others) :runs 60 :margin -1) (incf thought)))
    (unless (> thought 3) (fail \"hardly anything was thought about\"))";

/// Milliseconds from a percept to the commands that answer it, the most of ten seconds.
fn longest_answer_ms(site: &Site) -> f64 {
    let robot = &site.office().expect("there is a robot").settings.robot;
    let (name, period_us) = (robot.name.to_string(), robot.step_us);
    let service = Service {
        robot: name.clone(),
        period_us,
        factor: 1.0,
        until_us: None,
        once: true,
        start_known: true,
        patience: PATIENCE,
        token: None,
    };
    let listener = TcpListener::bind("127.0.0.1:0").expect("there is a port");
    let address = listener.local_addr().expect("it has an address").to_string();
    let mut world = site.office_robot(1).expect("there is a world").host;
    let served = thread::spawn(move || serve(&mut world, listener, service, &|| false, &mut |_| ()));
    let (rpl, mission) = ("bench".to_string(), None);
    let hello = MissionHello { protocol: PROTOCOL, rpl, robot: name, mission, token: None };
    let (_, host) = TcpHost::connect(&address, hello).unwrap_or_else(|fault| panic!("{fault:?}"));
    let line = Arc::new(Transcript::live("host", Box::new(host), Kept::Last, None));
    let thinking = Arc::new(Transcript::live("thinking", Box::new(Thinker::default()), Kept::Last, None));
    let host = RemoteHost::new(&address, line, thinking, robot.clone());
    let plan = site.compile("think.rpl", THINK, &mut NoFiles).expect("the plan is right");
    let mut system = site.start_traced_with(site.robot_of(host, true, 1).expect("there is a world"), plan, 1);
    while system.advance() == Progress::Running {}
    assert!(matches!(system.outcome(), Some(Outcome::Succeeded(_))), "{:?}", system.outcome());
    drop(system);
    let record = served.join().expect("it serves").expect("it listens");
    record.latencies_s.iter().fold(0.0, |longest: f64, &latency_s| longest.max(f64::from(latency_s))) * 1e3
}

fn main() {
    let report = Report::from_arguments();
    let site = Site::new(Setup { world: World::builtin("dept"), ..Setup::default() }).expect("the robot has room");
    let what = "the longest that commands come behind a percept while plans are compared";
    report.row(Question::new("thinking", what, "ms", 50.0, "–"), || longest_answer_ms(&site));
}
