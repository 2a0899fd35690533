//! Points, lines, planes, cylinders; a figure that cannot be constructed is `$NULL`.

use super::vector::{along, cross, dot, norm, normalised};
use super::{FunctionContext, number, numbers};
use crate::fault::Outcome;
use crate::value::MacroValue;

const SMALL: f64 = 1e-12;

/// Three numbers from a place of a sequence on.
fn triple(values: &[f64], from: usize) -> Option<[f64; 3]> {
    values.get(from..from + 3)?.try_into().ok()
}

fn point(arguments: &[MacroValue], position: usize) -> Outcome<Option<[f64; 3]>> {
    Ok(triple(&numbers(arguments, position)?, 0))
}

fn minus(a: [f64; 3], b: [f64; 3]) -> Vec<f64> {
    along(&a, &b, -1.0)
}

fn or_null(value: Option<Vec<f64>>) -> Outcome<MacroValue> {
    let good = value.filter(|numbers| numbers.iter().all(|number| number.is_finite()));
    Ok(good.map_or(MacroValue::Null, |numbers| MacroValue::numbers(&numbers)))
}

pub(super) fn cylinder_through_points(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (a, b, c) = (point(arguments, 0)?, point(arguments, 1)?, point(arguments, 2)?);
    or_null((|| {
        let (a, b, c) = (a?, b?, c?);
        let (ab, ac) = (minus(b, a), minus(c, a));
        let normal = cross(&ab, &ac);
        let square = dot(&normal, &normal);
        if square < SMALL {
            return None;
        }
        let first = cross(&normal, &ab);
        let second = cross(&ac, &normal);
        let (p, q) = (dot(&ac, &ac) / (2.0 * square), dot(&ab, &ab) / (2.0 * square));
        let offset: Vec<f64> = first.iter().zip(second).map(|(x, y)| p * x + q * y).collect();
        let mut result = along(&a, &offset, 1.0);
        result.extend(normalised(&normal));
        result.push(norm(&offset));
        Some(result)
    })())
}

pub(super) fn line_and_plane(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (line, plane) = (numbers(arguments, 0)?, numbers(arguments, 1)?);
    or_null((|| {
        let (start, way, normal) = (triple(&line, 0)?, triple(&line, 3)?, triple(&plane, 1)?);
        let along_normal = dot(&way, &normal);
        if along_normal.abs() < SMALL {
            return None;
        }
        Some(along(&start, &way, (plane.first()? - dot(&start, &normal)) / along_normal))
    })())
}

/// Where a segment meets a surface `A t² + 2 B t + C = 0`, with its ends.
fn crossings(start: [f64; 3], way: &[f64], (a, b, c): (f64, f64, f64)) -> Vec<f64> {
    let inside_start = c < 0.0;
    let end_value = a + 2.0 * b + c;
    let root = b * b - a * c;
    let mut result = Vec::new();
    if a.abs() > SMALL && root >= 0.0 {
        let root = root.sqrt();
        let mut places = vec![(-b - root) / a];
        if root > SMALL {
            places.push((-b + root) / a);
        }
        for place in places.into_iter().filter(|t| (-1e-12..=1.0 + 1e-12).contains(t)) {
            result.extend(along(&start, way, place));
        }
    }
    #[allow(clippy::cast_precision_loss)]
    let count = (result.len() / 3) as f64;
    let place = if count > 0.0 {
        0.0
    } else if inside_start && end_value <= 0.0 {
        -1.0
    } else {
        1.0
    };
    [vec![count, place], result].concat()
}

pub(super) fn segment_and_cylinder(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (p1, p2, third) = (point(arguments, 0)?, point(arguments, 1)?, numbers(arguments, 2)?);
    let (axis, radius) = if arguments.len() > 4 {
        (point(arguments, 3)?, Some(number(arguments, 4)?))
    } else {
        (triple(&third, 3), third.get(6).copied())
    };
    or_null((|| {
        let (start, end, base, radius) = (p1?, p2?, triple(&third, 0)?, radius?);
        let axis = axis?;
        if norm(&axis) < SMALL {
            return None;
        }
        let axis = normalised(&axis);
        let flat = |v: &[f64]| along(v, &axis, -dot(v, &axis));
        let way = minus(end, start);
        let (w, d) = (flat(&minus(start, base)), flat(&way));
        Some(crossings(start, &way, (dot(&d, &d), dot(&w, &d), dot(&w, &w) - radius * radius)))
    })())
}

pub(super) fn segment_and_sphere(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (p1, p2, centre) = (point(arguments, 0)?, point(arguments, 1)?, point(arguments, 2)?);
    let radius = number(arguments, 3)?;
    or_null((|| {
        let (start, end, centre) = (p1?, p2?, centre?);
        let (way, w) = (minus(end, start), minus(start, centre));
        Some(crossings(start, &way, (dot(&way, &way), dot(&w, &way), dot(&w, &w) - radius * radius)))
    })())
}

fn plane(at: [f64; 3], normal: &[f64]) -> Option<Vec<f64>> {
    if norm(normal) < SMALL {
        return None;
    }
    let normal = normalised(normal);
    let mut result = vec![dot(&at, &normal)];
    result.extend(normal);
    Some(result)
}

pub(super) fn plane_through_points(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (a, b, c) = (point(arguments, 0)?, point(arguments, 1)?, point(arguments, 2)?);
    or_null((|| plane(a?, &cross(&minus(b?, a?), &minus(c?, a?))))())
}

pub(super) fn plane_with_normal(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (at, normal) = (point(arguments, 0)?, point(arguments, 1)?);
    or_null((|| plane(at?, &normal?))())
}

pub(super) fn projection(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (p, second) = (point(arguments, 0)?, numbers(arguments, 1)?);
    let normal = if arguments.len() > 2 { point(arguments, 2)? } else { triple(&second, 1) };
    or_null((|| {
        let (p, normal) = (p?, normal?);
        if norm(&normal) < SMALL {
            return None;
        }
        let normal = normalised(&normal);
        let distance = if arguments.len() > 2 { dot(&triple(&second, 0)?, &normal) } else { *second.first()? };
        Some(along(&p, &normal, distance - dot(&p, &normal)))
    })())
}
