//! Lines to other processes: pipes, sockets, and the threads and clocks that they take.
