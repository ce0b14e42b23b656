//! The messages of an MCAP file, also from chunks that are packed.

use anyhow::{Context, Result, anyhow, bail};
use mcap::McapError;
use mcap::read::{ChunkReader, LinearReader};
use mcap::records::{ChunkHeader, Record};
use rpl_lang::visible::shortened;
use rpl_shell::files::packed::Packing;
use std::collections::BTreeMap;
use std::io::Read;

/// A chunk that is longer unpacked is refused; those of recorders have a few MiB.
const MOST_CHUNK_BYTES: u64 = 256 << 20;

/// All chunks together may not be longer: somebody waits.
const MOST_UNPACKED_BYTES: u64 = 8 << 30;

/// A topic as the file tells of it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Channel {
    /// Its name.
    pub topic: String,
    /// The type of its messages, as `sensor_msgs/msg/LaserScan`.
    pub kind: String,
    /// How they are written: `cdr` by ROS 2.
    pub encoding: String,
}

/// What the records that were read so far say of those to come.
#[derive(Default)]
struct Known {
    kinds: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
    unpacked_bytes: u64,
}

/// Calls `hear` with each message in the order of the file: its channel, the time of the recorder, its bytes. Tells
/// whether the file has its end; what is missing of one that has not is left out.
///
/// # Errors
/// The file is damaged, its chunks are packed by something else than zstd or LZ4, or `hear` refuses a message.
pub fn each(bytes: &[u8], mut hear: impl FnMut(&Channel, u64, &[u8])) -> Result<bool> {
    let mut known = Known::default();
    for record in LinearReader::new(bytes)? {
        match record {
            Ok(Record::Chunk { header, data }) => {
                let (header, plain) = known.unpacked(header, &data)?;
                for record in ChunkReader::new(header, &plain)? {
                    known.take(record.context("a chunk of it is damaged")?, &mut hear);
                }
            }
            Ok(record) => known.take(record, &mut hear),
            Err(McapError::UnexpectedEof) => return Ok(false),
            Err(error) => return Err(error.into()),
        }
    }
    Ok(true)
}

impl Known {
    fn take(&mut self, record: Record<'_>, hear: &mut impl FnMut(&Channel, u64, &[u8])) {
        match record {
            Record::Schema { header, .. } => {
                self.kinds.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                let kind = self.kinds.get(&channel.schema_id).cloned().unwrap_or_default();
                let known = Channel { topic: channel.topic, kind, encoding: channel.message_encoding };
                self.channels.insert(channel.id, known);
            }
            Record::Message { header, data } => {
                // A message whose channel is not told cannot be one of those that are asked for.
                if let Some(channel) = self.channels.get(&header.channel_id) {
                    hear(channel, header.log_time, &data);
                }
            }
            Record::Header(_)
            | Record::Footer(_)
            | Record::Chunk { .. }
            | Record::MessageIndex(_)
            | Record::ChunkIndex(_)
            | Record::Attachment { .. }
            | Record::AttachmentIndex(_)
            | Record::Statistics(_)
            | Record::Metadata(_)
            | Record::MetadataIndex(_)
            | Record::SummaryOffset(_)
            | Record::DataEnd(_)
            | Record::Unknown { .. } => {}
        }
    }

    /// A chunk as if it had not been packed; whoever reads its records checks its sum.
    fn unpacked(&mut self, header: ChunkHeader, data: &[u8]) -> Result<(ChunkHeader, Vec<u8>)> {
        let packing = match header.compression.as_str() {
            "" => None,
            "zstd" => Some(Packing::Zstd),
            "lz4" => Some(Packing::Lz4),
            other => bail!(
                "its chunks are packed by `{}`; zstd, lz4 and none are read: type `mcap compress --compression none FILE \
                 -o plain.mcap`",
                shortened(other)
            ),
        };
        let length = header.uncompressed_size;
        self.unpacked_bytes = self.unpacked_bytes.saturating_add(length);
        if length > MOST_CHUNK_BYTES || self.unpacked_bytes > MOST_UNPACKED_BYTES {
            bail!(
                "it is longer than 8 GiB unpacked, or a chunk of it than 256 MiB: type `mcap filter FILE -o short.mcap -y \
                 TOPIC` with a `-y` for each of the topics of scans, odometry and corrected poses"
            );
        }
        let mut plain = Vec::new();
        if let Some(packing) = packing {
            let unpacked = packing.reader(data).take(length + 1).read_to_end(&mut plain);
            unpacked.map_err(|error| anyhow!("a chunk of it, packed by {}, is damaged ({error})", packing.name()))?;
        } else {
            plain.extend_from_slice(data);
        }
        if plain.len() as u64 != length {
            bail!("a chunk of it is damaged: {length} bytes are said and {} found", plain.len());
        }
        Ok((ChunkHeader { compression: String::new(), compressed_size: length, ..header }, plain))
    }
}
