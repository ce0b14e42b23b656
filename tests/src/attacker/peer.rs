//! Hosts that a mission is sent to, and which mean no good.

use super::surface::{Judged, Surface};
use super::victim::Victim;
use crate::forger::mangle;
use crate::generated::Dice;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

/// A mission has ended within this time, if its host is silent or says nonsense.
const ENDED: Duration = Duration::from_secs(30);

/// What the host says to the next mission.
#[derive(Clone, Debug, Default)]
struct Script {
    bytes: Vec<u8>,
    /// Whether it goes when it has said it.
    goes: bool,
}

struct Hosts {
    command: PathBuf,
    folder: PathBuf,
    address: String,
    script: Arc<Mutex<Script>>,
    is_over: Arc<AtomicBool>,
}

pub(super) fn start(command: &Path, folder: &Path) -> Result<Box<dyn Surface>, String> {
    std::fs::write(folder.join("plan.rpl"), "(wait-time 1)\n(go-to 'corner)\n").map_err(|error| error.to_string())?;
    let listener = TcpListener::bind("127.0.0.1:0").map_err(|error| error.to_string())?;
    let address = listener.local_addr().map_err(|error| error.to_string())?.to_string();
    let (script, is_over) = (Arc::<Mutex<Script>>::default(), Arc::new(AtomicBool::new(false)));
    let (scripts, ends) = (Arc::clone(&script), Arc::clone(&is_over));
    thread::spawn(move || {
        for mission in listener.incoming().flatten().take_while(|_| !ends.load(Ordering::Relaxed)) {
            let script = scripts.lock().unwrap_or_else(PoisonError::into_inner).clone();
            thread::spawn(move || speak(mission, &script));
        }
    });
    let (command, folder) = (command.to_path_buf(), folder.to_path_buf());
    Ok(Box::new(Hosts { command, folder, address, script, is_over }))
}

/// Says what is in the script, and goes or stays until the mission has gone.
fn speak(mut mission: TcpStream, script: &Script) {
    // Whatever happens to the bytes, the judge is at the other end.
    mission.write_all(&script.bytes).ok();
    if !script.goes {
        mission.read_to_end(&mut Vec::new()).ok();
    }
}

const HELLO: &str =
    "{\"type\":\"hello\",\"protocol\":2,\"robot\":\"b21\",\"period_us\":50000,\"factor\":1.0,\"start_known\":true}\n";

fn percept(number: u64, time_us: u64, x_m: f64) -> String {
    let sonars = ["2.5"; 24].join(",");
    format!(
        "{{\"type\":\"percept\",\"number\":{number},\"time_us\":{time_us},\"commands\":0,\"odometry_in_odom\":{{\"x_m\":{x_m:.3},\"y_m\":0.0,\"heading_rad\":0.0}},\"translation_mps\":0.0,\"rotation_radps\":0.0,\"sonar_m\":[{sonars}],\"bumped\":false,\"gripper\":\"open\",\"battery\":1.0}}\n"
    )
}

fn script(dice: &mut Dice) -> (&'static str, Vec<u8>) {
    let percepts =
        |count: u64| (0..count).map(|number| percept(number, 50_000 * (number + 1), 0.0)).collect::<String>();
    let bye = |reason: &str| format!("{HELLO}{{\"type\":\"bye\",\"reason\":\"{reason}\"}}\n").into_bytes();
    match dice.below(9) {
        0 => ("silence", Vec::new()),
        1 => ("a greeting and no more", HELLO.as_bytes().to_vec()),
        2 => ("a line without end", vec![b'{'; 4 << 20]),
        3 => ("a reason that steers a terminal", bye("\\u001b[2J\\nthe plan has succeeded\\u009b1m\\r")),
        4 => ("time that goes back", (HELLO.to_string() + &percepts(3) + &percept(3, 10_000, 0.0)).into_bytes()),
        5 => ("a jump", (HELLO.to_string() + &percepts(3) + &percept(3, 200_000, 1e6)).into_bytes()),
        6 => ("percepts too fast", (HELLO.to_string() + &percepts(20_000)).into_bytes()),
        7 => ("numbers nobody means", mangle::numbers(&(HELLO.to_string() + &percepts(5)), 9, dice).into_bytes()),
        _ => ("a mangled conversation", mangle::bytes((HELLO.to_string() + &percepts(5)).as_bytes(), dice)),
    }
}

impl Surface for Hosts {
    fn attack(&mut self, dice: &mut Dice) -> Judged {
        let (kind, bytes) = script(dice);
        let said = Script { bytes, goes: !dice.once_in(4) };
        *self.script.lock().unwrap_or_else(PoisonError::into_inner) = said;
        let arguments =
            ["run", "plan.rpl", "--world", "test-room", "--grid", "coarse", "--until", "3s", "--host", &self.address];
        let mut mission = Victim::start(&self.command, &self.folder, &arguments)?;
        let status = mission.ends_within(ENDED).map_err(|finding| format!("{kind}: {finding}"))?;
        match status.code() {
            Some(0) => Err(format!("{kind}: the mission says that it succeeded")),
            Some(1..=3) if mission.errors().trim().is_empty() => Err(format!("{kind}: it ended without a word")),
            Some(1..=3) => Ok(kind),
            _ => Err(format!("{kind}: it ended with {status}: {}", mission.errors())),
        }
    }

    fn end(&mut self) -> Result<(), String> {
        self.is_over.store(true, Ordering::Relaxed);
        // The listener looks when somebody comes.
        TcpStream::connect(&self.address).map(drop).map_err(|error| error.to_string())
    }
}
