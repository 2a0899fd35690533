//! `explain`: the effect of a program word on a machine; without a machine, a diagnostic, an alarm or a word of macros.
//!
//! *Invariant:* the text is made from the data that `--json` prints.

mod arguments;
mod code;
mod components;
mod elsewhere;
mod pages;
mod programs;
mod register;
mod related;
mod signs;
mod text;
mod trial;
mod words;

use counterpoint_kernel::machine::index::{CodeRowId, DataRowId};
use counterpoint_kernel::machine::show;
use counterpoint_kernel::machine::{DefinitionKey, Machine, WrittenDefinition};
use counterpoint_kernel::tape;
use serde_json::{Value, json};

use crate::arguments::Explain;
use crate::error::Error;
use crate::fields::JsonFields as _;
use crate::local_machine::LocalMachine;
use crate::{macros, say};
use words::WordMeaning;

/// Explains the words of the command line.
pub(crate) fn explain(arguments: &Explain) -> Result<u8, Error> {
    let asked = arguments.words.join(" ");
    let asked = asked.trim();
    if asked.is_empty() {
        return Err(Error::Usage("give a word, a number or a name to explain".to_owned()));
    }
    match &arguments.machine {
        Some(machine) => on_machine(asked, machine, arguments.json),
        None => anywhere(asked, arguments.json),
    }
}

/// Without a machine: a diagnostic, an alarm, a word of macros, or the machines that have a word.
fn anywhere(asked: &str, json: bool) -> Result<u8, Error> {
    if let Some(text) = macros::explanation(asked) {
        if json {
            print(&json!({ "word": asked, "text": text }), true)?;
        } else {
            say::data(text.as_bytes())?;
        }
        return Ok(0);
    }
    let machines = elsewhere::machines(asked, None);
    if machines.is_empty() {
        return Err(Error::Usage(format!(
            "{}; for a word of programs give --machine NAME or --machine DIR",
            macros::unknown(asked)
        )));
    }
    print(&json!({ "word": asked, "machines": machines }), json)?;
    Ok(0)
}

/// A machine, or a component of a composite, with the pages and tables that explain its words.
struct ExplainedMachine {
    machine: Machine,
    local: LocalMachine,
    definition: WrittenDefinition,
    /// Folder of the machine, also of the composite of a component.
    own: String,
}

fn on_machine(asked: &str, name: &str, json: bool) -> Result<u8, Error> {
    let subject = ExplainedMachine::of(LocalMachine::open(name)?)?;
    let words =
        if subject.machine.components.is_empty() { subject.words(asked) } else { components::words(&subject, asked) };
    let known = words.iter().all(|word| word.at("known") == true || word.at("elsewhere") == true);
    let value = json!({ "machine": subject.machine.name, "extends": subject.definition.chain, "words": words });
    print(&value, json)?;
    // Treat a word that the machine does not have like any unknown name.
    Ok(if known { 0 } else { 2 })
}

/// The number of a diagnostic from the head of its page.
fn number_of(line: &str) -> Option<u32> {
    line.strip_prefix("# ")?.get(..8)?.parse().ok()
}

fn print(value: &Value, json: bool) -> Result<(), Error> {
    if json {
        let text = serde_json::to_string_pretty(value).unwrap_or_default();
        return say::line(&text);
    }
    say::data(text::text(value).as_bytes())
}

impl ExplainedMachine {
    fn of(local: LocalMachine) -> Result<Self, Error> {
        let (machine, definition) = (local.load()?, local.definition()?);
        let own = definition.chain.first().cloned().unwrap_or_default();
        Ok(Self { machine, local, definition, own })
    }

    /// The words of a text, with the answer of the control and of other machines for those that the machine does not
    /// have.
    fn words(&self, asked: &str) -> Vec<Value> {
        let mut words = self.looked_up(asked);
        for word in words.iter_mut().filter(|word| word.at("known") == false) {
            let text = word.at("word").as_str().unwrap_or_default().to_owned();
            if let Some(accepted) = trial::accepted(&self.machine, &text) {
                word.set("accepted", json!(accepted));
                word.set("known", json!(true));
            } else {
                self.not_found(word, &text);
            }
        }
        words
    }

    /// Reports a word that the machine does not have: a word of macros, which no machine defines, or an unknown word.
    fn not_found(&self, word: &mut Value, text: &str) {
        if let Some(explanation) = macros::explanation(text) {
            word.set("text", json!(explanation));
            word.set("known", json!(true));
        } else {
            word.set("unknown", self.unknown(text));
        }
    }

    /// The whole text as one word of the machine, or its words one by one.
    fn looked_up(&self, asked: &str) -> Vec<Value> {
        let whole = self.word(asked, &[]);
        let several = asked.contains(char::is_whitespace);
        if whole.at("known") == true || !several {
            return vec![whole];
        }
        let (mut codes, mut words) = (Vec::new(), Vec::new());
        for word in asked.split_whitespace() {
            words.push(self.word(word, &codes));
            if let Some(found) = words::find(&self.machine, word) {
                codes.extend(found.codes);
            }
        }
        // The pages of the control list a statement of several words only as a whole.
        if words.iter().any(|word| word.at("known") == false) { vec![whole] } else { words }
    }

    /// A word; `before` are the codes before it.
    fn word(&self, asked: &str, before: &[CodeRowId]) -> Value {
        let machine = &self.machine;
        let mut value = json!({ "word": asked, "known": true });
        let mut add = |key: &str, found: Value| {
            let empty = found.as_array().is_some_and(Vec::is_empty) || found.is_null();
            if let Value::Object(value) = &mut value
                && !empty
            {
                value.insert(key.to_owned(), found);
            }
            !empty
        };
        let mut known = false;
        let number = asked.strip_prefix('#').and_then(|digits| digits.parse().ok());
        known |= add("variable", number.map_or(Value::Null, |number| self.variable(number)));
        if number.is_none() {
            if let Some(found) = words::find(machine, asked) {
                known |= add("codes", self.codes(&found));
                known |= add("register", self.register(&found, before));
            }
            known |= add("called", json!(self.called(asked)));
            known |= add("programs", json!(programs::of_word(machine, asked, &self.called_numbers(asked))));
            known |= add("alarms", json!(programs::that_raise(machine, asked)));
            known |= add("words", json!(arguments::of(machine, asked)));
            known |= add("rows", json!(self.rows(asked)));
            known |= add("diagnostic", self.diagnostic(asked));
            add("edited", self.edited(asked));
        }
        // A letter alone occurs on every page.
        let pages = if asked.len() > 1 {
            pages::rows(machine, &self.local, &self.definition.chain, &asked.to_uppercase())
        } else {
            Vec::new()
        };
        known |= add("sign", json!(signs::meaning(&machine.format, asked)));
        // The pages also name codes that the machine does not have.
        let told = add("pages", json!(pages));
        known = known || told && !trial::is_unknown_code(machine, asked);
        value.set("known", json!(known));
        value
    }

    fn codes(&self, found: &WordMeaning) -> Value {
        let codes = found.codes.iter().map(|id| {
            let mut value = code::code(&self.machine, *id);
            self.place_macros(&mut value);
            self.inherited(&mut value);
            value
        });
        codes.collect()
    }

    /// The register of a word other than a code.
    fn register(&self, found: &WordMeaning, before: &[CodeRowId]) -> Value {
        if !found.codes.is_empty() && found.register.is_some_and(|(_, value)| value.is_some()) {
            return Value::Null;
        }
        let machine = &self.machine;
        let read =
            |id: &DataRowId| before.iter().any(|code| code::reads(machine, machine.codes[*code].id).contains(id));
        let mut rows = found.data.clone();
        if rows.iter().any(read) {
            rows.retain(read);
        }
        let rows = rows.into_iter().map(|id| {
            let mut value = register::data(machine, id);
            self.place_macros(&mut value);
            self.inherited(&mut value);
            value
        });
        let rows: Vec<Value> = rows.collect();
        match found.register {
            Some((id, _)) => {
                let mut value = register::register(machine, id, before);
                value.set("data", json!(rows));
                value.set("codes", json!(code::of_register(machine, id)));
                value
            }
            None if rows.is_empty() => Value::Null,
            None => json!({ "data": rows }),
        }
    }

    /// The family that defines a row.
    fn inherited(&self, value: &mut Value) {
        let folder = value.at("file").as_str().and_then(|file| file.rsplit_once('/')).map_or("", |(folder, _)| folder);
        let folder = folder.to_owned();
        let own = self.definition.chain.first().is_some_and(|own| *own == folder) || self.own == folder;
        value.set("inherited_from", if own { Value::Null } else { json!(folder) });
    }

    /// The lines of the machine file at which macros are declared.
    fn place_macros(&self, found: &mut Value) {
        for one in found.get_mut("macros").and_then(Value::as_array_mut).into_iter().flatten() {
            let file = one.at("file").as_str().unwrap_or_default().to_owned();
            let named =
                |key: &DefinitionKey| key.key == "file" && file.ends_with(&format!("/{}", key.value.trim_matches('"')));
            let first = one.at("match").get(0).and_then(Value::as_str).unwrap_or_default().to_owned();
            let fires = |key: &DefinitionKey| key.value.contains(&first);
            let row = self.definition.rows.iter().find(|row| {
                row.section.starts_with("macros.") && row.keys.iter().any(named) && row.keys.iter().any(fires)
            });
            one.set("defined", json!(row.map(|row| row.place.as_str())));
        }
    }

    fn variable(&self, number: u32) -> Value {
        let Some(mut found) = show::variable(&self.machine, number) else { return Value::Null };
        let first = found.at("range").at("first").to_string();
        let row = self.definition.rows.iter().find(|row| row.section == "system_variables" && row.name == first);
        found.set("defined", json!(row.map(|row| row.place.as_str())));
        found
    }

    /// Numbers of the programs that the word calls.
    fn called_numbers(&self, asked: &str) -> Vec<u32> {
        let Some(WordMeaning { register: Some((register, Some(value))), .. }) =
            words::register_of(&self.machine, asked)
        else {
            return Vec::new();
        };
        let calls = self.machine.subprograms.calls.iter().filter(|call| call.register == register);
        calls.filter_map(|call| call.program_of(register, value)).collect()
    }

    /// Rows of `[[subprograms.calls]]` that contain the word.
    fn called(&self, asked: &str) -> Vec<Value> {
        let Some(WordMeaning { register: Some((register, value)), .. }) = words::register_of(&self.machine, asked)
        else {
            return Vec::new();
        };
        let calls = self.machine.subprograms.calls.iter().filter(|call| {
            call.register == register
                && value.map_or(!call.max.is_finite(), |value| call.program_of(register, value).is_some())
        });
        calls
            .map(|call| {
                let text = show::word_call(&self.machine, call);
                json!({ "text": text, "defined": format!("{}:{}", call.file, call.line) })
            })
            .collect()
    }

    /// Rows of the definition that have the word as their name: statements that wait, variables of the PLC, tools.
    fn rows(&self, asked: &str) -> Vec<Value> {
        const SECTIONS: [&str; 4] = ["waits", "external", "tool.names", "dialogs"];
        let rows = self.definition.rows.iter();
        let own = rows.filter(|row| SECTIONS.contains(&row.section.as_str()) && row.name.eq_ignore_ascii_case(asked));
        own.map(|row| {
            let keys = row.keys.iter().map(|key| format!("{} = {}", key.key, key.value)).collect::<Vec<_>>();
            json!({ "section": row.section, "text": keys.join(", "), "defined": row.place })
        })
        .collect()
    }

    /// A diagnostic or an alarm, with the changes of the machine.
    fn diagnostic(&self, asked: &str) -> Value {
        let page = macros::diagnostic(asked);
        let refusals = related::refusals(&self.machine, |rule| rule.alarm.eq_ignore_ascii_case(asked));
        if page.is_none() && refusals.is_empty() {
            return Value::Null;
        }
        let numbers: Vec<u32> = page.iter().flat_map(|page| page.lines()).filter_map(number_of).collect();
        let rule = self.machine.diagnostics.rules.iter().find(|rule| numbers.contains(&rule.number));
        let rule = rule.map(|rule| {
            let row = self
                .definition
                .rows
                .iter()
                .find(|row| row.section == "diagnostics" && row.name == rule.number.to_string());
            json!({
                "number": rule.number, "severity": rule.severity, "text": rule.text, "enable": rule.enable,
                "repeat": rule.repeat, "stops": rule.stops, "defined": row.map(|row| row.place.as_str()),
            })
        });
        json!({ "page": page, "rule": rule, "refusals": refusals })
    }

    /// The word as the tape editor changes it.
    fn edited(&self, asked: &str) -> Value {
        let steps = tape::steps(&self.machine, asked.as_bytes(), false);
        let steps = steps.iter().filter_map(|step| {
            let rule = self.machine.tape_editor.get(step.rule)?;
            let text = String::from_utf8_lossy(&step.text);
            Some(json!({ "text": text, "rule": step.rule + 1, "defined": format!("{}:{}", rule.file, rule.line) }))
        });
        steps.collect()
    }

    /// A word that the machine does not have: the response of the control, the most similar word, and the machines that
    /// have the word.
    fn unknown(&self, asked: &str) -> Value {
        let machine = &self.machine;
        json!({
            "diagnostics": trial::diagnostics(machine.clone(), asked),
            "near": elsewhere::nearest(machine, asked),
            "machines": elsewhere::machines(asked, Some(&machine.name)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The alarms of all controls, on a machine on which many of them look like words.
    #[test]
    fn every_alarm_is_explained_on_a_machine_with_its_meaning() {
        for machine in ["fanuc-lathe", "siemens-mill"] {
            let subject =
                ExplainedMachine::of(LocalMachine::shipped(machine)).unwrap_or_else(|error| panic!("{error}"));
            for (alarm, about, _) in macros::alarm_rows() {
                let words = subject.looked_up(&alarm);
                let page = words[0].at("diagnostic").at("page").as_str().unwrap_or_default();
                assert!(words[0].at("known") == true && page.contains(&about), "{alarm}: {about} is not in {page}");
            }
        }
    }
}
