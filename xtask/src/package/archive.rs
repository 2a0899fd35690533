//! Archives: tar with gzip, and the `ar` of Debian packages.
//!
//! *Invariant:* the same files produce the same bytes: entries are sorted, belong to root and share one time.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use tar::{Builder, EntryType, Header};

/// A file of a package.
#[derive(Debug, Clone)]
pub(super) struct File {
    pub(super) content: Vec<u8>,
    pub(super) executable: bool,
}

/// Files by their path, without a leading `/`.
pub(super) type Files = BTreeMap<String, File>;

fn header(kind: EntryType, size: usize, mode: u32, time: u64) -> Header {
    let mut header = Header::new_gnu();
    header.set_entry_type(kind);
    header.set_size(size as u64);
    header.set_mode(mode);
    header.set_mtime(time);
    header
}

/// Compresses content; the header has no name and no time.
pub(super) fn gzip(content: &[u8], level: u32) -> std::io::Result<Vec<u8>> {
    let mut out = GzEncoder::new(Vec::new(), Compression::new(level));
    out.write_all(content)?;
    out.finish()
}

/// An archive of the files and their folders below `root`, with a time and a compression level.
pub(super) fn tar_gz(files: &Files, root: &str, (time, level): (u64, u32)) -> std::io::Result<Vec<u8>> {
    let mut tar = Builder::new(GzEncoder::new(Vec::new(), Compression::new(level)));
    let parents = |path: &str| Path::new(path).ancestors().skip(1).map(Path::to_path_buf).collect::<Vec<_>>();
    let folders: BTreeSet<_> = files.keys().flat_map(|path| parents(path)).collect();
    for folder in folders {
        let path = format!("{root}/{}/", folder.display()).replace("//", "/");
        tar.append_data(&mut header(EntryType::Directory, 0, 0o755, time), path, std::io::empty())?;
    }
    for (path, file) in files {
        let mode = if file.executable { 0o755 } else { 0o644 };
        let mut header = header(EntryType::Regular, file.content.len(), mode, time);
        tar.append_data(&mut header, format!("{root}/{path}"), file.content.as_slice())?;
    }
    tar.into_inner()?.finish()
}

/// An `ar` archive of a few members with short names.
pub(super) fn ar(members: &[(&str, Vec<u8>)], time: u64) -> Vec<u8> {
    let mut out = b"!<arch>\n".to_vec();
    for (name, content) in members {
        out.extend(format!("{name:<16}{time:<12}0     0     100644  {:<10}`\n", content.len()).into_bytes());
        out.extend(content);
        if content.len() % 2 == 1 {
            out.push(b'\n');
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_files_give_the_same_bytes_below_their_folders() {
        let file = |content: &[u8], executable| File { content: content.to_vec(), executable };
        let files: Files = [
            ("usr/bin/b".to_owned(), file(b"program", true)),
            (format!("usr/share/{}", "long/".repeat(40)), file(b"text", false)),
        ]
        .into();
        let archive = tar_gz(&files, ".", (1_700_000_000, 9)).unwrap();
        assert_eq!(archive, tar_gz(&files, ".", (1_700_000_000, 9)).unwrap());
        let mut tar = tar::Archive::new(flate2::read::GzDecoder::new(archive.as_slice()));
        let entry = |entry: tar::Entry<'_, _>| {
            (entry.path().unwrap().display().to_string(), entry.header().mode().unwrap(), entry.size())
        };
        let entries: Vec<_> = tar.entries().unwrap().map(|one| entry(one.unwrap())).collect();
        let folders: Vec<&str> = entries[..3].iter().map(|(path, ..)| path.as_str()).collect();
        assert_eq!(folders, ["./", "usr/", "usr/bin/"], "a folder comes before its files");
        assert!(entries.contains(&("usr/bin/b".to_owned(), 0o755, 7)), "{entries:?}");
    }

    #[test]
    fn members_of_an_ar_archive_begin_at_even_places() {
        let archive = ar(&[("debian-binary", b"2.0".to_vec()), ("data", b"xy".to_vec())], 7);
        assert_eq!(archive.len(), 8 + 60 + 4 + 60 + 2);
        assert!(archive.starts_with(b"!<arch>\ndebian-binary   7           0     0     100644  3         `\n2.0\n"));
    }
}
