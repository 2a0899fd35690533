//! DEFINE: texts that stand for names.
//!
//! Facts: reference control-emulator.md 5.4. A name is a whole one, as `M5` or `START`; texts in quotation marks and
//! the text that a name stands for are left alone. Invariant: no block grows without bound.

use rustc_hash::FxHashMap;

use super::Siemens;
use super::cursor::{begins_name, in_name};

/// Largest text that DEFINE may make of a block.
const LONGEST_BLOCK: usize = 20_000;

/// Texts by the names that they are defined for.
#[derive(Debug, Default)]
pub(super) struct Defines {
    texts: FxHashMap<String, String>,
    /// Bytes of the texts.
    text_bytes: usize,
}

impl Defines {
    pub(super) fn is_empty(&self) -> bool {
        self.texts.is_empty()
    }

    /// Memory of names and texts.
    pub(super) fn bytes(&self) -> usize {
        self.texts.len() * 100 + self.text_bytes
    }
}

impl Siemens {
    /// DEFINE: the name stands for the text from now on.
    pub(super) fn define(&mut self, name: &str, text: &str) {
        self.defines.text_bytes += text.len();
        if let Some(before) = self.defines.texts.insert(name.to_owned(), text.to_owned()) {
            self.defines.text_bytes -= before.len();
        }
    }

    /// The block with the texts of its defined names.
    pub(super) fn expanded(&self, text: &str) -> String {
        let defines = |text: &str| text.trim_start().get(..6).is_some_and(|head| head.eq_ignore_ascii_case("DEFINE"));
        let behind_number =
            text.trim_start().trim_start_matches(['N', 'n']).trim_start_matches(|c: char| c.is_ascii_digit());
        if self.defines.is_empty() || defines(text) || defines(behind_number) {
            return text.to_owned();
        }
        let (mut out, mut rest, mut quoted) = (String::new(), text, false);
        while let Some(first) = rest.chars().next() {
            let byte = rest.as_bytes().first().copied().unwrap_or(0);
            let behind_name = out.as_bytes().last().copied().is_some_and(in_name);
            let mut length = first.len_utf8();
            quoted ^= first == '"';
            if !quoted && begins_name(byte) && !behind_name {
                length = 1 + rest.bytes().skip(1).take_while(|byte| in_name(*byte)).count();
                let name = rest.get(..length).unwrap_or_default().to_ascii_uppercase();
                let defined = self.defines.texts.get(&name);
                if let Some(text) = defined.filter(|text| out.len() + text.len() < LONGEST_BLOCK) {
                    out.push_str(text);
                    rest = rest.get(length..).unwrap_or_default();
                    continue;
                }
            }
            out.push_str(rest.get(..length).unwrap_or_default());
            rest = rest.get(length..).unwrap_or_default();
        }
        out
    }
}
