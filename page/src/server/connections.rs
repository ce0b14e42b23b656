//! Who is connected. There is limited room; when it is taken, somebody who has shown nothing gives way to the next.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv6Addr};
use tokio::task::AbortHandle;

/// Somebody who is connected.
#[derive(Debug)]
struct Connection {
    network: IpAddr,
    /// A request that may be answered has come from there.
    may_look: bool,
    task: AbortHandle,
}

/// All who are connected, by number; numbers are given in the order of coming.
#[derive(Debug)]
pub struct Connections {
    most: usize,
    next: u64,
    open: BTreeMap<u64, Connection>,
    /// With those that gave way and are not closed yet.
    taken: usize,
}

impl Connections {
    /// Room for `most` connections.
    pub fn new(most: usize) -> Self {
        Self { most, next: 0, open: BTreeMap::new(), taken: 0 }
    }

    /// The number that the next one gets.
    pub fn next(&self) -> u64 {
        self.next
    }

    /// Takes in the next one, who is served by a task; somebody gives way if there is no room.
    pub fn add(&mut self, from: IpAddr, task: AbortHandle) {
        if self.open.len() >= self.most
            && let Some(gone) = self.gives_way().and_then(|number| self.open.remove(&number))
        {
            gone.task.abort();
        }
        self.open.insert(self.next, Connection { network: network(from), may_look: false, task });
        self.next += 1;
        self.taken += 1;
    }

    /// Whether somebody who gave way is not gone yet.
    pub fn is_crowded(&self) -> bool {
        self.taken > self.most
    }

    /// A request that may be answered has come.
    pub fn may_look(&mut self, number: u64) {
        if let Some(connection) = self.open.get_mut(&number) {
            connection.may_look = true;
        }
    }

    /// It is closed.
    pub fn closed(&mut self, number: u64) {
        self.open.remove(&number);
        self.taken -= 1;
    }

    /// Those who have shown that they may look stay for as long as there are others; of these, or else of all, the oldest
    /// from the network that has the most.
    fn gives_way(&self) -> Option<u64> {
        let all_may_look = self.open.values().all(|connection| connection.may_look);
        let others = || self.open.iter().filter(|(_, connection)| connection.may_look == all_may_look);
        let mut of_network = BTreeMap::<IpAddr, usize>::new();
        others().for_each(|(_, connection)| *of_network.entry(connection.network).or_default() += 1);
        others()
            .max_by_key(|(number, connection)| (of_network[&connection.network], Reverse(**number)))
            .map(|(n, _)| *n)
    }
}

/// The addresses that one machine can have as it likes are one network.
fn network(from: IpAddr) -> IpAddr {
    match from.to_canonical() {
        IpAddr::V4(address) => IpAddr::V4(address),
        IpAddr::V6(address) => IpAddr::V6(Ipv6Addr::from_bits(address.to_bits() >> 64 << 64)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::future::pending;
    use tokio::runtime::Builder;

    /// All that come, each from an address, where there is room for `most`; and who is there then, by number.
    fn left(most: usize, from: impl IntoIterator<Item = &'static str>, looking: &[u64]) -> Vec<u64> {
        let runtime = Builder::new_current_thread().build().expect("it can be made");
        let mut connections = Connections::new(most);
        for address in from {
            let task = runtime.spawn(pending::<()>());
            let number = connections.next();
            connections.add(address.parse().expect("an address"), task.abort_handle());
            if looking.contains(&number) {
                connections.may_look(number);
            }
        }
        connections.open.into_keys().collect()
    }

    #[test]
    fn the_oldest_that_has_shown_nothing_gives_way() {
        assert_eq!(left(3, ["::1"; 5], &[]), [2, 3, 4]);
        assert_eq!(left(3, ["::1"; 5], &[0]), [0, 3, 4]);
        assert_eq!(left(3, ["::1"; 5], &[0, 1, 2, 3, 4]), [2, 3, 4]);
    }

    #[test]
    fn whoever_comes_often_gives_way_to_whoever_comes_once() {
        let often = ["10.0.0.1"; 50];
        assert_eq!(left(3, ["10.0.0.2"].into_iter().chain(often), &[]), [0, 49, 50]);
        // The addresses of one network count as one, and those of version 4 by themselves.
        assert_eq!(left(3, ["2001:db8::1", "2001:db8:0:1::1", "2001:db8::2", "2001:db8::3"], &[]), [1, 2, 3]);
        assert_eq!(left(3, ["::ffff:10.0.0.1", "10.0.0.2", "::ffff:10.0.0.2", "10.0.0.3"], &[]), [0, 2, 3]);
    }
}
