//! `--set KEY=VALUE`: the data of the machine that a run may set, with their values.

use std::ops::RangeInclusive;
use std::str::FromStr;

use counterpoint_kernel::diag;
use counterpoint_kernel::log::info::MachineUnit;

/// The keys with their values.
const KEYS: &str = "waits=FIRST-LAST (M codes that are waiting codes, for example waits=900-999), numbers=increments (coordinates \
                    without a decimal point count least increments), units=mm or inch (unit in which programs begin), \
                    system=A, B or C (G-code system of a lathe), \
                    shared=FIRST-LAST (common variables that all channels share, for example shared=500-549), \
                    stop.AXIS=POSITION (where an axis meets a part or a stop, for example stop.B=-408) and \
                    warn.NUMBER=off or on (a warning by its number or word)";

/// Highest number of a common variable.
const HIGHEST_VARIABLE: u32 = 999_999;

/// Highest number of an M code.
const HIGHEST: u32 = 99_999_999;

/// One datum of the machine.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum MachineSetting {
    /// M codes that are waiting codes.
    Waits(RangeInclusive<u32>),
    /// Coordinates without a decimal point count least increments.
    Increments,
    /// Programs begin in inches, or in millimetres.
    Units(MachineUnit),
    /// G-code system of a lathe: A, B or C.
    System(char),
    /// Common variables that all channels share.
    Shared(u32, u32),
    /// Name of an axis, and the position at which it meets a part or a stop.
    Stop(String, f64),
    /// A warning by its number, switched off or on.
    Warning(u32, bool),
}

impl MachineSetting {
    /// The line of `[control]` for this setting, and the suffix of the machine's name.
    pub(crate) fn of_control(&self) -> Option<(String, String)> {
        match self {
            Self::Waits(_) | Self::Units(_) | Self::Shared(..) | Self::Stop(..) | Self::Warning(..) => None,
            Self::Increments => Some(("numbers = \"increments\"".to_owned(), "-inc".to_owned())),
            Self::System(letter) => {
                Some((format!("system = \"{letter}\""), format!("-{}", letter.to_ascii_lowercase())))
            }
        }
    }
}

impl FromStr for MachineSetting {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (key, value) = text.split_once('=').ok_or_else(|| format!("a value is missing: give {KEYS}"))?;
        match key.trim() {
            "waits" => {
                let (first, last) =
                    value.split_once('-').ok_or_else(|| format!("'{value}' is not a range: give {KEYS}"))?;
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
            "shared" => {
                let ends = value.split_once('-').map(|(first, last)| [first, last]);
                let numbers = ends.map(|ends| ends.map(|end| end.trim().trim_start_matches('#').parse::<u32>().ok()));
                match numbers {
                    Some([Some(first), Some(last)]) if (100..=last).contains(&first) && last <= HIGHEST_VARIABLE => {
                        Ok(Self::Shared(first, last))
                    }
                    _ => Err(format!(
                        "'{value}' is not a range of common variables: give FIRST-LAST from 100 to {HIGHEST_VARIABLE}, the smaller \
                         number first"
                    )),
                }
            }
            "numbers" => match value.trim() {
                "increments" => Ok(Self::Increments),
                other => Err(format!("'{other}' is not a way to count numbers: give {KEYS}")),
            },
            "units" => match value.trim() {
                "mm" => Ok(Self::Units(MachineUnit::Mm)),
                "inch" => Ok(Self::Units(MachineUnit::Inch)),
                other => Err(format!("'{other}' is not a unit in which programs begin: give units=mm or units=inch")),
            },
            "system" => match value.trim() {
                "A" | "a" => Ok(Self::System('A')),
                "B" | "b" => Ok(Self::System('B')),
                "C" | "c" => Ok(Self::System('C')),
                other => Err(format!("'{other}' is not a G-code system: give {KEYS}")),
            },
            other => match other.split_once('.') {
                Some(("warn", warning)) => self::warning(warning.trim(), value.trim()),
                Some(("stop", axis)) => stop(axis.trim(), value.trim()),
                _ => Err(format!("no such key '{other}': the keys are {KEYS}")),
            },
        }
    }
}

/// Reads a setting such as `stop.B=-408`.
fn stop(axis: &str, value: &str) -> Result<MachineSetting, String> {
    if axis.is_empty() || !axis.chars().all(|c| c.is_ascii_alphanumeric()) {
        return Err(format!("'{axis}' is not the name of an axis: give stop.AXIS=POSITION, for example stop.B=-408"));
    }
    match value.parse::<f64>() {
        Ok(at) if at.is_finite() => Ok(MachineSetting::Stop(axis.to_owned(), at)),
        _ => Err(format!("'{value}' is not the position of a stop: give stop.AXIS=POSITION, for example stop.B=-408")),
    }
}

/// `warn.2900680=off`, `warn.feed-above-rates=off`.
fn warning(name: &str, value: &str) -> Result<MachineSetting, String> {
    let on = match value {
        "on" => true,
        "off" => false,
        other => return Err(format!("'{other}' is not a switch of a warning: give on or off")),
    };
    let number = name.parse().ok().or_else(|| diag::number(&name.to_lowercase()));
    let Some(number) = number else {
        return Err(format!("'{name}' is not a warning: give its number or its word, such as feed-above-rates"));
    };
    match diag::severity(number) {
        Some(severity) if severity >= 8 => {
            let word = diag::name(number).unwrap_or_default();
            Err(format!("{number} ({word}) is an error: only warnings and messages can be switched"))
        }
        _ => Ok(MachineSetting::Warning(number, on)),
    }
}

/// The warnings that are switched off, or on; the last setting of a number counts.
pub(crate) fn warnings(settings: &[MachineSetting], on: bool) -> Vec<u32> {
    let mut last: std::collections::BTreeMap<u32, bool> = std::collections::BTreeMap::new();
    for setting in settings {
        if let MachineSetting::Warning(number, on) = setting {
            last.insert(*number, *on);
        }
    }
    last.into_iter().filter(|(_, own)| *own == on).map(|(number, _)| number).collect()
}

/// The waiting codes that a guess looks for, if they differ from those of the machines.
pub(crate) fn waits(settings: &[MachineSetting]) -> Option<RangeInclusive<u32>> {
    let range = |setting: &MachineSetting| match setting {
        MachineSetting::Waits(range) => Some(range.clone()),
        _ => None,
    };
    settings.iter().rev().find_map(range)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_setting_has_a_known_key_and_a_range() {
        assert_eq!("waits=900-999".parse(), Ok(MachineSetting::Waits(900..=999)));
        assert_eq!("waits=M200-M299".parse(), Ok(MachineSetting::Waits(200..=299)));
        assert_eq!("numbers=increments".parse(), Ok(MachineSetting::Increments));
        assert_eq!("units=inch".parse(), Ok(MachineSetting::Units(MachineUnit::Inch)));
        assert_eq!("units=mm".parse(), Ok(MachineSetting::Units(MachineUnit::Mm)));
        assert_eq!("system=b".parse(), Ok(MachineSetting::System('B')));
        assert_eq!("shared=500-549".parse(), Ok(MachineSetting::Shared(500, 549)));
        assert_eq!("stop.B2=-408.5".parse(), Ok(MachineSetting::Stop("B2".to_owned(), -408.5)));
        assert_eq!("shared=#100-#100".parse(), Ok(MachineSetting::Shared(100, 100)));
        assert_eq!(waits(&[MachineSetting::Waits(900..=999), MachineSetting::Increments]), Some(900..=999));
        assert_eq!("warn.2900680=off".parse(), Ok(MachineSetting::Warning(2_900_680, false)));
        assert_eq!("warn.feed-above-rates=on".parse(), Ok(MachineSetting::Warning(2_900_680, true)));
        let both =
            [MachineSetting::Warning(1, false), MachineSetting::Warning(2, false), MachineSetting::Warning(1, true)];
        assert_eq!((warnings(&both, false), warnings(&both, true)), (vec![2], vec![1]));
        for (text, with) in [
            ("waits", "a value is missing"),
            ("waits=900", "'900' is not a range"),
            ("waits=999-900", "is not a range"),
            ("waits=0-9", "is not a range"),
            ("stop.=1", "is not the name of an axis"),
            ("stop.B=near", "is not the position of a stop"),
            ("shared=33-120", "is not a range of common variables"),
            ("shared=500", "is not a range of common variables"),
            ("shared=600-500", "is not a range of common variables"),
            ("numbers=inches", "'inches' is not a way to count numbers"),
            ("units=in", "'in' is not a unit in which programs begin"),
            ("system=D", "'D' is not a G-code system"),
            ("warn.2900680=maybe", "is not a switch"),
            ("warn.feed-above=off", "'feed-above' is not a warning"),
            ("warn.2900320=off", "2900320 (unknown-code) is an error"),
            ("rapids=1", "no such key 'rapids': the keys are waits="),
        ] {
            let error = text.parse::<MachineSetting>().unwrap_err();
            assert!(error.contains(with), "{error}");
        }
    }
}
