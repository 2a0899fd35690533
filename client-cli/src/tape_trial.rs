//! `machine edit`: the rules of the tape editor tried on lines.
//!
//! *Invariant:* the last text of a line is the text of a run with the rules that are on at the start of a program.

use std::fmt::Write as _;
use std::io::Read as _;

use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::tape;
use serde_json::{Value, json};

use crate::error::Error;
use crate::fields::JsonFields as _;
use crate::local_machine::LocalMachine;
use crate::say;

/// Tries the rules on each line; a line `-` is all lines of standard input.
pub(crate) fn edit(machine: &str, lines: &[String], all: bool, json: bool) -> Result<u8, Error> {
    let machine = LocalMachine::open(machine)?.load()?;
    let all_machines: Vec<_> = machine.definitions().collect();
    if all_machines.iter().all(|(_, machine)| machine.tape_editor.is_empty()) {
        return Err(Error::Usage(format!(
            "machine '{}' has no rules of the tape editor ([[tape_editor]])",
            machine.name
        )));
    }
    let mut texts: Vec<Vec<u8>> = Vec::new();
    for line in lines {
        if line == "-" {
            let mut read = Vec::new();
            std::io::stdin().read_to_end(&mut read).map_err(Error::file("standard input"))?;
            let lines = read.split(|byte| *byte == b'\n').map(|line| line.strip_suffix(b"\r").unwrap_or(line).to_vec());
            texts.extend(lines);
            // Text after the last line feed is a line unless it is empty.
            texts.pop_if(|line| line.is_empty());
        } else {
            texts.push(line.clone().into_bytes());
        }
    }
    let tried = texts.iter().flat_map(|line| all_machines.iter().map(move |one| steps(*one, line, all)));
    let tried: Vec<Value> = tried.collect();
    if json {
        say::line(&serde_json::to_string_pretty(&tried).unwrap_or_default())?;
    } else {
        say::data(tried.iter().map(text).collect::<String>().as_bytes())?;
    }
    Ok(0)
}

fn steps((component, machine): (&str, &Machine), line: &[u8], all: bool) -> Value {
    let steps = tape::steps(machine, line, all);
    let steps = steps.iter().filter_map(|step| {
        let rule = machine.tape_editor.get(step.rule)?;
        Some(json!({
            "rule": step.rule + 1,
            "find": rule.find,
            "replace": rule.replace,
            "on": rule.on,
            "file": rule.file,
            "line": rule.line,
            "text": String::from_utf8_lossy(&step.text),
        }))
    });
    let mut tried = json!({ "line": String::from_utf8_lossy(line), "steps": steps.collect::<Vec<_>>() });
    if !component.is_empty() {
        tried.set("component", json!(component));
    }
    tried
}

/// The line, then its text after each rule that changes it.
fn text(tried: &Value) -> String {
    let of = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let component = tried.at("component").as_str().map(|component| format!("{component}: ")).unwrap_or_default();
    let mut out = format!("{component}{}\n", of(tried.at("line")));
    let steps = tried.at("steps").as_array();
    for step in steps.into_iter().flatten() {
        let off = if step.at("on") == true { "" } else { ", off at the start of a program" };
        let place = format!("{}:{}", of(step.at("file")), step.at("line"));
        let (find, replace) = (of(step.at("find")), of(step.at("replace")));
        let _ = writeln!(out, "  rule {} \"{find}\" -> \"{replace}\"  [{place}{off}]", step.at("rule"));
        let _ = writeln!(out, "{}", of(step.at("text")));
    }
    if steps.is_none_or(Vec::is_empty) {
        out.push_str("  no rule changes it\n");
    }
    out
}
