//! Parts that all notations share: the current position, and the writing of values, block numbers and comments.

use fastrand::Rng;

use crate::program::{GRID_INCH, GRID_MM, Place};

/// Block numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Numbers {
    /// Only at the targets of jumps.
    Needed,
    /// Each block, by this step from this number.
    Every(u32, u32),
}

/// How a program is written.
#[derive(Debug, Clone)]
pub struct Style {
    pub inches: bool,
    pub relative: bool,
    pub numbers: Numbers,
    /// Comments and blanks are inserted, by this seed.
    pub filler: Option<u64>,
    /// The text has X mirrored, and the directions of circles and the sides of contours exchanged.
    pub mirrored: bool,
    /// X is mirrored by a code of the control.
    pub by_code: bool,
    /// Shift of the zero by the settable offset.
    pub offset: Place,
    /// Shift of the zero by the program.
    pub shift: Place,
}

impl Default for Style {
    fn default() -> Self {
        Self {
            inches: false,
            relative: false,
            numbers: Numbers::Needed,
            filler: None,
            mirrored: false,
            by_code: false,
            offset: [0; 3],
            shift: [0; 3],
        }
    }
}

/// A block: its words, and the mark by which jumps find it. `@5@` in the words is the number of the block with mark 5.
struct Block {
    mark: Option<u32>,
    words: String,
    /// A line that has no number: the head of a program.
    bare: bool,
}

/// A program that is being written.
pub struct Writer {
    pub style: Style,
    pub at: Place,
    blocks: Vec<Block>,
    marks: u32,
}

/// The differences between the notations in the form of a line.
pub struct Lines {
    /// Before the number of a block.
    pub number: &'static str,
    /// Around a comment.
    pub comment: [&'static str; 2],
}

impl Writer {
    pub fn new(style: &Style) -> Self {
        Self { style: style.clone(), at: [0; 3], blocks: Vec::new(), marks: 0 }
    }

    pub fn block(&mut self, words: impl Into<String>) {
        self.blocks.push(Block { mark: None, words: words.into(), bare: false });
    }

    pub fn bare(&mut self, words: impl Into<String>) {
        self.blocks.push(Block { mark: None, words: words.into(), bare: true });
    }

    /// A block to which jumps lead.
    pub fn marked(&mut self, mark: u32, words: impl Into<String>) {
        self.blocks.push(Block { mark: Some(mark), words: words.into(), bare: false });
    }

    pub fn mark(&mut self) -> u32 {
        self.marks += 1;
        self.marks
    }

    /// A length.
    pub fn length(&self, grid: i32) -> String {
        if self.style.inches {
            format!("{:.3}", f64::from(grid) * GRID_INCH)
        } else {
            format!("{:.3}", f64::from(grid) * GRID_MM)
        }
    }

    /// A feed in tens of inches a minute, converted to inches or millimetres.
    pub fn feed(&self, tens: i32) -> i32 {
        if self.style.inches { tens * 10 } else { tens * 254 }
    }

    /// The place, with X on the other side in a mirrored program.
    pub fn side(&self, place: Place) -> Place {
        if self.style.mirrored { [-place[0], place[1], place[2]] } else { place }
    }

    /// Whether a circle is written clockwise.
    pub fn clockwise(&self, clockwise: bool) -> bool {
        clockwise != self.style.mirrored
    }

    /// Values for words of the axes from `at` to `to`: positions, or distances in a relative program.
    pub fn values(&self, to: Place) -> [String; 3] {
        let (from, to) = (self.side(self.at), self.side(to));
        [0, 1, 2].map(|axis| self.length(if self.style.relative { to[axis] - from[axis] } else { to[axis] }))
    }

    /// Distances from `at`, mirrored if the program is.
    pub fn distances(&self, to: [i32; 2]) -> [String; 2] {
        let (from, to) = (self.side(self.at), self.side([to[0], to[1], 0]));
        [0, 1].map(|axis| self.length(to[axis] - from[axis]))
    }

    /// The text: with numbers, comments and blanks.
    pub fn text(self, lines: &Lines) -> String {
        let mut rng = self.style.filler.map(Rng::with_seed);
        let number = |at: usize, mark: Option<u32>| match self.style.numbers {
            Numbers::Needed => mark.map(|mark| mark + 9),
            Numbers::Every(first, step) => Some(first + step * at as u32),
        };
        let numbers: Vec<_> = self.blocks.iter().enumerate().map(|(at, block)| number(at, block.mark)).collect();
        let mut text = String::new();
        for (block, number) in self.blocks.iter().zip(&numbers) {
            let mut words = block.words.clone();
            for (target, number) in self.blocks.iter().zip(&numbers) {
                if let (Some(mark), Some(number)) = (target.mark, number) {
                    words = words.replace(&format!("@{mark}@"), &number.to_string());
                }
            }
            if let Some(number) = number.filter(|_| !block.bare) {
                words = format!("{}{number} {words}", lines.number);
            }
            match &mut rng {
                Some(rng) if !block.bare => filled(&words, lines, rng, &mut text),
                _ => text += &words,
            }
            text.push('\n');
        }
        text
    }
}

/// Comments that a careless reader would take for words.
const COMMENTS: [&str; 4] = ["X99 G28 M30", "G91 Z-50.", "DEPTH: 5 MM, T1", "N10 GOTO 20"];

/// Blanks between words, and a comment before or after the block.
fn filled(words: &str, lines: &Lines, rng: &mut Rng, text: &mut String) {
    let comment = |rng: &mut Rng| format!("{}{}{}", lines.comment[0], COMMENTS[rng.usize(..4)], lines.comment[1]);
    match rng.u8(0..6) {
        0 => *text += &format!("{}\n{words}", comment(rng)),
        1 => *text += &format!("\n{words}"),
        2 => *text += &format!("{words} {}", comment(rng)),
        3 => *text += &words.replace(' ', "   "),
        4 => *text += &format!("{words}  "),
        _ => *text += words,
    }
}
