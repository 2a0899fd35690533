//! Colours for tools: the first ones chosen by hand, further ones as far from all others as possible.
//!
//! *Invariant:* the same number of tools gives the same colours; none is grey, which marks rapids and moves without a
//! tool.

/// Colours that differ well on white.
const CHOSEN: [[u8; 3]; 12] = [
    [0x1f, 0x6f, 0xb4],
    [0xc2, 0x41, 0x0c],
    [0x2e, 0x7d, 0x32],
    [0x7b, 0x3f, 0xa0],
    [0xb8, 0x86, 0x0b],
    [0xbe, 0x18, 0x5d],
    [0x0f, 0x8b, 0x8d],
    [0x5b, 0x46, 0x36],
    [0x4f, 0x46, 0xe5],
    [0x6b, 0x8e, 0x23],
    [0xa6, 0x1b, 0x1b],
    [0x15, 0x3e, 0x75],
];

/// Maximum number of different colours; further tools repeat them.
const MOST: usize = 96;

/// This many colours, `#rrggbb`.
pub(super) fn colors(count: usize) -> Vec<String> {
    let mut all: Vec<[u8; 3]> = CHOSEN.into_iter().take(count.max(1)).collect();
    let candidates = candidates();
    while all.len() < count.min(MOST) {
        let distance = |candidate: &[u8; 3]| all.iter().map(|other| difference(*candidate, *other)).min().unwrap_or(0);
        // Of equally good ones the first.
        let best = candidates.iter().rev().max_by_key(|candidate| distance(candidate));
        let Some(best) = best.filter(|best| distance(best) > 0) else { break };
        all.push(*best);
    }
    let hex = |[r, g, b]: &[u8; 3]| format!("#{r:02x}{g:02x}{b:02x}");
    all.iter().map(hex).cycle().take(count).collect()
}

/// Hues by lightness, dark enough to be seen on white.
fn candidates() -> Vec<[u8; 3]> {
    let mut all = Vec::new();
    for (value, saturation) in [(0.75, 0.95), (0.5, 0.9), (0.9, 0.7), (0.6, 0.55), (0.35, 0.8)] {
        for step in 0..36_u8 {
            all.push(of_hue(f64::from(step) / 6.0, saturation, value));
        }
    }
    all
}

/// A colour of a hue (0 to 6), saturation and value (0 to 1).
fn of_hue(hue: f64, saturation: f64, value: f64) -> [u8; 3] {
    let part = |shift: f64| {
        let k = (shift + hue) % 6.0;
        let share = value - value * saturation * k.min(4.0 - k).clamp(0.0, 1.0);
        (share * 255.0).round() as u8
    };
    [part(5.0), part(3.0), part(1.0)]
}

/// How different two colours look: weighted distance of their parts, squared.
fn difference(one: [u8; 3], other: [u8; 3]) -> i64 {
    let parts = one.into_iter().zip(other).map(|(a, b)| i64::from(a) - i64::from(b));
    parts.zip([2, 4, 3]).map(|(part, weight)| weight * part * part).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_colours_differ_and_are_no_greys() {
        let all = colors(48);
        let parse = |text: &String| {
            let part = |at: usize| u8::from_str_radix(&text[at..at + 2], 16).unwrap();
            [part(1), part(3), part(5)]
        };
        let parsed: Vec<[u8; 3]> = all.iter().map(parse).collect();
        for (index, one) in parsed.iter().enumerate() {
            let spread = one.iter().max().unwrap() - one.iter().min().unwrap();
            assert!(spread > 30, "{one:?} is a grey");
            for other in &parsed[..index] {
                assert!(difference(*one, *other) > 1500, "{one:?} and {other:?} look alike");
            }
        }
        assert_eq!(colors(5), colors(20)[..5], "more tools change no colour");
    }
}
