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

/// A grey image, `[row][column]` with the top row first. Two bytes a pixel, three with transparency.
#[derive(Clone, Debug, PartialEq)]
pub struct GreyImage {
    /// Pixels along a row.
    pub columns: usize,
    /// Rows.
    pub rows: usize,
    /// `rows · columns` values, from 0, black, to `white`: the sum of the colours where there are several.
    pub values: Vec<u16>,
    /// The value of white.
    pub white: u16,
    /// Whether a pixel is transparent in part; empty for an image without transparency.
    pub transparent: Vec<bool>,
}

impl GreyImage {
    /// The shade of a value, from 0, black, to 1, white.
    pub fn shade(&self, value: u16) -> f32 {
        f32::from(value) / f32::from(self.white)
    }

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
    fn number(&mut self, what: impl Fn() -> String) -> Result<usize, ImageError> {
        loop {
            match self.bytes.get(self.at) {
                Some(b'#') => {
                    while self.bytes.get(self.at).is_some_and(|&byte| byte != b'\n') {
                        self.at += 1;
                    }
                }
                Some(byte) if byte.is_ascii_whitespace() => self.at += 1,
                Some(_) => break,
                None => return Err(wrong(format!("the PGM image is truncated: it ends before {}", what()))),
            }
        }
        let digits = self.bytes[self.at..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let text = str::from_utf8(&self.bytes[self.at..self.at + digits]);
        self.at += digits;
        let number = text.ok().and_then(|text| text.parse().ok());
        number.ok_or_else(|| wrong(format!("{} of the PGM image is not a number (byte {})", what(), self.at)))
    }
}

fn decode_pgm(bytes: &[u8]) -> Result<GreyImage, ImageError> {
    let is_plain = bytes[1] == b'2';
    let mut text = PgmText { bytes, at: 2 };
    let (columns, rows) = (text.number(|| "the width".to_owned())?, text.number(|| "the height".to_owned())?);
    let pixels = checked_pixels(columns, rows)?;
    let brightest = text.number(|| "the maximal value".to_owned())?;
    let Some(white) = u16::try_from(brightest).ok().filter(|&white| white > 0) else {
        return Err(wrong(format!("the maximal value of a PGM image is from 1 to 65535, found {brightest}")));
    };
    let values = if is_plain { plain_values(&mut text, pixels)? } else { raw_values(&text, pixels, white)? };
    if let Some(value) = values.iter().find(|&&value| value > white) {
        return Err(wrong(format!("a pixel of {value} is above the maximal value of the PGM image, {white}")));
    }
    Ok(GreyImage { columns, rows, values, white, transparent: Vec::new() })
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
        let value = text.number(|| format!("pixel {} of {pixels}", index + 1))?;
        u16::try_from(value).map_err(|_| wrong(format!("pixel {} of {pixels} is {value}, above 65535", index + 1)))
    };
    // Not reserved from the header: a short file may claim any size.
    (0..pixels).map(read).collect()
}

/// One byte a pixel, or two with the higher one first.
fn raw_values(text: &PgmText<'_>, pixels: usize, white: u16) -> Result<Vec<u16>, ImageError> {
    let width = if white > 255 { 2 } else { 1 };
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
    let value = |pixel: &[u8]| pixel[..colours].iter().map(|&byte| u16::from(byte)).sum::<u16>();
    let pixels = data[..frame.buffer_size()].chunks_exact(channels);
    Ok(GreyImage {
        columns,
        rows,
        values: pixels.clone().map(value).collect(),
        // Three colours at most.
        white: 255 * colours as u16,
        transparent: if has_alpha { pixels.map(|pixel| pixel[colours] < 255).collect() } else { Vec::new() },
    })
}
