//! OpenEXR pictures: one group of channels of the first flat layer.

use std::io::Cursor;

use exr::image::{AnyChannel, FlatSamples};
use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers, read};

use super::decode_image::finite;
use super::{ReadError, ReadLimits};
use crate::data::{Image, Samples};

/// Decodes the data window of the first layer without deep samples.
///
/// Of its channels those named R, G, B and A are taken, or Y and A; failing these, up to four channels of any name in
/// alphabetical order (`X`, `Y`, `Z` of a normal map). Names may be prefixed (`diffuse.R`): the first prefix
/// that serves is taken. Half, float and unsigned samples become `f32` of the same value.
///
/// # Errors
/// See [`ReadError`].
pub(super) fn decode_exr(bytes: &[u8], limits: &ReadLimits) -> Result<Image, ReadError> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(wrap)?;
    let header = meta.headers.iter().find(|header| !header.deep).ok_or_else(|| {
        ReadError::unsupported("OpenEXR", "all its layers are deep; one with flat samples is expected")
    })?;
    let (width, height) = (header.layer_size.x() as u64, header.layer_size.y() as u64);
    let channels = header.channels.list.len() as u64;
    limits.check_picture(width, height, channels.saturating_mul(4))?;
    if width == 0 || height == 0 || channels == 0 {
        let found = format!("the first layer has {width} × {height} pixels of {channels} channels");
        return Err(ReadError::damaged("OpenEXR", found));
    }
    if let Some(channel) = header.channels.list.iter().find(|c| c.sampling != exr::math::Vec2(1, 1)) {
        let found = format!("channel `{}` is subsampled; one sample a pixel is expected", channel.name);
        return Err(ReadError::unsupported("OpenEXR", found));
    }

    let reader = read().no_deep_data().largest_resolution_level().all_channels();
    let image =
        reader.first_valid_layer().all_attributes().from_buffered(Cursor::new(bytes)).map_err(wrap)?;
    let layer = image.layer_data;
    // The reader takes the first layer that it can read: not taken on trust to be the one checked above.
    let (width, height) = (layer.size.x(), layer.size.y());
    let names: Vec<String> = layer.channel_data.list.iter().map(|channel| channel.name.to_string()).collect();
    let chosen = choose(&names).ok_or_else(|| {
        let found =
            format!("its channels are {}; R, G, B, A or Y, or at most four are expected", names.join(", "));
        ReadError::unsupported("OpenEXR", found)
    })?;
    let pixels = width.saturating_mul(height);
    let mut samples = vec![0.0; pixels.saturating_mul(chosen.len())];
    for (c, &from) in chosen.iter().enumerate() {
        let channel: &AnyChannel<FlatSamples> = &layer.channel_data.list[from];
        let values = channel.sample_data.values_as_f32();
        samples
            .iter_mut()
            .skip(c)
            .step_by(chosen.len())
            .zip(values)
            .for_each(|(sample, value)| *sample = value);
    }
    let image = Image::new(width as u32, height as u32, chosen.len(), Samples::F32(samples));
    finite(image.map_err(|error| ReadError::damaged("OpenEXR", error))?)
}

fn wrap(error: exr::error::Error) -> ReadError {
    match error {
        exr::error::Error::NotSupported(reason) => ReadError::unsupported("OpenEXR", reason),
        error => ReadError::damaged("OpenEXR", error),
    }
}

/// The indices of the channels to take.
fn choose(names: &[String]) -> Option<Vec<usize>> {
    let split = |name: &str| match name.rsplit_once('.') {
        Some((prefix, last)) => (prefix.to_owned(), last.to_uppercase()),
        None => (String::new(), name.to_uppercase()),
    };
    let split: Vec<_> = names.iter().map(|name| split(name)).collect();
    let mut prefixes: Vec<&str> = split.iter().map(|(prefix, _)| prefix.as_str()).collect();
    prefixes.sort_unstable();
    prefixes.dedup();
    let find = |prefix: &str, last: &str| split.iter().position(|(p, l)| p == prefix && l == last);
    for wanted in [&["R", "G", "B"][..], &["Y"]] {
        for prefix in &prefixes {
            let found: Option<Vec<usize>> = wanted.iter().map(|last| find(prefix, last)).collect();
            // `X`, `Y`, `Z` is a vector, not a luminance.
            if wanted.len() == 1 && (find(prefix, "X").is_some() || find(prefix, "Z").is_some()) {
                continue;
            }
            if let Some(mut found) = found {
                found.extend(find(prefix, "A"));
                return Some(found);
            }
        }
    }
    prefixes.iter().find_map(|prefix| {
        let mut group: Vec<usize> = (0..split.len()).filter(|&i| split[i].0 == *prefix).collect();
        group.sort_by(|&a, &b| split[a].1.cmp(&split[b].1));
        (1..=4).contains(&group.len()).then_some(group)
    })
}
