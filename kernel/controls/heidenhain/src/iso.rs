//! Notations of ISO programs: functions by D, labels by G98, calls by L, motion by modal G words.
//!
//! Facts: Heidenhain ISO pre-processor page, programming manual (DIN/ISO). Invariant: a block of which nothing is
//! evaluated is left as it is.

use super::formula;
use super::formula::{FormulaError, expected};
use super::lex::HeidenhainCursor;
use super::path_state::{PathBlockKind, PathBuilder, axis};
use super::statement::{HeidenhainStatement, Label};
use super::words::{HeidenhainWord, Operand};

/// A statement of ISO programs.
pub(super) fn read(cursor: &mut HeidenhainCursor<'_>) -> Result<Option<HeidenhainStatement>, FormulaError> {
    let mut ahead = cursor.clone();
    if ahead.take(b'D')
        && let Some(number) = ahead.whole()
        && matches!(ahead.peek(), Some(b'Q' | b'P' | b'"'))
    {
        return super::functions::read_iso(number, &mut ahead).map(Some);
    }
    let mut ahead = cursor.clone();
    if ahead.take_text("G98") && ahead.take(b'L') {
        let label = match ahead.quoted() {
            Some(name) => Label::Name(name.to_owned()),
            None => Label::Number(ahead.whole().ok_or_else(|| expected(&ahead, "the number of a label"))?),
        };
        if !ahead.is_over() {
            return Err(expected(&ahead, "the end of the block"));
        }
        return Ok(Some(if label == Label::Number(0) {
            HeidenhainStatement::EndOfLabel
        } else {
            HeidenhainStatement::Label(label)
        }));
    }
    let mut ahead = cursor.clone();
    if ahead.take_text("G39") {
        ahead.take_text("P01");
        let text = format!("PGM {}", ahead.all());
        return Ok(Some(HeidenhainStatement::CyclePart { cycle: 12, part: 1, words: Vec::new(), text }));
    }
    call(cursor)
}

/// `L5`, `L5,0`, `L5,2`, `L5.2`, `L"NAME"`: such a block has no other words.
fn call(cursor: &mut HeidenhainCursor<'_>) -> Result<Option<HeidenhainStatement>, FormulaError> {
    let mut ahead = cursor.clone();
    if !ahead.take(b'L') {
        return Ok(None);
    }
    let label = match (ahead.next_byte(), ahead.clone().quoted()) {
        (Some(b'"'), Some(name)) => {
            ahead.quoted();
            formula::text(name)
        }
        (Some(b'0'..=b'9'), _) => formula::number(f64::from(ahead.whole().unwrap_or(u32::MAX))),
        _ => return Ok(None),
    };
    let repeat = if matches!(ahead.peek(), Some(b',' | b'.')) {
        ahead.bump();
        // `L5,0` calls the subprogram once.
        let mut zero = ahead.clone();
        if zero.whole() == Some(0) && zero.is_over() {
            ahead = zero;
            None
        } else {
            Some(formula::operand(&mut ahead)?)
        }
    } else {
        None
    };
    if !ahead.is_over() {
        return Err(expected(&ahead, "the end of the block"));
    }
    Ok(Some(HeidenhainStatement::CallLabel { label, repeat }))
}

/// Words, or a block that moves.
pub(super) fn path(words: Vec<HeidenhainWord>) -> HeidenhainStatement {
    let cycle = words.iter().position(|word| word.name.starts_with('Q') && word.name.ends_with('='));
    if let Some(first) = cycle
        && let Some(word) = words.first().filter(|word| &*word.name == "G").cloned()
    {
        return HeidenhainStatement::CycleDefinition(
            std::iter::once(word).chain(words.into_iter().skip(first)).collect(),
        );
    }
    let moves = |word: &HeidenhainWord| match &word.operand {
        Operand::Number(_, value) if &*word.name == "G" => {
            matches!(*value as u32, 0..=3 | 5..=7 | 10..=19 | 24..=29 | 90 | 91) && value.fract() == 0.0
        }
        Operand::None => false,
        _ => axis(&word.name).is_some() || matches!(&*word.name, "I" | "J" | "K"),
    };
    // Words of frames, cycles and the like take the positions of their block.
    let takes = |word: &HeidenhainWord| match &word.operand {
        Operand::Number(_, value) if &*word.name == "G" => {
            value.fract() != 0.0 || matches!(*value as u32, 4 | 28 | 30..=39 | 50..=69 | 72..=78 | 80..=89 | 92..=99)
        }
        _ => false,
    };
    if words.iter().any(moves) && !words.iter().any(takes) {
        return HeidenhainStatement::Path { shape: PathBlockKind::Iso, iso: true, words };
    }
    HeidenhainStatement::Words(words)
}

/// Whether a plain block needs the interpreter: it moves, or sets data on which later blocks depend.
pub(super) fn needs_interpreter(text: &[u8]) -> bool {
    let mut at = text.iter().take_while(|byte| byte.is_ascii_whitespace()).count();
    if matches!(text.get(at), None | Some(b';')) {
        // The line that follows a comment with this sign is part of it.
        return text.trim_ascii_end().ends_with(b"~");
    }
    while let Some(&byte) = text.get(at) {
        at += 1;
        let letter = match byte.to_ascii_uppercase() {
            b' ' | b'\t' => continue,
            b';' => return false,
            letter @ (b'M' | b'S' | b'F' | b'H') => letter,
            _ => return true,
        };
        let digits = text.get(at..).unwrap_or_default();
        let length = digits.iter().take_while(|byte| byte.is_ascii_digit()).count();
        let number = digits.get(..length).unwrap_or_default();
        let number = number
            .iter()
            .fold(0_u32, |value, digit| value.saturating_mul(10).saturating_add(u32::from(digit.wrapping_sub(b'0'))));
        at += length;
        let plain = match letter {
            _ if length == 0 => false,
            b'M' => !matches!(number, 3..=5 | 8 | 9 | 13 | 14 | 89 | 99),
            _ => true,
        };
        if !plain {
            return true;
        }
        if text.get(at) == Some(&b'.') {
            at += 1;
            at += text.get(at..).unwrap_or_default().iter().take_while(|byte| byte.is_ascii_digit()).count();
        }
    }
    false
}

impl PathBuilder<'_> {
    /// Shape of a block by its G words.
    pub(super) fn iso_shape(&mut self) -> PathBlockKind {
        let seen = &self.step.seen;
        let numbers = || seen.iter().filter(|word| word.is("G")).filter_map(|word| word.value);
        let mut own = None;
        for number in numbers() {
            match number as u32 {
                number @ (0..=3 | 5..=7 | 10..=13 | 15 | 16) => own = Some(number),
                24 => return PathBlockKind::Chamfer,
                25 => return PathBlockKind::Round,
                29 => return PathBlockKind::Pole,
                _ => {}
            }
        }
        let moves = seen.iter().any(|word| axis(&word.name).is_some() && word.value.is_some());
        let polar = seen.iter().any(|word| matches!(&*word.name, "R" | "H"));
        let centers = seen.iter().any(|word| matches!(&*word.name, "I" | "J" | "K"));
        if own.is_some() {
            self.path.mode = own;
        }
        let mode = self.path.mode;
        match mode {
            Some(2) => self.path.clockwise = Some(true),
            Some(3) => self.path.clockwise = Some(false),
            Some(12) => self.path.clockwise = Some(true),
            Some(13) => self.path.clockwise = Some(false),
            _ => {}
        }
        match mode {
            _ if centers && !moves && own.is_none() => PathBlockKind::Pole,
            _ if !(moves || polar || centers && own.is_some()) => PathBlockKind::Iso,
            Some(2 | 3 | 5) if seen.iter().any(|word| word.is("R")) => PathBlockKind::Radius,
            Some(2 | 3 | 5) => PathBlockKind::Arc,
            Some(6) => PathBlockKind::Tangent,
            Some(10 | 11) if polar || !moves => PathBlockKind::PolarLine,
            Some(12 | 13 | 15) if polar || !moves => PathBlockKind::PolarArc,
            Some(16) if polar || !moves => PathBlockKind::PolarTangent,
            _ => PathBlockKind::Line,
        }
    }

    /// The motion word for the way in which a mode reads positions.
    pub(super) fn plain_mode(&self, mode: u32) -> u32 {
        match mode {
            0 | 10 => 0,
            2 | 3 => mode,
            5 if self.path.clockwise == Some(true) => 2,
            5 => 3,
            _ => 1,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words_of(text: &str) -> Vec<HeidenhainWord> {
        super::super::words::words(&mut HeidenhainCursor::new(text))
    }

    #[test]
    fn plain_words_are_left_alone() {
        for text in ["M30", "  S3000", "; X+5", "", "F200.5"] {
            assert!(!needs_interpreter(text.as_bytes()), "{text}");
        }
        for text in [
            "G54 M8 ; X",
            "S3000 T5",
            "L X+5",
            "12 M30",
            "N10 M30",
            "Q1 = 2",
            "%A",
            "X+5",
            "M99",
            "G1",
            "G91",
            "M30 *",
            "G",
            "\"",
            "Ü",
        ] {
            assert!(needs_interpreter(text.as_bytes()), "{text}");
        }
    }

    #[test]
    fn blocks_that_move_are_told_from_words() {
        assert!(matches!(path(words_of("G01 X+5")), HeidenhainStatement::Path { .. }));
        assert!(matches!(path(words_of("I+5 J+3")), HeidenhainStatement::Path { .. }));
        assert!(matches!(path(words_of("G40 M3")), HeidenhainStatement::Words(_)));
        assert!(matches!(path(words_of("G54 X+5")), HeidenhainStatement::Words(_)));
        assert!(matches!(path(words_of("G200 Q200=2")), HeidenhainStatement::CycleDefinition(_)));
    }
}
