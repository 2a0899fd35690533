//! Length codes that move the axis of the tool, against a model of its machine position.
//!
//! Random blocks of a Fanuc mill with G43, G44, G49 and H, with and without a word for Z, in G90 and G91. The model
//! keeps the programmed position and the length. A code changes the length only, so the machine position is the sum of
//! both (B-63844EN/02 14.1.1, parameter 5006#6 at 0). The same program in G90 ends its moves of Z at the same places if
//! the length shifts the frame.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::indexing_slicing, missing_docs)]

use counterpoint_kernel::log::event::Kind;
use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::{Work, machine};
use proptest::prelude::*;

const LENGTHS: &str = "[compensation]\nlength_change = \"CHANGE\"
[[tool.offsets]]\nnumber = 1\nvalues = { Z = 50 }
[[tool.offsets]]\nnumber = 2\nvalues = { Z = -20 }
[[tool.offsets]]\nnumber = 3\nvalues = { Z = 7.5 }\n";
const VALUES: [f64; 4] = [0.0, 50.0, -20.0, 7.5];

/// A block: its length word (0 nothing, 1 G43 H, 2 G44 H, 3 G49, 4 H alone), the number, G91, Z, X.
type Block = (u8, usize, bool, Option<i32>, bool);

fn text(blocks: &[Block]) -> String {
    let mut text = String::from("G90 G0 Z100.\n");
    for (at, &(code, number, relative, z, x)) in blocks.iter().enumerate() {
        text += if relative { "G91" } else { "G90" };
        text += &match code {
            1 => format!(" G43 H{number}"),
            2 => format!(" G44 H{number}"),
            3 => " G49".to_owned(),
            4 => format!(" H{number}"),
            _ => String::new(),
        };
        if x {
            text += &format!(" X{}.", if relative { 1 } else { at });
        }
        if let Some(z) = z {
            text += &format!(" Z{z}.");
        }
        text += "\n";
    }
    text + "M30\n"
}

/// Machine positions of Z after each block that may move it.
fn model(blocks: &[Block]) -> Vec<(u32, f64)> {
    let (mut programmed, mut length, mut sign) = (100.0, 0.0, 0.0);
    let mut places = vec![(1, 100.0)];
    for (at, &(code, number, relative, z, _)) in blocks.iter().enumerate() {
        match code {
            1 => (sign, length) = (1.0, VALUES[number]),
            2 => (sign, length) = (-1.0, -VALUES[number]),
            3 => (sign, length) = (0.0, 0.0),
            4 if sign != 0.0 => length = sign * VALUES[number],
            _ => {}
        }
        if let Some(z) = z {
            programmed = if relative { programmed + f64::from(z) } else { f64::from(z) };
        }
        places.push((at as u32 + 2, programmed + length));
    }
    places
}

/// Machine positions of Z at the end of each line, counted from the part zero.
fn run(blocks: &[Block], change: &str) -> Vec<(u32, f64)> {
    let mill = machine("fanuc-mill", &LENGTHS.replace("CHANGE", change));
    let text = text(blocks);
    let done = Work::texts(mill, &[&text], JobOptions::default()).run(None).expect("a job");
    assert!(done.summary.diagnostics.is_empty(), "{text}{:?}", done.summary.diagnostics);
    let (mut shift, mut z) = (0.0, 500.0);
    let mut places: Vec<(u32, f64)> = Vec::new();
    for event in &done.events {
        match &event.kind {
            Kind::Frame(frame) => shift = frame.shift[2],
            // The part zero is 500 below that of the machine.
            Kind::Motion(motion) => z = motion.to[2] + shift + 500.0,
            _ => continue,
        }
        if event.line == 0 {
            continue;
        }
        places.retain(|(line, _)| *line != event.line);
        places.push((event.line, z));
    }
    places
}

fn blocks() -> impl Strategy<Value = Vec<Block>> {
    let block = (0_u8..=4, 0_usize..=3, any::<bool>(), prop::option::of(-60_i32..=60), any::<bool>());
    prop::collection::vec(block, 1..12)
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: counterpoint_tests::cases(150), failure_persistence: None, ..ProptestConfig::default()
    })]

    #[test]
    fn the_axis_moves_by_the_change_of_the_length(blocks in blocks()) {
        let expected = model(&blocks);
        let place = |wanted: u32| expected.iter().find(|(line, _)| *line == wanted).map(|(_, z)| *z);
        let places = run(&blocks, "move");
        for &(line, z) in &places {
            prop_assert!(place(line).is_some_and(|wanted| (wanted - z).abs() < 1e-6), "line {line}: {z}, not {:?}\n{}", place(line), text(&blocks));
        }
        let last = expected.last().map(|(_, z)| *z);
        prop_assert!(places.last().zip(last).is_some_and(|((_, z), last)| (z - last).abs() < 1e-6), "{}", text(&blocks));
    }

    #[test]
    fn absolute_positions_do_not_depend_on_the_kind_of_change(blocks in blocks()) {
        let blocks: Vec<Block> = blocks.into_iter().map(|(code, number, _, z, x)| (code, number, false, z, x)).collect();
        let [moved, shifted] = ["move", "shift"].map(|change| run(&blocks, change));
        for (at, block) in blocks.iter().enumerate().filter(|(_, block)| block.3.is_some()) {
            let line = at as u32 + 2;
            let place = |places: &[(u32, f64)]| places.iter().find(|(of, _)| *of == line).map(|(_, z)| *z);
            let (one, other) = (place(&moved), place(&shifted));
            if let (Some(one), Some(other)) = (one, other) {
                prop_assert!((one - other).abs() < 1e-6, "line {line} {block:?}: {one} and {other}\n{}", text(&blocks));
            }
        }
    }
}
