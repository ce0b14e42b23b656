//! Which readings of a scan the filter is given.

use super::drive::{Scan, ScanGeometry};

/// Why there is no such choice of beams.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BeamError {
    /// Nothing to localize with.
    #[error("at least one beam is needed")]
    None,
    /// The tables have a direction for each whole degree.
    #[error("{wanted} beams are more than the scan has at different whole degrees, which are {most}")]
    TooMany {
        /// What was asked for.
        wanted: usize,
        /// What there is.
        most: usize,
    },
}

/// Beams of a scan, equally spaced over it.
///
/// The tables of expected distances have a direction for each whole degree; a beam is the reading
/// that is nearest to one, at most half the scan's step away from it.
#[derive(Clone, Debug, PartialEq)]
pub struct BeamChoice {
    /// Indices of the readings.
    pub readings: Vec<usize>,
    /// Their bearings, to the left of straight ahead.
    pub bearings_deg: Vec<i32>,
}

impl BeamChoice {
    /// `beams` beams from the first reading to the last; a single one looks into the middle.
    ///
    /// # Errors
    /// No beam, or more than there are whole degrees.
    pub fn spread(geometry: &ScanGeometry, beams: usize) -> Result<Self, BeamError> {
        if beams == 0 {
            return Err(BeamError::None);
        }
        let last = (geometry.readings - 1) as f64;
        let bearing_deg = |reading: f64| (geometry.first_rad + reading * geometry.step_rad).to_degrees();
        let most = (last * geometry.step_rad.to_degrees()).min(359.0) as usize + 1;
        let wanted = |beam: usize| if beams == 1 { last / 2.0 } else { last * beam as f64 / (beams - 1) as f64 };
        let bearings_deg: Vec<i32> = (0..beams).map(|beam| libm::round(bearing_deg(wanted(beam))) as i32).collect();
        if beams > most.min(geometry.readings) || bearings_deg.windows(2).any(|pair| pair[0] == pair[1]) {
            return Err(BeamError::TooMany { wanted: beams, most: most.min(geometry.readings) });
        }
        let reading = |bearing_deg: &i32| {
            let exact = (f64::from(*bearing_deg).to_radians() - geometry.first_rad) / geometry.step_rad;
            libm::round(exact).clamp(0.0, last) as usize
        };
        Ok(Self { readings: bearings_deg.iter().map(reading).collect(), bearings_deg })
    }

    /// The beams' readings of a scan.
    pub fn ranges_m(&self, scan: &Scan) -> Vec<f32> {
        self.readings.iter().map(|&reading| scan.ranges_m[reading]).collect()
    }
}
