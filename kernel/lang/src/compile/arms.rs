//! Branches of IF and CASE, of which one at most is executed: the same name may be declared in several of them.

use crate::ast::{CompoundStatement, MacroStatement, MacroVariableScope, StatementKind};
use crate::value::ValueType;
use rustc_hash::FxHashMap;

/// Blocks around a statement, outermost first, each with the number of its branch.
type Path = Vec<(u32, u32)>;

/// The data of a declaration about a name beside its sizes and its first value.
pub(super) type Said = (MacroVariableScope, Option<ValueType>, usize, bool);

/// Walks over the statements of a macro and remembers the declarations with their places.
#[derive(Default)]
pub(super) struct Arms {
    blocks: u32,
    path: Path,
    seen: FxHashMap<String, (Said, Vec<Path>)>,
}

impl Arms {
    /// Takes note of a statement, in the order of the macro.
    pub(super) fn pass(&mut self, statement: &MacroStatement) {
        match &statement.kind {
            StatementKind::If(_) | StatementKind::Case(_) => {
                self.blocks += 1;
                self.path.push((self.blocks, 0));
            }
            StatementKind::ElseIf(_) | StatementKind::Else | StatementKind::When(_) => {
                if let Some((_, branch)) = self.path.last_mut() {
                    *branch += 1;
                }
            }
            StatementKind::EndOf(CompoundStatement::If | CompoundStatement::Case) => {
                self.path.pop();
            }
            _ => {}
        }
    }

    /// Remembers a declaration here.
    pub(super) fn declared(&mut self, name: &str, said: Said) {
        let entry = self.seen.entry(name.to_owned()).or_insert_with(|| (said, Vec::new()));
        entry.1.push(self.path.clone());
    }

    /// Tells whether a name was declared in the same way in other branches only.
    pub(super) fn again(&self, name: &str, said: Said) -> bool {
        self.seen
            .get(name)
            .is_some_and(|(before, paths)| *before == said && paths.iter().all(|path| self.excludes(path)))
    }

    /// Here and there are never executed both.
    fn excludes(&self, there: &Path) -> bool {
        let parting = self.path.iter().zip(there).find(|(here, there)| here != there);
        parting.is_some_and(|(here, there)| here.0 == there.0)
    }
}
