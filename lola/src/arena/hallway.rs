//! A hallway, and all that is on its sides.

use super::interval::{Interval, Millimetres};
use crate::feature::{Feature, Side};
use rpl_robot::world::Axis;

/// A straight hallway from wall to wall, with the squares where others cross it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Hallway {
    /// Along which axis of the map it runs.
    pub axis: Axis,
    /// Its floor along that axis: where it begins and ends.
    pub along_mm: Interval,
    /// Its floor across that axis.
    pub across_mm: Interval,
    /// What is on its left and on its right for who walks in the direction of the axis, in that order.
    pub sides: [Vec<SideFeature>; 2],
}

/// A feature of a hallway's side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SideFeature {
    /// What it is; never a wall.
    pub feature: Feature,
    /// Where it begins, along the hallway's axis in the map.
    pub from_mm: Millimetres,
    /// Where it ends.
    pub to_mm: Millimetres,
    /// What is behind it.
    pub leads_to: LeadsTo,
}

/// What is behind an opening.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeadsTo {
    /// A room, by its number in the arena.
    Room(usize),
    /// Another hallway, by its number in the arena.
    Hallway(usize),
}

impl SideFeature {
    /// Its middle, along the hallway's axis in the map.
    pub fn middle_mm(&self) -> Millimetres {
        (self.from_mm + self.to_mm) / 2
    }
}

impl Hallway {
    /// Whether an instruction that names a side of the robot means the left or the right of one who walks in
    /// the direction of the axis, or (not `forwards`) against it.
    pub fn side_in_map(side: Side, forwards: bool) -> Side {
        if forwards { side } else { side.other() }
    }

    /// On which side larger (or smaller) values of the other axis lie for who walks in the direction of this one:
    /// along x, larger y is left; along y, larger x is right.
    pub(super) fn side_towards(&self, larger: bool) -> Side {
        match (self.axis, larger) {
            (Axis::X, true) | (Axis::Y, false) => Side::Left,
            (Axis::X, false) | (Axis::Y, true) => Side::Right,
        }
    }

    /// What is on a side for who walks in the direction of the axis, from its beginning on.
    pub fn side(&self, side: Side) -> &[SideFeature] {
        match side {
            Side::Left => &self.sides[0],
            Side::Right => &self.sides[1],
        }
    }

    pub(super) fn side_mut(&mut self, side: Side) -> &mut Vec<SideFeature> {
        match side {
            Side::Left => &mut self.sides[0],
            Side::Right => &mut self.sides[1],
        }
    }

    /// What begins at or after a point of the axis on a side of a robot that drives on from there, the nearest
    /// first.
    pub fn ahead(&self, side: Side, at_mm: Millimetres, forwards: bool) -> Vec<SideFeature> {
        let features = self.side(Self::side_in_map(side, forwards)).iter();
        if forwards {
            features.filter(|feature| feature.from_mm >= at_mm).copied().collect()
        } else {
            features.rev().filter(|feature| feature.to_mm <= at_mm).copied().collect()
        }
    }

    /// Where it ends for a robot that drives in this direction.
    pub fn end_mm(&self, forwards: bool) -> Millimetres {
        if forwards { self.along_mm.1 } else { self.along_mm.0 }
    }

    /// What is on a side of a robot that drives on from a point of the axis, as `from` and `to` in metres along
    /// the way it drives: the nearest first, and what begins behind it with negative numbers.
    pub fn seen_from(&self, side: Side, at_mm: Millimetres, forwards: bool) -> Vec<(Feature, f64, f64)> {
        let metres = |along_mm: Millimetres| (along_mm - at_mm) as f64 / 1000.0;
        let features = self.side(Self::side_in_map(side, forwards)).iter();
        if forwards {
            features.map(|found| (found.feature, metres(found.from_mm), metres(found.to_mm))).collect()
        } else {
            features.rev().map(|found| (found.feature, -metres(found.to_mm), -metres(found.from_mm))).collect()
        }
    }
}
