//! Instants as text, in UTC, for messages of the server and the command line.

use time::{OffsetDateTime, UtcDateTime};

/// Date and time of day of an instant, ms since 1970, as `2026-11-27` and `17:39:05`. An instant outside the years
/// -9999 to 9999 becomes the first or last instant of that range.
#[must_use]
pub fn date_and_time(ms: i64) -> (String, String) {
    let (earliest, latest) = (UtcDateTime::MIN.unix_timestamp(), UtcDateTime::MAX.unix_timestamp());
    let seconds = ms.div_euclid(1000).clamp(earliest, latest);
    let at = OffsetDateTime::from_unix_timestamp(seconds).unwrap_or(OffsetDateTime::UNIX_EPOCH);
    let (hour, minute, second) = at.to_hms();
    let date = format!("{:04}-{:02}-{:02}", at.year(), u8::from(at.month()), at.day());
    (date, format!("{hour:02}:{minute:02}:{second:02}"))
}

/// Date and time of an instant, ms since 1970, as `2026-11-27 17:39:05`.
#[must_use]
pub fn instant(ms: i64) -> String {
    let (date, time) = date_and_time(ms);
    format!("{date} {time}")
}

/// The instant of an ISO 8601 date, ms since 1970: `2026-11-27`, `2026-11-27T17:39`, `2026-11-27 17:39:05Z` or
/// `2026-11-27T18:39:05+01:00`. A date without an offset is UTC.
#[must_use]
pub fn from_iso(text: &str) -> Option<i64> {
    const DATE: usize = "2026-11-27".len();
    let (date, rest) = text.split_at_checked(DATE)?;
    let [year, month, day] = numbers(date, '-', [4, 2, 2])?;
    let month = time::Month::try_from(u8::try_from(month).ok()?).ok()?;
    let date = time::Date::from_calendar_date(year, month, u8::try_from(day).ok()?).ok()?;
    let (clock, offset_s) = match rest.strip_prefix(['T', 't', ' ']) {
        None if rest.is_empty() => (time::Time::MIDNIGHT, 0),
        None => return None,
        Some(rest) => {
            let (clock, offset) = rest.split_at(rest.find(['Z', 'z', '+', '-']).unwrap_or(rest.len()));
            (clock_of(clock)?, offset_of(offset)?)
        }
    };
    let seconds = date.with_time(clock).assume_utc().unix_timestamp() - i64::from(offset_s);
    seconds.checked_mul(1000)
}

/// `17:39` or `17:39:05`.
fn clock_of(text: &str) -> Option<time::Time> {
    let [hour, minute, second] = match numbers(text, ':', [2, 2]) {
        Some([hour, minute]) => [hour, minute, 0],
        None => numbers(text, ':', [2, 2, 2])?,
    };
    time::Time::from_hms(u8::try_from(hour).ok()?, u8::try_from(minute).ok()?, u8::try_from(second).ok()?).ok()
}

/// Seconds of an offset from UTC: empty, `Z` or `+01:00`.
fn offset_of(text: &str) -> Option<i32> {
    let sign = match text.get(..1) {
        None | Some("Z" | "z") => return (text.len() <= 1).then_some(0),
        Some("-") => -1,
        Some(_) => 1,
    };
    let [hours, minutes] = numbers(text.get(1..)?, ':', [2, 2])?;
    (hours < 24 && minutes < 60).then_some(sign * (hours * 3600 + minutes * 60))
}

/// Numbers with these digit counts, separated by a character.
fn numbers<const N: usize>(text: &str, separator: char, digits: [usize; N]) -> Option<[i32; N]> {
    let mut parts = text.split(separator);
    let mut numbers = [0; N];
    for (number, digits) in numbers.iter_mut().zip(digits) {
        let part = parts.next().filter(|part| part.len() == digits && part.bytes().all(|byte| byte.is_ascii_digit()));
        *number = part?.parse().ok()?;
    }
    parts.next().is_none().then_some(numbers)
}

#[cfg(test)]
mod tests {
    use super::{from_iso, instant};

    #[test]
    fn dates_are_read() {
        for (text, seconds) in [
            ("2027-01-01", 1_798_761_600),
            ("2027-01-01T00:00:30Z", 1_798_761_630),
            ("2027-01-01 00:01", 1_798_761_660),
            ("2027-01-01T01:00:00+01:00", 1_798_761_600),
            ("2026-12-31T22:30:00-01:30", 1_798_761_600),
            ("2024-02-29T23:59:59", 1_709_251_199),
        ] {
            assert_eq!(from_iso(text), Some(seconds * 1000), "{text}");
        }
        for wrong in ["", "2027-13-01", "2027-01-01T", "2027-1-1", "2027-01-01T25:00", "2025-02-29", "2027-01-01x"] {
            assert_eq!(from_iso(wrong), None, "{wrong}");
        }
        for wrong in ["2027-01-01T00:00:00ZZ", "2027-01-01T00:00+1", "2027-01-01T00:00:00:00", "ü027-01-01"] {
            assert_eq!(from_iso(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn instants_are_those_of_the_calendar() {
        for (seconds, text) in [
            (-1, "1969-12-31 23:59:59"),
            (0, "1970-01-01 00:00:00"),
            (1000, "1970-01-01 00:16:40"),
            (951_827_696, "2000-02-29 12:34:56"),
            (1_709_251_199, "2024-02-29 23:59:59"),
            (1_709_251_200, "2024-03-01 00:00:00"),
            (1_798_761_599, "2026-12-31 23:59:59"),
            (4_107_542_400, "2100-03-01 00:00:00"),
        ] {
            assert_eq!(instant(seconds * 1000 + 999), text);
        }
        assert_eq!(instant(i64::MAX), "9999-12-31 23:59:59");
        assert_eq!(instant(i64::MIN), "-9999-01-01 00:00:00");
    }
}
