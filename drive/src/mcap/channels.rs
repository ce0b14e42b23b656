//! The file: a channel for each topic, and messages on them.

use anyhow::Result;
use mcap::records::MessageHeader;
use mcap::{WriteOptions, Writer};
use rpl_ros_messages::text::String as Text;
use rpl_ros_messages::{Message, cdr};
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;

/// A topic on which messages of one type are written.
pub struct Topic {
    channel_id: u16,
    written: u32,
}

/// What ROS records with a latched topic: reliable, transient local; there is no deadline (the longest time ROS knows), and
/// readers ask for every key.
const LATCHED: &str = "\
- history: keep_last
  depth: 1
  reliability: reliable
  durability: transient_local
  deadline: {sec: 9223372036, nsec: 854775807}
  lifespan: {sec: 9223372036, nsec: 854775807}
  liveliness: automatic
  liveliness_lease_duration: {sec: 9223372036, nsec: 854775807}
  avoid_ros_namespace_conventions: false
";

/// An MCAP file being written.
pub struct McapFile {
    writer: Writer<BufWriter<File>>,
}

/// Bytes between two indices of the file.
const CHUNK_BYTES: u64 = 1 << 20;

impl McapFile {
    /// An empty file.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn begin(file: File) -> Result<Self> {
        let options = WriteOptions::new()
            .compression(None)
            .profile("ros2")
            .library(concat!("rpl ", env!("CARGO_PKG_VERSION")))
            .chunk_size(Some(CHUNK_BYTES));
        Ok(Self { writer: options.create(BufWriter::new(file))? })
    }

    /// A topic for messages of a type of ROS. Of a latched topic, who comes later hears the last message.
    ///
    /// # Errors
    /// The disk is full.
    pub fn topic<M: Message>(&mut self, name: &str, latched: bool) -> Result<Topic> {
        let mut metadata = BTreeMap::new();
        if latched {
            metadata.insert("offered_qos_profiles".to_string(), LATCHED.to_string());
        }
        self.channel::<M>(name, &metadata)
    }

    /// A topic for texts of JSON; what they are like stands with the channel as `jsonschema`.
    ///
    /// # Errors
    /// The disk is full.
    pub fn json_topic(&mut self, name: &str, schema: &Value) -> Result<Topic> {
        let described = BTreeMap::from([("jsonschema".to_string(), schema.to_string())]);
        self.channel::<Text>(name, &described)
    }

    fn channel<M: Message>(&mut self, name: &str, metadata: &BTreeMap<String, String>) -> Result<Topic> {
        let schema = self.writer.add_schema(M::NAME, "ros2msg", M::definition().as_bytes())?;
        let channel_id = self.writer.add_channel(schema, name, "cdr", metadata)?;
        Ok(Topic { channel_id, written: 0 })
    }

    /// Writes a message at a time of the run.
    ///
    /// # Errors
    /// The disk is full.
    pub fn write<M: Message + Serialize>(&mut self, topic: &mut Topic, time_us: u64, message: &M) -> Result<()> {
        let time_ns = time_us.saturating_mul(1000);
        let sequence = topic.written;
        topic.written = topic.written.wrapping_add(1);
        let header = MessageHeader { channel_id: topic.channel_id, sequence, log_time: time_ns, publish_time: time_ns };
        Ok(self.writer.write_to_known_channel(&header, &cdr(message))?)
    }

    /// Writes the index, without which readers must look through the whole file.
    ///
    /// # Errors
    /// The disk is full.
    pub fn finish(&mut self) -> Result<()> {
        self.writer.finish()?;
        Ok(())
    }
}
