//! Tenants: the owners of jobs, machines and files. No tenant sees data of another tenant.
//!
//! Invariant: the name of a tenant can be part of a file name on every system, and no two differ in case only.

/// Tenant of callers without an identity, and of everything stored before there were tenants.
pub(crate) const DEFAULT: &str = "default";

/// Rule for names of tenants, for messages.
pub(crate) const RULE: &str = "1 to 63 characters of a-z 0-9 - _, the first a letter or digit";

/// Same as [`DEFAULT`], for rows that were written before there were tenants.
pub(crate) fn default() -> String {
    DEFAULT.to_owned()
}

/// For rows that need not say it.
pub(crate) fn is_default(tenant: &str) -> bool {
    tenant == DEFAULT
}

/// Whether a text can be the name of a tenant.
pub(crate) fn is_tenant(text: &str) -> bool {
    let allowed = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-' || b == b'_';
    (1..=63).contains(&text.len()) && text.bytes().all(allowed) && text.starts_with(|c: char| c.is_ascii_alphanumeric())
}

/// Refusal of a text that is not the name of a tenant; `place` is its location.
pub(crate) fn no_tenant(place: &str, tenant: &str) -> String {
    format!("{place}: '{tenant}' is not a tenant: expected {}", RULE)
}

/// Key of something that has a name within a tenant. Names do not contain `/`.
pub(crate) fn key(tenant: &str, name: &str) -> String {
    if is_default(tenant) { name.to_owned() } else { format!("{tenant}/{name}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_tenants_can_be_parts_of_paths() {
        for name in ["default", "a", "milling-2", "0_x"] {
            assert!(is_tenant(name), "{name}");
        }
        for name in ["", "A", "-a", "a/b", "..", "a.b", "ü", &"a".repeat(64)] {
            assert!(!is_tenant(name), "{name}");
        }
        assert_eq!((key(DEFAULT, "x").as_str(), key("t", "x").as_str()), ("x", "t/x"));
    }
}
