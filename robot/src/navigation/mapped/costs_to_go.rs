//! The costs to go that were asked for lately on a map, shared by all who drive on it.

use crate::geometry::Point;
use crate::memo::Memo;
use crate::planning::{CostToGo, PlannerModel};
use std::collections::VecDeque;
use std::sync::Arc;

/// The most that are kept, and the most bytes of them.
const MOST_KEPT: usize = 128;
const MOST_BYTES: usize = 32 << 20;

/// A target, and the barriers around which the ways to it lead, in the map.
type Question = (Point, Vec<Point>);

/// What it costs to go to targets, the one asked for last at the end. A pure function of map, target and barriers.
#[derive(Clone, Debug, Default)]
pub struct CostsToGo(Memo<VecDeque<(Question, Arc<CostToGo>)>>);

impl CostsToGo {
    /// To a target with barriers in closed doors. Cost: a pass over the cells of the map, if it was not asked for
    /// lately.
    pub(super) fn to(&self, planner: &PlannerModel, target_in_map: Point, barriers_in_map: &[Point]) -> Arc<CostToGo> {
        let is_same = |((target, barriers), _): &(Question, Arc<CostToGo>)| {
            *target == target_in_map && barriers == barriers_in_map
        };
        let known = self.0.with(|kept| kept.iter().rposition(is_same).and_then(|at| kept.remove(at)));
        let known = known.unwrap_or_else(|| {
            let costs = planner.cost_to_go_around(target_in_map, barriers_in_map);
            ((target_in_map, barriers_in_map.to_vec()), Arc::new(costs))
        });
        let costs = known.1.clone();
        self.0.with(|kept| {
            kept.push_back(known);
            while kept.len() > MOST_KEPT || kept.len() * costs.bytes() > MOST_BYTES {
                kept.pop_front();
            }
        });
        costs
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::avoidance::DriveLimits;
    use crate::navigation::NavigationModel;
    use crate::world::World;

    #[test]
    fn what_was_asked_for_lately_is_shared_and_what_was_long_ago_is_forgotten() {
        let world = World::builtin("test-room").expect("built in");
        let NavigationModel { planner, costs_to_go, .. } = NavigationModel::new(&world, DriveLimits::default());
        let to = |number: usize| costs_to_go.to(&planner, Point::new(1.0 + 0.01 * number as f64, 1.0), &[]);
        let first = to(0);
        assert!(Arc::ptr_eq(&first, &to(0)) && *first == planner.cost_to_go(Point::new(1.0, 1.0)));
        (1..=MOST_KEPT).for_each(|number| drop(to(number)));
        assert!(!Arc::ptr_eq(&first, &to(0)));
        let around = costs_to_go.to(&planner, Point::new(1.0, 1.0), &[Point::new(1.5, 1.0)]);
        assert!(around != first, "barriers make another question");
    }
}
