//! The paths of SL cycles along their contours: the blocks of cycles 21 to 24, and of 6, 15 and 16.
//!
//! Facts: programming manuals of the control (Q1 to Q9 of cycle 20; Q10 to Q19, Q208 of the cycles: levels, feeds,
//! allowances, sense; the lines of the old cycles, which count from the position of the tool). Decisions: a pocket is
//! cleared by cuts along the first axis, then once around each contour. The tool plunges straight and rises to the
//! clearance Q6 between rows. Sides are reached and left on quarter circles of the radius of the tool, smaller where
//! there is less room. Where contours leave less room than the tool, it goes around the area that it reaches. After
//! another tool (Q18) it clears the places that it touches in the material left by that tool. *Invariant:* no path
//! comes nearer to a contour than the radius of the tool with its allowance.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_motion::arc::by_center;
use counterpoint_motion::contour::closed::{ClosedContour, Cut, cuts, is_clear, turned_by};
use counterpoint_motion::contour::element::{Element, Spot, distance, plus};
use counterpoint_motion::contour::reach::{eroded, grown, remaining};

use super::Heidenhain;
use super::moves::{Along, Moves, RAPID};
use super::sl_contours::{AreaBoundary, AreaStage};
use super::tasks::{ContourParameters, Rounding};

/// Blocks in the making.
pub(super) struct CycleBlockWriter {
    pub(super) moves: Moves,
    letters: [&'static str; 2],
    height: &'static str,
    /// Geometry units of a unit of the program.
    factor: f64,
}

impl CycleBlockWriter {
    pub(super) fn of(own: &Heidenhain, host: &dyn InterpreterHost) -> Self {
        Self {
            moves: Moves::default(),
            letters: own.plane_letters(),
            height: own.tool_letter(),
            factor: host.length_factor(),
        }
    }

    fn at(&self, spot: Spot) -> [Along; 2] {
        let [first, second] = self.letters;
        [(first, spot[0] / self.factor), (second, spot[1] / self.factor)]
    }

    pub(super) fn over(&mut self, spot: Spot) {
        let at = self.at(spot);
        self.moves.line(at, true, RAPID);
    }

    /// To a place and a height together.
    pub(super) fn ramp(&mut self, spot: Spot, height: f64, feed: f64) {
        let to = self.at(spot).into_iter().chain([(self.height, height)]);
        self.moves.line(to, false, feed);
    }

    pub(super) fn line(&mut self, spot: Spot, feed: f64) {
        let at = self.at(spot);
        self.moves.line(at, false, feed);
    }

    pub(super) fn rise_to(&mut self, height: f64, feed: f64) {
        self.moves.line([(self.height, height)], true, feed);
    }

    /// To a place and down to a level.
    fn plunge(&mut self, spot: Spot, task: &ContourParameters, level: f64) {
        self.over(spot);
        self.rise_to(task.clear, RAPID);
        self.rise_to(level, task.plunge);
    }

    /// Rows of cuts at a level, then once along each path.
    fn cleared(&mut self, rows: &[Vec<Cut>], ways: &[ClosedContour], task: &ContourParameters, level: f64) {
        for (start, row) in rows.iter().filter_map(|row| Some((row.first()?.0, row))) {
            self.plunge(start, task, level);
            let mut here = start;
            for (from, to) in row {
                if distance(here, *from) > 1e-7 {
                    self.line(*from, task.feed);
                }
                self.line(*to, task.feed);
                here = *to;
            }
            self.rise_to(task.clear, task.out);
        }
        for way in ways {
            let Some(first) = way.elements().first() else { continue };
            self.plunge(first.from, task, level);
            for element in way.elements() {
                self.element(element, task.feed);
            }
            self.rise_to(task.clear, task.out);
        }
    }

    /// A hole in pecks, each from a stop ahead of the last depth.
    fn drilled(&mut self, at: Spot, task: &ContourParameters, levels: &[f64], ahead: f64) {
        self.over(at);
        self.rise_to(task.clear, RAPID);
        let mut last = None;
        for level in levels {
            if let Some(last) = last {
                self.rise_to(task.clear, RAPID);
                self.rise_to(last + ahead, RAPID);
            }
            self.rise_to(*level, task.plunge);
            last = Some(*level);
        }
        self.rise_to(task.clear, RAPID);
    }

    pub(super) fn element(&mut self, element: &Element, feed: f64) {
        self.element_to(element, None, feed);
    }

    /// Along an element, to a height on the way.
    pub(super) fn element_to(&mut self, element: &Element, height: Option<f64>, feed: f64) {
        let to = self.at(element.to).into_iter().chain(height.map(|height| (self.height, height)));
        match &element.arc {
            None => self.moves.line(to, false, feed),
            Some(arc) => self.moves.circle(self.at(arc.center), to, arc.sweep < 0.0, feed),
        }
    }
}

/// Levels from a surface down to a depth.
pub(super) fn levels(surface: f64, bottom: f64, infeed: f64) -> Vec<f64> {
    let infeed = infeed.abs();
    let mut levels = Vec::new();
    let mut level = surface;
    while infeed > 0.0 && level - infeed > bottom + 1e-9 && levels.len() < 10_000 {
        level -= infeed;
        levels.push(level);
    }
    levels.push(bottom);
    levels
}

/// Most moves that a cycle makes at all its levels.
const MOST_MOVES: usize = 500_000;

/// A cycle does not make more moves than it may.
pub(super) fn within_reason(moves: usize, levels: usize) -> Result<(), String> {
    if moves.saturating_mul(levels) <= MOST_MOVES {
        return Ok(());
    }
    Err(format!("the cycle would make more than {MOST_MOVES} moves: program larger infeeds"))
}

/// A quarter circle to a path or from it.
fn quarter(at: Spot, heading: Spot, side: f64, radius: f64, arrives: bool) -> Option<Element> {
    let center = plus(at, [-heading[1] * side, heading[0] * side], radius);
    let end = plus(center, heading, if arrives { -radius } else { radius });
    let (from, to) = if arrives { (end, at) } else { (at, end) };
    Some(Element { from, to, arc: Some(by_center(from, to, center, side < 0.0).ok()?) })
}

impl Heidenhain {
    /// Radius of the active tool, in geometry units.
    pub(super) fn cutter(&self, host: &dyn InterpreterHost) -> Result<f64, String> {
        let radius = host.tool_in_force()[1];
        if radius > 0.0 { Ok(radius) } else { Err("the tool of an SL cycle has no radius".to_owned()) }
    }

    /// Paths beside the figures in the sense of the task: along each of them. Where they leave too little room for
    /// that, the path goes around the whole area that the tool reaches.
    fn ways(
        &self,
        figures: &[AreaBoundary],
        amount: f64,
        task: &ContourParameters,
    ) -> Result<Vec<ClosedContour>, String> {
        let all: Vec<ClosedContour> = figures.iter().map(|figure| figure.outline.clone()).collect();
        let corners = match task.rounding {
            Rounding::Everywhere(radius) if radius > 0.0 => return Self::rounded_ways(&all, amount, radius, task),
            Rounding::Everywhere(_) => 0.0,
            Rounding::Corners(radius) => radius,
        };
        let round = |ways: Vec<ClosedContour>| ways.iter().map(|way| way.rounded(corners)).collect();
        let along = figures.iter().map(|figure| {
            // Climb milling runs counter-clockwise in a pocket, clockwise around an island.
            let clockwise = figure.is_pocket != task.climbs;
            let same = figure.outline.is_clockwise() == clockwise;
            let outline = if same { figure.outline.clone() } else { figure.outline.reversed() };
            let way = outline.beside(if task.climbs { 1.0 } else { -1.0 }, amount)?;
            way.keeps_away(&all, amount).then_some(way)
        });
        if let Some(ways) = along.collect::<Option<Vec<_>>>() {
            return Ok(round(ways));
        }
        Self::rims(eroded(&all, amount), task).map(round)
    }

    /// Paths that turn with a radius of their own inside of corners.
    fn rounded_ways(
        all: &[ClosedContour],
        amount: f64,
        radius: f64,
        task: &ContourParameters,
    ) -> Result<Vec<ClosedContour>, String> {
        let narrow = eroded(all, amount + radius);
        Self::rims(narrow.and_then(|narrow| grown(&narrow, radius)), task)
    }

    /// Paths around the material left by an earlier tool; none if that tool had no larger radius.
    fn remaining_ways(
        host: &dyn InterpreterHost,
        figures: &[AreaBoundary],
        (away, radius): (f64, f64),
        (tool, task): (u32, &ContourParameters),
    ) -> Result<Vec<ClosedContour>, String> {
        let earlier = host.tool_size(tool)[1];
        if earlier <= 0.0 {
            return Err(format!("tool {tool}, which has roughed before (Q18, Q438), has no radius"));
        }
        if earlier <= radius {
            return Ok(Vec::new());
        }
        let all: Vec<ClosedContour> = figures.iter().map(|figure| figure.outline.clone()).collect();
        let left = remaining(&all, away, radius, earlier).ok_or_else(|| {
            "the contours have too many elements to find what an earlier tool (Q18, Q438) has left".to_owned()
        })?;
        Ok(Self::turned_by_sense(&left, task))
    }

    /// Paths in the sense of the task, from the middle of their longest elements.
    fn turned_by_sense(rims: &[ClosedContour], task: &ContourParameters) -> Vec<ClosedContour> {
        let way = |way: &ClosedContour| if task.climbs { way.from_longest() } else { way.reversed().from_longest() };
        rims.iter().map(way).collect()
    }

    /// The rims of the area that a tool reaches, in the sense of the task.
    fn rims(reached: Option<Vec<ClosedContour>>, task: &ContourParameters) -> Result<Vec<ClosedContour>, String> {
        let reached = reached.filter(|reached| !reached.is_empty()).ok_or_else(|| {
            "the tool with its allowance does not fit into the contours, or they have too many elements to find where it does"
                .to_owned()
        })?;
        Ok(Self::turned_by_sense(&reached, task))
    }

    /// The ground of a stage.
    fn ground(stage: &AreaStage, task: &ContourParameters) -> f64 {
        stage.depth.map_or(task.bottom, |depth| task.surface - depth + task.floor)
    }

    /// The stages of a task, with where each begins and ends.
    fn grounds(&self, task: &ContourParameters, amount: f64) -> Result<Vec<(AreaStage, f64, f64)>, String> {
        let mut top = task.surface;
        let open = task.others.open.then_some(amount);
        let stages = self.stages(task.surface - task.bottom + task.floor, open)?.into_iter().map(|stage| {
            let ground = Self::ground(&stage, task);
            (stage, std::mem::replace(&mut top, ground), ground)
        });
        Ok(stages.collect())
    }

    /// Rows of cuts between paths that keep away from the figures by an amount.
    fn rows(
        outlines: &[ClosedContour],
        (figures, amount): (&[AreaBoundary], f64),
        task: &ContourParameters,
        radius: f64,
    ) -> Result<Vec<Vec<Cut>>, String> {
        let turned: Vec<ClosedContour> = outlines.iter().map(|way| way.turned(-task.along)).collect();
        let contours: Vec<ClosedContour> = figures.iter().map(|figure| figure.outline.turned(-task.along)).collect();
        let rows = cuts(&turned, task.overlap * radius, |link| is_clear(link, &contours, amount));
        let mut rows =
            rows.ok_or_else(|| "the contours of cycle 14 have room for more than 10000 rows of cuts".to_owned())?;
        for spot in rows.iter_mut().flatten().flat_map(|(from, to)| [from, to]) {
            *spot = turned_by(*spot, task.along);
        }
        Ok(rows)
    }

    /// Cycles 22 and 23, in one go, and 6.
    pub(super) fn rough_out(
        &self,
        host: &dyn InterpreterHost,
        task: &ContourParameters,
        at_once: bool,
    ) -> Result<Moves, String> {
        let (radius, factor) = (self.cutter(host)?, host.length_factor());
        let amount = radius + task.allowance * factor;
        let mut blocks = CycleBlockWriter::of(self, host);
        blocks.rise_to(task.safe, RAPID);
        for (AreaStage { figures, .. }, top, ground) in self.grounds(task, amount)? {
            let outlines = match task.others.earlier {
                Some(tool) => Self::remaining_ways(host, &figures, (task.allowance * factor, radius), (tool, task))?,
                None => self.ways(&figures, amount, task)?,
            };
            let rows = Self::rows(&outlines, (&figures, amount), task, radius)?;
            let levels = if at_once { vec![ground] } else { levels(top, ground, task.infeed) };
            for level in levels {
                blocks.cleared(&rows, &outlines, task, level);
            }
        }
        blocks.rise_to(task.safe, RAPID);
        Ok(blocks.moves)
    }

    /// Cycles 24 and 16.
    pub(super) fn finish_sides(&self, host: &dyn InterpreterHost, task: &ContourParameters) -> Result<Moves, String> {
        let (radius, factor) = (self.cutter(host)?, host.length_factor());
        let amount = radius + task.allowance * factor;
        let side = if task.climbs { 1.0 } else { -1.0 };
        let mut blocks = CycleBlockWriter::of(self, host);
        blocks.rise_to(task.safe, RAPID);
        for (AreaStage { figures, .. }, top, ground) in self.grounds(task, amount)? {
            let all: Vec<ClosedContour> = figures.iter().map(|figure| figure.outline.clone()).collect();
            // An open boundary has no side.
            let sides = if task.others.open { figures.get(1..).unwrap_or_default() } else { &figures[..] };
            for way in self.ways(sides, amount, task)? {
                let (Some(first), Some(last)) = (way.elements().first(), way.elements().last()) else { continue };
                let both = |size: f64| {
                    let to = quarter(first.from, first.start(), side, size, true)?;
                    let from = quarter(last.to, last.end(), side, size, false)?;
                    (is_clear(&to, &all, amount) && is_clear(&from, &all, amount)).then_some((to, from))
                };
                let quarters = (0..6).find_map(|halved| both(radius / f64::from(1 << halved)));
                let Some((to, from)) = quarters else {
                    return Err("a side of a contour of cycle 14 has no room for a way to it".to_owned());
                };
                for level in levels(top, ground, task.infeed) {
                    blocks.plunge(to.from, task, level);
                    blocks.element(&to, task.feed);
                    for element in way.elements() {
                        blocks.element(element, task.feed);
                    }
                    blocks.element(&from, task.feed);
                    blocks.rise_to(task.clear, RAPID);
                }
            }
        }
        blocks.rise_to(task.safe, RAPID);
        Ok(blocks.moves)
    }

    /// Cycles 21 and 15: holes where the roughing cycle plunges, with tool Q13 or the active one.
    pub(super) fn drill_pilots(&self, host: &dyn InterpreterHost, task: &ContourParameters) -> Result<Moves, String> {
        let factor = host.length_factor();
        let radius = match task.others.holes {
            Some(tool) => host.tool_size(tool)[1],
            None => self.cutter(host)?,
        };
        if radius <= 0.0 {
            return Err("tool Q13, with which cycle 22 roughs, has no radius".to_owned());
        }
        let amount = radius + task.allowance * factor;
        let mut blocks = CycleBlockWriter::of(self, host);
        blocks.rise_to(task.safe, RAPID);
        for (AreaStage { figures, .. }, _, ground) in self.grounds(task, amount)? {
            let outlines = self.ways(&figures, amount, task)?;
            let rows = Self::rows(&outlines, (&figures, amount), task, radius)?;
            let of_rows = rows.iter().filter_map(|row| row.first()).map(|(from, _)| *from);
            let starts =
                of_rows.chain(outlines.iter().filter_map(|way| way.elements().first()).map(|element| element.from));
            let depth = task.surface - ground;
            // In millimetres, for any unit of the program.
            let depth = depth * factor;
            let ahead = if depth > 30.0 { (depth / 50.0).min(7.0) } else { 0.6 } / factor;
            for start in starts {
                blocks.drilled(start, task, &levels(task.surface, ground, task.infeed), ahead);
            }
        }
        blocks.rise_to(task.safe, RAPID);
        Ok(blocks.moves)
    }
}
