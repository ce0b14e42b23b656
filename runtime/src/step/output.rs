//! Lines of output, written.

use crate::state::block::block;
use crate::state::machine::Machine;
use crate::state::output::{Channel, MAX_WAITING_OUTPUT, MAX_WAITING_OUTPUT_BYTES, Output};

impl Machine {
    /// Writes a line of output; it waits to be taken.
    pub fn put_out(&mut self, channel: Channel, text: String) {
        if self.output.is_empty() {
            self.scratch.output_bytes = 0;
        }
        self.heap.allocated += size_of::<Output>() + block(text.len());
        self.scratch.output_bytes += text.len();
        self.output.push(Output { channel, text, time_us: self.now_us, sequence: self.trace.next_sequence });
        self.scratch.switch |= self.is_output_full();
    }

    /// Whether so much output waits to be taken that a task gives way for it.
    pub fn is_output_full(&self) -> bool {
        let bytes = if self.output.is_empty() { 0 } else { self.scratch.output_bytes };
        self.output.len() >= MAX_WAITING_OUTPUT || bytes >= MAX_WAITING_OUTPUT_BYTES
    }
}
