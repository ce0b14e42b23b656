//! What debuggers say: the messages of the Debug Adapter Protocol that an adapter for plans takes and gives. The adapter
//! itself stands where runs are stepped.

pub mod messages;
