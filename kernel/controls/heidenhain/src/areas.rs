//! The area that SL contours make together.
//!
//! Facts: programming manuals of the control (overlapping contours of cycle 14: two pockets are one if the first starts
//! outside the second, otherwise their intersection counts; islands are removed; in CONTOUR DEF pockets are one; DEPTH
//! is that of a pocket, or the distance of an island below the surface; formulas of SEL CONTOUR). Decisions: a pocket
//! inside an island is also cut; depths make levels, and from each level to the next the area is that of the contours
//! there. *Invariant:* contours that do not meet, and that lie in each other only as pocket, island, pocket, stay as
//! programmed.

use counterpoint_motion::contour::closed::ClosedContour;
use counterpoint_motion::contour::combine::{combined, touch};
use counterpoint_motion::contour::shifted::shifted;

use super::Heidenhain;
use super::sl_contours::{AreaBoundary, AreaExpression, AreaStage, Contours, Join};

/// The union of areas.
fn union(areas: impl Iterator<Item = AreaExpression>) -> Option<AreaExpression> {
    areas.reduce(|one, other| one.joined(Join::Union, other))
}

/// The combined area of the figures: overlapping pockets, then islands removed, then pockets inside islands.
/// `by_start`: two pockets become their intersection if the first starts in the second.
fn of_figures(figures: &[AreaBoundary], by_start: bool) -> Option<AreaExpression> {
    let at = |place: usize| figures.get(place);
    let starts_in = |one: usize, other: usize| {
        let start = at(one).and_then(|figure| figure.outline.elements().first()).map(|element| element.from);
        start.zip(at(other)).is_some_and(|(start, other)| other.outline.holds(start))
    };
    let meets = |one: usize, other: usize| at(one).zip(at(other)).is_some_and(|(a, b)| touch(&a.outline, &b.outline));
    let of = |pocket: bool| (0..figures.len()).filter(move |place| at(*place).is_some_and(|f| f.is_pocket == pocket));
    let inside = |one: usize, other: usize| starts_in(one, other) && !meets(one, other);
    let is_inner = |pocket: &usize| of(false).any(|island| inside(*pocket, island));
    // Pockets that meet; each group with its area so far.
    let mut groups: Vec<(Vec<usize>, AreaExpression)> = Vec::new();
    for pocket in of(true).filter(|pocket| !is_inner(pocket)) {
        let mut area = AreaExpression::Contour(pocket);
        let mut members = vec![pocket];
        while let Some(near) = groups.iter().position(|(others, _)| others.iter().any(|other| meets(*other, pocket))) {
            let (others, group) = groups.remove(near);
            let first = others.iter().find(|other| meets(**other, pocket)).copied().unwrap_or(pocket);
            let join = if by_start && starts_in(first, pocket) { Join::Common } else { Join::Union };
            area = group.joined(join, area);
            members.extend(others);
        }
        groups.push((members, area));
    }
    let mut area = union(groups.into_iter().map(|(_, area)| area))?;
    let outer = of(false).filter(|island| !of(true).filter(is_inner).any(|pocket| inside(*island, pocket)));
    if let Some(islands) = union(outer.map(AreaExpression::Contour)) {
        area = area.joined(Join::Without, islands);
    }
    for pocket in of(true).filter(is_inner) {
        let own = union(of(false).filter(|island| inside(*island, pocket)).map(AreaExpression::Contour));
        let pocket = AreaExpression::Contour(pocket);
        let pocket = own.map_or_else(|| pocket.clone(), |own| pocket.clone().joined(Join::Without, own));
        area = area.joined(Join::Union, pocket);
    }
    Some(area)
}

/// The rims of an area as pockets and islands.
fn rims(figures: &[AreaBoundary], area: &AreaExpression, counts: &[bool]) -> Result<Vec<AreaBoundary>, String> {
    let outlines: Vec<ClosedContour> = figures.iter().map(|figure| figure.outline.clone()).collect();
    let counted = |held: &[bool]| held.iter().zip(counts).map(|(held, counts)| *held && *counts).collect::<Vec<_>>();
    let rings = combined(&outlines, |held| area.holds(&counted(held)))
        .ok_or_else(|| "the contours meet too often, or leave a rim that does not close".to_owned())?;
    let figure = |outline: ClosedContour| AreaBoundary { is_pocket: !outline.is_clockwise(), outline };
    Ok(rings.into_iter().map(figure).collect())
}

/// Pockets and islands as they may stand: apart, an island in a pocket, a pocket in an island.
fn is_plain(figures: &[AreaBoundary]) -> bool {
    figures.iter().enumerate().all(|(place, figure)| {
        let others = || figures.iter().enumerate().filter(|(other, _)| *other != place).map(|(_, other)| other);
        let Some(start) = figure.outline.elements().first().map(|element| element.from) else { return false };
        let around = others().filter(|other| other.outline.holds(start)).count();
        (around % 2 == 0) == figure.is_pocket && others().all(|other| !touch(&other.outline, &figure.outline))
    })
}

impl Contours {
    /// The area of figures without depths of their own.
    fn together(&self, figures: Vec<AreaBoundary>) -> Result<Vec<AreaBoundary>, String> {
        if let Some(formula) = &self.formula {
            return rims(&figures, formula, &vec![true; figures.len()]);
        }
        if is_plain(&figures) {
            return Ok(figures);
        }
        let lost = figures.iter().enumerate().filter(|(_, figure)| !figure.is_pocket).find(|(_, island)| {
            let start = island.outline.elements().first().map(|element| element.from);
            !figures.iter().filter(|figure| figure.is_pocket).any(|pocket| {
                touch(&pocket.outline, &island.outline) || start.is_some_and(|start| pocket.outline.holds(start))
            })
        });
        if let Some((place, _)) = lost {
            return Err(format!("contour {} of cycle 14 is an island outside of all pockets", place + 1));
        }
        let area = of_figures(&figures, self.by_start).ok_or_else(|| "cycle 14 has no pocket".to_owned())?;
        rims(&figures, &area, &vec![true; figures.len()])
    }
}

/// The first figure becomes larger, the others have to be islands in it.
fn open_boundary(figures: &mut [AreaBoundary], beyond: f64) -> Result<(), String> {
    let islands = figures.get(1..).unwrap_or_default().iter().all(|figure| !figure.is_pocket);
    let Some(first) = figures.first_mut().filter(|first| first.is_pocket && islands) else {
        return Err("an open boundary (Q569=1) is the first contour, a pocket, and the others are islands".to_owned());
    };
    let outside = if first.outline.is_clockwise() { 1.0 } else { -1.0 };
    let larger = shifted(first.outline.from_longest().elements(), outside, beyond).and_then(ClosedContour::new);
    first.outline = larger.ok_or_else(|| "the tool does not fit around the open boundary (Q569)".to_owned())?;
    if is_plain(figures) { Ok(()) } else { Err("islands reach beyond the open boundary (Q569), or meet".to_owned()) }
}

impl Heidenhain {
    /// The common area of the contours, from the surface down.
    /// `open`: how far the tool may go beyond the first of them, which bounds the material.
    pub(super) fn stages(&self, bottom: f64, open: Option<f64>) -> Result<Vec<AreaStage>, String> {
        let mut figures = self.figures()?;
        if let Some(beyond) = open {
            open_boundary(&mut figures, beyond)?;
        }
        let contours = &self.cycles.contours;
        let depth = |place: usize| contours.depth(place);
        let mut stops: Vec<f64> = (0..figures.len()).filter_map(depth).collect();
        if stops.is_empty() {
            return Ok(vec![AreaStage { depth: None, figures: contours.together(figures)? }]);
        }
        let is_pocket = |figure: &AreaBoundary| figure.is_pocket;
        if figures.iter().enumerate().any(|(place, figure)| is_pocket(figure) && depth(place).is_none()) {
            stops.push(bottom);
        }
        stops.sort_by(f64::total_cmp);
        stops.dedup_by(|a, b| (*a - *b).abs() < 1e-9);
        let mut stages = Vec::new();
        for stop in stops {
            // Islands stand up from below their tops; pockets end at their floors.
            let here = figures.iter().enumerate().filter(|(place, figure)| match depth(*place) {
                None if figure.is_pocket => bottom >= stop - 1e-9,
                None => true,
                Some(own) if figure.is_pocket => own >= stop - 1e-9,
                Some(top) => top < stop - 1e-9,
            });
            let here: Vec<AreaBoundary> = here.map(|(_, figure)| figure.clone()).collect();
            if let Some(formula) = &contours.formula {
                // Contours that end above are not there.
                let ends = |place: usize| depth(place).is_some_and(|own| own < stop - 1e-9);
                let counts: Vec<bool> = (0..figures.len()).map(|place| !ends(place)).collect();
                stages.push(AreaStage { depth: Some(stop), figures: rims(&figures, formula, &counts)? });
            } else if here.iter().any(is_pocket) {
                stages.push(AreaStage { depth: Some(stop), figures: contours.together(here)? });
            }
        }
        Ok(stages)
    }
}
