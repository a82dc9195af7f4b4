//! A part of the picture: which, and how to cut it out.

use super::failure::Failure;
use pse::image::{Image, Variable};
use std::borrow::Cow;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Pixels of the display window: from `x0`, `y0` up to but not including `x1`, `y1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Region {
    pub x0: i64,
    pub y0: i64,
    pub x1: i64,
    pub y1: i64,
}

impl FromStr for Region {
    type Err = String;

    fn from_str(text: &str) -> Result<Region, String> {
        let form = || {
            format!(
                "`{text}` is not a region; write x0,y0,x1,y1 or WxH+X+Y, for example 0,0,320,240 or 320x240+0+0"
            )
        };
        let number = |t: &str| t.trim().parse::<i32>().map(i64::from).map_err(|_| form());
        let region = if text.contains(',') {
            let parts = text.split(',').map(number).collect::<Result<Vec<i64>, String>>()?;
            let [x0, y0, x1, y1] = parts[..] else { return Err(form()) };
            Region { x0, y0, x1, y1 }
        } else {
            let (width, rest) = text.split_once('x').ok_or_else(form)?;
            let (height, rest) = rest.split_once('+').ok_or_else(form)?;
            let (x, y) = rest.split_once('+').ok_or_else(form)?;
            let (width, height, x0, y0) = (number(width)?, number(height)?, number(x)?, number(y)?);
            Region { x0, y0, x1: x0 + width, y1: y0 + height }
        };
        if region.x0 < region.x1 && region.y0 < region.y1 {
            Ok(region)
        } else {
            Err(format!("the region `{text}` has no pixels: x1 and y1 are exclusive"))
        }
    }
}

/// As it may be given again.
impl fmt::Display for Region {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{},{},{},{}", self.x0, self.y0, self.x1, self.y1)
    }
}

impl Region {
    /// The pixels that an image holds.
    pub fn held(image: &Image<'_>) -> Region {
        let [x0, y0] = image.metadata.origin.map(i64::from);
        Region { x0, y0, x1: x0 + image.width as i64, y1: y0 + image.height as i64 }
    }

    /// What both have; `None` if that is nothing.
    pub fn and(self, other: Region) -> Option<Region> {
        let both = Region {
            x0: self.x0.max(other.x0),
            y0: self.y0.max(other.y0),
            x1: self.x1.min(other.x1),
            y1: self.y1.min(other.y1),
        };
        (both.x0 < both.x1 && both.y0 < both.y1).then_some(both)
    }

    /// How many pixels there are in it.
    pub fn area(self) -> i64 {
        (self.x1 - self.x0) * (self.y1 - self.y0)
    }

    /// The same with so many more pixels on each side.
    fn grown(self, by: i64) -> Region {
        Region { x0: self.x0 - by, y0: self.y0 - by, x1: self.x1 + by, y1: self.y1 + by }
    }

    /// The rows of the image that lie in this region, counted from its first.
    pub fn rows(self, image: &Image<'_>) -> Result<Range<usize>, Failure> {
        let (inside, held) = (self.inside(image)?, Region::held(image));
        Ok((inside.y0 - held.y0) as usize..(inside.y1 - held.y0) as usize)
    }

    /// What an image has of it.
    pub fn inside(self, image: &Image<'_>) -> Result<Region, Failure> {
        let held = Region::held(image);
        self.and(held).ok_or_else(|| {
            let message = format!("the region {self} is outside the image");
            Failure::plain(message).hint(format!("The image holds {held}."))
        })
    }

    /// The image's pixels in this region and up to `around` pixels about it, in the same display window.
    pub fn cut<'a>(self, image: &Image<'a>, around: i64) -> Result<Image<'static>, Failure> {
        let (inside, held) = (self.inside(image)?, Region::held(image));
        let part = inside.grown(around).and(held).unwrap_or(inside);
        let (width, height) = ((part.x1 - part.x0) as usize, (part.y1 - part.y0) as usize);
        let first = (part.x0 - held.x0) as usize;
        let rows = (part.y0 - held.y0) as usize..(part.y1 - held.y0) as usize;
        let plane = |plane: &Cow<'a, [f32]>| -> Cow<'static, [f32]> {
            let row = |y: usize| &plane[y * image.width + first..][..width];
            rows.clone().flat_map(row).copied().collect::<Vec<f32>>().into()
        };
        let variables = image.variables.iter().map(|v| Variable {
            name: v.name.clone(),
            shape: v.shape.clone(),
            planes: v.planes.iter().map(plane).collect(),
        });
        let variables = variables.collect();
        let mut metadata = image.metadata.clone();
        metadata.resolution = Some(image.resolution());
        metadata.origin = [part.x0 as i32, part.y0 as i32];
        Ok(Image { width, height, variables, metadata })
    }
}

/// Pixels of a band, about: enough to keep the threads busy, and few enough to stay near the processor.
const BAND: usize = 1 << 18;

/// Bands have a multiple of so many rows, which blocks of most EXR files have too.
const BLOCK: usize = 32;

/// These rows of an image of that width, cut into bands that are read, run and written one after another.
pub(super) fn bands(width: usize, rows: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let height = BAND.div_ceil(width.max(1)).next_multiple_of(BLOCK);
    rows.clone().step_by(height).map(move |top| top..rows.end.min(top + height))
}

#[cfg(test)]
mod tests {
    use super::*;
    use pse::internal::shape::Shape;

    #[test]
    fn two_forms() {
        let region = Region { x0: 10, y0: 20, x1: 40, y1: 60 };
        assert_eq!("10,20,40,60".parse(), Ok(region));
        assert_eq!("30x40+10+20".parse(), Ok(region));
        assert_eq!("2x2+-1+0".parse(), Ok(Region { x0: -1, y0: 0, x1: 1, y1: 2 }));
        for text in ["", "1,2,3", "3x4", "5,5,5,9", "0x4+1+1", "a,b,c,d", "3x4+1"] {
            assert!(text.parse::<Region>().is_err(), "{text}");
        }
    }

    #[test]
    fn a_cut_keeps_its_place() {
        let plane: Vec<f32> = (0..12).map(|i| i as f32).collect();
        let variable = Variable::new("x", Shape::Scalar, [plane]).unwrap();
        let image = Image::new(4, 3, [variable]).unwrap();
        let region: Region = "1,1,3,9".parse().unwrap();
        let cut = region.cut(&image, 0).unwrap();
        assert_eq!((cut.width, cut.height, cut.metadata.origin), (2, 2, [1, 1]));
        assert_eq!(cut.resolution(), [4, 3]);
        assert_eq!(&cut.variables[0].planes[0][..], [5.0, 6.0, 9.0, 10.0]);
        let wide = region.cut(&image, 1).unwrap();
        assert_eq!((wide.width, wide.height), (4, 3));
        assert!("9,9,10,10".parse::<Region>().unwrap().cut(&image, 1).is_err());
    }
}
