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
        // How many of `open` have each number: what is not there is not looked for.
        let mut waiting = [0_u32; 256];
        for (line, statement) in statements {
            match statement {
                Statement::While(_, number) | Statement::Do(number) => {
                    open.push((number, line));
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
                            pairs.loops.insert(start, line);
                            pairs.loops.insert(line, start);
                            break;
                        }
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

    /// Bytes that they take, about.
    pub(crate) fn bytes(&self) -> usize {
        (self.loops.len() + self.branches.len()) * 20
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
