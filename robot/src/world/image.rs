//! Grey images of maps: PGM (plain and raw, any maximal value) and PNG.

/// Pixels of an image, at most: a map of 400 m by 400 m at 5 cm. A few hundred bytes can claim to be
/// any size.
const MOST_PIXELS: usize = 1 << 26;

/// What the decoder may allocate beside the pixels.
const DECODER_BYTES: usize = 64 << 20;

/// Why bytes are no image.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct ImageError {
    /// What was found, and what would be right.
    pub message: String,
}

fn wrong(message: impl Into<String>) -> ImageError {
    ImageError { message: message.into() }
}

/// A grey image, `[row][column]` with the top row first; 0 is black, 1 is white.
#[derive(Clone, Debug, PartialEq)]
pub struct GreyImage {
    /// Pixels along a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// `rows · columns` shades: the mean of the colours where there are several.
    pub shades: Vec<f32>,
    /// Whether a pixel is transparent in part; empty for an image without transparency.
    pub transparent: Vec<bool>,
}

impl GreyImage {
    /// Reads a PGM or a PNG image, told apart by their first bytes.
    ///
    /// # Errors
    /// Another format, a header that makes no sense, pixels that are missing or above the maximal value.
    pub fn decode(bytes: &[u8]) -> Result<Self, ImageError> {
        match bytes {
            [b'P', b'2' | b'5', ..] => decode_pgm(bytes),
            [0x89, b'P', b'N', b'G', ..] => decode_png(bytes),
            [] => Err(wrong("the image is empty")),
            _ => Err(wrong(
                "the image is neither PGM (P2 or P5) nor PNG; convert it, for example with `magick map.bmp map.pgm`",
            )),
        }
    }
}

/// The header of a PGM and what follows it.
struct PgmText<'b> {
    bytes: &'b [u8],
    at: usize,
}

impl PgmText<'_> {
    /// The next number, after white space and comments up to the end of their line.
    fn number(&mut self, what: &str) -> Result<usize, ImageError> {
        loop {
            match self.bytes.get(self.at) {
                Some(b'#') => {
                    while self.bytes.get(self.at).is_some_and(|&byte| byte != b'\n') {
                        self.at += 1;
                    }
                }
                Some(byte) if byte.is_ascii_whitespace() => self.at += 1,
                Some(_) => break,
                None => return Err(wrong(format!("the PGM image is truncated: it ends before {what}"))),
            }
        }
        let digits = self.bytes[self.at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let text = String::from_utf8_lossy(&self.bytes[self.at..self.at + digits]).into_owned();
        self.at += digits;
        text.parse().map_err(|_| wrong(format!("{what} of the PGM image is not a number (byte {})", self.at)))
    }
}

fn decode_pgm(bytes: &[u8]) -> Result<GreyImage, ImageError> {
    let is_plain = bytes[1] == b'2';
    let mut text = PgmText { bytes, at: 2 };
    let (columns, rows) = (text.number("the width")?, text.number("the height")?);
    let pixels = checked_pixels(columns, rows)?;
    let brightest = text.number("the maximal value")?;
    if brightest == 0 || brightest > 65535 {
        return Err(wrong(format!("the maximal value of a PGM image is from 1 to 65535, found {brightest}")));
    }
    let values = if is_plain { plain_values(&mut text, pixels)? } else { raw_values(&text, pixels, brightest)? };
    if let Some(value) = values.iter().find(|&&value| usize::from(value) > brightest) {
        return Err(wrong(format!("a pixel of {value} is above the maximal value of the PGM image, {brightest}")));
    }
    let shades = values.into_iter().map(|value| f32::from(value) / brightest as f32).collect();
    Ok(GreyImage { columns, rows, shades, transparent: Vec::new() })
}

fn checked_pixels(columns: usize, rows: usize) -> Result<usize, ImageError> {
    match columns.checked_mul(rows) {
        Some(pixels) if pixels > 0 && pixels <= MOST_PIXELS => Ok(pixels),
        _ => Err(wrong(format!(
            "an image of {columns} by {rows} pixels is no map: it has from 1 to {MOST_PIXELS} pixels; crop or shrink it"
        ))),
    }
}

fn plain_values(text: &mut PgmText<'_>, pixels: usize) -> Result<Vec<u16>, ImageError> {
    let read = |index: usize| {
        let value = text.number(&format!("pixel {} of {pixels}", index + 1))?;
        u16::try_from(value).map_err(|_| wrong(format!("pixel {} of {pixels} is {value}, above 65535", index + 1)))
    };
    // Not reserved from the header: a short file may claim any size.
    (0..pixels).map(read).collect()
}

/// One byte a pixel, or two with the higher one first.
fn raw_values(text: &PgmText<'_>, pixels: usize, brightest: usize) -> Result<Vec<u16>, ImageError> {
    let width = if brightest > 255 { 2 } else { 1 };
    // Exactly one white-space byte ends the header.
    let data = text.bytes.get(text.at + 1..).unwrap_or_default();
    let Some(data) = data.get(..pixels * width) else {
        return Err(wrong(format!(
            "the PGM image is truncated: {} bytes of pixels, {} expected",
            data.len(),
            pixels * width
        )));
    };
    Ok(match width {
        1 => data.iter().map(|&byte| u16::from(byte)).collect(),
        _ => data.as_chunks::<2>().0.iter().map(|&pair| u16::from_be_bytes(pair)).collect(),
    })
}

fn decode_png(bytes: &[u8]) -> Result<GreyImage, ImageError> {
    let broken = |error: png::DecodingError| wrong(format!("the PNG image is truncated or damaged: {error}"));
    let limits = png::Limits { bytes: DECODER_BYTES };
    let mut decoder = png::Decoder::new_with_limits(std::io::Cursor::new(bytes), limits);
    // Neither means anything in a map, and both may inflate to gigabytes.
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    decoder.set_transformations(png::Transformations::EXPAND | png::Transformations::STRIP_16);
    let header = decoder.read_header_info().map_err(broken)?;
    let (columns, rows) = (header.width as usize, header.height as usize);
    checked_pixels(columns, rows)?;
    let mut reader = decoder.read_info().map_err(broken)?;
    let mut data = vec![0; reader.output_buffer_size().ok_or_else(|| wrong("the PNG image is too large"))?];
    let frame = reader.next_frame(&mut data).map_err(broken)?;
    let channels = frame.color_type.samples();
    let has_alpha = matches!(frame.color_type, png::ColorType::GrayscaleAlpha | png::ColorType::Rgba);
    let colours = if has_alpha { channels - 1 } else { channels };
    let shade = |pixel: &[u8]| {
        let sum: u32 = pixel[..colours].iter().map(|&byte| u32::from(byte)).sum();
        sum as f32 / (colours * 255) as f32
    };
    let pixels = data[..frame.buffer_size()].chunks_exact(channels);
    Ok(GreyImage {
        columns,
        rows,
        shades: pixels.clone().map(shade).collect(),
        transparent: if has_alpha { pixels.map(|pixel| pixel[colours] < 255).collect() } else { Vec::new() },
    })
}
