//! The byte form in which values lie in the disk cache: little-endian numbers and length-prefixed arrays.

/// Appends numbers and arrays to a byte buffer.
#[derive(Default)]
pub struct Writer(Vec<u8>);

impl Writer {
    /// An empty buffer.
    pub fn new() -> Self {
        Self::default()
    }
    /// Appends a number.
    pub fn u64(&mut self, value: u64) -> &mut Self {
        self.0.extend_from_slice(&value.to_le_bytes());
        self
    }
    /// Appends a length and that many bytes.
    pub fn bytes(&mut self, bytes: &[u8]) -> &mut Self {
        self.u64(bytes.len() as u64);
        self.0.extend_from_slice(bytes);
        self
    }
    /// Appends a text.
    pub fn text(&mut self, text: &str) -> &mut Self {
        self.bytes(text.as_bytes())
    }
    /// Appends an array of plain numbers.
    pub fn array<T: bytemuck::NoUninit>(&mut self, items: &[T]) -> &mut Self {
        self.bytes(bytemuck::cast_slice(items))
    }
    /// The buffer.
    pub fn finish(self) -> Vec<u8> {
        self.0
    }
}

/// Reads what [`Writer`] wrote; any damage is an error, never a panic or a huge allocation.
pub struct Reader<'a>(&'a [u8]);

impl<'a> Reader<'a> {
    /// Starts at the first byte.
    pub fn new(bytes: &'a [u8]) -> Self {
        Self(bytes)
    }

    fn take(&mut self, n: usize) -> Result<&'a [u8], String> {
        let (head, tail) = self.0.split_at_checked(n).ok_or("the data ends too early")?;
        self.0 = tail;
        Ok(head)
    }

    /// A number.
    ///
    /// # Errors
    /// If the data ends too early.
    pub fn u64(&mut self) -> Result<u64, String> {
        let bytes = self.take(8)?;
        Ok(u64::from_le_bytes(bytes.try_into().map_err(|_| "the data ends too early")?))
    }

    /// A number that counts things in memory.
    ///
    /// # Errors
    /// If the data ends too early or the number is too large.
    pub fn usize(&mut self) -> Result<usize, String> {
        usize::try_from(self.u64()?).map_err(|_| "a count is too large".to_owned())
    }

    /// A number of 32 bits.
    ///
    /// # Errors
    /// If the data ends too early or the number is too large.
    pub fn u32(&mut self) -> Result<u32, String> {
        u32::try_from(self.u64()?).map_err(|_| "a number is too large".to_owned())
    }

    /// Length-prefixed bytes.
    ///
    /// # Errors
    /// If the data ends too early.
    pub fn bytes(&mut self) -> Result<&'a [u8], String> {
        let n = self.usize()?;
        self.take(n)
    }

    /// A text.
    ///
    /// # Errors
    /// If the data ends too early or is not UTF-8.
    pub fn text(&mut self) -> Result<String, String> {
        String::from_utf8(self.bytes()?.to_vec()).map_err(|error| error.to_string())
    }

    /// An array of plain numbers.
    ///
    /// # Errors
    /// If the data ends too early or the length is not a multiple of the number's size.
    pub fn array<T: bytemuck::AnyBitPattern>(&mut self) -> Result<Vec<T>, String> {
        let bytes = self.bytes()?;
        if size_of::<T>() == 0 || bytes.len() % size_of::<T>() != 0 {
            return Err("an array's length does not fit its type".to_owned());
        }
        Ok(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect())
    }

    /// Checks that nothing is left.
    ///
    /// # Errors
    /// If bytes are left.
    pub fn end(self) -> Result<(), String> {
        if self.0.is_empty() { Ok(()) } else { Err(format!("{} bytes too many", self.0.len())) }
    }
}

/// The bytes of a value whose form is derived from its fields (postcard's wire format).
pub fn pack<T: serde::Serialize>(value: &T) -> Option<Vec<u8>> {
    postcard::to_stdvec(value).ok()
}

/// Reads what [`pack`] wrote; any damage is an error.
///
/// # Errors
/// If the bytes are no such value, or bytes are left.
pub fn unpack<T: serde::de::DeserializeOwned>(bytes: &[u8]) -> Result<T, String> {
    match postcard::take_from_bytes(bytes) {
        Ok((value, [])) => Ok(value),
        Ok((_, rest)) => Err(format!("{} bytes too many", rest.len())),
        Err(error) => Err(error.to_string()),
    }
}
