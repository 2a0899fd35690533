//! `--set KEY=VALUE`: which data of the machine a run may set, and to what.

use std::ops::RangeInclusive;
use std::str::FromStr;

/// The keys with their values.
const KEYS: &str = "waits=FIRST-LAST (M codes that are waiting codes, for example waits=900-999), numbers=increments (coordinates \
                    without a decimal point count least increments) and system=A, B or C (system of G codes of a lathe)";

/// Highest number of an M code.
const HIGHEST: u32 = 99_999_999;

/// One datum of the machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Setting {
    /// M codes that are waiting codes.
    Waits(RangeInclusive<u32>),
    /// Coordinates without a decimal point count least increments.
    Increments,
    /// System of G codes of a lathe: A, B or C.
    System(char),
}

impl Setting {
    /// The line of `[control]` that says it, and what the name of a machine with it ends with.
    pub(crate) fn of_control(&self) -> Option<(String, String)> {
        match self {
            Self::Waits(_) => None,
            Self::Increments => Some(("numbers = \"increments\"".to_owned(), "-inc".to_owned())),
            Self::System(letter) => {
                Some((format!("system = \"{letter}\""), format!("-{}", letter.to_ascii_lowercase())))
            }
        }
    }
}

impl FromStr for Setting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) = text.split_once('=').ok_or_else(|| format!("a value is missing: give {KEYS}"))?;
        match key.trim() {
            "waits" => {
                let (first, last) = value.split_once('-').ok_or_else(|| format!("no range: give {KEYS}"))?;
                let number = |text: &str| text.trim().trim_start_matches(['M', 'm']).parse::<u32>().ok();
                match (number(first), number(last)) {
                    (Some(first), Some(last)) if 1 <= first && first < last && last <= HIGHEST => {
                        Ok(Self::Waits(first..=last))
                    }
                    _ => Err(format!(
                        "'{value}' is not a range of M codes: the first must be at least 1 and below the last"
                    )),
                }
            }
            "numbers" => match value.trim() {
                "increments" => Ok(Self::Increments),
                other => Err(format!("'{other}' is not a way to count numbers: give {KEYS}")),
            },
            "system" => match value.trim() {
                "A" | "a" => Ok(Self::System('A')),
                "B" | "b" => Ok(Self::System('B')),
                "C" | "c" => Ok(Self::System('C')),
                other => Err(format!("'{other}' is not a system of G codes: give {KEYS}")),
            },
            other => Err(format!("no such key '{other}': the keys are {KEYS}")),
        }
    }
}

/// The waiting codes that a guess looks for, if they are others than those of the machines.
pub(crate) fn waits(settings: &[Setting]) -> Option<RangeInclusive<u32>> {
    let range = |setting: &Setting| match setting {
        Setting::Waits(range) => Some(range.clone()),
        Setting::Increments | Setting::System(_) => None,
    };
    settings.iter().rev().find_map(range)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setting_has_a_known_key_and_a_range() {
        assert_eq!("waits=900-999".parse(), Ok(Setting::Waits(900..=999)));
        assert_eq!("waits=M200-M299".parse(), Ok(Setting::Waits(200..=299)));
        assert_eq!("numbers=increments".parse(), Ok(Setting::Increments));
        assert_eq!("system=b".parse(), Ok(Setting::System('B')));
        assert_eq!(waits(&[Setting::Waits(900..=999), Setting::Increments]), Some(900..=999));
        for (text, with) in [
            ("waits", "a value is missing"),
            ("waits=900", "no range"),
            ("waits=999-900", "is not a range"),
            ("waits=0-9", "is not a range"),
            ("numbers=inches", "'inches' is not a way to count numbers"),
            ("system=D", "'D' is not a system of G codes"),
            ("rapids=1", "no such key 'rapids': the keys are waits="),
        ] {
            let error = text.parse::<Setting>().unwrap_err();
            assert!(error.contains(with), "{error}");
        }
    }
}
