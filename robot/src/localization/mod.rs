//! Markov localization on a position probability grid.
