//! Volumes as multi-page TIFF files.

use std::io::{self, Seek, Write};

use breccia_engine::{Data, Exporter, Sink, Value};
use tiff::TiffError;
use tiff::encoder::colortype::{ColorType, Gray8, Gray16, Gray32, RGB8, RGBA8};
use tiff::encoder::{Rational, TiffEncoder, TiffKind, TiffValue};
use tiff::tags::{ExtraSamples, ResolutionUnit, Tag};

use super::export::{Pixels, invalid, named_maps, typed};
use crate::data::{Map, Samples, Volume};

/// Exporter of volumes.
pub(super) const EXPORTER: Exporter = Exporter {
    ty: Volume::TYPE,
    extensions: &["tif", "tiff"],
    docs: "TIFF with one page a Z slice and ImageJ's description, 8-bit, labels 16- or 32-bit; further maps as NAME.MAP.tif",
    write: write_files,
};

fn write_files(value: &Value, sink: &mut Sink) -> io::Result<()> {
    let volume = typed::<Volume>(value)?;
    for (i, (name, map)) in named_maps(&volume)?.into_iter().enumerate() {
        let sibling = format!("{}.{name}.{}", sink.stem(), sink.extension());
        let mut out = if i == 0 { sink.main()? } else { sink.file(&sibling)? };
        write_tiff(&volume, map, &mut out)?;
        out.flush()?;
    }
    Ok(())
}

/// More than the tags of a page take.
const TAG_BYTES: u64 = 1024;

/// Writes one map of a volume as a TIFF file with one uncompressed page a Z slice.
///
/// The first page's description is the one that ImageJ writes for a stack (if that has more than 1 KiB): number of slices, spacing along z. The
/// resolution tags hold voxels a unit along x and y. Bytes are kept, float `color` is encoded to 8-bit sRGB, other
/// floats are scaled to 8 bits (0 to 1, or the range given as `min` and `max` in the description), labels take 16 bits,
/// or 32 where they must. The origin stands in the description as `xorigin`, `yorigin` and `zorigin`, in voxels. Files of
/// more than 4 GiB are BigTIFF.
///
/// # Errors
/// If the map has more than four channels, or from `out`.
pub fn write_tiff(volume: &Volume, map: &Map, out: &mut (impl Write + Seek)) -> io::Result<()> {
    let wide = matches!(&map.samples, Samples::U32(v) if v.iter().any(|&label| label > 65_535));
    let pixels = if wide { None } else { Some(Pixels::of_map(map)?) };
    let bits = pixels.as_ref().map_or(32, |p| u64::from(p.bits()));
    let bytes = (map.samples.len() as u64).saturating_mul(bits / 8);
    if bytes.saturating_add((volume.size[2] as u64).saturating_mul(TAG_BYTES)) < u64::from(u32::MAX) {
        write_pages(TiffEncoder::new(out).map_err(to_io)?, volume, map, pixels.as_ref())
    } else {
        write_pages(TiffEncoder::new_big(out).map_err(to_io)?, volume, map, pixels.as_ref())
    }
}

fn write_pages<W: Write + Seek, K: TiffKind>(
    mut encoder: TiffEncoder<W, K>,
    volume: &Volume,
    map: &Map,
    pixels: Option<&Pixels<'_>>,
) -> io::Result<()> {
    let bits = pixels.map_or(32, |p| u64::from(p.bits()));
    let bytes = (map.samples.len() as u64).saturating_mul(bits / 8);
    let text = description(volume, pixels.and_then(Pixels::range), bytes);
    let samples_per_page = volume.size[0].saturating_mul(volume.size[1]).saturating_mul(map.channels);
    let mut bytes = Vec::new();
    for z in 0..volume.size[2] {
        let range = z * samples_per_page..(z + 1) * samples_per_page;
        let text = if z == 0 { text.as_str() } else { "" };
        let Some(pixels) = pixels else {
            let Samples::U32(labels) = &map.samples else {
                return Err(invalid("only labels are written with 32 bits"));
            };
            let labels = labels.get(range).unwrap_or_default();
            write_page::<Gray32, W, K>(&mut encoder, volume, map.channels, text, labels)?;
            continue;
        };
        bytes.clear();
        pixels.push(range, &mut bytes);
        match (pixels.bits(), map.channels) {
            (16, c) => {
                let words: Vec<u16> =
                    bytes.as_chunks().0.iter().map(|&pair| u16::from_be_bytes(pair)).collect();
                write_page::<Gray16, W, K>(&mut encoder, volume, c, text, &words)?;
            }
            (_, 3) => write_page::<RGB8, W, K>(&mut encoder, volume, 3, text, &bytes)?,
            (_, 4) => write_page::<RGBA8, W, K>(&mut encoder, volume, 4, text, &bytes)?,
            (_, c) => write_page::<Gray8, W, K>(&mut encoder, volume, c, text, &bytes)?,
        }
    }
    Ok(())
}

fn write_page<C: ColorType, W: Write + Seek, K: TiffKind>(
    encoder: &mut TiffEncoder<W, K>,
    volume: &Volume,
    channels: usize,
    text: &str,
    samples: &[C::Inner],
) -> io::Result<()>
where
    [C::Inner]: TiffValue,
{
    let side =
        |n: usize| u32::try_from(n).map_err(|_| invalid(format!("a tiff page cannot be {n} pixels wide")));
    let (width, height) = (side(volume.size[0])?, side(volume.size[1])?);
    let mut page = encoder.new_image::<C>(width, height).map_err(to_io)?;
    // One strip a page: ImageJ wants a stack's pixels contiguous.
    page.rows_per_strip(height).map_err(to_io)?;
    let extra = channels.saturating_sub(C::BITS_PER_SAMPLE.len());
    if extra > 0 {
        page.extra_samples(&vec![ExtraSamples::Unspecified; extra]).map_err(to_io)?;
    }
    let tags = page.encoder();
    if !text.is_empty() {
        tags.write_tag(Tag::ImageDescription, text).map_err(to_io)?;
    }
    tags.write_tag(Tag::ResolutionUnit, ResolutionUnit::None.to_u16()).map_err(to_io)?;
    tags.write_tag(Tag::XResolution, per_unit(volume.spacing[0])).map_err(to_io)?;
    tags.write_tag(Tag::YResolution, per_unit(volume.spacing[1])).map_err(to_io)?;
    page.write_strip(samples).map_err(to_io)?;
    page.finish().map_err(to_io)
}

/// ImageJ's description of a stack, but for `images`: that would promise pixels without tags between the pages.
///
/// Readers that see as many bytes before the second page as the whole stack has take them for such pixels all the same:
/// stacks smaller than a page's tags do not claim to be ImageJ's.
fn description(volume: &Volume, range: Option<(f32, f32)>, bytes: u64) -> String {
    let ([_, _, slices], [_, _, spacing], [x, y, z]) = (volume.size, volume.spacing, volume.origin);
    let later_pages = bytes / slices.max(1) as u64 * slices.saturating_sub(1) as u64;
    let program = if later_pages < TAG_BYTES { "Breccia" } else { "ImageJ=1.53t" };
    let mut text = format!(
        "{program}\nslices={slices}\nunit=unit\nspacing={spacing}\nloop=false\n\
         xorigin={x}\nyorigin={y}\nzorigin={z}\n"
    );
    if let Some((lo, hi)) = range {
        text += &format!("min={lo}\nmax={hi}\n");
    }
    text
}

/// Voxels a unit, as a fraction that is exact for spacings of few decimal digits.
fn per_unit(spacing: f32) -> Rational {
    let spacing = if spacing.is_finite() && spacing > 0.0 { f64::from(spacing) } else { 1.0 };
    let scales = std::iter::successors(Some(1_000_000_000u32), |&n| (n > 1).then_some(n / 10));
    let fits = |&n: &u32| spacing * f64::from(n) <= f64::from(u32::MAX);
    let n = scales.into_iter().find(fits).unwrap_or(1);
    Rational { n, d: ((spacing * f64::from(n)).round() as u32).max(1) }
}

fn to_io(error: TiffError) -> io::Error {
    match error {
        TiffError::IoError(error) => error,
        error => invalid(error.to_string()),
    }
}
