//! How a page holds, paces and steps a run. What is asked for acts between two instants, or before a form where the run
//! stands; a run that is held writes the same trace as one that is not.

use crate::stopping::breakpoint::Breakpoint;
use crate::stopping::halt::{Halt, Until};
use crate::stopping::{Places, Stopping, condition_met};
use rpl_mission::robot::Robot;
use rpl_page::server::Server;
use rpl_page::server::news::{Asked, News, RunState, Standing, Trouble};
use rpl_runtime::run::stepping::{Stepped, Stop};
use rpl_runtime::run::system::{System, Turn};

/// More places are not kept.
const MOST_BREAKPOINTS: usize = 100;

/// What became of a turn of a run that may be steered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SteeredTurn {
    /// As without a page.
    Turned(Turn),
    /// It is to stand still before a form.
    Halted,
}

/// The page's hand on a run.
pub struct Steering {
    server: Server,
    standing: Standing,
    /// As the page was told.
    told: Standing,
    /// The text that a line without a name means.
    file: String,
    until: Until,
    breakpoints: Vec<Breakpoint>,
    stopping: Stopping,
    stop: Option<Stop>,
    is_pace_new: bool,
    is_stop_asked: bool,
}

impl Steering {
    /// Of a run at its start.
    pub fn new(server: Server, control: bool, file: String) -> Self {
        let mut steering = Self {
            server,
            standing: Standing { control, ..Standing::default() },
            told: Standing::default(),
            file,
            until: Until::End,
            breakpoints: Vec::new(),
            stopping: Stopping::default(),
            stop: None,
            is_pace_new: false,
            is_stop_asked: false,
        };
        steering.publish();
        steering
    }

    /// Why the page does not answer, if that was not told before.
    pub fn trouble(&mut self) -> Option<Trouble> {
        self.server.trouble()
    }

    /// Whether the run is to stand still.
    pub fn is_held(&self) -> bool {
        self.standing.state == RunState::Paused
    }

    /// Whether the run is to end.
    pub fn is_stop_asked(&self) -> bool {
        self.is_stop_asked
    }

    /// Another pace, if one was asked for since this was.
    pub fn take_pace(&mut self) -> Option<Option<f64>> {
        std::mem::take(&mut self.is_pace_new).then_some(self.standing.pace)
    }

    /// The run is paced like this from the start.
    pub fn begin_at(&mut self, pace: Option<f64>) {
        self.standing.pace = pace;
        self.publish();
    }

    /// Tells the page what the run does.
    pub fn stand(&mut self, state: RunState) {
        self.standing.state = state;
        self.publish();
    }

    fn publish(&mut self) {
        self.standing.breakpoints = self.breakpoints.iter().map(Breakpoint::to_string).collect();
        if self.told != self.standing {
            self.told.clone_from(&self.standing);
            // A page that has broken off is told of by itself.
            self.server.news.send(News::Standing(Box::new(self.standing.clone()))).ok();
        }
    }

    /// Does what was asked for since; tells whether anything was.
    pub fn attend(&mut self, system: &mut System<Robot>) -> bool {
        let mut is_any = false;
        while let Ok(asked) = self.server.asked.try_recv() {
            is_any = true;
            self.standing.note = None;
            self.answer(asked, system);
        }
        if is_any {
            self.standing.time_us = system.machine.now_us;
            self.publish();
        }
        is_any
    }

    fn answer(&mut self, asked: Asked, system: &mut System<Robot>) {
        match asked {
            Asked::Pause => self.standing.state = RunState::Paused,
            Asked::Go => self.go(Until::End),
            Asked::Step => self.go(Until::Step),
            Asked::Over => self.go(Until::Next),
            Asked::Out => self.go(Until::Out),
            Asked::Pace(pace) => match pace {
                Some(pace) if !(pace.is_finite() && pace > 0.0) => {
                    self.standing.note = Some("the pace must be a number above 0".to_string());
                }
                _ => (self.standing.pace, self.is_pace_new) = (pace, true),
            },
            Asked::Break(text) => self.add_breakpoint(&text, system),
            Asked::Unbreak(text) => self.breakpoints.retain(|place| place.to_string() != text),
            Asked::Stop => {
                self.is_stop_asked = true;
                self.go(Until::End);
            }
        }
    }

    fn go(&mut self, until: Until) {
        self.until = until;
        self.stopping = Stopping::from(self.stop.take());
        self.standing.state = RunState::Running;
        self.standing.at = None;
    }

    fn add_breakpoint(&mut self, text: &str, system: &mut System<Robot>) {
        if self.breakpoints.len() >= MOST_BREAKPOINTS {
            self.standing.note = Some(format!("{MOST_BREAKPOINTS} places are enough; take one away first"));
            return;
        }
        match Breakpoint::parse(text, Some(&self.file), system, false) {
            Ok(place) if self.breakpoints.iter().any(|known| known.to_string() == place.to_string()) => {}
            Ok(place) => self.breakpoints.push(place),
            Err(why) => self.standing.note = Some(why),
        }
    }

    /// One turn of the run, as far as the next place to stop at.
    pub fn turn(&mut self, system: &mut System<Robot>) -> SteeredTurn {
        let places = Places { until: &self.until, breakpoints: &self.breakpoints, file: Some(&self.file) };
        if !places.need_forms() {
            return SteeredTurn::Turned(system.step_slice());
        }
        match system.step_form() {
            Stepped::Settled => SteeredTurn::Turned(Turn::Idle),
            Stepped::Ran => SteeredTurn::Turned(Turn::Over),
            Stepped::Before(mut stop) => {
                stop.is_entry = self.stopping.enters(&stop);
                match self.stopping.halt_before(system, &stop, places) {
                    Some(halt) => {
                        self.halt(&halt, Some(stop), system);
                        SteeredTurn::Halted
                    }
                    None => SteeredTurn::Turned(Turn::Over),
                }
            }
        }
    }

    /// All tasks are blocked: whether a condition to stop at has become true.
    pub fn settled(&mut self, system: &mut System<Robot>) {
        if let Some(halt) = condition_met(system, &mut self.breakpoints) {
            self.halt(&halt, None, system);
        }
    }

    fn halt(&mut self, halt: &Halt, stop: Option<Stop>, system: &System<Robot>) {
        self.standing.at = stop.as_ref().map(|stop| system.program.sources.place(stop.span));
        self.standing.note = match halt {
            Halt::Breakpoint(place) => Some(format!("stopped at {place}")),
            Halt::Arrived | Halt::Answered(_) | Halt::Interrupted => None,
        };
        self.standing.time_us = system.machine.now_us;
        self.stop = stop;
        self.until = Until::End;
        self.stand(RunState::Paused);
    }
}
