//! Worlds, robots and poses as Python objects.

use crate::fault::wrong;
use pyo3::prelude::*;
use rpl_command::embedded;
use rpl_robot::description::RobotDescription;
use rpl_robot::geometry::Pose;
use rpl_robot::world;
use std::collections::BTreeMap;
use std::sync::Arc;

/// A pose as Python has it: x and y in metres, the heading in radians.
pub type PoseTuple = (f64, f64, f64);

/// The pose as Python has it.
pub fn tuple(pose: Pose) -> PoseTuple {
    (pose.x_m, pose.y_m, pose.heading_rad)
}

/// A robot: what it looks like and can do. The name of a built-in one, or a file; the papers' robot without.
#[pyclass(frozen, module = "rpl")]
pub struct Robot {
    /// What it is like.
    pub description: Arc<RobotDescription>,
}

#[pymethods]
impl Robot {
    #[new]
    #[pyo3(signature = (name=None))]
    fn new(name: Option<&str>) -> PyResult<Self> {
        Ok(Self { description: embedded::robot(name).map_err(wrong)? })
    }

    /// The robots that need no file.
    #[staticmethod]
    fn names() -> Vec<&'static str> {
        RobotDescription::builtin_names().collect()
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.description.name
    }

    /// What it is, in a sentence.
    #[getter]
    fn purpose(&self) -> &str {
        &self.description.purpose
    }

    /// Radius of its circle, in metres.
    #[getter]
    fn radius_m(&self) -> f64 {
        self.description.radius_m
    }

    fn __repr__(&self) -> String {
        format!("Robot({:?})", self.description.name)
    }
}

/// A world: the name of a built-in one, or a file. An arena is drawn from the seed.
#[pyclass(frozen, module = "rpl")]
pub struct World {
    /// What stands where.
    pub world: Arc<world::World>,
    /// Of the robot that stands at the start.
    robot_radius_m: f64,
}

#[pymethods]
impl World {
    #[new]
    #[pyo3(signature = (name, robot=None, seed=1))]
    fn new(py: Python<'_>, name: &str, robot: Option<&Robot>, seed: u64) -> PyResult<Self> {
        let robot = robot.map_or_else(RobotDescription::papers, |robot| robot.description.clone());
        let world = py.detach(|| embedded::world(name, &robot, seed)).map_err(wrong)?;
        Ok(Self { world: Arc::new(world), robot_radius_m: robot.radius_m })
    }

    /// The worlds that need no file.
    #[staticmethod]
    fn names() -> Vec<&'static str> {
        embedded::world_names().collect()
    }

    /// Its name.
    #[getter]
    fn name(&self) -> &str {
        &self.world.name
    }

    /// Left, right, bottom and top in metres of the map, as `imshow` takes it.
    #[getter]
    fn extent(&self) -> (f64, f64, f64, f64) {
        let bounds = self.world.bounds();
        (bounds.min.x, bounds.max.x, bounds.min.y, bounds.max.y)
    }

    /// Where the robot stands at the start: x [m], y [m], heading [rad].
    #[getter]
    fn start(&self) -> PoseTuple {
        tuple(self.world.start_in_map)
    }

    /// The places by name: x [m], y [m], heading [rad].
    #[getter]
    fn places(&self) -> BTreeMap<&str, PoseTuple> {
        self.world.places.iter().map(|place| (place.name.as_str(), tuple(place.pose_in_map))).collect()
    }

    fn _repr_svg_(&self, py: Python<'_>) -> String {
        py.detach(|| embedded::world_figure(&self.world, self.robot_radius_m))
    }

    fn __repr__(&self) -> String {
        format!("World({:?})", self.world.name)
    }
}
