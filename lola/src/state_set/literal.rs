//! Eqs. (1) and (3) as they are printed, to compare with.

use super::chain::Chain;
use super::matrix::Matrix;
use crate::feature::Feature;

/// The certainties of all nodes from the start to the goal after a percept, from those before it, where the
/// goal's is left out: nothing goes on from it. The start is a wall. Cost: linear in the nodes.
pub(super) fn progressed(chain: &Chain, matrix: &Matrix, before: &[f64], seen: Feature) -> Vec<f64> {
    let sum = |percept: Feature, node: usize| -> f64 {
        let features = if node == 0 { &[Feature::Wall] } else { chain.counted };
        features.iter().map(|&feature| matrix.certainty(percept, feature)).sum()
    };
    let mut certainties = vec![0.0];
    let mut reaching = 0.0;
    for (node, earlier) in before.iter().enumerate() {
        // The first bracket of Eq. (3) is about the node left behind, S_j.
        reaching = reaching * sum(Feature::Wall, node) + earlier * sum(seen, node);
        certainties.push(reaching);
    }
    certainties
}
