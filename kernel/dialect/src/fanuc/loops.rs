//! Which DO belongs to which END, and which IF to which ELSE and ENDIF, in one program.

use super::statement::Statement;
use crate::kept::Table;
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
                            pairs.loops.extend([(start, spot), (spot, start)]);
                            break;
                        }
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
