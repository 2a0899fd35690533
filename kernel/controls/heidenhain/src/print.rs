//! Output of programs: FN 15, FN 16, FN 38 and their ISO forms, as messages.
//!
//! Facts: programming manuals of the control: texts with formats as `%4.2f`, masks with one print line each. Decisions:
//! wherever a program prints to, the lines are messages to the operator; keywords of masks for time, language and files
//! print nothing. Invariant: a format without a value prints nothing for it.

use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;
use counterpoint_fault::Halt;

use super::Heidenhain;
use super::eval::Evaluator;
use super::formula::operand;
use super::lex::{HeidenhainCursor, capitals};
use super::q_parameter::ParameterValue;
use super::words::shown;

/// Longest field of a format.
const WIDEST: usize = 500;

impl Heidenhain {
    /// `/"text %F" / Q1 / Q2`, or values alone.
    pub(super) fn send(&mut self, host: &mut dyn InterpreterHost, text: &str) -> Result<(), Halt> {
        let mut cursor = HeidenhainCursor::new(text);
        cursor.take_text("P01");
        cursor.take(b'/');
        let mut parts = Vec::new();
        while !cursor.is_over() {
            match operand(&mut cursor) {
                Ok(formula) => parts.push(formula),
                Err(wrong) => {
                    let text = format!("{wrong} of '{text}'");
                    return Err(host.alarm(&diag::MACRO_SYNTAX, text));
                }
            }
            if !(cursor.take(b'/') || cursor.take(b',') || cursor.take_text("P02") || cursor.take_text("P03")) {
                break;
            }
        }
        let mut evaluator = Evaluator::new(&mut self.variables, host);
        let values = parts.iter().map(|part| evaluator.value(part)).collect::<Result<Vec<_>, _>>()?;
        let line = match values.split_first() {
            Some((ParameterValue::Text(format), rest)) => formatted(format, rest),
            _ => values.iter().map(plain).collect::<Vec<_>>().join(" "),
        };
        host.show(&line);
        Ok(())
    }

    /// A mask: `MASK.A / OUT.TXT`.
    pub(super) fn print(&mut self, host: &mut dyn InterpreterHost, text: &str) -> Result<(), Halt> {
        // Paths have strokes of their own, the output is after one between blanks or after the last one.
        let (mask, _) = text.split_once(" /").or_else(|| text.rsplit_once('/')).unwrap_or((text, ""));
        let mask = mask.trim().trim_matches('"');
        let Some((file, _)) = self.find_program(host, mask, false)? else {
            let text = format!("mask {mask} not found for '{}'; nothing is printed", host.block_text());
            host.diagnose(&diag::PRINT_MASK, text);
            return Ok(());
        };
        let Some(source) = host.source(file) else { return Ok(()) };
        for line in 1..=source.lines().min(10_000) {
            let text = capitals(&String::from_utf8_lossy(source.line(line)));
            let text = text.trim().trim_end_matches(';');
            if !text.starts_with('"') {
                continue;
            }
            let mut cursor = HeidenhainCursor::new(text);
            let format = cursor.quoted().unwrap_or_default().to_owned();
            let mut values = Vec::new();
            while cursor.take(b',') {
                match operand(&mut cursor) {
                    Ok(formula) => values.push(Evaluator::new(&mut self.variables, host).value(&formula)?),
                    Err(_) => {
                        cursor.letters();
                        values.push(ParameterValue::Number(0.0));
                    }
                }
            }
            host.show(&formatted(&format, &values));
        }
        Ok(())
    }
}

fn plain(value: &ParameterValue) -> String {
    match value {
        ParameterValue::Number(value) => shown(*value),
        ParameterValue::Text(text) => text.to_string(),
    }
}

/// Fills values into a format.
fn formatted(format: &str, values: &[ParameterValue]) -> String {
    let (mut out, mut values) = (String::new(), values.iter());
    let mut rest = format;
    while let Some((before, behind)) = rest.split_once('%') {
        out.push_str(before);
        let flags = behind.len() - behind.trim_start_matches(['+', '-', '0', ' ', '#']).len();
        let (flags, numbers) = behind.split_at(flags);
        let length = numbers.bytes().take_while(|byte| byte.is_ascii_digit() || *byte == b'.').count();
        let (numbers, kind) = numbers.split_at(length);
        let kind_length = kind.chars().next().map_or(0, char::len_utf8);
        let (kind, after) = kind.split_at(kind_length);
        rest = after;
        if kind == "%" {
            out.push('%');
            continue;
        }
        let (width, places) = numbers.split_once('.').unwrap_or((numbers, ""));
        let width = width.parse::<usize>().unwrap_or(0).min(WIDEST);
        let places = places.parse::<usize>().ok().map(|places| places.min(20));
        let field = match (kind, values.next()) {
            (_, None) => String::new(),
            ("d" | "D" | "i" | "I", Some(ParameterValue::Number(value))) => format!("{}", value.trunc() + 0.0),
            (_, Some(ParameterValue::Number(value))) => match places {
                Some(places) => format!("{:.places$}", value + 0.0),
                None => shown(*value),
            },
            (_, Some(ParameterValue::Text(text))) => text.to_string(),
        };
        let field = if flags.contains('+') && !field.starts_with('-') { format!("+{field}") } else { field };
        out.push_str(&match flags.contains('-') {
            true => format!("{field:<width$}"),
            false => format!("{field:>width$}"),
        });
    }
    out.push_str(rest);
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_take_values_in_order() {
        let values = [ParameterValue::Number(1.5), ParameterValue::Text("A".into()), ParameterValue::Number(-7.9)];
        assert_eq!(formatted("x=%6.2F|%-3S|%D|%F 5%%", &values), "x=  1.50|A  |-7| 5%");
        assert_eq!(formatted("%", &[]), "");
        assert_eq!(formatted("100%é", &[]), "100");
    }
}
