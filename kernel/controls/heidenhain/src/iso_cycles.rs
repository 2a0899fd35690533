//! Cycles of ISO programs whose values have numbers (`G83 P01 2 P02 -20 …`), as the lines of their conversational
//! definitions.
//!
//! Facts: programming manual (DIN/ISO). Decision: the numbers of G56 to G59 and G74 to G78 follow the order of the
//! lines. Invariant: a value without a place in the cycle has no effect.

use IsoCycleWord::{Clockwise, Counterclockwise, Feed, Radius, Value};

use super::words::EvaluatedWord;

/// A word of a line: the number of its value, or the direction of the cycle.
#[derive(Debug, Clone, Copy)]
pub(super) enum IsoCycleWord {
    /// A value identified by its place in the line, or by the letter of its axis.
    Value(u32),
    Feed(u32),
    Radius(u32),
    Clockwise,
    Counterclockwise,
}

/// Lines of a definition, from 1.
pub(super) type Lines = &'static [&'static [IsoCycleWord]];

const SLOT: Lines = &[&[Value(1)], &[Value(2)], &[Value(3), Feed(4)], &[Value(5)], &[Value(6)], &[Feed(7)]];
const POCKET_CLOCKWISE: Lines =
    &[&[Value(1)], &[Value(2)], &[Value(3), Feed(4)], &[Value(5)], &[Value(6)], &[Feed(7), Clockwise, Radius(8)]];
const POCKET_COUNTERCLOCKWISE: Lines = &[
    &[Value(1)],
    &[Value(2)],
    &[Value(3), Feed(4)],
    &[Value(5)],
    &[Value(6)],
    &[Feed(7), Counterclockwise, Radius(8)],
];
const ROUGH: Lines = &[&[Value(1), Value(2)], &[Value(3), Feed(4), Value(5)], &[Value(6), Feed(7)]];

/// The cycle of a G word, and the lines of its definition.
pub(super) fn lines(function: u32) -> Option<(u32, Lines)> {
    Some(match function {
        56 => (15, &[&[Value(1), Value(2)], &[Value(3), Feed(4), Value(5)]]),
        57 => (6, ROUGH),
        58 => (16, &[&[Value(1), Value(2)], &[Value(3), Feed(4)], &[Clockwise, Feed(5)]]),
        59 => (16, &[&[Value(1), Value(2)], &[Value(3), Feed(4)], &[Counterclockwise, Feed(5)]]),
        74 => (3, SLOT),
        75 => (4, POCKET_CLOCKWISE),
        76 => (4, POCKET_COUNTERCLOCKWISE),
        77 => (5, &[&[Value(1)], &[Value(2)], &[Value(3), Feed(4)], &[Radius(5)], &[Feed(6), Clockwise]]),
        78 => (5, &[&[Value(1)], &[Value(2)], &[Value(3), Feed(4)], &[Radius(5)], &[Feed(6), Counterclockwise]]),
        83 => (1, &[&[Value(1)], &[Value(2)], &[Value(3)], &[Value(4)], &[Feed(5)]]),
        84 => (2, &[&[Value(1)], &[Value(2)], &[Value(3)], &[Feed(4)]]),
        85 => (17, &[&[Value(1)], &[Value(2)], &[Value(3)]]),
        86 => (18, &[&[Value(1)], &[Value(2)]]),
        _ => return None,
    })
}

/// The lines with the values of a block.
pub(super) fn filled(lines: Lines, seen: &[EvaluatedWord]) -> Vec<(u32, Vec<EvaluatedWord>)> {
    let word = |item: &IsoCycleWord| match *item {
        Clockwise => Some(EvaluatedWord::turn(true)),
        Counterclockwise => Some(EvaluatedWord::turn(false)),
        Value(number) => numbered(seen, number).map(|(name, value)| EvaluatedWord::made(name, value)),
        Feed(number) => numbered(seen, number).map(|(_, value)| EvaluatedWord::made("F", value)),
        Radius(number) => numbered(seen, number).map(|(_, value)| EvaluatedWord::made("RADIUS", value)),
    };
    let line = |items: &&[IsoCycleWord]| items.iter().filter_map(word).collect();
    (1..).zip(lines.iter().map(line)).collect()
}

/// The letter and the value after a number: P05 X+80.
fn numbered(seen: &[EvaluatedWord], number: u32) -> Option<(&str, f64)> {
    let mut pairs = seen.iter().zip(seen.iter().skip(1));
    let (_, word) = pairs.find(|(place, _)| place.is("P") && place.value == Some(f64::from(number)))?;
    let value = word.value?;
    match &*word.name {
        "" | "+" => Some(("", value)),
        "-" => Some(("", -value)),
        name => Some((name, value)).filter(|_| super::path_state::axis(name).is_some()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::old;
    use super::*;

    /// The items of a block: `P05`, then `X+80` or `-20`.
    fn seen(text: &str) -> Vec<EvaluatedWord> {
        let word = |word: &str| {
            let (name, value) = match word.strip_prefix(['P', 'X', 'Y']) {
                Some(value) => (word.get(..1).unwrap(), value),
                None => ("", word),
            };
            EvaluatedWord::made(name, value.parse().unwrap())
        };
        text.split_whitespace().map(word).collect()
    }

    fn data(function: u32, text: &str) -> (u32, old::Data) {
        let (cycle, lines) = lines(function).unwrap();
        let lines = filled(lines, &seen(text));
        (cycle, old::data(cycle, lines.iter().map(|(number, words)| (*number, words.as_slice())), [0, 1]))
    }

    /// The data by the numbers of ID30: clearance, depth, infeed, feed, sides, slot, radius, feed, direction, dwell,
    /// pitch, allowance, angle.
    #[test]
    fn values_have_the_places_of_the_conversational_cycle() {
        for (function, text, cycle, expected) in [
            (
                74,
                "P01 2 P02 -20 P03 5 P04 100 P05 X+80 P06 Y+12 P07 275",
                3,
                [2., -20., 5., 100., 0., 0., 80., 12., 0., 275., 0., 0., 0., 0., 0.],
            ),
            (
                75,
                "P01 2 P02 -20 P03 5 P04 100 P05 X80 P06 Y40 P07 275 P08 5",
                4,
                [2., -20., 5., 100., 80., 40., 0., 0., 5., 275., -1., 0., 0., 0., 0.],
            ),
            (
                76,
                "P01 2 P02 -20 P03 5 P04 100 P05 X80 P06 Y40 P07 275",
                4,
                [2., -20., 5., 100., 80., 40., 0., 0., 0., 275., 1., 0., 0., 0., 0.],
            ),
            (
                77,
                "P01 2 P02 -20 P03 5 P04 100 P05 40 P06 250",
                5,
                [2., -20., 5., 100., 0., 0., 0., 0., 40., 250., -1., 0., 0., 0., 0.],
            ),
            (
                78,
                "P01 2 P02 -20 P03 5 P04 100 P05 40 P06 250",
                5,
                [2., -20., 5., 100., 0., 0., 0., 0., 40., 250., 1., 0., 0., 0., 0.],
            ),
            (
                56,
                "P01 2 P02 -15 P03 5 P04 250 P05 0.5",
                15,
                [2., -15., 5., 250., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0.5, 0.],
            ),
            (
                57,
                "P01 2 P02 -15 P03 5 P04 250 P05 0.5 P06 30 P07 500",
                6,
                [2., -15., 5., 250., 0., 0., 0., 0., 0., 500., 0., 0., 0., 0.5, 30.],
            ),
            (
                58,
                "P01 2 P02 -15 P03 5 P04 250 P05 500",
                16,
                [2., -15., 5., 250., 0., 0., 0., 0., 0., 500., -1., 0., 0., 0., 0.],
            ),
            (
                59,
                "P01 2 P02 -15 P03 5 P04 250 P05 500",
                16,
                [2., -15., 5., 250., 0., 0., 0., 0., 0., 500., 1., 0., 0., 0., 0.],
            ),
            (
                83,
                "P01 2 P02 -10 P03 5 P04 1 P05 200",
                1,
                [2., -10., 5., 200., 0., 0., 0., 0., 0., 0., 0., 1., 0., 0., 0.],
            ),
            (84, "P01 2 P02 -10 P03 1 P04 200", 2, [2., -10., 0., 200., 0., 0., 0., 0., 0., 0., 0., 1., 0., 0., 0.]),
            (85, "P01 2 P02 -10 P03 1.5", 17, [2., -10., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 1.5, 0., 0.]),
            (86, "P01 -10 P02 1.5", 18, [0., -10., 0., 0., 0., 0., 0., 0., 0., 0., 0., 0., 1.5, 0., 0.]),
        ] {
            assert_eq!(data(function, text), (cycle, expected), "G{function} {text}");
        }
    }
}
