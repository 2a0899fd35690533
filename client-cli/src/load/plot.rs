//! Lines over an axis, as SVG.
//!
//! *Invariant:* for any points, every number in the drawing is finite and inside it.

use std::fmt::Write as _;

/// Size of the drawing and of its margins.
const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 300.0;
const LEFT: f64 = 62.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 52.0;
const BOTTOM: f64 = 44.0;
/// Colours that people with any kind of colour vision tell apart, each with a pattern of dashes.
const LINES: [(&str, &str); 4] = [("#0072b2", "none"), ("#d55e00", "6 3"), ("#009e73", "2 2"), ("#8f4d9f", "8 3 2 3")];

/// How values lead to heights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PlotScale {
    Linear,
    Log,
}

/// A line.
#[derive(Debug)]
pub(super) struct Series {
    name: String,
    points: Vec<(f64, f64)>,
}

impl Series {
    pub(super) fn new(name: &str, points: Vec<(f64, f64)>) -> Self {
        let finite = points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite());
        Self { name: name.to_owned(), points: finite.collect() }
    }
}

/// A plot.
#[derive(Debug)]
pub(super) struct Plot {
    pub(super) title: String,
    pub(super) x: String,
    pub(super) y: String,
    pub(super) scale: PlotScale,
    /// Up to here the background is shaded.
    pub(super) shaded: f64,
    /// The axis counts nines: 0 = none, 1 = 90 %, 2 = 99 %.
    pub(super) nines: bool,
    pub(super) series: Vec<Series>,
}

/// A text inside HTML.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The next of 1, 2, 5, 10, 20, … that is not below.
fn round_up(value: f64) -> f64 {
    let power = 10_f64.powf(value.log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|step| step * power).find(|step| *step >= value * 0.999_999).unwrap_or(value)
}

/// A number without zeros that say nothing, long ones with k or M.
fn short(value: f64) -> String {
    let (value, unit) = match value.abs() {
        v if v >= 1e6 => (value / 1e6, "M"),
        v if v >= 1e4 => (value / 1e3, "k"),
        _ => (value, ""),
    };
    let text = format!("{value:.3}");
    format!("{}{unit}", text.trim_end_matches('0').trim_end_matches('.'))
}

/// Marks of the axis of values, ascending.
fn marks(scale: PlotScale, low: f64, high: f64) -> Vec<f64> {
    match scale {
        PlotScale::Linear => {
            let step = round_up((high / 4.0).max(1e-9));
            (0..=10).map(|n| f64::from(n) * step).take_while(|mark| *mark < high + step).collect()
        }
        PlotScale::Log => {
            let (from, to) = (low.max(1e-3).log10().floor() as i32, high.max(2e-3).log10().ceil() as i32);
            (from..=to.max(from + 1)).map(|power| 10_f64.powi(power)).collect()
        }
    }
}

impl Plot {
    /// The drawing.
    pub(super) fn svg(&self) -> String {
        let values = || self.series.iter().flat_map(|series| series.points.iter().copied());
        let most = values().map(|(_, y)| y).fold(0.0, f64::max);
        let least = values().map(|(_, y)| y).filter(|y| *y > 0.0).fold(f64::INFINITY, f64::min).min(most.max(1e-3));
        let x_most = values().map(|(x, _)| x).fold(0.0, f64::max).max(1.0);
        let marks = marks(self.scale, least, if most > 0.0 { most } else { 1.0 });
        let (low, high) = (marks.first().copied().unwrap_or(0.0), marks.last().copied().unwrap_or(1.0));
        let x_of = |x: f64| LEFT + (x / x_most).clamp(0.0, 1.0) * (WIDTH - LEFT - RIGHT);
        let y_of = |y: f64| {
            let share = match self.scale {
                PlotScale::Linear => (y - low) / (high - low),
                PlotScale::Log => (y.max(low).log10() - low.log10()) / (high.log10() - low.log10()),
            };
            HEIGHT - BOTTOM - share.clamp(0.0, 1.0) * (HEIGHT - TOP - BOTTOM)
        };
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" \
             font-family=\"sans-serif\" font-size=\"11\">\n<title>{0}</title>\n\
             <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n\
             <text x=\"{LEFT}\" y=\"16\" font-size=\"13\" font-weight=\"bold\" fill=\"#1b1f24\">{0}</text>\n",
            escaped(&self.title)
        );
        if self.shaded > 0.0 {
            let width = x_of(self.shaded) - LEFT;
            let height = HEIGHT - TOP - BOTTOM;
            let _ = writeln!(
                out,
                "<rect x=\"{LEFT}\" y=\"{TOP}\" width=\"{width:.1}\" height=\"{height}\" fill=\"#f0f2f4\"/>"
            );
            let _ =
                writeln!(out, "<text x=\"{:.1}\" y=\"{:.1}\" fill=\"#57606a\">warm-up</text>", LEFT + 4.0, TOP + 12.0);
        }
        for mark in &marks {
            let y = y_of(*mark);
            let _ = writeln!(
                out,
                "<line x1=\"{LEFT}\" y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{y:.1}\" stroke=\"#d8dee4\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#57606a\">{}</text>",
                WIDTH - RIGHT,
                LEFT - 6.0,
                y + 4.0,
                short(*mark)
            );
        }
        for (x, text) in self.x_marks(x_most) {
            let at = x_of(x);
            let _ = writeln!(
                out,
                "<text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#57606a\">{text}</text>",
                HEIGHT - BOTTOM + 15.0
            );
        }
        let _ = writeln!(
            out,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" fill=\"#57606a\">{}</text>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\" fill=\"#57606a\">{}</text>",
            (LEFT + WIDTH - RIGHT) / 2.0,
            HEIGHT - 10.0,
            escaped(&self.x),
            LEFT - 6.0,
            TOP - 14.0,
            escaped(&self.y)
        );
        let mut legend = LEFT;
        for (series, (colour, dashes)) in self.series.iter().zip(LINES.iter().cycle()) {
            let points: Vec<String> =
                series.points.iter().map(|(x, y)| format!("{:.1},{:.1}", x_of(*x), y_of(*y))).collect();
            let line = format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\" stroke-dasharray=\"{dashes}\"");
            match points.as_slice() {
                [] => {}
                [one] => {
                    let (x, y) = one.split_once(',').unwrap_or_default();
                    let _ = writeln!(out, "<circle cx=\"{x}\" cy=\"{y}\" r=\"2.5\" fill=\"{colour}\"/>");
                }
                many => {
                    let _ = writeln!(out, "<polyline points=\"{}\" {line}/>", many.join(" "));
                }
            }
            let _ = writeln!(
                out,
                "<line x1=\"{legend:.1}\" y1=\"32\" x2=\"{:.1}\" y2=\"32\" {line}/>\
                 <text x=\"{:.1}\" y=\"36\" fill=\"#1b1f24\">{}</text>",
                legend + 22.0,
                legend + 27.0,
                escaped(&series.name)
            );
            legend += 45.0 + 6.4 * series.name.chars().count() as f64;
        }
        out + "</svg>"
    }

    /// Marks of the other axis with their texts.
    fn x_marks(&self, most: f64) -> Vec<(f64, String)> {
        if self.nines {
            let text = |nines: u32| match nines {
                0 => "0".to_owned(),
                1 => "90".to_owned(),
                2 => "99".to_owned(),
                more => format!("99.{}", "9".repeat(more as usize - 2)),
            };
            return (0..=6).map(|nines| (f64::from(nines), text(nines))).take_while(|(x, _)| *x <= most).collect();
        }
        let step = round_up(most / 8.0);
        (0..=10).map(|n| f64::from(n) * step).take_while(|x| *x <= most).map(|x| (x, short(x))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(scale: PlotScale, points: Vec<(f64, f64)>) -> String {
        Plot {
            title: "a < b".into(),
            x: "s".into(),
            y: "ms".into(),
            scale,
            shaded: 2.0,
            nines: false,
            series: vec![Series::new("one", points.clone()), Series::new("two", points)],
        }
        .svg()
    }

    #[test]
    fn every_number_is_finite_and_inside_of_the_drawing() {
        let odd = vec![
            vec![],
            vec![(0.0, 0.0)],
            vec![(1.0, f64::NAN), (2.0, f64::INFINITY)],
            vec![(0.0, 1e-12), (1e9, 1e15)],
            vec![(0.0, 5.0), (1.0, 5.0)],
        ];
        for points in odd {
            for scale in [PlotScale::Linear, PlotScale::Log] {
                let svg = plot(scale, points.clone());
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{points:?} {svg}");
                assert!(svg.contains("a &lt; b") && !svg.contains("<script"), "{svg}");
                let numbers = svg.split('"').skip(1).step_by(2).flat_map(|value| value.split([' ', ',']));
                for number in numbers.filter_map(|number| number.parse::<f64>().ok()) {
                    assert!((0.0..=WIDTH).contains(&number), "{number} of {points:?}");
                }
            }
        }
    }

    #[test]
    fn axes_have_round_marks() {
        assert_eq!(marks(PlotScale::Linear, 0.0, 37.0), [0.0, 10.0, 20.0, 30.0, 40.0]);
        assert_eq!(marks(PlotScale::Log, 0.4, 37.0), [0.1, 1.0, 10.0, 100.0]);
        assert_eq!(["0.5", "15k", "2M", "7"], [0.5, 15_000.0, 2e6, 7.0].map(short).each_ref().map(String::as_str));
    }
}
