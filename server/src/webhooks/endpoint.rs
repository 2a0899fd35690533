//! The address of a target.

use http::Uri;

/// Host, port and path of a target.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Endpoint {
    pub(super) encrypted: bool,
    /// Name or address, without brackets.
    pub(super) host: String,
    pub(super) port: u16,
    /// `HOST` or `HOST:PORT` as written.
    pub(super) authority: String,
    /// Path and query.
    pub(super) path: String,
}

impl Endpoint {
    /// Reads an address; without encryption only one of this computer, unless `insecure`.
    pub(super) fn parse(url: &str, insecure: bool) -> Result<Self, String> {
        let expected = "expected https://HOST/PATH";
        let uri: Uri = url.parse().map_err(|error| format!("url '{url}': {error}; {expected}"))?;
        let encrypted = match uri.scheme_str() {
            Some("https") => true,
            Some("http") => false,
            _ => return Err(format!("url '{url}' is not an address of HTTP; {expected}")),
        };
        let authority = uri.authority().ok_or_else(|| format!("url '{url}' has no host; {expected}"))?;
        if authority.as_str().contains('@') {
            return Err("url must not contain a user or a password; messages are signed with the secret".to_owned());
        }
        let port = authority.as_str().get(authority.host().len()..).unwrap_or_default();
        if !port.is_empty() && authority.port_u16().is_none() {
            return Err(format!("url '{url}': '{port}' is not a port; a port is 1 to 65535"));
        }
        let host = authority.host().trim_start_matches('[').trim_end_matches(']').to_owned();
        if !encrypted && !insecure && !is_this_computer(&host) {
            return Err(format!("url '{url}' is not encrypted: use https, or a target on this computer"));
        }
        let port = authority.port_u16().unwrap_or(if encrypted { 443 } else { 80 });
        let path = uri.path_and_query().map_or("/", |path| path.as_str()).to_owned();
        Ok(Self { encrypted, host, port, authority: authority.as_str().to_owned(), path })
    }
}

fn is_this_computer(host: &str) -> bool {
    host.eq_ignore_ascii_case("localhost")
        || host.parse::<std::net::IpAddr>().is_ok_and(|address| address.is_loopback())
}

#[cfg(test)]
mod tests {
    use super::Endpoint;

    #[test]
    fn addresses_are_read_and_unencrypted_ones_are_for_this_computer() {
        let read = |url: &str| Endpoint::parse(url, false).map(|e| (e.encrypted, e.host, e.port, e.path));
        let is = |encrypted, host: &str, port, path: &str| Ok((encrypted, host.to_owned(), port, path.to_owned()));
        assert_eq!(read("https://mes.example/hook?a=1"), is(true, "mes.example", 443, "/hook?a=1"));
        assert_eq!(read("https://mes.example:8443"), is(true, "mes.example", 8443, "/"));
        assert_eq!(read("http://127.0.0.1:9000/x"), is(false, "127.0.0.1", 9000, "/x"));
        assert_eq!(read("http://[::1]:9000/x"), is(false, "::1", 9000, "/x"));
        for (url, reason) in [
            ("http://mes.example/x", "not encrypted"),
            ("http://169.254.169.254/latest", "not encrypted"),
            ("ftp://mes.example/x", "expected https"),
            ("mes.example", "expected https"),
            ("https://user:pass@mes.example/", "password"),
            ("https:///x", "expected https"),
            ("http://127.0.0.1:99999/", "':99999' is not a port"),
            ("https://mes.example:/", "':' is not a port"),
        ] {
            let error = read(url).unwrap_err();
            assert!(error.contains(reason) && !error.contains("user:pass"), "{url}: {error}");
        }
        assert!(Endpoint::parse("http://mes.example/x", true).is_ok());
    }
}
