//! Times of the clock as text, in UTC, for messages of the server and of the command line.

use time::{OffsetDateTime, UtcDateTime};

/// Date and time of day of an instant, ms since 1970, as `2026-11-27` and `17:39:05`. An instant outside the years
/// -9999 to 9999 becomes the first or last one of these years.
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

#[cfg(test)]
mod tests {
    use super::instant;

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
