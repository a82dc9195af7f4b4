//! What is written comes back.

use super::*;

fn plane(values: &[f32]) -> Cow<'static, [f32]> {
    Cow::Owned(values.to_vec())
}

fn image(width: usize, height: usize, variables: &[(&str, Shape)]) -> Image<'static> {
    let count = width * height;
    let variables = variables
        .iter()
        .enumerate()
        .map(|(v, (name, shape))| Variable {
            name: name.to_string(),
            shape: shape.clone(),
            planes: (0..shape.cells())
                .map(|c| {
                    plane(&(0..count).map(|i| (v * 100 + c * 10) as f32 + i as f32 / 7.0).collect::<Vec<_>>())
                })
                .collect(),
        })
        .collect();
    Image { width, height, variables, metadata: Metadata::default() }
}

fn written(image: &Image<'_>, options: &WriteOptions) -> File {
    open(encode("test.exr", Format::Exr, image, options).unwrap())
}

fn bits(image: &Image<'_>, name: &str) -> Vec<Vec<u32>> {
    let variable = image.variable(name).unwrap();
    variable.planes.iter().map(|p| p.iter().map(|v| v.to_bits()).collect()).collect()
}

#[test]
fn every_shape_of_variable() {
    let nested = Shape::vector_of(&[Shape::Vector(2), Shape::Scalar, Shape::Vector(3)]);
    let variables = [
        ("color", Shape::Vector(3)),
        ("alpha", Shape::Scalar),
        ("surface", Shape::Scalar),
        ("point", Shape::Vector(3)),
        ("normal", Shape::Vector(3)),
        ("depth", Shape::Scalar),
        ("uv", Shape::Vector(2)),
        ("motion", Shape::Vector(4)),
        ("albedo", Shape::Vector(3)),
        ("x", Shape::Scalar),
        ("u", Shape::Scalar),
        ("N", Shape::Vector(2)),
        ("id", Shape::Vector(3)),
        ("one", Shape::Vector(1)),
        ("many", Shape::Vector(12)),
        ("rows", Shape::vector_of(&[Shape::Vector(3), Shape::Vector(3)])),
        ("m", nested),
        ("a_rather_long_name_of_more_than_thirty_one_letters", Shape::Scalar),
    ];
    for (width, height) in [(1, 1), (1, 40), (33, 1), (17, 35)] {
        let image = image(width, height, &variables);
        let file = written(&image, &WriteOptions::default());
        let names: Vec<&str> = variables.iter().map(|v| v.0).collect();
        let back = file.load(&names).unwrap();
        for (name, shape) in &variables {
            assert_eq!(back.variable(name).unwrap().shape, *shape, "{name}");
            assert_eq!(bits(&back, name), bits(&image, name), "{name}");
        }
    }
}

#[test]
fn a_color_with_alpha_and_a_grey_color() {
    let four = image(3, 2, &[("color", Shape::Vector(4))]);
    let back = written(&four, &WriteOptions::default()).load(&["color", "alpha"]).unwrap();
    assert_eq!(bits(&back, "color")[..], bits(&four, "color")[..3]);
    assert_eq!(bits(&back, "alpha")[0], bits(&four, "color")[3]);
    let grey = image(3, 2, &[("color", Shape::Scalar)]);
    let back = written(&grey, &WriteOptions::default()).load(&["color"]).unwrap();
    assert_eq!(bits(&back, "color"), vec![bits(&grey, "color")[0].clone(); 3]);
}

#[test]
fn nan_infinity_and_hashes_keep_their_bits() {
    let odd = [
        f32::NAN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        -0.0,
        f32::MIN_POSITIVE / 4.0,
        f32::from_bits(0x7fa0_0001),
        f32::from_bits(0x75f7_4669),
        1e-45,
        f32::MAX,
    ];
    let mut image = image(9, 1, &[("v", Shape::Scalar)]);
    image.variables[0].planes[0] = plane(&odd);
    for compression in
        [Compression::None, Compression::Rle, Compression::Zips, Compression::Zip, Compression::Piz]
    {
        let options = WriteOptions { compression, ..WriteOptions::default() };
        let back = written(&image, &options).load(&["v"]).unwrap();
        assert_eq!(bits(&back, "v"), bits(&image, "v"), "{compression:?}");
    }
}

#[test]
fn half_spares_what_must_be_exact() {
    let image =
        image(5, 3, &[("color", Shape::Vector(3)), ("surface", Shape::Scalar), ("point", Shape::Vector(3))]);
    let file = written(&image, &WriteOptions { half: true, ..WriteOptions::default() });
    for channel in file.channels() {
        let want = if channel.name.len() == 1 { Samples::Half } else { Samples::Float };
        assert_eq!(channel.samples, want, "{}", channel.name);
    }
    let back = file.load(&["color", "point"]).unwrap();
    assert_eq!(bits(&back, "point"), bits(&image, "point"));
    let (got, want) = (&back.variables[0].planes[2], &image.variables[0].planes[2]);
    assert!(got.iter().zip(want.iter()).all(|(g, w)| *g == half::f16::from_f32(*w).to_f32()));
}

#[test]
fn windows_and_attributes_pass_through() {
    use exr::meta::attribute::AttributeValue;
    let mut image = image(4, 3, &[("surface", Shape::Scalar), ("Crypto00", Shape::Vector(4))]);
    image.metadata.origin = [-2, 5];
    image.metadata.resolution = Some([100, 50]);
    image.metadata.display_origin = [7, -3];
    image.metadata.pixel_aspect = 2.0;
    let text = |t: &str| AttributeValue::Text(t.into());
    image.metadata.attributes.list = vec![
        ("cryptomatte/1/manifest".into(), text("{\"a\":\"00\"}")),
        ("cryptomatte/1/name".into(), text("ViewLayer.Crypto")),
        ("cryptomatte/2/name".into(), text("ViewLayer.Other")),
        ("framesPerSecond".into(), AttributeValue::Rational((24, 1))),
        ("worldToCamera".into(), AttributeValue::Matrix4x4([1.5; 16])),
    ];
    let file = written(&image, &WriteOptions::default());
    let about = file.metadata();
    assert_eq!((about.origin, about.resolution), ([-2, 5], Some([100, 50])));
    assert_eq!((about.display_origin, about.pixel_aspect), ([7, -3], 2.0));
    let attributes: Vec<(&str, String)> = about.attributes.iter().collect();
    let find = |name: &str| attributes.iter().find(|a| a.0 == name).map(|a| a.1.as_str());
    assert_eq!(find("framesPerSecond"), Some("24/1"));
    assert!(find("worldToCamera").unwrap().starts_with("1.5 1.5"));
    assert_eq!(find("cryptomatte/1/name"), Some("Crypto"), "the channels have lost their prefix");
    assert!(find("cryptomatte/1/manifest").is_some());
    assert_eq!(find("cryptomatte/2/name"), None, "its channels are not written");
    assert_eq!(channels_of(&file, "Crypto00"), ["Crypto00.r", "Crypto00.g", "Crypto00.b", "Crypto00.a"]);
    // And once more through: nothing grows or moves.
    let again = encode("test.exr", Format::Exr, &file.load_all().unwrap(), &WriteOptions::default()).unwrap();
    let first = encode("test.exr", Format::Exr, &image, &WriteOptions::default()).unwrap();
    assert_eq!(again, first);
}

#[test]
fn the_same_image_gives_the_same_bytes_on_any_number_of_threads() {
    let image = image(50, 70, &[("color", Shape::Vector(3)), ("alpha", Shape::Scalar)]);
    for format in [Format::Exr, Format::Png, Format::Jpeg, Format::Tiff, Format::Hdr, Format::Webp] {
        let all = encode("x", format, &image, &WriteOptions::default()).unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let one = pool.install(|| encode("x", format, &image, &WriteOptions::default()).unwrap());
        assert_eq!(all, one, "{format:?}");
    }
}

/// All codes of 8 bits in each component, with alpha that never is 0.
fn codes(width: usize, height: usize, alpha: bool) -> Image<'static> {
    let count = width * height;
    let of = |step: usize, start: usize| -> Vec<f32> {
        (0..count).map(|i| color::decode8(((i * step + start) % 256) as u8)).collect()
    };
    let a: Vec<f32> = (0..count).map(|i| (255 - i % 255) as f32 / 255.0).collect();
    let mut planes = vec![of(1, 0), of(3, 7), of(5, 100)];
    if alpha {
        planes.iter_mut().for_each(|p| p.iter_mut().zip(&a).for_each(|(c, a)| *c *= a));
        planes.push(a);
    }
    let shape = Shape::Vector(planes.len() as u32);
    let planes = planes.into_iter().map(Cow::Owned).collect();
    let variables = vec![Variable { name: "color".into(), shape, planes }];
    Image { width, height, variables, metadata: Metadata::default() }
}

fn read_back(name: &str, format: Format, image: &Image<'_>, options: &WriteOptions) -> Image<'static> {
    let bytes = encode(name, format, image, options).unwrap();
    let file = read(Input::from_bytes(name, bytes), &ReadOptions { raw: options.raw, ..Default::default() })
        .unwrap();
    file.load_all().unwrap()
}

#[test]
fn pictures_keep_their_codes() {
    for (width, height) in [(32, 16), (1, 1), (1, 9), (9, 1)] {
        for (name, format) in [
            ("a.png", Format::Png),
            ("a.tif", Format::Tiff),
            ("a.bmp", Format::Bmp),
            ("a.tga", Format::Tga),
            ("a.webp", Format::Webp),
        ] {
            for bits in [8, 16] {
                if bits == 16 && !matches!(format, Format::Png | Format::Tiff) {
                    continue;
                }
                let options = WriteOptions { bits: Some(bits), ..WriteOptions::default() };
                let image = codes(width, height, false);
                let back = read_back(name, format, &image, &options);
                for c in 0..3 {
                    let encoded = |p: &[f32]| p.iter().map(|&v| color::encode8(v)).collect::<Vec<u8>>();
                    let (got, want) = (&back.variables[0].planes[c], &image.variables[0].planes[c]);
                    assert_eq!(encoded(got), encoded(want), "{name} {bits}");
                }
                let image = codes(width, height, true);
                let back = read_back(name, format, &image, &options);
                let alpha = &back.variable("alpha").unwrap().planes[0];
                for (got, want) in alpha.iter().zip(image.variables[0].planes[3].iter()) {
                    assert!((got - want).abs() < 1e-6, "{name} {bits}: alpha {got} is not {want}");
                }
                for c in 0..3 {
                    let (got, want) = (&back.variables[0].planes[c], &image.variables[0].planes[c]);
                    for (got, want) in got.iter().zip(want.iter()) {
                        assert!((got - want).abs() < 1e-5, "{name} {bits}: {got} is not {want}");
                    }
                }
            }
        }
    }
}

#[test]
fn float_pictures_are_linear() {
    let mut image = image(6, 5, &[("color", Shape::Vector(3))]);
    let back =
        read_back("a.tif", Format::Tiff, &image, &WriteOptions { bits: Some(32), ..Default::default() });
    assert_eq!(bits(&back, "color"), bits(&image, "color"));
    image.variables[0].planes[0] = plane(&[f32::NAN; 30]);
    let back = read_back("a.hdr", Format::Hdr, &image, &WriteOptions::default());
    for (got, want) in back.variables[0].planes[2].iter().zip(image.variables[0].planes[2].iter()) {
        assert!((got - want).abs() <= want / 100.0, "{got} is not {want}");
    }
    let back = read_back("a.jpg", Format::Jpeg, &codes(32, 32, false), &WriteOptions::default());
    assert_eq!((back.width, back.height), (32, 32));
}

#[test]
fn a_picture_shows_the_display_window() {
    let mut image = codes(4, 3, true);
    image.variables[0].planes[3] = plane(&[1.0; 12]);
    image.metadata.origin = [-1, 1];
    image.metadata.resolution = Some([5, 3]);
    let back = read_back("a.png", Format::Png, &image, &WriteOptions::default());
    assert_eq!((back.width, back.height), (5, 3));
    let alpha = &back.variable("alpha").unwrap().planes[0];
    let rows: Vec<String> =
        alpha.chunks(5).map(|r| r.iter().map(|a| if *a > 0.5 { '#' } else { '.' }).collect()).collect();
    assert_eq!(rows, [".....", "###..", "###.."]);
    let red = &back.variables[0].planes[0];
    assert_eq!(color::encode8(red[5]), 1, "the second stored pixel is the first shown");
}

#[test]
fn raw_numbers_and_grey_files() {
    let mut image = image(4, 1, &[("color", Shape::Scalar)]);
    image.variables[0].planes[0] = plane(&[0.0, 0.2, 0.4, f32::NAN]);
    let raw = WriteOptions { raw: true, ..WriteOptions::default() };
    let back = read_back("a.png", Format::Png, &image, &raw);
    assert_eq!(back.variables[0].planes[0][..], [0.0, 0.2, 0.4, 0.0]);
    // A grey file of another program's is a colour of three equal components.
    let mut out = Cursor::new(Vec::new());
    let grey = ::image::GrayImage::from_raw(2, 1, vec![255, 188]).unwrap();
    grey.write_to(&mut out, ::image::ImageFormat::Png).unwrap();
    let file = read(Input::from_bytes("no extension", out.into_inner()), &ReadOptions::default()).unwrap();
    let back = file.load(&["color"]).unwrap();
    assert_eq!(back.variables[0].shape, Shape::Vector(3));
    assert_eq!(back.variables[0].planes[1][..], [1.0, color::decode8(188)]);
    assert!(info(&file).unwrap().to_string().contains("PNG, 2 x 1"));
}

#[test]
fn what_cannot_be_written_says_why() {
    let fail =
        |image: &Image<'_>, format| encode("x", format, image, &WriteOptions::default()).unwrap_err().message;
    let no_color = image(2, 2, &[("surface", Shape::Scalar)]);
    assert_eq!(fail(&no_color, Format::Png), "cannot write `x`: the image has no `color`");
    let pair = image(2, 2, &[("color", Shape::Vector(2))]);
    assert!(fail(&pair, Format::Png).contains("a vector of 2"));
    let twice = image(2, 2, &[("color", Shape::Vector(4)), ("alpha", Shape::Scalar)]);
    assert!(fail(&twice, Format::Exr).contains("channel `A`"));
    assert!(fail(&image(2, 2, &[("v", Shape::Vector(0))]), Format::Exr).contains("empty vector"));
    assert!(fail(&image(0, 2, &[("v", Shape::Scalar)]), Format::Exr).contains("no pixels"));
    let error = Format::of(std::path::Path::new("a.gif")).unwrap_err();
    assert!(error.hints[0].contains(".exr .png .jpg"), "{:?}", error.hints);
}

#[test]
fn tiff_files_say_what_their_alpha_is() {
    let plane = |v: f32| plane(&[v; 6]);
    let variables = vec![Variable {
        name: "color".into(),
        shape: Shape::Vector(4),
        planes: vec![plane(0.25), plane(0.125), plane(0.0), plane(0.5)],
    }];
    let image = Image { width: 3, height: 2, variables, metadata: Metadata::default() };
    for raw in [false, true] {
        for bits in [8, 16, 32] {
            let options = WriteOptions { bits: Some(bits), raw, ..Default::default() };
            let bytes = encode("a.tif", Format::Tiff, &image, &options).unwrap();
            // ExtraSamples, one short number: 2 is "not multiplied", 1 "multiplied".
            let kind = if raw { 1 } else { 2 };
            let tag = [[0x52, 1, 3, 0, 1, 0, 0, 0, kind], [1, 0x52, 0, 3, 0, 0, 0, 1, 0]];
            assert!(bytes.windows(9).any(|w| w == tag[0] || w == tag[1]), "{bits} {raw}");
            let options = ReadOptions { raw: true, ..Default::default() };
            let stored = read(Input::from_bytes("a.tif", bytes.clone()), &options).unwrap();
            let stored = stored.load(&["color"]).unwrap().variables[0].planes[0][0];
            let expected = match (raw, bits) {
                (true, _) => 0.25,
                (false, 32) => 0.5,
                (false, _) => color::linear_to_srgb(0.5) as f32,
            };
            assert!((stored - expected).abs() < 0.003, "{bits} {raw}: {stored}");
            if !raw {
                let back = read(Input::from_bytes("a.tif", bytes), &ReadOptions::default()).unwrap();
                let back = back.load(&["color", "alpha"]).unwrap();
                let near = |c: usize, v: f32| (back.variables[0].planes[c][0] - v).abs() < 0.003;
                assert!(near(0, 0.25) && near(1, 0.125), "{bits}");
                assert!((back.variables[1].planes[0][0] - 0.5).abs() < 0.003);
            }
        }
    }
}
