//! Numbers on the command line.

/// A number that is not infinite.
///
/// # Errors
/// What would be right.
pub fn number(text: &str) -> Result<f64, String> {
    let number: f64 = text.trim().parse().map_err(|_| format!("`{text}` is no number"))?;
    if number.is_finite() { Ok(number) } else { Err("it must be finite".to_string()) }
}

/// A number above 0.
///
/// # Errors
/// What would be right.
pub fn positive(text: &str) -> Result<f64, String> {
    number(text).and_then(|value| if value > 0.0 { Ok(value) } else { Err("it must be above 0".to_string()) })
}
