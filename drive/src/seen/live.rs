//! A run that is seen while it goes on, or afterwards: `--live`, `--report`.

use super::feed::Feed;
use super::head;
use super::steering::Steering;
use crate::onlooker::{Happened, Onlooker};
use crate::trace::Header;
use anyhow::{Context, Result, anyhow, bail};
use clap::ValueHint;
use rpl_mission::robot::Robot;
use rpl_mission::sight::Sight;
use rpl_mission::site::Site;
use rpl_page::html::{Source, page};
use rpl_page::report::report;
use rpl_page::series::{Series, Text};
use rpl_page::server::Server;
use rpl_page::server::access::Access;
use rpl_page::server::news::Trouble;
use rpl_robot::world::World;
use rpl_shell::files::outputs::OutputFile;
use rpl_shell::interrupt;
use rpl_shell::terminal::console::Console;
use rustix::rand::{GetRandomFlags, getrandom};
use std::net::{SocketAddr, ToSocketAddrs};
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::thread;
use std::time::Duration;

/// How long the page is kept at a time before somebody looks whether it is to end.
const NAP: Duration = Duration::from_millis(50);

/// What is shown of a run in a browser.
#[derive(clap::Args, Clone, Debug, Default)]
pub struct LiveArguments {
    /// Show the run in a browser until Ctrl-C; ADDRESS is [HOST][:PORT] (default: localhost, this machine only)
    #[arg(long, value_name = "ADDRESS", num_args = 0..=1, default_missing_value = "localhost", value_hint = ValueHint::Hostname)]
    pub live: Option<String>,
    /// Open the page in a browser
    #[arg(long, requires = "live")]
    pub open: bool,
    /// Let the page pause, step, pace and end the run
    #[arg(long, requires = "live")]
    pub control: bool,
    /// Also show the robot's true pose, and what its map lacks, on the page or in the report
    #[arg(long)]
    pub truth: bool,
    /// Write the run as one HTML file that needs no server
    #[arg(long, value_name = "FILE.html", value_hint = ValueHint::FilePath)]
    pub report: Option<PathBuf>,
}

impl LiveArguments {
    /// Whether anything is shown at all.
    pub fn is_wanted(&self) -> bool {
        self.live.is_some() || self.report.is_some()
    }

    /// Serves a page, and what it asks for of a run with this head of its series, if that is wanted, and says where.
    ///
    /// # Errors
    /// The address cannot be had.
    pub fn serve(&self, page: String, head: String, console: &mut Console) -> Result<Option<Server>> {
        let Some(address) = &self.live else { return Ok(None) };
        let address = socket_address(address)?;
        let needs_token = self.control || !address.ip().is_loopback();
        let access = Access { token: needs_token.then(token).transpose()?, control: self.control };
        let server = Server::start(address, access, page, head).with_context(|| {
            format!("cannot serve the page at {address}; another port can be given: `--live :0` takes a free one")
        })?;
        console.note(&format!("the run is shown at {}", server.link));
        if self.open {
            open(&server.link, console);
        }
        Ok(Some(server))
    }
}

/// The port where no other is given.
const PORT: u16 = 7420;

/// `localhost`, `:8080`, `0.0.0.0:8080`, `::1`.
fn socket_address(text: &str) -> Result<SocketAddr> {
    let is_number = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if is_number && text.parse::<u16>().is_err() {
        bail!("`{text}` is no port: ports go up to 65535");
    }
    let whole = match text {
        _ if is_number => format!("localhost:{text}"),
        _ if text.starts_with(':') && !text.starts_with("::") => format!("localhost{text}"),
        _ if text.parse::<std::net::Ipv6Addr>().is_ok() => format!("[{text}]:{PORT}"),
        _ if text.rsplit_once(':').is_some_and(|(_, port)| port.parse::<u16>().is_ok()) => text.to_string(),
        _ => format!("{text}:{PORT}"),
    };
    let mut found = whole
        .to_socket_addrs()
        .with_context(|| format!("`{text}` is no address; such as `localhost:8080` or `0.0.0.0`"))?;
    let first = found.next();
    // One that every machine has comes first.
    found
        .chain(first)
        .find(SocketAddr::is_ipv4)
        .or(first)
        .ok_or_else(|| anyhow!("`{text}` is no address of this machine"))
}

/// Nobody guesses it.
fn token() -> Result<String> {
    let mut bytes = [0_u8; 16];
    let filled =
        getrandom(&mut bytes, GetRandomFlags::empty()).context("the system has no random numbers for a token")?;
    match filled == bytes.len() {
        true => Ok(bytes.iter().map(|byte| format!("{byte:02x}")).collect()),
        false => Err(anyhow!("the system has too few random numbers for a token")),
    }
}

fn open(link: &str, console: &mut Console) {
    let program = if cfg!(target_os = "macos") { "open" } else { "xdg-open" };
    let started =
        Command::new(program).arg(link).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    if let Err(error) = started {
        console.note(&format!("no browser could be opened with `{program}`: {error}"));
    }
}

/// A run that is seen.
pub struct SeenRun {
    /// Takes in what happens.
    feed: Feed,
    title: String,
    report: Option<OutputFile>,
}

impl SeenRun {
    /// What the arguments want to be seen of a run that is about to begin, and how its page steers it; none if nothing
    /// is to be seen, or there is no page.
    ///
    /// # Errors
    /// The page cannot be served, or the report cannot be written.
    pub fn begin(
        arguments: &LiveArguments,
        run: &Header,
        texts: Vec<Text>,
        (site, world): (&Site, Option<&World>),
        console: &mut Console,
    ) -> Result<(Option<Self>, Option<Steering>)> {
        if !arguments.is_wanted() {
            return Ok((None, None));
        }
        let office = site.office().filter(|_| world.is_some());
        let robot = office.map(|office| (&office.sensors, &office.limits));
        let series = Series::new(&head(run, texts, world, robot, arguments.truth));
        let report = arguments.report.as_deref().map(|path| OutputFile::open(path, "the report")).transpose()?;
        let title = head::title(run);
        let server = arguments.serve(page(&title, Source::Server, ""), series.head().to_string(), console)?;
        let news = server.as_ref().map(|server| server.news.clone());
        let feed = Feed::new(report.is_some().then_some(series), news, arguments.truth);
        let steering = server.map(|server| Steering::new(server, arguments.control, run.plan.clone()));
        Ok((Some(Self { feed, title, report }), steering))
    }
}

impl Onlooker for SeenRun {
    fn happened(&mut self, happened: &Happened<'_>, _: &mut Robot) -> Result<()> {
        self.feed.events(happened.events);
        happened.told.iter().for_each(|told| self.feed.told(happened.now_us, told));
        Ok(())
    }

    fn seen(&mut self, now_us: u64, sight: &Sight, robot: &mut Robot) -> Result<()> {
        self.feed.look(now_us, sight, robot);
        Ok(())
    }

    /// The report.
    fn ends(&mut self) -> Result<()> {
        if let (Some(file), Some(series)) = (self.report.take(), self.feed.kept()) {
            file.write(report(&self.title, &[series])?.as_bytes())?;
        }
        Ok(())
    }
}

/// Keeps a page until Ctrl-C, and tells its troubles.
pub fn stay(mut trouble: impl FnMut() -> Option<Trouble>, console: &mut Console) {
    if interrupt::is_asked() {
        return;
    }
    let _meaning = interrupt::gives_prompt_back();
    console.note("the page stays until Ctrl-C");
    while !interrupt::is_asked() {
        if let Some(trouble) = trouble() {
            console.note(&trouble.to_string());
        }
        thread::sleep(NAP);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_may_leave_out_host_or_port() {
        for (text, meant) in [
            ("localhost", "127.0.0.1:7420"),
            (":8080", "127.0.0.1:8080"),
            ("0.0.0.0", "0.0.0.0:7420"),
            ("127.0.0.1:0", "127.0.0.1:0"),
            ("::1", "[::1]:7420"),
            ("[::1]:80", "[::1]:80"),
        ] {
            assert_eq!(socket_address(text).expect(text).to_string(), meant);
        }
        assert!(socket_address("no such host.invalid").is_err());
    }

    #[test]
    fn two_tokens_differ() {
        let (one, other) = (token().expect("one"), token().expect("other"));
        assert_eq!(one.len(), 32);
        assert_ne!(one, other);
    }
}
