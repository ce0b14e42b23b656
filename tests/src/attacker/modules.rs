//! Modules in other processes that do not keep to the protocol.

use super::surface::{Judged, Surface};
use super::victim::Victim;
use crate::forger::mangle;
use crate::generated::Dice;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

/// A mission has ended within this time, whatever its module does.
const ENDED: Duration = Duration::from_secs(30);

const MANIFEST: &str = "name = \"lamp\"\ndoc = \"A lamp.\"\ncommand = [\"sh\", \"module.sh\"]\n\
    answer_within = \"1s\"\nstart_within = \"1s\"\n\n[[behaviour]]\nname = \"blink\"\ndoc = \"Blinks.\"\n\
    takes = [\"1s\", \"1s\", \"1s\"]\n";

struct Modules {
    command: PathBuf,
    folder: PathBuf,
}

pub(super) fn start(command: &Path, folder: &Path) -> Result<Box<dyn Surface>, String> {
    let put = |name: &str, text: &str| fs::write(folder.join(name), text).map_err(|error| error.to_string());
    put("module.toml", MANIFEST)?;
    put("plan.rpl", "(blink)\n")?;
    Ok(Box::new(Modules { command: command.to_path_buf(), folder: folder.to_path_buf() }))
}

const HELLO: &str = "{\"type\":\"hello\",\"protocol\":2,\"module\":\"lamp\"}\n";

/// What the module says at once, and what it does then.
fn script(dice: &mut Dice) -> (&'static str, Vec<u8>, &'static str) {
    let whole = HELLO.to_string() + "{\"type\":\"done\",\"time_us\":0}\n{\"type\":\"success\",\"id\":1}\n";
    match dice.below(8) {
        0 => ("silence", Vec::new(), "exec cat > /dev/null"),
        1 => ("an end at once", Vec::new(), "exit 3"),
        2 => ("a pipe that somebody else holds", HELLO.into(), "sleep 20 &\nexit 4"),
        3 => ("a closed output", HELLO.into(), "exec >&-\nexec cat > /dev/null"),
        4 => ("words without end", Vec::new(), "exec cat /dev/zero"),
        5 => {
            let event =
                "{\"type\":\"failure\",\"id\":1,\"class\":\"\\u001b[2J\",\"message\":\"\\u001b]0;x\\u0007\\n\"}\n";
            ("a reason that steers a terminal", (HELLO.to_string() + event).into(), "exec cat > /dev/null")
        }
        6 => ("numbers nobody means", mangle::numbers(&whole, 3, dice).into(), "exec cat > /dev/null"),
        _ => ("a mangled conversation", mangle::bytes(whole.as_bytes(), dice), "exec cat > /dev/null"),
    }
}

impl Surface for Modules {
    fn attack(&mut self, dice: &mut Dice) -> Judged {
        let (kind, said, then) = script(dice);
        let put =
            |name: &str, bytes: &[u8]| fs::write(self.folder.join(name), bytes).map_err(|error| error.to_string());
        put("said", &said)?;
        put("module.sh", format!("cat said\n{then}\n").as_bytes())?;
        let arguments = ["run", "plan.rpl", "--world", "test-room", "--until", "5s", "--module", "module.toml"];
        let mut mission = Victim::start(&self.command, &self.folder, &arguments)?;
        let status = mission.ends_within(ENDED).map_err(|finding| format!("{kind}: {finding}"))?;
        match status.code() {
            Some(1..=3) if mission.errors().trim().is_empty() => Err(format!("{kind}: it ended without a word")),
            Some(0..=3) => Ok(kind),
            _ => Err(format!("{kind}: it ended with {status}: {}", mission.errors())),
        }
    }

    fn end(&mut self) -> Result<(), String> {
        Ok(())
    }
}
