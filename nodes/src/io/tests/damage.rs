//! No bytes whatever may crash a reader, and no part of a file may pass for the whole.

use std::io::Cursor;
use std::sync::LazyLock;

use image::{DynamicImage, ImageBuffer, ImageFormat};
use proptest::prelude::*;

use super::{bytes, floats, volume};
use crate::data::{Image, Samples};
use crate::io::{
    Encoding, NrrdEncoding, ReadLimits, VolumeOptions, decode_image, decode_volume, write_image_exr,
    write_npy, write_nrrd,
};

fn pictures() -> Vec<(&'static str, Vec<u8>)> {
    let picture = ImageBuffer::from_fn(9, 7, |x, y| {
        image::Rgba([x as u8 * 25, y as u8 * 30, (x * y) as u8, 255 - x as u8])
    });
    let rgba = DynamicImage::from(picture);
    let encode = |format: ImageFormat, picture: DynamicImage| {
        let mut out = Cursor::new(Vec::new());
        picture.write_to(&mut out, format).unwrap();
        out.into_inner()
    };
    let floats = Samples::F32((0..9 * 7 * 3).map(|i| i as f32 * 0.1).collect());
    let mut exr = Cursor::new(Vec::new());
    write_image_exr(&Image::new(9, 7, 3, floats).unwrap(), &mut exr).unwrap();
    vec![
        ("PNG", encode(ImageFormat::Png, rgba.clone())),
        ("16-bit PNG", encode(ImageFormat::Png, rgba.to_rgb16().into())),
        ("JPEG", encode(ImageFormat::Jpeg, rgba.to_rgb8().into())),
        ("TIFF", encode(ImageFormat::Tiff, rgba.clone())),
        ("float TIFF", encode(ImageFormat::Tiff, rgba.to_rgb32f().into())),
        ("BMP", encode(ImageFormat::Bmp, rgba.to_rgb8().into())),
        ("WebP", encode(ImageFormat::WebP, rgba)),
        ("EXR", exr.into_inner()),
    ]
}

fn volumes() -> Vec<(&'static str, Vec<u8>)> {
    let (color, height) = (volume([5, 4, 3], "color", 3, bytes), volume([5, 4, 3], "height", 1, floats));
    let (mut npy, mut raw, mut gzip) = (Vec::new(), Vec::new(), Vec::new());
    write_npy(color.size, &color.maps[0], &mut npy).unwrap();
    write_nrrd(&color, &color.maps[0], NrrdEncoding::Raw, &mut raw).unwrap();
    write_nrrd(&height, &height.maps[0], NrrdEncoding::Gzip, &mut gzip).unwrap();
    vec![("NPY", npy), ("NRRD", raw), ("gzipped NRRD", gzip)]
}

fn small() -> ReadLimits {
    ReadLimits { side: 64, picture_bytes: 1 << 16, volume_bytes: 1 << 16 }
}

#[test]
fn no_part_of_a_picture_passes_for_another() {
    for (name, file) in pictures() {
        let read = |bytes: &[u8]| decode_image(bytes, Encoding::Auto, &small());
        let whole = read(&file).unwrap();
        for length in 0..file.len() {
            // Some formats end in bytes that hold no samples.
            if let Ok(part) = read(&file[..length]) {
                assert_eq!(part, whole, "{length} of {} bytes of a {name} file", file.len());
            }
        }
    }
}

#[test]
fn no_part_of_a_volume_passes_for_another() {
    for (name, file) in volumes() {
        let options = VolumeOptions { limits: small(), ..VolumeOptions::default() };
        let whole = decode_volume(&file, &options).unwrap();
        for length in 0..file.len() {
            if let Ok(part) = decode_volume(&file[..length], &options) {
                assert!(name.starts_with("gzip"), "{length} of {} bytes of {name} are enough", file.len());
                assert_eq!(part, whole);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn damaged_files_never_crash(
        which in 0usize..11,
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        static FILES: LazyLock<Vec<(&str, Vec<u8>)>> =
            LazyLock::new(|| pictures().into_iter().chain(volumes()).collect());
        let mut file = FILES[which].1.clone();
        for (at, byte) in changes {
            let at = at.index(file.len());
            file[at] = byte;
        }
        // Whatever comes out, it came out.
        let _ = decode_image(&file, Encoding::Auto, &small());
        let _ = decode_volume(&file, &VolumeOptions { limits: small(), ..VolumeOptions::default() });
    }

    #[test]
    fn random_bytes_never_crash(head in 0usize..5, tail in prop::collection::vec(any::<u8>(), 0..200)) {
        let heads = [&b""[..], b"\x93NUMPY\x01\x00", b"NRRD0005\n", b"\x76\x2f\x31\x01\x02\0\0\0", b"II*\0"];
        let file = [heads[head], &tail].concat();
        let _ = decode_image(&file, Encoding::Auto, &small());
        let _ = decode_volume(&file, &VolumeOptions { limits: small(), ..VolumeOptions::default() });
    }
}
