//! Measured in 400 places; `WRITE_MARKERS=1 cargo test -p rpl-lola --test markers` writes this.

/// For each colour its bins, with their shares in parts of 10000.
pub(super) const MEASURED: [&[(usize, u32)]; 4] = [
    // pink
    &[(130, 5402), (131, 111), (136, 4321), (137, 135)],
    // orange
    &[(10, 25), (11, 9954)],
    // green
    &[(40, 362), (45, 769), (46, 8841), (51, 24)],
    // blue
    &[(83, 152), (88, 60), (89, 9787)],
];
