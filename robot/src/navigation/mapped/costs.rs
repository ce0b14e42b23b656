//! What it costs to go to the current target, kept as long as nothing changes.

use super::model::NavigationModel;
use crate::geometry::Point;
use crate::navigation::cache::Cache;
use crate::planning::CostToGo;
use std::sync::Arc;

/// The ways to the current target.
#[derive(Clone, Debug)]
pub(super) struct Costs {
    /// As the map has it, but for doors found closed.
    pub mapped: Arc<CostToGo>,
    /// With the blockages besides.
    pub around: Arc<CostToGo>,
}

/// The costs that were asked for last, and what for.
#[derive(Clone, Debug)]
pub(super) struct KnownCosts {
    target_in_map: Point,
    barriers_in_map: Vec<Point>,
    blocked_in_map: Vec<Point>,
    costs: Costs,
}

impl Cache<KnownCosts> {
    /// The costs to a target with barriers in closed doors and blocked points; a pass over the cells of
    /// the map for each that is not known yet.
    pub fn costs(
        &mut self,
        model: &NavigationModel,
        target_in_map: Point,
        barriers_in_map: Vec<Point>,
        blocked_in_map: Vec<Point>,
    ) -> Costs {
        let is_same =
            |known: &KnownCosts| known.target_in_map == target_in_map && known.barriers_in_map == barriers_in_map;
        let known = self.0.take().filter(is_same);
        if let Some(known) = known.clone().filter(|known| known.blocked_in_map == blocked_in_map) {
            self.0 = Some(known.clone());
            return known.costs;
        }
        let mapped = known.map_or_else(
            || model.costs_to_go.to(&model.planner, target_in_map, &barriers_in_map),
            |known| known.costs.mapped,
        );
        let around = if blocked_in_map.is_empty() {
            mapped.clone()
        } else {
            let all = [&barriers_in_map[..], &blocked_in_map].concat();
            Arc::new(model.planner.cost_to_go_around(target_in_map, &all))
        };
        let costs = Costs { mapped, around };
        self.0 = Some(KnownCosts { target_in_map, barriers_in_map, blocked_in_map, costs: costs.clone() });
        costs
    }

    /// Bytes of costs that an earlier cache does not share.
    pub fn bytes_apart(&self, earlier: &Self) -> usize {
        let Some(KnownCosts { costs, .. }) = &self.0 else { return 0 };
        let known: Vec<&Arc<CostToGo>> =
            earlier.0.iter().flat_map(|known| [&known.costs.mapped, &known.costs.around]).collect();
        let is_new = |cost: &&Arc<CostToGo>| !known.iter().any(|known| Arc::ptr_eq(known, cost));
        [&costs.mapped, &costs.around].into_iter().filter(is_new).map(|cost| cost.bytes()).sum()
    }
}
