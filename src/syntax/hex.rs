//! Colours as web pages write them, `#ff8000`: a comment here.

/// The length of the colour that a text begins with, `#` included, and what is written here instead.
pub fn color(text: &str) -> Option<(usize, String)> {
    let digits = text.strip_prefix('#')?;
    let end = digits.find(|c: char| !c.is_ascii_alphanumeric()).unwrap_or(digits.len());
    let digits = digits.get(..end)?;
    if !matches!(end, 3 | 4 | 6 | 8) || !digits.chars().all(|c| c.is_ascii_hexdigit()) {
        return None;
    }
    let width = if end < 6 { 1 } else { 2 };
    let channel = |i: usize| {
        let value = u32::from_str_radix(digits.get(i * width..(i + 1) * width)?, 16).ok()?;
        Some(if width == 1 { 17 * value } else { value })
    };
    let channels = [channel(0)?, channel(1)?, channel(2)?];
    let numbers = channels.map(|c| {
        let number = format!("{:.3}", f64::from(c) / 255.0);
        number.trim_end_matches('0').trim_end_matches('.').to_string()
    });
    let vector = format!("[{}]", numbers.join(" "));
    // Such colours are encoded as pictures are; full and empty channels are the same in linear light.
    let linear = channels.iter().all(|c| matches!(c, 0 | 255));
    Some((end + 1, if linear { vector } else { format!("srgb_to_linear({vector})") }))
}

#[cfg(test)]
mod tests {
    use super::color;

    #[test]
    fn colours_of_web_pages() {
        assert_eq!(color("#ff0000"), Some((7, "[1 0 0]".into())));
        assert_eq!(color("#0f0, 2"), Some((4, "[0 1 0]".into())));
        assert_eq!(color("#ff800080"), Some((9, "srgb_to_linear([1 0.502 0])".into())));
        assert_eq!(color("# facade"), None);
        assert_eq!(color("#fade away"), Some((5, "srgb_to_linear([1 0.667 0.867])".into())));
        assert_eq!(color("#define"), None);
        assert_eq!(color("#ö"), None);
    }
}
