//! The files of the disk cache: a header that tells damage from content, then the content.

use crate::value::Digest;

const MAGIC: &[u8; 8] = b"BRECCIA\x01";
/// Magic, kind, id, length, checksum.
const HEADER: usize = 8 + 1 + 32 + 8 + 32;

/// What a file of the disk cache holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(crate) enum EntryKind {
    /// A value's encoded bytes.
    Object = 1,
    /// What is known of a node's outputs.
    Record = 2,
}

/// The header of a file with this content.
pub(crate) fn header(kind: EntryKind, id: &Digest, content: &[u8]) -> Vec<u8> {
    let mut header = Vec::with_capacity(HEADER);
    header.extend_from_slice(MAGIC);
    header.push(kind as u8);
    header.extend_from_slice(&id.0);
    header.extend_from_slice(&(content.len() as u64).to_le_bytes());
    header.extend_from_slice(blake3::hash(content).as_bytes());
    header
}

/// The content of a file, if it is whole and the one that its name says.
pub(crate) fn content(kind: EntryKind, id: &Digest, mut file: Vec<u8>) -> Option<Vec<u8>> {
    if file.len() < HEADER {
        return None;
    }
    let content = file.split_off(HEADER);
    (file == header(kind, id, &content)).then_some(content)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_changed_bit_is_noticed() {
        let id = Digest::of(b"id");
        let mut file = header(EntryKind::Object, &id, b"content");
        file.extend_from_slice(b"content");
        assert_eq!(content(EntryKind::Object, &id, file.clone()).as_deref(), Some(&b"content"[..]));
        for i in 0..file.len() {
            let mut damaged = file.clone();
            damaged[i] ^= 1;
            assert_eq!(content(EntryKind::Object, &id, damaged), None, "byte {i}");
            assert_eq!(content(EntryKind::Object, &id, file[..i].to_vec()), None, "cut at {i}");
        }
        assert_eq!(content(EntryKind::Record, &id, file.clone()), None);
        assert_eq!(content(EntryKind::Object, &Digest::of(b"other"), file), None);
    }
}
