//! Any bytes are a picture or an error.
#![no_main]

use breccia_nodes::io::{Encoding, ReadLimits, decode_image};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let limits = ReadLimits { side: 4096, picture_bytes: 1 << 24, ..ReadLimits::default() };
    if let Ok(image) = decode_image(bytes, Encoding::Auto, &limits) {
        assert!(image.samples().byte_size() <= limits.picture_bytes);
    }
});
