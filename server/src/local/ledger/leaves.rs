//! Rows in the pages of a damaged ledger, found without its trees.
//!
//! A leaf of a tree is a page that begins with its mark and the number of its rows; then come the ends of all keys,
//! the ends of all rows, the keys and the rows (file format of redb). *Invariant:* a row is found only with its
//! checksum, so a page that looks like a leaf by chance yields nothing. Rows that were changed or removed may still be
//! in pages that are free.

use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom};
use std::path::Path;

use super::seal;

/// Pages begin at multiples of it.
const PAGE: u64 = 4096;
/// First byte of a leaf.
const LEAF: u8 = 1;
/// Largest leaf that is read, bytes.
const LARGEST: usize = 16 << 20;

/// Reads all leaves of a file; `found` gets the table, key and row of each row of these tables.
pub(super) fn rows(path: &Path, tables: &[&str], mut found: impl FnMut(usize, &str, &[u8])) -> io::Result<()> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    let mut page = Vec::new();
    for at in (0..length).step_by(PAGE as usize) {
        read(&mut file, at, PAGE as usize, &mut page)?;
        let Some(count) = count(&page) else { continue };
        let ends = 4 + 8 * count;
        if ends > page.len() {
            read(&mut file, at, ends, &mut page)?;
        }
        let Some(end) = end(&page, 2 * count - 1).filter(|end| *end <= LARGEST) else { continue };
        if end > page.len() {
            read(&mut file, at, end, &mut page)?;
        }
        for number in 0..count {
            let Some((key, row)) = pair(&page, count, number) else { continue };
            let whole = |table: &&str| seal::sealed_content(table, key, row).is_some();
            if let Some(table) = tables.iter().position(whole) {
                found(table, key, row);
            }
        }
    }
    Ok(())
}

/// Reads so many bytes, or as many as there are.
fn read(file: &mut File, at: u64, bytes: usize, page: &mut Vec<u8>) -> io::Result<()> {
    page.clear();
    file.seek(SeekFrom::Start(at))?;
    file.take(bytes as u64).read_to_end(page).map(drop)
}

/// Number of rows of a leaf.
fn count(page: &[u8]) -> Option<usize> {
    let (head, _) = page.split_first_chunk::<4>()?;
    let count = usize::from(u16::from_le_bytes([head[2], head[3]]));
    (head[0] == LEAF && count > 0).then_some(count)
}

/// The end of a key, or behind those of a row.
fn end(page: &[u8], number: usize) -> Option<usize> {
    let bytes = page.get(4 + 4 * number..)?.first_chunk::<4>()?;
    usize::try_from(u32::from_le_bytes(*bytes)).ok()
}

/// Key and row, unless their places are nonsense.
fn pair(page: &[u8], count: usize, number: usize) -> Option<(&str, &[u8])> {
    let key = if number == 0 { 4 + 8 * count } else { end(page, number - 1)? };
    let key = page.get(key..end(page, number)?)?;
    let row = page.get(end(page, count + number - 1)?..end(page, count + number)?)?;
    Some((std::str::from_utf8(key).ok()?, row))
}

#[cfg(test)]
mod tests {
    use redb::{Database, TableDefinition};

    use super::*;

    #[test]
    fn all_rows_are_found_in_any_file_that_has_them() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ledger");
        let table: TableDefinition<'_, &str, &[u8]> = TableDefinition::new("job");
        let content = |number: usize| vec![number as u8; number * 97];
        let database = Database::create(&path).unwrap();
        let txn = database.begin_write().unwrap();
        for number in 0..300 {
            let key = format!("id-{number}");
            let row = seal::bytes("job", &key, &content(number));
            txn.open_table(table).unwrap().insert(key.as_str(), row.as_slice()).unwrap();
        }
        txn.commit().unwrap();
        drop(database);
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[..64].fill(0xaa);
        std::fs::write(&path, &bytes).unwrap();
        let mut found = std::collections::BTreeMap::new();
        rows(&path, &["work", "job"], |table, key, row| {
            assert_eq!(table, 1);
            found.insert(key.to_owned(), seal::content("job", key, row).unwrap().to_vec());
        })
        .unwrap();
        assert_eq!(found.len(), 300);
        assert!((0..300).all(|number| found[&format!("id-{number}")] == content(number)));
        std::fs::write(&path, vec![1; 20_000]).unwrap();
        rows(&path, &["job"], |_, key, _| panic!("{key}")).unwrap();
    }
}
