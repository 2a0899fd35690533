//! Letters of engravings: single strokes of straight lines, in a fixed width.
//!
//! No source has the letters of a control; these are ours. A capital is as high as 1, a letter is as wide as [`WIDTH`];
//! letters are on the line of Y 0, and g, j, p, q, y, commas and the underscore go below it. *Invariant:* every
//! printable ASCII character has its strokes, a blank has none.

use crate::contour::element::Spot;

/// Width of a letter whose height is 1.
pub const WIDTH: f64 = 4.0 / HEIGHT;
/// The gap to the next letter that such letters usually have.
pub const GAP: f64 = 2.0 / HEIGHT;
/// Steps of the grid from the line up to the top of capitals, and from its lowest row up to the line.
const HEIGHT: f64 = 6.0;
const BELOW: f64 = 2.0;
/// The first character of the table.
const FIRST: u8 = b'!';

/// Strokes of `!` to `~`: points of a grid of 5 columns and 10 rows, column and row of each, with blanks between
/// strokes.
const STROKES: [&str; 94] = [
    "2824 2322",
    "1816 3836",
    "1218 3238 0444 0646",
    "473818070615354443321203 2921",
    "0248 0818170708 3343423233",
    "4216172837360403122244",
    "2826",
    "38272332",
    "18272312",
    "2723 0644 0446",
    "2723 0545",
    "232211",
    "0545",
    "2322",
    "0248",
    "031232434738180703",
    "172822 1232",
    "07183847460242",
    "0718384746354443321203 1535",
    "32380444",
    "480805354443321203",
    "4738180703123243443505",
    "084812",
    "15060718384746351504031232434435",
    "0312324347381807061545",
    "2625 2322",
    "2625 232211",
    "470543",
    "0646 0444",
    "074503",
    "07183847462524 2322",
    "3626243436 344447381807031242",
    "022842 1535",
    "02083847463505 3544433202",
    "4738180703123243",
    "02083847433202",
    "48080242 0535",
    "480802 0535",
    "47381807031232434525",
    "0802 4842 0545",
    "2822 1838 1232",
    "4843321203",
    "0802 480542",
    "080242",
    "0208254842",
    "02084248",
    "031232434738180703",
    "02083847463505",
    "031232434738180703 2442",
    "02083847463505 2542",
    "473818070615354443321203",
    "2822 0848",
    "080312324348",
    "082248",
    "0812253248",
    "0842 4802",
    "0825 4825 2522",
    "08480242",
    "38282232",
    "0842",
    "18282212",
    "062846",
    "0141",
    "1827",
    "46160503123243 4642",
    "0802 0516364543321203",
    "4536160503123243",
    "4842 4536160503123243",
    "04444536160503123243",
    "38281712 0636",
    "4536160503123243 4641301001",
    "0802 0516364542",
    "2622 2827",
    "26211001 2827",
    "0802 360442",
    "2822",
    "0602 05162522 25364542",
    "0602 0516364542",
    "031232434536160503",
    "0600 0516364543321203",
    "4640 4536160503123243",
    "0602 05163645",
    "45361605143443321203",
    "18132232 0636",
    "0603123243 4642",
    "062246",
    "0612243246",
    "0642 4602",
    "0622 4610",
    "06460242",
    "38272615242332",
    "2921",
    "18272635242312",
    "05163445",
];

/// The first character that has no letter.
#[must_use]
pub fn unknown(text: &str) -> Option<char> {
    text.chars().find(|letter| !matches!(letter, ' '..='~'))
}

/// Strokes of a text, each from its first to its last point: with height 1 and this gap between letters, from X 0 on.
pub fn strokes(text: &str, gap: f64) -> impl Iterator<Item = Vec<Spot>> {
    text.bytes().enumerate().flat_map(move |(place, letter)| {
        let known = letter.checked_sub(FIRST).and_then(|at| STROKES.get(usize::from(at))).copied();
        let left = (WIDTH + gap) * place as f64;
        known.unwrap_or_default().split(' ').filter(|stroke| !stroke.is_empty()).map(move |stroke| points(stroke, left))
    })
}

/// How wide a text of this many letters is.
#[must_use]
pub fn width(letters: usize, gap: f64) -> f64 {
    if letters == 0 { 0.0 } else { letters as f64 * (WIDTH + gap) - gap }
}

fn points(stroke: &str, left: f64) -> Vec<Spot> {
    let steps: Vec<f64> = stroke.bytes().map(|digit| f64::from(digit.wrapping_sub(b'0'))).collect();
    let point = |pair: &[f64]| match pair {
        [column, row] => Some([left + column / HEIGHT, (row - BELOW) / HEIGHT]),
        _ => None,
    };
    steps.chunks(2).filter_map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::{GAP, STROKES, strokes, unknown, width};

    #[test]
    fn every_letter_stays_on_its_grid() {
        for (at, letter) in STROKES.iter().enumerate() {
            for stroke in letter.split(' ') {
                assert!(stroke.len() >= 4 && stroke.len() % 2 == 0, "letter {at}: a stroke has two points at least");
                let columns = stroke.bytes().step_by(2).all(|column| (b'0'..=b'4').contains(&column));
                assert!(columns && stroke.bytes().all(|digit| digit.is_ascii_digit()), "letter {at}: '{stroke}'");
            }
        }
    }

    #[test]
    fn letters_follow_each_other() {
        let found: Vec<_> = strokes("L I", GAP).collect();
        assert_eq!(found[0], [[0.0, 1.0], [0.0, 0.0], [4.0 / 6.0, 0.0]]);
        assert_eq!(found[1], [[2.0 + 2.0 / 6.0, 1.0], [2.0 + 2.0 / 6.0, 0.0]]);
        assert_eq!(width(3, GAP), 3.0 - GAP);
    }

    #[test]
    fn letters_beyond_ascii_are_unknown() {
        assert_eq!(unknown("A b~"), None);
        assert_eq!(unknown("Aä"), Some('ä'));
    }
}
