//! Text in drawings: how wide it is, where lines break.

use super::palette;
use svg::node::element::Text;

/// Of what is written beside things.
pub const SMALL_PX: f64 = 11.0;
/// Of legends and axes.
pub const TEXT_PX: f64 = 12.0;
/// Of titles.
pub const TITLE_PX: f64 = 16.0;

/// The family that drawings ask for; the first is the one that PNG files are made with.
pub const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// About how wide a text is: that of DejaVu Sans, which is as wide as any that may take its place.
pub fn width_px(text: &str, size_px: f64) -> f64 {
    let em = |sign: char| match sign {
        'i' | 'j' | 'l' | '.' | ',' | ':' | ';' | '\'' | '|' | '!' | ' ' => 0.32,
        'f' | 't' | 'r' | '(' | ')' | '-' | '/' => 0.41,
        'm' | 'w' | 'M' | 'W' | '%' | '@' => 0.97,
        'A'..='Z' => 0.71,
        _ if sign as u32 >= 0x2e80 => 1.0,
        _ => 0.62,
    };
    text.chars().map(em).sum::<f64>() * size_px
}

/// The words of a text in lines no wider than this; a word that is wider is cut.
pub fn wrap(text: &str, size_px: f64, most_px: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let word = shortened(word, size_px, most_px);
        match lines.last_mut() {
            Some(line) if width_px(line, size_px) + width_px(&word, size_px) + size_px * 0.32 <= most_px => {
                line.push(' ');
                line.push_str(&word);
            }
            _ => lines.push(word),
        }
    }
    lines
}

/// As much of a text as fits, with an ellipsis if that is not all.
pub fn shortened(text: &str, size_px: f64, most_px: f64) -> String {
    if width_px(text, size_px) <= most_px {
        return text.to_string();
    }
    let mut kept = String::new();
    let mut room_px = most_px - size_px;
    for sign in text.chars() {
        room_px -= width_px(sign.encode_utf8(&mut [0; 4]), size_px);
        if room_px < 0.0 {
            break;
        }
        kept.push(sign);
    }
    kept + "…"
}

/// A text that begins there.
pub fn text(content: &str, x_px: f64, y_px: f64, size_px: f64) -> Text {
    Text::new(content)
        .set("x", rounded(x_px))
        .set("y", rounded(y_px))
        .set("font-size", size_px)
        .set("fill", palette::INK)
}

/// A text around there.
pub fn centred(content: &str, x_px: f64, y_px: f64, size_px: f64) -> Text {
    text(content, x_px, y_px, size_px).set("text-anchor", "middle")
}

/// A text that ends there.
pub fn ending(content: &str, x_px: f64, y_px: f64, size_px: f64) -> Text {
    text(content, x_px, y_px, size_px).set("text-anchor", "end")
}

/// A text that can be read on anything.
pub fn with_halo(text: Text) -> Text {
    text.set("stroke", palette::PAPER)
        .set("stroke-width", 3)
        .set("stroke-linejoin", "round")
        .set("paint-order", "stroke")
}

/// To the tenth of a pixel: more digits only make the file longer.
pub fn rounded(length_px: f64) -> f64 {
    (length_px * 10.0).round() / 10.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_no_wider_than_asked_for_and_lose_no_word_that_fits() {
        let text = "the belief at the end of a run, and where the robot really is";
        for most_px in [90.0, 150.0, 1000.0] {
            let lines = wrap(text, 16.0, most_px);
            assert!(lines.iter().all(|line| width_px(line, 16.0) <= most_px), "{lines:?}");
            assert_eq!(lines.join(" "), text);
        }
        let cut = wrap("incomprehensibilities", 16.0, 60.0);
        assert!(cut.len() == 1 && cut[0].ends_with('…') && width_px(&cut[0], 16.0) <= 66.0, "{cut:?}");
    }
}
