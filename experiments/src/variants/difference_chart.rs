//! How variants differ from the first one, as a chart.

use super::paired::{PairedDifferences, PairedShares};
use crate::means_chart::{Panels, Row};

/// The chart of how variants differ from the first one; none if there is nothing to compare.
pub fn differences(all: &[PairedDifferences]) -> Option<String> {
    let mut panels = Panels::of_differences();
    let against = &all.first()?.against;
    for (number, of_variant) in all.iter().enumerate() {
        let (variant, name) = (number + 1, of_variant.name.as_str());
        if let PairedShares { difference: Some(mean), interval_95, .. } = of_variant.succeeded {
            panels.add("share that succeeds", Row { variant, name, mean, interval_95 });
        }
        for measure in &of_variant.measures {
            panels.add(measure.quantity.name(), Row::of(variant, name, &measure.difference));
        }
    }
    panels.drawn(&format!("Difference from `{against}`, seed by seed: mean and 95 % interval"))
}
