//! Any bytes are a volume whose numbers fit together, or an error.
#![no_main]

use breccia_nodes::io::{ReadLimits, VolumeOptions, decode_npy};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = ReadLimits { volume_bytes: 1 << 24, ..ReadLimits::default() };
    let options = VolumeOptions { limits, ..VolumeOptions::default() };
    if let Ok(volume) = decode_npy(bytes, &options) {
        let map = &volume.maps[0];
        assert_eq!(map.samples.len(), volume.voxels() * map.channels);
        assert!(volume.spacing.iter().all(|s| s.is_finite() && *s > 0.0));
    }
});
