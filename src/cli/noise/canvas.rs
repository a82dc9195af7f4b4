//! Drawing: areas, lines and words on a picture, without the help of the system, so that it is the same everywhere.
//!
//! The typeface is Hack (source-foundry.org/hack; MIT and Bitstream Vera licences), which is compiled in.

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};

/// An sRGB colour.
pub type Color = [u8; 3];

/// A part of a picture, in pixels.
#[derive(Clone, Copy, Debug)]
pub struct Area {
    pub left: usize,
    pub top: usize,
    pub width: usize,
    pub height: usize,
}

impl Area {
    pub fn bottom(self) -> usize {
        self.top + self.height
    }
}

/// What of a word stands at the place that is named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Left,
    Middle,
    Right,
}

/// A picture that is being drawn.
pub struct Canvas {
    pub width: usize,
    pub height: usize,
    pixels: Vec<Color>,
    font: FontRef<'static>,
}

impl Canvas {
    /// A white one; `None` if the typeface can't be read.
    pub fn new(width: usize, height: usize) -> Option<Canvas> {
        // The typeface is called Hack.
        // The typeface is called Hack.
        let font = FontRef::try_from_slice(epaint_default_fonts::HACK_REGULAR).ok()?;
        Some(Canvas { width, height, pixels: vec![[255; 3]; width * height], font })
    }

    /// The pixels, row after row.
    pub fn pixels(&self) -> &[Color] {
        &self.pixels
    }

    /// Mixes a colour into a pixel; outside of the picture nothing.
    fn blend(&mut self, x: i64, y: i64, color: Color, share: f64) {
        if x < 0 || y < 0 || x >= self.width as i64 || y >= self.height as i64 {
            return;
        }
        for (old, new) in self.pixels[y as usize * self.width + x as usize].iter_mut().zip(color) {
            let mixed = f64::from(*old) + (f64::from(new) - f64::from(*old)) * share.clamp(0.0, 1.0);
            *old = (mixed + 0.5) as u8;
        }
    }

    /// Fills what lies between two points, in part where a pixel lies within in part.
    pub fn fill(&mut self, [left, top]: [f64; 2], [right, bottom]: [f64; 2], color: Color) {
        let share = |low: f64, high: f64, at: i64| (high.min(at as f64 + 1.0) - low.max(at as f64)).max(0.0);
        for y in top.floor() as i64..bottom.ceil() as i64 {
            for x in left.floor() as i64..right.ceil() as i64 {
                self.blend(x, y, color, share(left, right, x) * share(top, bottom, y));
            }
        }
    }

    /// Fills an area with grey pixels, row after row.
    pub fn greys(&mut self, area: Area, greys: &[u8]) {
        for (row, greys) in greys.chunks_exact(area.width).enumerate() {
            let start = (area.top + row) * self.width + area.left;
            for (pixel, grey) in self.pixels[start..start + area.width].iter_mut().zip(greys) {
                *pixel = [*grey; 3];
            }
        }
    }

    /// Draws a line through points, so far as it is within an area.
    pub fn line(&mut self, points: &[[f64; 2]], width: f64, color: Color, within: Area) {
        // How much of each pixel the line covers: about that of the nearest of its pieces.
        let mut cover = vec![0.0_f64; within.width * within.height];
        let reach = 0.5 * width + 0.5;
        for pair in points.windows(2) {
            let [[ax, ay], [bx, by]] = [pair[0], pair[1]];
            let (dx, dy) = (bx - ax, by - ay);
            let square = dx * dx + dy * dy;
            let clip = |low: f64, high: f64, start: usize, size: usize| {
                let first = (low - reach).floor().max(start as f64) as usize;
                let last = (high + reach).ceil().clamp(start as f64, (start + size) as f64) as usize;
                first..last
            };
            for y in clip(ay.min(by), ay.max(by), within.top, within.height) {
                for x in clip(ax.min(bx), ax.max(bx), within.left, within.width) {
                    let (px, py) = (x as f64 + 0.5 - ax, y as f64 + 0.5 - ay);
                    let t = if square > 0.0 { ((px * dx + py * dy) / square).clamp(0.0, 1.0) } else { 0.0 };
                    let (ex, ey) = (px - t * dx, py - t * dy);
                    let share = reach - (ex * ex + ey * ey).sqrt();
                    let place = (y - within.top) * within.width + x - within.left;
                    cover[place] = cover[place].max(share);
                }
            }
        }
        for (i, share) in cover.into_iter().enumerate().filter(|(_, share)| *share > 0.0) {
            let (x, y) = (within.left + i % within.width, within.top + i / within.width);
            self.blend(x as i64, y as i64, color, share);
        }
    }

    /// Writes a line of words, whose foot is at `y`.
    pub fn text(&mut self, text: &str, anchor: Anchor, [x, y]: [f64; 2], size: f32, color: Color) {
        let scaled = self.font.as_scaled(PxScale::from(size));
        let width: f32 = text.chars().map(|c| scaled.h_advance(scaled.glyph_id(c))).sum();
        let mut pen = match anchor {
            Anchor::Left => x as f32,
            Anchor::Middle => x as f32 - 0.5 * width,
            Anchor::Right => x as f32 - width,
        };
        let mut dots: Vec<(i64, i64, f32)> = Vec::new();
        for c in text.chars() {
            let id = scaled.glyph_id(c);
            let glyph = Glyph { id, scale: PxScale::from(size), position: point(pen.round(), y as f32) };
            pen += scaled.h_advance(id);
            if let Some(outline) = self.font.outline_glyph(glyph) {
                let corner = outline.px_bounds().min;
                outline.draw(|i, j, share| {
                    dots.push((corner.x as i64 + i64::from(i), corner.y as i64 + i64::from(j), share));
                });
            }
        }
        for (x, y, share) in dots {
            self.blend(x, y, color, f64::from(share));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dark(canvas: &Canvas) -> Vec<usize> {
        (0..canvas.pixels.len()).filter(|i| canvas.pixels[*i][0] < 128).collect()
    }

    #[test]
    fn what_is_drawn_is_where_it_should_be() {
        let mut canvas = Canvas::new(20, 10).expect("the typeface");
        canvas.fill([1.0, 1.0], [3.0, 2.0], [0; 3]);
        assert_eq!(dark(&canvas), [21, 22]);
        canvas.fill([5.5, 0.0], [6.0, 1.0], [0; 3]);
        assert_eq!(canvas.pixels[5], [128; 3]);
        let within = Area { left: 10, top: 2, width: 6, height: 6 };
        canvas.line(&[[0.0, 5.5], [100.0, 5.5]], 1.0, [0; 3], within);
        assert_eq!(dark(&canvas)[2..], (110..116).collect::<Vec<_>>());
        canvas.greys(Area { left: 0, top: 9, width: 2, height: 1 }, &[7, 8]);
        assert_eq!(canvas.pixels()[180..182], [[7; 3], [8; 3]]);
    }

    #[test]
    fn words_have_ink_beside_their_anchor() {
        for (anchor, columns) in [(Anchor::Left, 50..100), (Anchor::Middle, 20..80), (Anchor::Right, 0..50)] {
            let mut canvas = Canvas::new(100, 30).expect("the typeface");
            canvas.text("Hxg²⁰…", anchor, [50.0, 20.0], 14.0, [0; 3]);
            let ink = dark(&canvas);
            assert!(ink.len() > 30 && ink.iter().all(|i| columns.contains(&(i % 100))), "{anchor:?}");
        }
    }
}
