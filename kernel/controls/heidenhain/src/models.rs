//! SEL CONTOUR: contours in programs of their own, and the formula that makes an area of them.
//!
//! Facts: programming manuals of the control: `DECLARE CONTOUR QC1 = "NAME"`, `QC10 = (QC1 | QC2) & QC3 \ QC4 ^ QC5`,
//! `#` for the area outside; DEPTH; the last formula counts. Decision: `&` binds more strongly than the other
//! operators, which bind from left to right. *Invariant:* a formula that has been read is finite and has only declared
//! contours.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::formula::Formula;
use super::lex::HeidenhainCursor;
use super::sl_contours::{AreaExpression, ContourSource, ContourSubprogram, Contours, Join};
use super::{Heidenhain, lex};

/// Most contours and joins of a formula, and how deep its brackets may be.
const MOST: usize = 1000;
const DEEPEST: usize = 50;

/// Current values of QC parameters.
#[derive(Debug, Default)]
struct Model {
    areas: Vec<(u32, AreaExpression)>,
    /// Each with its DEPTH.
    programs: Vec<(String, Option<f64>)>,
    last: Option<AreaExpression>,
}

impl Model {
    /// A block of the model.
    fn block(&mut self, text: &str) -> Result<(), String> {
        let mut cursor = HeidenhainCursor::new(text);
        if cursor.is_over() || cursor.keyword("BEGIN PGM") || cursor.keyword("END PGM") {
            return Ok(());
        }
        let declares = cursor.keyword("DECLARE CONTOUR");
        let target = number(&mut cursor).ok_or_else(|| wrong(text, "DECLARE CONTOUR or QC with a number"))?;
        if !cursor.take(b'=') {
            return Err(wrong(text, "an equal sign"));
        }
        let area = if declares {
            let name = cursor.quoted().ok_or_else(|| wrong(text, "the name of a program in quotation marks"))?;
            let name = name.to_owned();
            let depth = match cursor.keyword("DEPTH") {
                true => {
                    cursor.take(b'=');
                    let _ = cursor.take(b'+') || cursor.take(b'-');
                    let (_, depth) = cursor.number().ok_or_else(|| wrong(text, "the number of DEPTH"))?;
                    // A depth of 0 is that of the cycle.
                    Some(depth.abs()).filter(|depth| *depth > 0.0)
                }
                false => None,
            };
            self.programs.push((name, depth));
            AreaExpression::Contour(self.programs.len() - 1)
        } else {
            let area = self.sum(&mut cursor, 0).map_err(|what| wrong(text, what))?;
            self.last = Some(area.clone());
            area
        };
        if !cursor.is_over() {
            return Err(wrong(text, "DEPTH or the end of the block"));
        }
        self.areas.retain(|(known, _)| *known != target);
        let all = self.areas.iter().map(|(_, area)| area.size()).sum::<usize>();
        if area.size() > MOST || all > MOST * 10 || self.programs.len() > MOST {
            return Err(format!("'{text}' joins more than {MOST} contours, or is one of too many formulas"));
        }
        self.areas.push((target, area));
        Ok(())
    }

    fn sum(&self, cursor: &mut HeidenhainCursor<'_>, depth: usize) -> Result<AreaExpression, &'static str> {
        let mut area = self.product(cursor, depth)?;
        while let Some(join) = [(b'|', Join::Union), (b'^', Join::Either), (b'\\', Join::Without)]
            .into_iter()
            .find_map(|(sign, join)| cursor.take(sign).then_some(join))
        {
            area = AreaExpression::Of(join, Box::new(area), Box::new(self.product(cursor, depth)?));
        }
        Ok(area)
    }

    fn product(&self, cursor: &mut HeidenhainCursor<'_>, depth: usize) -> Result<AreaExpression, &'static str> {
        let mut area = self.operand(cursor, depth)?;
        while cursor.take(b'&') {
            area = AreaExpression::Of(Join::Common, Box::new(area), Box::new(self.operand(cursor, depth)?));
        }
        Ok(area)
    }

    fn operand(&self, cursor: &mut HeidenhainCursor<'_>, depth: usize) -> Result<AreaExpression, &'static str> {
        if depth > DEEPEST {
            return Err("fewer brackets");
        }
        if cursor.take(b'#') {
            return self.operand(cursor, depth + 1).map(|area| AreaExpression::Outside(Box::new(area)));
        }
        if cursor.take(b'(') {
            let area = self.sum(cursor, depth + 1)?;
            return if cursor.take(b')') { Ok(area) } else { Err("a closing bracket") };
        }
        let wanted = number(cursor).ok_or("QC with a number")?;
        let known = self.areas.iter().find(|(known, _)| *known == wanted);
        known.map(|(_, area)| area.clone()).ok_or("a QC that was declared before")
    }
}

/// Number of a QC parameter.
fn number(cursor: &mut HeidenhainCursor<'_>) -> Option<u32> {
    if cursor.take_text("QC") { cursor.whole() } else { None }
}

fn wrong(text: &str, expected: &str) -> String {
    format!("'{text}' is not understood; expected {expected}")
}

impl Heidenhain {
    /// SEL CONTOUR.
    pub(super) fn select_contour(&mut self, host: &mut dyn InterpreterHost, name: &Formula) -> Result<(), Halt> {
        let name = self.text(host, name)?;
        let Some((file, _)) = self.find_program(host, &name, false)? else {
            let text = format!("contour program '{name}' not found for '{}'; add it to the job", host.block_text());
            return Err(host.alarm(&diag::SUBPROGRAM_MISSING, text));
        };
        let mut model = Model::default();
        let source = host.source(file);
        let mut failed = None;
        for line in 1..=source.as_deref().map_or(0, |source| source.lines()) {
            let text = source.as_deref().map_or(&[][..], |source| source.line(line));
            let clean = lex::clean(text, &|level| host.skips(level));
            if let Err(why) = model.block(&clean.text) {
                failed = Some(format!("line {line} of {name}: {why}"));
                break;
            }
        }
        let (None, Some(formula)) = (&failed, model.last) else {
            let why = failed.unwrap_or_else(|| format!("{name} has no formula, such as QC10 = QC1 | QC2"));
            let text = format!("{why}, in '{}'", host.block_text());
            return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
        };
        let away = |at: &usize| model.programs.get(*at).is_some_and(|(_, depth)| depth.is_some());
        if formula.taken_away().iter().any(away) {
            let text = format!(
                "DEPTH of a contour that {name} takes away, or of which it takes what lies outside, is not emulated in '{}'",
                host.block_text()
            );
            return Err(host.alarm(&diag::STATEMENT_UNKNOWN, text));
        }
        let of =
            |(name, depth)| ContourSubprogram { source: ContourSource::Program(name), is_pocket: Some(true), depth };
        let labels = model.programs.into_iter().map(of).collect();
        self.cycles.contours = Contours::joined(labels, formula);
        Ok(())
    }
}
