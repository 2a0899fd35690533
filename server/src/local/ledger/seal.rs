//! The checksum of a row: over the name of its table, its key and its content.
//!
//! A row begins with a mark and the CRC-32, then comes the content. *Invariant:* a row is read as it was stored under
//! this key of this table, or not at all. Rows of ledgers before schema 10 have no seal; they begin as JSON or as a log
//! does, which no sealed row can do.

use serde::Serialize;

use super::storage;
use crate::log::is_log;
use crate::reason::Refusal;

/// First byte of a sealed row.
const MARK: u8 = 1;
/// Mark and checksum.
pub(super) const HEAD: usize = 5;
/// Initial capacity of a new row, bytes; the rows of almost all jobs are shorter.
const ROOM: usize = 2048;

fn crc(table: &str, key: &str, content: &[u8]) -> [u8; 4] {
    let mut hash = crc32fast::Hasher::new();
    for part in [table.as_bytes(), b"\0", key.as_bytes(), b"\0", content] {
        hash.update(part);
    }
    hash.finalize().to_le_bytes()
}

/// Gives the row in a buffer, which begins with room for it, its head.
fn sealed(table: &str, key: &str, mut row: Vec<u8>) -> Vec<u8> {
    let crc = crc(table, key, row.get(HEAD..).unwrap_or_default());
    row.iter_mut().zip([MARK].into_iter().chain(crc)).for_each(|(to, byte)| *to = byte);
    row
}

/// The row of a value.
pub(super) fn json(table: &str, key: &str, value: &impl Serialize) -> Result<Vec<u8>, Refusal> {
    let mut row = Vec::with_capacity(ROOM);
    row.resize(HEAD, 0);
    serde_json::to_writer(&mut row, value).map_err(storage)?;
    Ok(sealed(table, key, row))
}

/// The row of a content.
pub(super) fn bytes(table: &str, key: &str, content: &[u8]) -> Vec<u8> {
    sealed(table, key, [&[0; HEAD], content].concat())
}

/// Whether a row has no seal because it was written before there were any.
pub(super) fn is_plain(row: &[u8]) -> bool {
    row.first() == Some(&b'{') || is_log(row)
}

/// The content of a row; none if it is not the one that was stored.
pub(super) fn content<'r>(table: &str, key: &str, row: &'r [u8]) -> Option<&'r [u8]> {
    if is_plain(row) { Some(row) } else { sealed_content(table, key, row) }
}

/// Same of a row that has a seal.
pub(super) fn sealed_content<'r>(table: &str, key: &str, row: &'r [u8]) -> Option<&'r [u8]> {
    let (head, content) = row.split_first_chunk::<HEAD>()?;
    let expected = std::iter::once(MARK).chain(crc(table, key, content));
    head.iter().copied().eq(expected).then_some(content)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_read_as_it_was_stored_under_its_key_or_not_at_all() {
        let row = json("job", "t/id", &serde_json::json!({"events": 7})).unwrap();
        assert_eq!(content("job", "t/id", &row).unwrap(), b"{\"events\":7}");
        assert_eq!((content("job", "t/ie", &row), content("work", "t/id", &row)), (None, None));
        for bit in 0..row.len() * 8 {
            let mut damaged = row.clone();
            damaged[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(content("job", "t/id", &damaged), None, "bit {bit}");
        }
        for length in 0..row.len() {
            assert_eq!(content("job", "t/id", &row[..length]), None, "{length}");
        }
        assert_eq!(content("log", "id", &bytes("log", "id", b"")).unwrap(), b"");
        assert_eq!(content("job", "id", b"{\"of an earlier\":1}").unwrap(), b"{\"of an earlier\":1}");
    }
}
