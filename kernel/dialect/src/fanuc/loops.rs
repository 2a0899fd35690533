//! Which DO belongs to which END, and which IF to which ELSE and ENDIF, in one program.

use super::statement::Statement;
use crate::open_loops::OpenLoops;
use counterpoint_program::kept::Table;
use counterpoint_program::spot::Spot;

/// Partners of the bracketing statements of a program, in the order of the blocks.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// `WHILE … DO m` or `DO m` → its `END m`, and back.
    loops: Vec<(Spot, Spot)>,
    /// A block `IF` or `ELSE` → its `ELSE` or `ENDIF`.
    branches: Vec<(Spot, Spot)>,
}

impl Pairs {
    /// Pairs the statements of a program given in their order.
    pub(super) fn of(statements: impl Iterator<Item = (Spot, Statement)>) -> Self {
        let mut pairs = Self::default();
        let mut open = OpenLoops::default();
        let mut ifs: Vec<Spot> = Vec::new();
        for (spot, statement) in statements {
            match statement {
                Statement::While(_, number) | Statement::Do(number) => open.begin(number, spot),
                Statement::End(number) => {
                    if let Some(start) = open.end(number) {
                        pairs.loops.extend([(start, spot), (spot, start)]);
                    }
                }
                Statement::IfBlock(_) => ifs.push(spot),
                Statement::Else => {
                    if let Some(start) = ifs.pop() {
                        pairs.branches.push((start, spot));
                        ifs.push(spot);
                    }
                }
                Statement::EndIf => {
                    if let Some(start) = ifs.pop() {
                        pairs.branches.push((start, spot));
                    }
                }
                _ => {}
            }
        }
        pairs.loops.sort_unstable();
        pairs.branches.sort_unstable();
        pairs
    }

    /// Partner of a loop statement.
    pub(super) fn of_loop(&self, spot: Spot) -> Option<Spot> {
        partner(&self.loops, spot)
    }

    /// Where a block `IF` or `ELSE` leads when its branch is not taken.
    pub(super) fn of_branch(&self, spot: Spot) -> Option<Spot> {
        partner(&self.branches, spot)
    }
}

fn partner(pairs: &[(Spot, Spot)], of: Spot) -> Option<Spot> {
    let at = pairs.binary_search_by_key(&of, |(spot, _)| *spot).ok()?;
    pairs.get(at).map(|(_, partner)| *partner)
}

impl Table for Pairs {
    fn bytes(&self) -> usize {
        (self.loops.len() + self.branches.len()) * size_of::<(Spot, Spot)>()
    }
}
