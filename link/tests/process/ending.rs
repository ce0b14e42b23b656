//! How a module ends: by itself, or for certain.

use crate::module::{manifest, process};
use rpl_link::transcript::Live;
use rpl_protocol::module::message::{ModuleWords, ToModule};
use std::sync::Arc;

#[test]
fn it_ends_with_the_run_whatever_it_does_at_the_end() {
    for mode in ["right", "death-at-bye", "ignores-bye"] {
        let mut module = process(&manifest(mode, "")).unwrap_or_else(|error| panic!("{error}"));
        let number = module.number().expect("it was started here");
        assert!(is_there(number), "{mode}");
        let answer = module.answer(&ModuleWords(vec![ToModule::Bye])).expect("it is no fault");
        assert!(answer.loss.is_some() && !is_there(number), "{mode}");
        drop(module);
    }
}

#[test]
fn it_ends_when_it_is_dropped_or_its_thread_panics() {
    let module = process(&manifest("right", "")).unwrap_or_else(|error| panic!("{error}"));
    let number = module.number().expect("it was started here");
    drop(module);
    assert!(!is_there(number));
    let module = process(&manifest("right", "")).unwrap_or_else(|error| panic!("{error}"));
    let number = module.number().expect("it was started here");
    let panicked = std::thread::spawn(move || {
        let _module = Arc::new(module);
        std::panic::resume_unwind(Box::new("a fault"));
    });
    assert!(panicked.join().is_err() && !is_there(number));
}

/// Whether there is a process of a number, also one that has ended and was not waited for.
fn is_there(number: u32) -> bool {
    let number = rustix::process::Pid::from_raw(number.cast_signed()).expect("it is no 0");
    rustix::process::test_kill_process(number).is_ok()
}
