//! A run that is ready: driven to its end, and told of.

use crate::hosts::{HostLines, astray};
use crate::journal::{EndKind, JournalEnd};
use crate::observed::RunEnd;
use crate::run_driver::{Pace, drive};
use crate::run_record::Records;
use crate::seen::stay;
use crate::show::figures;
use crate::show::summary::{RunSummary, report, status, summarize};
use crate::trace::TraceFile;
use anyhow::{Context, Result, bail};
use rpl_mission::robot::Robot;
use rpl_mission::site::Site;
use rpl_page::server::news::RunState;
use rpl_robot::world::World;
use rpl_runtime::run::system::System;
use rpl_shell::files::case_files::KeptCases;
use rpl_shell::files::module_files::Modules;
use rpl_shell::files::outputs::OutputFolder;
use rpl_shell::interrupt;
use rpl_shell::status::Status;
use rpl_shell::terminal::console::Console;
use std::time::Instant;

/// A run that is ready to be driven.
pub struct PreparedRun {
    /// Where it runs.
    pub site: Site,
    /// The world, if there is one.
    pub world: Option<World>,
    /// The run.
    pub system: System<Robot>,
    /// The seed it was started with.
    pub seed: u64,
    /// How it is driven.
    pub pace: Pace,
    /// What is kept of it.
    pub records: Records,
    /// The lines to its host, if that is not our simulator.
    pub host_lines: Option<HostLines>,
    /// Its modules in other processes.
    pub modules: Modules,
    /// What is written of it when it has ended.
    pub written_at_end: WrittenAtEnd,
    /// Since when there is something to do.
    pub began: Instant,
}

/// What is written of a run when it has ended, beside what is kept of it meanwhile: nothing, if nobody asks.
#[derive(Default)]
pub struct WrittenAtEnd {
    /// Where what the robot remembers goes.
    pub cases: Option<KeptCases>,
    /// Where figures go.
    pub figures: Option<OutputFolder>,
    /// Whether all that was considered at a choice is drawn, too.
    pub draws_choices: bool,
    /// Whether a summary is written to standard output.
    pub json: bool,
}

impl PreparedRun {
    /// Drives it to its end.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn drive(mut self, console: &mut Console) -> Result<Status> {
        let ending = {
            let _stops = interrupt::stops_runs();
            drive(&mut self.system, self.pace, console, &mut self.records)
        };
        // What cannot be written otherwise is no reason to lose what was learned.
        let kept = self.keep_cases();
        let ending = ending?;
        if let Some(trace) = &mut self.records.trace {
            trace.finish().context("the trace cannot be written")?;
        }
        if let Some(recorder) = &self.records.recorder {
            recorder.finish().context("the recording cannot be written")?;
        }
        if let (Some(folder), Some(world)) = (&mut self.written_at_end.figures, &self.world) {
            let radius_m = self.site.office().map_or(0.0, |office| office.limits.robot_radius_m);
            let (observed, belief) = (&self.records.observed, self.system.outside.belief());
            let draws_choices = self.written_at_end.draws_choices;
            figures::write_mission(folder, world, radius_m, observed, belief.as_ref(), draws_choices)?;
        }
        self.records.onlookers().try_for_each(|onlooker| onlooker.ends())?;
        if let Some(steering) = &mut self.records.steering {
            steering.stand(RunState::Ended);
        }
        let summary = summarize(&self.system, ending, &self.records.observed, self.seed, self.began);
        let is_written = self.end_journal(ending, &summary)?;
        report(&self.system, ending, &summary, console);
        self.tell_divergence(console);
        self.tell_left_deviations(console);
        if let Some(journal) = &self.records.journal {
            journal.told_at_end().inspect(|told| console.note(told));
        }
        if self.written_at_end.json {
            console.print(&summary.as_json()?)?;
        }
        console.flush()?;
        if let Some(steering) = &mut self.records.steering {
            stay(|| steering.trouble(), console);
        }
        kept?;
        if !is_written {
            bail!("the run was stopped because its journal could not be written");
        }
        Ok(status(&self.system, ending))
    }

    /// Writes what the robot remembers, however the run has ended.
    fn keep_cases(&mut self) -> Result<()> {
        match (self.written_at_end.cases.take(), self.system.outside.case_memory()) {
            (Some(cases), Some(memory)) => cases.write(memory),
            _ => Ok(()),
        }
    }

    /// Whether the journal, if there is one that must be, could be written all the time.
    fn end_journal(&mut self, ending: RunEnd, summary: &RunSummary) -> Result<bool> {
        let Records { journal, trace, .. } = &mut self.records;
        let Some(journal) = journal else { return Ok(true) };
        let summary = serde_json::to_value(summary).context("the summary cannot be written as JSON")?;
        let end = JournalEnd { how: EndKind::of(ending), time_us: self.system.machine.now_us, summary };
        // What was stopped for want of a journal is not over: it goes on from where there is one.
        if !journal.stops_run() {
            journal.finish(trace.as_mut().and_then(TraceFile::ledger), &end);
        }
        Ok(!journal.stops_run())
    }

    /// A schedule is of one plan with one seed; under another it means nothing.
    fn tell_left_deviations(&self, console: &mut Console) {
        let left = self.system.machine.schedule.as_ref().map_or(0, |schedule| schedule.left().count());
        if left > 0 {
            let choices = if left == 1 { "choice" } else { "choices" };
            console.note(&format!(
                "warning: {left} {choices} of the schedule did not come; it is of another plan, seed or time limit"
            ));
        }
    }

    /// Where the run first did something else than was recorded.
    fn tell_divergence(&self, console: &mut Console) {
        let of_host = self.host_lines.as_ref().and_then(HostLines::divergence);
        let divergence = of_host.or_else(|| self.modules.divergence());
        if let (Some(divergence), Some(period_us)) = (divergence, self.site.period_us()) {
            console.note(&astray(&divergence, period_us));
        }
    }
}
