//! The functions of the language.
//!
//! *Invariant:* a function is found by its row in one table; its result never depends on its name. Angles are in
//! degrees. Facts: the function catalogue of the reference.

mod convert;
mod date;
mod files;
mod geometry;
mod math;
mod matrix;
mod sort;
mod text;
mod vector;

pub use date::stamp;

use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::host::{HostFn, MacroHost, ROWS};
use crate::state::MacroState;
use crate::value::{MacroValue, ValueType};
use std::collections::HashMap;
use std::sync::OnceLock;

/// Data that a computing function may use.
pub struct FunctionContext<'a> {
    /// The machine.
    pub state: &'a mut MacroState,
    /// The outside.
    pub host: &'a mut dyn MacroHost,
}

/// How a function is computed.
#[derive(Clone, Copy)]
pub enum EvaluationMethod {
    /// From one number, none where it has no result.
    Math(fn(f64) -> Option<f64>),
    /// From two numbers, none where that is not so easy; then, and from other values, from its arguments.
    Pair(fn(f64, f64) -> Option<f64>, fn(&mut FunctionContext<'_>, &[MacroValue]) -> Outcome<MacroValue>),
    /// From its arguments.
    Compute(fn(&mut FunctionContext<'_>, &[MacroValue]) -> Outcome<MacroValue>),
    /// By the host.
    Host(HostFn),
    /// Part of another product, which the text names.
    Missing(&'static str),
}

/// A row of the table.
#[derive(Clone, Copy)]
pub struct BuiltInFunction {
    /// Name with its dollar sign.
    pub name: &'static str,
    /// Types of the arguments: `n s q l k c r` and `a` for any, upper case from the first optional one on, `+` after
    /// the last group that may repeat.
    pub arguments: &'static str,
    /// Type of the result if there is only one.
    pub result: Option<ValueType>,
    /// How it is computed.
    pub way: EvaluationMethod,
}

impl std::fmt::Debug for BuiltInFunction {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

impl PartialEq for BuiltInFunction {
    fn eq(&self, other: &BuiltInFunction) -> bool {
        self.name == other.name
    }
}

impl BuiltInFunction {
    /// Least number of arguments.
    #[must_use]
    pub fn least(&self) -> usize {
        self.arguments.bytes().take_while(|byte| byte.is_ascii_lowercase()).count()
    }

    /// Most arguments.
    #[must_use]
    pub fn most(&self) -> usize {
        if self.arguments.ends_with('+') { usize::MAX } else { self.arguments.len() }
    }

    /// Letter of the type of an argument.
    #[must_use]
    pub fn letter(&self, position: usize) -> u8 {
        let letters = self.arguments.trim_end_matches('+').as_bytes();
        letters.get(position).copied().unwrap_or(b'a').to_ascii_lowercase()
    }
}

/// Whether a value of this type fits a letter of a signature.
#[must_use]
pub fn fits(letter: u8, kind: ValueType) -> bool {
    match letter {
        b'n' => kind == ValueType::Real,
        b's' => kind == ValueType::Text,
        b'q' => kind == ValueType::Sequence,
        b'l' => kind == ValueType::Logical,
        b'k' => kind == ValueType::Keyword || kind == ValueType::Record,
        b'c' => kind == ValueType::Code,
        b'r' => kind == ValueType::Register,
        _ => true,
    }
}

const R: Option<ValueType> = Some(ValueType::Real);
const S: Option<ValueType> = Some(ValueType::Text);
const Q: Option<ValueType> = Some(ValueType::Sequence);
const L: Option<ValueType> = Some(ValueType::Logical);
const A: Option<ValueType> = None;

const fn math(name: &'static str, function: fn(f64) -> Option<f64>) -> BuiltInFunction {
    BuiltInFunction { name, arguments: "n", result: R, way: EvaluationMethod::Math(function) }
}

const fn pure(
    name: &'static str,
    arguments: &'static str,
    result: Option<ValueType>,
    function: fn(&mut FunctionContext<'_>, &[MacroValue]) -> Outcome<MacroValue>,
) -> BuiltInFunction {
    BuiltInFunction { name, arguments, result, way: EvaluationMethod::Compute(function) }
}

const fn missing(name: &'static str, why: &'static str) -> BuiltInFunction {
    BuiltInFunction { name, arguments: "A+", result: A, way: EvaluationMethod::Missing(why) }
}

const POST: &str = "it belongs to the post-processor product";

/// Functions that are computed here.
static COMPUTED: &[BuiltInFunction] = &[
    math("$FSIN", math::sine),
    math("$FCOS", math::cosine),
    math("$FTAN", math::tangent),
    math("$FASIN", math::arc_sine),
    math("$FACOS", math::arc_cosine),
    math("$FATAN", math::arc_tangent),
    math("$FEXP", math::exponential),
    math("$FLN", math::natural_logarithm),
    math("$FLOG", math::logarithm),
    math("$FSQRT", math::root),
    math("$FABS", |n| Some(n.abs())),
    math("$FSIGN", |n| Some(if n == 0.0 { 0.0 } else { n.signum() })),
    math("$FINT", |n| Some(n.trunc())),
    math("$FFRAC", |n| Some(n - n.trunc())),
    math("$FNINT", |n| Some(n.round())),
    math("$FCEIL", |n| Some(n.ceil())),
    math("$FFLOOR", |n| Some(n.floor())),
    pure("$FATAN2", "nn", R, math::arc_tangent_of_two),
    BuiltInFunction {
        name: "$FMOD",
        arguments: "nn",
        result: R,
        way: EvaluationMethod::Pair(math::quick_remainder, math::remainder),
    },
    pure("$FMAX", "nnN+", R, math::largest),
    pure("$FMIN", "nnN+", R, math::smallest),
    pure("$FDIST", "nnnnnn", R, math::distance),
    pure("$FCHAR", "n", S, text::character),
    pure("$FICHAR", "s", R, text::code_of),
    pure("$FLEN", "a", R, text::length),
    pure("$FINDEX", "ss", R, text::index),
    pure("$FFIND", "aaN", R, text::find),
    pure("$FEDIT", "ssAN", S, text::edit),
    pure("$FMATCH", "ssAN", S, text::matched),
    pure("$FSPLIT", "ssN", Q, text::split),
    pure("$FSWRIT", "sA+", S, text::formatted),
    pure("$FTOLOWR", "s", S, text::lower),
    pure("$FTOUPER", "s", S, text::upper),
    pure("$FTRIM", "sS", S, text::trim),
    pure("$FTRIML", "sS", S, text::trim_left),
    pure("$FTRIMR", "sS", S, text::trim_right),
    pure("$FELEM", "qn", A, text::element),
    pure("$FSUBSQ", "qnn", Q, text::part_of_sequence),
    pure("$FSUBST", "snn", S, text::part_of_text),
    pure("$FSEQ", "A+", Q, text::sequence),
    pure("$FDATE", "sA", S, date::date),
    pure("$FCTIME", "n", S, date::time_text),
    pure("$FATOF", "s", R, convert::number),
    pure("$FCVREAL", "a", R, convert::real),
    pure("$FCVINT", "a", R, convert::whole),
    pure("$FMINOR", "a", A, convert::minor),
    pure("$FMAJOR", "aN", A, convert::major),
    pure("$FISNUM", "a", L, |_, v| Ok(convert::is(v, ValueType::Real))),
    pure("$FISSTR", "a", L, |_, v| Ok(convert::is(v, ValueType::Text))),
    pure("$FISSEQ", "a", L, |_, v| Ok(convert::is(v, ValueType::Sequence))),
    pure("$FISWRD", "a", L, |_, v| Ok(convert::is(v, ValueType::Keyword))),
    pure("$FIF", "laa", A, convert::choice),
    pure("$FCHOOSE", "naA+", A, convert::choose),
    pure("$FSWITCH", "laA+", A, convert::switch),
    pure("$FVADD", "qq", Q, vector::add),
    pure("$FVSUB", "qq", Q, vector::subtract),
    pure("$FVMULT", "qn", Q, vector::multiply),
    pure("$FVDOT", "qq", R, vector::dot_product),
    pure("$FVLEN", "q", R, vector::length),
    pure("$FVNORM", "q", Q, vector::unit),
    pure("$FVANG", "qq", A, vector::angle),
    pure("$FVCROSS", "qq", A, vector::cross_product),
    pure("$FVROTN", "qqn", A, vector::turn_toward),
    pure("$FVROTV", "nqqN", A, vector::turn_about),
    pure("$FMX", "aA+", A, matrix::build),
    pure("$FMXINV", "q", A, matrix::inverse),
    pure("$FMXTRSP", "q", Q, matrix::transpose),
    pure("$FMXMULT", "qq", Q, matrix::product),
    pure("$FMXTRFP", "qq", Q, matrix::point),
    pure("$FMXTRFV", "qq", Q, matrix::vector),
    pure("$FMXTYPE", "qK", R, matrix::kind),
    pure("$FGCYPT3", "qqq", A, geometry::cylinder_through_points),
    pure("$FGLNXPL", "qq", A, geometry::line_and_plane),
    pure("$FGLSXCY", "qqqQN", A, geometry::segment_and_cylinder),
    pure("$FGLSXSP", "qqqn", A, geometry::segment_and_sphere),
    pure("$FGPLPT3", "qqq", A, geometry::plane_through_points),
    pure("$FGPLPTN", "qq", A, geometry::plane_with_normal),
    pure("$FGPTRPL", "qqQ", A, geometry::projection),
    pure("$FEOF", "N", L, files::at_end),
    pure("$FBASNAM", "sS", S, files::base_name),
    pure("$FDIRNAM", "s", S, files::directory),
    pure("$FARGC", "SS", R, files::argument_count),
    pure("$FARGV", "nSS", S, files::argument),
    pure("$FPNAME", "s", S, files::qualifier_name),
    pure("$FPVALUE", "s", S, files::qualifier_value),
    pure("$FGETENV", "s", A, files::environment),
    pure("$FGETDEF", "s", A, files::definition),
    pure("$FSORT", "aA+", A, files::sort),
];

/// Functions that the host computes.
static HOSTED: [BuiltInFunction; ROWS.len()] = hosted();

#[allow(clippy::indexing_slicing, reason = "the compiler evaluates it, and both are of one length")]
const fn hosted() -> [BuiltInFunction; ROWS.len()] {
    let mut functions = [missing("", ""); ROWS.len()];
    let mut at = 0;
    while at < ROWS.len() {
        let (function, arguments, result) = ROWS[at];
        functions[at] =
            BuiltInFunction { name: function.name(), arguments, result, way: EvaluationMethod::Host(function) };
        at += 1;
    }
    functions
}

/// Functions of other products.
static MISSING: &[BuiltInFunction] = &[
    missing("$FCLREC", POST),
    missing("$FCLS", POST),
    missing("$FCL", POST),
    missing("$FSIZE", POST),
    missing("$FCLASS", POST),
    missing("$FSUBCL", POST),
    missing("$FARG", POST),
    missing("$FGETARG", POST),
    missing("$FLOOK", POST),
    missing("$FINFO", POST),
    missing("$FCLINFO", POST),
    missing("$FGETSB", POST),
    missing("$FAPPOS", POST),
    missing("$FOPPATH", POST),
    missing("$FTLTAB", POST),
    missing("$FEDRAP", POST),
];

/// `$FFIND` where its first argument is an element of a system variable.
pub(crate) static FIND_IN_SYSTEM: BuiltInFunction = pure("$FFIND()", "naaN+", R, text::find_in_system);

/// Every function.
pub fn all() -> impl Iterator<Item = &'static BuiltInFunction> {
    COMPUTED.iter().chain(&HOSTED).chain(MISSING)
}

/// Finds a function by its name, upper case.
#[must_use]
pub fn named(name: &str) -> Option<&'static BuiltInFunction> {
    static NAMES: OnceLock<HashMap<&'static str, &'static BuiltInFunction>> = OnceLock::new();
    NAMES.get_or_init(|| all().map(|function| (function.name, function)).collect()).get(name).copied()
}

/// An argument as a number.
fn number(arguments: &[MacroValue], position: usize) -> Outcome<f64> {
    let value = arguments.get(position).unwrap_or(&MacroValue::Unset);
    value.as_real().ok_or_else(|| MacroFault::kind("a number", value))
}

/// An argument as a text.
fn string(arguments: &[MacroValue], position: usize) -> Outcome<&str> {
    let value = arguments.get(position).unwrap_or(&MacroValue::Unset);
    value.as_text().ok_or_else(|| MacroFault::kind("a text", value))
}

/// An argument as a sequence.
fn sequence(arguments: &[MacroValue], position: usize) -> Outcome<&[MacroValue]> {
    let value = arguments.get(position).unwrap_or(&MacroValue::Unset);
    value.as_sequence().ok_or_else(|| MacroFault::kind("a sequence", value))
}

/// An argument as a sequence of numbers.
fn numbers(arguments: &[MacroValue], position: usize) -> Outcome<Vec<f64>> {
    sequence(arguments, position)?
        .iter()
        .map(|value| value.as_real().ok_or_else(|| MacroFault::kind("a number", value)))
        .collect()
}

/// A whole number that counts something; fractions are discarded, negatives are 0.
fn count(number: f64) -> usize {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let whole = number.max(0.0) as usize;
    whole
}

#[allow(clippy::cast_precision_loss)]
fn real(count: usize) -> MacroValue {
    MacroValue::Real(count as f64)
}

fn impossible<T>(message: impl Into<String>) -> Outcome<T> {
    Err(MacroFault::new(DiagnosticNumber::BAD_ARITHMETIC, message))
}
