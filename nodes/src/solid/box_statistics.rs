//! Plain statistics of the channels of a volume.

use crate::control::{Cancelled, Control, check};
use crate::data::{Map, Volume};

/// Statistics of one channel of one map. Bytes count as 0 to 255, other samples as they are.
#[derive(Clone, Debug, PartialEq)]
pub struct ChannelStatistics {
    /// The map and, where it has several channels, the channel: `color.r`, `roughness`.
    pub name: String,
    /// The arithmetic mean.
    pub mean: f64,
    /// The standard deviation (of the whole box, not an estimate from a sample).
    pub std: f64,
    /// The smallest value.
    pub min: f64,
    /// The largest value.
    pub max: f64,
    /// The entropy of the histogram of 256 equal bins (0 to 255 for bytes, smallest to largest value
    /// otherwise), in bits: 0 for one value, 8 for all bins alike.
    pub entropy: f64,
}

/// The statistics of every channel of a volume, in order.
///
/// # Errors
/// [`Cancelled`].
pub fn box_statistics(volume: &Volume, control: &dyn Control) -> Result<Vec<ChannelStatistics>, Cancelled> {
    let mut all = Vec::new();
    for map in &volume.maps {
        for channel in 0..map.channels {
            check(control)?;
            all.push(channel_statistics(map, channel));
        }
    }
    Ok(all)
}

fn channel_statistics(map: &Map, channel: usize) -> ChannelStatistics {
    let bytes = matches!(map.samples, crate::data::Samples::U8(_));
    let scale = if bytes { 255.0 } else { 1.0 };
    let values = || {
        let picks = (channel..map.samples.len()).step_by(map.channels.max(1));
        picks.map(|i| f64::from(map.samples.get(i)) * scale)
    };
    let (mut count, mut sum, mut min, mut max) = (0u64, 0.0, f64::INFINITY, f64::NEG_INFINITY);
    for value in values() {
        count += 1;
        sum += value;
        min = min.min(value);
        max = max.max(value);
    }
    let n = count.max(1) as f64;
    let mean = sum / n;
    let (low, high) = if bytes { (0.0, 256.0) } else { (min, max) };
    let mut bins = [0u64; 256];
    let mut squares = 0.0;
    for value in values() {
        squares += (value - mean) * (value - mean);
        let bin = if high > low { (value - low) / (high - low) * 256.0 } else { 0.0 };
        // Bytes come back from fractions with a rounding error of far less than half a bin.
        bins[(bin + if bytes { 0.5 } else { 0.0 }).clamp(0.0, 255.0) as usize] += 1;
    }
    let entropy = bins.iter().filter(|&&bin| bin > 0).map(|&bin| {
        let p = bin as f64 / n;
        -p * libm::log2(p)
    });
    ChannelStatistics {
        name: channel_name(map, channel),
        mean,
        std: (squares / n).sqrt(),
        min,
        max,
        entropy: entropy.sum::<f64>().max(0.0),
    }
}

fn channel_name(map: &Map, channel: usize) -> String {
    let letter = match (map.channels, channel) {
        (1, _) => return map.name.clone(),
        (3 | 4, 0) => "r",
        (3 | 4, 1) => "g",
        (3 | 4, 2) => "b",
        (4, _) => "a",
        _ => return format!("{}.{channel}", map.name),
    };
    format!("{}.{letter}", map.name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Samples;

    fn volume(samples: Samples, channels: usize) -> Volume {
        let size = [samples.len() / channels, 1, 1];
        let maps = vec![Map { name: "color".into(), channels, samples }];
        Volume { size, origin: [0; 3], spacing: [1.0; 3], maps }
    }

    #[test]
    fn every_byte_once_has_eight_bits_of_entropy() {
        let all = box_statistics(&volume(Samples::U8((0..=255).collect()), 1), &()).unwrap();
        let [s] = &all[..] else { panic!("{all:?}") };
        assert!((s.entropy - 8.0).abs() < 1e-9, "{s:?}");
        assert!((s.mean - 127.5).abs() < 1e-3 && (s.std - 73.9).abs() < 0.01, "{s:?}");
        assert_eq!((s.min.round(), s.max.round()), (0.0, 255.0));
    }

    #[test]
    fn a_constant_channel_has_neither_spread_nor_entropy() {
        let all = box_statistics(&volume(Samples::F32(vec![0.25; 30]), 3), &()).unwrap();
        let names: Vec<_> = all.iter().map(|s| s.name.as_str()).collect();
        assert_eq!(names, ["color.r", "color.g", "color.b"]);
        assert!(all.iter().all(|s| s.std == 0.0 && s.entropy == 0.0 && s.mean == 0.25), "{all:?}");
    }
}
