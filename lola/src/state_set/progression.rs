//! The certainties of an instruction's nodes, and how percepts move them.

use super::chain::Chain;
use super::counter;
use super::inference::{Inference, Method};
use super::literal;
use super::matrix::Matrix;
use crate::feature::{Feature, HiddenWall, Percept, Side};
use crate::instruction::Instruction;
use serde::{Deserialize, Serialize};

/// Between two openings on a side; the distance before the first percept is not known.
pub const USUAL_DISTANCE_M: f64 = 4.0;

/// How many percepts are remembered as possibly the goal; the least certain is forgotten.
const MOST_CANDIDATES: usize = 12;

/// How far the robot has got with an instruction, given what it perceived: a plain value of bounded size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StateSet {
    /// Which one.
    pub instruction: Instruction,
    certainties: Certainties,
    /// Percepts with a smaller number were taken in.
    next_number: u64,
    /// How many of them concerned this instruction.
    counted: u64,
    /// Where the last of those ended, along the hallway's axis.
    last_m: Option<f64>,
}

/// They sum to 1.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Certainties {
    /// For each number of nodes before the goal (none, one, …), that the robot has passed as many.
    before: Vec<f64>,
    /// That the goal was perceived, and as which percept; in the order of percepts.
    candidates: Vec<Candidate>,
    /// That the goal was passed and nothing perceived of it.
    unseen: f64,
}

/// A percept that may be the goal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// Which one.
    pub percept: Percept,
    /// That it is the goal.
    pub certainty: f64,
}

/// Where the robot is in an instruction, as far as it knows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Standing {
    /// The goal is most likely still ahead.
    OnTheWay,
    /// This percept is most likely the goal; it may be an earlier one than the last.
    Arrived(Percept),
    /// The goal was most likely passed, and nothing perceived of it.
    PassedUnseen,
}

impl StateSet {
    /// At the start of an instruction; none for those that are followed without counting: to leave a room,
    /// and to go to the end of a hallway.
    #[must_use]
    pub fn start(instruction: Instruction) -> Option<Self> {
        let mut before = vec![0.0; Chain::of(instruction)?.length];
        before[0] = 1.0;
        let certainties = Certainties { before, candidates: Vec::new(), unseen: 0.0 };
        Some(Self { instruction, certainties, next_number: 0, counted: 0, last_m: None })
    }

    /// Takes in the percepts of a step, in the order of their numbers, and where something stands before the walls;
    /// what was taken in before, by its number, is left out. Cost: the number of percepts times that of nodes.
    pub fn progress(&mut self, inference: &Inference, percepts: &[Percept], hidden: &[HiddenWall]) {
        let Some(chain) = Chain::of(self.instruction) else { return };
        for percept in percepts.iter().filter(|percept| chain.concerns(percept)) {
            if percept.number >= self.next_number {
                self.next_number = percept.number + 1;
                self.counted += 1;
                self.take_in(&chain, inference, percept, hidden);
            }
        }
    }

    /// Where the robot is, asked when all percepts of a step were taken in: arrived when the goal's certainty
    /// is the greatest.
    ///
    /// # Deviation
    /// The certainty of one percept to be the goal is compared with that of all nodes before the goal
    /// together: the robot stops at an opening, not at a node. A threshold would have to know how far off the
    /// goal is, because certainty is lost with each opening that is passed.
    pub fn standing(&self) -> Standing {
        let on_the_way: f64 = self.certainties.before.iter().sum();
        let unseen = self.certainties.unseen;
        match self.best() {
            Some(best) if best.certainty >= on_the_way.max(unseen) => Standing::Arrived(best.percept),
            _ if unseen > on_the_way => Standing::PassedUnseen,
            _ => Standing::OnTheWay,
        }
    }

    /// The percept that is the goal, if the goal was most likely passed.
    pub fn arrived(&self) -> Option<Percept> {
        match self.standing() {
            Standing::Arrived(percept) => Some(percept),
            Standing::OnTheWay | Standing::PassedUnseen => None,
        }
    }

    /// The percept that is most likely the goal, whether that is likely or not.
    pub fn best(&self) -> Option<Candidate> {
        let better = |best: Candidate, other: Candidate| if other.certainty > best.certainty { other } else { best };
        self.candidates().iter().copied().reduce(better)
    }

    /// Every percept that may be the goal, in the order in which they came.
    pub fn candidates(&self) -> &[Candidate] {
        &self.certainties.candidates
    }

    /// Of each node: the start, those that are counted, the goal, and beyond it without having perceived it.
    /// They sum to 1.
    pub fn certainties(&self) -> Vec<f64> {
        let Certainties { before, unseen, .. } = &self.certainties;
        before.iter().copied().chain([self.certainties.of_goal(), *unseen]).collect()
    }

    /// How many percepts concerned this instruction.
    pub fn counted(&self) -> u64 {
        self.counted
    }

    /// A percept that no node explains changes nothing.
    fn take_in(&mut self, chain: &Chain, inference: &Inference, percept: &Percept, hidden: &[HiddenWall]) {
        let certainties = &self.certainties;
        let passed = Passed {
            way_m: self.last_m.map_or(USUAL_DISTANCE_M, |last_m| (percept.from_m - last_m).max(0.0)),
            hidden_m: hidden_between_m(hidden, percept.side, self.last_m.unwrap_or(0.0), percept.from_m),
        };
        self.last_m = Some(percept.to_m);
        let progressed = match inference.method {
            Method::StateSet => certainties.progressed(chain, &inference.matrix, percept, passed),
            Method::LiteralEquations => certainties.progressed_literally(chain, &inference.matrix, percept),
            Method::PlainCounter => certainties.counted(self.counted >= chain.length as u64, percept),
            Method::CounterWithClass => certainties.counted(counter::is_goal(chain, self.counted, percept), percept),
        };
        self.certainties = progressed.normalised().unwrap_or_else(|| certainties.clone());
    }
}

impl Certainties {
    /// Eqs. (1) to (3) for one percept, after the wall passed since the last.
    ///
    /// # Deviation
    /// The features in the first bracket of Eq. (3) are those of S_i: printed is S_j, by which a percept would
    /// be compared with what the robot has left behind. A state may stay (j = i), because a wall may be
    /// perceived as something, and because a foyer is not counted; with j < i alone every false alarm counts.
    /// In the product of Eq. (2) stands how many nodes can have been missed on the way since (Poisson): along
    /// ten metres more than along two, and more where a box stands before the wall. What comes after the goal is any
    /// opening, so that one sum stands for all nodes beyond it, and each percept that may have been the goal keeps a
    /// certainty of its own: the robot can go back to it.
    fn progressed(&self, chain: &Chain, matrix: &Matrix, percept: &Percept, passed: Passed) -> Self {
        let seen = percept.seen;
        let go = 1.0 - chain.uncounted_share;
        let stay = matrix.certainty(seen, Feature::Wall) + chain.uncounted_share * matrix.mean(seen, chain.uncounted);
        let counted = go * matrix.mean(seen, chain.counted);
        let places = passed.way_m / USUAL_DISTANCE_M;
        let hidden = chain.share(Feature::ClosedDoor) * passed.hidden_m / USUAL_DISTANCE_M;
        let missed = matrix.mean(Feature::Wall, chain.counted) * places + hidden;
        let missed_goal = matrix.missed(chain.goal) * places / missed.max(f64::MIN_POSITIVE);

        let reaching = reaching(&self.before, missed);
        let to_goal = reaching.goal * go * matrix.certainty(seen, chain.goal);
        let before = self.before.iter().zip(&reaching.nodes).map(|(&at, to)| at * stay + to * counted).collect();
        // After the goal, however many were missed since; a false alarm may come after it as well.
        let beyond = |certainty: f64| certainty * (stay + counted);
        let unseen = beyond(self.unseen) + reaching.beyond_goal * missed_goal * counted;
        let earlier = self
            .candidates
            .iter()
            .map(|&Candidate { percept, certainty }| Candidate { percept, certainty: beyond(certainty) });
        let arriving = Candidate { percept: *percept, certainty: to_goal };
        Self { before, candidates: earlier.chain([arriving]).collect(), unseen }.with_likeliest_candidates()
    }

    /// By [`literal::progressed`].
    fn progressed_literally(&self, chain: &Chain, matrix: &Matrix, percept: &Percept) -> Self {
        let mut before = literal::progressed(chain, matrix, &self.before, percept.seen);
        let certainty = before.pop().unwrap_or(0.0);
        Self { before, candidates: vec![Candidate { percept: *percept, certainty }], unseen: 0.0 }
    }

    /// What a counter knows: that this percept is the goal, or nothing new.
    fn counted(&self, is_goal: bool, percept: &Percept) -> Self {
        if !is_goal || !self.candidates.is_empty() {
            return self.clone();
        }
        let candidates = vec![Candidate { percept: *percept, certainty: 1.0 }];
        Self { before: vec![0.0; self.before.len()], candidates, unseen: 0.0 }
    }

    fn with_likeliest_candidates(mut self) -> Self {
        let certainty = |at: &usize| self.candidates[*at].certainty;
        if self.candidates.len() > MOST_CANDIDATES
            && let Some(least) = (0..self.candidates.len()).min_by(|a, b| certainty(a).total_cmp(&certainty(b)))
        {
            self.candidates.remove(least);
        }
        self
    }

    fn of_goal(&self) -> f64 {
        self.candidates.iter().map(|candidate| candidate.certainty).sum()
    }

    /// None if nothing is left.
    fn normalised(mut self) -> Option<Self> {
        let sum = self.before.iter().sum::<f64>() + self.of_goal() + self.unseen;
        self.before.iter_mut().for_each(|certainty| *certainty /= sum);
        self.candidates.iter_mut().for_each(|candidate| candidate.certainty /= sum);
        self.unseen /= sum;
        (sum > 0.0).then_some(self)
    }
}

/// The wall on a side between two percepts, and how much of it was hidden.
#[derive(Clone, Copy, Debug)]
struct Passed {
    way_m: f64,
    hidden_m: f64,
}

/// How much of a side is hidden between two places.
fn hidden_between_m(hidden: &[HiddenWall], side: Side, from_m: f64, to_m: f64) -> f64 {
    let on_side = hidden.iter().filter(|wall| wall.side == side);
    on_side.map(|wall| (wall.to_m.min(to_m) - wall.from_m.max(from_m)).max(0.0)).sum()
}

/// What comes from all earlier nodes when everything between was missed (Eq. 2).
struct Reaching {
    /// To each node before the goal.
    nodes: Vec<f64>,
    /// To the goal.
    goal: f64,
    /// To the nodes beyond the goal.
    beyond_goal: f64,
}

/// With a mean number of missed nodes. Cost: the square of the nodes.
fn reaching(before: &[f64], missed: f64) -> Reaching {
    let mut nodes = vec![0.0; before.len()];
    let mut reaching = Reaching { nodes: Vec::new(), goal: 0.0, beyond_goal: 0.0 };
    for (from, certainty) in before.iter().enumerate() {
        let mut of_missing = libm::exp(-missed);
        let mut left = 1.0;
        for (number, to) in (from + 1..=before.len()).enumerate() {
            match nodes.get_mut(to) {
                Some(node) => *node += certainty * of_missing,
                None => reaching.goal += certainty * of_missing,
            }
            left -= of_missing;
            of_missing *= missed / (number + 1) as f64;
        }
        reaching.beyond_goal += certainty * f64::max(left, 0.0);
    }
    reaching.nodes = nodes;
    reaching
}
