//! The order in which files that use each other are compiled.
//!
//! *Invariant:* a file comes after those whose functions and shared variables it names, as far as that is possible;
//! otherwise the given order stays.

use super::File;
use counterpoint_lang::ast::{MacroVariableScope, StatementKind};
use counterpoint_lang::lex::{self, TokenKind};
use counterpoint_lang::parse;
use counterpoint_lang::source::MacroSource;
use std::collections::HashSet;

/// Names that a file defines for other files, and every name it uses.
struct FileSymbols {
    defines: HashSet<String>,
    uses: HashSet<String>,
}

fn names(file: &File) -> FileSymbols {
    let source = MacroSource::new(file.0.as_str(), file.1.as_str());
    let mut defines = HashSet::new();
    for one in parse::parse(&source).0 {
        defines.extend(one.header.map(|header| header.name));
        for statement in one.statements {
            if let StatementKind::Declare {
                scope: MacroVariableScope::Object | MacroVariableScope::Global,
                names,
                ..
            } = statement.kind
            {
                defines.extend(names.into_iter().map(|declared| declared.name));
            }
        }
    }
    let (lines, _) = lex::lex(&source);
    let tokens = lines.into_iter().flat_map(|line| line.tokens);
    let uses = tokens.filter_map(|spanned| match spanned.token {
        TokenKind::Name(name) | TokenKind::Percent(name) => Some(name),
        _ => None,
    });
    FileSymbols { uses: uses.collect(), defines }
}

/// Positions of the files in the order of their use.
pub(crate) fn order(files: &[File]) -> Vec<usize> {
    let all: Vec<FileSymbols> = files.iter().map(names).collect();
    let needs = |at: usize, other: usize| {
        at != other
            && matches!((all.get(at), all.get(other)), (Some(a), Some(b)) if b.defines.iter().any(|name| a.uses.contains(name) && !a.defines.contains(name)))
    };
    let (mut order, mut left): (Vec<usize>, Vec<usize>) = (Vec::new(), (0..files.len()).collect());
    while !left.is_empty() {
        let free = left.iter().position(|at| !left.iter().any(|other| needs(*at, *other)));
        order.push(left.remove(free.unwrap_or(0)));
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_defines_comes_before_what_uses() {
        let file = |name: &str, text: &str| (name.to_owned(), text.to_owned());
        let files = [
            file("main", "A=TWICE(LIMIT)"),
            file("twice", "MACRO/TWICE(V)\nTWICE=PAIR(V,V)\nENDMAC"),
            file("pair", "MACRO/PAIR(A,B)\nPAIR=A+B\nENDMAC\nDECLAR/OBJECT,LIMIT=1"),
        ];
        assert_eq!(order(&files), [2, 1, 0]);
        let circle = [file("a", "MACRO/FA()\nFA=FB()\nENDMAC"), file("b", "MACRO/FB()\nFB=FA()\nENDMAC")];
        assert_eq!(order(&circle), [0, 1]);
    }
}
