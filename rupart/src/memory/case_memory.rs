//! Cases by number, and the most similar one to a situation.

use super::chunk::{Chunk, Query};
use super::columns::{Bounds, Least};
use super::number::CaseNumber;
use super::retrieval::{Best, Retrieval};
use crate::case::{Case, Content, Kind};
use crate::route::Route;
use crate::similarity::Similarity;
use crate::situation::Situation;

use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Runners-up that a retrieval tells of.
pub const RUNNERS_UP: usize = 3;

/// Cases that are looked at first: with more of them the limit is nearer for the others.
const PROMISING: usize = 32;

/// Cases of all kinds.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(into = "Retained", from = "Retained")]
pub struct CaseMemory {
    pub(super) similarity: Arc<Similarity>,
    /// The number of the next case.
    next: u32,
    /// For each kind, in the order of [`Kind::ALL`], its cases by number: none of the chunks is empty.
    pub(super) tables: [Vec<Arc<Chunk>>; Kind::ALL.len()],
}

impl PartialEq for CaseMemory {
    /// Whether both hold the same cases under the same numbers and compare them alike, however they lie.
    fn eq(&self, other: &Self) -> bool {
        self.next == other.next && self.similarity == other.similarity && self.cases().eq(other.cases())
    }
}

/// A memory as it is written down.
#[derive(Clone, Serialize, Deserialize)]
struct Retained {
    similarity: Arc<Similarity>,
    next: u32,
    cases: Vec<(CaseNumber, Arc<Case>)>,
}

impl From<CaseMemory> for Retained {
    fn from(memory: CaseMemory) -> Self {
        let cases = memory.cases().map(|(number, case)| (number, case.clone())).collect();
        Self { similarity: memory.similarity, next: memory.next, cases }
    }
}

impl From<Retained> for CaseMemory {
    fn from(retained: Retained) -> Self {
        Self::with_cases((*retained.similarity).clone(), CaseNumber(retained.next), retained.cases)
    }
}

impl CaseMemory {
    /// A memory without cases.
    pub fn new(similarity: Similarity) -> Self {
        Self { similarity: Arc::new(similarity), next: 0, tables: Default::default() }
    }

    /// A memory of cases that have numbers already, each its own; the next is at least `next`.
    pub(crate) fn with_cases(
        similarity: Similarity,
        next: CaseNumber,
        cases: impl IntoIterator<Item = (CaseNumber, Arc<Case>)>,
    ) -> Self {
        let mut memory = Self { next: next.0, ..Self::new(similarity) };
        for (number, case) in cases {
            memory.put(number, case);
            memory.next = memory.next.max(number.0.saturating_add(1));
        }
        memory
    }

    /// The number that the next case will have.
    pub fn next_number(&self) -> CaseNumber {
        CaseNumber(self.next)
    }

    /// How cases are compared.
    pub fn similarity(&self) -> &Similarity {
        &self.similarity
    }

    /// How many cases there are.
    pub fn len(&self) -> usize {
        self.tables.iter().flatten().map(|chunk| chunk.len()).sum()
    }

    /// How many cases of a kind there are.
    pub fn count(&self, kind: Kind) -> usize {
        self.tables[kind as usize].iter().map(|chunk| chunk.len()).sum()
    }

    /// Whether there is no case.
    pub fn is_empty(&self) -> bool {
        self.tables.iter().all(Vec::is_empty)
    }

    /// Keeps a case under a new number. O(1), and the copy of a chunk if another memory shares it.
    ///
    /// # Panics
    /// The index has features that no case can be compared by ([`Situation::unusable_features`]), or four
    /// thousand million cases were retained.
    pub fn retain(&mut self, case: Case) -> CaseNumber {
        let unusable = case.index.unusable_features();
        assert!(unusable.is_empty(), "an index must be comparable, and {unusable:?} of this one is not");
        let number = CaseNumber(self.next);
        self.next = self.next.checked_add(1).expect("no run makes so many cases");
        self.put(number, Arc::new(case));
        number
    }

    /// Adds a case after those with smaller numbers.
    fn put(&mut self, number: CaseNumber, case: Arc<Case>) {
        let most_m = self.similarity.scales.sonar_m;
        let table = &mut self.tables[case.content.kind() as usize];
        match table.last_mut().filter(|chunk| !chunk.is_full() && chunk.last() < Some(number)) {
            Some(chunk) => Arc::make_mut(chunk).push(number, case, most_m),
            None => {
                let mut chunk = Chunk::default();
                chunk.push(number, case, most_m);
                let after = table.partition_point(|chunk| chunk.first() < Some(number));
                table.insert(after, Arc::new(chunk));
            }
        }
    }

    /// The case of a number, if it was not forgotten. O(log n).
    pub fn get(&self, number: CaseNumber) -> Option<&Arc<Case>> {
        let (kind, chunk, slot) = self.find(number)?;
        Some(self.tables[kind][chunk].case(slot))
    }

    /// Changes a case, which must keep its kind and its index. O(log n), and the copy of a chunk if another
    /// memory shares it.
    ///
    /// # Panics
    /// The change gives it another kind or index.
    pub fn change(&mut self, number: CaseNumber, change: impl FnOnce(&mut Case)) {
        let Some((kind, chunk, slot)) = self.find(number) else { return };
        let case = Arc::make_mut(&mut self.tables[kind][chunk]).case_mut(slot);
        let before = case.clone();
        change(Arc::make_mut(case));
        let is_kept = case.content.kind() == before.content.kind() && case.index == before.index;
        assert!(is_kept, "a case keeps its kind and its index: what is compared is laid out beside it");
    }

    /// Drops a case; says whether it was there. O(log n), and the copy of a chunk.
    pub fn forget(&mut self, number: CaseNumber) -> bool {
        let Some((kind, chunk, slot)) = self.find(number) else { return false };
        let table = &mut self.tables[kind];
        let forgetting = Arc::make_mut(&mut table[chunk]);
        forgetting.remove(slot);
        if forgetting.len() == 0 {
            table.remove(chunk);
        } else if let Some(before) = chunk.checked_sub(1)
            && table[before].fits(&table[chunk])
        {
            // Else a memory that forgets as fast as it learns would end as chunks of one case.
            let joined = table.remove(chunk);
            Arc::make_mut(&mut table[before]).append(&joined);
        }
        true
    }

    /// The same memory but for some cases. Cost: for each of them as for forgetting it.
    #[must_use]
    pub fn without(&self, numbers: &[CaseNumber]) -> Self {
        let mut rest = self.clone();
        for &number in numbers {
            rest.forget(number);
        }
        rest
    }

    /// Where a case lies: kind, chunk, slot.
    fn find(&self, number: CaseNumber) -> Option<(usize, usize, usize)> {
        self.tables.iter().enumerate().find_map(|(kind, table)| {
            let chunk = table.partition_point(|chunk| chunk.last() < Some(number));
            Some((kind, chunk, table.get(chunk)?.slot_of(number)?))
        })
    }

    /// All cases, by kind and then by number.
    pub fn cases(&self) -> impl Iterator<Item = (CaseNumber, &Arc<Case>)> {
        self.tables.iter().flatten().flat_map(|chunk| chunk.cases())
    }

    /// The cases of a kind, by number.
    pub fn cases_of(&self, kind: Kind) -> impl Iterator<Item = (CaseNumber, &Arc<Case>)> {
        self.tables[kind as usize].iter().flat_map(|chunk| chunk.cases())
    }

    /// The routes, by number.
    pub fn routes(&self) -> impl Iterator<Item = (CaseNumber, &Route)> {
        self.cases_of(Kind::Route).filter_map(|(number, case)| match &case.content {
            Content::Route(route) => Some((number, route)),
            Content::Behaviour(_) | Content::Goal(_) | Content::MetaPlan(_) => None,
        })
    }

    /// The most similar case to a situation, of whatever kind, and those that come next; of two at the same
    /// distance the one with the lower number. None if there is no case. Cost: a pass over the columns of
    /// all cases, and the sonars and distances of those that may be among the first by them.
    ///
    /// # Panics
    /// The situation has features that no case can be compared by ([`Situation::unusable_features`]).
    pub fn retrieve(&self, asked: &Situation) -> Option<Retrieval> {
        let unusable = asked.unusable_features();
        assert!(unusable.is_empty(), "a situation must be comparable, and {unusable:?} of this one is not");
        let mut best = Best::new(1 + RUNNERS_UP);
        // The cases that promise most, looked at first, rule out most of the others.
        let mut promising = Best::new(PROMISING);
        let searches: Vec<(Query, Bounds, Vec<Least>)> = Kind::ALL
            .into_iter()
            .zip(&self.tables)
            .map(|(kind, table)| {
                let bounds = Bounds::new(&self.similarity, asked, kind);
                let least = table.iter().map(|chunk| chunk.least(&bounds)).collect();
                (Query { similarity: &self.similarity, asked, kind }, bounds, least)
            })
            .collect();
        for ((.., least), table) in searches.iter().zip(&self.tables) {
            for (least, chunk) in least.iter().zip(table) {
                let mut worst = promising.worst();
                for (&least, number) in least.iter().zip(chunk.numbers()) {
                    if f64::from(least) < worst {
                        promising.offer(f64::from(least), *number);
                        worst = promising.worst();
                    }
                }
            }
        }
        let mut known = Best::new(1 + RUNNERS_UP);
        for number in promising.numbers() {
            if let Some(case) = self.get(number) {
                known.offer(self.similarity.distance(asked, case.content.kind(), &case.index), number);
            }
        }
        let most = known.worst();
        for ((query, bounds, least), table) in searches.iter().zip(&self.tables) {
            for (least, chunk) in least.iter().zip(table) {
                chunk.search(bounds, least, query, most, &mut best);
            }
        }
        best.retrieval(|number| {
            let case = self.get(number)?;
            let kind = case.content.kind();
            Some((kind, self.similarity.contributions(asked, kind, &case.index)))
        })
    }
}
