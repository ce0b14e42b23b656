//! Users and groups of the system, as its files name them.

use std::fs::File;
use std::io::Read;

/// More than this is not read of either file.
const MOST_BYTES: u64 = 4 << 20;

/// What the files say of the system's users and groups. Accounts that are kept elsewhere (LDAP) have no line there.
pub struct Accounts {
    /// Lines `name:password:uid:gid:…`.
    users: String,
    /// Lines `name:password:gid:member,member`.
    groups: String,
}

impl Accounts {
    /// Those of this system.
    pub fn of_system() -> Self {
        let text = |path: &str| {
            let mut text = String::new();
            // Without the file no group is known to be private, and users have numbers.
            File::open(path).and_then(|file| file.take(MOST_BYTES).read_to_string(&mut text)).ok();
            text
        };
        Self { users: text("/etc/passwd"), groups: text("/etc/group") }
    }

    /// A user's name, or else its number.
    pub fn name_of(&self, uid: u32) -> String {
        let known = entries(&self.users).find(|user| numbered(user, 2, uid));
        known.map_or_else(|| format!("user {uid}"), |user| format!("`{}`", user[0]))
    }

    /// A group's name, or else its number.
    pub fn group_name(&self, gid: u32) -> String {
        let known = entries(&self.groups).find(|group| numbered(group, 2, gid));
        known.map_or_else(|| gid.to_string(), |group| format!("`{}`", group[0]))
    }

    /// Whether a group is the user's own: many systems give each user one of the same name or number, with nobody else
    /// in it, and let it write what the user makes.
    pub fn is_private(&self, gid: u32, uid: u32) -> bool {
        let name = entries(&self.users).find(|user| numbered(user, 2, uid)).map(|user| user[0]);
        let others_begin_in_it = entries(&self.users).any(|user| numbered(&user, 3, gid) && !numbered(&user, 2, uid));
        let group = entries(&self.groups).find(|group| numbered(group, 2, gid));
        let has_same_name = name.is_some() && group.as_ref().map(|group| group[0]) == name;
        let members = group.as_ref().and_then(|group| group.get(3)).copied().unwrap_or_default();
        let has_others = members.split(',').map(str::trim).any(|member| !member.is_empty() && Some(member) != name);
        (has_same_name || gid == uid) && !others_begin_in_it && !has_others
    }
}

/// The fields of each line.
fn entries(text: &str) -> impl Iterator<Item = Vec<&str>> {
    text.lines().map(|line| line.split(':').collect())
}

/// Whether a field is this number.
fn numbered(fields: &[&str], at: usize, number: u32) -> bool {
    fields.get(at).and_then(|field| field.parse().ok()) == Some(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_private_group_has_its_users_name_and_nobody_else() {
        let accounts = Accounts {
            users: "root:x:0:0::/root:/bin/sh\nada:x:1000:1001::/:\nbob:x:1001:100::/:\neve:x:1002:100::/:\n"
                .to_string(),
            groups: "root:x:0:\nusers:x:100:\nada:x:1001:ada\nstaff:x:50:ada,eve\nbob:x:1003:eve\n".to_string(),
        };
        assert!(accounts.is_private(1001, 1000), "Debian's usual one");
        assert!(accounts.is_private(0, 0), "root's");
        assert!(!accounts.is_private(100, 1001), "others begin in it");
        assert!(!accounts.is_private(50, 1000), "it has another name");
        assert!(!accounts.is_private(1003, 1001), "it has a member");
        assert!(!accounts.is_private(1001, 1001), "it is that of another user");
        // Accounts from elsewhere, and users of containers that no file knows.
        assert!(accounts.is_private(4711, 4711) && !accounts.is_private(0, 4711) && !accounts.is_private(4712, 4711));
        assert_eq!((accounts.name_of(1002), accounts.name_of(7)), ("`eve`".to_string(), "user 7".to_string()));
        assert_eq!((accounts.group_name(50), accounts.group_name(7)), ("`staff`".to_string(), "7".to_string()));
    }
}
