//! Which DO belongs to which END, and which IF to which ELSE and ENDIF, in one program.

use rustc_hash::FxHashMap;

use super::statement::Statement;
use crate::kept::Table;
use counterpoint_program::spot::Spot;

/// Partners of the bracketing statements of a program, by block.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// `WHILE … DO m` or `DO m` → its `END m`, and back.
    loops: FxHashMap<Spot, Spot>,
    /// A block `IF` or `ELSE` → its `ELSE` or `ENDIF`.
    branches: FxHashMap<Spot, Spot>,
}

impl Pairs {
    /// Pairs the statements of a program given in their order.
    pub(super) fn of(statements: impl Iterator<Item = (Spot, Statement)>) -> Self {
        let mut pairs = Self::default();
        let mut open: Vec<(u8, Spot)> = Vec::new();
        let mut ifs: Vec<Spot> = Vec::new();
        // How many of `open` have each number: what is not there is not looked for.
        let mut waiting = [0_u32; 256];
        for (spot, statement) in statements {
            match statement {
                Statement::While(_, number) | Statement::Do(number) => {
                    open.push((number, spot));
                    if let Some(count) = waiting.get_mut(usize::from(number)) {
                        *count += 1;
                    }
                }
                Statement::End(number) if waiting.get(usize::from(number)).is_some_and(|count| *count > 0) => {
                    while let Some((other, start)) = open.pop() {
                        if let Some(count) = waiting.get_mut(usize::from(other)) {
                            *count -= 1;
                        }
                        if other == number {
                            pairs.loops.insert(start, spot);
                            pairs.loops.insert(spot, start);
                            break;
                        }
                    }
                }
                Statement::IfBlock(_) => ifs.push(spot),
                Statement::Else => {
                    if let Some(start) = ifs.pop() {
                        pairs.branches.insert(start, spot);
                        ifs.push(spot);
                    }
                }
                Statement::EndIf => {
                    if let Some(start) = ifs.pop() {
                        pairs.branches.insert(start, spot);
                    }
                }
                _ => {}
            }
        }
        pairs
    }

    /// Partner of a loop statement.
    pub(super) fn of_loop(&self, spot: Spot) -> Option<Spot> {
        self.loops.get(&spot).copied()
    }

    /// Where a block `IF` or `ELSE` leads when its branch is not taken.
    pub(super) fn of_branch(&self, spot: Spot) -> Option<Spot> {
        self.branches.get(&spot).copied()
    }
}

impl Table for Pairs {
    fn bytes(&self) -> usize {
        (self.loops.len() + self.branches.len()) * 36
    }
}
