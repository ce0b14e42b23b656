//! Values, heap, tasks, fluents, valves, failures, timers, scheduler, trace.
