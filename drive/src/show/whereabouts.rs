//! What a run is at, in one line.

use rpl_mission::robot::Robot;
use rpl_mission::sight::Sight;
use rpl_runtime::robot::Outside;
use rpl_runtime::state::activation::Phase;
use rpl_runtime::state::machine::Machine;
use rpl_runtime::state::slab::NONE;
use rpl_runtime::state::task::State;

/// Time, what the robot does, how sure it is of its place, and where in the plan it is, in `room` columns if possible.
pub fn whereabouts(machine: &Machine, robot: &Robot, sight: Option<Sight>, room: usize) -> String {
    let active = machine.activations.iter().zip(&robot.tables().behaviours);
    // Position tracking never rests; what drives says more.
    let mut busy = active.filter(|(activation, spec)| activation.phase == Phase::Active && spec.valve.is_some());
    let (doing, task) = match busy.next_back() {
        Some((activation, spec)) => {
            (Some(&*spec.name), activation.task.and_then(|task| machine.tasks.find_alive(task)))
        }
        None => (None, None),
    };
    let mut parts = vec![format!("{:.1} s", machine.now_s())];
    parts.extend(doing.map(str::to_string));
    parts.extend(sight.map(|sight| format!("certainty {:.2}", sight.certainty)));
    let taken: usize = parts.iter().map(|part| part.chars().count() + GAP.len()).sum();
    let path = task.or_else(|| waiting_leaf(machine)).map(|task| machine.path(task));
    parts.extend(path.map(|path| path_end(&path, room.saturating_sub(taken))));
    parts.join(GAP)
}

/// What stands between the parts of the status line.
const GAP: &str = "  ";

/// The end of a path, which says most about where the plan is, in `longest` characters if possible.
pub fn path_end(path: &str, longest: usize) -> String {
    const LEFT_OUT: &str = "…/";
    if path.chars().count() <= longest {
        return path.to_string();
    }
    let tails = path.match_indices('/').map(|(slash, _)| &path[slash + 1..]);
    let fits = |tail: &&str| tail.chars().count() + LEFT_OUT.chars().count() <= longest;
    let last = path.rsplit('/').next().unwrap_or(path);
    format!("{LEFT_OUT}{}", tails.into_iter().find(fits).unwrap_or(last))
}

fn waiting_leaf(machine: &Machine) -> Option<u32> {
    let mut leaves =
        machine.tasks.iter().filter(|(_, task)| task.state() == State::Blocked && task.first_child == NONE);
    leaves.next().map(|(index, _)| index)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_path_keeps_its_end() {
        assert_eq!(path_end("main/tidy", 46), "main/tidy");
        let path = "main/with-policy[1]/bring/go-to/with-policy[1]/navigation";
        assert_eq!(path_end(path, 46), "…/bring/go-to/with-policy[1]/navigation");
    }
}
