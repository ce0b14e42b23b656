//! Drawings as PNG and PDF, with letters of our own, so that they are the same wherever they are made.

use super::writing::FAMILY;
use anyhow::{Context, Result, anyhow};
use resvg::tiny_skia::{Color, Pixmap, Transform};
use resvg::usvg::{Options, Tree, WriteOptions, fontdb};
use std::sync::{Arc, LazyLock};
use svg2pdf::{ConversionOptions, PageOptions};

/// Pixels of a PNG for one of the SVG: sharp on paper at its size on the screen.
const SCALE: f32 = 2.0;

/// The most pixels of a drawing.
const MOST_PIXELS: f64 = 64e6;

/// Pixels of the SVG for an inch of the PDF, as browsers print them.
const PAGE_DPI: f32 = 96.0;

/// The letters: DejaVu Sans, upright and bold, with what drawings write.
static FONTS: LazyLock<Arc<fontdb::Database>> = LazyLock::new(|| {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(include_bytes!("../fonts/DejaVuSans.ttf").to_vec());
    fonts.load_font_data(include_bytes!("../fonts/DejaVuSans-Bold.ttf").to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    Arc::new(fonts)
});

fn read(drawing: &str) -> Result<Tree> {
    let options = Options { font_family: FAMILY.to_string(), fontdb: FONTS.clone(), ..Options::default() };
    Tree::from_str(drawing, &options).context("the drawing cannot be read")
}

/// A drawing as PDF, its letters as outlines; its last line is a comment with this mark.
///
/// # Errors
/// It is no drawing.
pub fn pdf(drawing: &str, mark: &str) -> Result<Vec<u8>> {
    // Without its text feature, and the dozen crates of that, the converter leaves text out: it is turned into paths before.
    let outlines = read(drawing)?.to_string(&WriteOptions { preserve_text: false, ..WriteOptions::default() });
    // An outline is compressed, and every byte of the file follows from the drawing.
    let converted = svg2pdf::to_pdf(&read(&outlines)?, ConversionOptions::default(), PageOptions { dpi: PAGE_DPI });
    let mut bytes = converted.map_err(|error| anyhow!("the drawing cannot be converted: {error}"))?;
    bytes.extend_from_slice(format!("\n%{mark}\n").as_bytes());
    Ok(bytes)
}

/// A drawing as PNG; its text chunk `Software` is this mark.
///
/// # Errors
/// It is no drawing, or a page of it would be too large.
pub fn png(drawing: &str, mark: &str) -> Result<Vec<u8>> {
    let tree = read(drawing)?;
    let size = tree.size();
    let scale = SCALE.min((MOST_PIXELS / f64::from(size.width() * size.height())).sqrt() as f32);
    let side = |length: f32| ((length * scale).ceil() as u32).max(1);
    let (width, height) = (side(size.width()), side(size.height()));
    let mut pixels = Pixmap::new(width, height).ok_or_else(|| anyhow!("the drawing has no size"))?;
    // The last pixels lie only partly on the sheet.
    pixels.fill(Color::WHITE);
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut pixels.as_mut());
    let colours: Vec<u8> = pixels.data().chunks_exact(4).flat_map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.add_text_chunk("Software".to_string(), mark.to_string())?;
    encoder.write_header()?.write_image_data(&colours)?;
    Ok(bytes)
}
