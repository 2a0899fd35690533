//! Conversational programs of Heidenhain mills.

use crate::program::{BY_CALL, CLEAR, Place, Step, circle};
use crate::writer::{Lines, Style, Writer};

pub fn text(steps: &[Step], style: &Style) -> String {
    let mut w = Writer::new(style);
    let unit = if style.inches { "INCH" } else { "MM" };
    w.block(format!("BEGIN PGM MAIN {unit}"));
    w.block("TOOL CALL 1 Z S1000");
    w.block("M3");
    let [x, y, z] = style.offset.map(|part| w.length(part));
    w.block("CYCL DEF 7.0 DATUM SHIFT");
    w.block(format!("CYCL DEF 7.1 X{x}"));
    w.block(format!("CYCL DEF 7.2 Y{y}"));
    w.block(format!("CYCL DEF 7.3 Z{z}"));
    if style.shift != [0; 3] {
        let [x, y, z] = style.shift.map(|part| w.length(part));
        w.block(format!("TRANS DATUM AXIS IX{x} IY{y} IZ{z}"));
    }
    if style.by_code {
        w.block("CYCL DEF 8.0 MIRROR IMAGE");
        w.block("CYCL DEF 8.1 X");
    }
    w.block(format!("L X+0 Y+0 Z{} R0 FMAX", w.length(CLEAR)));
    w.at = [0, 0, CLEAR];
    for step in steps {
        write(&mut w, step);
    }
    w.block("M30");
    let [x, y, _] = w.side([BY_CALL[0], BY_CALL[1], 0]).map(|part| w.length(part));
    w.block("LBL 77");
    w.block(format!("L IX{x} IY{y} F{}", feed(&w, 3)));
    w.block("LBL 0");
    w.block(format!("END PGM MAIN {unit}"));
    w.text(&Lines { number: "", comment: ["; ", ""] })
}

/// In programs in inches F counts tenths of an inch a minute.
fn feed(w: &Writer, tens: i32) -> i32 {
    if w.style.inches { w.feed(tens) * 10 } else { w.feed(tens) }
}

/// Words of a line to `to`.
fn words(w: &Writer, to: Place, axes: &[usize]) -> String {
    let (values, prefix) = (w.values(to), if w.style.relative { "I" } else { "" });
    axes.iter().map(|axis| format!(" {prefix}{}{}", ["X", "Y", "Z"][*axis], values[*axis])).collect()
}

fn write(w: &mut Writer, step: &Step) {
    let turn = |w: &Writer, clockwise| if w.clockwise(clockwise) { "DR-" } else { "DR+" };
    match *step {
        Step::Rapid(to) => {
            w.block(format!("L{} R0 FMAX", words(w, to, &[0, 1, 2])));
            w.at = to;
        }
        Step::Feed(to, tens) => {
            w.block(format!("L{} R0 F{}", words(w, to, &[0, 1, 2]), feed(w, tens)));
            w.at = to;
        }
        Step::Circle { radius, along_x, quarters, clockwise } => {
            let (center, to) = circle(w.at, radius, along_x, quarters, clockwise);
            w.block(format!("CC{}", words(w, [center[0], center[1], 0], &[0, 1])));
            w.block(format!("C{} {} F{}", words(w, to, &[0, 1]), turn(w, clockwise), feed(w, 4)));
            w.at = to;
        }
        Step::ByRadius { radius, along_x, half, clockwise } => {
            let (_, to) = circle(w.at, radius, along_x, 1 + u8::from(half), clockwise);
            let r = w.length(radius.abs());
            w.block(format!("CR{} R+{r} {} F{}", words(w, to, &[0, 1]), turn(w, clockwise), feed(w, 4)));
            w.at = to;
        }
        Step::Hole { at, bottom } => {
            let clear = w.length(CLEAR);
            w.block(format!("L Z{clear} R0 FMAX"));
            w.at[2] = CLEAR;
            let [depth, above, second] = [bottom, 10, CLEAR].map(|part| w.length(part));
            w.block(format!(
                "CYCL DEF 200 DRILLING Q200={above} Q201={depth} Q206={} Q202={} Q210=0 Q203=0 Q204={second} Q211=0",
                feed(w, 2),
                w.length(100),
            ));
            let to = [at[0], at[1], CLEAR];
            w.block(format!("L{} R0 FMAX M99", words(w, to, &[0, 1])));
            w.at = to;
        }
        Step::Contour { left, ref points } => {
            for (number, point) in points.iter().enumerate() {
                let to = [point[0], point[1], w.at[2]];
                let side = match (number, w.clockwise(left)) {
                    (0, true) => " RL",
                    (0, false) => " RR",
                    _ if number + 1 == points.len() => " R0",
                    _ => "",
                };
                w.block(format!("L{}{side} F{}", words(w, to, &[0, 1]), feed(w, 5)));
                w.at = to;
            }
        }
        Step::Call(times) => {
            (0..times).for_each(|_| w.block("CALL LBL 77"));
            let times = i32::from(times);
            w.at = [w.at[0] + BY_CALL[0] * times, w.at[1] + BY_CALL[1] * times, w.at[2]];
        }
        Step::Jump(to) => {
            let label = w.mark() + 100;
            w.block(format!("FN 9: IF +0 EQU +0 GOTO LBL {label}"));
            w.block(format!("L{} R0 FMAX", words(w, to, &[0, 1, 2])));
            w.block(format!("LBL {label}"));
        }
        Step::Dwell(seconds) => {
            w.block("CYCL DEF 9.0 DWELL TIME");
            w.block(format!("CYCL DEF 9.1 DWELL {seconds}"));
        }
        Step::Coolant(on) => w.block(if on { "M8" } else { "M9" }),
        Step::Speed(speed) => {
            w.block(format!("TOOL CALL S{speed}"));
            w.block("M3");
        }
    }
}
