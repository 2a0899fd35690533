//! Programs of an archive: `%_N_NAME_MPF` and `%_N_NAME_SPF` in one file, before anything runs.
//!
//! Facts: reference channel-synchronisation.md 1.2. Decisions: main programs are those with the ending MPF that no
//! block of the archive calls or selects by INIT; they belong to the channels from left to right. In a job archive of
//! INDEX lathes `%_N_n_0_MPF` is the main program of channel n, and other numbers are data (tool lists). Other content
//! of an archive (definitions `_DEF`, data `_INI`, `_TOA` and so on) is not a program, and keeps its ending in its
//! name. *Invariant:* each line is examined alone.

use counterpoint_program::syntax::NamedPrograms;

pub(super) const PROGRAMS: NamedPrograms =
    NamedPrograms { defined, called, is_header, returns, in_archive: Some(in_archive) };

/// Name and ending of the program that begins with a line.
fn parts(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let line = line.trim_ascii_start();
    let (start, rest) = line.split_at_checked(4)?;
    let length = rest.iter().take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'_').count();
    let (name, ending) = rest.get(..length)?.split_at_checked(length.checked_sub(4)?)?;
    (start.eq_ignore_ascii_case(b"%_N_") && !name.is_empty()).then_some((name, ending))
}

fn ends_with(line: &[u8], wanted: &[u8]) -> bool {
    parts(line).is_some_and(|(_, ending)| ending.eq_ignore_ascii_case(wanted))
}

fn defined(line: &[u8]) -> Option<&[u8]> {
    let (name, ending) = parts(line)?;
    match ending {
        [b'_', ending @ ..] if [b"MPF", b"SPF"].iter().any(|of| ending.eq_ignore_ascii_case(*of)) => Some(name),
        [b'_', ending @ ..] if ending.iter().all(u8::is_ascii_alphanumeric) => {
            let line = line.trim_ascii_start();
            line.get(4..4 + name.len() + ending.len() + 1)
        }
        _ => None,
    }
}

/// Everything but a main program.
fn returns(line: &[u8]) -> bool {
    parts(line).is_some() && !ends_with(line, b"_MPF")
}

/// `%_N_n_k_MPF` of a job archive (INDEX): program k of channel n.
fn in_archive(line: &[u8]) -> Option<(u16, u32)> {
    let (name, ending) = parts(line).filter(|_| ends_with(line, b"_MPF"))?;
    let (channel, number) = std::str::from_utf8(name).ok().filter(|_| ending.len() == 4)?.split_once('_')?;
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    if !digits(channel) || !digits(number) {
        return None;
    }
    Some((channel.parse().ok()?, number.parse().ok()?))
}

/// `;$PATH=…` says where a program was.
fn is_header(line: &[u8]) -> bool {
    line.trim_ascii_start().get(..6).is_some_and(|start| start.eq_ignore_ascii_case(b";$PATH"))
}

/// The program that a block calls by its name, or selects for another channel.
fn called(line: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(line).ok()?.trim_start();
    let block = match text.strip_prefix('N').map(|rest| rest.trim_start_matches(|c: char| c.is_ascii_digit())) {
        Some(rest) if rest.starts_with(' ') => rest.trim_start(),
        _ => text,
    };
    if let Some(at) = block.find("INIT") {
        let path = block.get(at..)?.split('"').nth(1)?;
        let name = path.rsplit(['/', '\\']).next()?.trim();
        return Some(super::files::program_name(name));
    }
    let length = block.bytes().take_while(|byte| byte.is_ascii_alphanumeric() || *byte == b'_').count();
    let (name, rest) = block.split_at_checked(length)?;
    let is_name = name.as_bytes().get(1).is_some_and(|byte| byte.is_ascii_alphabetic() || *byte == b'_');
    (is_name && !rest.trim_start().starts_with('=')).then(|| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_of_programs() {
        assert_eq!(defined(b"%_N_PART_1_MPF"), Some(&b"PART_1"[..]));
        assert_eq!(defined(b" %_n_hole_spf ;P"), Some(&b"hole"[..]));
        assert_eq!(defined(b"%_N_UGUD_DEF"), Some(&b"UGUD_DEF"[..]));
        assert!(returns(b"%_N_UGUD_DEF") && returns(b"%_N_COMPLETE_TEA_INI"));
        for line in [&b"%"[..], b"%PART", b"N10 G0", b"%_N__MPF", b"%_N_MPF", b"%_N_"] {
            assert_eq!(defined(line), None, "{}", String::from_utf8_lossy(line));
        }
        assert_eq!(in_archive(b"%_N_2_13_MPF"), Some((2, 13)));
        for line in [&b"%_N_2_13_SPF"[..], b"%_N_A_1_MPF", b"%_N_2_MPF", b"%_N_2_1A_MPF", b"G1"] {
            assert_eq!(in_archive(line), None, "{}", String::from_utf8_lossy(line));
        }
        assert!(returns(b"%_N_HOLE_SPF") && !returns(b"%_N_PART_1_MPF"));
        assert!(is_header(b";$PATH=/_N_MPF_DIR") && !is_header(b"; $PATH"));
    }

    #[test]
    fn programs_that_a_block_names() {
        for (line, name) in [
            ("N10 INIT(2,\"/_N_MPF_DIR/_N_SIDE_MPF\",\"S\")", Some("SIDE")),
            ("INIT(2, \"SIDE\")", Some("SIDE")),
            ("N20 HOLE(3,4)", Some("HOLE")),
            ("SIDE", Some("SIDE")),
            ("R1=5", None),
            ("G1 X10", None),
            ("WIDTH=5", None),
        ] {
            assert_eq!(called(line.as_bytes()).as_deref(), name, "{line}");
        }
    }
}
