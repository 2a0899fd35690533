//! Terms that are in no other table: operators, format codes, elements of regular expressions, words inside statements,
//! arguments of macros.
//!
//! *Invariant:* every operator of the lexer and every code of the format parser has a row; tests compare them.

use std::fmt::Write as _;

use counterpoint_lang::format::{
    ColumnStyle, FormatCode, FormatPiece, FormatRegister, Numeric, PointStyle, StringFormat, ZeroStyle, wildcard_text,
};
use counterpoint_lang::ident::{self, Reserved};

/// Spellings, divided by blanks, and their meaning.
type Row = (&'static str, &'static str);

const OPERATORS: &[Row] = &[
    ("**", "Power of two numbers; binds strongest and to the right: 2**3**2 is 2**9."),
    ("*", "Product of two numbers."),
    ("/", "Quotient of two numbers; division by zero is an error."),
    ("+", "Sum of two numbers, or two texts joined; before a number it changes nothing."),
    ("-", "Difference of two numbers, or the negative of one; -2**2 is -4."),
    ("//", "Joins two texts; binds weaker than + and stronger than comparisons."),
    (
        ".EQ. ==",
        "True if both sides are equal. Both have one type; texts compare with case, the shorter one filled up with blanks; $NULL may be compared with anything and equals only itself.",
    ),
    (".NE. !=", "True if both sides, of one type, differ."),
    (".GT. >", "True if the left side is greater: numbers, texts by character code, keywords by code."),
    (".LT. <", "True if the left side is less: numbers, texts by character code, keywords by code."),
    (".GE. >=", "True if the left side is greater or equal."),
    (".LE. <=", "True if the left side is less or equal."),
    (".NOT. !", "True if the truth value after it is false; binds weaker than comparisons, stronger than .AND."),
    (".AND. &&", "True if both truth values are; the right one is not evaluated if the left one is false."),
    (".OR. ||", "True if one of the truth values is; the right one is not evaluated if the left one is true."),
    (".XOR. ^^", "True if exactly one of the truth values is; binds weakest. In a format ^^ prints one ^."),
    ("=", "Gives a variable, or an element of an array or sequence, a value."),
    ("+=", "Adds a number, or appends to a text or sequence."),
    ("-=", "Subtracts a number."),
    ("*=", "Multiplies by a number."),
    ("/=", "Divides by a number."),
    ("( )", "Group, index, range or arguments: (A+B)*2, Q(3), T(2:4), $FSIN(30)."),
    ("{ }", "Sequence of values; a sequence inside gives its elements: {A,{1,2}}."),
    (":", "Range of a text or sequence: T(2:4), T(:4), Q(2:)."),
    (
        "$",
        "At the end of a line: the statement continues in the next line. Before a name: a system variable or function.",
    ),
    ("$$", "The rest of the line is a comment."),
    ("'", "Starts and ends a text; written twice inside a text it stands for one quote: 'it''s'."),
    ("#", "A keyword or record by number: #71, #2000:1030, #28000:*."),
    (
        "%",
        "Before a name: a variable with the name of a word of the language, as %ON; %L01 and %G01 are variables of their own.",
    ),
    (".TRUE. $TRUE", "The truth value true."),
    (".FALSE. $FALSE", "The truth value false."),
    ("$NULL", "No value; it equals only itself, and may be compared with anything by .EQ. and .NE."),
    ("$PI", "The number pi."),
    (
        "#{ !{",
        "In the text of a block: code of macros up to }, run when the block is read; its result takes its place. #{ comes before the pre-processor, !{ after it ($EMBMAC).",
    ),
    (
        "AND OR",
        "In `condition` of a macro in the machine file, as .AND., && and .OR., ||; AND binds tighter. Macros write .AND. and .OR.",
    ),
];

const FORMATS: &[Row] = &[
    ("!!", "Prints one exclamation mark."),
    ("^^", "Prints one ^ (in an expression: .XOR.)."),
    ("^", "Prints the character whose code is the next number."),
    (
        "!",
        "Begins a code of a format: !(s5.2), !(A), !(*), !@X; !! prints one exclamation mark. In an expression: .NOT.",
    ),
    (
        "!()",
        "A code of a format. Numbers: !([V|F|X][+][s|e]digits[.|f][digits][s|e]), with :2 once or twice after the whole digits a time in seconds; !(An) text, !(Mn) keyword, !(Rn) record, !(Ln) truth value, !(Tn) column, !(Xn) skip (READ), !(*) anything, !(@n) !(#n) in the format of a register.",
    ),
    (
        "V F X",
        "Use of columns by a number in a format: V no blanks, F blanks for suppressed zeros and the sign before the first digit, X like F with the sign in a first column of its own.",
    ),
    ("s e", "Zeros at the end of a group of digits in a format: s drops all of them, e keeps one digit."),
    (
        "f",
        "Point of a number in a format: it is written only if there is a fraction. First in a format, F asks for fixed columns.",
    ),
];

const PATTERNS: &[Row] = &[
    (".", "In a regular expression: any one character."),
    (
        "[] [^]",
        "In a regular expression: one character of the set, or, after ^, one that is not in the set: [A-Z0-9], [^;].",
    ),
    ("^", "At the beginning of a regular expression: the beginning of the text."),
    ("$", "At the end of a regular expression: the end of the text."),
    ("*", "In a regular expression: what comes before it, any number of times."),
    (r"\< \>", "In a regular expression: beginning and end of a word of letters, digits and underscores."),
    (
        r"\( \)",
        "In a regular expression: a group, which \\1 to \\9 repeat in the expression and insert in the replacement.",
    ),
    (r"\{ \}", "In a regular expression: a number of repetitions: a\\{3\\}, a\\{2,\\}, a\\{2,4\\}."),
    (r"\1 \2 \3 \4 \5 \6 \7 \8 \9", "In a regular expression or its replacement: what a group has matched."),
    (
        r"\",
        "In a regular expression: the next character as itself; \\< \\> \\( \\) \\{ \\} and \\1 to \\9 have a meaning.",
    ),
];

const KEYWORDS: &[Row] = &[
    ("THRU", "In a WHEN list: from the value before it to the one after it, both included."),
    ("OTHERS", "WHEN/OTHERS is the last branch of a CASE and runs when no other does."),
    ("GLOBAL", "In DECLAR: the variable is known to all macros of the job."),
    ("OBJECT", "In DECLAR: the variable is known to all macros of one kernel."),
    ("LOCAL", "In DECLAR, and without any of these words: the variable lives as long as the macro runs."),
    ("CHANNEL", "In DECLAR: one value for each channel; the index may be left out."),
    ("REAL", "Type of a variable: a number. It begins with 0."),
    ("LOGICAL", "Type of a variable: a truth value. It begins with .FALSE."),
    ("STRING", "Type of a variable: a text. It begins empty, which counts as one blank."),
    ("SEQUENCE", "Type of a variable: a sequence of values. It begins as {}."),
    ("KEYWORD", "Type of a variable: a minor word such as ON. It begins with #0."),
    ("RECORD", "Type of a variable: a major word such as COOLNT. It begins with #0:0."),
    ("CODE", "Type of a variable: a code identifier. It begins with CODE_NONE."),
    ("REG", "Type of a variable: a data identifier. It begins with REG_NONE."),
    ("EXTERN", "In DECLAR: a function outside the macros; not supported here."),
    ("FUNCTION", "In DECLAR/EXTERN; functions of macros are written with MACRO/."),
    ("NOW", "EXEC/NOW: the block is executed at once, before the macro continues."),
    ("NEXT", "EXEC/NEXT, and without a word: the block is executed after the current one."),
    ("FRONT", "OPEN/unit,FRONT and without a word: from the beginning of the file."),
    ("REAR", "OPEN/unit,REAR: at the end of the file."),
    ("INCR", "READ/unit,INCR and without a word: the next line. In $FSORT: smallest first."),
    ("DECR", "READ/unit,DECR: the line that was read last again. In $FSORT: largest first."),
    ("ENDIF ENDCASE ENDC ENDWHILE ENDW ENDDO", "The same as ENDOF/IF, ENDOF/CASE, ENDOF/WHILE or ENDOF/DO."),
    ("LEAVE", "The same as EXIT."),
    ("CODE_NONE", "No code."),
    ("REG_NONE", "No data."),
];

/// Argument, kind of macro, and content of the argument; an asterisk marks arguments that the macro may set.
const ARGUMENTS: &[(u8, &str, &str)] = &[
    (
        1,
        "subprogram startup and shutdown",
        "* 1 range of the program, 2 another file; 0 ignores the call, -1 reports the subprogram as missing",
    ),
    (1, "pre-processor startup and shutdown", "* 1; 0 skips the block"),
    (1, "block startup and shutdown", "* 1; 0 skips the block"),
    (1, "motion event", "1 circle, 2 thread, 4 rapid, 5 linear"),
    (1, "cycle event", "cycle code"),
    (1, "tool event", "1 tool selected, 2 tool loaded"),
    (1, "diagnostic event", "* 1; 0 drops the diagnostic"),
    (
        1,
        "pre-processor identification",
        "* 0; -1 ignores the text silently, 0 reports it, 1 evaluates $P2 again, 2 keeps $P2 as text",
    ),
    (1, "code macro", "* the code"),
    (1, "data macro", "* 1; 0 removes the value"),
    (2, "subprogram startup and shutdown", "name or number of the subprogram"),
    (2, "pre-processor startup and shutdown", "* the block"),
    (2, "block startup and shutdown", "* the block"),
    (2, "motion event", "end point, six numbers"),
    (2, "cycle event", "reference height"),
    (2, "tool event", "0 tool, 1 head"),
    (2, "diagnostic event", "* number"),
    (2, "pre-processor identification", "* unknown text"),
    (2, "code macro", "value of the code, or its text"),
    (2, "data macro", "* the value"),
    (3, "subprogram startup and shutdown", "first sequence number"),
    (3, "pre-processor and block startup and shutdown", "number of the block"),
    (3, "motion event", "centre of the circle"),
    (3, "cycle event", "clearance height"),
    (3, "tool event", "the tool or head"),
    (3, "diagnostic event", "* severity"),
    (3, "pre-processor identification", "value that is assigned, or $NULL"),
    (3, "data macro", "data identifier"),
    (4, "subprogram startup and shutdown", "last sequence number"),
    (4, "motion event", "normal vector of the plane"),
    (4, "cycle event", "retract height"),
    (4, "diagnostic event", "how often it has occurred"),
    (4, "data macro", "* 1 absolute, 2 incremental"),
    (5, "subprogram startup and shutdown", "number of repetitions"),
    (5, "motion event", "point in the middle of a circle in space"),
    (5, "cycle event", "depth"),
    (5, "diagnostic event", "* text"),
    (5, "data macro", "order of the register, or 0"),
    (6, "subprogram startup and shutdown", "the calling block"),
    (6, "motion event", "direction: 1 clockwise, 2 counter-clockwise"),
    (6, "cycle event", "bottom of a back boring"),
    (7, "subprogram startup and shutdown", "level of nesting"),
    (7, "motion event", "plane: 0 in space, 1 XY, 2 ZX, 3 YZ"),
    (8, "subprogram startup and shutdown", "number of this repetition"),
    (8, "motion event", "which of the six axes move"),
    (9, "subprogram startup and shutdown", "* file"),
    (10, "subprogram startup and shutdown", "* line in the file, -1 if it was not found"),
];

/// Arguments of a kind of macro, with their content.
pub(super) fn arguments_of(kind: &str) -> impl Iterator<Item = (u8, &'static str)> {
    let both = "pre-processor and block startup and shutdown";
    let is = move |of: &str| of == kind || of == both && both.ends_with(kind.trim_start_matches("pre-processor "));
    ARGUMENTS.iter().filter(move |(_, of, _)| !kind.is_empty() && is(of)).map(|(number, _, about)| (*number, *about))
}

/// The explanations of a term, one for each of its meanings.
pub(super) fn terms(what: &str) -> Option<String> {
    let what = what.trim();
    let upper = what.to_uppercase();
    let mut out = String::new();
    let tables = [("Operator or sign", OPERATORS), ("Format", FORMATS), ("Pattern", PATTERNS), ("Keyword", KEYWORDS)];
    for (title, rows) in tables {
        // Letters of formats differ by case.
        let name = if title == "Format" { what } else { upper.as_str() };
        let named = |names: &str| names == name || names.split(' ').any(|one| one == name);
        for (names, about) in rows.iter().filter(|(names, _)| named(names)) {
            let _ = writeln!(out, "{}{names}\n{title}\n\n{about}", if out.is_empty() { "" } else { "\n" });
        }
    }
    let text = if out.is_empty() { None } else { Some(out) };
    text.or_else(|| format_text(what)).or_else(|| variables(&upper)).or_else(|| reserved(&upper))
}

/// `$P1`, `%L01` and `%G01`.
fn variables(name: &str) -> Option<String> {
    if let Some(number) = name.strip_prefix("$P").and_then(|digits| digits.parse::<u8>().ok()) {
        if !(1..=99).contains(&number) {
            return None;
        }
        let rows: Vec<_> = ARGUMENTS.iter().filter(|(argument, ..)| *argument == number).collect();
        let mut out = format!("$P{number}\nArgument {number} of a macro\n\n");
        for (_, kind, about) in &rows {
            let _ = writeln!(out, "{kind}: {}", about.trim_start_matches("* "));
        }
        let settable: Vec<&str> =
            rows.iter().filter(|(.., about)| about.starts_with('*')).map(|(_, kind, _)| *kind).collect();
        if rows.is_empty() {
            out.push_str("No macro of the control emulator receives this argument; it is a local variable.\n");
        } else if !settable.is_empty() {
            let _ = writeln!(out, "\nA value assigned to it takes effect in: {}.", settable.join(", "));
        }
        return Some(out);
    }
    let digits = |rest: &str| rest.is_empty() || rest.len() <= 2 && rest.bytes().all(|byte| byte.is_ascii_digit());
    let about = match name.get(..2)? {
        "%L" if digits(name.get(2..)?) => {
            "%L00 to %L99\nVariable of one macro\n\nNever declared, of any type, unset when the macro begins.\n"
        }
        "%G" if digits(name.get(2..)?) => {
            "%G00 to %G99\nVariable of all macros of the job\n\nNever declared, of any type, unset when the job begins.\n"
        }
        _ => return None,
    };
    Some(about.to_owned())
}

fn reserved(name: &str) -> Option<String> {
    let record = ident::record(name).filter(|record| record.class != ident::MAJOR_CLASS);
    let what = match (ident::reserved(name)?, record) {
        (_, Some(record)) => format!(
            "Record word of the post-processor product; it can be written #{}:{}, and as a statement it does nothing here.",
            record.class, record.subclass
        ),
        (Reserved::Post, None) => "Word of the post-processor product; it does nothing here.".to_owned(),
        (Reserved::Control, None) => "Word of the language.".to_owned(),
    };
    Some(format!("{name}\nReserved word\n\n{what} A variable of this name is written %{name}.\n"))
}

/// A format, code by code.
fn format_text(what: &str) -> Option<String> {
    if !what.starts_with('!') {
        return None;
    }
    let format = StringFormat::output(what).or_else(|_| StringFormat::input(what)).ok()?;
    let mut out = format!("{what}\nFormat\n\n");
    for piece in &format.pieces {
        match piece {
            FormatPiece::Literal(text) => {
                let _ = writeln!(out, "'{text}' as it is.");
            }
            FormatPiece::Code(code) => {
                let _ = writeln!(out, "{}.", self::code(code));
            }
        }
    }
    Some(out)
}

fn code(code: &FormatCode) -> String {
    let words = |what: &str, width: usize, lower: bool| {
        let case = if lower { " in lower case" } else { "" };
        let fit = if width == 0 {
            " in full length".to_owned()
        } else {
            format!(", shortened or padded to {width} characters")
        };
        format!("{what}{case}{fit}")
    };
    match code {
        FormatCode::Number(numeric) => number(numeric),
        FormatCode::Text { width, lower } => words("A text", *width, *lower),
        FormatCode::Minor { width, lower } => words("Name of a keyword", *width, *lower),
        FormatCode::Record { width, lower } => words("Name of a record", *width, *lower),
        FormatCode::Logical { width, lower } => words("TRUE or FALSE", *width, *lower),
        FormatCode::Column { column, back: true } => format!("Continue in column {column}, cutting off the text from there on"),
        FormatCode::Column { column, back: false } => format!("Continue in column {column}, never backwards"),
        FormatCode::Skip(count) => format!("Skip {count} characters (READ)"),
        FormatCode::Any => "A value of any type by default rules: a number as !(s9f9s), texts and names as they are, $NULL, a sequence as <1,2>".to_owned(),
        FormatCode::Register { register, word, argument } => {
            let register = match register {
                FormatRegister::Index(index) => format!("register {index}"),
                FormatRegister::Letter(letter) => format!("register {letter}"),
            };
            let what = if *word { "word" } else { "value" };
            let from = if *argument { "A number" } else { "The current value" };
            format!("{from} as the {what} of {register}")
        }
        FormatCode::Character => "The character whose code is the number".to_owned(),
    }
}

fn number(numeric: &Numeric) -> String {
    let zeros = |zeros: ZeroStyle, which: &str| match zeros {
        ZeroStyle::Shown => format!("{which} zeros shown"),
        ZeroStyle::Dropped => format!("{which} zeros dropped"),
        ZeroStyle::KeepOne => format!("one digit of {which} zeros kept"),
    };
    let point = match numeric.point {
        PointStyle::Implied => "no point",
        PointStyle::Always => "a point always",
        PointStyle::WithFraction => "a point before a fraction only",
    };
    let style = match numeric.style {
        ColumnStyle::Variable => "",
        ColumnStyle::Fixed => ", fixed width with the sign before the first digit",
        ColumnStyle::Signed => ", fixed width with the sign in the first column",
    };
    let what = if numeric.groups.is_empty() { "A number" } else { "A time, given in seconds" };
    let samples: &[f64] = if numeric.groups.is_empty() { &[7.35, -12.0, 0.0] } else { &[8987.0, 35.5] };
    let shown: Vec<String> = samples
        .iter()
        .map(|value| {
            let mut text = String::new();
            numeric.write(&mut text, *value);
            format!("{} gives '{text}'", wildcard_text(*value))
        })
        .collect();
    format!(
        "{what}: {} whole digits ({}), {point}, {} fraction digits ({}){}{style}; {}",
        numeric.whole,
        zeros(numeric.lead, "leading"),
        numeric.fraction,
        zeros(numeric.trail, "trailing"),
        if numeric.plus { ", plus shown" } else { "" },
        shown.join(", ")
    )
}

#[cfg(test)]
mod tests;
