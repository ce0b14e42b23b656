//! The topic of the commanded velocity: which message is spoken there, and whether anybody listens.

use crate::teller::Teller;
use crate::topic::{Listener, Said, Topics, is_name, rooted};
use anyhow::Result;
use clap::ValueEnum;
use rpl_ros_messages::messages::{Header, Time, Twist, TwistStamped};
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// How often it is looked who listens.
const LOOK_EVERY: Duration = Duration::from_millis(200);

/// A robot that is told to drive has somebody who listens within this time.
const UNHEARD: Duration = Duration::from_secs(5);

/// Motors that are off for longer have no mission.
const LEFT: Duration = Duration::from_secs(1);

/// Other topics that are named to whom nobody listens, at most.
const MOST_NAMED: usize = 3;

/// The frame of the velocity.
const FRAME: &str = "base_link";

/// A message that says a velocity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// `geometry_msgs/Twist`.
    Twist,
    /// `geometry_msgs/TwistStamped`.
    Stamped,
}

impl Kind {
    const ALL: [Self; 2] = [Self::Twist, Self::Stamped];

    /// Its name without its package.
    fn name(self) -> &'static str {
        match self {
            Self::Twist => "Twist",
            Self::Stamped => "TwistStamped",
        }
    }

    /// Its name with its package.
    fn full_name(self) -> String {
        format!("geometry_msgs/{}", self.name())
    }

    /// The option that chooses it.
    fn option(self) -> &'static str {
        match self {
            Self::Twist => "--twist twist",
            Self::Stamped => "--twist stamped",
        }
    }
}

/// Which message is to be spoken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Choice {
    /// That of whoever listens.
    #[default]
    Auto,
    /// geometry_msgs/Twist.
    Twist,
    /// geometry_msgs/TwistStamped.
    Stamped,
}

impl Choice {
    fn kind(self) -> Option<Kind> {
        match self {
            Self::Auto => None,
            Self::Twist => Some(Kind::Twist),
            Self::Stamped => Some(Kind::Stamped),
        }
    }
}

/// What is spoken.
enum Voice {
    Twist(Said<Twist>),
    Stamped(Said<TwistStamped>),
}

impl Voice {
    fn open(topics: &mut Topics, topic: &str, kind: Kind) -> Result<Self> {
        let name = kind.full_name();
        Ok(match kind {
            Kind::Twist => Self::Twist(topics.say(topic, &name)?),
            Kind::Stamped => Self::Stamped(topics.say(topic, &name)?),
        })
    }

    fn kind(&self) -> Kind {
        match self {
            Self::Twist(_) => Kind::Twist,
            Self::Stamped(_) => Kind::Stamped,
        }
    }
}

/// The topic of the commanded velocity.
pub struct Velocity {
    topic: String,
    choice: Choice,
    /// None while nobody listens, if he chooses.
    voice: Option<Voice>,
    audience: Audience,
    looked: Option<Instant>,
}

impl Velocity {
    /// Nothing is said yet.
    ///
    /// # Errors
    /// The name is none of ROS.
    pub fn new(topics: &mut Topics, topic: &str, choice: Choice) -> Result<Self> {
        is_name(topic)?;
        let voice = choice.kind().map(|kind| Voice::open(topics, topic, kind)).transpose()?;
        Ok(Self { topic: topic.to_string(), choice, voice, audience: Audience::default(), looked: None })
    }

    /// Looks who listens, every now and then: takes up the message that he expects, and tells when nobody does.
    /// `drives` and `is_off` say what the robot is told now.
    ///
    /// # Errors
    /// The topic cannot be opened.
    pub fn attend(&mut self, topics: &mut Topics, now: Instant, told: Motors, teller: &mut Teller) -> Result<()> {
        if self.looked.is_some_and(|looked| now.saturating_duration_since(looked) < LOOK_EVERY) {
            return Ok(());
        }
        self.looked = Some(now);
        let listeners = topics.listeners();
        if self.choice == Choice::Auto {
            self.take_up(topics, &listeners, teller)?;
        }
        let kind = self.voice.as_ref().map(Voice::kind);
        let is_heard = kind.is_some_and(|kind| count(&listeners, &rooted(&self.topic), kind) > 0);
        if let Some(news) = self.audience.look(now, is_heard, told) {
            let nobody = nobody(&self.topic, kind, &listeners);
            teller.tell(&match news {
                News::Nobody => nobody,
                News::Left => format!("the last subscriber of `{}` has left: {nobody}", self.topic),
            });
        }
        Ok(())
    }

    /// Speaks the message that is expected; who listens to that which is spoken keeps it.
    fn take_up(&mut self, topics: &mut Topics, listeners: &[Listener], teller: &mut Teller) -> Result<()> {
        let counts = Kind::ALL.map(|kind| count(listeners, &rooted(&self.topic), kind));
        let spoken = self.voice.as_ref().map(Voice::kind);
        let expected = match counts {
            [0, 0] => {
                // Whoever comes next may expect another one.
                self.voice = None;
                return Ok(());
            }
            [_, 0] => Kind::Twist,
            [0, _] => Kind::Stamped,
            [twist, stamped] => {
                let most = if stamped > twist { Kind::Stamped } else { Kind::Twist };
                let kept = spoken.unwrap_or(most);
                teller.once("two kinds", || {
                    let (topic, kept) = (&self.topic, kept.name());
                    let options = Kind::ALL.map(|kind| format!("`{}`", kind.option())).join(" or ");
                    format!("`{topic}` has subscribers of Twist and of TwistStamped, and {kept} is spoken: {options}")
                });
                kept
            }
        };
        if spoken != Some(expected) {
            // One at a time: tools take a topic to have one type.
            self.voice = None;
            self.voice = Some(Voice::open(topics, &self.topic, expected)?);
        }
        Ok(())
    }

    /// Publishes a velocity, if anybody can hear it.
    ///
    /// # Errors
    /// One sentence: nothing can be published any more.
    pub fn say(&mut self, twist: Twist, stamp: Time) -> Result<(), String> {
        match &mut self.voice {
            None => Ok(()),
            Some(Voice::Twist(said)) => said.say(twist),
            Some(Voice::Stamped(said)) => {
                said.say(TwistStamped { header: Header { stamp, frame_id: FRAME.to_string() }, twist })
            }
        }
    }
}

/// What motors are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motors {
    /// To drive.
    Drive,
    /// To stand.
    Stand,
    /// Nobody commands them.
    Off,
}

/// What is new about those who listen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum News {
    /// There is nobody.
    Nobody,
    /// The last has gone.
    Left,
}

/// Whether anybody listens, and what of it was told.
#[derive(Debug, Default)]
struct Audience {
    was_heard: bool,
    /// Since when a robot was to drive that does not hear it.
    unheard: Option<Instant>,
    /// Since when nobody commands.
    off: Option<Instant>,
    is_told: bool,
}

impl Audience {
    fn look(&mut self, now: Instant, is_heard: bool, told: Motors) -> Option<News> {
        let for_long = |since: Option<Instant>, most: Duration| {
            since.is_some_and(|since| now.saturating_duration_since(since) >= most)
        };
        self.off = (told == Motors::Off).then(|| self.off.unwrap_or(now));
        if is_heard || for_long(self.off, LEFT) {
            // Another mission is told anew.
            (self.unheard, self.is_told) = (None, false);
        }
        if is_heard {
            self.was_heard = true;
            return None;
        }
        if std::mem::take(&mut self.was_heard) {
            self.is_told = true;
            return Some(News::Left);
        }
        if told == Motors::Drive {
            self.unheard.get_or_insert(now);
        }
        let is_new = !self.is_told && for_long(self.unheard, UNHEARD);
        self.is_told |= is_new;
        is_new.then_some(News::Nobody)
    }
}

fn count(listeners: &[Listener], topic: &str, kind: Kind) -> usize {
    let name = kind.full_name();
    listeners.iter().filter(|listener| listener.topic == topic && listener.kind == name).count()
}

/// One sentence: nobody listens to a topic where a message is spoken, and who listens elsewhere.
fn nobody(topic: &str, spoken: Option<Kind>, listeners: &[Listener]) -> String {
    let named = listeners.iter().filter_map(|listener| {
        let kind = Kind::ALL.into_iter().find(|kind| kind.full_name() == listener.kind)?;
        let elsewhere = (listener.topic != rooted(topic)).then(|| format!("--velocity {}", listener.topic));
        let otherwise = spoken.filter(|spoken| *spoken != kind).map(|_| kind.option().to_string());
        let options: Vec<String> = elsewhere.into_iter().chain(otherwise).collect();
        let (name, kind) = (&listener.topic, kind.name());
        // Of another message under the same name it is said first.
        let is_far = listener.topic != rooted(topic);
        Some((is_far, format!("; `{name}` has a subscriber of {kind}: `{}`", options.join(" "))))
    });
    let named: BTreeSet<(bool, String)> = named.collect();
    let elsewhere: String = match named.len() {
        0 => "; no topic has a subscriber of Twist or TwistStamped".to_string(),
        _ => named.into_iter().take(MOST_NAMED).map(|(_, named)| named).collect(),
    };
    format!("nobody listens to `{topic}`{elsewhere}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listener(topic: &str, kind: Kind) -> Listener {
        Listener { topic: topic.to_string(), kind: kind.full_name() }
    }

    #[test]
    fn who_listens_elsewhere_or_to_another_message_is_named_with_the_options() {
        let diff_drive = listener("/diff_drive_controller/cmd_vel", Kind::Stamped);
        let odometry = Listener { topic: "/odom".to_string(), kind: "nav_msgs/Odometry".to_string() };
        let listeners = [odometry.clone(), diff_drive];
        assert_eq!(
            nobody("/cmd_vel", None, &listeners),
            "nobody listens to `/cmd_vel`; `/diff_drive_controller/cmd_vel` has a subscriber of TwistStamped: \
             `--velocity /diff_drive_controller/cmd_vel`"
        );
        assert!(nobody("/cmd_vel", Some(Kind::Twist), &listeners).ends_with("cmd_vel --twist stamped`"));
        assert_eq!(
            nobody("cmd_vel", Some(Kind::Twist), &[listener("/cmd_vel", Kind::Stamped)]),
            "nobody listens to `cmd_vel`; `/cmd_vel` has a subscriber of TwistStamped: `--twist stamped`"
        );
        assert!(nobody("/cmd_vel", None, &[odometry]).ends_with("no topic has a subscriber of Twist or TwistStamped"));
    }

    #[test]
    fn it_is_told_once_a_mission_that_nobody_listens_and_at_once_that_the_last_has_left() {
        let began = Instant::now();
        let mut audience = Audience::default();
        let mut look = |at_s: f64, is_heard, told| audience.look(began + Duration::from_secs_f64(at_s), is_heard, told);
        assert_eq!(look(0.0, false, Motors::Off), None);
        assert_eq!(look(60.0, false, Motors::Stand), None);
        assert_eq!([60.1, 65.0].map(|at_s| look(at_s, false, Motors::Drive)), [None, None]);
        assert_eq!(look(65.2, false, Motors::Drive), Some(News::Nobody));
        assert_eq!(look(75.0, false, Motors::Drive), None, "it was told");
        // The next mission.
        assert_eq!([76.0, 77.5].map(|at_s| look(at_s, false, Motors::Off)), [None, None]);
        assert_eq!(look(78.0, false, Motors::Drive), None);
        assert_eq!(look(83.0, false, Motors::Drive), Some(News::Nobody));
        assert_eq!(look(84.0, true, Motors::Drive), None);
        assert_eq!(look(84.2, false, Motors::Drive), Some(News::Left));
        assert_eq!(look(90.0, false, Motors::Drive), None, "it was told");
    }
}
