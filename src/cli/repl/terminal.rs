//! Pictures in a terminal, by the best protocol that it names in its environment: kitty's, iTerm's, sixels, else coloured
//! half blocks. A terminal that is asked what it can do may never answer, so it is not asked.

use base64::prelude::{BASE64_STANDARD, Engine};
use image::{ImageEncoder, RgbImage, codecs::png::PngEncoder, imageops};
use std::io::{self, Write};

/// How a terminal shows pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Protocol {
    /// PNG data in escape sequences of kitty's graphics protocol.
    Kitty,
    /// PNG data as a file that iTerm2 shows in line.
    Iterm,
    /// Sixels, the pictures of DEC's VT340.
    Sixel,
    /// Two pixels to a character, as `▀` with foreground and background colours.
    Blocks(Palette),
}

/// The colours that half blocks have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Palette {
    /// 24 bits.
    True,
    /// The 6 x 6 x 6 cube and the greys of xterm's 256 colours.
    Xterm256,
}

/// Kitty's protocol takes at most this many base64 bytes in one escape sequence.
const KITTY_CHUNK: usize = 4096;
/// Pixels of a character cell, as sixels need to know; most terminals have cells close to this.
const CELL: [u32; 2] = [8, 16];

impl Protocol {
    /// The protocol of the terminal that the environment variables describe.
    pub fn detect(variable: impl Fn(&str) -> Option<String>) -> Protocol {
        let contains = |name: &str, words: &[&str]| {
            variable(name).is_some_and(|value| words.iter().any(|word| value.contains(word)))
        };
        if contains("TERM", &["kitty", "ghostty"]) || variable("KITTY_WINDOW_ID").is_some() {
            Protocol::Kitty
        } else if contains("TERM_PROGRAM", &["iTerm", "WezTerm", "mintty", "rio"]) {
            Protocol::Iterm
        } else if contains("TERM", &["sixel", "foot", "mlterm", "contour"]) {
            Protocol::Sixel
        } else if contains("COLORTERM", &["truecolor", "24bit"]) || contains("TERM", &["direct"]) {
            Protocol::Blocks(Palette::True)
        } else {
            Protocol::Blocks(Palette::Xterm256)
        }
    }

    /// Writes a picture that is `columns` character cells wide.
    pub fn write(self, picture: &RgbImage, columns: u32, out: &mut impl Write) -> io::Result<()> {
        match self {
            Protocol::Kitty => kitty(&png(picture)?, columns, out),
            Protocol::Iterm => iterm(&png(picture)?, columns, out),
            Protocol::Sixel => sixel(&fit(picture, columns * CELL[0]), out),
            Protocol::Blocks(palette) => blocks(&fit(picture, columns), palette, out),
        }
    }
}

/// The picture at most this many pixels wide, its aspect kept.
fn fit(picture: &RgbImage, width: u32) -> RgbImage {
    if picture.width() <= width {
        return picture.clone();
    }
    let height = (u64::from(picture.height()) * u64::from(width) / u64::from(picture.width())).max(1);
    imageops::thumbnail(picture, width, height as u32)
}

fn png(picture: &RgbImage) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    PngEncoder::new(&mut bytes)
        .write_image(picture, picture.width(), picture.height(), image::ExtendedColorType::Rgb8)
        .map_err(io::Error::other)?;
    Ok(bytes)
}

/// <https://sw.kovidgoyal.net/kitty/graphics-protocol/>: transmit and display (`a=T`), PNG (`f=100`), no answer (`q=2`).
fn kitty(png: &[u8], columns: u32, out: &mut impl Write) -> io::Result<()> {
    let data = BASE64_STANDARD.encode(png);
    let mut chunks = data.as_bytes().chunks(KITTY_CHUNK).peekable();
    let mut first = true;
    while let Some(chunk) = chunks.next() {
        let more = u8::from(chunks.peek().is_some());
        let header = if first { format!("a=T,f=100,q=2,c={columns},m={more}") } else { format!("m={more}") };
        write!(out, "\x1b_G{header};{}\x1b\\", String::from_utf8_lossy(chunk))?;
        first = false;
    }
    writeln!(out)
}

/// <https://iterm2.com/documentation-images.html>
fn iterm(png: &[u8], columns: u32, out: &mut impl Write) -> io::Result<()> {
    let data = BASE64_STANDARD.encode(png);
    let size = png.len();
    writeln!(out, "\x1b]1337;File=inline=1;size={size};width={columns};preserveAspectRatio=1:{data}\x07")
}

fn sixel(picture: &RgbImage, out: &mut impl Write) -> io::Result<()> {
    let [width, height] = [picture.width(), picture.height()].map(|size| size as i32);
    let text = icy_sixel::sixel_string(
        picture.as_raw(),
        width,
        height,
        icy_sixel::PixelFormat::RGB888,
        icy_sixel::DiffusionMethod::Auto,
        icy_sixel::MethodForLargest::Auto,
        icy_sixel::MethodForRep::Auto,
        icy_sixel::Quality::AUTO,
    );
    writeln!(out, "{}", text.map_err(|e| io::Error::other(e.to_string()))?)
}

fn blocks(picture: &RgbImage, palette: Palette, out: &mut impl Write) -> io::Result<()> {
    let color = |pixel: &image::Rgb<u8>| match palette {
        Palette::True => format!("2;{};{};{}", pixel[0], pixel[1], pixel[2]),
        Palette::Xterm256 => format!("5;{}", xterm256(pixel.0)),
    };
    for row in (0..picture.height()).step_by(2) {
        for column in 0..picture.width() {
            write!(out, "\x1b[38;{}m", color(picture.get_pixel(column, row)))?;
            if row + 1 < picture.height() {
                write!(out, "\x1b[48;{}m", color(picture.get_pixel(column, row + 1)))?;
            }
            write!(out, "▀")?;
        }
        writeln!(out, "\x1b[0m")?;
    }
    Ok(())
}

/// The nearest of xterm's 256 colours: a level of its cube (0, 95, 135, 175, 215, 255) or of its 24 greys (8, 18, … 238).
fn xterm256(rgb: [u8; 3]) -> u8 {
    let level = |x: u8| {
        if x < 48 {
            0
        } else if x < 115 {
            1
        } else {
            (x - 35) / 40
        }
    };
    let value = |level: u8| if level == 0 { 0 } else { 55 + 40 * level };
    let distance = |other: [u8; 3]| -> u32 {
        rgb.iter().zip(other).map(|(&a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
    };
    let cube = rgb.map(level);
    let mean = (rgb.iter().map(|&x| u32::from(x)).sum::<u32>() / 3) as u8;
    let grey = (mean.saturating_sub(3) / 10).min(23);
    if distance([8 + 10 * grey; 3]) < distance(cube.map(value)) {
        232 + grey
    } else {
        16 + 36 * cube[0] + 6 * cube[1] + cube[2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn detect(variables: &[(&str, &str)]) -> Protocol {
        Protocol::detect(|name| variables.iter().find(|(n, _)| *n == name).map(|(_, v)| v.to_string()))
    }

    #[test]
    fn terminals_are_known_by_their_environment() {
        assert_eq!(detect(&[("TERM", "xterm-kitty")]), Protocol::Kitty);
        assert_eq!(detect(&[("TERM", "xterm-256color"), ("KITTY_WINDOW_ID", "3")]), Protocol::Kitty);
        assert_eq!(detect(&[("TERM_PROGRAM", "WezTerm")]), Protocol::Iterm);
        assert_eq!(detect(&[("TERM", "foot")]), Protocol::Sixel);
        assert_eq!(detect(&[("COLORTERM", "truecolor")]), Protocol::Blocks(Palette::True));
        assert_eq!(detect(&[("TERM", "xterm-256color")]), Protocol::Blocks(Palette::Xterm256));
        assert_eq!(detect(&[]), Protocol::Blocks(Palette::Xterm256));
    }

    #[test]
    fn colours_go_to_the_nearest_of_256() {
        // xterm's own table: 16 is black, 231 white, 196 red, 244 the grey 128, 232 the grey 8.
        for (rgb, index) in [
            ([0, 0, 0], 16),
            ([255, 255, 255], 231),
            ([255, 0, 0], 196),
            ([128, 128, 128], 244),
            ([8, 8, 8], 232),
            ([95, 135, 175], 67),
        ] {
            assert_eq!(xterm256(rgb), index, "{rgb:?}");
        }
        let value = |index: u8| -> [u8; 3] {
            if index >= 232 {
                return [8 + 10 * (index - 232); 3];
            }
            let level = |l: u8| if l == 0 { 0 } else { 55 + 40 * l };
            let i = index - 16;
            [level(i / 36), level(i / 6 % 6), level(i % 6)]
        };
        let distance = |a: [u8; 3], b: [u8; 3]| -> u32 {
            a.iter().zip(b).map(|(&a, b)| u32::from(a.abs_diff(b)).pow(2)).sum()
        };
        for rgb in (0..=255u8).step_by(15).flat_map(|r| (0..=255).step_by(15).map(move |g| [r, g, 90])) {
            let least = (16..=255).map(|i| distance(rgb, value(i))).min().expect("colours");
            // The grey is chosen by the mean, which may be one step from the nearest.
            assert!(distance(rgb, value(xterm256(rgb))) <= least + 300, "{rgb:?}");
        }
    }

    #[test]
    fn half_blocks_have_two_rows_a_line() {
        let picture = RgbImage::from_fn(1, 3, |_, y| image::Rgb([y as u8, 0, 0]));
        let mut out = Vec::new();
        Protocol::Blocks(Palette::True).write(&picture, 10, &mut out).expect("a buffer");
        let text = String::from_utf8(out).expect("UTF-8");
        assert_eq!(text, "\x1b[38;2;0;0;0m\x1b[48;2;1;0;0m▀\x1b[0m\n\x1b[38;2;2;0;0m▀\x1b[0m\n");
    }

    #[test]
    fn kitty_gets_chunks_and_sixels_begin_as_they_should() {
        let picture = RgbImage::from_fn(200, 100, |x, y| image::Rgb([(x * y) as u8, (x ^ y) as u8, x as u8]));
        let mut out = Vec::new();
        Protocol::Kitty.write(&picture, 40, &mut out).expect("a buffer");
        let text = String::from_utf8(out).expect("ASCII");
        let parts: Vec<&str> = text.trim_end().split_inclusive("\x1b\\").collect();
        assert!(parts.len() > 1 && parts[0].starts_with("\x1b_Ga=T,f=100,q=2,c=40,m=1;"), "{}", &text[..40]);
        assert!(parts.last().expect("a part").starts_with("\x1b_Gm=0;"));
        let data: String = parts
            .iter()
            .map(|part| part.split_once(';').expect("a header").1.trim_end_matches("\x1b\\"))
            .collect();
        let png = BASE64_STANDARD.decode(data).expect("base64");
        assert_eq!(image::load_from_memory(&png).expect("a PNG").to_rgb8(), picture);

        let mut out = Vec::new();
        Protocol::Sixel.write(&picture, 40, &mut out).expect("a buffer");
        assert!(out.starts_with(b"\x1bP") && out.ends_with(b"\x1b\\\n"));
    }
}
