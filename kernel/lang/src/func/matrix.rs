//! Matrices: sequences of 12 numbers (three rows of rotation and translation) or of n×n numbers by rows.

use super::math::{cosine, sine};
use super::{FunctionContext, impossible, numbers};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::host::HostFn;
use crate::ident;
use crate::value::MacroValue;

/// A square matrix; 12 numbers become 4×4.
#[derive(Clone)]
struct Matrix {
    size: usize,
    cells: Vec<f64>,
    /// Was given as 3×4.
    short: bool,
}

impl Matrix {
    fn identity(size: usize) -> Matrix {
        let cells = (0..size * size).map(|at| if at % (size + 1) == 0 { 1.0 } else { 0.0 }).collect();
        Matrix { size, cells, short: size == 4 }
    }

    fn new(mut cells: Vec<f64>) -> Outcome<Matrix> {
        if cells.len() == 12 {
            cells.extend([0.0, 0.0, 0.0, 1.0]);
            return Ok(Matrix { size: 4, cells, short: true });
        }
        match (1..=16).find(|size| size * size == cells.len()) {
            Some(size) => Ok(Matrix { size, cells, short: false }),
            None => Err(MacroFault::new(
                DiagnosticNumber::BAD_VECTOR,
                format!("{} numbers do not make a matrix", cells.len()),
            )),
        }
    }

    fn at(&self, row: usize, column: usize) -> f64 {
        self.cells.get(row * self.size + column).copied().unwrap_or(0.0)
    }

    fn put(&mut self, row: usize, column: usize, value: f64) {
        if let Some(cell) = self.cells.get_mut(row * self.size + column) {
            *cell = value;
        }
    }

    fn value(&self) -> MacroValue {
        let keep = if self.short { 12 } else { self.cells.len() };
        MacroValue::numbers(self.cells.get(..keep).unwrap_or(&self.cells))
    }

    fn times(&self, other: &Matrix) -> Matrix {
        let mut result = Matrix { short: self.short && other.short, ..Matrix::identity(self.size) };
        for row in 0..self.size {
            for column in 0..self.size {
                let sum = (0..self.size).map(|k| self.at(row, k) * other.at(k, column)).sum();
                result.put(row, column, sum);
            }
        }
        result
    }

    fn inverted(&self) -> Option<Matrix> {
        let (mut left, mut right) = (self.clone(), Matrix { short: self.short, ..Matrix::identity(self.size) });
        for pivot in 0..self.size {
            let best =
                (pivot..self.size).max_by(|a, b| left.at(*a, pivot).abs().total_cmp(&left.at(*b, pivot).abs()))?;
            if left.at(best, pivot).abs() < 1e-12 {
                return None;
            }
            for column in 0..self.size {
                for matrix in [&mut left, &mut right] {
                    let (a, b) = (matrix.at(best, column), matrix.at(pivot, column));
                    matrix.put(pivot, column, a);
                    if best != pivot {
                        matrix.put(best, column, b);
                    }
                }
            }
            let scale = left.at(pivot, pivot);
            for column in 0..self.size {
                for matrix in [&mut left, &mut right] {
                    matrix.put(pivot, column, matrix.at(pivot, column) / scale);
                }
            }
            for row in (0..self.size).filter(|row| *row != pivot) {
                let factor = left.at(row, pivot);
                for column in 0..self.size {
                    for matrix in [&mut left, &mut right] {
                        matrix.put(row, column, matrix.at(row, column) - factor * matrix.at(pivot, column));
                    }
                }
            }
        }
        Some(right)
    }

    fn shifted(shift: &[f64]) -> Matrix {
        let mut result = Matrix::identity(4);
        shift.iter().take(3).enumerate().for_each(|(row, value)| result.put(row, 3, *value));
        result
    }

    /// Rotation in the plane of two axes.
    fn rotated((a, b): (usize, usize), degrees: f64) -> Matrix {
        let (s, c) = (sine(degrees).unwrap_or(0.0), cosine(degrees).unwrap_or(1.0));
        let mut result = Matrix::identity(4);
        result.put(a, a, c);
        result.put(b, b, c);
        result.put(a, b, -s);
        result.put(b, a, s);
        result
    }
}

/// Words and numbers of $FMX in order.
struct Items<'a>(&'a [MacroValue]);

impl Items<'_> {
    fn word(&mut self, word: &str) -> bool {
        let found = match self.0.first() {
            Some(MacroValue::Keyword(code)) => ident::minor_name(*code) == Some(word),
            Some(MacroValue::Record(record)) => ident::record_name(*record) == Some(word),
            _ => false,
        };
        if found {
            self.0 = self.0.get(1..).unwrap_or(&[]);
        }
        found
    }

    fn numbers(&mut self) -> Vec<f64> {
        let found: Vec<f64> = self.0.iter().map_while(MacroValue::as_real).collect();
        self.0 = self.0.get(found.len()..).unwrap_or(&[]);
        found
    }
}

const PLANES: [(&str, (usize, usize)); 3] = [("XYROT", (0, 1)), ("YZROT", (1, 2)), ("ZXROT", (2, 0))];

pub(super) fn build(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let mut items = Items(arguments);
    let inverse = items.word("INVERS");
    if items.word("MSYS") {
        let last = items.word("LAST");
        let asked = [MacroValue::Logical(last)];
        let frame = context.host.function(context.state, HostFn::MachineFrame, &asked)?;
        return if inverse { invert(&numbers(&[frame], 0)?) } else { Ok(frame) };
    }
    let first = items.numbers();
    let matrix = if first.len() == 12 { Matrix::new(first)? } else { steps(&first, &mut items)? };
    if !items.0.is_empty() {
        return Err(MacroFault::new(DiagnosticNumber::TYPE_MISMATCH, "$FMX cannot read the rest of its arguments"));
    }
    if inverse { matrix.inverted().map_or_else(singular, |matrix| Ok(matrix.value())) } else { Ok(matrix.value()) }
}

fn steps(first: &[f64], items: &mut Items<'_>) -> Outcome<Matrix> {
    let wrong = |what: &str| Err(MacroFault::new(DiagnosticNumber::WRONG_COUNT, format!("$FMX needs {what}")));
    if !matches!(first.len(), 0 | 2 | 3) || (first.is_empty() && items.0.is_empty()) {
        return wrong("two or three numbers, twelve, or a rotation");
    }
    let mut matrix = Matrix::identity(4);
    while let Some((_, plane)) = PLANES.into_iter().find(|(word, _)| items.word(word)) {
        let [degrees] = items.numbers()[..] else { return wrong("one angle after the name of a plane") };
        let turn = Matrix::rotated(plane, degrees);
        let turn = if items.word("AT") {
            let centre = items.numbers();
            if !matches!(centre.len(), 2 | 3) {
                return wrong("two or three numbers after AT");
            }
            let back: Vec<f64> = centre.iter().map(|value| -value).collect();
            Matrix::shifted(&centre).times(&turn).times(&Matrix::shifted(&back))
        } else {
            turn
        };
        matrix = matrix.times(&turn);
    }
    if items.word("TRANS") {
        let shift = items.numbers();
        if !matches!(shift.len(), 2 | 3) {
            return wrong("two or three numbers after TRANS");
        }
        matrix = matrix.times(&Matrix::shifted(&shift));
    }
    Ok(Matrix::shifted(first).times(&matrix))
}

fn singular() -> Outcome<MacroValue> {
    impossible("this matrix has no inverse")
}

fn invert(cells: &[f64]) -> Outcome<MacroValue> {
    Matrix::new(cells.to_vec())?.inverted().map_or_else(singular, |matrix| Ok(matrix.value()))
}

pub(super) fn inverse(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    invert(&numbers(arguments, 0)?)
}

pub(super) fn transpose(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let matrix = Matrix::new(numbers(arguments, 0)?)?;
    let mut result = matrix.clone();
    let size = if matrix.short { 3 } else { matrix.size };
    for row in 0..size {
        for column in 0..size {
            result.put(row, column, matrix.at(column, row));
        }
    }
    Ok(result.value())
}

pub(super) fn product(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (a, b) = (Matrix::new(numbers(arguments, 0)?)?, Matrix::new(numbers(arguments, 1)?)?);
    if a.size != b.size {
        return Err(MacroFault::new(DiagnosticNumber::BAD_VECTOR, "these matrices have different sizes"));
    }
    Ok(a.times(&b).value())
}

fn transformed(arguments: &[MacroValue], translation: f64) -> Outcome<MacroValue> {
    let (matrix, input) = (Matrix::new(numbers(arguments, 0)?)?, numbers(arguments, 1)?);
    let homogeneous = matrix.size == 4;
    let size = if homogeneous { 3 } else { matrix.size };
    let at = |column: usize| input.get(column).copied().unwrap_or(0.0);
    let mut result = input.clone();
    for (row, cell) in result.iter_mut().take(size).enumerate() {
        *cell = (0..size.min(input.len())).map(|column| matrix.at(row, column) * at(column)).sum();
        if homogeneous {
            *cell += translation * matrix.at(row, 3);
        }
    }
    Ok(MacroValue::numbers(&result))
}

pub(super) fn point(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    transformed(arguments, 1.0)
}

pub(super) fn vector(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    transformed(arguments, 0.0)
}

/// Composition of a linear part, apart from a mirror.
#[derive(Clone, Copy, PartialEq)]
enum MatrixShape {
    Zero,
    Plain,
    Rotated,
    Scaled,
    Mixed,
}

/// A product of two columns of a rotation given to nine digits differs from 0 or 1 by less than this.
const NINE_DIGITS: f64 = 2e-9;

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-9
}

/// Determines the shape of the upper left `size` rows and columns. A half turn is a rotation, and so are three negative
/// directions: a half turn and a mirror.
fn shape(matrix: &Matrix, size: usize) -> MatrixShape {
    let all = |test: &dyn Fn(usize, usize) -> bool| (0..size).all(|r| (0..size).all(|c| test(r, c)));
    if all(&|r, c| near(matrix.at(r, c), 0.0)) {
        return MatrixShape::Zero;
    }
    let column = |c: usize| (0..size).map(|r| matrix.at(r, c)).collect::<Vec<f64>>();
    let columns: Vec<Vec<f64>> = (0..size).map(column).collect();
    let product = |a: usize, b: usize| match (columns.get(a), columns.get(b)) {
        (Some(a), Some(b)) => super::vector::dot(a, b),
        _ => 0.0,
    };
    let pure = all(&|a, b| (product(a, b) - f64::from(u8::from(a == b))).abs() < NINE_DIGITS);
    let straight = all(&|r, c| r == c || near(matrix.at(r, c), 0.0));
    let turned = !straight || (0..size).filter(|at| matrix.at(*at, *at) < 0.0).count() > 1;
    match (turned, pure) {
        (true, true) => MatrixShape::Rotated,
        (true, false) => MatrixShape::Mixed,
        (false, true) => MatrixShape::Plain,
        (false, false) => MatrixShape::Scaled,
    }
}

pub(super) fn kind(_: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let matrix = Matrix::new(numbers(arguments, 0)?)?;
    let homogeneous = matrix.size == 4;
    let size = if homogeneous { 3 } else { matrix.size };
    let translation = homogeneous && (0..3).any(|row| !near(matrix.at(row, 3), 0.0));
    let shape = shape(&matrix, size);
    let mirrored = determinant(&matrix, size) < 0.0;
    // A mirror or a scale cannot be distinguished from a rotation that it is mixed with.
    let rotation = match shape {
        MatrixShape::Rotated if !mirrored => 100.0,
        MatrixShape::Rotated | MatrixShape::Mixed => 200.0,
        _ => 0.0,
    };
    let parts = [
        ("TRANS", if translation { 10.0 } else { 0.0 }),
        ("ROTATE", rotation),
        ("SCALE", if shape == MatrixShape::Scaled { 1000.0 } else { 0.0 }),
        ("MIRROR", if mirrored && rotation == 0.0 { 10000.0 } else { 0.0 }),
    ];
    let mut wanted = Items(arguments.get(1..).unwrap_or(&[]));
    for (word, part) in parts {
        if wanted.word(word) {
            return Ok(MacroValue::Real(part));
        }
    }
    if let Some(other) = arguments.get(1) {
        return Err(MacroFault::kind("TRANS, ROTATE, SCALE or MIRROR", other));
    }
    let sum: f64 = parts.iter().map(|(_, part)| part).sum();
    Ok(MacroValue::Real(if sum == 0.0 && shape == MatrixShape::Plain { 1.0 } else { sum }))
}

fn determinant(matrix: &Matrix, size: usize) -> f64 {
    let mut work = matrix.clone();
    let mut result = 1.0;
    for pivot in 0..size {
        let best = (pivot..size).max_by(|a, b| work.at(*a, pivot).abs().total_cmp(&work.at(*b, pivot).abs()));
        let best = best.unwrap_or(pivot);
        if work.at(best, pivot) == 0.0 {
            return 0.0;
        }
        if best != pivot {
            result = -result;
            for column in 0..size {
                let (a, b) = (work.at(best, column), work.at(pivot, column));
                work.put(pivot, column, a);
                work.put(best, column, b);
            }
        }
        result *= work.at(pivot, pivot);
        for row in pivot + 1..size {
            let factor = work.at(row, pivot) / work.at(pivot, pivot);
            for column in pivot..size {
                work.put(row, column, work.at(row, column) - factor * work.at(pivot, column));
            }
        }
    }
    result
}
