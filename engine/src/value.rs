//! Type-erased values that flow along links, each with a byte size, a summary and a content digest.

use std::any::Any;
use std::fmt;
use std::sync::Arc;

/// A content digest (blake3): equal digests mean equal content.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Digest(pub [u8; 32]);

impl Digest {
    /// The digest of some bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self(*blake3::hash(bytes).as_bytes())
    }

    /// Reads the 64 hexadecimal digits that a digest is written as.
    pub fn parse(text: &str) -> Option<Self> {
        blake3::Hash::from_hex(text).ok().map(Self::from)
    }
}

impl serde::Serialize for Digest {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> serde::Deserialize<'de> for Digest {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::parse(&text).ok_or_else(|| {
            serde::de::Error::custom(format!("found `{text}`, expected a digest of 64 hexadecimal digits"))
        })
    }
}

impl From<blake3::Hash> for Digest {
    fn from(hash: blake3::Hash) -> Self {
        Self(*hash.as_bytes())
    }
}

impl fmt::Display for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for Digest {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Digest({self})")
    }
}

/// What a Rust type must offer to flow along a link.
pub trait Data: Send + Sync + 'static {
    /// The stable name of the socket type, in lower case (`image`, `solid`), never a Rust path.
    const TYPE: &'static str;

    /// What such a value is, in one line, for the reference pages.
    const DOCS: &'static str;

    /// Bytes held in memory, for the cache's budget.
    fn byte_size(&self) -> u64;

    /// A short human summary such as `128³ RGB, 6.3 MB`.
    fn summary(&self) -> String;

    /// The digest of the content: equal content, equal digest, in every process on every machine.
    fn digest(&self) -> Digest;

    /// The bytes kept by the disk cache, or `None` for values that are cheaper to make again.
    fn encode(&self) -> Option<Vec<u8>> {
        None
    }

    /// The inverse of [`Data::encode`].
    ///
    /// # Errors
    /// A message saying what is wrong with the bytes.
    fn decode(bytes: &[u8]) -> Result<Self, String>
    where
        Self: Sized,
    {
        let _ = bytes;
        Err(format!("values of type {} are not stored on disk", Self::TYPE))
    }
}

/// A socket type: the name and docs of a [`Data`] type, and how to read one back from the disk cache.
#[derive(Clone, Copy)]
pub struct TypeInfo {
    /// [`Data::TYPE`].
    pub name: &'static str,
    /// [`Data::DOCS`].
    pub docs: &'static str,
    /// [`Data::decode`], type-erased.
    pub decode: fn(&[u8]) -> Result<Value, String>,
}

impl TypeInfo {
    /// The description of `T`.
    pub const fn of<T: Data>() -> Self {
        Self { name: T::TYPE, docs: T::DOCS, decode: |bytes| T::decode(bytes).map(Value::new) }
    }
}

trait Erased: Send + Sync {
    fn type_name(&self) -> &'static str;
    fn byte_size(&self) -> u64;
    fn summary(&self) -> String;
    fn digest(&self) -> Digest;
    fn encode(&self) -> Option<Vec<u8>>;
    fn into_any(self: Arc<Self>) -> Arc<dyn Any + Send + Sync>;
}

impl<T: Data> Erased for T {
    fn type_name(&self) -> &'static str {
        T::TYPE
    }
    fn byte_size(&self) -> u64 {
        Data::byte_size(self)
    }
    fn summary(&self) -> String {
        Data::summary(self)
    }
    fn digest(&self) -> Digest {
        Data::digest(self)
    }
    fn encode(&self) -> Option<Vec<u8>> {
        Data::encode(self)
    }
    fn into_any(self: Arc<Self>) -> Arc<dyn Any + Send + Sync> {
        self
    }
}

/// A shared, immutable, type-erased value. Cloning it copies a pointer.
#[derive(Clone)]
pub struct Value(Arc<dyn Erased>);

impl Value {
    /// Erases the type of `data`.
    pub fn new<T: Data>(data: T) -> Self {
        Self(Arc::new(data))
    }

    /// Erases the type of a shared value.
    pub fn from_arc<T: Data>(data: Arc<T>) -> Self {
        Self(data)
    }

    /// The name of the socket type.
    pub fn type_name(&self) -> &'static str {
        self.0.type_name()
    }

    /// See [`Data::byte_size`].
    pub fn byte_size(&self) -> u64 {
        self.0.byte_size()
    }

    /// See [`Data::summary`].
    pub fn summary(&self) -> String {
        self.0.summary()
    }

    /// See [`Data::digest`].
    pub fn digest(&self) -> Digest {
        self.0.digest()
    }

    /// See [`Data::encode`].
    pub fn encode(&self) -> Option<Vec<u8>> {
        self.0.encode()
    }

    /// The value as a `T`, or `None` if it is of another type.
    pub fn downcast<T: Data>(&self) -> Option<Arc<T>> {
        Arc::clone(&self.0).into_any().downcast().ok()
    }

    /// How many owners share the value; 1 means nobody else holds it.
    pub fn owners(&self) -> usize {
        Arc::strong_count(&self.0)
    }
}

impl fmt::Debug for Value {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Value({}: {})", self.type_name(), self.summary())
    }
}
