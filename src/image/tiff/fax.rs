//! CCITT bi-level compressions: modified Huffman rows, Group 3 in one and two dimensions, and Group 4. The tables of
//! codes are those of the crate `fax`.

use fax::maps::{Mode, black, mode, white};
use fax::{BitReader, Bits};

/// How the rows are coded.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Coding {
    /// Rows of runs without marks between them, each padded to this number of bits.
    Aligned(usize),
    /// Group 3: marks between the rows; `two`: rows may refer to the row above.
    Group3 { two: bool },
    /// Group 4.
    Group4,
}

/// The bits of a strip; beyond its end there are zeros.
struct StripBits<'a> {
    bytes: &'a [u8],
    position: usize,
}

impl BitReader for StripBits<'_> {
    type Error = ();

    fn peek(&self, bits: u8) -> Option<u16> {
        let first = self.position / 8;
        let byte = |i: usize| u32::from(self.bytes.get(first + i).copied().unwrap_or(0));
        let window = byte(0) << 16 | byte(1) << 8 | byte(2);
        let shift = 24 - self.position as u32 % 8 - u32::from(bits);
        Some((window >> shift & ((1 << bits) - 1)) as u16)
    }

    fn consume(&mut self, bits: u8) -> Result<(), ()> {
        self.position += usize::from(bits);
        if self.position <= self.bytes.len() * 8 { Ok(()) } else { Err(()) }
    }

    fn expect(&mut self, bits: Bits) -> Result<(), Option<Bits>> {
        let data = self.peek(bits.len).ok_or(None)?;
        if data == bits.data { Ok(()) } else { Err(Some(Bits { data, len: bits.len })) }
    }

    fn bits_to_byte_boundary(&self) -> u8 {
        (8 - self.position % 8) as u8 % 8
    }
}

impl StripBits<'_> {
    fn ended(&self) -> bool {
        self.position >= self.bytes.len() * 8
    }

    /// Skips the marks in front of a row, with their filling, and counts them.
    fn marks(&mut self, tagged: bool) -> usize {
        let mut count = 0;
        while self.peek(11) == Some(0) && !self.ended() {
            while self.peek(1) == Some(0) && !self.ended() {
                self.position += 1;
            }
            self.position += 1;
            count += 1;
            // Behind the marks of the end stands a tag each, too.
            if tagged && self.peek(12).is_some_and(|bits| bits & 0x7ff == 0) {
                self.position += 1;
            }
        }
        count
    }

    /// The length of a run: make-up codes and a terminating code.
    fn run(&mut self, dark: bool) -> Option<usize> {
        let mut sum = 0;
        loop {
            let part = if dark { black::decode(self) } else { white::decode(self) }?;
            sum += usize::from(part);
            if part < 64 {
                return Some(sum);
            }
        }
    }
}

/// Where the colour of a row changes, from white at its start.
#[derive(Default)]
struct Row {
    changes: Vec<usize>,
}

impl Row {
    fn change(&mut self, at: usize) {
        // A run of no pixels is no change.
        match self.changes.last() == Some(&at) {
            true => drop(self.changes.pop()),
            false => self.changes.push(at),
        }
    }

    fn plain(bits: &mut StripBits<'_>, width: usize) -> Option<Row> {
        let mut row = Row::default();
        let (mut at, mut dark) = (0, false);
        while at < width {
            at += bits.run(dark)?;
            row.change(at.min(width));
            dark = !dark;
        }
        Some(row)
    }

    /// A row that refers to the one above it; the inner `None`: there are no more rows.
    fn referring(bits: &mut StripBits<'_>, above: &Row, width: usize) -> Option<Option<Row>> {
        let mut row = Row::default();
        let (mut at, mut dark, mut next) = (None, false, 0);
        while at.is_none_or(|at| at < width) {
            // The first change to the other colour in the row above that lies to the right.
            while next > 0 && above.changes.get(next - 1).is_none_or(|&c| at.is_some_and(|at| c > at)) {
                next -= 1;
            }
            while above.changes.get(next).is_some_and(|&c| at.is_some_and(|at| c <= at))
                || next % 2 != usize::from(dark)
            {
                next += 1;
            }
            let change = |i: usize| above.changes.get(i).copied().unwrap_or(width);
            match mode::decode(bits)? {
                Mode::Pass => at = Some(change(next + 1)),
                Mode::Vertical(by) => {
                    let to = change(next).checked_add_signed(isize::from(by))?;
                    if to > width || at.is_some_and(|at| to < at) {
                        return None;
                    }
                    row.change(to);
                    (at, dark) = (Some(to), !dark);
                }
                Mode::Horizontal => {
                    let first = at.unwrap_or(0) + bits.run(dark)?;
                    let second = first + bits.run(!dark)?;
                    row.change(first.min(width));
                    row.change(second.min(width));
                    at = Some(second);
                }
                Mode::EOF => return Some(None),
                Mode::Extension => return None,
            }
        }
        Some(Some(row))
    }

    /// Sets the bits of the black pixels.
    fn draw(&self, line: &mut [u8], width: usize) {
        for run in self.changes.chunks(2) {
            for x in run[0]..run.get(1).copied().unwrap_or(width).min(width) {
                line[x / 8] |= 0x80 >> (x % 8);
            }
        }
    }
}

/// Decodes rows of one bit a pixel, black as 1.
pub(super) fn decode(
    bytes: &[u8],
    coding: Coding,
    width: usize,
    rows: usize,
) -> Result<Vec<u8>, &'static str> {
    let mut bits = StripBits { bytes, position: 0 };
    let stride = width.div_ceil(8);
    let mut out = vec![0; stride * rows];
    let mut above = Row::default();
    for line in out.chunks_exact_mut(stride) {
        let row = match coding {
            Coding::Aligned(to) => {
                bits.position = bits.position.next_multiple_of(to);
                Row::plain(&mut bits, width)
            }
            Coding::Group3 { two } => {
                // Several marks in a row end the page; rows behind them are white.
                if bits.marks(two) > 1 {
                    break;
                }
                let plain = !two || bits.peek(1) == Some(1);
                bits.position += usize::from(two);
                match plain {
                    true => Row::plain(&mut bits, width),
                    false => Row::referring(&mut bits, &above, width).map(Option::unwrap_or_default),
                }
            }
            Coding::Group4 => match Row::referring(&mut bits, &above, width) {
                Some(None) => break,
                row => row.flatten(),
            },
        };
        above = match row {
            Some(row) => row,
            None if bits.ended() => return Err("it ends too early"),
            None => return Err("a row of the fax compression is invalid"),
        };
        above.draw(line, width);
    }
    Ok(out)
}
