//! Functions of texts, and those that ask about names.
//!
//! Facts: reference control-emulator.md 5.4. Places in a text count from 0, −1 means not found; letter case matters.
//! Decision: places count characters. Invariant: no result is longer than its operands, except for the widths of
//! SPRINT.

use super::conversions::number;
use super::evaluate::SiemensEvaluator;
use super::number_text::shown;
use super::value::Data;
use super::{Outcome, Siemens, SiemensBlockError, syntax, wrong_type};
use counterpoint_control_api::host::InterpreterHost;
use counterpoint_fault as diag;

/// Largest width in a format of SPRINT.
const WIDEST: usize = 100;

fn text(values: &[Data], at: usize) -> Outcome<String> {
    match values.get(at) {
        Some(Data::Text(text) | Data::Axis(text)) => Ok(text.clone()),
        Some(Data::Char(one)) => Ok(char::from(*one).to_string()),
        Some(other) => wrong_type(format!("{} is not a text", other.described())),
        None => Ok(String::new()),
    }
}

/// Place of a character, −1 for none.
fn place(found: Option<usize>) -> Data {
    Data::Int(found.and_then(|at| i64::try_from(at).ok()).unwrap_or(-1))
}

/// A number as texts have it.
fn parse(text: &str) -> Option<f64> {
    let text = text.trim().to_ascii_uppercase().replace("EX", "e");
    let plain = text.bytes().all(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b'e' | b'+' | b'-'));
    text.parse::<f64>().ok().filter(|value| plain && value.is_finite())
}

impl Siemens {
    pub(super) fn text_function(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        values: &[Data],
    ) -> Outcome<Data> {
        let first = || text(values, 0);
        let chars = |at: usize| text(values, at).map(|text| text.chars().collect::<Vec<char>>());
        Ok(match name {
            "TOUPPER" => Data::Text(first()?.to_uppercase()),
            "TOLOWER" => Data::Text(first()?.to_lowercase()),
            "STRLEN" => place(Some(first()?.chars().count())),
            "INDEX" | "MINDEX" => {
                let wanted = chars(1)?;
                place(chars(0)?.iter().position(|one| wanted.contains(one)))
            }
            "RINDEX" => {
                let wanted = chars(1)?;
                place(chars(0)?.iter().rposition(|one| wanted.contains(one)))
            }
            "MATCH" => {
                let (inside, wanted) = (first()?, text(values, 1)?);
                place(inside.find(&wanted).and_then(|at| inside.get(..at)).map(|before| before.chars().count()))
            }
            "SUBSTR" => {
                let count = |at: usize| values.get(at).map_or(Ok(f64::MAX), number);
                let (from, length) = (count(1)?, count(2)?);
                if from < 0.0 || length < 0.0 {
                    let text = format!("SUBSTR has no value from {from} with {length} characters");
                    return Err(SiemensBlockError::Alarm(&diag::MACRO_DOMAIN, text));
                }
                Data::Text(chars(0)?.into_iter().skip(from as usize).take(length as usize).collect())
            }
            "NUMBER" => match parse(&first()?) {
                Some(value) => Data::Real(value),
                None => {
                    let text = format!("\"{}\" is not a valid number", first()?);
                    return Err(SiemensBlockError::Alarm(&diag::MACRO_DOMAIN, text));
                }
            },
            "ISNUMBER" => Data::Bool(parse(&first()?).is_some()),
            "STRING" => Data::Text(values.first().map(Data::text).unwrap_or_default()),
            "AXSTRING" => match values.first() {
                Some(Data::Axis(axis)) => Data::Text(axis.clone()),
                other => {
                    return wrong_type(format!("{} is not an axis", other.map(Data::described).unwrap_or_default()));
                }
            },
            "AXNAME" => {
                let wanted = first()?.to_ascii_uppercase();
                if !super::evaluate::words_name(host, &wanted) {
                    return wrong_type(format!("axis {wanted} does not exist"));
                }
                Data::Axis(wanted)
            }
            "ISAXIS" => {
                let wanted = values.first().map_or(Ok(0.0), number)?;
                Data::Bool((1.0..4.0).contains(&wanted) && geometry_name(host, wanted as usize - 1).is_some())
            }
            "ISVAR" => Data::Bool(self.is_variable(host, &first()?)?),
            "GETT" => {
                let duplo = values.get(1).map(number).transpose()?;
                SiemensEvaluator { siemens: self, host }.named_tool(&first()?, duplo)?
            }
            "ISFILE" => Data::Bool(self.has_file(host, &first()?)?),
            "SPRINT" => Data::Text(sprint(&first()?, values.get(1..).unwrap_or_default())?),
            _ => return syntax(format!("function {name} does not exist")),
        })
    }

    fn is_variable(&mut self, host: &mut dyn InterpreterHost, text: &str) -> Outcome<bool> {
        let Some(name) = super::settings::named(text, &[]) else { return Ok(false) };
        let found = self.quietly(|this| {
            if name.name.starts_with('$') {
                return this.system(host, &name).map(|found| found.is_some());
            }
            this.locate(host, &name).map(|found| found.is_some())
        })?;
        Ok(found.unwrap_or(false))
    }
}

/// Name of the first, second or third geometry axis.
pub(super) fn geometry_name(host: &dyn InterpreterHost, at: usize) -> Option<String> {
    let wanted = ["X", "Y", "Z"].get(at)?;
    host.axes().into_iter().find(|axis| axis.letter.eq_ignore_ascii_case(wanted)).map(|axis| axis.letter)
}

/// Fills a format with values: `%5D`, `%8.3F`, `%S` and the like.
fn sprint(format: &str, values: &[Data]) -> Outcome<String> {
    let (mut out, mut values, mut rest) = (String::new(), values.iter(), format.chars().peekable());
    while let Some(one) = rest.next() {
        if one != '%' {
            out.push(one);
            continue;
        }
        if rest.peek() == Some(&'%') {
            rest.next();
            out.push('%');
            continue;
        }
        let left = rest.next_if_eq(&'-').is_some();
        let mut digits = String::new();
        while let Some(digit) = rest.next_if(char::is_ascii_digit) {
            digits.push(digit);
        }
        let mut decimals = String::new();
        if rest.next_if_eq(&'.').is_some() {
            while let Some(digit) = rest.next_if(char::is_ascii_digit) {
                decimals.push(digit);
            }
        }
        let width = digits.parse().unwrap_or(0_usize).min(WIDEST);
        let places = decimals.parse::<usize>().ok().map(|places| places.min(WIDEST));
        let letter = rest.next().unwrap_or(' ');
        let Some(value) = values.next() else { return syntax("SPRINT has fewer values than its format") };
        let text = piece(letter, value, places)?;
        let missing = " ".repeat(width.saturating_sub(text.chars().count()));
        out.push_str(&if left { text + &missing } else { missing + &text });
        if out.len() > 1000 {
            return wrong_type("a text is longer than 1000 characters");
        }
    }
    Ok(out)
}

fn piece(letter: char, value: &Data, places: Option<usize>) -> Outcome<String> {
    Ok(match letter.to_ascii_uppercase() {
        'D' | 'U' => format!("{:.0}", number(value)?.trunc()),
        'F' => format!("{:.*}", places.unwrap_or(6), number(value)?),
        'E' => format!("{:.*e}", places.unwrap_or(6), number(value)?),
        'G' => shown(number(value)?),
        'X' => format!("{:X}", number(value)? as i64 as u32),
        'B' => if number(value)? != 0.0 { "TRUE" } else { "FALSE" }.to_owned(),
        'C' => match value {
            Data::Char(one) => char::from(*one).to_string(),
            other => text(std::slice::from_ref(other), 0)?.chars().take(1).collect(),
        },
        'S' => match value {
            Data::Text(text) | Data::Axis(text) => text.chars().take(places.unwrap_or(usize::MAX)).collect(),
            other => other.text(),
        },
        other => return syntax(format!("SPRINT has no format %{other}")),
    })
}
