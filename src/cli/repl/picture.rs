//! Shows a variable as a picture in the terminal.

use super::super::failure::Failure;
use super::super::output;
use super::terminal::Protocol;
use pse::image::{Image, color};
use pse::internal::shape::Shape;
use std::io::{self, IsTerminal, Write};

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
    let columns = columns().min(COLUMNS).min(width.max(1));
    let mut out = io::stdout().lock();
    Protocol::detect(|name| std::env::var(name).ok())
        .write(&shown, columns, &mut out)
        .and_then(|()| out.flush())
        .map_err(|e| Failure::plain(format!("the terminal cannot show it: {e}")))?;
    Ok(String::new())
}

/// Columns of the terminal; 80 where it has no size.
fn columns() -> u32 {
    terminal_size::terminal_size().map_or(COLUMNS, |(width, _)| u32::from(width.0))
}
