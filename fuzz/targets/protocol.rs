//! Lines to and from hosts and modules: what is read of one is the same after it was written.

#![no_main]

use libfuzzer_sys::fuzz_target;
use rpl_protocol::host::{self, FromHost, ToHost};
use rpl_protocol::module::message::{FromModule, ToModule};
use serde::{Deserialize, Serialize};
use std::fmt::Debug;

fn same_after_writing<M: for<'t> Deserialize<'t> + Serialize + PartialEq + Debug>(line: &str) {
    match host::read::<M>(line) {
        Ok(message) => {
            let written = host::written(&message);
            assert_eq!(host::read::<M>(&written), Ok(message), "{written}");
        }
        Err(why) => assert!(!why.is_empty()),
    }
}

fuzz_target!(|line: &str| {
    same_after_writing::<ToHost>(line);
    same_after_writing::<FromHost>(line);
    same_after_writing::<ToModule>(line);
    same_after_writing::<FromModule>(line);
    assert!(FromModule::read(line.as_bytes()).is_ok() == host::read::<FromModule>(line).is_ok());
});
