//! Which topics of a recording are taken: by the types of their messages, and where several fit by their usual names or
//! by what the user says.

use anyhow::{Result, bail};
use rpl_lang::visible::shortened;

/// Usual names of scans, the most usual first.
const SCAN: [&str; 3] = ["/scan", "/base_scan", "/scan_filtered"];

/// Of odometry.
const ODOM: [&str; 7] = [
    "/odom",
    "/odometry",
    "/wheel_odom",
    "/wheel/odometry",
    "/odom/wheel",
    "/diff_drive_controller/odom",
    "/odometry/filtered",
];

/// Of corrected poses; those that know come before those that estimate.
const TRUTH: [&str; 10] = [
    "/ground_truth",
    "/ground_truth/pose",
    "/ground_truth_pose",
    "/ground_truth/odom",
    "/ground_truth/state",
    "/base_pose_ground_truth",
    "/odom/ground_truth",
    "/amcl_pose",
    "/pose",
    "/slam_toolbox/pose",
];

/// Poses that somebody wants or guesses, and no robot has been at.
const NO_TRUTH: [&str; 5] =
    ["/initialpose", "/goal_pose", "/move_base_simple/goal", "/clicked_pose", "/move_base/current_goal"];

/// What a topic has messages of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// `sensor_msgs/msg/LaserScan`.
    LaserScan,
    /// `nav_msgs/msg/Odometry`.
    Odometry,
    /// `geometry_msgs/msg/PoseStamped`.
    PoseStamped,
    /// `geometry_msgs/msg/PoseWithCovarianceStamped`.
    PoseWithCovarianceStamped,
}

/// A topic and what it has.
pub type Topic = (String, Kind);

/// The topics that are taken.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topics {
    /// Of scans.
    pub scan: Topic,
    /// Of odometry.
    pub odom: Topic,
    /// Of corrected poses.
    pub truth: Topic,
}

/// What a user has said of the topics.
#[derive(Clone, Copy, Debug, Default)]
pub struct Wanted<'w> {
    /// Of scans.
    pub scan: Option<&'w str>,
    /// Of odometry.
    pub odom: Option<&'w str>,
    /// Of corrected poses.
    pub truth: Option<&'w str>,
}

impl Kind {
    /// By the name of the type.
    pub fn of(name: &str) -> Option<Self> {
        match name {
            "sensor_msgs/msg/LaserScan" => Some(Self::LaserScan),
            "nav_msgs/msg/Odometry" => Some(Self::Odometry),
            "geometry_msgs/msg/PoseStamped" => Some(Self::PoseStamped),
            "geometry_msgs/msg/PoseWithCovarianceStamped" => Some(Self::PoseWithCovarianceStamped),
            _ => None,
        }
    }

    /// The name of the type, without its package.
    pub fn name(self) -> &'static str {
        match self {
            Self::LaserScan => "LaserScan",
            Self::Odometry => "Odometry",
            Self::PoseStamped => "PoseStamped",
            Self::PoseWithCovarianceStamped => "PoseWithCovarianceStamped",
        }
    }
}

/// One of the three things that are needed.
struct Role<'r> {
    option: &'static str,
    what: &'static str,
    kinds: &'static [Kind],
    usual: &'static [&'static str],
    wanted: Option<&'r str>,
}

impl Topics {
    /// Chooses among the topics of a recording, which are in order.
    ///
    /// # Errors
    /// For one of the three there is no topic, or there are several and none has a usual name; they are listed.
    pub fn choose(all: &[Topic], wanted: Wanted<'_>) -> Result<Self> {
        let scan =
            Role { option: "--scan", what: "scans", kinds: &[Kind::LaserScan], usual: &SCAN, wanted: wanted.scan };
        let truth = Role {
            option: "--truth",
            what: "corrected poses",
            kinds: &[Kind::PoseStamped, Kind::PoseWithCovarianceStamped, Kind::Odometry],
            usual: &TRUTH,
            wanted: wanted.truth,
        };
        let odom =
            Role { option: "--odom", what: "odometry", kinds: &[Kind::Odometry], usual: &ODOM, wanted: wanted.odom };
        let scan = scan.choose(all, |_| true)?;
        // What is odometry by its type is a reference only by its name.
        let is_truth = |(name, kind): &Topic| *kind != Kind::Odometry && !NO_TRUTH.contains(&name.as_str());
        let truth = truth.choose(all, is_truth)?;
        let others: Vec<Topic> = all.iter().filter(|topic| **topic != truth).cloned().collect();
        let odom = odom.choose(if wanted.odom.is_some() { all } else { &others }, |_| true)?;
        if odom == truth {
            bail!(
                "`{}` is named as odometry and as corrected pose: the filter would be told what it is to find",
                shortened(&odom.0)
            );
        }
        Ok(Self { scan, odom, truth })
    }
}

impl Role<'_> {
    fn choose(&self, all: &[Topic], alone: impl Fn(&Topic) -> bool) -> Result<Topic> {
        let fit = |topic: &&Topic| self.kinds.contains(&topic.1);
        if let Some(wanted) = self.wanted {
            let is_wanted = |topic: &&Topic| topic.0.trim_start_matches('/') == wanted.trim_start_matches('/');
            let Some(topic) = all.iter().filter(fit).find(is_wanted) else {
                bail!("it has no {} on `{}`{}", self.types(), shortened(wanted), self.listed(all.iter().filter(fit)));
            };
            return Ok(topic.clone());
        }
        let usual = |name: &'static &str| all.iter().filter(fit).find(|topic| topic.0 == **name);
        if let Some(topic) = self.usual.iter().find_map(usual) {
            return Ok(topic.clone());
        }
        let left: Vec<&Topic> = all.iter().filter(fit).filter(|topic| alone(topic)).collect();
        match left[..] {
            [topic] => Ok(topic.clone()),
            [] => match self.listed(all.iter().filter(fit)) {
                none if none.is_empty() => bail!("it has no {}: no {}", self.what, self.types()),
                listed => bail!("none of its topics has {} by its name{listed}", self.what),
            },
            [..] => bail!("it has {} topics of {}{}", left.len(), self.what, self.listed(left.into_iter())),
        }
    }

    fn types(&self) -> String {
        let names: Vec<&str> = self.kinds.iter().map(|kind| kind.name()).collect();
        names.join(", ")
    }

    /// What could be named with the option.
    fn listed<'t>(&self, topics: impl Iterator<Item = &'t Topic>) -> String {
        let named = |(name, kind): &Topic| format!("`{} {}` ({})", self.option, shortened(name), kind.name());
        let named: Vec<String> = topics.map(named).collect();
        if named.is_empty() { String::new() } else { format!("; say which: {}", named.join(", ")) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn topic(name: &str, kind: Kind) -> Topic {
        (name.to_string(), kind)
    }

    fn chosen(all: &[Topic], wanted: Wanted<'_>) -> Result<[String; 3], String> {
        let topics = Topics::choose(all, wanted).map_err(|error| error.to_string())?;
        Ok([topics.scan.0, topics.odom.0, topics.truth.0])
    }

    #[test]
    fn topics_are_taken_by_type_then_by_name_then_as_the_user_says() {
        use Kind::*;
        let one = [topic("/mocap/robot", PoseStamped), topic("/laser", LaserScan), topic("/wheels", Odometry)];
        assert_eq!(chosen(&one, Wanted::default()), Ok(["/laser", "/wheels", "/mocap/robot"].map(String::from)));
        let several = [
            topic("/base_pose_ground_truth", Odometry),
            topic("/ekf", Odometry),
            topic("/goal_pose", PoseStamped),
            topic("/odom", Odometry),
            topic("/pose", PoseWithCovarianceStamped),
            topic("/rear", LaserScan),
            topic("/scan", LaserScan),
        ];
        let usual = chosen(&several, Wanted::default());
        assert_eq!(usual, Ok(["/scan", "/odom", "/base_pose_ground_truth"].map(String::from)));
        let wanted = Wanted { scan: Some("rear"), odom: Some("/ekf"), truth: Some("/pose") };
        assert_eq!(chosen(&several, wanted), Ok(["/rear", "/ekf", "/pose"].map(String::from)));
        let twice = Wanted { odom: Some("/ekf"), truth: Some("/ekf"), ..Wanted::default() };
        assert!(chosen(&several, twice).is_err_and(|error| error.contains("is named as odometry and as")));
    }

    #[test]
    fn where_several_fit_they_are_listed_with_what_to_type() {
        use Kind::*;
        let two =
            [topic("/a", LaserScan), topic("/b", LaserScan), topic("/odom", Odometry), topic("/pose", PoseStamped)];
        let error = chosen(&two, Wanted::default()).expect_err("two lasers");
        assert_eq!(error, "it has 2 topics of scans; say which: `--scan /a` (LaserScan), `--scan /b` (LaserScan)");
        let error = chosen(&two, Wanted { scan: Some("/c"), ..Wanted::default() }).expect_err("no such laser");
        assert!(error.starts_with("it has no LaserScan on `/c`; say which: `--scan /a`"), "{error}");
        let error = chosen(&two[..3], Wanted { scan: Some("/a"), ..Wanted::default() }).expect_err("no truth");
        let said = "none of its topics has corrected poses by its name; say which: `--truth /odom` (Odometry)";
        assert!(error.starts_with(said), "{error}");
    }
}
