//! Moves of the cycles that follow contours.
//!
//! *Invariant:* each move is a block of conversational words, which the machine reads like words of the program.

use super::path_state::FASTEST;
use super::words::{EvaluatedWord, LeftBlock};

/// A feed parameter of this value or more means rapid.
pub(super) const RAPID: f64 = 99_999.0;

/// A position along an axis, by its letter.
pub(super) type Along = (&'static str, f64);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum MoveKind {
    /// A straight line; `off` ends the radius compensation.
    Line {
        off: bool,
    },
    /// The centre of the next circle.
    Center,
    Circle {
        clockwise: bool,
    },
    /// Only an M function.
    Function(u16),
}

#[derive(Debug, Clone, Copy)]
struct MadeMove {
    kind: MoveKind,
    /// End of its words in the list of all words.
    end: usize,
    /// [`RAPID`] or more means rapid.
    feed: f64,
}

/// Moves of a cycle, in the order in which they are executed.
#[derive(Debug, Default)]
pub(super) struct Moves {
    all: Vec<MadeMove>,
    words: Vec<Along>,
}

impl Moves {
    fn push(&mut self, kind: MoveKind, words: impl IntoIterator<Item = Along>, feed: f64) {
        self.words.extend(words);
        self.all.push(MadeMove { kind, end: self.words.len(), feed });
    }

    /// Moves straight.
    pub(super) fn line(&mut self, to: impl IntoIterator<Item = Along>, off: bool, feed: f64) {
        self.push(MoveKind::Line { off }, to, feed);
    }

    /// Moves around a centre.
    pub(super) fn circle(
        &mut self,
        center: [Along; 2],
        to: impl IntoIterator<Item = Along>,
        clockwise: bool,
        feed: f64,
    ) {
        self.push(MoveKind::Center, center, 0.0);
        self.push(MoveKind::Circle { clockwise }, to, feed);
    }

    /// Executes an M function.
    pub(super) fn function(&mut self, number: u16) {
        self.push(MoveKind::Function(number), [], 0.0);
    }

    /// The moves as blocks.
    pub(super) fn blocks(&self) -> impl Iterator<Item = LeftBlock> {
        let mut from = 0;
        self.all.iter().map(move |made| {
            let words = self.words.get(std::mem::replace(&mut from, made.end)..made.end).unwrap_or_default();
            made.block(words)
        })
    }
}

impl MadeMove {
    fn block(self, words: &[Along]) -> LeftBlock {
        let head = match self.kind {
            MoveKind::Line { .. } => EvaluatedWord::text("L"),
            MoveKind::Center => EvaluatedWord::text("CC"),
            MoveKind::Circle { .. } => EvaluatedWord::text("C"),
            MoveKind::Function(number) => EvaluatedWord::made("M", f64::from(number)),
        };
        let rapid = self.feed >= RAPID;
        let more = match self.kind {
            MoveKind::Line { off } => {
                let feed = if rapid { EvaluatedWord::text("FMAX") } else { EvaluatedWord::made("F", self.feed) };
                [off.then(|| EvaluatedWord::text("R0")), Some(feed)]
            }
            // A rapid of the machine is straight.
            MoveKind::Circle { clockwise } => [
                Some(EvaluatedWord::turn(clockwise)),
                Some(EvaluatedWord::made("F", if rapid { FASTEST } else { self.feed })),
            ],
            MoveKind::Center | MoveKind::Function(_) => [None, None],
        };
        let words = words.iter().map(|(letter, value)| EvaluatedWord::made(letter, *value));
        std::iter::once(head).chain(words).chain(more.into_iter().flatten()).collect()
    }
}
