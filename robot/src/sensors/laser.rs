//! The laser range finder.

/// Readings of a scan: the front half turn, one per degree.
pub const LASER_READINGS: usize = 181;

/// Direction in `base` of one of `readings` readings, a degree apart from right to left about straight
/// ahead.
pub fn laser_direction_rad(readings: usize, reading: usize) -> f64 {
    (reading as f64 - (readings as f64 - 1.0) / 2.0).to_radians()
}

/// The reading in a direction of whole degrees, of `readings` ones; none where the laser does not look.
pub fn laser_reading(readings: usize, bearing_deg: i32) -> Option<usize> {
    let reading = f64::from(bearing_deg) + (readings as f64 - 1.0) / 2.0;
    (0.0..readings as f64).contains(&reading).then_some(reading as usize)
}
