//! Signs in the text of a program: words and names that only some controls or machines have.
//!
//! Comments do not count. A sign is kept once, with the first line it is on.

/// The kind of machine or control that a sign indicates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A milling machine.
    Mill,
    /// A lathe, G-code system A.
    Lathe,
    /// A lathe of the Haas kind: blocks that end with a semicolon, depths in millimetres or inches.
    Haas,
    /// Words that only mills of the Haas kind have.
    HaasMill,
    /// A milling machine with five axes.
    FiveAxis,
    /// A lathe of the Mazak kind: numbers of its cycles, tools with the code of their form.
    Mazak,
    /// A lathe with live tools or a Y axis.
    Live,
    Siemens,
    Heidenhain,
    Okuma,
    /// Blocks of the lower turret of an Okuma lathe.
    Turrets,
    /// One file with `$1` and `$2` sections.
    Sections,
}

impl Kind {
    /// The control that the sign belongs to, if it is not one of Fanuc's kind.
    pub(super) fn control(self) -> Option<&'static str> {
        match self {
            Self::Mill | Self::Lathe | Self::Haas | Self::HaasMill | Self::FiveAxis => None,
            Self::Mazak | Self::Live | Self::Turrets => None,
            Self::Siemens => Some("a Siemens control"),
            Self::Heidenhain => Some("a Heidenhain control"),
            Self::Okuma => Some("an Okuma control"),
            Self::Sections => Some("a control with $1 and $2 sections (Citizen, Star, Mitsubishi)"),
        }
    }
}

/// A sign.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Sign {
    pub(super) kind: Kind,
    /// What was found.
    pub(super) text: String,
    /// Line, 0 for the name of the file.
    pub(super) line: usize,
    /// 3: almost unique to this kind; 1: other kinds have it, too.
    pub(super) weight: u32,
}

/// Number of lines ending with a semicolon that indicates a Haas.
const SEMICOLONS: usize = 3;

/// Signs of a file's name and text; of the program with that number alone, if there is one.
pub(super) fn of(name: &str, text: &str, number: Option<u32>) -> Vec<Sign> {
    let mut signs = Signs { all: Vec::new(), line: 0 };
    signs.file(name);
    let (mut semicolons, mut current) = (0, None);
    let mut upper = false;
    for (index, line) in text.replace("\r\n", "\n").split(['\n', '\r']).enumerate() {
        signs.line = index + 1;
        let line = line.trim().to_ascii_uppercase();
        signs.statement(&line);
        let code = code(&line);
        let words = words(&code);
        if let Some(("O", digits)) = words.first().map(|(letter, value)| (letter.as_str(), value)) {
            current = digits.parse::<u32>().ok();
        }
        if number.is_some() && current.is_some() && number != current {
            continue;
        }
        semicolons += usize::from(line.ends_with(';') && line.len() > 1 && !words.is_empty());
        if semicolons == SEMICOLONS {
            signs.add(Kind::Haas, "blocks that end with ;", 1);
        }
        signs.block(&words);
        // A block with nothing else: on other controls G13 mills a circle, and G14 has words or no G13 beside it.
        let alone = |number: &str| matches!(code.trim().strip_prefix('G'), Some(digits) if digits == number);
        upper |= alone("13");
        if alone("14") {
            signs.add(Kind::Turrets, "G14", 3);
        }
    }
    if let (true, Some(line)) = (upper, signs.line_of(Kind::Turrets)) {
        signs.line = line;
        signs.add(Kind::Okuma, "G13 and G14", 3);
    }
    signs.all
}

/// A program of that number is defined in the text.
pub(super) fn has_program(text: &str, number: u32) -> bool {
    let defined = |line: &str| {
        let digits = line.trim_start().strip_prefix(['O', 'o', ':'])?;
        digits.split(|c: char| !c.is_ascii_digit()).next()?.parse::<u32>().ok()
    };
    text.split(['\n', '\r']).any(|line| defined(line) == Some(number))
}

/// A line without comments in brackets and after a semicolon.
fn code(line: &str) -> String {
    let mut depth = 0_u32;
    let outside = |c: &char| {
        match c {
            '(' => depth += 1,
            ')' => {
                depth = depth.saturating_sub(1);
                return false;
            }
            _ => {}
        }
        depth == 0
    };
    line.chars().take_while(|c| *c != ';').filter(outside).collect()
}

/// Words of one letter with their values; names of several letters are left out.
fn words(code: &str) -> Vec<(String, String)> {
    let mut words: Vec<(String, String)> = Vec::new();
    let mut rest = code;
    while let Some(at) = rest.find(|c: char| c.is_ascii_alphabetic()) {
        let tail = rest.get(at..).unwrap_or_default();
        let letters = tail.len() - tail.trim_start_matches(|c: char| c.is_ascii_alphabetic() || c == '_').len();
        let (name, after) = tail.split_at(letters);
        let value: String = after
            .trim_start()
            .chars()
            .take_while(|c| c.is_ascii_digit() || matches!(c, '.' | '-' | '+' | '#' | '[' | '='))
            .collect();
        if letters == 1 && !value.is_empty() {
            words.push((name.to_owned(), value));
        }
        rest = after;
    }
    words
}

struct Signs {
    all: Vec<Sign>,
    line: usize,
}

impl Signs {
    fn add(&mut self, kind: Kind, text: impl Into<String>, weight: u32) {
        let text = text.into();
        if self.all.iter().all(|sign| (sign.kind, &sign.text) != (kind, &text)) && self.all.len() < 100 {
            self.all.push(Sign { kind, text, line: self.line, weight });
        }
    }

    fn line_of(&self, kind: Kind) -> Option<usize> {
        self.all.iter().find(|sign| sign.kind == kind).map(|sign| sign.line)
    }

    /// Adds the signs of a file name ending.
    fn file(&mut self, name: &str) {
        let Some((_, ending)) = name.rsplit_once('.') else { return };
        let kind = match ending.to_ascii_lowercase().as_str() {
            "mpf" | "spf" | "arc" => Kind::Siemens,
            "h" | "i" => Kind::Heidenhain,
            "min" | "sub" | "ssb" => Kind::Okuma,
            _ => return,
        };
        self.add(kind, format!("the file ending .{ending}"), 3);
    }

    /// Adds the signs of a whole line, comments included.
    fn statement(&mut self, line: &str) {
        let unnumbered = line.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start();
        let bare = match line.strip_prefix('N') {
            Some(rest) => rest.trim_start_matches(|c: char| c.is_ascii_digit()).trim_start(),
            None => line,
        };
        if line.starts_with("%_N_") {
            self.add(Kind::Siemens, "%_N_", 3);
        } else if unnumbered.starts_with("BEGIN PGM ") {
            self.add(Kind::Heidenhain, "BEGIN PGM", 3);
        } else if line.starts_with('%') && line.ends_with('*') && (line.contains(" G71") || line.contains(" G70")) {
            self.add(Kind::Heidenhain, "% NAME G71 *", 3);
        } else if line.starts_with('$') && line.ends_with('%') && line.len() > 2 {
            self.add(Kind::Okuma, "$NAME%", 3);
        } else if matches!(line.as_bytes(), [b'$', b'0'..=b'9']) {
            self.add(Kind::Sections, line, 3);
        } else {
            const NAMES: [(&str, Kind); 16] = [
                ("WAITM(", Kind::Siemens),
                ("WAITMC(", Kind::Siemens),
                ("WAITE(", Kind::Siemens),
                ("SETM(", Kind::Siemens),
                ("CLEARM(", Kind::Siemens),
                ("MSG(", Kind::Siemens),
                ("CYCLE", Kind::Siemens),
                ("DIAMON", Kind::Siemens),
                ("MCALL", Kind::Siemens),
                ("DEF REAL", Kind::Siemens),
                ("DEF INT", Kind::Siemens),
                ("TRANS ", Kind::Siemens),
                ("TOOL CALL", Kind::Heidenhain),
                ("CYCL DEF", Kind::Heidenhain),
                ("CALL OO", Kind::Okuma),
                ("NLAP", Kind::Okuma),
            ];
            if unnumbered.starts_with("NLAP") {
                self.add(Kind::Lathe, "NLAP", 3);
            }
            const TURNING: [&str; 7] = ["DIAMON", "DIAMOF", "DIAM90", "CYCLE93", "CYCLE95", "CYCLE97", "CYCLE99"];
            if let Some(name) = TURNING.iter().find(|name| bare.contains(**name)) {
                self.add(Kind::Siemens, *name, 3);
                self.add(Kind::Lathe, *name, 3);
            }
            if let Some(name) = ["TRAORI", "A3="].iter().find(|name| bare.contains(**name)) {
                self.add(Kind::Siemens, *name, 3);
                self.add(Kind::Mill, *name, 2);
                self.add(Kind::FiveAxis, *name, 3);
            }
            let line = unnumbered.starts_with("L ") || unnumbered.starts_with("LN ");
            if line && unnumbered.contains(" M128") {
                self.add(Kind::FiveAxis, "M128", 3);
            } else if unnumbered.starts_with("FUNCTION TCPM") {
                self.add(Kind::FiveAxis, "FUNCTION TCPM", 3);
            }
            for (name, kind) in NAMES {
                let starts = bare.starts_with(name) || unnumbered.starts_with(name);
                let cycle = name != "CYCLE" || bare.as_bytes().get(name.len()).is_some_and(u8::is_ascii_digit);
                if starts && cycle {
                    self.add(kind, name.trim_end_matches(['(', ' ']), 3);
                }
            }
        }
    }

    /// Adds the signs of the words of a block.
    fn block(&mut self, words: &[(String, String)]) {
        let value = |letter: &str| words.iter().find(|(l, _)| l == letter).map(|(_, value)| value.as_str());
        let has = |letter: &str| value(letter).is_some();
        let code = |letter: &str, numbers: &[u32]| {
            let number = |value: &str| value.parse::<u32>().ok();
            let mut all = words.iter().filter(|(l, _)| l == letter).filter_map(|(_, v)| number(v));
            all.find(|number| numbers.contains(number))
        };
        let speed = value("S").map(|s| format!(" S{s}")).unwrap_or_default();
        if let Some(g) = code("G", &[50, 92, 96]).filter(|_| has("S") && !has("X") && !has("Z")) {
            self.add(Kind::Lathe, format!("G{g}{speed}"), 3);
        } else if let Some(g) = code("G", &[96, 97]) {
            self.add(Kind::Lathe, format!("G{g}{speed}"), 2);
        }
        if code("G", &[70, 71, 72, 73, 74, 75, 76]).is_some() && has("P") && has("Q") {
            let g = code("G", &[70, 71, 72, 73, 74, 75, 76]).unwrap_or_default();
            self.add(Kind::Lathe, format!("G{g} P Q"), 3);
            // Controls of the Fanuc kind count D in least increments, without a point.
            if matches!(g, 71..=72) && value("D").is_some_and(|depth| depth.contains('.')) {
                self.add(Kind::Haas, format!("G{g} D with a point"), 2);
            }
        }
        if let Some(g) = code("G", &[12, 13]).filter(|_| has("I")) {
            self.add(Kind::HaasMill, format!("G{g} I"), 3);
        }
        if let Some(g) = code("G", &[70, 71, 72]).filter(|_| has("I") && has("L") && !has("P")) {
            self.add(Kind::HaasMill, format!("G{g} I L"), 3);
        }
        if let Some(g) = code("G", &[154, 187]).filter(|_| has("P")) {
            self.add(Kind::HaasMill, format!("G{g} P"), 3);
        }
        if code("M", &[97]).is_some() && has("P") {
            self.add(Kind::HaasMill, "M97 P", 3);
        }
        if let (Some(tool), None) = (value("T"), code("M", &[6])) {
            let digits = tool.len();
            if (3..=4).contains(&digits) && tool.bytes().all(|b| b.is_ascii_digit()) && !tool.ends_with("00") {
                self.add(Kind::Lathe, format!("T{tool}"), 2);
            } else if digits == 6 && tool.bytes().all(|b| b.is_ascii_digit()) {
                self.add(Kind::Okuma, format!("T{tool}"), 3);
                self.add(Kind::Lathe, format!("T{tool}"), 2);
            }
        }
        let cycles: Vec<u32> = (270..=276).chain(283..=285).chain(287..=290).chain([292, 294]).collect();
        if let Some(g) = code("G", &cycles) {
            self.add(Kind::Mazak, format!("G{g}"), 3);
            self.add(Kind::Lathe, format!("G{g}"), 3);
        }
        if let Some((digits, form)) = value("T").and_then(|tool| tool.split_once('.'))
            && (3..=6).contains(&digits.len())
            && [digits, form].iter().all(|part| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit()))
        {
            self.add(Kind::Mazak, format!("T{digits}.{form}"), 3);
            self.add(Kind::Lathe, format!("T{digits}.{form}"), 2);
        }
        if !has("Y") && (has("U") || has("W")) && code("G", &[10, 65, 66]).is_none() {
            self.add(Kind::Lathe, if has("U") { "U" } else { "W" }, 2);
        }
        if code("G", &[98, 99]).is_some() && !words.iter().any(|(l, v)| l == "G" && v.starts_with(['7', '8'])) {
            self.add(Kind::Lathe, "G98 or G99 without a drilling cycle", 1);
        }
        if code("G", &[18]).is_some() {
            self.add(Kind::Lathe, "G18", 1);
        }
        if let (Some(tool), Some(_)) = (value("T"), code("M", &[6])) {
            self.add(Kind::Mill, format!("T{tool} M6"), 3);
        }
        if let (Some(_), Some(offset)) = (code("G", &[43]), value("H")) {
            self.add(Kind::Mill, format!("G43 H{offset}"), 3);
        }
        if words.iter().any(|(letter, value)| letter == "G" && matches!(value.as_str(), "43.4" | "43.5")) {
            self.add(Kind::Mill, "G43.4", 2);
            self.add(Kind::FiveAxis, "G43.4", 3);
        }
        if let (Some(_), Some(offset)) = (code("G", &[15]), value("H")) {
            self.add(Kind::Okuma, format!("G15 H{offset}"), 3);
            self.add(Kind::Mill, format!("G15 H{offset}"), 2);
        }
        if code("G", &[49]).is_some() {
            self.add(Kind::Mill, "G49", 2);
        }
        if has("Y") && code("G", &[65, 66]).is_none() {
            self.add(Kind::Mill, "Y", 2);
            self.add(Kind::Live, "Y", 1);
        }
        let others = words.iter().filter(|(l, v)| l == "G" && v != "90").count();
        if code("G", &[90]).is_some() && others > 0 {
            self.add(Kind::Mill, "G90 beside another G code", 2);
        }
        for (letter, number, kind) in [
            ("G", 17, Kind::Mill),
            ("G", 91, Kind::Mill),
            ("G", 112, Kind::Live),
            ("M", 154, Kind::Live),
            ("M", 155, Kind::Live),
            ("M", 133, Kind::Live),
        ] {
            if code(letter, &[number]).is_some() {
                self.add(kind, format!("{letter}{number}"), 1);
            }
        }
    }
}
