//! Which DO belongs to which END, and which IF to which ELSE and ENDIF, in one program.

use super::statement::FanucStatement;
use counterpoint_control_api::open_loops::OpenLoops;
use counterpoint_program::kept::CachedTable;
use counterpoint_program::spot::BlockStart;

/// Partners of the bracketing statements of a program, in the order of the blocks.
#[derive(Debug, Default)]
pub(super) struct Pairs {
    /// `WHILE … DO m` or `DO m` → its `END m`, and back.
    loops: Vec<(BlockStart, BlockStart)>,
    /// A block `IF` or `ELSE` → its `ELSE` or `ENDIF`.
    branches: Vec<(BlockStart, BlockStart)>,
}

impl Pairs {
    /// Pairs the statements of a program given in their order.
    pub(super) fn of(statements: impl Iterator<Item = (BlockStart, FanucStatement)>) -> Self {
        let mut pairs = Self::default();
        let mut open = OpenLoops::default();
        let mut ifs: Vec<BlockStart> = Vec::new();
        for (spot, statement) in statements {
            match statement {
                FanucStatement::While(_, number) | FanucStatement::Do(number) => open.begin(number, spot),
                FanucStatement::End(number) => {
                    if let Some(start) = open.end(number) {
                        pairs.loops.extend([(start, spot), (spot, start)]);
                    }
                }
                FanucStatement::IfBlock(_) => ifs.push(spot),
                FanucStatement::Else => {
                    if let Some(start) = ifs.pop() {
                        pairs.branches.push((start, spot));
                        ifs.push(spot);
                    }
                }
                FanucStatement::EndIf => {
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
    pub(super) fn of_loop(&self, spot: BlockStart) -> Option<BlockStart> {
        partner(&self.loops, spot)
    }

    /// Where a block `IF` or `ELSE` leads when its branch is not taken.
    pub(super) fn of_branch(&self, spot: BlockStart) -> Option<BlockStart> {
        partner(&self.branches, spot)
    }
}

fn partner(pairs: &[(BlockStart, BlockStart)], of: BlockStart) -> Option<BlockStart> {
    let at = pairs.binary_search_by_key(&of, |(spot, _)| *spot).ok()?;
    pairs.get(at).map(|(_, partner)| *partner)
}

impl CachedTable for Pairs {
    fn bytes(&self) -> usize {
        (self.loops.len() + self.branches.len()) * size_of::<(BlockStart, BlockStart)>()
    }
}
