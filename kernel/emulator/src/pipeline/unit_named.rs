//! Programs that look like inches and name no unit.
//!
//! *Invariant:* nothing here changes the effect of a block. Only the start of a text is checked.

use counterpoint_event::info::MachineUnit;
use counterpoint_fault as diag;
use counterpoint_machine::length_units::unit_codes;

use crate::channel::Kernel;

/// Number of bytes to check.
const LOOKED_AT: usize = 64 << 10;

/// Coordinates with four digits after the point that a program in inches has at least.
const FEWEST: usize = 10;

/// Largest coordinate and largest feed of a program in inches.
const LARGEST: (f64, f64) = (40.0, 400.0);

/// Reports a program whose numbers look like inches if the channel runs in millimetres and the program has no code
/// of a unit.
#[cold]
pub(super) fn check_unit_named(kernel: &mut Kernel<'_>, text: &[u8]) {
    let machine = kernel.channel.env.machine;
    if machine.unit != MachineUnit::Mm || kernel.channel.state.secondary {
        return;
    }
    let names = unit_codes(machine);
    if names.is_empty() || !looks_like_inches(text.get(..LOOKED_AT).unwrap_or(text), &names) {
        return;
    }
    let list = names.iter().map(|name| format!("G{name}")).collect::<Vec<_>>().join(", ");
    let text = format!(
        "the program has no code of a unit ({list}) and runs in millimetres, but four digits after the point and small \
         numbers look like inches: name the unit in the program"
    );
    kernel.diagnose(&diag::UNIT_NOT_NAMED, text);
}

/// Whether most coordinates have four digits after the point, none is large, and no code names a unit. Programs with
/// rotary axes or directions (A3=) never count, because their posts also write four digits in millimetres, for the sake
/// of the angles.
fn looks_like_inches(text: &[u8], names: &[f64]) -> bool {
    let (mut coordinates, mut fine) = (0_usize, 0_usize);
    for line in text.split(|byte| *byte == b'\n') {
        for (letter, number) in words(line) {
            let value = number.parse::<f64>().map_or(0.0, f64::abs);
            let decimals = number.split_once('.').map_or(0, |(_, fraction)| fraction.len());
            match letter {
                b'G' if names.contains(&value) => return false,
                b'X' | b'Y' | b'Z' if value > LARGEST.0 => return false,
                b'F' if value > LARGEST.1 => return false,
                b'A' | b'B' | b'C' => return false,
                b'X' | b'Y' | b'Z' if number.contains('.') => {
                    coordinates += 1;
                    fine += usize::from(decimals == 4);
                }
                _ => {}
            }
        }
    }
    fine >= FEWEST && fine * 2 >= coordinates
}

/// Letters with the numbers after them, outside comments.
fn words(line: &[u8]) -> impl Iterator<Item = (u8, &str)> {
    let mut rest = line;
    std::iter::from_fn(move || {
        loop {
            let (&byte, after) = rest.split_first()?;
            rest = after;
            match byte.to_ascii_uppercase() {
                b';' => rest = &[],
                // Letter of a corner (,C).
                b',' => rest = after.get(1..).unwrap_or_default(),
                b'(' => {
                    rest = after.iter().position(|b| *b == b')').and_then(|at| after.get(at + 1..)).unwrap_or_default()
                }
                letter @ b'A'..=b'Z' => {
                    let is_part = |b: &u8| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+');
                    let end = after.iter().position(|b| !is_part(b)).unwrap_or(after.len());
                    if end > 0 {
                        rest = after.get(end..).unwrap_or_default();
                        let number = after.get(..end).and_then(|number| std::str::from_utf8(number).ok())?;
                        return Some((letter, number));
                    }
                }
                _ => {}
            }
        }
    })
}

#[cfg(test)]
mod tests {
    use super::looks_like_inches;

    fn looks(text: &str) -> bool {
        looks_like_inches(text.as_bytes(), &[20.0, 21.0])
    }

    #[test]
    fn fine_and_small_coordinates_look_like_inches() {
        let contour: String = (0..8).map(|n| format!("G1 X{n}.1875 Y-0.{n}625 F12.\n")).collect();
        assert!(looks(&contour));
        assert!(looks(&format!("(G21 X900.)\n{contour}")));
        for other in ["G20\n", "N10 G21 G90\n", "G0 X250.\n", "G1 F1500.\n"] {
            assert!(!looks(&format!("{other}{contour}")), "{other}");
        }
        assert!(!looks(&contour.replace("875", "87").replace("625", "62")));
        assert!(!looks("G1 X1.1875 Y1.0625\n"));
    }

    #[test]
    fn programs_with_angles_and_directions_do_not() {
        let contour: String = (0..8).map(|n| format!("G1 X{n}.1875 Y-0.{n}625 F12.\n")).collect();
        for turned in ["G0 A-10.1234 C20.1234\n", "G1 A3=0.1234 B3=0.2345 C3=0.9567\n", "G0 B90.\n"] {
            assert!(!looks(&format!("{contour}{turned}")), "{turned}");
        }
        assert!(looks(&format!("{contour}G1 X2.5,C.0625\nX3. ,R.1\n")));
    }
}
