//! Who moves the robot of a run: our simulator, a host in another process, or a recording of one; and the
//! recording that a run writes.

use crate::recorded_run::{HostHeard, RecordedRun};
use anyhow::{Context, Result, bail};
use clap::ValueHint;
use rpl_link::recording::{RecordedTurns, Recorder, Recording, Turn};
use rpl_link::tcp_client::TcpHost;
use rpl_link::thinker::Thinker;
use rpl_link::transcript::{Divergence, Kept, Transcript};
use rpl_mission::robot::Robot;
use rpl_mission::site::Site;
use rpl_protocol::host::{CommandsMessage, HostAnswer, HostHello, MissionHello, PROTOCOL};
use rpl_protocol::line::{Line, LineFault};
use rpl_protocol::remote_host::RemoteHost;
use rpl_protocol::thinking::{ThinkingAnswer, ThinkingLine, ThinkingWords};
use rpl_protocol::token::Token;
use rpl_shell::arguments::site::{SiteArguments, needs_world};
use rpl_shell::arguments::token::TokenArgument;
use rpl_shell::files::outputs::OutputFile;
use rpl_shell::files::robot_files;
use rpl_shell::files::shown::Shown;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The name of the line to a host in recordings.
const HOST: &str = "host";

/// The name of the line to who thinks beside a run.
const THINKING: &str = "thinking";

/// Turns that a session keeps, to go back to: more than four hours at 20 a second.
const MOST_KEPT: usize = 300_000;

/// The same of turns of thinking, which are there while something is thought about: three quarters of an hour. The
/// answers in them are larger.
const MOST_THINKING_KEPT: usize = 54_000;

/// Arguments that say who moves the robot, and whether what it says is kept.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct HostArguments {
    /// Address of the host that moves the robot, such as 127.0.0.1:7300 (`rpl simulate`); the world is then
    /// only the robot's map
    #[arg(long, value_name = "ADDRESS", conflicts_with = "scenario", value_hint = ValueHint::Hostname)]
    pub host: Option<String>,
    /// Record all input from outside in this file, so that `rpl replay` can repeat the run
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub record: Option<PathBuf>,
    #[command(flatten)]
    /// The token that is said to it.
    pub token: TokenArgument,
}

/// Who moves the robot.
pub enum HostSource {
    /// Our simulator, if there is a robot.
    Simulated,
    /// A process that has been reached.
    Live {
        /// Where.
        address: String,
        /// How it greets.
        hello: HostHello,
        /// The line to it.
        host: TcpHost,
    },
    /// A recording.
    Recorded {
        /// The host that was heard.
        heard: HostHeard,
        /// What it said.
        turns: Vec<Turn<CommandsMessage, HostAnswer>>,
        /// What was thought about meanwhile.
        thinking: Vec<Turn<ThinkingWords, ThinkingAnswer>>,
    },
}

/// The line to a host, where there is one, and to who thinks while it goes on.
pub struct HostLines {
    host: Arc<Transcript<CommandsMessage, HostAnswer>>,
    thinking: Arc<Transcript<ThinkingWords, ThinkingAnswer>>,
}

impl HostLines {
    /// Where the run first wanted to tell the host something else than it did, if it did.
    pub(crate) fn divergence(&self) -> Option<Divergence> {
        self.host.divergence()
    }

    /// A host goes on where another one, or the same, was heard last.
    ///
    /// # Errors
    /// What was heard cannot be read.
    pub fn go_on(&self, past: &RecordedTurns, recorder: Arc<Recorder>) -> Result<()> {
        self.host.go_on(past.stretch(HOST)?, Some(recorder.clone()));
        self.thinking.go_on(past.stretch(THINKING)?, Some(recorder));
        Ok(())
    }
}

impl HostArguments {
    /// Reaches the host, if one is named, for a mission that is called so. Done before anything costly: the world
    /// waits for the first commands.
    ///
    /// # Errors
    /// It cannot be reached, or moves another robot than the one of this site.
    pub fn reach(&self, site: &SiteArguments, mission: &str) -> Result<HostSource> {
        match &self.host {
            Some(_) if site.world.is_none() => bail!(needs_world("--host")),
            Some(address) => {
                reach(address, robot_files::named(site.robot.as_deref())?.name.clone(), mission, self.token.read()?)
            }
            None if self.token.token_file.is_some() => {
                bail!("`--token-file` is for a host; add `--host ADDRESS`, or leave it away")
            }
            None => Ok(HostSource::Simulated),
        }
    }

    /// Begins the recording, if one is to be written.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn record(&self, run: &RecordedRun) -> Result<Option<Arc<Recorder>>> {
        let Some(path) = &self.record else { return Ok(None) };
        let file = OutputFile::open(path, "the recording")?.begin()?;
        let recorder =
            Recorder::begin(file, run).with_context(|| format!("cannot write the recording `{}`", path.shown()))?;
        Ok(Some(Arc::new(recorder)))
    }
}

/// Reaches a host that moves this robot, for a mission by the name of its plan's file.
///
/// # Errors
/// It cannot be reached, or moves another robot.
pub fn reach(address: &str, robot: String, mission: &str, token: Option<Token>) -> Result<HostSource> {
    let mission = Path::new(mission).file_name().map(|name| name.to_string_lossy().into_owned());
    let hello = MissionHello { protocol: PROTOCOL, rpl: env!("CARGO_PKG_VERSION").to_string(), robot, mission, token };
    match TcpHost::connect(address, hello) {
        Ok((hello, host)) => Ok(HostSource::Live { address: address.to_string(), hello, host }),
        Err(LineFault(why)) => bail!("{why}"),
    }
}

/// How much of what a host says stays in memory: a session goes back, a run does not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// A run from its start to its end.
    Run,
    /// A session.
    Session,
}

impl HostSource {
    /// For a run that began with another host, or an earlier mission of the same: only that one's start counts.
    pub fn starting_as(self, then: &HostHeard) -> Self {
        match self {
            HostSource::Live { address, hello, host } => {
                let hello = HostHello { start_known: then.start_known, ..hello };
                HostSource::Live { address, hello, host }
            }
            HostSource::Simulated | HostSource::Recorded { .. } => self,
        }
    }

    /// Whether what the host said was recorded.
    pub fn is_recording(&self) -> bool {
        matches!(self, HostSource::Recorded { .. })
    }

    /// What a recording says of the host.
    pub fn heard(&self) -> Option<HostHeard> {
        match self {
            HostSource::Simulated => None,
            HostSource::Live { address, hello, .. } => {
                Some(HostHeard { address: address.clone(), start_known: hello.start_known })
            }
            HostSource::Recorded { heard, .. } => Some(heard.clone()),
        }
    }

    /// The robot at the start of a run, and the lines to its host if that is not our simulator.
    ///
    /// # Errors
    /// The host does not fit the robot.
    pub fn robot(
        self,
        site: &Site,
        seed: u64,
        kept: Use,
        recorder: Option<Arc<Recorder>>,
    ) -> Result<(Robot, Option<HostLines>)> {
        let Some(heard) = self.heard() else { return Ok((site.robot(seed), None)) };
        let office = site.office().context("a host needs a world; add `--world dept`")?;
        let period_us = office.settings.robot.step_us;
        let (host, thinking) = match self {
            HostSource::Simulated => return Ok((site.robot(seed), None)),
            HostSource::Live { address, hello, host } => {
                if hello.period_us != period_us {
                    bail!(
                        "the host `{address}` has a period of {} us, and the robot of the mission one of {period_us} us",
                        hello.period_us
                    );
                }
                let kept = |most| match kept {
                    Use::Run => Kept::Last,
                    Use::Session => Kept::Newest(most),
                };
                let thinker = Box::new(Thinker::default());
                let thinking = Transcript::live(THINKING, thinker, kept(MOST_THINKING_KEPT), recorder.clone());
                (Transcript::live(HOST, Box::new(host), kept(MOST_KEPT), recorder), thinking)
            }
            HostSource::Recorded { turns, thinking, .. } => {
                (Transcript::recorded(HOST, turns), Transcript::recorded(THINKING, thinking))
            }
        };
        let lines = HostLines { host: Arc::new(host), thinking: Arc::new(thinking) };
        let line: Arc<dyn Line<CommandsMessage, HostAnswer>> = lines.host.clone();
        let thinking: ThinkingLine = lines.thinking.clone();
        let host = RemoteHost::new(&heard.address, line, thinking, office.settings.robot.clone());
        let robot = site.robot_of(host, heard.start_known, seed).context("a host needs a world; add `--world dept`")?;
        Ok((robot, Some(lines)))
    }
}

/// The host of a recording.
///
/// # Errors
/// Its turns cannot be read.
pub fn recorded(recording: &Recording<RecordedRun>) -> Result<HostSource> {
    heard(recording.run.host.as_ref(), &recording.turns)
}

/// A host by what it said; our simulator if there was none.
///
/// # Errors
/// Its turns cannot be read.
pub fn heard(host: Option<&HostHeard>, turns: &RecordedTurns) -> Result<HostSource> {
    match host {
        Some(heard) => {
            let (turns, thinking) = (turns.of(HOST)?, turns.of(THINKING)?);
            Ok(HostSource::Recorded { heard: heard.clone(), turns, thinking })
        }
        None => Ok(HostSource::Simulated),
    }
}

/// Where a run left its recording, for a person: when, and what it did then and now.
pub(crate) fn astray(divergence: &Divergence, period_us: u64) -> String {
    let Divergence { turn, recorded, now } = divergence;
    let time_s = (*turn * period_us) as f64 / 1e6;
    let (recorded, now) = first_difference(recorded, now);
    format!(
        "the run acts differently from {time_s:.2} s on, and what comes then is not recorded\n  recorded: {recorded}\n  \
         now:      {now}"
    )
}

/// Of several messages at a turn, the first that is another one.
fn first_difference(recorded: &str, now: &str) -> (String, String) {
    let messages = |text: &str| serde_json::from_str::<Vec<serde_json::Value>>(text).ok();
    let (Some(then), Some(here)) = (messages(recorded), messages(now)) else {
        return (recorded.to_string(), now.to_string());
    };
    let at = then.iter().zip(&here).take_while(|(then, here)| then == here).count();
    let shown = |messages: &[serde_json::Value]| messages.get(at).map_or("nothing".to_string(), ToString::to_string);
    (shown(&then), shown(&here))
}
