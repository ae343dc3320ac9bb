//! What can be wrong with a picture or a volume that is read, and how large it may be.

/// Why the bytes of a file are no picture or volume that can be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReadError {
    /// The file has no bytes.
    #[error("the file is empty")]
    Empty,
    /// The first bytes are those of no known format.
    #[error("expected {expected}, but the file begins with {found}")]
    UnknownFormat {
        /// The formats that are known.
        expected: &'static str,
        /// The first bytes.
        found: String,
    },
    /// The content contradicts its format or ends too early.
    #[error("the {format} file is damaged or cut short: {reason}")]
    Damaged {
        /// The format's name.
        format: &'static str,
        /// What was found.
        reason: String,
    },
    /// A valid file of a kind that is not read.
    #[error("this kind of {format} file is not read: {reason}")]
    Unsupported {
        /// The format's name.
        format: &'static str,
        /// What was found, and what is read instead.
        reason: String,
    },
    /// A side of a picture is too long.
    #[error("the picture has {width} × {height} pixels; at most {limit} a side are read")]
    TooManyPixels {
        /// Pixels in a row.
        width: u64,
        /// Rows.
        height: u64,
        /// [`ReadLimits::side`].
        limit: u32,
    },
    /// The decoded samples would take too much memory.
    #[error("{what} takes {} MiB in memory; the limit is {} MiB", bytes.div_ceil(1 << 20), limit >> 20)]
    TooLarge {
        /// The size in pixels or voxels, and the number type.
        what: String,
        /// Bytes needed.
        bytes: u64,
        /// The limit in bytes.
        limit: u64,
    },
    /// A sample is NaN, infinite, or outside of what the samples in memory can hold.
    #[error("the sample at {place} is {value}; {expected}")]
    BadSample {
        /// Coordinates and channel, each counted from 0.
        place: String,
        /// The sample.
        value: String,
        /// What it should be.
        expected: &'static str,
    },
}

impl ReadError {
    pub(super) fn damaged(format: &'static str, reason: impl std::fmt::Display) -> Self {
        Self::Damaged { format, reason: reason.to_string() }
    }

    pub(super) fn unsupported(format: &'static str, reason: impl std::fmt::Display) -> Self {
        Self::Unsupported { format, reason: reason.to_string() }
    }

    pub(super) fn unknown(expected: &'static str, bytes: &[u8]) -> Self {
        let head = bytes.get(..8).unwrap_or(bytes);
        let text: String =
            head.iter().flat_map(|&byte| std::ascii::escape_default(byte)).map(char::from).collect();
        Self::UnknownFormat { expected, found: format!("\"{text}\"") }
    }
}

/// How large a picture or a volume may be; checked against its header, before any sample is decoded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReadLimits {
    /// Longest side of a picture, in pixels.
    pub side: u32,
    /// Most bytes of a picture's samples in memory.
    pub picture_bytes: u64,
    /// Most bytes of a volume's samples in memory.
    pub volume_bytes: u64,
}

impl Default for ReadLimits {
    /// 16,384 pixels a side, 512 MiB a picture, 4 GiB a volume.
    fn default() -> Self {
        Self { side: 16_384, picture_bytes: 512 << 20, volume_bytes: 4 << 30 }
    }
}

impl ReadLimits {
    /// Checks a picture's size.
    ///
    /// # Errors
    /// [`ReadError::TooManyPixels`] or [`ReadError::TooLarge`].
    pub fn check_picture(&self, width: u64, height: u64, bytes_per_pixel: u64) -> Result<(), ReadError> {
        if width.max(height) > u64::from(self.side) {
            return Err(ReadError::TooManyPixels { width, height, limit: self.side });
        }
        let bytes = width.saturating_mul(height).saturating_mul(bytes_per_pixel);
        if bytes > self.picture_bytes {
            let what = format!("a picture of {width} × {height} pixels with {bytes_per_pixel} bytes each");
            return Err(ReadError::TooLarge { what, bytes, limit: self.picture_bytes });
        }
        Ok(())
    }
}
