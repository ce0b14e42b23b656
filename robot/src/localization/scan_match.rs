//! The pose below the size of a cell: where a scan of rays fits the map best.

use super::evidence::Evidence;
use super::model::LocalizationModel;
use super::parameters::{OdometryError, Spread};
use super::scan::ScanModel;
use crate::geometry::{Pose, wrap_angle_rad};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

/// Differences well beyond this count for little, step by step: at first the pose is known to a cell
/// and the heading to a step.
pub(super) const SCALES_M: [f64; 4] = [0.3, 0.15, 0.1, 0.1];

/// A pose farther than this from where the belief has its mode is another one.
const FARTHEST_M: f64 = 0.35;
const FARTHEST_RAD: f64 = 8.0 / 180.0 * std::f64::consts::PI;

/// A pose that was found by its scans, and how well it is known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Fix {
    /// The pose.
    pub pose_in_map: Pose,
    /// Covariance of x, y and heading, in m and rad.
    covariance: [[f64; 3]; 3],
}

impl Fix {
    /// A pose that is known so well.
    pub(super) fn around(pose_in_map: Pose, spread: Spread) -> Self {
        let square = |error: f64| error * error;
        let position = square(spread.position_m);
        let variances = Vector3::new(position, position, square(spread.heading_rad));
        Self { pose_in_map, covariance: Matrix3::from_diagonal(&variances).into() }
    }

    /// How well the pose is known: in the direction in which it is known worst, and in the heading.
    pub(super) fn spread(&self) -> Spread {
        let [[xx, yx, _], [_, yy, _], [_, _, heading]] = self.covariance;
        let (mean, half) = ((xx + yy) / 2.0, libm::hypot((xx - yy) / 2.0, yx));
        Spread { position_m: libm::sqrt(mean + half), heading_rad: libm::sqrt(heading) }
    }

    /// Variances of the position, the sum along both axes, and of the heading.
    pub(super) fn variances(&self) -> [f64; 2] {
        let [[xx, ..], [_, yy, _], [_, _, heading]] = self.covariance;
        [xx + yy, heading]
    }

    /// Carried on by a motion, whose error adds to its own.
    pub(super) fn advanced(self, motion: Pose, error: &OdometryError) -> Self {
        let before = self.pose_in_map;
        let pose_in_map = before.compose(motion);
        let (dx_m, dy_m) = (pose_in_map.x_m - before.x_m, pose_in_map.y_m - before.y_m);
        let (sin, cos) = libm::sincos(before.heading_rad);
        let turned = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let noise = Vector3::from(error.variances(motion));
        let carried = Matrix3::new(1.0, 0.0, -dy_m, 0.0, 1.0, dx_m, 0.0, 0.0, 1.0);
        let covariance = carried * Matrix3::from(self.covariance) * carried.transpose()
            + turned * Matrix3::from_diagonal(&noise) * turned.transpose();
        Self { pose_in_map, covariance: covariance.into() }
    }

    /// Whether it may be the pose that a belief has its mode at.
    pub(super) fn is_near(&self, mode_in_map: Pose) -> bool {
        let turned_rad = libm::fabs(wrap_angle_rad(self.pose_in_map.heading_rad - mode_in_map.heading_rad));
        self.pose_in_map.distance_m(mode_in_map) <= FARTHEST_M && turned_rad <= FARTHEST_RAD
    }
}

impl LocalizationModel {
    /// The pose near the mode of a belief that explains the scans of rays best, beginning from what the
    /// last one says of it. None if no rays are read, because a cone does not say from where in it an
    /// echo comes; or if it is not near the mode.
    ///
    /// # Deviation
    /// The papers take the likeliest cell. Gauss and Newton's method on the differences between
    /// measured and expected ranges (as Kohlbrecher et al., "A flexible and scalable SLAM system with
    /// full 3D motion estimation", 2011, match scans to a grid map) finds where inside it the robot is.
    /// A surface is the line through the ends of the ray and of two beside it, because the cells of a wall that is not
    /// along the grid are a stair. Each difference is taken across it and weighted by Geman and McClure's kernel, so
    /// that people and furniture count for little, and tempered as the scan is, to the same power. The prior is the last
    /// pose found this way, carried on by odometry, as long as the mode is near it and odometry is never badly wrong;
    /// else the mode. Along a bare wall it alone tells. Costs twelve rays for each beam.
    pub(super) fn matched(
        &self,
        mode_in_map: Pose,
        last: Option<Fix>,
        scans_m: &[Option<&[f32]>],
        powers: &[f64],
    ) -> Option<Fix> {
        let scans = self.sensors.iter().zip(scans_m).zip(powers);
        let scans: Vec<(&ScanModel, &[f32], f64)> = scans
            .filter(|((sensor, _), _)| sensor.parameters.beam.cone_deg == 0)
            .filter_map(|((sensor, scan_m), &power)| scan_m.map(|scan_m| (sensor, scan_m, power)))
            .collect();
        if scans.is_empty() {
            return None;
        }
        let known = last.filter(|last| last.is_near(mode_in_map)).unwrap_or_else(|| self.mode_fix(mode_in_map));
        let prior = Matrix3::from(known.covariance).try_inverse()?;
        let mut fix = known;
        for scale_m in SCALES_M {
            let mut evidence = Evidence::of_pose(prior, known.pose_in_map, fix.pose_in_map);
            for &(sensor, scan_m, power) in &scans {
                add_scan(&mut evidence, sensor, scan_m, power, fix.pose_in_map, scale_m);
            }
            let factors = evidence.information.cholesky()?;
            let (step, pose) = (factors.solve(&evidence.pull), fix.pose_in_map);
            fix.pose_in_map = Pose::new(pose.x_m + step.x, pose.y_m + step.y, pose.heading_rad + step.z);
            fix.covariance = factors.inverse().into();
        }
        Some(fix).filter(|fix| fix.is_near(mode_in_map))
    }

    /// What is known before the scans: the mode, to a cell, though the mean around it is known to half of one: the
    /// belief has heard these scans, and what they say is not to count twice.
    fn mode_fix(&self, mode_in_map: Pose) -> Fix {
        Fix::around(mode_in_map, Spread { position_m: self.grid.cell_m, heading_rad: self.grid.angle_step_rad() })
    }
}

/// Adds what the rays of a scan say whose ends lie on surfaces.
fn add_scan(evidence: &mut Evidence, sensor: &ScanModel, scan_m: &[f32], power: f64, pose: Pose, scale_m: f64) {
    let beam = &sensor.parameters.beam;
    let tempering = power * sensor.parameters.tempering;
    for (bearing_deg, &range_m) in sensor.parameters.beams_deg.iter().zip(scan_m) {
        let (bearing_rad, range_m) = (f64::from(*bearing_deg).to_radians(), f64::from(range_m));
        if range_m < beam.max_range_m {
            evidence.add_ray(&sensor.distances, beam, tempering, pose, (bearing_rad, range_m), scale_m);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::localization::{BeamParameters, LocalizationParameters, ScanParameters};
    use crate::occupancy::{Cell, OccupancyGrid};
    use crate::sensors::LaserScanner;
    use rpl_random::Stream;

    /// A walled room, `length_m` × 4 m, in cells of 5 cm.
    fn room(length_m: f64) -> OccupancyGrid {
        let (columns, rows) = ((length_m / 0.05) as usize, 80);
        let mut map = OccupancyGrid::filled(Point::origin(), 0.05, columns, rows, Cell::Free);
        for column in 0..columns {
            (0..rows).for_each(|row| {
                if column < 2 || row < 2 || column + 2 >= columns || row + 2 >= rows {
                    map.set(column, row, Cell::Occupied);
                }
            });
        }
        map
    }

    fn model(map: &OccupancyGrid, sensor: ScanParameters) -> LocalizationModel {
        let parameters = LocalizationParameters { sensors: vec![sensor], ..LocalizationParameters::default() };
        LocalizationModel::new(map, parameters).expect("the room is a map")
    }

    fn laser() -> ScanParameters {
        ScanParameters::laser(&LaserScanner { readings: 181, resolution_deg: 1.0, range_m: 8.0 })
    }

    /// What a laser measures at a pose, with noise of this standard deviation.
    fn scan_m(model: &LocalizationModel, pose: Pose, sigma_m: f64, noise: &mut Stream) -> Vec<f32> {
        let ray = |bearing_deg: &i32| {
            let (sin, cos) = libm::sincos(pose.heading_rad + f64::from(*bearing_deg).to_radians());
            (model.distances.cast_m(pose.point(), (cos, sin), 8.0) + sigma_m * noise.normal()).min(8.0) as f32
        };
        model.sensors[0].parameters.beams_deg.iter().map(ray).collect()
    }

    #[test]
    fn inside_a_cell_the_pose_is_found_by_a_few_scans() {
        let model = model(&room(6.0), laser());
        let mut noise = Stream::new(10_300, "noise");
        for _ in 0..50 {
            let truth = Pose::new(noise.uniform_in(1.0, 5.0), noise.uniform_in(1.0, 3.0), noise.uniform_in(-3.0, 3.0));
            let [x, y, turn] = [0.1, 0.1, 0.03].map(|most| noise.uniform_in(-most, most));
            let mode = Pose::new(truth.x_m + x, truth.y_m + y, truth.heading_rad + turn);
            let mut found = None;
            for _ in 0..3 {
                let mut scan_m = scan_m(&model, truth, 0.02, &mut noise);
                // Somebody stands to the left.
                scan_m[22..26].fill(0.6);
                found = model.matched(mode, found, &[Some(&scan_m)], &[1.0]);
            }
            let found = found.expect("a fix").pose_in_map;
            let turned_rad = wrap_angle_rad(found.heading_rad - truth.heading_rad).abs();
            assert!(found.distance_m(truth) < 0.04 && turned_rad < 1f64.to_radians(), "{truth:?} {mode:?} {found:?}");
        }
    }

    #[test]
    fn along_a_bare_wall_the_pose_stays() {
        let model = model(&room(40.0), laser());
        let (truth, mode) = (Pose::new(20.0, 1.7, 0.0), Pose::new(20.1, 1.76, 0.02));
        let scan_m = scan_m(&model, truth, 0.0, &mut Stream::new(10_301, "noise"));
        let found = model.matched(mode, None, &[Some(&scan_m)], &[1.0]).expect("a fix").pose_in_map;
        assert!((found.x_m - mode.x_m).abs() < 0.02 && (found.y_m - truth.y_m).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn walls_across_the_grid_tell_the_heading() {
        // A room of 6 × 4 m, turned; its cells begin before the walls, as in a map made of scans.
        const TURNED_RAD: f64 = 0.35;
        const HALF_M: [f64; 2] = [3.0, 2.0];
        let sensor = laser();
        let beam = BeamParameters { wall_depth_m: 0.08, ..sensor.beam.clone() };
        let mut map = OccupancyGrid::filled(Point::new(-4.0, -4.0), 0.1, 80, 80, Cell::Free);
        let in_room = |at: Point| Pose::new(0.0, 0.0, -TURNED_RAD).transform(at);
        for (column, row) in (0..80).flat_map(|row| (0..80).map(move |column| (column, row))) {
            let at = in_room(map.centre(column, row));
            // The edge of a cell is half a cell before its middle.
            let most_m = HALF_M.map(|half_m| half_m - beam.wall_depth_m + 0.05);
            if at.x.abs() > most_m[0] || at.y.abs() > most_m[1] {
                map.set(column, row, Cell::Occupied);
            }
        }
        let parameters = LocalizationParameters {
            cell_m: 0.1,
            sensors: vec![ScanParameters { beam, tempering: 0.2, ..sensor }],
            ..LocalizationParameters::default()
        };
        let model = LocalizationModel::new(&map, parameters).expect("the room is a map");
        let mut noise = Stream::new(10_310, "noise");
        let mut off_rad = 0.0;
        for _ in 0..100 {
            let [x_m, y_m, heading_rad] = [2.0, 1.2, 3.0].map(|most| noise.uniform_in(-most, most));
            let truth = Pose::new(0.0, 0.0, TURNED_RAD).compose(Pose::new(x_m, y_m, heading_rad));
            let [x, y, turn] = [0.1, 0.1, 0.03].map(|most| noise.uniform_in(-most, most));
            let mode = Pose::new(truth.x_m + x, truth.y_m + y, truth.heading_rad + turn);
            let ray = |bearing_deg: &i32| {
                let (sin, cos) = libm::sincos(heading_rad + f64::from(*bearing_deg).to_radians());
                let to = |half_m: f64, at_m: f64, along: f64| (half_m * along.signum() - at_m) / along;
                (to(HALF_M[0], x_m, cos).min(to(HALF_M[1], y_m, sin)) + 0.02 * noise.normal()) as f32
            };
            let scan_m: Vec<f32> = model.sensors[0].parameters.beams_deg.iter().map(ray).collect();
            let found = model.matched(mode, None, &[Some(&scan_m)], &[1.0]).expect("a fix").pose_in_map;
            off_rad += wrap_angle_rad(found.heading_rad - truth.heading_rad).abs() / 100.0;
        }
        // By the cells alone, or with the depth of a wall along the ray, it is 0.42° and more.
        assert!(off_rad < 0.4f64.to_radians(), "{}°", off_rad.to_degrees());
    }

    #[test]
    fn cones_and_missing_scans_give_no_fix() {
        let mode = Pose::new(3.07, 2.01, 0.4);
        let rays = model(&room(6.0), laser());
        assert_eq!(rays.matched(mode, None, &[None], &[1.0]), None);
        let cones = model(&room(6.0), ScanParameters::default());
        assert_eq!(cones.matched(mode, None, &[Some(&[1.0; 24])], &[1.0]), None);
    }
}
