//! Contours with a name (LAP): where they start and end, and which one a cycle goes along.
//!
//! `NLAP1 G81` (G82 along X) starts a contour, G80 ends it; G83 before it starts that of the blank. G85 to G88 go along
//! the contour that they name. Facts: reference okuma-osp.md 4. *Invariant:* a contour that the program runs into is
//! skipped; a name is resolved in the text, so a contour may be anywhere in its program.

use std::sync::Arc;

use counterpoint_fault as diag;
use counterpoint_fault::Acted;

use super::Okuma;
use super::names::normal;
use super::text::{PreparedText, prepare};
use counterpoint_control_api::host::{InterpreterHost, NamedContour};

/// Relation of a block to contours.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum LapRole {
    /// It begins one.
    Begins,
    /// It cuts along the contour with this name, without N.
    Cuts(String),
}

/// Relation of a block to contours. The name of the contour is blanked.
pub(super) fn find(block: &mut PreparedText) -> Option<LapRole> {
    let mut code = None;
    for (start, end) in words(&block.upper) {
        let word = block.upper.get(start..end).unwrap_or_default();
        match word {
            [b'G', digits @ ..] if code.is_none() => code = lap_code(digits),
            [b'N', name @ ..] if matches!(code, Some(5..=8)) && !name.is_empty() => {
                let name = normal(&String::from_utf8_lossy(name));
                for text in [&mut block.plain, &mut block.upper] {
                    text.get_mut(start..end).unwrap_or_default().fill(b' ');
                }
                return Some(LapRole::Cuts(name));
            }
            _ => {}
        }
    }
    matches!(code, Some(1..=3)).then_some(LapRole::Begins)
}

/// Words and names: letters with the letters and digits after them.
fn words(text: &[u8]) -> Vec<(usize, usize)> {
    let (mut found, mut at) = (Vec::new(), 0);
    while let Some(&byte) = text.get(at) {
        let run = |from: usize, is: fn(&u8) -> bool| text.iter().skip(from).take_while(|byte| is(byte)).count();
        if !byte.is_ascii_alphabetic() {
            at += 1;
            continue;
        }
        let letters = run(at, u8::is_ascii_alphabetic);
        let all = if byte == b'N' {
            run(at, u8::is_ascii_alphanumeric)
        } else {
            letters + run(at + letters, u8::is_ascii_digit)
        };
        found.push((at, at + all));
        at += all;
    }
    found
}

/// Last digit of G80 to G88.
fn lap_code(digits: &[u8]) -> Option<u8> {
    let leading = digits.iter().take_while(|digit| **digit == b'0').count();
    match digits.get(leading..).unwrap_or_default() {
        [b'8', last @ b'0'..=b'8'] => Some(last - b'0'),
        _ => None,
    }
}

/// The code of a line, G80 to G88 as 0 to 8.
fn code_of(line: &[u8]) -> Option<u8> {
    if !line.contains(&b'8') {
        return None;
    }
    let block = prepare(line);
    let words = words(&block.upper);
    words.into_iter().find_map(|(start, end)| match block.upper.get(start..end).unwrap_or_default() {
        [b'G', digits @ ..] => lap_code(digits),
        _ => None,
    })
}

impl Okuma {
    /// Continues after the contour that begins here.
    pub(super) fn skip_contour(&mut self, host: &mut dyn InterpreterHost) -> Acted {
        let place = host.place();
        let source = host.source(place.file);
        let end = source
            .and_then(|source| (place.line + 1..=source.lines()).find(|line| code_of(source.line(*line)) == Some(0)));
        match end {
            Some(end) => host.go_to(end + 1),
            None => {
                let text = format!("the contour that begins with '{}' has no end (G80)", host.block_text());
                Err(host.alarm(&diag::CONTOUR_BLOCKS, text))
            }
        }
    }

    /// The cycle of the block goes along the contour with this name.
    pub(super) fn cut_along(&mut self, host: &mut dyn InterpreterHost, name: &str) -> Acted {
        let place = host.place();
        let index = self.index(host, place.file);
        let mut has_blank = false;
        let is_bar = code_of(host.block_text().as_bytes()) == Some(5);
        let shape = index.label(name, place.line, place.range).and_then(|label| {
            let source = host.source(place.file)?;
            let mut codes = (label..=source.lines()).map(|line| (line, code_of(source.line(line))));
            has_blank = match codes.next()? {
                (_, Some(code @ 1..=3)) => code == 3,
                _ => return None,
            };
            let mut codes = (label..=source.lines()).map(|line| (line, code_of(source.line(line))));
            let (begin, code) = codes.find(|(_, code)| matches!(code, Some(0..=2)))?;
            if code == Some(0) {
                return None;
            }
            let (end, _) = codes.find(|(_, code)| *code == Some(0))?;
            let blank = (has_blank && is_bar && begin > label + 1).then_some((label + 1, begin - 1));
            let name = Arc::from(format!("N{name}"));
            Some(NamedContour { name, first: begin + 1, last: end - 1, face: code == Some(2), blank })
        });
        match shape {
            Some(shape) => {
                if has_blank && !is_bar && code_of(host.block_text().as_bytes()) != Some(7) {
                    let text = format!("the blank of N{name} is ignored in '{}'", host.block_text());
                    host.diagnose(&diag::OKUMA_BLANK, text);
                }
                host.cut_along(shape);
                Ok(())
            }
            None => {
                let text = format!("no contour N{name} (G81 or G82 to G80) in the program for '{}'", host.block_text());
                Err(host.alarm(&diag::CONTOUR_BLOCKS, text))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contours_of_blocks() {
        let of = |text: &str| {
            let mut block = prepare(text.as_bytes());
            (find(&mut block), String::from_utf8(block.upper).unwrap())
        };
        assert_eq!(of("NLAP1 G81").0, Some(LapRole::Begins));
        assert_eq!(of("N0207 G082").0, Some(LapRole::Begins));
        let (lap, text) = of("N10 G85 NLAP1 D4 F0.3 U0.4");
        assert_eq!((lap, text.as_str()), (Some(LapRole::Cuts("LAP1".to_owned())), "N10 G85       D4 F0.3 U0.4"));
        assert_eq!(of("G87 N0207").0, Some(LapRole::Cuts("207".to_owned())));
        for text in ["G85 D4", "G80", "(G81)", "LG81=3", "G8 P1", "G810", "G189 X1", "NG81 X5"] {
            assert_eq!(of(text).0, None, "{text}");
        }
        assert_eq!((code_of(b"G80"), code_of(b"N5 G0080 (G81)"), code_of(b"X80")), (Some(0), Some(0), None));
    }
}
