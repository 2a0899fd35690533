//! The data of an explanation as short text.
//!
//! *Invariant:* the text shows only the data.

use std::fmt::Write as _;

use serde_json::Value;

use crate::fields::JsonFields as _;
use crate::severity;
use crate::text::table;

/// Maximum number of codes and words in a line.
const LISTED: usize = 12;

/// The whole explanation.
pub(super) fn text(value: &Value) -> String {
    let mut out = String::new();
    let Some(words) = value.at("words").as_array() else {
        let _ = writeln!(out, "{}", of(value.at("word")));
        machines(&mut out, value.at("machines"));
        return out;
    };
    let families: Vec<String> = rows(value.at("extends")).skip(1).map(of).collect();
    let families = if families.is_empty() { String::new() } else { format!(" (extends {})", families.join(", ")) };
    let chain = format!("{}{families}", of(value.at("machine")));
    for (at, word) in words.iter().enumerate() {
        let blank = if at > 0 { "\n" } else { "" };
        let name = of(word.at("word"));
        let component = word.at("component").as_str();
        if let Some(component) = component.filter(|_| word.at("elsewhere") == true) {
            let _ = writeln!(out, "{blank}component {component} of {} does not have {name}", of(value.at("machine")));
            continue;
        }
        match component {
            Some(component) => {
                let extends = list(word.at("extends"), ", ", usize::MAX);
                let _ = writeln!(out, "{blank}{component}: {name} on {} ({extends})", of(value.at("machine")));
            }
            None => {
                let _ = writeln!(out, "{blank}{name} on {chain}");
            }
        }
        one(&mut out, word);
    }
    out
}

/// One word.
fn one(out: &mut String, word: &Value) {
    rows(word.at("codes")).for_each(|row| code(out, row));
    if !word.at("register").is_null() {
        register(out, word.at("register"));
    }
    if let variable @ Value::Object(_) = word.at("variable") {
        let write = if variable.at("write") == true { "; programs may set it" } else { "; read only" };
        let range = variable.at("range");
        let _ = writeln!(out, "\nvariable: {}{write}", of(variable.at("means")));
        let _ = writeln!(out, "  of #{} to #{}{}", range.at("first"), range.at("last"), defined(variable));
    }
    rows(word.at("called")).for_each(|call| line(out, &format!("\ncall: {}{}", of(call.at("text")), defined(call))));
    for program in rows(word.at("programs")) {
        let _ = writeln!(out, "\nprogram stored with the machine: {}:{}", of(program.at("path")), program.at("line"));
        [program.at("about"), program.at("head")].into_iter().filter(|text| text.is_string()).for_each(|text| {
            line(out, &format!("  {}", of(text)));
        });
        let parameters = list(program.at("parameters"), " ", usize::MAX);
        if !parameters.is_empty() {
            line(out, &format!("  reads {parameters}"));
        }
    }
    for alarm in rows(word.at("alarms")) {
        let place = format!("{}:{}", of(alarm.at("path")), alarm.at("line"));
        line(out, &format!("\nalarm of a program stored with the machine ({place}): {}", of(alarm.at("about"))));
    }
    let words: Vec<Vec<String>> =
        rows(word.at("words")).map(|row| vec![of(row.at("word")), of(row.at("meaning"))]).collect();
    if !words.is_empty() {
        out.push_str("\nwords that the call reads\n");
        out.push_str(&table(&words, 2));
    }
    for row in rows(word.at("rows")) {
        line(out, &format!("\nrow of {}: {}{}", of(row.at("section")), of(row.at("text")), defined(row)));
    }
    for step in rows(word.at("edited")) {
        line(
            out,
            &format!(
                "\nrule {} of the tape editor makes '{}' of it{}",
                step.at("rule"),
                of(step.at("text")),
                defined(step)
            ),
        );
    }
    if let diagnostic @ Value::Object(_) = word.at("diagnostic") {
        self::diagnostic(out, diagnostic);
    }
    pages(out, word.at("pages"));
    if let Some(text) = word.at("sign").as_str() {
        let _ = writeln!(out, "\nsign of the program text: {text}");
    }
    if let Some(block) = word.at("accepted").as_str() {
        let kind = if block.contains('=') { "a variable of the control" } else { "a name of the control" };
        let _ = writeln!(out, "\n{kind}: a block '{block}' is accepted");
    }
    if let Some(text) = word.at("text").as_str() {
        let _ = write!(out, "\nno word of a program, but a word of macros:\n\n{text}");
    }
    if !word.at("unknown").is_null() {
        unknown(out, word.at("unknown"));
    }
}

/// A code row.
fn code(out: &mut String, row: &Value) {
    let _ = writeln!(out, "\ncode {}: {}", of(row.at("id")), of(row.at("meaning")));
    let conditions = [("with", "with"), ("without", "without")].into_iter().filter_map(|(key, word)| {
        let registers = list(row.at(key), " ", usize::MAX);
        (!registers.is_empty()).then(|| format!(" {word} {registers}"))
    });
    let conditions: String = conditions.collect();
    let mut line = |name: &str, text: String| {
        if !text.is_empty() {
            let _ = writeln!(out, "  {name:<10}{text}");
        }
    };
    line("written", format!("{}{conditions}", of(row.at("word"))));
    if row.at("as_data").is_string() {
        line("value", format!("becomes {}", of(row.at("as_data"))));
    }
    if let Some(digits) = row.at("tool_digits").as_u64() {
        line("digits", tool_digits(digits));
    }
    let off = [("enable", "the row is switched off"), ("process", "the word is ignored")];
    let off: Vec<&str> = off.into_iter().filter(|(key, _)| row.at(key) == false).map(|(_, text)| text).collect();
    line("note", off.join(", "));
    line("group", group(row));
    line("order", of(row.at("order")));
    if row.at("seconds").as_f64().is_some_and(|seconds| seconds > 0.0) {
        line("time", format!("{} s", row.at("seconds")));
    }
    line("defined", place(row));
    for wait in rows(row.at("waits")) {
        line("wait", format!("{} ({})", of(wait.at("primitive")), of(wait.at("act"))));
    }
    macros(out, row.at("macros"));
    let reads: Vec<&Value> = rows(row.at("reads")).collect();
    if !reads.is_empty() {
        out.push_str("\nwords that it reads\n");
        out.push_str(&data(&reads));
    }
    refusals(out, row.at("refusals"));
}

/// `the last 2 digits are the number of the offset: T0203 is tool 2 with offset 3`.
fn tool_digits(digits: u64) -> String {
    let width = usize::try_from(digits).unwrap_or(2).min(8);
    let which = if digits == 1 { "digit is".to_owned() } else { format!("{digits} digits are") };
    format!("the last {which} the number of the offset: T{:0width$}{:0width$} is tool 2 with offset 3", 2, 3)
}

fn group(row: &Value) -> String {
    let modality = of(row.at("modality"));
    if row.at("group") == 0 {
        return format!("none, {modality}");
    }
    let subject = match of(row.at("subject")) {
        subject if subject == "-" => String::new(),
        subject => format!(" {subject}"),
    };
    let start = if row.at("active_at_start") == true { ", active at the start" } else { "" };
    let others = list(row.at("same_group"), " ", LISTED);
    let others = if others.is_empty() { String::new() } else { format!("; also in it: {others}") };
    format!("{}{subject}, {modality}{start}{others}", row.at("group"))
}

/// A register with its data.
fn register(out: &mut String, register: &Value) {
    if register.at("name").is_string() {
        let second = register.at("second").as_str().map(|name| format!(", {name} for increments")).unwrap_or_default();
        let _ = writeln!(out, "\nregister {}: {}{second}", of(register.at("name")), of(register.at("number")));
        let codes: Vec<&Value> = rows(register.at("codes")).collect();
        let cells = codes.iter().take(LISTED).map(|code| {
            let meaning = code.at("meaning").as_str().map(|meaning| format!(": {meaning}")).unwrap_or_default();
            vec![of(code.at("word")), format!("{}{meaning}", of(code.at("id")))]
        });
        out.push_str(&table(&cells.collect::<Vec<_>>(), 2));
        if codes.len() > LISTED {
            let more = codes.len() - LISTED;
            let _ = writeln!(out, "  and {more} more codes: `counterpoint machine show NAME codes` lists them");
        }
    }
    let rows: Vec<&Value> = self::rows(register.at("data")).collect();
    if !rows.is_empty() {
        out.push_str("\ndata\n");
        out.push_str(&data(&rows));
    }
    rows.iter().for_each(|row| macros(out, row.at("macros")));
    refusals(out, register.at("refusals"));
}

/// Data rows as a table.
fn data(rows: &[&Value]) -> String {
    let head = ["word", "data", "meaning", "number", "unit", "limits", "scaling", "defined"];
    let mut head = head.map(str::to_owned).to_vec();
    let blocks = rows.iter().any(|row| row.at("block").is_string());
    if blocks {
        head.insert(2, "block".to_owned());
    }
    let columns = head.len();
    let mut cells = vec![head];
    cells.extend(rows.iter().map(|row| {
        let limits = match (row.at("min"), row.at("max")) {
            (Value::Null, Value::Null) => "-".to_owned(),
            (min, max) => format!("{} to {}", number(min), number(max)),
        };
        let mul = row.at("mul").as_f64().filter(|mul| *mul != 1.0).map(|mul| format!("*{mul}")).unwrap_or_default();
        let add = row.at("add").as_f64().filter(|add| *add != 0.0).map(|add| format!("{add:+}")).unwrap_or_default();
        let scaling = format!("{mul}{add}");
        let mut line = vec![
            dash(&of(row.at("register"))),
            of(row.at("id")),
            of(row.at("meaning")),
            dash(&of(row.at("number"))),
            of(row.at("dimension")),
            limits,
            dash(&scaling),
            place(row),
        ];
        if blocks {
            line.insert(2, dash(&of(row.at("block"))));
        }
        line
    }));
    table(&cells, columns)
}

fn macros(out: &mut String, macros: &Value) {
    for one in rows(macros) {
        let condition = of(one.at("condition"));
        let condition = if condition.is_empty() { condition } else { format!(", if {condition}") };
        let off = if one.at("enabled") == false { ", switched off" } else { "" };
        let (name, file) = (of(one.at("name")), of(one.at("file")));
        let _ = writeln!(out, "  {:<10}{name}: {file}{condition}{off}{}", "macro", defined(one));
    }
}

fn refusals(out: &mut String, refusals: &Value) {
    let rules: Vec<&Value> = rows(refusals).collect();
    if rules.is_empty() {
        return;
    }
    out.push_str("\nblocks that the control refuses\n");
    let mut cells = Vec::new();
    for rule in rules {
        let part = |key: &str, word: &str| {
            let list = list(rule.at(key), " ", LISTED);
            (!list.is_empty()).then(|| format!("{word} {list}"))
        };
        let word = of(rule.at("word"));
        let word = (!word.is_empty()).then(|| format!("unless {word}"));
        let parts = [
            part("with", "with"),
            part("without", "without"),
            part("active", "while"),
            part("inactive", "unless"),
            word,
        ];
        let when: Vec<String> = parts.into_iter().flatten().collect();
        cells.push(vec![of(rule.at("alarm")), of(rule.at("text")), dash(&when.join(", ")), place(rule)]);
    }
    out.push_str(&table(&cells, 4));
}

fn diagnostic(out: &mut String, diagnostic: &Value) {
    let rule = diagnostic.at("rule");
    if !rule.is_null() {
        let _ = writeln!(out, "\nthe machine changes {}{}", rule.at("number"), defined(rule));
        for (key, name) in [("severity", "severity"), ("text", "text"), ("repeat", "repeat"), ("stops", "stops")] {
            if !rule.at(key).is_null() {
                let _ = writeln!(out, "  {name:<10}{}", of(rule.at(key)));
            }
        }
        if rule.at("enable") == false {
            out.push_str("  never shown\n");
        }
    }
    refusals(out, diagnostic.at("refusals"));
    if let Some(page) = diagnostic.at("page").as_str() {
        let _ = write!(out, "\n{page}");
    }
}

fn pages(out: &mut String, pages: &Value) {
    let mut last = String::new();
    for row in rows(pages) {
        let page = of(row.at("page"));
        if page != last {
            let _ = writeln!(out, "\n{page}");
            last = page;
        }
        let _ = writeln!(out, "  {}", of(row.at("text")));
    }
}

fn unknown(out: &mut String, unknown: &Value) {
    out.push_str("\nthe machine does not have it\n");
    let mut told = false;
    for diagnostic in rows(unknown.at("diagnostics")) {
        told = true;
        let severity = diagnostic.at("severity").as_u64().and_then(|severity| u32::try_from(severity).ok());
        let (kind, _) = severity::word(severity.unwrap_or(severity::ERROR));
        let number = diagnostic.at("number").as_u64().filter(|number| *number > 0);
        let number = number.map(|number| format!(" {number}")).unwrap_or_default();
        let _ = writeln!(out, "  in a block: {kind}{number}: {}", of(diagnostic.at("text")));
    }
    if !told {
        out.push_str("  in a block: nothing is reported\n");
    }
    if let Some(near) = unknown.at("near").as_str() {
        let _ = writeln!(out, "  did you mean {near}?");
    }
    if rows(unknown.at("machines")).next().is_some() {
        out.push_str("\nmachines that have it\n");
        machines(out, unknown.at("machines"));
    }
}

fn machines(out: &mut String, machines: &Value) {
    for row in rows(machines) {
        let meaning = row.at("meaning").as_str().map(|meaning| format!(": {meaning}")).unwrap_or_default();
        let _ = writeln!(out, "  {}{meaning}", of(row.at("id")));
        let _ = writeln!(out, "    {}", list(row.at("machines"), " ", usize::MAX));
    }
}

/// `haas-lathe/machine.toml:12`, with the family that a row comes from.
fn place(row: &Value) -> String {
    let Some(file) = row.at("file").as_str() else { return "-".to_owned() };
    let from = row.at("inherited_from").as_str().map(|family| format!(" (inherited from {family})"));
    format!(
        "{file}:{}{}",
        row.at("line"),
        from.filter(|_| row.at("id").is_string() && row.at("word").is_string()).unwrap_or_default()
    )
}

/// `, defined in …`.
fn defined(row: &Value) -> String {
    row.at("defined").as_str().map(|place| format!(", defined in {place}")).unwrap_or_default()
}

fn rows(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn list(value: &Value, between: &str, most: usize) -> String {
    let all: Vec<String> = rows(value).map(of).collect();
    let more = if all.len() > most { " …" } else { "" };
    format!("{}{more}", all.into_iter().take(most).collect::<Vec<_>>().join(between))
}

fn number(value: &Value) -> String {
    value.as_f64().map_or_else(|| "…".to_owned(), |number| number.to_string())
}

/// A value without quotes.
fn of(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Null => String::new(),
        other => other.to_string(),
    }
}

fn dash(text: &str) -> String {
    if text.is_empty() { "-".to_owned() } else { text.to_owned() }
}

fn line(out: &mut String, text: &str) {
    out.push_str(text);
    out.push('\n');
}
