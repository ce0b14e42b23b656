//! The topics of ROS 2, and what has come on them.

use anyhow::{Context as _, Result, anyhow};
use ros2_client::dds::rustdds::discovery::DiscoveredReaderData;
use ros2_client::qos::{History, WhenFull};
use ros2_client::{
    Context, ContextOptions, MessageTypeName, Name, Node, NodeName, NodeOptions, Publisher, QosProfile, Subscription,
};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::time::{Duration, Instant};

/// A sender that has said nothing for longer than this is lost.
pub const PATIENCE: Duration = Duration::from_secs(1);

/// What is taken in at once, at most; the rest has to wait.
const MOST_TAKEN: usize = 100;

/// Only the newest counts, and whoever publishes reliably or not is heard.
const NEWEST: QosProfile = QosProfile::subscription_default();

/// Each counts, also what comes between two looks.
const EACH: QosProfile = QosProfile::subscription_default().history(History::KeepLast { depth: MOST_TAKEN });

/// Arrives, and never keeps the robot waiting.
const SURE: QosProfile = QosProfile::publisher_default().reliability_reliable(WhenFull::Fail);

/// Before the name of a topic of ROS 2, in DDS.
const OF_ROS: &str = "rt";

/// Between the package and the name of a message, in DDS.
const IN_TYPE: &str = "::msg::dds_::";

/// Who listens: a topic, and the type that is expected there.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Listener {
    /// Its name, from the root on.
    pub topic: String,
    /// `PACKAGE/NAME`.
    pub kind: String,
}

/// Opens the topics of a domain of ROS 2.
pub struct Topics {
    node: Node,
    // Behind the node, which uses it until it is dropped.
    context: Context,
}

impl Topics {
    /// A node of a name in a domain.
    ///
    /// # Errors
    /// There is no network to take part in.
    pub fn join(domain: u16, name: &str) -> Result<Self> {
        let cannot = || format!("cannot take part in the domain {domain} of ROS 2");
        let context = Context::with_options(ContextOptions::new().domain_id(domain)).with_context(cannot)?;
        let name = NodeName::new("/", name).map_err(|error| anyhow!("{}: {error:?}", cannot()))?;
        let options = NodeOptions::new().enable_rosout(false).start_parameter_services(false);
        let node = context.new_node(name, options).map_err(|error| anyhow!("{}: {error:?}", cannot()))?;
        Ok(Self { node, context })
    }

    /// Hears the newest of what is published under a name, of a type `PACKAGE/NAME`.
    ///
    /// # Errors
    /// The name is none of ROS.
    pub fn hear_newest<M: 'static>(&mut self, topic: &str, kind: &str) -> Result<Heard<M>> {
        self.hear(topic, kind, NEWEST)
    }

    /// The same, and what came before the newest since the last look.
    ///
    /// # Errors
    /// The name is none of ROS.
    pub fn hear_each<M: 'static>(&mut self, topic: &str, kind: &str) -> Result<Heard<M>> {
        self.hear(topic, kind, EACH)
    }

    fn hear<M: 'static>(&mut self, topic: &str, kind: &str, quality: QosProfile) -> Result<Heard<M>> {
        let opened = self.open(topic, kind, &quality)?;
        let cannot = || format!("cannot subscribe to `{topic}`");
        let subscription = self.node.create_subscription(&opened, Some(quality)).with_context(cannot)?;
        Ok(Heard { topic: topic.to_string(), subscription, last: None, is_refused: false })
    }

    /// Publishes under a name.
    ///
    /// # Errors
    /// The name is none of ROS.
    pub fn say<M: Serialize>(&mut self, topic: &str, kind: &str) -> Result<Said<M>> {
        let opened = self.open(topic, kind, &SURE)?;
        let cannot = || format!("cannot publish at `{topic}`");
        let publisher = self.node.create_publisher(&opened, Some(SURE)).with_context(cannot)?;
        Ok(Said { topic: topic.to_string(), publisher, last: Instant::now() })
    }

    /// Who listens anywhere, one entry for each subscriber, as far as it was discovered.
    pub fn listeners(&self) -> Vec<Listener> {
        let readers = self.context.domain_participant().discovered_readers();
        let listener = |reader: &DiscoveredReaderData| {
            let data = &reader.subscription_topic_data;
            let topic = data.topic_name().strip_prefix(OF_ROS)?.strip_prefix('/')?;
            let (package, kind) = data.type_name().split_once(IN_TYPE)?;
            let kind = format!("{package}/{}", kind.strip_suffix('_')?);
            Some(Listener { topic: rooted(topic), kind })
        };
        readers.iter().filter_map(listener).collect()
    }

    fn open(&self, topic: &str, kind: &str, quality: &QosProfile) -> Result<ros2_client::dds::rustdds::Topic> {
        let name = name(topic)?;
        let (package, kind) = kind.split_once('/').with_context(|| format!("`{kind}` is no type of messages"))?;
        let kind = MessageTypeName::new(package, kind);
        self.node.create_topic(&name, kind, quality).with_context(|| format!("cannot open `{topic}`"))
    }
}

fn name(topic: &str) -> Result<Name> {
    let wrong = |error| anyhow!("`{topic}` is no name of a topic ({error:?}); one is, for instance, `/robot/odom`");
    Name::parse(topic).map_err(wrong)
}

/// The name of a topic from the root on, as [`Listener`]s have it.
pub fn rooted(topic: &str) -> String {
    format!("/{}", topic.trim_start_matches('/'))
}

/// The name can be that of a topic.
///
/// # Errors
/// It is none of ROS.
pub fn is_name(topic: &str) -> Result<()> {
    name(topic).map(drop)
}

/// A topic that is heard.
pub struct Heard<M> {
    /// Its name.
    pub topic: String,
    subscription: Subscription<M>,
    /// When it last said what is of use.
    last: Option<Instant>,
    /// What it has said since was of no use.
    is_refused: bool,
}

impl<M: DeserializeOwned + 'static> Heard<M> {
    /// What has come since the last look, the newest last.
    ///
    /// # Errors
    /// One sentence: what came is no such message.
    pub fn take(&mut self) -> Result<Vec<M>, String> {
        self.take_if(|_| true)
    }

    /// The same of what is of use; the rest is dropped, and who says nothing else is silent.
    ///
    /// # Errors
    /// One sentence: what came is no such message.
    pub fn take_if(&mut self, mut is_of_use: impl FnMut(&M) -> bool) -> Result<Vec<M>, String> {
        let mut taken = Vec::new();
        for _ in 0..MOST_TAKEN {
            match self.subscription.take() {
                Ok(Some((message, _))) if is_of_use(&message) => taken.push(message),
                Ok(Some(_)) => self.is_refused = true,
                Ok(None) => break,
                Err(error) => return Err(self.fault(&format!("has said what cannot be read: {error}"))),
            }
        }
        if !taken.is_empty() {
            (self.last, self.is_refused) = (Some(Instant::now()), false);
        }
        Ok(taken)
    }
}

impl<M> Heard<M> {
    /// Whether anything has ever come.
    pub fn has_spoken(&self) -> bool {
        self.last.is_some()
    }

    /// It has said something in the last second.
    ///
    /// # Errors
    /// One sentence: it has not.
    pub fn is_alive(&self, now: Instant) -> Result<(), String> {
        match self.last {
            Some(last) if now.saturating_duration_since(last) < PATIENCE => Ok(()),
            Some(_) | None => {
                let what = if self.is_refused { "nothing of use" } else { "nothing" };
                Err(self.fault(&format!("has said {what} for {:.1} s", PATIENCE.as_secs_f64())))
            }
        }
    }

    /// One sentence about the topic.
    pub fn fault(&self, why: &str) -> String {
        format!("the topic `{}` {why}", self.topic)
    }
}

/// A topic that is published.
pub struct Said<M: Serialize> {
    topic: String,
    publisher: Publisher<M>,
    last: Instant,
}

impl<M: Serialize> Said<M> {
    /// Publishes a message, unless those before it are still on their way.
    ///
    /// # Errors
    /// One sentence: nothing can be published any more.
    pub fn say(&mut self, message: M) -> Result<(), String> {
        match self.publisher.publish(message) {
            Ok(()) => {
                self.last = Instant::now();
                Ok(())
            }
            Err(ros2_client::WriteError::WouldBlock { .. }) if self.last.elapsed() < PATIENCE => Ok(()),
            Err(error) => Err(format!("the topic `{}` takes nothing any more: {error}", self.topic)),
        }
    }
}
