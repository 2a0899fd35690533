//! Modal states.

use std::borrow::Cow;
use std::fmt;

use super::Kind;
use super::declare::record;

record! {
    /// A modal state changed.
    #[derive(Debug, Clone, PartialEq)]
    pub struct Mode {
        /// The action in the words of the listing: `plane zx`, `comp diam left n=3`.
        pub text: Cow<'static, str> = 1,
    }

    fn action(&self, _: fn(f64) -> String) -> Option<String> {
        Some(self.to_string())
    }
}

/// The words of the listing.
impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Kind {
    /// A modal state, in the words of the listing.
    pub fn mode(text: impl Into<Cow<'static, str>>) -> Self {
        Self::Mode(Mode { text: text.into() })
    }
}
