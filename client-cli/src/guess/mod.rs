//! Guesses the shipped machine of a job without `--machine` from the text of its programs.
//!
//! Every sign has a weight and a place, and the answer names the signs, so that the user can judge the guess.
//! *Invariant:* no machine is chosen by default. Programs without signs, with as many signs of milling as of turning, or
//! for a control that no shipped machine has are refused.

mod signs;

use std::fs;
use std::io::Read as _;
use std::ops::RangeInclusive;

use crate::error::Error;
use crate::pack::{self, Inside};
use signs::{Kind, Sign};

/// Bytes of a program that are looked at.
const LOOKED_AT: u64 = 4 << 20;
/// Weight from which signs are enough.
const ENOUGH: u32 = 2;
/// Signs named in the answer.
const NAMED: usize = 3;

/// A machine and why.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Guess {
    /// Name of a shipped machine.
    pub(crate) machine: &'static str,
    /// The signs with their places.
    pub(crate) why: String,
}

/// The machine for programs as they stand on the command line.
///
/// `waits` are the M codes that are waiting codes.
pub(crate) fn machine(programs: &[String], waits: &RangeInclusive<u32>) -> Result<Guess, Error> {
    let mut signs = Vec::new();
    for program in programs {
        let (path, inside) = pack::program(program)?;
        let number = match inside {
            Some(Inside::Number(number)) => Some(number),
            Some(Inside::Name(_)) | None => None,
        };
        let mut bytes = Vec::new();
        let file = fs::File::open(&path).map_err(Error::file(&path))?;
        file.take(LOOKED_AT).read_to_end(&mut bytes).map_err(Error::file(&path))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let text = decode(&bytes);
        if let Some(number) = number.filter(|number| !signs::has_program(&text, *number)) {
            return Err(Error::Usage(format!("'{}' has no program O{number}", path.display())));
        }
        signs.extend(signs::of(&name, &text, number).into_iter().map(|sign| (name.clone(), sign)));
    }
    let evidence = Evidence { signs, several: programs.len() > 1 };
    evidence.judge(pack::channels(programs, waits), programs)
}

/// Text of a program: UTF-8, UTF-16 with a byte order mark, or bytes of which only ASCII matters.
fn decode(bytes: &[u8]) -> String {
    let wide = |unit: fn([u8; 2]) -> u16| {
        let pairs = bytes.chunks_exact(2).skip(1).filter_map(|pair| pair.first_chunk().copied());
        let units: Vec<u16> = pairs.map(unit).collect();
        String::from_utf16_lossy(&units)
    };
    match bytes {
        [0xff, 0xfe, ..] => wide(u16::from_le_bytes),
        [0xfe, 0xff, ..] => wide(u16::from_be_bytes),
        [0xef, 0xbb, 0xbf, rest @ ..] => String::from_utf8_lossy(rest).into_owned(),
        _ => String::from_utf8_lossy(bytes).into_owned(),
    }
}

/// A shipped machine, and the kinds whose signs chose it among those of its control.
type Chosen = (&'static str, &'static [Kind]);

/// Signs, each with the name of its file.
struct Evidence {
    signs: Vec<(String, Sign)>,
    several: bool,
}

impl Evidence {
    fn weight(&self, kind: Kind) -> u32 {
        self.of(kind).map(|(_, sign)| sign.weight).sum()
    }

    fn of(&self, kind: Kind) -> impl Iterator<Item = &(String, Sign)> {
        // A sign that several programs show counts once.
        let first = move |at: usize, sign: &Sign| {
            self.signs.iter().take(at).all(|(_, o)| (o.kind, &o.text) != (sign.kind, &sign.text))
        };
        self.signs
            .iter()
            .enumerate()
            .filter(move |(at, (_, sign))| sign.kind == kind && first(*at, sign))
            .map(|(_, s)| s)
    }

    /// The heaviest signs of a kind with their places.
    fn named(&self, kind: Kind) -> String {
        let mut signs: Vec<_> = self.of(kind).collect();
        signs.sort_by_key(|(_, sign)| std::cmp::Reverse(sign.weight));
        let one = |(file, sign): &(String, Sign)| {
            let of = if self.several { format!("{file} ") } else { String::new() };
            match sign.line {
                0 => format!("{} ({file})", sign.text),
                line => format!("{} ({of}line {line})", sign.text),
            }
        };
        signs.into_iter().take(NAMED).map(one).collect::<Vec<_>>().join(", ")
    }

    /// The heaviest signs of several kinds, each sign once.
    fn named_all(&self, kinds: &[Kind]) -> String {
        let mut all: Vec<String> = Vec::new();
        for kind in kinds {
            for sign in self.named(*kind).split(", ").filter(|sign| !sign.is_empty()) {
                if all.iter().all(|known| known != sign) {
                    all.push(sign.to_owned());
                }
            }
        }
        all.join(", ")
    }

    /// A program for a control other than Fanuc's.
    fn other_control(&self, kind: Kind, channels: usize) -> Result<Guess, Error> {
        let machine = match kind {
            Kind::Siemens => self.siemens(channels),
            Kind::Heidenhain => self.heidenhain(channels),
            Kind::Okuma => self.okuma(channels),
            _ => self.sections(channels),
        };
        match machine {
            Ok((machine, shows)) => Ok(Guess { machine, why: self.named_all(&[&[kind][..], shows].concat()) }),
            Err(why) => Err(Error::Usage(format!(
                "no machine given, and the program is for {}, judging by {}: {why}; {ASK}",
                kind.control().unwrap_or_default(),
                self.named(kind)
            ))),
        }
    }

    fn siemens(&self, channels: usize) -> Result<Chosen, &'static str> {
        let (mill, lathe) = (self.weight(Kind::Mill), self.weight(Kind::Lathe));
        match channels {
            2 if mill > lathe => Err("no such milling machine with two channels is shipped"),
            2 => Ok(("siemens-2channel", &[Kind::Lathe])),
            _ if mill == lathe => {
                Err("siemens-mill and siemens-lathe are shipped, and nothing shows which one it is for")
            }
            1 if lathe > mill => Ok(("siemens-lathe", &[Kind::Lathe])),
            1 if self.weight(Kind::FiveAxis) > 0 => Ok(("siemens-mill-5axis", &[Kind::FiveAxis, Kind::Mill])),
            1 => Ok(("siemens-mill", &[Kind::Mill])),
            _ => Err(TOO_MANY),
        }
    }

    fn heidenhain(&self, channels: usize) -> Result<Chosen, &'static str> {
        let iso = self.of(Kind::Heidenhain).any(|(_, sign)| sign.text.ends_with('*'));
        match channels {
            _ if iso => Err("the shipped machine has no ISO words; describe yours (docs/tutorial-control.md)"),
            1 if self.weight(Kind::FiveAxis) > 0 => Ok(("heidenhain-mill-5axis", &[Kind::FiveAxis])),
            1 => Ok(("heidenhain-mill", &[])),
            _ => Err(TOO_MANY),
        }
    }

    /// One file is one program for both turrets, whatever O-programs it has.
    fn okuma(&self, channels: usize) -> Result<Chosen, &'static str> {
        let (mill, lathe) = (self.weight(Kind::Mill), self.weight(Kind::Lathe));
        match if self.several { channels } else { 1 } {
            1 if self.weight(Kind::Turrets) > 0 => Ok(("okuma-2turret", &[Kind::Turrets, Kind::Lathe])),
            1 if lathe > mill => Ok(("okuma-lathe", &[Kind::Lathe])),
            1 if mill > lathe => Ok(("okuma-mill", &[Kind::Mill])),
            1 => Err("okuma-mill and okuma-lathe are shipped, and nothing shows which one it is for"),
            2 if mill > lathe => Err("no such milling machine with two channels is shipped"),
            2 => Ok(("okuma-2turret", &[Kind::Turrets, Kind::Lathe])),
            _ => Err(TOO_MANY),
        }
    }

    /// One file has the sections of all systems.
    fn sections(&self, channels: usize) -> Result<Chosen, &'static str> {
        let beyond = |text: &str| matches!(text.as_bytes(), [b'$', b'4'..=b'9']);
        if self.several && channels > 3 || self.of(Kind::Sections).any(|(_, sign)| beyond(&sign.text)) {
            return Err("citizen-3system has three systems");
        }
        Ok(("citizen-3system", &[]))
    }

    fn judge(&self, channels: usize, programs: &[String]) -> Result<Guess, Error> {
        let control = [Kind::Siemens, Kind::Heidenhain, Kind::Okuma, Kind::Sections]
            .into_iter()
            .find(|kind| self.weight(*kind) > 0);
        if let Some(kind) = control {
            return self.other_control(kind, channels);
        }
        let (mill, lathe) = (self.weight(Kind::Mill), self.weight(Kind::Lathe));
        // On a milling machine M198 and the like are not waiting codes, and further O programs of a file are subprograms.
        let channels = if !self.several && mill > lathe { 1 } else { channels };
        let waits = if self.several {
            format!("{channels} programs")
        } else {
            format!("{channels} programs with waiting codes in one file")
        };
        match channels {
            1 if mill.max(lathe) < ENOUGH => Err(Error::Usage(format!(
                "no machine given, and nothing in {} shows which machine it is for: {ASK}",
                programs.join(" ")
            ))),
            1 if mill == lathe => Err(Error::Usage(format!(
                "no machine given, and the program shows milling ({}) as well as turning ({}): {ASK}",
                self.named(Kind::Mill),
                self.named(Kind::Lathe)
            ))),
            1 if mill > lathe && self.weight(Kind::HaasMill) > 0 => {
                let why = format!("{}, {}", self.named(Kind::Mill), self.named(Kind::HaasMill));
                Ok(Guess { machine: "haas-mill", why })
            }
            1 if mill > lathe && self.weight(Kind::FiveAxis) > 0 => {
                let why = format!("{}, {}", self.named(Kind::FiveAxis), self.named(Kind::Mill));
                Ok(Guess { machine: "fanuc-mill-5axis", why })
            }
            1 if mill > lathe => Ok(Guess { machine: "fanuc-mill", why: self.named(Kind::Mill) }),
            1 if self.weight(Kind::Mazak) > 0 => {
                let why = self.named_all(&[Kind::Mazak, Kind::Lathe]);
                Ok(Guess { machine: "mazak-eia-lathe", why })
            }
            1 if self.weight(Kind::Live) > 0 => {
                let why = format!("{}, {}", self.named(Kind::Lathe), self.named(Kind::Live));
                Ok(Guess { machine: "haas-mill-turn", why })
            }
            1 if self.weight(Kind::Haas) > 0 => {
                let why = format!("{}, {}", self.named(Kind::Lathe), self.named(Kind::Haas));
                Ok(Guess { machine: "haas-lathe", why })
            }
            1 => Ok(Guess { machine: "fanuc-lathe", why: self.named(Kind::Lathe) }),
            2 | 3 if mill > lathe => Err(Error::Usage(format!(
                "no machine given, and {waits} show milling ({}): no milling machine with {channels} channels is \
                 shipped; run the programs one by one, or name your own machine with --machine DIR",
                self.named(Kind::Mill)
            ))),
            2 | 3 => {
                let machine = if channels == 2 { "fanuc-2path-lathe" } else { "fanuc-3path-lathe" };
                let shown = self.named(Kind::Lathe);
                let why = if shown.is_empty() { waits } else { format!("{waits}, {shown}") };
                Ok(Guess { machine, why })
            }
            n => Err(Error::Usage(format!(
                "no machine given, and no shipped machine has {n} channels: name your own machine with --machine DIR"
            ))),
        }
    }
}

/// What to do when nothing can be guessed.
const ASK: &str = "use --machine NAME (`counterpoint machine list` shows the names) or --machine DIR";

const TOO_MANY: &str = "no such machine with as many channels is shipped";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::WAITS;

    fn guess(files: &[(&str, &str)]) -> Result<Guess, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = |(name, text): &(&str, &str)| {
            let path = folder.path().join(name);
            fs::write(&path, text).unwrap();
            path.display().to_string()
        };
        let programs: Vec<_> = files.iter().map(path).collect();
        machine(&programs, &WAITS).map_err(|error| error.to_string())
    }

    #[test]
    fn programs_show_what_they_are_for() {
        let of = |text: &str| guess(&[("p.nc", text)]).map(|g| g.machine);
        for (text, machine) in [
            ("%\nO1\nT1 M6\nG90 G54 G0 X1. Y2.\nG43 H1 Z5.\nM30\n", "fanuc-mill"),
            ("G90 G0 X10. Y5.\nG1 X20. F100.\nM30\n", "fanuc-mill"),
            ("G90 G94 G1 X2. F100\nM30\n", "fanuc-mill"),
            ("O1\nG50 S2500\nG96 S200 M3\nT0101\nG0 X52. Z2.\nM30\n", "fanuc-lathe"),
            ("O1\nT0101\nG0 X52. Z2.\nG1 W-20. F0.2\nU4.\nM30\n", "fanuc-lathe"),
            ("O1\nG71 U2. R1.\nG71 P10 Q20 U0.5 W0.1 F0.2\nM30\n", "fanuc-lathe"),
            ("G92 S2000\nG96 S180\n(T1 M6 G43 H1 Y5.)\nM30\n", "fanuc-lathe"),
            ("O1\nT101\nG71 P10 Q20 U0.5 W0.1 D2.5 F0.2\nM30\n", "haas-lathe"),
            ("T101;\nG97 S1000 M3;\nG0 X50. Z2.;\nM30;\n", "haas-lathe"),
            ("T101;\nG97 S1000 M3;\nG0 X50. Y0;\nM155;\nM30;\n", "haas-mill-turn"),
            ("%_N_PART_MPF\nG17 G90 T1 M6\nG0 X1 Y2\n", "siemens-mill"),
            ("O1\nT001.01\nG97 S500 M3\nG0 X50. Z2.\n", "mazak-eia-lathe"),
            ("O1\nT0101\nG0 X50. Z2.\nG290 X46. Z-20. F0.2\n", "mazak-eia-lathe"),
            ("N10 TRAORI(1)\nN20 G1 X1 A=-20 C10\n", "siemens-mill-5axis"),
            ("%_N_PART_MPF\nG1 X1 A3=0 B3=1 C3=0\n", "siemens-mill-5axis"),
            ("0 BEGIN PGM PART MM\n1 L X+10 A+20 R0 FMAX M128\n", "heidenhain-mill-5axis"),
            ("0 BEGIN PGM PART MM\n1 FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS\n", "heidenhain-mill-5axis"),
            ("O1\nT1 M6\nG43.4 H1 Z50.\nG1 X1. A-20. F100.\n", "fanuc-mill-5axis"),
            ("DIAMON\nG96 S200 LIMS=3000 M4\nG0 X40 Z2\n", "siemens-lathe"),
            ("0 BEGIN PGM PART MM\n1 L X+10 R0 FMAX\n", "heidenhain-mill"),
            ("O1\nT0101\nM130\nM99\nO2\nT0202\nM130\nM99\n", "fanuc-2path-lathe"),
        ] {
            assert_eq!(of(text), Ok(machine), "{text}");
        }
        let two = guess(&[("a.nc", "O1\nM101\nM30\n"), ("b.nc", "O2\nT0202\nM101\nM30\n")]).unwrap();
        assert_eq!((two.machine, two.why.as_str()), ("fanuc-2path-lathe", "2 programs, T0202 (b.nc line 2)"));
        let archive = guess(&[("a.arc", "%_N_A_1_MPF\nDIAMON\nM30\n%_N_A_2_MPF\nM30\n%_N_B_SPF\nM17\n")]).unwrap();
        assert_eq!(archive.machine, "siemens-2channel");
        let marks = guess(&[("a.nc", "WAITM(1,1,2)\nM30\n"), ("b.nc", "WAITM(1,1,2)\nG96 S200\n")]).unwrap();
        assert_eq!(
            (marks.machine, marks.why.as_str()),
            ("siemens-2channel", "WAITM (a.nc line 1), G96 S200 (b.nc line 2)")
        );
        let one = guess(&[("p.nc", "O1\r\nT1 M6\r\nN10 G43 H1\r\nM30\r\n")]).unwrap();
        assert_eq!(one.why, "T1 M6 (line 2), G43 H1 (line 3)");
    }

    #[test]
    fn controls_of_one_file_with_all_channels_are_known_by_their_heads() {
        let of = |name: &str, text: &str| guess(&[(name, text)]).map(|g| (g.machine, g.why));
        for (name, text, machine, why) in [
            (
                "p.MIN",
                "G50 S2500\nT010101\n",
                "okuma-lathe",
                "the file ending .MIN (p.MIN), T010101 (line 2), G50 S2500 (line 1)",
            ),
            ("p.nc", "$PART.MIN%\nG96 S180\n", "okuma-lathe", "$NAME% (line 1), G96 S180 (line 2)"),
            ("p.nc", "NLAP1 G81\n", "okuma-lathe", "NLAP (line 1)"),
            ("p.nc", "G15 H1\nT1 M6\n", "okuma-mill", "G15 H1 (line 1), T1 M6 (line 2)"),
            (
                "p.min",
                "G14\nG96 S150\n",
                "okuma-2turret",
                "the file ending .min (p.min), G14 (line 1), G96 S150 (line 2)",
            ),
            ("p.nc", "O1\nG13\nM110\nG14 (B)\nO2\n", "okuma-2turret", "G13 and G14 (line 4), G14 (line 4)"),
            ("p.nc", "O1\n$1\nG50 S2500\nM30\n$2\nM30\n", "citizen-3system", "$1 (line 2), $2 (line 5)"),
            ("p.nc", "$0\n#814=10\n$1\nT1 M6\n", "citizen-3system", "$0 (line 1), $1 (line 3)"),
            // Pocket milling of a Haas, its second spindle and the end of polar interpolation are no turrets.
            ("p.nc", "G13 I5. D1 F100.\nG14\nT1 M6\n", "haas-mill", "T1 M6 (line 3), G13 I (line 1)"),
            ("p.nc", "T1 M6\nG154 P3 X0 Y0\n", "haas-mill", "T1 M6 (line 1), Y (line 2), G154 P (line 2)"),
            ("p.nc", "T1 M6\nM97 P100 L2\n", "haas-mill", "T1 M6 (line 1), M97 P (line 2)"),
            ("p.nc", "T1 M6\nG70 I20. J0 L6\n", "haas-mill", "T1 M6 (line 1), G70 I L (line 2)"),
            ("p.nc", "G13.1\nG50 S900\n", "fanuc-lathe", "G50 S900 (line 2)"),
        ] {
            assert_eq!(of(name, text), Ok((machine, why.to_owned())), "{text}");
        }
        let both = guess(&[("a.min", "G13\nG50 S900\n"), ("b.min", "G14\nG97 S500\n")]).unwrap();
        assert_eq!(both.machine, "okuma-2turret");
    }

    #[test]
    fn what_cannot_be_guessed_is_refused() {
        let refused = |files: &[(&str, &str)], with: &str| {
            let error = guess(files).unwrap_err();
            assert!(error.contains(with), "{error}");
            assert!(error.contains("--machine"), "{error}");
        };
        refused(&[("p.nc", "O1\nG0 X1.\nM30\n")], "nothing in ");
        refused(&[("p.nc", "T1 M6\nG43 H1\nG50 S1000\nG96 S100\n")], "as well as turning (G50 S1000 (line 3)");
        refused(&[("p.nc", "%_N_PART_MPF\nG0 X1\n")], "the program is for a Siemens control, judging by %_N_ (line 1)");
        refused(&[("p.nc", "%PART G71 *\nN10 G00 X1*\n")], "has no ISO words");
        refused(&[("a.mpf", "G96 S200\n"), ("b.mpf", "M30\n"), ("c.mpf", "M30\n")], "as many channels");
        refused(&[("a.mpf", "T1 M6\nWAITM(1,1,2)\n"), ("b.mpf", "M30\n")], "milling machine with two channels");
        refused(&[("p.MIN", "G0 X50\n")], "okuma-mill and okuma-lathe are shipped");
        refused(&[("a.MIN", "T1 M6\n"), ("b.MIN", "G0 Y2\n")], "milling machine with two channels");
        refused(&[("a.MIN", "G13\n"), ("b.MIN", "G14\n"), ("c.MIN", "G50 S99\n")], "as many channels");
        refused(&[("p.nc", "$1\nM30\n$2\nM30\n$4\nM30\n")], "judging by $1 (line 1), $2 (line 3), $4 (line 5)");
        refused(&[("a.nc", "T1 M6\nG43 H1\n"), ("b.nc", "T2 M6\n")], "2 programs show milling");
        refused(&[("a", "M30"), ("b", "M30"), ("c", "M30"), ("d", "M30")], "4 channels");
    }

    #[test]
    fn waiting_codes_are_those_of_the_settings() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("both.nc");
        fs::write(&path, "O1\nT0101\nM901\nM99\nO2\nT0202\nM901\nM99\n").unwrap();
        let of = |waits| machine(&[path.display().to_string()], &waits).unwrap().machine;
        assert_eq!((of(900..=999), of(WAITS)), ("fanuc-2path-lathe", "fanuc-lathe"));
    }

    #[test]
    fn a_program_of_a_file_is_judged_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("both.nc");
        fs::write(&path, "O1\nT1 M6\nG43 H1\nM30\nO2\nG50 S2000\nT0101\nM30\n").unwrap();
        let of = |number: &str| machine(&[format!("{}#{number}", path.display())], &WAITS).unwrap().machine;
        assert_eq!((of("1"), of("O2")), ("fanuc-mill", "fanuc-lathe"));
        let error = machine(&[format!("{}#3", path.display())], &WAITS).unwrap_err().to_string();
        assert!(error.ends_with("both.nc' has no program O3"), "{error}");
    }

    #[test]
    fn other_encodings_are_read() {
        let text: Vec<u8> = std::iter::once(0xfeff_u16)
            .chain("T1 M6\r\nG43 H1\r\n".encode_utf16())
            .flat_map(u16::to_le_bytes)
            .collect();
        assert_eq!(decode(&text), "T1 M6\r\nG43 H1\r\n");
        assert_eq!(decode(b"\xef\xbb\xbfG0"), "G0");
        assert_eq!(decode(b"(\xe4)\nG0"), "(\u{fffd})\nG0");
    }
}
