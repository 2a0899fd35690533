//! Dates: the codes of C, with hundredths of a second as `%s` and zone names as `%z` and `%Z`.

use super::{FunctionContext, number, string};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};
use crate::value::MacroValue;
use std::fmt::Write as _;

const MONTHS: [&str; 12] = [
    "January",
    "February",
    "March",
    "April",
    "May",
    "June",
    "July",
    "August",
    "September",
    "October",
    "November",
    "December",
];
const DAYS: [&str; 7] = ["Sunday", "Monday", "Tuesday", "Wednesday", "Thursday", "Friday", "Saturday"];

struct Moment {
    year: i64,
    month: usize,
    day: i64,
    hour: i64,
    minute: i64,
    second: i64,
    hundredth: i64,
    week_day: i64,
    year_day: i64,
}

/// Days since 1970-01-01 of a date of the Gregorian calendar.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let of_era = year.rem_euclid(400);
    let of_year = (153 * ((month + 9) % 12) + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
}

fn moment(seconds: f64) -> Moment {
    #[allow(clippy::cast_possible_truncation)]
    let hundredths = (seconds.clamp(-6e10, 2.5e11) * 100.0).floor() as i64;
    let whole = hundredths.div_euclid(100);
    let (day_number, rest) = (whole.div_euclid(86_400), whole.rem_euclid(86_400));
    let shifted = day_number + 719_468;
    let era = shifted.div_euclid(146_097);
    let of_era = shifted.rem_euclid(146_097);
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_index = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month_index + 2) / 5 + 1;
    let month = if month_index < 10 { month_index + 3 } else { month_index - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    Moment {
        year,
        month: usize::try_from(month).unwrap_or(1),
        day,
        hour: rest / 3600,
        minute: rest / 60 % 60,
        second: rest % 60,
        hundredth: hundredths.rem_euclid(100),
        week_day: (day_number + 4).rem_euclid(7),
        year_day: day_number - days(year, 1, 1) + 1,
    }
}

/// Reads `dd-mmm-yyyy hh:mm:ss.ss`.
fn parsed(text: &str) -> Option<f64> {
    let (date, time) = text.trim().split_once(' ').unwrap_or((text.trim(), "0:0:0"));
    let mut parts = date.split('-');
    let day: i64 = parts.next()?.parse().ok()?;
    let name = parts.next()?.to_lowercase();
    let month = MONTHS.iter().position(|month| name.len() >= 3 && month.to_lowercase().starts_with(&name))? + 1;
    let year: i64 = parts.next()?.parse().ok()?;
    if !(1..=31).contains(&day) || !(-9999..=9999).contains(&year) {
        return None;
    }
    let mut seconds = 0.0;
    for part in time.trim().split(':') {
        seconds = seconds * 60.0 + part.parse::<f64>().ok()?;
    }
    #[allow(clippy::cast_precision_loss)]
    Some(days(year, i64::try_from(month).ok()?, day) as f64 * 86_400.0 + seconds)
}

fn name(names: &[&'static str], at: i64) -> &'static str {
    usize::try_from(at).ok().and_then(|at| names.get(at)).copied().unwrap_or("")
}

pub(super) fn date(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let format = string(arguments, 0)?;
    let (now, offset, zone) = context.host.now();
    let seconds = match arguments.get(1) {
        None => now + f64::from(offset),
        Some(MacroValue::Text(text)) => parsed(text).ok_or_else(|| {
            MacroFault::new(DiagnosticNumber::TYPE_MISMATCH, "this is not a date of the form dd-mmm-yyyy hh:mm:ss")
        })?,
        Some(_) => number(arguments, 1)? + f64::from(offset),
    };
    let mut out = String::new();
    context.state.spend(format.len() / 16)?;
    write(&mut out, format, &moment(seconds), &zone);
    context.state.check_text(out.len())?;
    Ok(MacroValue::text(out))
}

fn write(out: &mut String, format: &str, at: &Moment, zone: &str) {
    let mut codes = format.chars();
    while let Some(c) = codes.next() {
        if c != '%' {
            out.push(c);
            continue;
        }
        let mut code = codes.next().unwrap_or('%');
        let bare = code == '#';
        if bare {
            code = codes.next().unwrap_or('%');
        }
        one(out, code, bare, at, zone);
    }
}

fn one(out: &mut String, code: char, bare: bool, at: &Moment, zone: &str) {
    let month = i64::try_from(at.month).unwrap_or(1);
    let half = if at.hour % 12 == 0 { 12 } else { at.hour % 12 };
    let mut digits = |value: i64, width: usize| {
        let width = if bare { 0 } else { width };
        let _ = write!(out, "{value:0width$}");
    };
    match code {
        'd' => digits(at.day, 2),
        'H' => digits(at.hour, 2),
        'I' => digits(half, 2),
        'j' => digits(at.year_day, 3),
        'm' => digits(month, 2),
        'M' => digits(at.minute, 2),
        's' => digits(at.hundredth, 2),
        'S' => digits(at.second, 2),
        'U' => digits((at.year_day - 1 + 7 - at.week_day) / 7, 2),
        'W' => digits((at.year_day - 1 + 7 - (at.week_day + 6) % 7) / 7, 2),
        'w' => digits(at.week_day, 1),
        'y' => digits(at.year.rem_euclid(100), 2),
        'Y' => digits(at.year, 4),
        'a' => out.push_str(name(&DAYS, at.week_day).get(..3).unwrap_or("")),
        'A' => out.push_str(name(&DAYS, at.week_day)),
        'b' => out.push_str(name(&MONTHS, month - 1).get(..3).unwrap_or("")),
        'B' => out.push_str(name(&MONTHS, month - 1)),
        'p' => out.push_str(if at.hour < 12 { "AM" } else { "PM" }),
        'c' if bare => write(out, "%A, %B %d, %Y, %H:%M:%S", at, zone),
        'c' => write(out, "%m/%d/%y %H:%M:%S", at, zone),
        'x' if bare => write(out, "%A, %B %d, %Y", at, zone),
        'x' => write(out, "%m/%d/%y", at, zone),
        'X' => write(out, "%H:%M:%S", at, zone),
        'z' | 'Z' => out.push_str(zone),
        '%' => out.push('%'),
        other => {
            out.push('%');
            out.push(other);
        }
    }
}

/// A time (seconds since 1970, offset of the zone in seconds) as `$DATE` has it: `dd-mmm-yyyy hh:mm:ss.ss`.
#[must_use]
pub fn stamp(now: f64, offset: i32) -> String {
    let mut out = String::new();
    write(&mut out, "%d-%b-%Y %H:%M:%S.%s", &moment(now + f64::from(offset)), "");
    out
}

pub(super) fn time_text(context: &mut FunctionContext<'_>, arguments: &[MacroValue]) -> Outcome<MacroValue> {
    let (_, offset, zone) = context.host.now();
    let mut out = String::new();
    write(&mut out, "%d-%m-%Y %H:%M:%S", &moment(number(arguments, 0)? + f64::from(offset)), &zone);
    Ok(MacroValue::text(out))
}
