//! Some cases of one kind that lie together, with what is compared of them in columns.

use super::columns::{Bounds, CHUNK, COLUMNS, Least, Rings, Row};
use super::number::CaseNumber;
use super::retrieval::Best;
use crate::case::{Case, Kind};
use crate::similarity::Similarity;
use crate::situation::Situation;
use std::sync::Arc;

/// At most [`CHUNK`] cases of one kind, by number.
#[derive(Clone, Debug)]
pub(super) struct Chunk {
    numbers: Vec<CaseNumber>,
    cases: Vec<Arc<Case>>,
    /// `columns[column][case]`; beyond the last case whatever.
    columns: Box<[[f32; CHUNK]; COLUMNS]>,
    rings: Vec<Rings>,
}

impl Default for Chunk {
    fn default() -> Self {
        Self { numbers: Vec::new(), cases: Vec::new(), columns: Box::new([[0.0; CHUNK]; COLUMNS]), rings: Vec::new() }
    }
}

impl Chunk {
    pub(super) fn len(&self) -> usize {
        self.cases.len()
    }

    pub(super) fn is_full(&self) -> bool {
        self.len() == CHUNK
    }

    pub(super) fn first(&self) -> Option<CaseNumber> {
        self.numbers.first().copied()
    }

    pub(super) fn last(&self) -> Option<CaseNumber> {
        self.numbers.last().copied()
    }

    pub(super) fn numbers(&self) -> &[CaseNumber] {
        &self.numbers
    }

    pub(super) fn slot_of(&self, number: CaseNumber) -> Option<usize> {
        self.numbers.binary_search(&number).ok()
    }

    pub(super) fn case(&self, slot: usize) -> &Arc<Case> {
        &self.cases[slot]
    }

    pub(super) fn case_mut(&mut self, slot: usize) -> &mut Arc<Case> {
        &mut self.cases[slot]
    }

    pub(super) fn cases(&self) -> impl Iterator<Item = (CaseNumber, &Arc<Case>)> {
        self.numbers.iter().copied().zip(&self.cases)
    }

    /// Adds a case with a greater number than the last; ranges are taken for `most_m` if they are greater.
    pub(super) fn push(&mut self, number: CaseNumber, case: Arc<Case>, most_m: f64) {
        let slot = self.len();
        let row = Row::of(&case.index, most_m);
        for (column, value) in self.columns.iter_mut().zip(row.columns) {
            column[slot] = value;
        }
        self.rings.push(row.rings);
        self.numbers.push(number);
        self.cases.push(case);
    }

    pub(super) fn remove(&mut self, slot: usize) {
        let len = self.len();
        self.numbers.remove(slot);
        self.cases.remove(slot);
        self.rings.remove(slot);
        self.columns.iter_mut().for_each(|column| column.copy_within(slot + 1..len, slot));
    }

    /// Whether another one's cases have room here.
    pub(super) fn fits(&self, other: &Chunk) -> bool {
        self.len() + other.len() <= CHUNK
    }

    /// Adds the cases of another, all of which have greater numbers.
    pub(super) fn append(&mut self, other: &Chunk) {
        let (len, more) = (self.len(), other.len());
        self.numbers.extend_from_slice(&other.numbers);
        self.cases.extend_from_slice(&other.cases);
        self.rings.extend_from_slice(&other.rings);
        for (column, of_other) in self.columns.iter_mut().zip(other.columns.iter()) {
            column[len..len + more].copy_from_slice(&of_other[..more]);
        }
    }

    /// The least distance each case can have by its columns.
    pub(super) fn least(&self, bounds: &Bounds) -> Least {
        bounds.of(&self.columns)
    }

    /// Offers each case that may be among the best, and no farther off than `most`, with its distance.
    pub(super) fn search(&self, bounds: &Bounds, least: &Least, query: &Query, most: f64, best: &mut Best) {
        let mut limit = best.worst().min(most) + bounds.margin;
        for (slot, &least) in least[..self.len()].iter().enumerate() {
            if f64::from(least) > limit || f64::from(least + bounds.of_rings(&self.rings[slot])) > limit {
                continue;
            }
            best.offer(query.distance(&self.cases[slot]), self.numbers[slot]);
            limit = best.worst().min(most) + bounds.margin;
        }
    }
}

/// What is asked for, and how cases of a kind are compared with it.
pub(super) struct Query<'q> {
    pub(super) similarity: &'q Similarity,
    pub(super) asked: &'q Situation,
    pub(super) kind: Kind,
}

impl Query<'_> {
    pub(super) fn distance(&self, case: &Case) -> f64 {
        self.similarity.distance(self.asked, self.kind, &case.index)
    }
}
