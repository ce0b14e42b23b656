//! What happens in a run, written down as what is seen of it.

use super::robot_view::RobotView;
use super::task_view::{TaskView, cut};
use crate::events::{LineKind, ToldLine, detail};
use crate::show::event_line::ROBOT;
use crate::trace::TracedPose;
use rpl_mission::robot::Robot;
use rpl_mission::sight::Sight;
use rpl_page::series::{Fluent, Seen, Series, SeriesWriter, Told, ToldKind};
use rpl_page::server::news::News;
use rpl_runtime::state::trace::{Event, EventKind};
use std::sync::mpsc::Sender;

/// Writes what is seen of a run.
pub struct Feed {
    tasks: TaskView,
    robot: RobotView,
    writer: SeriesWriter,
    /// All of it, if it is needed afterwards.
    kept: Option<Series>,
    /// The page of the run that goes on, if there is one.
    page: Option<Sender<News>>,
}

impl Feed {
    /// Of a run at its start; where the robot really is only if that is to be seen.
    pub fn new(kept: Option<Series>, page: Option<Sender<News>>, truth: bool) -> Self {
        let (tasks, robot, writer) = (TaskView::default(), RobotView::new(truth), SeriesWriter::default());
        Self { tasks, robot, writer, kept, page }
    }

    /// All that was seen so far, if it was kept.
    pub fn kept(&self) -> Option<&Series> {
        self.kept.as_ref()
    }

    /// All that was seen, if it was kept.
    pub fn into_kept(self) -> Option<Series> {
        self.kept
    }

    fn add(&mut self, time_us: u64, seen: impl IntoIterator<Item = Seen>) {
        let lines = self.writer.lines(time_us, seen);
        if lines.is_empty() {
            return;
        }
        if let Some(kept) = &mut self.kept {
            kept.add(&lines);
        }
        if let Some(page) = &self.page {
            // A page that has broken off is told of by itself.
            page.send(News::Lines(lines)).ok();
        }
    }

    /// Takes in what happened.
    pub fn events(&mut self, events: &[Event]) {
        for event in events {
            let mut seen = self.tasks.take(event);
            seen.extend(fluent(event));
            seen.extend(failure_or_notice(event));
            self.add(event.time_us, seen);
        }
    }

    /// Takes in what a person was told in an instant.
    pub fn told(&mut self, time_us: u64, told: &ToldLine) {
        let kind = match told.kind {
            LineKind::Print => ToldKind::Print,
            LineKind::Log => ToldKind::Log,
            LineKind::Event => ToldKind::Robot,
        };
        self.add(time_us, [Seen::Told(Told { kind, text: cut(&told.text), task: String::new() })]);
    }

    /// Looks at the robot, which is seen as said.
    pub fn look(&mut self, now_us: u64, sight: &Sight, robot: &mut Robot) {
        let seen = self.robot.look(now_us, sight, robot);
        self.add(now_us, seen);
    }

    /// Takes in where the robot was, of a run that is over.
    pub fn pose(&mut self, pose: &TracedPose) {
        let seen = self.robot.note(&pose.sight);
        self.add(pose.time_us, seen);
    }
}

fn fluent(event: &Event) -> Option<Seen> {
    let value = match event.kind {
        EventKind::Fluent => Some(cut(detail(event, "value"))),
        EventKind::Pulse => None,
        _ => return None,
    };
    let by = if event.path.is_empty() { ROBOT } else { &event.path }.to_string();
    Some(Seen::Fluent(Fluent { name: detail(event, "fluent").to_string(), value, by }))
}

fn failure_or_notice(event: &Event) -> Option<Seen> {
    let (kind, text) = match event.kind {
        EventKind::Failed => (ToldKind::Failure, detail(event, "failure")),
        EventKind::Handled => (ToldKind::Handled, ""),
        EventKind::Warning => (ToldKind::Notice, detail(event, "text")),
        EventKind::Swapped => (ToldKind::Notice, "has another plan"),
        EventKind::Decided => (ToldKind::Notice, detail(event, "what")),
        _ => return None,
    };
    Some(Seen::Told(Told { kind, text: cut(text), task: event.path.clone() }))
}
