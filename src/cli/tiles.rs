//! Tiles: a picture cut into columns and rows of parts, so that several machines can each compute one.

use super::failure::Failure;
use super::region::Region;
use pse::image::Image;
use std::fmt;
use std::str::FromStr;

/// The place of a tile's number in the names of files.
const PLACE: &str = "{tile}";

/// The most tiles that a picture is cut into.
const MAX_TILES: usize = 4096;

/// How many columns and rows of tiles there are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tiles {
    pub columns: usize,
    pub rows: usize,
}

impl Tiles {
    /// How many tiles there are.
    pub fn count(self) -> usize {
        self.columns * self.rows
    }
}

impl FromStr for Tiles {
    type Err = String;

    fn from_str(text: &str) -> Result<Tiles, String> {
        let form = || format!("`{text}` is not a number of tiles; write COLUMNSxROWS, for example 4x4");
        let (columns, rows) = text.split_once('x').ok_or_else(form)?;
        let number = |t: &str| t.trim().parse::<usize>().ok().filter(|n| *n > 0).ok_or_else(form);
        let tiles = Tiles { columns: number(columns)?, rows: number(rows)? };
        match tiles.columns.checked_mul(tiles.rows).is_some_and(|n| n <= MAX_TILES) {
            true => Ok(tiles),
            false => Err(format!("{tiles} are more than {MAX_TILES} tiles")),
        }
    }
}

impl fmt::Display for Tiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.columns, self.rows)
    }
}

/// One tile of a picture. They are counted from 1, row by row from the top left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tile {
    pub number: usize,
    pub of: Tiles,
}

impl FromStr for Tile {
    type Err = String;

    fn from_str(text: &str) -> Result<Tile, String> {
        let Some((number, of)) = text.split_once('/') else {
            return Err(format!("`{text}` is not a tile; write NUMBER/COLUMNSxROWS, for example 3/4x4"));
        };
        let of: Tiles = of.parse()?;
        let count = of.count();
        match number.trim().parse::<usize>().ok().filter(|n| (1..=count).contains(n)) {
            Some(number) => Ok(Tile { number, of }),
            None => Err(format!("there is no tile `{number}` of {of}: tiles are numbered 1 to {count}")),
        }
    }
}

impl Tile {
    /// Its pixels of what an image holds. All tiles together are the image, and no pixel is in two.
    pub fn region(self, image: &Image<'_>) -> Result<Region, Failure> {
        let Tiles { columns, rows } = self.of;
        if image.width < columns || image.height < rows {
            let (of, width, height) = (self.of, image.width, image.height);
            return Err(Failure::plain(format!("{width}x{height} pixels cannot be cut into {of} tiles"))
                .hint("A tile has at least one pixel. Use fewer tiles."));
        }
        let (column, row) = ((self.number - 1) % columns, (self.number - 1) / columns);
        let part = |i: usize, of: usize, size: usize| (i * size / of) as i64;
        let [x, y] = image.metadata.origin.map(i64::from);
        Ok(Region {
            x0: x + part(column, columns, image.width),
            y0: y + part(row, rows, image.height),
            x1: x + part(column + 1, columns, image.width),
            y1: y + part(row + 1, rows, image.height),
        })
    }
}

/// Has the name a place for the tile's number?
pub(super) fn has_place(name: &str) -> bool {
    name.contains(PLACE)
}

/// The name with the tile's number in that place.
pub(super) fn fill(name: &str, number: usize) -> String {
    name.replace(PLACE, &number.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_a_picture_once() {
        let mut image = Image { width: 10, height: 7, ..Image::default() };
        image.metadata.origin = [-3, 5];
        let mut hits = vec![0; 70];
        for number in 1..=12 {
            let tile: Tile = format!("{number}/4x3").parse().unwrap();
            let region = tile.region(&image).unwrap();
            for y in region.y0..region.y1 {
                (region.x0..region.x1).for_each(|x| hits[((y - 5) * 10 + x + 3) as usize] += 1);
            }
        }
        assert!(hits.iter().all(|&n| n == 1), "{hits:?}");
        assert!("1/11x1".parse::<Tile>().unwrap().region(&image).is_err());
    }

    #[test]
    fn what_is_no_tile_is_said() {
        for text in ["", "3", "0/2x2", "5/2x2", "1/2", "1/0x2", "1/100x100", "a/2x2"] {
            assert!(text.parse::<Tile>().is_err(), "{text}");
        }
        assert_eq!(fill("a.{tile}.exr", 12), "a.12.exr");
    }
}
