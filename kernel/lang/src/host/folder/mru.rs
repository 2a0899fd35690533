//! The stores of most recently used values.
//!
//! *Invariant:* a store is read when it is opened and written when it is closed, in a small XML form of its own: a
//! `key` per line group, a `param` per line. Facts: reference functions.md 7; the form of the file is this project's
//! choice.

use super::{FAILED, MacroFolder, Shelf, text};
use crate::fault::Outcome;
use crate::host::FileFn;
use crate::state::MacroState;
use crate::value::MacroValue;
use std::fmt::Write as _;

/// Name of a store that is opened without one.
const DEFAULT_FILE: &str = "counterpoint-mru.xml";

/// Stores that can be opened in one run.
const MOST: usize = 100;

#[derive(Clone, Debug, Default)]
struct MruKey {
    id: u32,
    name: String,
    parameters: Vec<(String, MacroValue)>,
}

/// An open store; the key used last comes first.
#[derive(Clone, Debug, Default)]
pub(super) struct MruStore {
    file: String,
    keys: Vec<MruKey>,
    next: u32,
}

impl MruStore {
    fn find(&self, name: &str) -> Option<usize> {
        self.keys.iter().position(|key| key.name.eq_ignore_ascii_case(name))
    }

    /// The key, moved to the front; made if `make` is set.
    fn touch(&mut self, name: &str, make: bool) -> Option<&mut MruKey> {
        match self.find(name) {
            Some(at) => {
                let key = self.keys.remove(at);
                self.keys.insert(0, key);
            }
            None if make => {
                self.next += 1;
                self.keys.insert(0, MruKey { id: self.next, name: name.to_owned(), parameters: Vec::new() });
            }
            None => return None,
        }
        self.keys.first_mut()
    }

    fn write(&self) -> String {
        let mut out = String::from("<mru>\n");
        for key in &self.keys {
            let _ = writeln!(out, "<key name=\"{}\">", escaped(&key.name));
            for (name, value) in &key.parameters {
                let items = value.as_sequence().map_or(std::slice::from_ref(value), |items| items);
                let list = matches!(value, MacroValue::Sequence(_));
                let _ = write!(out, "<param name=\"{}\" list=\"{}\">", escaped(name), u8::from(list));
                for item in items {
                    let (kind, text) = flat(item);
                    let _ = write!(out, "<v t=\"{kind}\">{}</v>", escaped(&text));
                }
                out.push_str("</param>\n");
            }
            out.push_str("</key>\n");
        }
        out.push_str("</mru>\n");
        out
    }

    fn read(file: &str, text: &str) -> MruStore {
        let mut store = MruStore { file: file.to_owned(), ..MruStore::default() };
        for line in text.lines() {
            if line.starts_with("<key ") {
                store.next += 1;
                let name = attribute(line, "name");
                store.keys.push(MruKey { id: store.next, name, parameters: Vec::new() });
            } else if let (true, Some(key)) = (line.starts_with("<param "), store.keys.last_mut()) {
                let mut items: Vec<MacroValue> = line.split("<v t=\"").skip(1).filter_map(item).collect();
                let list = attribute(line, "list") == "1";
                let value = if list { MacroValue::sequence(items) } else { items.pop().unwrap_or(MacroValue::Null) };
                key.parameters.push((attribute(line, "name"), value));
            }
        }
        store
    }
}

/// Letter of the type and text of a single value.
fn flat(value: &MacroValue) -> (char, String) {
    match value {
        MacroValue::Real(number) => ('n', number.to_string()),
        MacroValue::Logical(truth) => ('l', u8::from(*truth).to_string()),
        MacroValue::Keyword(code) => ('k', code.to_string()),
        MacroValue::Text(text) => ('s', text.as_ref().clone()),
        _ => ('0', String::new()),
    }
}

fn item(part: &str) -> Option<MacroValue> {
    let (kind, rest) = part.split_once("\">")?;
    let text = plain(rest.split_once("</v>")?.0);
    Some(match kind {
        "n" => MacroValue::Real(text.parse().ok()?),
        "l" => MacroValue::Logical(text == "1"),
        "k" => MacroValue::Keyword(text.parse().ok()?),
        "s" => MacroValue::text(text),
        _ => MacroValue::Null,
    })
}

fn attribute(line: &str, name: &str) -> String {
    let start = format!("{name}=\"");
    let rest = line.split_once(&start).map_or("", |(_, rest)| rest);
    plain(rest.split_once('"').map_or("", |(value, _)| value))
}

fn escaped(text: &str) -> String {
    let mut out = text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;");
    out = out.replace('\n', "&#10;").replace('\r', "&#13;");
    out
}

fn plain(text: &str) -> String {
    let out = text.replace("&#10;", "\n").replace("&#13;", "\r").replace("&quot;", "\"").replace("&gt;", ">");
    out.replace("&lt;", "<").replace("&amp;", "&")
}

#[allow(clippy::cast_precision_loss)]
fn count(number: usize) -> MacroValue {
    MacroValue::Real(number as f64)
}

fn done(good: bool) -> MacroValue {
    count(usize::from(good))
}

impl MacroFolder {
    pub(super) fn most_recently_used(
        &mut self,
        shelf: &mut dyn Shelf,
        state: &mut MacroState,
        (function, arguments): (FileFn, &[MacroValue]),
        program: &str,
    ) -> Outcome<MacroValue> {
        if function == FileFn::MruOpen {
            return Ok(self.open_store(shelf, state, text(arguments, 0)));
        }
        let handle = arguments.first().and_then(MacroValue::as_real).unwrap_or(0.0);
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let at = (handle.max(0.0) as usize).wrapping_sub(1);
        if function == FileFn::MruClose {
            let Some(store) = self.stores.get_mut(at).and_then(Option::take) else { return Ok(MacroValue::Null) };
            let saved = self.save(shelf, &store.file, &store.write());
            state.status = saved.err().unwrap_or(0);
            return Ok(done(saved.is_ok()));
        }
        let default = default_key(program);
        let key = |value: Option<&MacroValue>| match value {
            Some(MacroValue::Text(name)) if !name.trim().is_empty() => name.trim().to_owned(),
            Some(MacroValue::Real(number)) if *number != 0.0 => crate::format::wildcard_text(*number),
            _ => default.clone(),
        };
        let Some(store) = self.stores.get_mut(at).and_then(Option::as_mut) else {
            return Ok(MacroValue::Null);
        };
        // Every search goes through the whole store, so it pays for its size.
        state.spend(store.keys.len() + store.keys.iter().map(|key| key.parameters.len()).max().unwrap_or(0))?;
        let key = named(store, arguments.get(1)).unwrap_or_else(|| key(arguments.get(1)));
        Ok(asked(store, function, &key, arguments))
    }

    fn open_store(&mut self, shelf: &mut dyn Shelf, state: &mut MacroState, file: &str) -> MacroValue {
        let file = if file.trim().is_empty() { DEFAULT_FILE } else { file.trim() };
        state.status = if self.stores.len() < MOST { self.openable(shelf, state, file) } else { FAILED };
        if state.status != 0 {
            return done(false);
        }
        let store = MruStore::read(file, &self.load(shelf, file).unwrap_or_default());
        self.stores.push(Some(store));
        count(self.stores.len())
    }
}

/// The program's file name without its ending.
fn default_key(path: &str) -> String {
    let name = path.rsplit(['/', '\\']).next().unwrap_or("");
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}

/// A key may be named by the identity that `$FMRU_GETKEY` gave.
fn named(store: &MruStore, value: Option<&MacroValue>) -> Option<String> {
    let id = value.and_then(|value| if matches!(value, MacroValue::Real(_)) { value.as_real() } else { None })?;
    store.keys.iter().find(|key| f64::from(key.id) == id).map(|key| key.name.clone())
}

fn asked(store: &mut MruStore, function: FileFn, key: &str, arguments: &[MacroValue]) -> MacroValue {
    let parameter = text(arguments, 2).trim().to_owned();
    let position = |key: &MruKey| key.parameters.iter().position(|(name, _)| name.eq_ignore_ascii_case(&parameter));
    let list = |at: usize| arguments.get(at).and_then(MacroValue::as_sequence);
    match function {
        FileFn::MruKey => count(store.find(key).and_then(|at| store.keys.get(at)).map_or(0, |key| key.id as usize)),
        FileFn::MruKeys => {
            let mut names: Vec<&str> = store.keys.iter().map(|key| key.name.as_str()).collect();
            let order = arguments.get(1).and_then(MacroValue::as_real).unwrap_or(0.0);
            if order != 0.0 {
                names.sort_unstable();
            }
            if order < 0.0 {
                names.reverse();
            }
            MacroValue::sequence(names.into_iter().map(MacroValue::text).collect())
        }
        FileFn::MruDeleteKey => done(store.find(key).map(|at| store.keys.remove(at)).is_some()),
        FileFn::MruDeleteKeys => {
            let before = store.keys.len();
            match list(1) {
                Some(names) => store.keys.retain(|key| !holds(names, &key.name)),
                None => store.keys.clear(),
            }
            count(before - store.keys.len())
        }
        FileFn::MruParameters => {
            let found = store.touch(key, false).map(|key| &key.parameters);
            MacroValue::sequence(found.into_iter().flatten().map(|(name, _)| MacroValue::text(name.as_str())).collect())
        }
        FileFn::MruDeleteParameters => {
            let Some(found) = store.touch(key, false) else { return count(0) };
            let before = found.parameters.len();
            match list(2) {
                Some(names) => found.parameters.retain(|(name, _)| !holds(names, name)),
                None => found.parameters.clear(),
            }
            count(before - found.parameters.len())
        }
        _ if parameter.is_empty() => MacroValue::Null,
        FileFn::MruParameter => {
            let found = store.touch(key, false);
            let found = found.and_then(|key| position(key).and_then(|at| key.parameters.get(at)));
            found.map(|(_, value)| value.clone()).or_else(|| arguments.get(3).cloned()).unwrap_or(MacroValue::Null)
        }
        FileFn::MruSetParameter => {
            let value = arguments.get(3).cloned().unwrap_or(MacroValue::Null);
            let Some(key) = store.touch(key, true) else { return MacroValue::Null };
            match position(key).and_then(|at| key.parameters.get_mut(at)) {
                Some((_, old)) => std::mem::replace(old, value),
                None => {
                    key.parameters.push((parameter, value));
                    MacroValue::Null
                }
            }
        }
        _ => {
            let Some(key) = store.touch(key, false) else { return done(false) };
            done(position(key).map(|at| key.parameters.remove(at)).is_some())
        }
    }
}

fn holds(names: &[MacroValue], name: &str) -> bool {
    names.iter().any(|other| other.as_text().is_some_and(|other| other.trim().eq_ignore_ascii_case(name)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_store_is_read_as_it_was_written() {
        let mut store = MruStore::default();
        let values = [
            MacroValue::Real(0.1),
            MacroValue::text("a <b> & \"c\"\nd"),
            MacroValue::Logical(true),
            MacroValue::Keyword(71),
            MacroValue::Null,
            MacroValue::sequence(vec![MacroValue::Real(1.0), MacroValue::text("x")]),
            MacroValue::sequence(Vec::new()),
        ];
        let key = store.touch("job 7", true).unwrap();
        key.parameters.extend(values.iter().enumerate().map(|(at, value)| (format!("p{at}"), value.clone())));
        let again = MruStore::read("f", &store.write());
        assert_eq!(again.keys[0].name, "job 7");
        for (value, (_, read)) in values.iter().zip(&again.keys[0].parameters) {
            assert_eq!(value.equals(read), Some(true), "{value:?} {read:?}");
        }
    }
}
