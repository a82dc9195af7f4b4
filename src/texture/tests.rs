//! What holds for every filter: means are kept, seams do not show, and nothing depends on an image's size.

use super::source::from_image as arranged_from;
use super::sphere;
use super::*;
#[cfg(feature = "raster")]
use crate::image::Frame;
use crate::image::{Image, Variable};

const FILTERS: [Filter; 5] = [Filter::Mip, Filter::Sums, Filter::Nearest, Filter::Bilinear, Filter::Cubic];
const WRAPS: [Wrap; 4] = [Wrap::Periodic, Wrap::Black, Wrap::Clamp, Wrap::Mirror];
const ALL: Needs = Needs { levels: true, sums: true };

/// A texture in memory.
fn from_image(image: Image<'static>, layout: Layout, needs: Needs) -> Texture {
    arranged_from(image, layout, needs, u64::MAX)
}

/// Scattered numbers from 0 to 1.
fn scattered(i: usize) -> f32 {
    (i.wrapping_mul(2_654_435_761) >> 9) as f32 % 1000.0 / 1000.0
}

fn image(width: usize, height: usize, f: impl Fn(usize, usize) -> f32) -> Image<'static> {
    let plane: Vec<f32> = (0..width * height).map(|i| f(i % width, i / width)).collect();
    Image::new(width, height, [Variable::new("v", Shape::Scalar, [plane]).unwrap()]).unwrap()
}

fn random(width: usize, height: usize, layout: Layout) -> Texture {
    let needs = Needs { sums: layout != Layout::Cube, ..ALL };
    from_image(image(width, height, |x, y| scattered(y * width + x)), layout, needs)
}

fn look(filter: Filter, wrap: Wrap) -> Look {
    Look { filter, wrap: [wrap; 2] }
}

fn at(texture: &Texture, look: Look, place: [f64; 2], widths: [f32; 2]) -> f32 {
    let [x] = texture.at::<1>(look, place, widths, &mut Near::default());
    x
}

#[test]
fn a_constant_image_is_constant_under_every_filter_and_width() {
    for (w, h) in [(1, 1), (2, 1), (5, 7), (64, 48), (37, 100)] {
        let texture = from_image(image(w, h, |_, _| 0.7), Layout::Plane, ALL);
        let round = from_image(image(w, h, |_, _| 0.7), Layout::LatLong, ALL);
        for filter in FILTERS {
            for (i, width) in [0.0, 0.01, 0.3, 1.0, 2.5, 1e9, f32::INFINITY].into_iter().enumerate() {
                let place = [scattered(i).into(), (3.0 * scattered(i + 50)).into()];
                for wrap in [Wrap::Periodic, Wrap::Clamp, Wrap::Mirror] {
                    for widths in [[width; 2], [width, 0.02], [0.0, width]] {
                        let found = at(&texture, look(filter, wrap), place, widths);
                        assert!(
                            (found - 0.7).abs() < 1e-5,
                            "{w}x{h} {filter:?} {wrap:?} {widths:?}: {found}"
                        );
                    }
                }
                let direction = [scattered(i) - 0.5, scattered(i + 9) - 0.5, scattered(i + 99) - 0.5];
                let [found] =
                    round.toward::<1>(look(filter, Wrap::Periodic), direction, width, &mut Near::default());
                assert!((found - 0.7).abs() < 1e-5, "{w}x{h} {filter:?} around, {width}: {found}");
            }
        }
    }
    let cube = from_image(image(24, 18, |_, _| 0.7), Layout::Cube, Needs { levels: true, sums: false });
    for i in 0..200 {
        let direction = [0, 1, 2].map(|k| scattered(3 * i + k) - 0.5);
        let [found] = cube.toward::<1>(
            look(Filter::Mip, Wrap::Periodic),
            direction,
            scattered(i),
            &mut Near::default(),
        );
        assert!((found - 0.7).abs() < 1e-6, "cube: {found}");
    }
}

#[test]
fn every_level_has_the_mean_of_the_image() {
    for (w, h) in [(64, 64), (37, 100), (5, 3), (1, 9), (255, 2)] {
        let texture = random(w, h, Layout::Plane);
        let texels = |l: &Level| l.texels.memory().expect("it is in memory").to_vec();
        let mean = |l: &Level| {
            let texels = texels(l);
            texels.iter().map(|&x| f64::from(x)).sum::<f64>() / texels.len() as f64
        };
        let first = mean(&texture.levels[0]);
        for level in &texture.levels {
            assert!((mean(level) - first).abs() < 1e-6, "{w}x{h} at {}x{}", level.width, level.height);
        }
        assert_eq!(texture.levels.last().map(|l| texels(l).len()), Some(1));
        let far = at(&texture, look(Filter::Mip, Wrap::Periodic), [0.3, 0.9], [1e9, 1e9]);
        assert!((f64::from(far) - first).abs() < 1e-6);
    }
}

/// The mean of a box, texel by texel.
fn direct(w: usize, h: usize, wrap: Wrap, [s, v]: [f64; 2], widths: [f32; 2]) -> f64 {
    let texel = |x: i64, y: i64| {
        let along = |i: i64, n: usize| {
            let n = n as i64;
            match wrap {
                Wrap::Periodic => Some(i.rem_euclid(n)),
                Wrap::Black => (0..n).contains(&i).then_some(i),
                Wrap::Clamp => Some(i.clamp(0, n - 1)),
                Wrap::Mirror => Some(i.rem_euclid(2 * n).min(2 * n - 1 - i.rem_euclid(2 * n))),
            }
        };
        let (Some(x), Some(y)) = (along(x, w), along(y, h)) else { return 0.0 };
        f64::from(scattered(y as usize * w + x as usize))
    };
    let ends = |c: f64, width: f32, n: usize| {
        let d = (f64::from(width) * n as f64).max(1.0);
        (c * n as f64 - 0.5 * d, c * n as f64 + 0.5 * d)
    };
    let ((x0, x1), (y0, y1)) = (ends(s, widths[0], w), ends(v, widths[1], h));
    let share = |i: i64, a: f64, b: f64| b.min((i + 1) as f64) - a.max(i as f64);
    let mut sum = 0.0;
    for y in y0.floor() as i64..y1.ceil() as i64 {
        for x in x0.floor() as i64..x1.ceil() as i64 {
            sum += share(x, x0, x1) * share(y, y0, y1) * texel(x, y);
        }
    }
    sum / ((x1 - x0) * (y1 - y0))
}

#[test]
fn the_summed_area_table_is_the_mean_of_the_box() {
    let (w, h) = (13, 7);
    let texture = random(w, h, Layout::Plane);
    for i in 0..300 {
        let place = [f64::from(scattered(i)) * 4.0 - 1.5, f64::from(scattered(i + 1000)) * 4.0 - 1.5];
        let widths = [scattered(i + 2000) * 3.0, scattered(i + 3000) * 0.8];
        for wrap in WRAPS {
            let found = at(&texture, look(Filter::Sums, wrap), place, widths);
            let wanted = direct(w, h, wrap, place, widths);
            assert!(
                (f64::from(found) - wanted).abs() < 1e-5,
                "{wrap:?} {place:?} {widths:?}: {found} {wanted}"
            );
        }
        // No wider than a texel it is bilinear.
        let sums = at(&texture, look(Filter::Sums, Wrap::Periodic), place, [0.0; 2]);
        let bilinear = at(&texture, look(Filter::Mip, Wrap::Periodic), place, [0.0; 2]);
        assert!((sums - bilinear).abs() < 1e-5, "{place:?}: {sums} {bilinear}");
    }
}

#[test]
fn seams_do_not_show() {
    let texture = random(30, 20, Layout::Plane);
    for filter in [Filter::Mip, Filter::Sums, Filter::Bilinear, Filter::Cubic] {
        for wrap in [Wrap::Periodic, Wrap::Mirror, Wrap::Clamp] {
            for width in [0.0, 0.07, 0.4] {
                for edge in [-1.0, 0.0, 1.0, 2.0] {
                    let v = 0.37;
                    let [a, b] =
                        [-1e-7, 1e-7].map(|e| at(&texture, look(filter, wrap), [edge + e, v], [width; 2]));
                    assert!((a - b).abs() < 1e-4, "{filter:?} {wrap:?} {width} at {edge}: {a} {b}");
                }
            }
        }
        let near = |s, v| at(&texture, look(filter, Wrap::Periodic), [s, v], [0.1; 2]);
        assert!((near(0.21, 0.63) - near(-4.0 + 0.21, 7.0 + 0.63)).abs() < 1e-5);
    }
}

#[test]
fn directions_meet_at_seams_poles_and_edges() {
    let round = random(32, 16, Layout::LatLong);
    let cube = random(8 * 6, 8, Layout::Cube);
    let close = |texture: &Texture, filter, a: [f32; 3], b: [f32; 3], width: f32| {
        let [[a1], [b1]] =
            [a, b].map(|d| texture.toward::<1>(look(filter, Wrap::Periodic), d, width, &mut Near::default()));
        assert!((a1 - b1).abs() < 2e-3, "{:?} {filter:?} {a:?} {b:?} {width}: {a1} {b1}", texture.layout);
    };
    for i in 0..100 {
        let (p, q) = (scattered(i) - 0.5, scattered(i + 500) - 0.5);
        let e = 1e-6;
        for filter in [Filter::Mip, Filter::Sums, Filter::Cubic] {
            for width in [0.0, 0.3] {
                close(&round, filter, [e, p, -1.0], [-e, p, -1.0], width);
            }
        }
        // Over the poles. (A mip map's probes go along the row, so only narrow ones meet.)
        close(&round, Filter::Bilinear, [e * p, 1.0, e * q], [-e * p, 1.0, -e * q], 0.0);
        close(&round, Filter::Sums, [e * p, -1.0, e * q], [-e * p, -1.0, -e * q], 0.0);
        // Where two sides of the cube meet.
        close(&cube, Filter::Bilinear, [1.0 + e, q, 1.0], [1.0 - e, q, 1.0], 0.0);
        close(&cube, Filter::Bilinear, [q, 1.0 + e, 1.0], [q, 1.0 - e, 1.0], 0.0);
        close(&cube, Filter::Bilinear, [q, -1.0 - e, -1.0], [q, -1.0 + e, -1.0], 0.0);
        close(&cube, Filter::Bilinear, [-1.0 - e, 1.0, q], [-1.0 + e, 1.0, q], 0.0);
    }
}

#[test]
fn directions_and_places_go_round() {
    for i in 0..1000 {
        let d = [0, 1, 2].map(|k| f64::from(scattered(3 * i + k)) - 0.5);
        let (side, s, v) = sphere::side_of(d);
        let back = sphere::on_side(side, s, v);
        let length = |d: [f64; 3]| d.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (a, b) = (length(d), length(back));
        assert!((0..3).all(|k| (d[k] / a - back[k] / b).abs() < 1e-9), "{d:?}: side {side}, {back:?}");
        let ([s, v], cosine) = sphere::latitude_longitude(d.map(|x| x as f32));
        let (longitude, latitude) = ((s - 0.5) * std::f64::consts::TAU, (0.5 - v) * std::f64::consts::PI);
        let back = [
            -libm::sin(longitude) * libm::cos(latitude),
            libm::sin(latitude),
            libm::cos(longitude) * libm::cos(latitude),
        ];
        assert!((0..3).all(|k| (d[k] / a - back[k]).abs() < 1e-5), "{d:?}: {back:?}");
        assert!((f64::from(cosine) - libm::cos(latitude)).abs() < 1e-5);
    }
    assert_eq!(turned_z_up([1.0, 0.0, 0.0]), [0.0, 0.0, 1.0]);
    assert_eq!(turned_z_up([0.0, 0.0, 1.0]), [0.0, 1.0, 0.0]);
}

#[test]
fn all_arrangements_of_a_cube_are_the_same_cube() {
    // The row as it is, then the others from it.
    let n = 4;
    let texel = |side: usize, x: usize, y: usize| scattered(side * n * n + y * n + x);
    let arranged = |columns: usize, rows: usize| {
        let (size, sides) = sphere::sides(columns * n, rows * n).unwrap();
        assert_eq!(size, n);
        let image = image(columns * n, rows * n, |x, y| {
            let side = sides.iter().position(|seat| (seat.column, seat.row) == (x / n, y / n));
            let Some(side) = side else { return 0.0 };
            let (x, y) = (x % n, y % n);
            if sides[side].turned { texel(side, n - 1 - x, n - 1 - y) } else { texel(side, x, y) }
        });
        from_image(image, Layout::Cube, Needs { levels: true, sums: false })
    };
    let row = arranged(6, 1);
    for (columns, rows) in [(1, 6), (3, 2), (4, 3), (3, 4)] {
        assert_eq!(arranged(columns, rows).levels[0].texels.memory(), row.levels[0].texels.memory());
    }
    assert!(sphere::sides(10, 10).is_none() && sphere::sides(7, 1).is_none());
    // In the cross, neighbours are neighbours: right of +z comes +x, above it +y.
    let (side, s, v) = sphere::side_of(sphere::on_side(4, 1.01, 0.3));
    assert!(side == 0 && s < 0.1 && (v - 0.3).abs() < 0.1, "{side} {s} {v}");
    let (side, s, v) = sphere::side_of(sphere::on_side(4, 0.3, -0.01));
    assert!(side == 2 && (s - 0.3).abs() < 0.1 && v > 0.9, "{side} {s} {v}");
    let (side, s, _) = sphere::side_of(sphere::on_side(4, -0.01, 0.3));
    assert!(side == 1 && s > 0.9, "{side} {s}");
}

#[test]
fn awkward_places_are_borne() {
    let textures = [random(13, 7, Layout::Plane), random(13, 7, Layout::LatLong), random(6, 1, Layout::Cube)];
    let awkward = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e9, -1e9, f32::MAX, 0.0, -0.0, 1.0, 1e-40];
    for filter in FILTERS {
        for wrap in WRAPS {
            for (a, b) in awkward.into_iter().flat_map(|a| awkward.map(|b| (a, b))) {
                for width in awkward {
                    let found = at(&textures[0], look(filter, wrap), [a.into(), b.into()], [width, 0.1]);
                    let is_nan = a.is_nan() || b.is_nan() || width.is_nan();
                    assert!(!is_nan || found.is_nan());
                    assert!(found.is_nan() || (-0.01..=1.01).contains(&found), "{a} {b} {width}: {found}");
                    for round in &textures[1..] {
                        let filter = if round.layout == Layout::Cube { Filter::Mip } else { filter };
                        let [found] =
                            round.toward::<1>(look(filter, wrap), [a, b, 0.5], width, &mut Near::default());
                        assert!(
                            found.is_nan() || (-0.01..=1.01).contains(&found),
                            "{a} {b} {width}: {found}"
                        );
                        assert!(!is_nan || found.is_nan());
                    }
                }
            }
        }
    }
    for wrap in [Wrap::Black, Wrap::Clamp] {
        assert!(!at(&textures[0], look(Filter::Mip, wrap), [1e9, f64::INFINITY], [0.0; 2]).is_nan());
    }
}

#[test]
fn a_long_footprint_is_not_blurred_across() {
    // Stripes along the columns: wide along them, narrow across, they must stay.
    let stripes = from_image(image(64, 64, |_, y| (y / 4 % 2) as f32), Layout::Plane, ALL);
    for filter in [Filter::Mip, Filter::Sums] {
        let found = at(&stripes, look(filter, Wrap::Periodic), [0.5, 6.0 / 64.0], [0.25, 0.01]);
        assert!((found - 1.0).abs() < 1e-5, "{filter:?}: {found}");
        let found = at(&stripes, look(filter, Wrap::Periodic), [0.5, 6.0 / 64.0], [0.01, 0.5]);
        assert!((found - 0.5).abs() < 0.1, "{filter:?}: {found}");
    }
}

#[cfg(feature = "raster")]
#[test]
fn an_image_is_read_once_and_counted_each_time() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    crate::image::write(&path, &image(8, 4, |x, _| x as f32), &Default::default()).unwrap();
    let mut source = Source::new(
        "a.exr",
        Origin::File(crate::image::Input::Path(path.clone())),
        None,
        false,
        Layout::Plane,
    );
    source.needs = ALL;
    let tiles = Arc::default();
    let mut left = 10_000;
    let first = source.load(Frame::from(1.0_f32), &mut left, &tiles).unwrap();
    let taken = 10_000 - left;
    assert_eq!(taken, 4 * (32 + 10) + 8 * 45);
    std::fs::remove_file(path).unwrap();
    let again = source.load(Frame::from(2.0_f32), &mut left, &tiles).unwrap();
    assert!(Arc::ptr_eq(&first, &again));
    assert_eq!(left, 10_000 - 2 * taken);
    // What is allowed less memory now is read again.
    assert!(source.load(Frame::from(3.0_f32), &mut (taken - 1), &tiles).is_err());
}

#[cfg(feature = "raster")]
#[test]
fn tiles_are_as_memory_bit_for_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let layouts = [(Layout::Plane, [167, 131]), (Layout::LatLong, [96, 40]), (Layout::Cube, [280, 210])];
    let cubes = [[70 * 6, 70], [70, 70 * 6], [210, 140], [210, 280]].map(|size| (Layout::Cube, size));
    for (layout, [w, h]) in layouts.into_iter().chain(cubes) {
        let mut image = image(w, h, |x, y| scattered(y * w + x));
        // A crop of a larger picture, but of cubes.
        if layout != Layout::Cube {
            (image.metadata.origin, image.metadata.resolution) = ([9, 5], Some([w + 20, h + 7]));
        }
        crate::image::write(&path, &image, &Default::default()).unwrap();
        let origin = Origin::File(crate::image::Input::Path(path.clone()));
        let load = |mut left: u64, tiles: u64| {
            let mut source = Source::new("a.exr", origin.clone(), None, false, layout);
            source.needs = Needs { levels: true, sums: layout != Layout::Cube };
            let cache = Arc::<Tiles>::default();
            let texture = source.load(Frame::from(0.0_f32), &mut left, &cache).unwrap();
            cache.allow(tiles);
            assert_eq!(texture.store.is_some(), tiles > 0);
            texture
        };
        let (memory, tiled) = (load(1 << 30, 0), load(0, 20_000));
        let (mut a, mut b) = (Near::default(), Near::default());
        for i in 0..20_000 {
            let [s, v, width, across] = [0, 1, 2, 3].map(|k| scattered(4 * i + k));
            let width = if i % 2 == 0 { width * width } else { 0.01 * width };
            let filter = if layout == Layout::Cube { Filter::Mip } else { FILTERS[i % 5] };
            let look = look(filter, WRAPS[i / 5 % 4]);
            let (one, other) = if layout == Layout::Plane {
                let (place, widths) = ([3.0 * f64::from(s) - 1.0, f64::from(v)], [width, width * across]);
                (memory.at::<1>(look, place, widths, &mut a), tiled.at::<1>(look, place, widths, &mut b))
            } else {
                let way = [s - 0.5, v - 0.5, across - 0.5];
                (memory.toward(look, way, width, &mut a), tiled.toward(look, way, width, &mut b))
            };
            assert_eq!(one.map(f32::to_bits), other.map(f32::to_bits), "{layout:?} {w}x{h} {look:?} {i}");
        }
        tiled.sound().unwrap();
    }
}
