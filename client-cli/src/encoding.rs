//! `--encoding NAME`: the code page that program files are written in.
//!
//! Files are converted to UTF-8 before they are hashed and uploaded. *Invariant:* no character is replaced silently: a
//! file with bytes that the code page does not have is refused.

use std::str::FromStr;

/// The upper halves of the code pages of MS-DOS, which web browsers do not know.
const DOS: [(&str, &str); 2] = [
    (
        "437",
        "ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜ¢£¥₧ƒáíóúñÑªº¿⌐¬½¼¡«»░▒▓│┤╡╢╖╕╣║╗╝╜╛┐└┴┬├─┼╞╟╚╔╩╦╠═╬╧╨╤╥╙╘╒╓╫╪┘┌█▄▌▐▀\
         αßΓπΣσµτΦΘΩδ∞φε∩≡±≥≤⌠⌡÷≈°∙·√ⁿ²■\u{a0}",
    ),
    (
        "850",
        "ÇüéâäàåçêëèïîìÄÅÉæÆôöòûùÿÖÜø£Ø×ƒáíóúñÑªº¿®¬½¼¡«»░▒▓│┤ÁÂÀ©╣║╗╝¢¥┐└┴┬├─┼ãÃ╚╔╩╦╠═╬¤ðÐÊËÈıÍÎÏ┘┌█▄¦Ì▀\
         ÓßÔÒõÕµþÞÚÛÙýÝ¯´\u{ad}±‗¾¶§÷¸°¨·¹³²■\u{a0}",
    ),
];

/// A code page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Encoding {
    /// One that the standard of the web names.
    Known(&'static encoding_rs::Encoding),
    /// The characters of the bytes from 128 on.
    Upper(&'static str),
}

impl FromStr for Encoding {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let small = text.trim().to_ascii_lowercase();
        // `cp1252` and `1252` are names of windows-1252, `cp850` and `ibm850` of a code page of MS-DOS.
        let digits =
            ["windows-", "ibm", "cp", ""].iter().find_map(|before| small.strip_prefix(before)).unwrap_or(&small);
        if let Some((_, upper)) = DOS.iter().find(|(number, _)| *number == digits) {
            return Ok(Self::Upper(upper));
        }
        let windows = format!("windows-{digits}");
        let known = encoding_rs::Encoding::for_label(small.as_bytes())
            .or_else(|| encoding_rs::Encoding::for_label(windows.as_bytes()));
        known.map(Self::Known).ok_or_else(|| {
            format!(
                "unknown code page '{text}': give utf-16le, windows-1250 to windows-1258, iso-8859-1 to iso-8859-16, cp437, \
                 cp850, shift_jis, euc-kr, gbk, big5, koi8-r"
            )
        })
    }
}

impl Encoding {
    /// A text in UTF-8; none if it has bytes that the code page does not have.
    pub(crate) fn decode(self, bytes: &[u8]) -> Option<String> {
        match self {
            Self::Known(encoding) => {
                let mark = encoding_rs::Encoding::for_bom(bytes).filter(|(of_mark, _)| *of_mark == encoding);
                let bytes = bytes.get(mark.map_or(0, |(_, length)| length)..).unwrap_or_default();
                encoding.decode_without_bom_handling_and_without_replacement(bytes).map(|text| text.into_owned())
            }
            Self::Upper(upper) => {
                let one = |byte: &u8| match byte.checked_sub(128) {
                    None => Some(char::from(*byte)),
                    Some(at) => upper.chars().nth(usize::from(at)),
                };
                bytes.iter().map(one).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn code_pages_are_known_by_their_names() {
        let decoded = |name: &str, bytes: &[u8]| name.parse::<Encoding>().unwrap().decode(bytes);
        for (name, bytes, text) in [
            ("windows-1252", &b"(FR\xc4SER \x80)"[..], "(FRÄSER €)"),
            ("cp1252", b"\xc4", "Ä"),
            ("1250", b"\xe8", "č"),
            ("iso-8859-2", b"\xe8", "č"),
            ("CP850", b"\x8e\x9d", "ÄØ"),
            ("cp437", b"\x8e\x9d\xff", "Ä¥\u{a0}"),
            ("shift_jis", b"\x83\x65", "テ"),
            ("utf-16le", b"G\x000\x00", "G0"),
            ("utf-16be", b"\xfe\xff\x00G\x000", "G0"),
        ] {
            assert_eq!(decoded(name, bytes).as_deref(), Some(text), "{name}");
        }
        assert_eq!(decoded("utf-8", b"\xc4"), None);
        assert_eq!(decoded("shift_jis", b"\x83"), None);
        assert!("cp9999".parse::<Encoding>().unwrap_err().contains("windows-1250"));
        assert!(DOS.iter().all(|(_, upper)| upper.chars().count() == 128));
    }
}
