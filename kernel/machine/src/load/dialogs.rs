//! `[[dialogs]]`: questions to the operator, in the machine file or in files beside it.
//!
//! Invariant: names are unique without blanks and letter case, defaults pass the check of their field, there is a
//! button of type OK. Facts: reference control-emulator.md 7.4.

use crate::macros::model::Macros;
use crate::macros::system;
use crate::toml::check::FindingCollector;
use crate::toml::node::{self, DefinitionPlace, Node};
use crate::toml::parse::parse;
use crate::toml::section::TableReader;
use counterpoint_ports::dialog::answers::DialogValue;
use counterpoint_ports::dialog::{Button, ButtonKind, Dialog, DialogField, FieldKind, same_name};
use counterpoint_ports::files::JobFiles;

/// Most dialogs of a machine, and most fields and buttons of one.
const MOST: usize = 200;

/// A variable that a dialog names: its name, where, and whether it only decides about a field.
type Named = (String, DefinitionPlace, bool);

/// Reads the dialogs in file order; `shown` are those that macros show by name.
pub(super) fn read(
    top: &mut TableReader<'_>,
    files: &dyn JobFiles,
    macros: Option<&Macros>,
    shown: &[(String, DefinitionPlace)],
    check: &FindingCollector,
) -> Vec<Dialog> {
    let mut dialogs: Vec<Dialog> = Vec::new();
    for mut row in top.rows("dialogs", "[[dialogs]]", MOST) {
        let dialog = match row.name("file", 128) {
            None => read_dialog(row, macros, check),
            Some(name) => {
                let folder = row.place().file.rsplit_once('/').map_or("", |(folder, _)| folder).to_owned();
                let path = format!("{folder}/{name}");
                let content = files.read(&path);
                let at = row.place_of("file").clone();
                row.finish();
                match content {
                    Ok(content) if !name.contains("..") => {
                        let place = DefinitionPlace { file: path.as_str().into(), line: 0, column: 0 };
                        let table = parse(&place.file, &content, check);
                        read_dialog(TableReader::new(&table, place, "a dialog file", check), macros, check)
                    }
                    _ => {
                        check.error(&at, format!("the file {path} does not exist"));
                        None
                    }
                }
            }
        };
        let Some((dialog, place)) = dialog else { continue };
        if dialogs.iter().any(|other| same_name(&other.name, &dialog.name)) {
            check.error(&place, format!("there is already a dialog \"{}\"", dialog.name));
        }
        dialogs.push(dialog);
    }
    for dialog in &dialogs {
        for button in &dialog.buttons {
            if let ButtonKind::Call(name) = &button.kind
                && !dialogs.iter().any(|other| same_name(&other.name, name))
            {
                check.error(
                    top.place_of("dialogs"),
                    format!("button {} calls the unknown dialog \"{name}\"", button.label),
                );
            }
        }
    }
    for (name, place) in shown {
        if !dialogs.iter().any(|dialog| same_name(&dialog.name, name)) {
            check.error(place, format!("this machine has no dialog '{name}'; [[dialogs]] with this name is expected"));
        }
    }
    dialogs
}

/// Variables of a dialog that do not exist: text entered there would be lost.
fn check_variables(dialog: &[DialogField], named: &[Named], macros: Option<&Macros>, check: &FindingCollector) {
    let Some(macros) = macros else { return };
    for (variable, place, decides) in named {
        let name = variable.trim().to_ascii_uppercase();
        let in_dialog = dialog.iter().any(|field| field.variable.eq_ignore_ascii_case(&name));
        if *decides && in_dialog {
            continue;
        }
        let known = if name.starts_with('$') {
            system::find(&name).is_some_and(|variable| variable.indices.is_empty())
        } else if let Some(number) = name.strip_prefix("%G") {
            number.parse::<u8>().is_ok_and(|number| number < 100)
        } else {
            macros.program.shared_variable(&name).is_some()
        };
        if !known {
            let or = if *decides { "a variable of a field of this dialog, " } else { "" };
            let text = format!(
                "no macro declares {variable}; {or}a GLOBAL or OBJECT variable of the declaration, %G00 to %G99 or a \
                 system variable is expected"
            );
            check.error(place, text);
        }
    }
}

/// Fields that take a value of the same variable at the same time: only the last one would count.
fn check_twins(fields: &[DialogField], named: &[Named], check: &FindingCollector) {
    for (index, field) in fields.iter().enumerate().filter(|(_, field)| !field.variable.is_empty()) {
        let name = &field.variable;
        if field.enabled.as_ref().is_some_and(|(variable, _)| variable.eq_ignore_ascii_case(name)) {
            let place = named.iter().find(|(variable, _, decides)| *decides && variable.eq_ignore_ascii_case(name));
            if let Some((_, place, _)) = place {
                check.error(
                    place,
                    format!("{name} is the variable of this field; a different variable must decide about it"),
                );
            }
        }
        let twin = |other: &&DialogField| other.variable.eq_ignore_ascii_case(name) && other.enabled == field.enabled;
        if fields.iter().take(index).any(|other| twin(&other)) {
            let mut places =
                named.iter().filter(|(variable, _, decides)| !decides && variable.eq_ignore_ascii_case(name));
            if let Some((_, place, _)) = places.next_back() {
                check.error(
                    place,
                    format!("another field of this dialog sets {name} too, but only one of the values can be kept"),
                );
            }
        }
    }
}

/// The word of `kind` of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum FieldWord {
    Label,
    Text,
    Number,
    Check,
    Choice,
}

/// The word of `type` of a button.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ButtonWord {
    Ok,
    Cancel,
    Reset,
    Call,
}

/// Reports keys that a field of its kind ignores.
fn check_keys(row: &TableReader<'_>, kind: FieldWord, given: &[&'static str]) {
    for key in given {
        let (used, wanted) = match *key {
            "min" | "max" | "whole" => (kind == FieldWord::Number, "\"number\""),
            "longest" => (kind == FieldWord::Text, "\"text\""),
            "choices" => (kind == FieldWord::Choice, "\"choice\""),
            _ => (kind != FieldWord::Label, "\"text\", \"number\", \"check\" or \"choice\""),
        };
        if !used {
            row.error(key, format!("`{key}` belongs to a field of kind {wanted}, this one ignores it"));
        }
    }
}

fn read_dialog(
    mut row: TableReader<'_>,
    macros: Option<&Macros>,
    check: &FindingCollector,
) -> Option<(Dialog, DefinitionPlace)> {
    row.require("name", "the name of the dialog");
    let name = row.name("name", 64).map(str::to_owned);
    let title = row.text("title").map(str::to_owned);
    let mut named = Vec::new();
    let fields = row.rows("fields", "a field", MOST);
    let fields: Vec<DialogField> =
        fields.into_iter().filter_map(|field| read_field(field, &mut named, check)).collect();
    check_variables(&fields, &named, macros, check);
    check_twins(&fields, &named, check);
    let mut buttons: Vec<Button> = row.rows("buttons", "a button", MOST).into_iter().filter_map(read_button).collect();
    if buttons.is_empty() {
        buttons.push(Button { label: "OK".into(), kind: ButtonKind::Ok });
        buttons.push(Button { label: "Cancel".into(), kind: ButtonKind::Cancel });
    } else if !buttons.iter().any(|button| button.kind == ButtonKind::Ok) {
        row.error("buttons", "a dialog needs a button of type \"ok\"");
    }
    for (index, button) in buttons.iter().enumerate() {
        if buttons.iter().take(index).any(|other| other.label.eq_ignore_ascii_case(&button.label)) {
            row.error("buttons", format!("two buttons have the label \"{}\", the result of the dialog", button.label));
        }
    }
    let place = row.place_of("name").clone();
    row.finish();
    let name = name?;
    Some((Dialog { title: title.unwrap_or_else(|| name.clone()), name, fields, buttons }, place))
}

fn read_button(mut row: TableReader<'_>) -> Option<Button> {
    row.require("label", "the text on the button");
    let label = row.name("label", 64).map(str::to_owned);
    let words = [
        ("ok", ButtonWord::Ok),
        ("cancel", ButtonWord::Cancel),
        ("reset", ButtonWord::Reset),
        ("call", ButtonWord::Call),
    ];
    let kind = row.choice("type", &words).unwrap_or(ButtonWord::Ok);
    let called = row.name("dialog", 64).map(str::to_owned);
    if called.is_some() != (kind == ButtonWord::Call) {
        row.error("dialog", "`dialog` belongs to a button of type \"call\"");
    }
    row.finish();
    let kind = match (kind, called) {
        (ButtonWord::Cancel, _) => ButtonKind::Cancel,
        (ButtonWord::Reset, _) => ButtonKind::Reset,
        (ButtonWord::Call, Some(dialog)) => ButtonKind::Call(dialog),
        (ButtonWord::Ok, _) | (ButtonWord::Call, None) => ButtonKind::Ok,
    };
    Some(Button { label: label?, kind })
}

fn read_field(mut row: TableReader<'_>, named: &mut Vec<Named>, check: &FindingCollector) -> Option<DialogField> {
    let words = [
        ("label", FieldWord::Label),
        ("text", FieldWord::Text),
        ("number", FieldWord::Number),
        ("check", FieldWord::Check),
        ("choice", FieldWord::Choice),
    ];
    row.require("kind", "\"label\", \"text\", \"number\", \"check\" or \"choice\"");
    let kind = row.choice("kind", &words)?;
    let label = row.text("label").unwrap_or_default().to_owned();
    let variable = row.name("variable", 32).unwrap_or_default().to_owned();
    if variable.is_empty() && kind != FieldWord::Label {
        row.error("kind", "a field needs `variable`, the macro variable that it sets");
    }
    let keys = ["min", "max", "whole", "longest", "choices", "default", "required", "when", "unless", "variable"];
    let given: Vec<&'static str> = keys.into_iter().filter(|key| row.node(key).is_some()).collect();
    check_keys(&row, kind, &given);
    let longest = row.integer("longest", 1..=1000).unwrap_or(250) as usize;
    let (min, max) = (row.number("min").unwrap_or(f64::MIN), row.number("max").unwrap_or(f64::MAX));
    if min > max {
        row.error("max", format!("`max` {max} is less than `min` {min}"));
    }
    let whole = row.flag("whole").unwrap_or(false);
    if whole && min <= max && min.ceil() > max.floor() {
        row.error("whole", format!("no whole number lies from {min} to {max}"));
    }
    let choices = choices(&mut row, check);
    let required = row.flag("required").unwrap_or(false);
    let default = row.node("default").and_then(|node| value(node, check));
    let kind = match kind {
        FieldWord::Label => FieldKind::Label,
        FieldWord::Text => FieldKind::Text { longest },
        FieldWord::Number => FieldKind::Number { min, max, whole },
        FieldWord::Check => FieldKind::Check,
        FieldWord::Choice => FieldKind::Choice(choices),
    };
    if kind == FieldKind::Choice(Vec::new()) {
        row.error("choices", "a choice needs `choices`");
    }
    let when = row.name("when", 32).map(|variable| (variable.to_owned(), true));
    let unless = row.name("unless", 32).map(|variable| (variable.to_owned(), false));
    if when.is_some() && unless.is_some() {
        row.error("unless", "a field has `when` or `unless`, not both");
    }
    if !variable.is_empty() {
        named.push((variable.clone(), row.place_of("variable").clone(), false));
    }
    for (key, decides) in [("when", &when), ("unless", &unless)] {
        named.extend(decides.iter().map(|(variable, _)| (variable.clone(), row.place_of(key).clone(), true)));
    }
    let mut field = DialogField { label, variable, kind, default: None, required, enabled: when.or(unless) };
    match field.accept(default.clone()) {
        Ok(accepted) => field.default = accepted,
        Err(why) if default.is_some() => row.error("default", why),
        Err(_) => {}
    }
    row.finish();
    Some(field)
}

/// Labels, or labels with values of their own: `["soft", { label = "hard", value = 2 }]`.
fn choices(row: &mut TableReader<'_>, check: &FindingCollector) -> Vec<(String, DialogValue)> {
    let mut out = Vec::new();
    for item in row.list("choices").unwrap_or_default() {
        match &item.value {
            node::TomlValue::Table(table) => {
                let mut choice = TableReader::new(table, item.place.clone(), "a choice", check);
                choice.require("label", "the text of the choice");
                let label = choice.text("label").unwrap_or_default().to_owned();
                let value = choice.node("value").and_then(|node| value(node, check));
                choice.finish();
                out.push((label.clone(), value.unwrap_or(DialogValue::Text(label))));
            }
            _ => out.extend(value(item, check).map(|value| (value.to_string(), value))),
        }
        check_choice(&out, item, check);
    }
    out
}

/// The last choice differs from those before it.
fn check_choice(choices: &[(String, DialogValue)], item: &Node, check: &FindingCollector) {
    let Some(((label, value), before)) = choices.split_last() else { return };
    let by_label = |text: &str, value: &DialogValue| matches!(value, DialogValue::Text(other) if other == text);
    if before.iter().any(|(other, _)| other == label) {
        check.error(&item.place, format!("another choice of this field has the label \"{label}\""));
    } else if let Some((other, _)) = before.iter().find(|(_, known)| known == value) {
        let text =
            format!("the choices \"{other}\" and \"{label}\" have the same value {value}: the first one is shown");
        check.warning(&item.place, text);
    } else if let Some((other, _)) =
        before.iter().find(|(other, known)| by_label(other, value) || by_label(label, known))
    {
        let text =
            format!("what is the value of one of the choices \"{other}\" and \"{label}\" is the label of the other");
        check.warning(&item.place, text);
    }
}

fn value(node: &Node, check: &FindingCollector) -> Option<DialogValue> {
    match &node.value {
        node::TomlValue::Text(text) => Some(DialogValue::Text(text.clone())),
        node::TomlValue::Integer(number) => Some(DialogValue::Number(*number as f64)),
        node::TomlValue::Float(number) if number.is_finite() => Some(DialogValue::Number(*number)),
        node::TomlValue::Flag(flag) => Some(DialogValue::Flag(*flag)),
        other => {
            check.error(&node.place, format!("expected a text, a number, true or false, not {}", other.kind()));
            None
        }
    }
}
