//! Which DO belongs to which END, and which IF to which ELSE and ENDIF, in one program.

use rustc_hash::FxHashMap;

use super::statement::Statement;

/// Partners of the bracketing statements of a program, by line.
#[derive(Debug, Default)]
pub(crate) struct Pairs {
    /// Line of `WHILE … DO m` or `DO m` → line of its `END m`, and back.
    loops: FxHashMap<u32, u32>,
    /// Line of a block `IF` or `ELSE` → line of its `ELSE` or `ENDIF`.
    branches: FxHashMap<u32, u32>,
}

impl Pairs {
    /// Pairs the statements of a program given in line order.
    pub(crate) fn of(statements: impl Iterator<Item = (u32, Statement)>) -> Self {
        let mut pairs = Self::default();
        let mut open: Vec<(u8, u32)> = Vec::new();
        let mut ifs: Vec<u32> = Vec::new();
        for (line, statement) in statements {
            match statement {
                Statement::While(_, number) | Statement::Do(number) => open.push((number, line)),
                Statement::End(number) => {
                    if let Some(at) = open.iter().rposition(|&(n, _)| n == number) {
                        let (_, start) = open.remove(at);
                        open.truncate(at);
                        pairs.loops.insert(start, line);
                        pairs.loops.insert(line, start);
                    }
                }
                Statement::IfBlock(_) => ifs.push(line),
                Statement::Else => {
                    if let Some(start) = ifs.pop() {
                        pairs.branches.insert(start, line);
                        ifs.push(line);
                    }
                }
                Statement::EndIf => {
                    if let Some(start) = ifs.pop() {
                        pairs.branches.insert(start, line);
                    }
                }
                _ => {}
            }
        }
        pairs
    }

    /// Partner of a loop statement.
    pub(crate) fn of_loop(&self, line: u32) -> Option<u32> {
        self.loops.get(&line).copied()
    }

    /// Where a block `IF` or `ELSE` leads when its branch is not taken.
    pub(crate) fn of_branch(&self, line: u32) -> Option<u32> {
        self.branches.get(&line).copied()
    }
}
