//! Changes to the file of identities.
//!
//! Invariants: a reader finds the old content or the new one, never a part; the new one has no error; everything that
//! is not changed stays as its owner wrote it, including comments, and so do owner and mode of the file. Only its owner
//! can read a new file.

use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::Path;

use tempfile::NamedTempFile;
use toml_edit::{DocumentMut, Item, Table};

use super::file::KnownIdentities;

/// A token as the file has it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TokenRecord {
    /// Name in the audit log.
    pub name: String,
    /// Tenant of its caller.
    pub tenant: String,
    /// Role of its caller.
    pub role: String,
    /// Digest of the token.
    pub sha256: String,
    /// When it expires, seconds since 1970; none = never.
    pub expires_s: Option<u64>,
}

impl TokenRecord {
    fn read(table: &Table) -> Self {
        let text = |key: &str| table.get(key).and_then(Item::as_str).unwrap_or_default().to_owned();
        let expires_s = table.get("expires_s").and_then(Item::as_integer).and_then(|at| at.try_into().ok());
        Self { name: text("name"), tenant: text("tenant"), role: text("role"), sha256: text("sha256"), expires_s }
    }
}

/// The tokens of a file, in its order.
///
/// # Errors
/// When the file cannot be read or has an error.
pub fn rows(path: &Path) -> Result<Vec<TokenRecord>, String> {
    named(
        path,
        read(path).and_then(|text| parsed(&text)).map(|document| tables(&document).map(TokenRecord::read).collect()),
    )
}

/// Adds a row to a file, which is created if it does not exist.
///
/// # Errors
/// When the file cannot be read or written, or has an error.
pub fn add_row(path: &Path, row: &str) -> Result<(), String> {
    change(path, true, |text| {
        Ok(if text.is_empty() { row.to_owned() } else { format!("{}\n\n{row}", text.trim_end()) })
    })
}

/// Removes the token with this digest, and the comment right above its row.
///
/// # Errors
/// When the file has no such token, cannot be read or written, or has an error.
pub fn remove(path: &Path, sha256: &str) -> Result<(), String> {
    change(path, false, |text| without(text, sha256))
}

fn named<T>(path: &Path, done: Result<T, String>) -> Result<T, String> {
    done.map_err(|error| format!("'{}': {error}", path.display()))
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| error.to_string())
}

fn parsed(text: &str) -> Result<DocumentMut, String> {
    KnownIdentities::parse(text)?;
    let document: DocumentMut = text.parse().map_err(|error: toml_edit::TomlError| error.to_string())?;
    match document.get("token") {
        Some(item) if !item.is_array_of_tables() => {
            Err("write each token under a line [[token]] of its own".to_owned())
        }
        _ => Ok(document),
    }
}

fn tables(document: &DocumentMut) -> impl Iterator<Item = &Table> {
    document.get("token").and_then(Item::as_array_of_tables).into_iter().flatten()
}

/// The text without the row of a token.
fn without(text: &str, sha256: &str) -> Result<String, String> {
    let mut document = parsed(text)?;
    let at = tables(&document).position(|table| TokenRecord::read(table).sha256 == sha256);
    let removed = document.get_mut("token").and_then(Item::as_array_of_tables_mut).zip(at);
    let Some((place, head)) = removed.and_then(|(tokens, at)| {
        let table = tokens.get(at)?;
        let head = table.decor().prefix().and_then(|prefix| prefix.as_str()).unwrap_or_default().to_owned();
        let place = table.position();
        tokens.remove(at);
        Some((place, head))
    }) else {
        return Err(format!("there is no token with the sha256 {sha256}"));
    };
    // Comments that an empty line separates from the row are not about it.
    let kept = head.rfind("\n\n").map_or("", |end| &head[..=end]);
    let next = all_tables(&mut document).filter(|table| table.position() > place).min_by_key(|table| table.position());
    match next {
        Some(next) => {
            let own = next.decor().prefix().and_then(|prefix| prefix.as_str()).unwrap_or_default().to_owned();
            next.decor_mut().set_prefix(format!("{kept}{own}"));
        }
        None => {
            let own = document.trailing().as_str().unwrap_or_default().to_owned();
            document.set_trailing(format!("{kept}{own}"));
        }
    }
    Ok(document.to_string())
}

/// The tables of all lists.
fn all_tables(document: &mut DocumentMut) -> impl Iterator<Item = &mut Table> {
    document.iter_mut().filter_map(|(_, item)| item.as_array_of_tables_mut()).flat_map(|list| list.iter_mut())
}

/// Replaces a file by a changed one. Changes at the same time come one after the other.
fn change(path: &Path, make: bool, edit: impl FnOnce(&str) -> Result<String, String>) -> Result<(), String> {
    named(path, replaced(path, make, edit))
}

fn replaced(path: &Path, make: bool, edit: impl FnOnce(&str) -> Result<String, String>) -> Result<(), String> {
    let io = |error: io::Error| error.to_string();
    // The target of a link is changed, not the link.
    let path = if path.exists() { &*path.canonicalize().map_err(io)? } else { path };
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    #[cfg(unix)]
    let held = File::open(folder).map_err(io)?;
    #[cfg(unix)]
    held.lock().map_err(io)?;
    let before = match fs::read_to_string(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound && make => String::new(),
        text => text.map_err(io)?,
    };
    parsed(&before)?;
    let after = edit(&before)?;
    parsed(&after)?;
    let mut file = NamedTempFile::new_in(folder).map_err(io)?;
    if let Ok(data) = fs::metadata(path) {
        keep_owner(file.as_file(), &data).map_err(io)?;
    }
    file.write_all(after.as_bytes()).and_then(|()| file.as_file().sync_all()).map_err(io)?;
    file.persist(path).map_err(|error| error.to_string())?;
    #[cfg(unix)]
    held.sync_all().map_err(io)?;
    Ok(())
}

/// Gives a file the owner and the mode of another one.
fn keep_owner(file: &File, data: &fs::Metadata) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::{MetadataExt as _, fchown};
        let made = file.metadata()?;
        if (made.uid(), made.gid()) != (data.uid(), data.gid()) {
            fchown(file, Some(data.uid()), Some(data.gid()))?;
        }
    }
    file.set_permissions(data.permissions())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::access::{Role, token};

    fn row(name: &str) -> (String, String) {
        let (_, row) = token::create(name, "t", Role::Submit, None).unwrap();
        let digest = row.split("sha256 = \"").nth(1).unwrap()[..64].to_owned();
        (row, digest)
    }

    #[test]
    fn rows_come_and_go_and_everything_else_stays_as_it_was_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("access.toml");
        let ((a, of_a), (b, of_b), (c, of_c)) = (row("a"), row("b"), row("c"));
        let certificate = "[[certificate]] # cells\nname = 'cell-3'   # of the hall\ntenant=\"t\"\nrole = \"read\"\n";
        let head = "# Who may call.\n# Ask Kim.\n\n";
        fs::write(&path, format!("{head}# the builds\n{a}\n# cells\n{certificate}\n# the end\n")).unwrap();
        add_row(&path, &b).unwrap();
        add_row(&path, &c).unwrap();
        let text = format!("{head}# the builds\n{a}\n# cells\n{certificate}\n# the end\n\n{b}\n{c}");
        assert_eq!(fs::read_to_string(&path).unwrap(), text);
        let names = |path: &Path| rows(path).unwrap().into_iter().map(|row| row.name).collect::<Vec<_>>();
        assert_eq!(names(&path), ["a", "b", "c"]);
        remove(&path, &of_a).unwrap();
        let text = format!("{head}\n# cells\n{certificate}\n# the end\n\n{b}\n{c}");
        assert_eq!(fs::read_to_string(&path).unwrap().replace("\n\n\n", "\n\n"), text.replace("\n\n\n", "\n\n"));
        remove(&path, &of_c).unwrap();
        remove(&path, &of_b).unwrap();
        assert_eq!(names(&path), [""; 0]);
        let left = fs::read_to_string(&path).unwrap();
        assert!(left.starts_with(head) && left.contains(certificate) && left.contains("# the end\n"), "{left}");
        assert!(remove(&path, &of_b).unwrap_err().contains("there is no token"));
    }

    #[test]
    fn a_file_with_an_error_or_without_tables_is_not_changed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("access.toml");
        let (new, digest) = row("new");
        let inline = format!("token = [{{ name = \"a\", tenant = \"t\", role = \"read\", sha256 = \"{digest}\" }}]\n");
        for text in ["[[tokens]]\n", "[[token]]\nname = \"a\"\n", inline.as_str()] {
            fs::write(&path, text).unwrap();
            for done in [add_row(&path, &new), remove(&path, &digest), rows(&path).map(drop)] {
                assert!(done.unwrap_err().contains("access.toml"), "{text}");
            }
            assert_eq!(fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left");
    }

    #[cfg(unix)]
    #[test]
    fn a_new_file_is_for_its_owner_only_and_an_old_one_keeps_its_mode_and_its_link() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let (path, link) = (folder.path().join("access.toml"), folder.path().join("link.toml"));
        let mode = || fs::metadata(&path).unwrap().permissions().mode() & 0o777;
        add_row(&path, &row("a").0).unwrap();
        assert_eq!(mode(), 0o600);
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&path, &link).unwrap();
        add_row(&link, &row("b").0).unwrap();
        assert_eq!((mode(), rows(&path).unwrap().len()), (0o640, 2));
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }
}
