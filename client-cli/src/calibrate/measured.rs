//! Measured times of the lines of a program: a table of seconds, a table of samples, or a document of MTConnect.
//!
//! Samples say in which line the control was at a time; a line lasts until the next one begins. A line that is executed
//! several times counts with the sum. *Invariant:* times are finite and not negative; a mistake is named with its line.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::Error;
use crate::standard_input;

/// Seconds that lines took, by number.
pub(crate) type Lines = BTreeMap<u32, f64>;

/// Names of the data item that says the line, in documents of MTConnect.
const LINES: [&str; 3] = ["Line", "LineNumber", "BlockCount"];

/// Reads a file.
///
/// # Errors
/// It cannot be read, or has no times.
pub(crate) fn read(path: &Path) -> Result<Lines, Error> {
    standard_input::refuse("--measured", path)?;
    let text = std::fs::read_to_string(path).map_err(Error::file(path))?;
    let lines = if text.trim_start().starts_with('<') { document(&text) } else { table(&text) };
    let shown = path.display();
    let lines = lines.map_err(|reason| Error::Usage(format!("'{shown}': {reason}")))?;
    if lines.values().all(|seconds| *seconds <= 0.0) {
        return Err(Error::Usage(format!("'{shown}' has no line that takes time")));
    }
    Ok(lines)
}

/// Columns `line` and `seconds`, or `line` and `time`; separated by commas, semicolons or tabs.
fn table(text: &str) -> Result<Lines, String> {
    let head = text.lines().next().unwrap_or_default();
    let delimiter = [b';', b'\t', b','].into_iter().find(|mark| head.as_bytes().contains(mark)).unwrap_or(b',');
    let mut reader = csv::ReaderBuilder::new().delimiter(delimiter).trim(csv::Trim::All).from_reader(text.as_bytes());
    let names: Vec<String> = reader
        .headers()
        .map_err(|error| error.to_string())?
        .iter()
        .map(|name| name.trim_start_matches('\u{feff}').to_ascii_lowercase())
        .collect();
    let column = |wanted: &[&str]| names.iter().position(|name| wanted.contains(&name.as_str()));
    let line = column(&["line", "block"]).ok_or("the first row must name a column `line`")?;
    let seconds = column(&["seconds", "s", "duration"]);
    let time = column(&["time", "timestamp"]);
    let mut lines = Lines::new();
    let mut samples = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| error.to_string())?;
        let at = record.position().map_or(0, csv::Position::line);
        let number = record.get(line).unwrap_or_default();
        let number: u32 = number.parse().map_err(|_| format!("row {at}: '{number}' is not a line number"))?;
        match (seconds, time) {
            (Some(column), _) => {
                let text = record.get(column).unwrap_or_default();
                *lines.entry(number).or_default() += duration(text).map_err(|reason| format!("row {at}: {reason}"))?;
            }
            (None, Some(column)) => {
                let text = record.get(column).unwrap_or_default();
                samples.push((instant(text).map_err(|reason| format!("row {at}: {reason}"))?, number));
            }
            (None, None) => return Err("the first row must name a column `seconds` or `time`".to_owned()),
        }
    }
    if seconds.is_none() { stays(&samples) } else { Ok(lines) }
}

/// Samples of the line in a document of MTConnect.
fn document(text: &str) -> Result<Lines, String> {
    let document = roxmltree::Document::parse(text).map_err(|error| format!("not a document of MTConnect: {error}"))?;
    let mut samples = Vec::new();
    for node in document.descendants().filter(|node| LINES.contains(&node.tag_name().name())) {
        let value = node.text().unwrap_or_default().trim();
        let Ok(number) = value.parse::<u32>() else { continue };
        let time = node.attribute("timestamp").ok_or_else(|| format!("{} has no timestamp", node.tag_name().name()))?;
        samples.push((instant(time)?, number));
    }
    if samples.is_empty() {
        return Err(format!("no {} with a number was found", LINES.join(", ")));
    }
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    stays(&samples)
}

/// How long each line lasted; the last one has no end.
fn stays(samples: &[(f64, u32)]) -> Result<Lines, String> {
    let mut lines = Lines::new();
    for pair in samples.windows(2) {
        let [(from, line), (to, _)] = pair else { continue };
        if to < from {
            return Err(format!("the time goes back after line {line}: sort the samples by time"));
        }
        *lines.entry(*line).or_default() += to - from;
    }
    Ok(lines)
}

fn duration(text: &str) -> Result<f64, String> {
    let seconds: Option<f64> = text.replace(',', ".").parse().ok();
    seconds.filter(|s| s.is_finite() && *s >= 0.0).ok_or_else(|| format!("'{text}' is not a duration in seconds"))
}

/// Seconds as a number, or a time as in RFC 3339.
fn instant(text: &str) -> Result<f64, String> {
    if let Some(seconds) = text.replace(',', ".").parse().ok().filter(|seconds: &f64| seconds.is_finite()) {
        return Ok(seconds);
    }
    let wrong = || format!("'{text}' is neither seconds nor a time such as 2026-01-31T12:00:00.250Z");
    let time: toml::value::Datetime = text.parse().map_err(|_| wrong())?;
    let clock = time.time.ok_or_else(wrong)?;
    let days = time.date.map_or(0, |date| days(i64::from(date.year), i64::from(date.month), i64::from(date.day)));
    let minutes = match time.offset {
        Some(toml::value::Offset::Custom { minutes }) => i64::from(minutes),
        _ => 0,
    };
    let whole = days * 86_400 + i64::from(clock.hour) * 3600 + (i64::from(clock.minute) - minutes) * 60;
    let second = f64::from(clock.second.unwrap_or(0)) + f64::from(clock.nanosecond.unwrap_or(0)) / 1e9;
    Ok(whole as f64 + second)
}

/// Days since the first of March of the year 0 of the Gregorian calendar.
fn days(year: i64, month: i64, day: i64) -> i64 {
    let year = if month > 2 { year } else { year - 1 };
    let month = (month + 9) % 12;
    year * 365 + year.div_euclid(4) - year.div_euclid(100) + year.div_euclid(400) + (month * 306 + 5) / 10 + day - 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_of_lines_are_summed() {
        let lines = table("line;seconds\n3;0,25\n4;1\n3;0.5\n").unwrap();
        assert_eq!(lines, Lines::from([(3, 0.75), (4, 1.0)]));
        assert!(table("line,seconds\n3,x\n").unwrap_err().contains("row 2: 'x' is not a duration"));
        assert!(table("a,b\n1,2\n").unwrap_err().contains("column `line`"));
    }

    #[test]
    fn a_line_lasts_until_the_next_sample() {
        let text = "time,line\n2026-02-28T23:59:59.5Z,1\n2026-03-01T00:00:01Z,2\n2026-03-01T01:00:02+01:00,1\n3.0,9\n";
        assert!(table(text).unwrap_err().contains("goes back"));
        let text = "time,line\n2026-02-28T23:59:59.5Z,1\n2026-03-01T00:00:01Z,2\n2026-03-01T01:00:02+01:00,1\n2026-03-01T00:00:02.5Z,3\n";
        assert_eq!(table(text).unwrap(), Lines::from([(1, 2.0), (2, 1.0)]));
    }

    #[test]
    fn documents_of_mtconnect() {
        let text = "<MTConnectStreams><Events><Line timestamp=\"2026-01-01T00:00:01Z\">7</Line>\
                    <Line timestamp=\"2026-01-01T00:00:00Z\">6</Line><Line timestamp=\"2026-01-01T00:00:03Z\">UNAVAILABLE</Line>\
                    <Line timestamp=\"2026-01-01T00:00:03.5Z\">8</Line></Events></MTConnectStreams>";
        assert_eq!(document(text).unwrap(), Lines::from([(6, 1.0), (7, 2.5)]));
        assert!(document("<a/>").unwrap_err().contains("was found"));
    }
}
