//! Saved runs with changed bytes: they are refused, or run on; and what was loaded is saved as it was.
//!
//! An input says which program is run, for how long, and which bytes of what is saved then are changed: so it stays one,
//! whatever is saved.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rpl_lang::compile::NoFiles;
use rpl_runtime::robot::{NoRobot, RobotTables};
use rpl_runtime::run::library::{Library, Loaded};
use rpl_runtime::run::system::System;
use rpl_runtime::state::limits::Limits;
use std::sync::{Arc, LazyLock};

/// Bytes of a saved run before what changes; the checksum is the last word of them.
const HEADER: usize = 19;

/// Little of everything that a run can have, without the library in RPL, which would be read again for each input.
const PROGRAMS: [&str; 3] = [
    "(def-fluent n 0)
     (def-valve arm)
     (measure 'rooms 4)
     (par (seq (with-valve arm (wait-time 1) (setf (value n) (list 1 2.5 \"c\" 'd :e))))
          (with-valve arm (wait-for n) (print (value n)))
          (unwind-protect (wait-time 3) (setf (value n) nil)))",
    "(def-fluent m 7)
     (defun count (i) (if (< i 20) (count (+ i 1)) i))
     (let ((f (lambda (x) (list x (count 0)))))
       (par (with-failure-handling ((plan-failure (s) (print s))) (wait-time 1) (car (car (funcall f 3))))
            (wait-for (> m 8))
            (:tag setting (seq (wait-time 0.5) (setf (value m) 9) (wait-time 5)))))",
    "(let ((h (make-hash-table)) (v (vector 1 2 3)))
       (setf (gethash 'a h) v) (setf (gethash \"b\" h) h)
       (par (execute-plan '(seq (wait-time 1) (print 2)))
            (plan ((:tag a (wait-time 2)) (:tag b (print h))) (:order a b))))",
];

struct Programs {
    library: Arc<Library>,
    loaded: Vec<Loaded>,
}

static PROGRAMS_LOADED: LazyLock<Programs> = LazyLock::new(|| {
    let natives = [rpl_runtime::step::natives::natives(), rpl_stdlib::natives()].concat();
    let library = Library::new(natives, &[], &RobotTables::default());
    let library = Arc::new(library.unwrap_or_else(|rejected| panic!("{}", rejected.render(false))));
    let load = |text: &&str| library.load("plan.rpl", text, &mut NoFiles);
    let loaded =
        PROGRAMS.iter().map(load).map(|loaded| loaded.unwrap_or_else(|rejected| panic!("{}", rejected.render(false))));
    Programs { loaded: loaded.collect(), library: library.clone() }
});

fn run_on(system: &mut System<NoRobot>, steps: usize) {
    system.machine.limits = Limits { steps: 300, frames: 60, ..Limits::default() };
    for _ in 0..steps {
        if system.outcome().is_none() && !system.step_task() {
            system.next_instant();
        }
    }
}

fuzz_target!(|input: (u8, u8, Vec<(u16, u8, u8)>)| {
    let (program, steps, changes) = input;
    let Programs { library, loaded } = &*PROGRAMS_LOADED;
    let loaded = &loaded[usize::from(program) % loaded.len()];
    let load = |bytes: &[u8]| System::load(bytes, library.clone(), loaded.clone(), NoRobot);
    let mut system = System::new(library.clone(), loaded.clone(), NoRobot, 1);
    run_on(&mut system, usize::from(steps));
    let saved = system.save();
    let mut payload = saved[HEADER..].to_vec();
    for &(at, how, byte) in changes.iter().take(8) {
        let at = usize::from(at) % payload.len();
        match how % 4 {
            0 => payload[at] = byte,
            1 => payload[at] = payload[at].wrapping_add(byte),
            2 => payload.insert(at, byte),
            _ => drop((payload.len() > 1).then(|| payload.remove(at))),
        }
    }
    let bytes = [&saved[..HEADER - 4], &crc32fast::hash(&payload).to_le_bytes(), &payload].concat();
    let Ok(mut loaded) = load(&bytes) else {
        assert!(bytes != saved, "what was saved is refused");
        return;
    };
    // One number can be written in several ways, but not by a run.
    let again = loaded.save();
    assert!(bytes != saved || again == saved, "what was loaded is saved as something else");
    let twice = load(&again).unwrap_or_else(|why| panic!("what was loaded and saved is refused: {why}")).save();
    assert!(again == twice, "what was loaded is saved as something else");
    run_on(&mut loaded, 40);
});
