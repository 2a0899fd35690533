//! Instants of the clock as text, in UTC.

/// A day, s.
const DAY: i64 = 86_400;

/// Date and time of day of an instant, ms since 1970, as `2026-11-27` and `17:39:05`.
pub(crate) fn date_and_time(ms: i64) -> (String, String) {
    let seconds = ms.div_euclid(1000);
    let (day, rest) = (seconds.div_euclid(DAY), seconds.rem_euclid(DAY));
    // Count days in eras of 400 years that begin in March, so that the leap day is the last day of a year.
    let shifted = day + 719_468;
    let (era, of_era) = (shifted.div_euclid(146_097), shifted.rem_euclid(146_097));
    let year_of_era = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let month = if month < 10 { month + 3 } else { month - 9 };
    let year = year_of_era + era * 400 + i64::from(month <= 2);
    let time = format!("{:02}:{:02}:{:02}", rest / 3600, rest / 60 % 60, rest % 60);
    (format!("{year:04}-{month:02}-{day:02}"), time)
}

/// Date and time.
pub(crate) fn instant(ms: i64) -> String {
    let (date, time) = date_and_time(ms);
    format!("{date} {time}")
}

#[cfg(test)]
mod tests {
    use super::instant;

    #[test]
    fn instants_are_those_of_the_calendar() {
        for (seconds, text) in [
            (0, "1970-01-01 00:00:00"),
            (951_827_696, "2000-02-29 12:34:56"),
            (1_709_251_199, "2024-02-29 23:59:59"),
            (1_709_251_200, "2024-03-01 00:00:00"),
            (1_798_761_599, "2026-12-31 23:59:59"),
            (4_107_542_400, "2100-03-01 00:00:00"),
        ] {
            assert_eq!(instant(seconds * 1000 + 999), text);
        }
    }
}
