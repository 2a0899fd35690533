//! Whether a line is a block of words, as controls without marks of their own write it, or some other text.
//!
//! Letters, tables, pictures, and programs of robots and computers also have letters with numbers, but most of their
//! lines are not blocks. *Invariant:* a block of words or a statement of custom macros is never other text.

/// Statements that begin with a name.
const STATEMENTS: &[&str] = &[
    "IF", "THEN", "ELSE", "ENDIF", "WHILE", "DO", "END", "GOTO", "POPEN", "PCLOS", "DPRNT", "BPRNT", "SETVN", "IFERROR",
];

/// Operators between values.
const OPERATORS: &[&str] = &["AND", "OR", "XOR", "MOD", "EQ", "NE", "GT", "LT", "GE", "LE"];

/// Lines of programs by their kind.
#[derive(Debug, Default)]
pub(crate) struct LineCounts {
    blocks: usize,
    others: usize,
}

impl LineCounts {
    /// Counts a line in capitals, without comments and number. Heads of programs and sections count as neither.
    pub(crate) fn count(&mut self, line: &str) {
        let line = line.trim();
        let named = line.strip_prefix('<').and_then(|rest| rest.strip_suffix('>'));
        let head = line.starts_with(['%', '$', ':', '&', '@', '!'])
            || named.is_some_and(|name| !name.contains(['<', '>']))
            || line.strip_prefix('O').is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
        match () {
            () if line.is_empty() || head => {}
            () if is_other(line) => self.others += 1,
            () => self.blocks += 1,
        }
    }

    /// Whether at least a third of the lines is other text.
    pub(crate) fn are_no_program(&self) -> bool {
        self.others > 0 && self.others * 2 >= self.blocks
    }
}

/// Whether a line is neither words nor a statement of custom macros.
fn is_other(line: &str) -> bool {
    let strange = |c: char| !(c.is_ascii_alphanumeric() || " \t.-+#[]=*/,;:_\"<>".contains(c));
    if line.contains(strange) || line.ends_with('*') {
        return true;
    }
    let bracketed = line.contains('[');
    let name_at = |text: &str| text.trim_start_matches(|c: char| c.is_ascii_alphabetic()).len();
    let first = line.get(..line.len() - name_at(line)).unwrap_or_default();
    let statement = |name: &str| {
        let begins =
            |word: &&&str| name.strip_prefix(**word).is_some_and(|rest| rest.is_empty() || STATEMENTS.contains(&rest));
        STATEMENTS.iter().any(|word| begins(&word))
    };
    if statement(first) {
        return false;
    }
    let (mut rest, mut before) = (line, ' ');
    while let Some(at) = rest.find(|c: char| c.is_ascii_alphabetic()) {
        before = rest.get(..at).and_then(|skipped| skipped.chars().next_back()).unwrap_or(before);
        let tail = rest.get(at..).unwrap_or_default();
        let (name, after) = tail.split_at(tail.len() - name_at(tail));
        let valued = after.trim_start().starts_with(|c: char| c.is_ascii_digit() || "#[=.-+".contains(c));
        let word = name.len() == 1 && valued;
        let known = OPERATORS.contains(&name) || bracketed || matches!(before, '#' | '_');
        if !word && !known {
            return true;
        }
        before = name.chars().next_back().unwrap_or(' ');
        rest = after;
    }
    !line.contains(|c: char| c.is_ascii_alphabetic()) && !line.contains('#')
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::block::StrippedBlock;

    fn other(line: &str) -> bool {
        is_other(StrippedBlock::of(line).line.trim())
    }

    #[test]
    fn words_and_statements_are_blocks() {
        for line in [
            "N10 G1 X-1.5 Y+2 F#100",
            "X[#1*2] Y-[#2]",
            "#1=#2 MOD 3",
            "#100=ABS[#1]",
            "IF[#1EQ#2]GOTO10",
            "IF #1 EQ #2 GOTO 10",
            "WHILE[#1LT5]DO1",
            "END1",
            "GOTO 100",
            "POPEN",
            "DPRNT[A#1[43]]",
            "G3 X1.,R2.",
            "T0101 (80 DEG) ;",
            "#_M_SBK=1",
            "G65 P9810 X1. (PROBE)",
        ] {
            assert!(!other(line), "{line}");
        }
    }

    #[test]
    fn texts_and_other_languages_are_no_blocks() {
        for line in [
            "Dear Sir,",
            "the part is X and Y",
            "for x in range(3):",
            "y = x",
            "PTP {A1 0,A2 -90}",
            "MoveL p10, v100, z10, tool0;",
            "PU100,100;",
            "X100Y200D02*",
            "#include <stdio.h>",
            "DIM X AS DOUBLE",
            "METRIC,TZ",
            "10.5, 20.5",
        ] {
            assert!(other(line), "{line}");
        }
    }
}
