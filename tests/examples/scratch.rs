use rpl_robot::office::*;
use rpl_robot::world::World;
use rpl_runtime::library::Library;
use rpl_runtime::system::{Outcome, Progress, System};
use std::sync::Arc;
use std::time::Instant;
fn main() {
    let args: Vec<String> = std::env::args().collect();
    if let Some((a, b)) = args[1].split_once('-') {
        let (a, b): (u64, u64) = (a.parse().unwrap(), b.parse().unwrap());
        let settings = OfficeSettings::default();
        let model = Arc::new(OfficeModel::new(World::builtin("dept").unwrap(), settings).unwrap());
        let next = std::sync::atomic::AtomicU64::new(a);
        std::thread::scope(|s| {
            for _ in 0..2 {
                s.spawn(|| {
                    loop {
                        let seed = next.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
                        if seed > b {
                            break;
                        }
                        one(seed, &args, model.clone());
                    }
                });
            }
        });
        return;
    }
    let seed: u64 = args[1].parse().unwrap();
    let settings = OfficeSettings::default();
    let model = Arc::new(OfficeModel::new(World::builtin("dept").unwrap(), settings).unwrap());
    one(seed, &args, model);
}
fn one(seed: u64, args: &[String], model: Arc<OfficeModel>) {
    let quiet_run = args[1].contains('-');
    let plan = std::fs::read_to_string(&args[2]).unwrap();
    let base = [rpl_runtime::natives::natives(), rpl_stdlib::natives()].concat();
    let host0 = SimulatedHost::new(model.simulator.clone(), seed, None);
    let robot0 = OfficeRobot::new(model.clone(), host0, seed);
    let lib = Library::new(
        [base.clone(), natives()].concat(),
        &[("prelude", rpl_stdlib::PRELUDE), ("robot plans", PLANS)],
        &robot0,
        &[],
    );
    let lib = Arc::new(match lib {
        Ok(l) => l,
        Err(e) => {
            println!("{}", e.render(false));
            return;
        }
    });
    let scenario = args.get(3).map(|f| {
        let text = std::fs::read_to_string(f).unwrap();
        let oracle = Oracle::new(model.simulator.clone(), seed);
        let lib = Arc::new(
            Library::new([base.clone(), oracle_natives()].concat(), &[("prelude", rpl_stdlib::PRELUDE)], &oracle, &[])
                .map_err(|e| e.render(false))
                .unwrap(),
        );
        let loaded = lib.load(f, &text, &mut rpl_lang::compile::NoFiles).map_err(|e| e.render(false)).unwrap();
        {
            let mut s = System::new(lib, loaded, oracle);
            s.machine.seed_random(seed);
            s
        }
    });
    let mut host = SimulatedHost::new(model.simulator.clone(), seed, scenario);
    let p = model.world.place("mail-slots").unwrap().pose_in_map;
    host.state.place_item("mail", p.point());
    let robot = OfficeRobot::new(model.clone(), host, seed);
    let loaded = match lib.load(&args[2], &plan, &mut rpl_lang::compile::NoFiles) {
        Ok(l) => l,
        Err(e) => {
            println!("{}", e.render(false));
            return;
        }
    };
    let mut system = System::new(lib.clone(), loaded, robot);
    system.machine.trace.enabled = true;
    let quiet: Vec<u32> = ["x*", "y*", "o*", "pos-certainty*", "speed*"]
        .iter()
        .map(|n| {
            let s = system.machine.symbols.find(n).unwrap();
            let g = system.program.names[&s];
            match system.machine.globals[g as usize] {
                rpl_runtime::value::Value::Fluent(f) => f,
                _ => panic!(),
            }
        })
        .collect();
    system.machine.trace.quiet = quiet;
    let t = Instant::now();
    let verbose = std::env::var("V").is_ok();
    let mut next = 0.0;
    loop {
        let p = system.advance();
        for o in system.machine.output.drain(..) {
            println!("{:8.2} out {:?}", system.machine.now_us as f64 / 1e6, o);
        }
        for e in system.machine.trace.take() {
            if quiet_run {
                continue;
            }
            if verbose || e.kind == rpl_runtime::trace::EventKind::Robot {
                println!("{e}");
            }
        }
        if verbose && system.machine.now_s() >= next {
            next += 5.0;
            let tp = system.outside.true_pose_in_map();
            let e = system.outside.estimate();
            println!(
                "{:8.2} true {:.2} {:.2} {:.0}  est {:.2} {:.2} {:.0} c {:.3}",
                system.machine.now_s(),
                tp.x_m,
                tp.y_m,
                tp.heading_rad.to_degrees(),
                e.pose_in_map.x_m,
                e.pose_in_map.y_m,
                e.pose_in_map.heading_rad.to_degrees(),
                e.certainty
            );
        }
        if p == Progress::Ended || system.machine.now_us > 1_200_000_000 {
            break;
        }
    }
    let tp = system.outside.true_pose_in_map();
    println!(
        "seed {seed} end {:.1} s wall {:?} outcome {} true {:.2} {:.2} contacts {:?} dist {:.1}",
        system.machine.now_s(),
        t.elapsed(),
        match system.outcome() {
            Some(Outcome::Succeeded(_)) => "ok".to_string(),
            Some(Outcome::Failed(f)) => system.machine.show(&system.program, f),
            o => format!("{o:?}"),
        },
        tp.x_m,
        tp.y_m,
        system.outside.contacts(),
        system.outside.distance_driven_m()
    );
}
