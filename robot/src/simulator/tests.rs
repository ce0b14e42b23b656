use super::*;
use crate::world::World;
use std::sync::Arc;

#[test]
fn a_sonar_facing_a_wall_reads_its_distance() {
    let model = SimulatorModel::new(Arc::new(World::builtin("test-room").unwrap()), SimulatorSettings::exact());
    let mut state = model.start(1);
    let percept = model.step(&mut state, &Commands { sonars_on: true, ..Commands::default() });
    let sonar_m = percept.sonar_m.unwrap();
    assert!((sonar_m[12] - 1.3).abs() < 1e-6, "{sonar_m:?}");
    assert!((sonar_m[6] - (5.8 - 3.0)).abs() < 1e-6, "{sonar_m:?}");
}
