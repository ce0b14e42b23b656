//! What is packed as a stream: gzip, zstd and LZ4, each known by how it begins.

use flate2::read::MultiGzDecoder;
use lz4_flex::frame::FrameDecoder as Lz4Decoder;
use ruzstd::decoding::StreamingDecoder as ZstdDecoder;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use std::io::{self, Read};

/// How something is packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// RFC 1952.
    Gzip,
    /// RFC 8878.
    Zstd,
    /// The frames of LZ4.
    Lz4,
}

impl Packing {
    /// How bytes are packed, by their beginning; none if they are not.
    pub fn of(head: &[u8]) -> Option<Self> {
        match head {
            [0x1f, 0x8b, ..] => Some(Self::Gzip),
            [0x28, 0xb5, 0x2f, 0xfd, ..] => Some(Self::Zstd),
            [0x04, 0x22, 0x4d, 0x18, ..] => Some(Self::Lz4),
            _ => None,
        }
    }

    /// What packs so.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gzip => "gzip",
            Self::Zstd => "zstd",
            Self::Lz4 => "LZ4",
        }
    }

    /// A reader of what is packed in some bytes.
    pub fn reader(self, bytes: &[u8]) -> Box<dyn Read + '_> {
        match self {
            Self::Gzip => Box::new(MultiGzDecoder::new(bytes)),
            Self::Zstd => Box::new(ZstdFrames { left: bytes, frame: None }),
            Self::Lz4 => Box::new(Lz4Frames(Lz4Decoder::new(bytes))),
        }
    }
}

/// The frames of LZ4 one after the other; the decoder says after each that it is at an end.
struct Lz4Frames<'b>(Lz4Decoder<&'b [u8]>);

impl Read for Lz4Frames<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        loop {
            let read = self.0.read(into)?;
            if read > 0 || into.is_empty() || self.0.get_ref().is_empty() {
                return Ok(read);
            }
        }
    }
}

/// The frames of zstd one after the other, without those to skip; the decoder itself knows one frame.
struct ZstdFrames<'b> {
    left: &'b [u8],
    frame: Option<ZstdDecoder<&'b [u8], ruzstd::decoding::FrameDecoder>>,
}

impl Read for ZstdFrames<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if into.is_empty() {
            return Ok(0);
        }
        loop {
            if let Some(frame) = &mut self.frame {
                let read = frame.read(into)?;
                if read > 0 {
                    return Ok(read);
                }
                self.left = frame.get_ref();
                self.frame = None;
            }
            if self.left.is_empty() {
                return Ok(0);
            }
            match ZstdDecoder::new(self.left) {
                Ok(frame) => self.frame = Some(frame),
                Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame { length, .. })) => {
                    // Four bytes that say so, four of the length.
                    let behind = self.left.get(8 + length as usize..);
                    self.left = behind.ok_or_else(|| io::Error::from(io::ErrorKind::UnexpectedEof))?;
                }
                Err(error) => return Err(io::Error::other(error)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::Compression;
    use flate2::write::GzEncoder;
    use lz4_flex::frame::FrameEncoder;
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};
    use std::io::Write;

    fn packed(packing: Packing, bytes: &[u8]) -> Vec<u8> {
        match packing {
            Packing::Gzip => {
                let mut packed = GzEncoder::new(Vec::new(), Compression::default());
                packed.write_all(bytes).expect("it is in memory");
                packed.finish().expect("it is in memory")
            }
            Packing::Zstd => compress_to_vec(bytes, CompressionLevel::Fastest),
            Packing::Lz4 => {
                let mut packed = FrameEncoder::new(Vec::new());
                packed.write_all(bytes).expect("it is in memory");
                packed.finish().expect("it is in memory")
            }
        }
    }

    fn read(packing: Packing, bytes: &[u8]) -> io::Result<Vec<u8>> {
        let mut all = Vec::new();
        packing.reader(bytes).read_to_end(&mut all).map(|_| all)
    }

    #[test]
    fn what_is_packed_is_known_by_its_beginning_and_unpacked_also_in_two_parts() {
        let text = b"FLASER 3 1.0 1.0 1.0 ".repeat(9000);
        for packing in [Packing::Gzip, Packing::Zstd, Packing::Lz4] {
            let part = packed(packing, &text);
            assert!(part.len() < text.len() / 4 && Packing::of(&part) == Some(packing), "{packing:?}");
            assert_eq!(read(packing, &part).expect("it is whole"), text, "{packing:?}");
            let twice = [&part[..], &part].concat();
            assert_eq!(read(packing, &twice).expect("it is whole").len(), 2 * text.len(), "{packing:?}");
            assert!(read(packing, &part[..part.len() / 2]).is_err(), "{packing:?}");
        }
        assert_eq!(Packing::of(b"FLASER"), None);
    }

    #[test]
    fn frames_of_zstd_that_are_to_be_skipped_are() {
        let skipped = [&[0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0][..], b"abc"].concat();
        let all = [&packed(Packing::Zstd, b"one ")[..], &skipped, &packed(Packing::Zstd, b"two")].concat();
        assert_eq!(read(Packing::Zstd, &all).expect("it is whole"), b"one two");
        assert!(read(Packing::Zstd, &all[..packed(Packing::Zstd, b"one ").len() + 9]).is_err());
    }
}
