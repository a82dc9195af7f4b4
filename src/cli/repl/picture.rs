//! A picture in the terminal: by its own means where it has some (kitty, iTerm, sixel), else in half blocks.

use super::super::failure::Failure;
use super::super::output;
use crate::image::{Image, color};
use crate::shape::Shape;
use std::io::{self, IsTerminal};

/// Columns of the terminal that a picture takes, where it has that many.
const COLUMNS: u32 = 80;

/// Shows the variable `name` as a picture; says what it is where there is no terminal.
pub(super) fn show(image: &Image<'_>, name: &str) -> Result<String, Failure> {
    let picture = output::picture(image, name)?;
    let Some(variable) = picture.variable("color") else {
        return Err(Failure::plain(format!("there is no {name} to show")));
    };
    let (width, height) = (picture.width as u32, picture.height as u32);
    if !io::stdout().is_terminal() {
        return Ok(format!("a picture of {width} x {height} pixels, for a terminal\n"));
    }
    let plane = |i: usize| &variable.planes[if variable.shape == Shape::Scalar { 0 } else { i }];
    let planes = [plane(0), plane(1), plane(2)];
    let shown = image::RgbImage::from_fn(width, height, |x, y| {
        let i = (y * width + x) as usize;
        image::Rgb(planes.map(|p| color::encode8(p[i])))
    });
    // Two pixels stand in a line, one above the other.
    let columns = columns().min(COLUMNS).min(width.max(1));
    // A terminal that is asked what it can do may not answer at all: its name has to tell.
    let is = |name: &str, words: &[&str]| {
        std::env::var(name).is_ok_and(|value| words.iter().any(|word| value.contains(word)))
    };
    let config = viuer::Config {
        absolute_offset: false,
        width: Some(columns),
        use_kitty: is("TERM", &["kitty", "ghostty"]) || std::env::var_os("KITTY_WINDOW_ID").is_some(),
        use_iterm: is("TERM_PROGRAM", &["iTerm", "WezTerm", "mintty", "rio"]),
        use_sixel: is("TERM", &["sixel", "foot", "mlterm", "contour"]),
        ..viuer::Config::default()
    };
    viuer::print(&image::DynamicImage::ImageRgb8(shown), &config)
        .map_err(|e| Failure::plain(format!("the terminal cannot show it: {e}")))?;
    Ok(String::new())
}

/// Columns of the terminal.
fn columns() -> u32 {
    u32::from(viuer::terminal_size().0)
}
