use std::io::Cursor;

use image::{DynamicImage, ImageBuffer, ImageFormat};
use proptest::prelude::*;

use crate::data::{Image, Samples, linear_to_srgb, srgb_to_linear};
use crate::io::{Encoding, ReadError, ReadLimits, decode_image, write_image_exr, write_image_png};

fn read(bytes: &[u8]) -> Result<Image, ReadError> {
    decode_image(bytes, Encoding::Auto, &ReadLimits::default())
}

fn encoded(picture: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    picture.into().write_to(&mut out, format).expect("a picture of a supported kind");
    out.into_inner()
}

fn png(image: &Image) -> Vec<u8> {
    let mut out = Vec::new();
    write_image_png(image, &mut out).expect("a picture that PNG holds");
    out
}

fn exr(image: &Image) -> Vec<u8> {
    let mut out = Cursor::new(Vec::new());
    write_image_exr(image, &mut out).expect("a picture that EXR holds");
    out.into_inner()
}

fn floats(image: &Image) -> &[f32] {
    match image.samples() {
        Samples::F32(v) => v,
        other => panic!("expected floats, found {:?}", other.ty()),
    }
}

proptest! {
    #[test]
    fn png_keeps_bytes(width in 1u32..9, height in 1u32..9, channels in 1usize..5, seed: u8) {
        let n = (width * height) as usize * channels;
        let samples = Samples::U8((0..n).map(|i| (i as u8).wrapping_mul(83) ^ seed).collect());
        let image = Image::new(width, height, channels, samples).unwrap();
        prop_assert_eq!(read(&png(&image)).unwrap(), image);
    }

    #[test]
    fn exr_keeps_floats(
        width in 1u32..9,
        channels in 1usize..5,
        values in prop::collection::vec(-1e30f32..1e30, 300),
    ) {
        let height = 7;
        let n = (width * height) as usize * channels;
        let image = Image::new(width, height, channels, Samples::F32(values[..n].to_vec())).unwrap();
        prop_assert_eq!(read(&exr(&image)).unwrap(), image);
    }

    #[test]
    fn png_keeps_fractions_to_16_bits(values in prop::collection::vec(0f32..=1.0, 12)) {
        let image = Image::new(2, 3, 2, Samples::F32(values)).unwrap();
        let back = read(&png(&image)).unwrap();
        for (a, b) in floats(&image).iter().zip(floats(&back)) {
            prop_assert!((a - b).abs() <= 0.5001 / 65_535.0, "{} came back as {}", a, b);
        }
    }
}

#[test]
fn linear_colours_are_written_as_srgb() {
    let image = Image::new(1, 1, 4, Samples::F32(vec![0.0, 0.214_041_14, 1.0, 0.5])).unwrap();
    assert_eq!(read(&png(&image)).unwrap().samples(), &Samples::U8(vec![0, 128, 255, 128]));
}

#[test]
fn colours_come_back_from_exr_as_the_same_bytes() {
    let image = Image::from_fn(256, 1, |x, _| [x as u8, 255 - x as u8, 7]);
    let back = read(&exr(&image)).unwrap();
    assert!((0..256).all(|x| back.rgb8(x, 0) == image.rgb8(x, 0)));
}

#[test]
fn sixteen_bit_colours_become_linear_and_data_stay_proportional() {
    let value = 0x8080u16;
    let colour =
        encoded(ImageBuffer::from_pixel(1, 1, image::Rgba([value, 0, 0xffff, value])), ImageFormat::Png);
    let grey = encoded(ImageBuffer::from_pixel(1, 1, image::Luma([value])), ImageFormat::Png);
    let fraction = f32::from(value) / 65_535.0;
    // 0x8080 is the same fraction as the byte 0x80.
    let linear = srgb_to_linear(0x80);
    let cases = [
        (&colour, Encoding::Auto, vec![linear, 0.0, 1.0, fraction]),
        (&colour, Encoding::Color, vec![linear, 0.0, 1.0, fraction]),
        (&colour, Encoding::Data, vec![fraction, 0.0, 1.0, fraction]),
        (&grey, Encoding::Auto, vec![fraction]),
        (&grey, Encoding::Color, vec![linear]),
        (&grey, Encoding::Data, vec![fraction]),
    ];
    for (file, encoding, expected) in cases {
        let image = decode_image(file, encoding, &ReadLimits::default()).unwrap();
        let found = floats(&image);
        assert!(
            found.iter().zip(&expected).all(|(a, b)| (a - b).abs() < 1e-6),
            "{encoding:?}: {found:?} instead of {expected:?}"
        );
    }
    assert_eq!(linear_to_srgb(linear), 0x80);
}

#[test]
fn palettes_and_few_bits_are_expanded() {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 3, 1);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Two);
    encoder.set_palette(vec![10, 20, 30, 40, 50, 60, 70, 80, 90]);
    encoder.set_trns(vec![255, 0, 128]);
    encoder.write_header().unwrap().write_image_data(&[0b00_01_10_00]).unwrap();
    let image = read(&file).unwrap();
    assert_eq!(image.channels(), 4);
    assert_eq!(image.samples(), &Samples::U8(vec![10, 20, 30, 255, 40, 50, 60, 0, 70, 80, 90, 128]));
}

#[test]
fn a_palette_of_broken_colours_is_an_error() {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, 3, 1);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_palette(vec![1, 2, 3, 4]);
    encoder.write_header().unwrap().write_image_data(&[0, 0, 1]).unwrap();
    let error = read(&file).unwrap_err().to_string();
    assert!(error.contains("4 bytes"), "{error}");
}

#[test]
fn every_format_is_told_by_its_content() {
    let picture = ImageBuffer::from_fn(5, 4, |x, y| image::Rgb([x as u8 * 40, y as u8 * 50, 100]));
    for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::Bmp, ImageFormat::WebP] {
        let image = read(&encoded(picture.clone(), format)).unwrap();
        assert_eq!((image.width(), image.height(), image.channels()), (5, 4, 3), "{format:?}");
        assert_eq!(image.rgb8(4, 3), [160, 150, 100], "{format:?}");
    }
    let jpeg = read(&encoded(picture, ImageFormat::Jpeg)).unwrap();
    assert_eq!((jpeg.width(), jpeg.height(), jpeg.channels()), (5, 4, 3));
}

#[test]
fn float_tiff_of_one_channel_is_read() {
    let mut file = Cursor::new(Vec::new());
    let mut encoder = tiff::encoder::TiffEncoder::new(&mut file).unwrap();
    let heights = [-1.5f32, 0.0, 2.25, 1e6];
    encoder.write_image::<tiff::encoder::colortype::Gray32Float>(2, 2, &heights).unwrap();
    let image = read(&file.into_inner()).unwrap();
    assert_eq!((image.width(), image.channels()), (2, 1));
    assert_eq!(floats(&image), heights);
}

#[test]
fn a_sample_that_is_not_finite_is_named() {
    for (bad, shown) in [(f32::NAN, "NaN"), (f32::INFINITY, "inf"), (f32::NEG_INFINITY, "-inf")] {
        let mut values = vec![0.5; 4 * 3 * 3];
        values[(2 * 4 + 1) * 3 + 1] = bad;
        values[(2 * 4 + 3) * 3] = bad;
        let image = Image::new(4, 3, 3, Samples::F32(values)).unwrap();
        let error = read(&exr(&image)).unwrap_err().to_string();
        assert!(error.contains("x 1, y 2, channel 1") && error.contains(shown), "{error}");
    }
}

fn exr_with_channels(names: &[&str]) -> Vec<u8> {
    use exr::prelude::*;
    let channel = |(i, &name): (usize, &&str)| AnyChannel::new(name, FlatSamples::F32(vec![i as f32; 4]));
    let channels = AnyChannels::sort(names.iter().enumerate().map(channel).collect());
    let mut out = Cursor::new(Vec::new());
    Image::from_channels((2, 2), channels).write().to_buffered(&mut out).unwrap();
    out.into_inner()
}

#[test]
fn exr_channels_are_chosen_by_name() {
    let cases: [(&[&str], &[f32]); 7] = [
        (&["B", "G", "R", "A"], &[2.0, 1.0, 0.0, 3.0]),
        (&["Z", "R", "G", "B", "id", "mask"], &[1.0, 2.0, 3.0]),
        (&["x", "Y", "z"], &[0.0, 1.0, 2.0]),
        (&["Y", "A", "N"], &[0.0, 1.0]),
        (&["depth.Z"], &[0.0]),
        (&["depth.Z", "diffuse.R", "diffuse.G", "diffuse.B"], &[1.0, 2.0, 3.0]),
        (&["u", "v"], &[0.0, 1.0]),
    ];
    for (names, expected) in cases {
        let image = read(&exr_with_channels(names)).unwrap();
        assert_eq!(&floats(&image)[..expected.len()], expected, "{names:?}");
        assert_eq!(image.channels(), expected.len(), "{names:?}");
    }
    let error = read(&exr_with_channels(&["a1", "b2", "c3", "d4", "e5"])).unwrap_err();
    assert!(error.to_string().contains("a1, b2, c3, d4, e5"), "{error}");
}

#[test]
fn a_picture_that_is_too_large_is_refused_by_its_header() {
    // There are no pixels behind this header: decoding would fail otherwise.
    let mut png = Vec::new();
    let mut writer = png::Encoder::new(&mut png, 20_000, 20_000).write_header().unwrap();
    writer.write_chunk(png::chunk::IDAT, &[0x78, 0x9c]).unwrap();
    drop(writer);
    let error = read(&png).unwrap_err();
    assert_eq!(error, ReadError::TooManyPixels { width: 20_000, height: 20_000, limit: 16_384 });
    assert!(error.to_string().contains("20000 × 20000") && error.to_string().contains("16384"), "{error}");

    let limits = ReadLimits { picture_bytes: 1 << 20, ..ReadLimits::default() };
    let picture = encoded(ImageBuffer::from_pixel(600, 600, image::Rgb([1u8, 2, 3])), ImageFormat::Jpeg);
    let error = decode_image(&picture, Encoding::Auto, &limits).unwrap_err();
    assert!(matches!(error, ReadError::TooLarge { bytes: 1_080_000, .. }), "{error}");
    assert!(error.to_string().contains("600 × 600"), "{error}");

    let picture = exr(&Image::new(600, 600, 1, Samples::F32(vec![0.0; 360_000])).unwrap());
    let error = decode_image(&picture, Encoding::Auto, &limits).unwrap_err();
    assert!(matches!(error, ReadError::TooLarge { bytes: 1_440_000, .. }), "{error}");
}

#[test]
fn one_pixel_is_a_picture() {
    let image = Image::from_fn(1, 1, |_, _| [9u8]);
    assert_eq!(read(&png(&image)).unwrap(), image);
}

#[test]
fn what_is_no_picture_is_described() {
    assert_eq!(read(&[]), Err(ReadError::Empty));
    let error = read(b"<svg width=").unwrap_err().to_string();
    assert!(error.contains("PNG") && error.contains("<svg wid"), "{error}");
    let gif = read(b"GIF89a\x01\x00\x01\x00").unwrap_err();
    assert!(matches!(gif, ReadError::UnknownFormat { .. }), "{gif}");
}

#[test]
fn a_camera_orientation_is_applied() {
    let mut picture = encoded(ImageBuffer::from_pixel(16, 8, image::Rgb([1u8, 2, 3])), ImageFormat::Jpeg);
    // An APP1 segment with one big-endian entry: orientation (0x112) 6, a quarter turn.
    let exif = b"\xff\xe1\x00\x22Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
    picture.splice(2..2, exif.iter().copied());
    let image = read(&picture).unwrap();
    assert_eq!((image.width(), image.height()), (8, 16));
}
