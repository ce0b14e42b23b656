//! What is seen of a run: gathered for the page from what happens, and from looks at the robot. It only looks: a run
//! that is seen writes the same bytes as one that is not.
//!
//! It writes the series of the crate `page` from the events of the trace, and from looks at the robot at fixed times of
//! the plan. So the series is the same for every viewer.
//!
//! Read in this order: `head`, `task_view`, `robot_view`, `feed`; then `live`, which serves it, and `steering`, by
//! which a page can hold and step a run.

mod feed;
mod head;
mod live;
mod measures;
mod robot_view;
mod steering;
mod task_view;

pub use feed::Feed;
pub use head::{head, plan_texts, title};
pub use live::{LiveArguments, SeenRun, stay};
pub use steering::{SteeredTurn, Steering};
