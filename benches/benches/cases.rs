//! What a retrieval costs, over ten thousand and a hundred thousand cases of a building, in the situations of a
//! robot that drives there; and over the same cases by CBRkit, where it is installed (`pip install
//! cbrkit`, for the `python3` of the path).

use rpl_benches::{Question, Report, median};
use rpl_random::Stream;
use rpl_robot::description::RobotDescription;
use rpl_robot::world::World;
use rpl_rupart::case::{Case, Content, Kind};
use rpl_rupart::control::BehaviourParameters;
use rpl_rupart::file::memory_text;
use rpl_rupart::forgetting::forget_beyond;
use rpl_rupart::memory::CaseMemory;
use rpl_rupart::places::Places;
use rpl_rupart::similarity::{Scales, Similarity};
use rpl_rupart::situation::Situation;
use rpl_rupart::trial::{KindGround, Reason};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// Situations that are asked for in a run, and runs of which the median counts.
const ASKED: usize = 50;
const RUNS: usize = 9;

/// Cases that CBRkit is given: it takes seconds for more.
const FOR_CBRKIT: usize = 10_000;

/// A memory of `count` behaviour cases, and situations to ask for.
fn memory(ground: &KindGround, count: usize) -> (CaseMemory, Vec<Situation>) {
    let mut stream = Stream::new(1, "bench");
    let mut memory = CaseMemory::new(Similarity::new(Scales::default()));
    for _ in 0..count {
        let index = ground.situation(Reason::OnTheWay, &mut stream);
        memory.retain(Case::new(index, Content::Behaviour(BehaviourParameters::default())));
    }
    let asked = (0..ASKED).map(|_| ground.situation(Reason::OnTheWay, &mut stream)).collect();
    (memory, asked)
}

/// Milliseconds of a retrieval.
fn measure(memory: &CaseMemory, asked: &[Situation]) -> f64 {
    let one_run = |_| {
        let began = Instant::now();
        for situation in asked {
            assert!(memory.retrieve(std::hint::black_box(situation)).is_some(), "there are cases");
        }
        began.elapsed().as_secs_f64() * 1e3 / asked.len() as f64
    };
    median((0..RUNS).map(one_run).collect())
}

/// Milliseconds of a retrieval by CBRkit over the same cases; none if it is not installed.
fn measure_cbrkit(memory: &CaseMemory, asked: &Situation) -> Option<f64> {
    let anchors = Path::new(env!("CARGO_MANIFEST_DIR")).join("anchors/cases.py");
    let file = std::env::temp_dir().join(format!("rpl-bench-{}.cases", std::process::id()));
    let mut text = memory_text(memory, "olin-rice", None);
    let mut as_case = CaseMemory::new(memory.similarity().clone());
    as_case.retain(Case::new(asked.clone(), Content::Behaviour(BehaviourParameters::default())));
    // The last line is what is asked for.
    text.extend(memory_text(&as_case, "olin-rice", None).lines().skip(1));
    std::fs::write(&file, text).ok()?;
    let output = Command::new("python3").arg(anchors).arg(&file).output();
    std::fs::remove_file(&file).ok()?;
    let output = output.ok().filter(|output| output.status.success())?;
    String::from_utf8_lossy(&output.stdout).trim().parse().ok()
}

fn main() {
    let report = Report::from_arguments();
    let world = World::builtin("olin-rice").expect("it is built in");
    let robot = RobotDescription::builtin("pioneer-2dx").expect("it is built in");
    let places = Places::new(&world, robot.radius_m).expect("it has places");
    let ground = KindGround::new(world, places, robot);
    let question =
        |name, what, target| Question::new(name, what, "ms", target, "CBRkit 1700 ms over ten thousand cases");
    let retrieve = |count: usize| {
        let (memory, asked) = memory(&ground, count);
        measure(&memory, &asked)
    };
    report.row(question("cases-10k", "a retrieval over ten thousand cases", 0.1), || retrieve(10_000));
    report.row(question("cases-100k", "a retrieval over a hundred thousand cases", 2.0), || retrieve(100_000));
    report.row(question("cases-copy", "a copy of a memory of ten thousand cases, and a case more", 0.1), || {
        let (memory, asked) = memory(&ground, 10_000);
        let one_run = |_| {
            let began = Instant::now();
            let mut copy = memory.clone();
            copy.retain(Case::new(asked[0].clone(), Content::Behaviour(BehaviourParameters::default())));
            began.elapsed().as_secs_f64() * 1e3
        };
        median((0..RUNS).map(one_run).collect())
    });
    report.row(question("cases-forget", "a case learned and one forgotten, of a hundred thousand", 20.0), || {
        let (mut memory, asked) = memory(&ground, 100_000);
        let mut one_run = |run: usize| {
            let began = Instant::now();
            memory.retain(Case::new(asked[run].clone(), Content::Behaviour(BehaviourParameters::default())));
            assert!(forget_beyond(&mut memory, Kind::Behaviour, 100_000, None).is_some(), "there is one too many");
            began.elapsed().as_secs_f64() * 1e3
        };
        median((0..RUNS).map(&mut one_run).collect())
    });
    let (memory, asked) = memory(&ground, FOR_CBRKIT);
    if let Some(ms) = measure_cbrkit(&memory, &asked[0]) {
        println!("{:<12} CBRkit here, over the same ten thousand cases: {ms:.1} ms", "");
    }
}
