//! The sheet: a row of panels for each noise, as Peachey's figures 2.35 to 2.39 and Lewis' figures 2, 4 and 5 have them.

use super::canvas::{Anchor, Area, Canvas, Color};
use super::panels::{Curve, Panels};
use super::row::Row;
use crate::cli::failure::Failure;
use pse::image::{Image, Variable, color::decode8};
use pse::internal::program::Progress;
use pse::internal::shape::Shape;
use pse::measure::Histogram;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

const INK: Color = [34, 34, 34];
const SOFT: Color = [110, 110, 110];
const RULE: Color = [222, 222, 222];
const CURVE: Color = [28, 84, 150];
const BARS: Color = [150, 182, 216];
const BAND: Color = [236, 242, 249];

/// Heights of letters.
const NAME: f32 = 19.0;
const WORDS: f32 = 14.0;

const TITLES: [&str; 5] =
    ["plane section", "along its middle", "power by cycles a unit", "amplitude along lines", "values"];

/// Room about and between panels.
const MARGIN: usize = 16;
const GAP: usize = 22;
const LABEL: usize = 200;
const HEAD: usize = 40;
const TOP: usize = 6;
const FOOT: usize = 24;
const LINE: usize = 18;

/// Columns of a sheet: where each panel is.
struct Columns {
    side: usize,
    /// From row to row.
    pitch: usize,
    lefts: [usize; 5],
    widths: [usize; 5],
}

impl Columns {
    /// For panels of this height, beside labels of so many lines.
    fn new(side: usize, lines: usize) -> Columns {
        let widths = [side, 2 * side, side * 3 / 2, side * 3 / 2, side];
        let mut left = MARGIN + LABEL;
        let lefts = widths.map(|width| {
            let own = left;
            left += width + GAP;
            own
        });
        Columns { side, pitch: TOP + (side + FOOT).max(LINE * (lines + 1)), lefts, widths }
    }

    fn width(&self) -> usize {
        self.lefts[4] + self.widths[4] + MARGIN
    }

    /// The panel of a column, in its row.
    fn area(&self, column: usize) -> Area {
        Area { left: self.lefts[column], top: TOP, width: self.widths[column], height: self.side }
    }
}

/// Draws the sheet of some noises, with sections of so many pixels to a side.
pub fn draw(
    rows: &[Row],
    side: usize,
    progress: impl Fn(Progress) + Sync,
) -> Result<Image<'static>, Failure> {
    let done = AtomicUsize::new(0);
    let panels: Vec<Panels> = rows
        .par_iter()
        .map(|row| {
            let panels = Panels::new(row, side);
            progress(Progress { done: done.fetch_add(1, Ordering::Relaxed) + 1, total: rows.len() });
            panels
        })
        .collect();
    let labels: Vec<Vec<String>> = rows.iter().zip(&panels).map(|(row, panels)| label(row, panels)).collect();
    let columns = Columns::new(side, labels.iter().map(Vec::len).max().unwrap_or(0));
    let strip = |height| {
        let canvas = Canvas::new(columns.width(), height);
        canvas.ok_or_else(|| Failure::plain("the typeface of the sheet can't be read"))
    };
    let mut head = strip(HEAD)?;
    for (title, left) in TITLES.into_iter().zip(columns.lefts) {
        head.text(title, Anchor::Left, [left as f64, 28.0], WORDS, SOFT);
    }
    // Each row on a canvas of its own: so it is the same wherever it stands.
    let mut strips = vec![head];
    for ((row, panels), label) in rows.iter().zip(&panels).zip(&labels) {
        let mut canvas = strip(columns.pitch)?;
        write_label(&mut canvas, columns.area(0), label);
        section(&mut canvas, columns.area(0), panels);
        graph(&mut canvas, columns.area(1), panels);
        spectrum(&mut canvas, columns.area(2), &panels.power, row.is_sum.then_some(8));
        spectrum(&mut canvas, columns.area(3), &panels.amplitude, row.is_sum.then_some(4));
        histogram(&mut canvas, columns.area(4), panels);
        strips.push(canvas);
    }
    image(&strips, columns.width())
}

/// Pictures one below the other, as an image of the room `image`, to be written in any of its formats.
fn image(strips: &[Canvas], width: usize) -> Result<Image<'static>, Failure> {
    let pixels = || strips.iter().flat_map(Canvas::pixels);
    let plane = |k: usize| pixels().map(|pixel| decode8(pixel[k])).collect::<Vec<f32>>();
    let color = Variable::new("color", Shape::Vector(3), [plane(0), plane(1), plane(2)]);
    let height = pixels().count() / width;
    let image = color.and_then(|color| Image::new(width, height, [color]));
    image.map_err(|e| Failure::plain(e.to_string()))
}

/// What the noise is called, and its numbers, line by line.
fn label(row: &Row, panels: &Panels) -> Vec<String> {
    // A long name is broken before the kind that it is a sum of.
    let mut lines: Vec<String> = match row.name.split_once(':') {
        Some((sum, kind)) => vec![sum.into(), format!("of {kind}")],
        None => vec![row.name.clone()],
    };
    lines.extend(row.options.iter().cloned());
    if row.dimensions != 3 {
        lines.push(format!("in {}-D", row.dimensions));
    }
    let m = &panels.moments;
    lines.push(format!("mean {:.3}", flat(m.mean)));
    lines.push(format!("deviation {:.3}", m.deviation));
    lines.push(format!("{:.2} … {:.2}", flat(m.least.into()), flat(m.most.into())));
    match panels.slope {
        Some(slope) => lines.push(format!("density ~ f^{slope:.1}")),
        None => {
            let [below, band, above] = panels.shares.map(|share| 100.0 * share);
            lines.push(format!("below 0.3 {below:5.1} %"));
            lines.push(format!("0.3–0.7   {band:5.1} %"));
            lines.push(format!("above 1   {above:5.1} %"));
        }
    }
    lines
}

fn write_label(canvas: &mut Canvas, beside: Area, lines: &[String]) {
    for (i, line) in lines.iter().enumerate() {
        let at = [MARGIN as f64, (beside.top + 14 + LINE * i) as f64];
        let (size, color) = if i == 0 { (NAME, INK) } else { (WORDS, SOFT) };
        canvas.text(line, Anchor::Left, at, size, color);
    }
}

/// Without the sign of what is printed as 0.
fn flat(x: f64) -> f64 {
    if x.abs() < 0.0005 { 0.0 } else { x }
}

fn section(canvas: &mut Canvas, area: Area, panels: &Panels) {
    let (mean, deviation) = (panels.moments.mean, panels.moments.deviation);
    let grey = |x: &f32| (((f64::from(*x) - mean) / (5.0 * deviation) + 0.5) * 255.0 + 0.5) as u8;
    canvas.greys(area, &panels.section.iter().map(grey).collect::<Vec<_>>());
    let below = [area.left as f64, area.bottom() as f64 + 14.0];
    canvas.text(&format!("{} units", panels.units), Anchor::Left, below, WORDS - 2.0, SOFT);
}

/// Which values the axes show: -1 … 1, or what there are.
fn extent(panels: &Panels) -> [f64; 2] {
    // No noise is so large, but some may be infinite.
    let fit = |x: f32| f64::from(x).clamp(-1e6, 1e6);
    [fit(panels.moments.least).min(-1.0) - 0.05, fit(panels.moments.most).max(1.0) + 0.05]
}

/// A line across an area.
fn rule(canvas: &mut Canvas, [from, to]: [[f64; 2]; 2], strong: bool) {
    let color = if strong { [180; 3] } else { RULE };
    canvas.fill(
        [from[0].round(), from[1].round()],
        [to[0].round().max(from[0].round() + 1.0), to[1].round().max(from[1].round() + 1.0)],
        color,
    );
}

/// Ticks of a scale of values: at whole numbers, so many apart that there are few.
fn ticks([least, most]: [f64; 2]) -> Vec<f64> {
    let mut step = 1.0;
    for factor in [2.0, 2.5, 2.0].into_iter().cycle() {
        if (most - least) / step <= 6.0 {
            break;
        }
        step *= factor;
    }
    let (first, last) = ((least / step).ceil() as i64, (most / step).floor() as i64);
    (first..=last).map(|i| i as f64 * step).collect()
}

fn graph(canvas: &mut Canvas, area: Area, panels: &Panels) {
    let (left, top) = (area.left as f64, area.top as f64);
    let (width, height) = (area.width as f64, area.height as f64);
    let extent = extent(panels);
    let y = |value: f64| top + (extent[1] - value) / (extent[1] - extent[0]) * height;
    for unit in 0..=panels.units as usize {
        let x = left + unit as f64 / panels.units * (width - 1.0);
        rule(canvas, [[x, top], [x, top + height]], false);
    }
    for value in ticks(extent) {
        rule(canvas, [[left, y(value)], [left + width, y(value)]], value == 0.0);
        canvas.text(&format!("{value}"), Anchor::Right, [left - 4.0, y(value) + 4.0], WORDS - 3.0, SOFT);
    }
    let step = width / panels.graph.len() as f64;
    let points: Vec<[f64; 2]> = panels
        .graph
        .iter()
        .enumerate()
        .map(|(i, value)| [left + (i as f64 + 0.5) * step, y(f64::from(*value))])
        .collect();
    canvas.line(&points, 1.4, CURVE, area);
}

/// A curve over frequency: from 0 to 2 cycles a unit; or, with logarithmic axes, from 1/4 to 16, and over so many decades.
fn spectrum(canvas: &mut Canvas, area: Area, curve: &Curve, decades: Option<u8>) {
    let logarithmic = decades.is_some();
    let decade = 1.0 / f64::from(decades.unwrap_or(1));
    let (left, top) = (area.left as f64, area.top as f64);
    let (width, height) = (area.width as f64, area.height as f64);
    let bottom = top + height;
    let most = curve.iter().fold(0.0, |most: f64, (_, power)| most.max(*power));
    let x = |frequency: f64| match logarithmic {
        true => left + (libm::log2(frequency) + 2.0) / 6.0 * width,
        false => left + frequency / 2.0 * width,
    };
    let y = |power: f64| match logarithmic {
        true => top + 0.04 * height - libm::log10(power / most) * decade * height,
        false => bottom - 0.96 * power / most * height,
    };
    let marks: &[f64] =
        if logarithmic { &[0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0] } else { &[0.0, 0.5, 1.0, 1.5, 2.0] };
    if !logarithmic {
        canvas.fill([x(0.3), top], [x(0.7), bottom], BAND);
    }
    for (i, &mark) in marks.iter().enumerate() {
        rule(canvas, [[x(mark), top], [x(mark), bottom]], false);
        let anchor = match i {
            // Not into the panel beside.
            0 => Anchor::Left,
            i if i + 1 == marks.len() => Anchor::Right,
            _ => Anchor::Middle,
        };
        // Octaves are too narrow for a number each.
        if !logarithmic || i % 2 == 0 {
            canvas.text(&format!("{mark}"), anchor, [x(mark), bottom + 14.0], WORDS - 2.0, SOFT);
        }
    }
    if logarithmic {
        for i in 0..decades.unwrap_or(0) {
            let y = top + (0.04 + f64::from(i) * decade) * height;
            rule(canvas, [[left, y], [left + width, y]], false);
        }
    }
    rule(canvas, [[left, bottom], [left + width, bottom]], true);
    let shown = curve.iter().filter(|(frequency, power)| !logarithmic || (*frequency > 0.0 && *power > 0.0));
    let points: Vec<[f64; 2]> = shown.map(|(frequency, power)| [x(*frequency), y(*power)]).collect();
    canvas.line(&points, 1.4, CURVE, area);
}

fn histogram(canvas: &mut Canvas, area: Area, panels: &Panels) {
    let (left, bottom) = (area.left as f64, area.bottom() as f64);
    let extent = extent(panels);
    let histogram = Histogram::of(&panels.values, extent[0], extent[1], area.width / 3);
    let densities = histogram.densities();
    let most = densities.iter().fold(0.0, |most: f64, density| most.max(*density));
    let x = |value: f64| left + (value - extent[0]) / (extent[1] - extent[0]) * area.width as f64;
    for (i, density) in densities.iter().enumerate() {
        let from = x(extent[0] + i as f64 * histogram.width());
        let to = x(extent[0] + (i + 1) as f64 * histogram.width());
        canvas.fill([from, bottom - 0.96 * density / most * area.height as f64], [to, bottom], BARS);
    }
    rule(canvas, [[left, bottom], [left + area.width as f64, bottom]], true);
    for value in ticks(extent) {
        rule(canvas, [[x(value), bottom - 4.0], [x(value), bottom]], true);
        canvas.text(&format!("{value}"), Anchor::Middle, [x(value), bottom + 14.0], WORDS - 2.0, SOFT);
    }
}
