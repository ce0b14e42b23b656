//! A mission as a Python object.

use crate::fault::wrong;
use crate::history::{History, Kept};
use crate::module::{self, Interrupt};
use crate::place::{self, PoseTuple, World, tuple};
use anyhow::Context;
use numpy::{IntoPyArray, PyArray1, PyArrayMethods};
use pyo3::exceptions::{PyRuntimeWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use rpl_command::embedded::{self, Folder, PlanText};
use rpl_mission::robot::Robot;
use rpl_mission::run::fluent_value;
use rpl_mission::sight::Sight;
use rpl_mission::site::Site;
use rpl_robot::description::RobotDescription;
use rpl_runtime::run::library::Loaded;
use rpl_runtime::run::system::{Outcome, System};
use std::collections::BTreeMap;
use std::ffi::CString;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// How long a mission goes on until Python is asked whether somebody wants to stop.
const BETWEEN_SIGNALS: Duration = Duration::from_millis(50);

/// A text with its name; or, if there is none, what the name is one of.
pub fn text_of(
    name: String,
    text: Option<String>,
    named: fn(&str) -> anyhow::Result<PlanText>,
) -> anyhow::Result<PlanText> {
    match text {
        Some(text) => Ok(PlanText { name, text, folder: Folder::Disk(".".into()) }),
        None => named(&name),
    }
}

/// A warning that what was told is not all there was, if it is not.
fn warn_of_forgotten<T>(py: Python<'_>, what: &str, kept: &Kept<T>) -> PyResult<()> {
    if kept.forgotten() == 0 {
        return Ok(());
    }
    let message = format!("{what} is not whole: the first {} are kept no longer", kept.forgotten());
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &CString::new(message)?, 2)
}

/// A plan, the robot in its world, what happens there, and a seed: a run as a value.
#[pyclass(subclass, module = "rpl.rpl_native")]
pub struct Mission {
    site: Arc<Site>,
    loaded: Loaded,
    seed: u64,
    system: System<Robot>,
    history: History,
    /// With modules in Python, which are no part of the value.
    interrupt: Option<Interrupt>,
}

impl Mission {
    fn started(site: Arc<Site>, loaded: Loaded, seed: u64, interrupt: Option<Interrupt>) -> Self {
        let system = site.start_traced(loaded.clone(), seed);
        let mut mission = Self { site, loaded, seed, system, history: History::default(), interrupt };
        mission.settle();
        mission
    }

    /// To the end of the instant; what came of it is kept.
    fn settle(&mut self) {
        self.system.settle();
        self.history.take_from(&mut self.system);
    }

    fn advance(&mut self) -> bool {
        if self.system.outcome().is_some() {
            return false;
        }
        self.system.next_instant();
        self.settle();
        self.system.outcome().is_none()
    }

    /// Goes on for a while. Answers whether the run has ended or the time is reached.
    fn advance_for(&mut self, wall: Duration, until_s: f64) -> bool {
        let began = Instant::now();
        while began.elapsed() < wall {
            let is_late = self.system.next_instant_us().is_some_and(|next_us| next_us as f64 / 1e6 > until_s);
            if is_late || !self.advance() {
                return true;
            }
            if self.interrupt.as_ref().is_some_and(Interrupt::is_there) {
                return false;
            }
        }
        false
    }

    /// Raises what a module was interrupted with.
    fn interrupted(&self) -> PyResult<()> {
        self.interrupt.as_ref().and_then(Interrupt::take).map_or(Ok(()), Err)
    }

    fn forked(&mut self) -> Self {
        Self {
            site: self.site.clone(),
            loaded: self.loaded.clone(),
            seed: self.seed,
            system: self.system.fork(),
            history: self.history.fork(),
            interrupt: None,
        }
    }

    fn is_value(&self) -> PyResult<()> {
        if self.interrupt.is_some() {
            return Err(PyValueError::new_err(
                "a mission with modules in Python cannot be forked or saved: nobody knows what they remember",
            ));
        }
        Ok(())
    }
}

#[pymethods]
impl Mission {
    /// A mission at its start; or, if another one is given, a second run that goes on from where that one is, whatever
    /// else is said.
    #[new]
    #[pyo3(signature = (plan, world, robot, seed, scenario, modules, fork_of=None))]
    #[expect(clippy::too_many_arguments, reason = "Python hands them over one by one")]
    fn new(
        py: Python<'_>,
        plan: (String, Option<String>),
        world: Option<&World>,
        robot: Option<&place::Robot>,
        seed: u64,
        scenario: Option<(String, Option<String>)>,
        modules: Vec<(String, Py<PyAny>)>,
        fork_of: Option<PyRefMut<'_, Self>>,
    ) -> PyResult<Self> {
        if let Some(mut other) = fork_of {
            other.is_value()?;
            return Ok(other.forked());
        }
        let robot = robot.map_or_else(RobotDescription::papers, |robot| robot.description.clone());
        py.detach(|| {
            let plan = text_of(plan.0, plan.1, embedded::plan)?;
            let scenario = scenario.map(|(name, text)| text_of(name, text, embedded::scenario)).transpose()?;
            let world = world.map(|place| (*place.world).clone());
            let interrupt = (!modules.is_empty()).then(Interrupt::default);
            let heard = interrupt.clone().unwrap_or_default();
            let modules = modules.into_iter().map(|(file, opened)| module::source(&file, opened, heard.clone()));
            let modules = modules.collect::<Result<_, _>>()?;
            let (site, loaded) = embedded::site(&plan, world, robot, scenario, modules)?;
            Ok(Self::started(Arc::new(site), loaded, seed, interrupt))
        })
        .map_err(wrong)
    }

    /// Goes on to the end of the next instant. Answers whether there is a further one.
    fn step(&mut self, py: Python<'_>) -> PyResult<bool> {
        let goes_on = py.detach(|| self.advance());
        self.interrupted()?;
        Ok(goes_on)
    }

    /// Goes on until a time of the plan, or to the end of the run. Answers whether it has ended.
    fn run_until(&mut self, py: Python<'_>, until_s: f64) -> PyResult<bool> {
        while !py.detach(|| self.advance_for(BETWEEN_SIGNALS, until_s)) {
            self.interrupted()?;
            py.check_signals()?;
        }
        self.interrupted()?;
        Ok(self.system.outcome().is_some())
    }

    /// The run as bytes, from which [`Mission::load`] goes on.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        self.is_value()?;
        Ok(PyBytes::new(py, &py.detach(|| self.system.save())))
    }

    /// Goes on from what was saved of a mission with the same plan in the same place.
    fn load(&mut self, py: Python<'_>, saved: &[u8]) -> PyResult<()> {
        self.is_value()?;
        py.detach(|| {
            let robot = self.site.robot(self.seed);
            let (library, loaded) = (self.site.library.clone(), self.loaded.clone());
            self.system = System::load(saved, library, loaded, robot).context("the run cannot be gone on with")?;
            // What came before was told by the mission that was saved.
            self.history = History::default();
            Ok(())
        })
        .map_err(wrong)
    }

    /// Virtual time in seconds.
    #[getter]
    fn time_s(&self) -> f64 {
        self.system.machine.now_s()
    }

    /// `succeeded`, `failed`, `ended itself`, or none while the run goes on.
    #[getter]
    fn outcome(&self) -> Option<&'static str> {
        Some(match self.system.outcome()? {
            Outcome::Succeeded(_) => "succeeded",
            Outcome::Failed(_) => "failed",
            Outcome::Evaporated => "ended itself",
        })
    }

    /// The value of a plan that has succeeded, as it could be read again.
    #[getter]
    fn value(&self) -> Option<String> {
        match self.system.outcome()? {
            Outcome::Succeeded(value) => Some(self.system.machine.write(&self.system.program, value)),
            Outcome::Failed(_) | Outcome::Evaporated => None,
        }
    }

    fn __repr__(&self) -> String {
        let place = match self.site.office() {
            Some(office) => format!("in {}", office.world.name),
            None => "without a robot".to_string(),
        };
        let machine = &self.system.machine;
        let standing = match self.system.outcome() {
            None => "goes on".to_string(),
            Some(Outcome::Succeeded(value)) => format!("succeeded with {}", machine.show(&self.system.program, value)),
            Some(Outcome::Failed(failure)) => format!("failed: {}", machine.show(&self.system.program, failure)),
            Some(Outcome::Evaporated) => "ended itself".to_string(),
        };
        format!("<Mission {place}, seed {}, at {:.1} s: {standing}>", self.seed, machine.now_s())
    }

    /// The failure of a plan that has failed, with its causes, as JSON.
    fn failure_json(&self) -> Option<String> {
        match self.system.outcome()? {
            Outcome::Failed(failure) => Some(embedded::failure(&self.system, failure).to_string()),
            Outcome::Succeeded(_) | Outcome::Evaporated => None,
        }
    }

    /// What the plan has printed; of very much the last million lines, and a warning tells how many came before.
    #[getter]
    fn printed(&self, py: Python<'_>) -> PyResult<Vec<&str>> {
        warn_of_forgotten(py, "what was printed", &self.history.printed)?;
        Ok(self.history.printed.iter().map(String::as_str).collect())
    }

    /// The value of a fluent of the robot, or of a global one of the plan, as it could be read again. None if there is
    /// none of the name.
    fn fluent(&self, name: &str) -> Option<String> {
        Some(self.system.machine.write(&self.system.program, fluent_value(&self.system, name)?))
    }

    /// Where the robot really is: x [m], y [m], heading [rad].
    #[getter]
    fn true_pose(&self) -> Option<PoseTuple> {
        self.system.outside.sight()?.robot_in_map.map(tuple)
    }

    /// Where it believes it is: x [m], y [m], heading [rad].
    #[getter]
    fn estimate(&self) -> Option<PoseTuple> {
        self.system.outside.sight().map(|sight| tuple(sight.estimate_in_map))
    }

    /// How sure it is of that, from 0 to 1.
    #[getter]
    fn certainty(&self) -> Option<f64> {
        self.system.outside.sight().map(|sight| sight.certainty)
    }

    /// Where the robot may be: the probability of each cell, `belief[row, column]`, as an array that cannot be written.
    /// The numbers are handed over and not copied. None without a map.
    #[getter]
    fn belief<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let Some(belief) = py.detach(|| self.system.outside.belief()) else { return Ok(None) };
        let rows = belief.cells.len() / belief.columns.max(1);
        let cells: Bound<'py, PyArray1<f64>> = belief.cells.into_pyarray(py);
        let flags = PyDict::new(py);
        flags.set_item("write", false)?;
        cells.call_method("setflags", (), Some(&flags))?;
        // A view of what cannot be written cannot either, and nobody can allow it again.
        Ok(Some(cells.reshape([rows, belief.columns])?.into_any()))
    }

    /// Where the belief lies: left, right, bottom and top in metres of the map, as `imshow` takes it.
    #[getter]
    fn belief_extent(&self) -> Option<(f64, f64, f64, f64)> {
        let grid = &self.site.office()?.map.as_ref()?.localization.grid;
        // The grid names the middle of its first cell.
        let (left_m, bottom_m) = (grid.origin_in_map.x - grid.cell_m / 2.0, grid.origin_in_map.y - grid.cell_m / 2.0);
        let (width_m, height_m) = (grid.columns as f64 * grid.cell_m, grid.rows as f64 * grid.cell_m);
        Some((left_m, left_m + width_m, bottom_m, bottom_m + height_m))
    }

    /// What was traced so far, column by column: time [s], path of the task, kind, and the details by name. Of very long
    /// runs the last million events; a warning tells how many came before.
    fn trace_columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = PyDict::new(py);
        let events = &self.history.events;
        warn_of_forgotten(py, "the trace", events)?;
        let times_s: Vec<f64> = events.iter().map(|event| event.time_us as f64 / 1e6).collect();
        columns.set_item("time_s", times_s.into_pyarray(py))?;
        columns.set_item("task", events.iter().map(|event| event.path.as_str()).collect::<Vec<_>>())?;
        columns.set_item("kind", events.iter().map(|event| event.kind.name()).collect::<Vec<_>>())?;
        let mut details: BTreeMap<&str, Vec<Option<&str>>> = BTreeMap::new();
        for (at, event) in events.iter().enumerate() {
            for (name, value) in &event.details {
                details.entry(name).or_insert_with(|| vec![None; events.len()])[at] = Some(value);
            }
        }
        for (name, values) in details {
            columns.set_item(name, values)?;
        }
        Ok(columns)
    }

    /// A drawing of the paths, and of where the robot may be, as SVG. None without a robot.
    fn figure_svg(&self, py: Python<'_>) -> Option<String> {
        py.detach(|| {
            let world = &self.site.office()?.world;
            let radius_m = self.site.office()?.settings.robot.radius_m;
            let track: Vec<Sight> = self.history.track.iter().copied().collect();
            Some(embedded::figure(world, radius_m, &track, self.system.outside.belief().as_ref()))
        })
    }
}
