//! All tasks, and the lines they stand in, which go through their records.

use crate::state::line::Line;
use crate::state::registers::{RegisterStore, Registers};
use crate::state::slab::{NONE, Slab};
use crate::state::task::Task;
use crate::state::value::{TaskRef, Value};
use serde::{Deserialize, Serialize};

/// All tasks.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Tasks {
    slots: Slab<Task>,
    generations: Vec<u32>,
    /// Registers of the tasks that do not run.
    pub registers: RegisterStore,
}

impl Tasks {
    /// Adds a task.
    pub fn insert(&mut self, task: Task) -> u32 {
        let index = self.slots.insert(task);
        if self.generations.len() <= index as usize {
            self.generations.push(0);
        }
        index
    }

    /// Frees a dead task's slot.
    pub fn free(&mut self, index: u32) {
        if let Some(task) = self.slots.get(index) {
            self.registers.free(task.registers);
            self.slots.clear(index);
            self.generations[index as usize] += 1;
        }
    }

    /// A name for the task that outlives it.
    pub fn reference(&self, index: u32) -> TaskRef {
        TaskRef { index, generation: self.generations[index as usize] }
    }

    /// The task a name means, unless its record is gone.
    pub fn find(&self, task: TaskRef) -> Option<u32> {
        (self.generations.get(task.index as usize) == Some(&task.generation) && self.slots.get(task.index).is_some())
            .then_some(task.index)
    }

    /// Whether it is the name of a task that there was, is or can be.
    pub(crate) fn may_be_named(&self, task: TaskRef) -> bool {
        (task.index as usize) < self.generations.len() && task.generation < u32::MAX / 2
    }

    /// The living task a name means.
    pub fn find_alive(&self, task: TaskRef) -> Option<u32> {
        self.find(task).filter(|&index| !self.slots[index].state().is_dead())
    }

    /// The values of a task's registers, while it does not run.
    pub fn registers_of(&self, index: u32) -> &[Value] {
        self.registers.get(self.slots[index].registers)
    }

    /// Keeps values as a task's registers while it does not run.
    pub fn set_registers(&mut self, index: u32, values: &[Value]) {
        let task = &mut self.slots[index];
        task.registers = self.registers.set(task.registers, values);
    }

    /// All tasks, by slot.
    pub fn iter(&self) -> impl Iterator<Item = (u32, &Task)> {
        self.slots.iter()
    }

    /// Whether every slot has a generation, and the free ones are those without a task.
    pub(crate) fn is_whole(&self) -> bool {
        self.generations.len() >= self.slots.slots()
            && self.generations.iter().all(|&generation| generation < u32::MAX / 2)
            && self.slots.is_whole()
            && self.registers.is_whole(self.slots.iter().map(|(_, task)| task.registers))
    }

    /// How many slots there are.
    pub fn slots(&self) -> usize {
        self.slots.slots()
    }

    /// Bytes of all records and registers.
    pub fn bytes(&self) -> usize {
        self.slots.slots() * size_of::<Option<Task>>()
            + self.generations.len() * size_of::<u32>()
            + self.registers.bytes()
    }

    /// Gives back what no task uses.
    pub(crate) fn shrink(&mut self, slack: usize) {
        self.slots.shrink(slack);
        let used: usize = self.slots.iter().map(|(_, task)| task.registers.values()).sum();
        if !self.registers.is_sparse(used) {
            return;
        }
        let sparse = std::mem::take(&mut self.registers);
        for task in self.slots.iter_mut() {
            task.registers = self.registers.set(Registers::default(), sparse.get(task.registers));
        }
    }

    /// The living task in a slot.
    pub fn get_alive(&self, index: u32) -> Option<&Task> {
        self.get(index).filter(|task| !task.state().is_dead())
    }

    /// The task in a slot, if it is used.
    pub fn get(&self, index: u32) -> Option<&Task> {
        self.slots.get(index)
    }

    /// The task in a slot, if it is used.
    pub fn get_mut(&mut self, index: u32) -> Option<&mut Task> {
        self.slots.get_mut(index)
    }
}

impl std::ops::Index<u32> for Tasks {
    type Output = Task;

    #[inline]
    fn index(&self, index: u32) -> &Task {
        &self.slots[index]
    }
}

impl std::ops::IndexMut<u32> for Tasks {
    #[inline]
    fn index_mut(&mut self, index: u32) -> &mut Task {
        &mut self.slots[index]
    }
}

impl Line {
    /// Adds at the end.
    #[inline]
    pub fn push_back(&mut self, tasks: &mut Tasks, task: u32) {
        self.append(tasks, Line { first: task, last: task });
    }

    /// Adds tasks at the end that stand behind one another, and perhaps between others, in a line that is given up. Cost:
    /// that of one of them.
    #[inline]
    pub fn append(&mut self, tasks: &mut Tasks, stretch: Line) {
        tasks[stretch.first].previous = self.last;
        tasks[stretch.last].next = NONE;
        if self.last == NONE {
            self.first = stretch.first;
        } else {
            tasks[self.last].next = stretch.first;
        }
        self.last = stretch.last;
    }

    /// Adds at the front.
    pub fn push_front(&mut self, tasks: &mut Tasks, task: u32) {
        tasks[task].next = self.first;
        tasks[task].previous = NONE;
        if self.first == NONE {
            self.last = task;
        } else {
            tasks[self.first].previous = task;
        }
        self.first = task;
    }

    /// Adds behind a task in it that is not the last, or at the front behind [`NONE`].
    pub fn insert_behind(&mut self, tasks: &mut Tasks, task: u32, before: u32) {
        if before == NONE {
            return self.push_front(tasks, task);
        }
        let after = std::mem::replace(&mut tasks[before].next, task);
        (tasks[task].previous, tasks[task].next) = (before, after);
        tasks[after].previous = task;
    }

    /// Takes the first task out.
    #[inline]
    pub fn pop_front(&mut self, tasks: &mut Tasks) -> Option<u32> {
        let task = self.first;
        if task == NONE {
            return None;
        }
        self.first = std::mem::replace(&mut tasks[task].next, NONE);
        if self.first == NONE {
            self.last = NONE;
        } else {
            tasks[self.first].previous = NONE;
        }
        Some(task)
    }

    /// The tasks in line, the first one first.
    pub fn tasks(&self, tasks: &Tasks) -> Vec<u32> {
        let mut line = Vec::new();
        let mut at = self.first;
        while at != NONE {
            line.push(at);
            at = tasks[at].next;
        }
        line
    }

    /// Takes a task out, wherever it stands.
    pub fn remove(&mut self, tasks: &mut Tasks, task: u32) {
        let record = &mut tasks[task];
        let (previous, next) = (record.previous, record.next);
        (record.previous, record.next) = (NONE, NONE);
        if previous == NONE {
            self.first = next;
        } else {
            tasks[previous].next = next;
        }
        if next == NONE {
            self.last = previous;
        } else {
            tasks[next].previous = previous;
        }
    }
}
