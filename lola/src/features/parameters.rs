//! What feature detection goes by, each with its reason.

/// The one place with its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FeatureParameters {
    /// Transducers up to this far off the perpendicular count: with a cone of 15° that is two to each side, and the
    /// echo comes from less than 25° off, where walls reflect the pulse back.
    pub widest_rad: f64,
    /// How far the robot drives from one kept scan to the next: three times as fine as the grain of misses.
    pub scan_m: f64,
    /// How much of the way is kept: the widest door, and wall on both sides of it.
    pub kept_m: f64,
    /// A reading this far beyond the wall is of an opening: deeper than any leaf in a wall of half a metre.
    pub opening_m: f64,
    /// A reading this far before the wall is of something that stands there, a box or a person: more than
    /// noise and the wall's own waves.
    pub obstacle_m: f64,
    /// The side reference is the median over this length of the way, as in the paper.
    pub reference_m: f64,
    /// An opening has ended when the wall was heard again over this length.
    pub wall_again_m: f64,
    /// Readings of beyond the wall are in a row if they are no farther apart.
    pub break_m: f64,
    /// A row of this length begins an opening: on shorter ways the corner of a box or a person walking by gives no
    /// echo either.
    pub least_stretch_m: f64,
    /// The longest row of an opening must have at least this length.
    pub least_heard_m: f64,
    /// Of the cones that look wholly into an opening, this share must hear beyond the wall rather than it ...
    pub least_share: f64,
    /// ... and this share although something stands before it.
    pub least_share_past: f64,
    /// Narrower ones are false alarms: doors are 0.9 m to 1 m wide, and a box may hide a third of one.
    pub least_width_m: f64,
    /// Half-way between a door of 1 m and a hallway of 2 m.
    pub hallway_m: f64,
    /// Half-way between a hallway of 2.5 m and a foyer of 3.5 m.
    pub foyer_m: f64,
    /// The same of an opening of which something hides a part: just wider than a door, than a hallway.
    pub hidden_m: [f64; 2],
    /// The widths of closed doors, from and to.
    pub door_m: (f64, f64),
    /// Places and widths of closed doors are tried in steps of this.
    pub grain_m: f64,
    /// Wall that is fitted before and behind an indentation.
    pub beside_m: f64,
    /// Wall that must have been passed behind it.
    pub behind_m: f64,
    /// How deep leaves are in their walls, from and to: the depth in a wall of 15 cm is 5.5 cm, in one of 10 cm
    /// 3 cm, in one of 30 cm 13 cm.
    pub leaf_m: (f64, f64),
    /// The wall's direction is known from the axis to within this.
    pub slope_rad: f64,
    /// An indentation must be deeper than its standard deviation by this factor ...
    pub least_significance: f64,
    /// ... which is at least that of a sonar that makes the errors of an echo at a metre.
    pub least_noise_m: f64,
    /// Readings of the leaf alone that are needed.
    pub least_readings: f64,
    /// A marker is of a door if it lies between its edges or within this distance of one.
    pub marker_beside_m: f64,
    /// And within these distances from the face of its wall.
    pub marker_aside_m: f64,
    /// When a door's marker is this far behind, the sonars have made of the door whatever they will.
    pub marker_behind_m: f64,
    /// With a marker, even a wider opening is a door: no hallway has one.
    pub marked_hallway_m: f64,
}

pub(super) const PARAMETERS: FeatureParameters = FeatureParameters {
    widest_rad: 0.56,
    scan_m: 0.02,
    kept_m: 3.2,
    opening_m: 0.25,
    obstacle_m: 0.13,
    reference_m: 0.25,
    wall_again_m: 0.12,
    break_m: 0.06,
    least_stretch_m: 0.12,
    least_heard_m: 0.2,
    least_share: 0.6,
    least_share_past: 0.4,
    least_width_m: 0.45,
    hallway_m: 1.5,
    foyer_m: 3.0,
    hidden_m: [1.15, 2.7],
    door_m: (0.8, 1.1),
    grain_m: 0.05,
    beside_m: 0.7,
    behind_m: 0.25,
    leaf_m: (0.022, 0.17),
    slope_rad: 0.02,
    least_significance: 6.0,
    least_noise_m: 0.015,
    least_readings: 12.0,
    marker_beside_m: 0.3,
    marker_aside_m: 0.5,
    marker_behind_m: 1.3,
    marked_hallway_m: 1.8,
};
