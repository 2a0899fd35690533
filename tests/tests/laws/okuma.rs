//! Programs of Okuma mills.

use crate::program::{BY_CALL, CLEAR, Step, circle};
use crate::writer::{Lines, Style, Writer};

/// Sets `okuma-mill` to inches; its lengths and rates equal those of the machine in millimetres.
pub const INCHES: &str = "units = \"inch\"

[[codes]]
id = \"CODE_UNITS_PRIMARY\"
word = \"G20\"

[[axes]]
name = \"X\"
rapid = 1574.803149606
acceleration = 236.220472441
home = 0

[[axes]]
name = \"Y\"
rapid = 1574.803149606
acceleration = 236.220472441
home = 0

[[axes]]
name = \"Z\"
rapid = 1259.842519685
acceleration = 236.220472441
home = 17.716535433

[[diagnostics]]
number = 2900023
enable = false

[[tool.offsets]]
number = 1
radius = 0.078740157
";

pub fn text(steps: &[Step], style: &Style) -> String {
    let mut w = Writer::new(style);
    w.bare("$MAIN.MIN%");
    w.bare("OMAIN");
    w.block("G90 G17 G94 G40 G80");
    let [x, y, z] = style.offset.map(|part| w.length(part));
    w.block(format!("VZOFX[1]={x} VZOFY[1]={y} VZOFZ[1]={z}"));
    w.block("G15 H1 T1 M6 S1000 M3");
    let [x, y, z] = style.shift.map(|part| w.length(part));
    w.block(format!("G11 X{x} Y{y} Z{z} P0"));
    w.block(format!("G90 G0 X0 Y0 Z{}", w.length(CLEAR)));
    w.at = [0, 0, CLEAR];
    for step in steps {
        write(&mut w, step);
    }
    w.block("G40 G80");
    w.block("M2");
    let [x, y, _] = w.side([BY_CALL[0], BY_CALL[1], 0]).map(|part| w.length(part));
    w.bare("O77");
    w.block(format!("G91 G1 X{x} Y{y} F{}", w.feed(3)));
    w.block("G90");
    w.block("RTS");
    w.text(&Lines { number: "N", comment: ["(", ")"] })
}

fn write(w: &mut Writer, step: &Step) {
    let distance = if w.style.relative { "G91" } else { "G90" };
    match *step {
        Step::Rapid(to) => {
            let [x, y, z] = w.values(to);
            w.block(format!("{distance} G0 X{x} Y{y} Z{z}"));
            w.at = to;
        }
        Step::Feed(to, feed) => {
            let [x, y, z] = w.values(to);
            w.block(format!("{distance} G1 X{x} Y{y} Z{z} F{}", w.feed(feed)));
            w.at = to;
        }
        Step::Circle { radius, along_x, quarters, clockwise } => {
            let (center, to) = circle(w.at, radius, along_x, quarters, clockwise);
            let ([x, y, _], [i, j]) = (w.values(to), w.distances(center));
            let code = if w.clockwise(clockwise) { "G2" } else { "G3" };
            let end = if quarters == 4 { String::new() } else { format!(" X{x} Y{y}") };
            w.block(format!("{distance} {code}{end} I{i} J{j} F{}", w.feed(4)));
            w.at = to;
        }
        Step::ByRadius { radius, along_x, half, clockwise } => {
            let (_, to) = circle(w.at, radius, along_x, 1 + u8::from(half), clockwise);
            let ([x, y, _], r) = (w.values(to), w.length(radius.abs()));
            let code = if w.clockwise(clockwise) { "G2" } else { "G3" };
            w.block(format!("{distance} {code} X{x} Y{y} R{r} F{}", w.feed(4)));
            w.at = to;
        }
        Step::Hole { at, bottom } => {
            let [x, y, _] = w.side([at[0], at[1], 0]).map(|part| w.length(part));
            let [clear, r, z] = [CLEAR, 10, bottom].map(|part| w.length(part));
            w.block(format!("G90 G0 Z{clear}"));
            w.block(format!("G81 X{x} Y{y} Z{z} R{r} F{}", w.feed(2)));
            w.block("G80");
            w.block(format!("G90 G0 Z{clear}"));
            w.at = [at[0], at[1], CLEAR];
        }
        Step::Contour { left, ref points } => {
            for (number, point) in points.iter().enumerate() {
                let to = [point[0], point[1], w.at[2]];
                let [x, y, _] = w.values(to);
                let side = match (number, w.clockwise(left)) {
                    (0, true) => "G41 D1 ",
                    (0, false) => "G42 D1 ",
                    _ if number + 1 == points.len() => "G40 ",
                    _ => "",
                };
                w.block(format!("{distance} {side}G1 X{x} Y{y} F{}", w.feed(5)));
                w.at = to;
            }
        }
        Step::Call(times) => {
            w.block(format!("CALL O77 Q{times}"));
            let times = i32::from(times);
            w.at = [w.at[0] + BY_CALL[0] * times, w.at[1] + BY_CALL[1] * times, w.at[2]];
        }
        Step::Jump(to) => {
            let ([x, y, z], mark) = (w.values(to), w.mark());
            w.block(format!("GOTO N@{mark}@"));
            w.block(format!("{distance} G0 X{x} Y{y} Z{z}"));
            w.marked(mark, "G90");
        }
        Step::Dwell(seconds) => w.block(format!("G4 F{seconds}")),
        Step::Coolant(on) => w.block(if on { "M8" } else { "M9" }),
        Step::Speed(speed) => w.block(format!("S{speed} M3")),
    }
}
