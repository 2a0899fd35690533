//! `explain` and `macro explain`: the meaning of a number or a name.
//!
//! *Invariant:* all answers come from the pages of the diagnostics and from the tables that the checker itself uses.

use counterpoint_kernel::diag;
use counterpoint_kernel::machine::ident::{self as control, takes};
use counterpoint_kernel::machine::macros::{identifiers, system, without};
use counterpoint_lang::explain::{self, ExplainEntry};
use counterpoint_lang::func::{self, EvaluationMethod};
use counterpoint_lang::host::HostFn;
use counterpoint_lang::{format, ident};
use include_dir::{Dir, include_dir};

use super::alarms::listed;
use super::kinds::kind;
use super::links::without_links;
use super::terms::terms;
use crate::error::Error;
use crate::say;

static PAGES: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../docs/diagnostics");

/// Prints the explanation of a number or a name.
pub(crate) fn explain(what: &str) -> Result<u8, Error> {
    let text = explanation(what).ok_or_else(|| Error::Usage(unknown(what)))?;
    say::data(text.as_bytes())?;
    Ok(0)
}

/// The explanation of a number or a name.
pub(crate) fn explanation(what: &str) -> Option<String> {
    // A word such as CYCLE may name a kind of macro, too.
    let names = || match (kind(what), named(what)) {
        (Some(kind), Some(name)) => Some(format!("{kind}\n{name}")),
        (kind, name) => kind.or(name),
    };
    page(what).or_else(names).or_else(|| alarm(what))
}

/// The pages of a diagnostic or of an alarm.
pub(crate) fn diagnostic(what: &str) -> Option<String> {
    page(what).or_else(|| alarm(what))
}

/// The page of a number or of its word.
pub(super) fn page(what: &str) -> Option<String> {
    let number = what.trim().parse().ok().or_else(|| diag::number(&what.trim().to_lowercase().replace('_', "-")))?;
    PAGES.get_file(format!("{number:08}.md"))?.contents_utf8().map(str::to_owned)
}

/// Letters of alarms whose number may be alone.
const ALARMS: &[&str] = &["PS", "SR", "SW", "SV", "SP", "OT", "OH", "IO", "PW", "BG", "DS", "IE", "EX"];

/// Letters and number of an alarm of a control: two to four letters, or none in short.
fn alarm_name(word: &str) -> Option<(&str, u32)> {
    let (letters, digits) = word.split_at_checked(word.bytes().take_while(u8::is_ascii_alphabetic).count())?;
    let plain = letters.len() != 1 && letters.len() <= 4 && digits.bytes().all(|byte| byte.is_ascii_digit());
    Some((letters, digits.parse().ok().filter(|_| plain)?))
}

/// The rows of the list of alarms that name an alarm, and the pages of all diagnostics that raise it. Zeros before the
/// number may be left out, and so may the letters.
fn alarm(what: &str) -> Option<String> {
    let word = what.trim().to_uppercase().replace('/', "");
    let asked = alarm_name(&word);
    let is = |one: &str| asked.is_some_and(|asked| is_alarm(asked, one));
    // A number of a page without its prefix does not name an alarm.
    let is_named = |one: &str| one.starts_with(|c: char| c.is_ascii_alphabetic()) && is(one);
    let (rows, numbers) = listed(&word, is);
    let listed: Vec<&str> =
        numbers.iter().filter_map(|number| PAGES.get_file(format!("{number:08}.md"))?.contents_utf8()).collect();
    let names = |text: &str| text.split(|c: char| !c.is_ascii_alphanumeric()).any(is_named);
    let named = PAGES
        .files()
        .filter(|file| file.path().file_stem().is_some_and(|stem| stem != "README"))
        .filter_map(|file| file.contents_utf8())
        .filter(|text| names(text) && !listed.contains(text));
    let rows: String = rows.iter().map(|row| format!("{row}\n\n")).collect();
    let pages: Vec<&str> = listed.iter().copied().chain(named).collect();
    let text = format!("{rows}{}", pages.join("\n"));
    (!text.is_empty()).then_some(text)
}

/// Whether a word names the alarm that is requested, in capitals.
fn is_alarm((letters, number): (&str, u32), one: &str) -> bool {
    alarm_name(one).is_some_and(|(of, known)| {
        let same =
            if letters.is_empty() { of.is_empty() && number > 999 || ALARMS.contains(&of) } else { of == letters };
        same && known == number
    })
}

/// The first sentence of the remedy on a diagnostic's page, without links; `None` if no remedy is needed.
pub(crate) fn remedy(number: u32) -> Option<String> {
    let page = PAGES.get_file(format!("{number:08}.md"))?.contents_utf8()?;
    let (_, text) = page.split_once("**Remedy.** ")?;
    let text = text.split("\n\n").next()?.trim_end().replace('\n', " ");
    let first = text.split_once(". ").map_or(&*text, |(first, _)| first).trim_end_matches('.');
    (!first.starts_with("None needed")).then(|| without_links(first))
}

/// The remedy for a kind of verdict: the item of that kind in the list on the page, else the remedy for all kinds.
pub(crate) fn remedy_for(number: u32, kind: &str) -> Option<String> {
    let page = PAGES.get_file(format!("{number:08}.md")).and_then(|file| file.contents_utf8())?;
    let quoted = format!("`{kind}`");
    let of_kind = page.split("\n* ").skip(1).find_map(|item| {
        let item = item.split("\n\n").next()?.trim_end().replace('\n', " ");
        let (kinds, text) = item.split_once(": ")?;
        kinds.split(", ").any(|one| one == quoted).then(|| text.trim_end_matches('.').to_owned())
    });
    of_kind.or_else(|| remedy(number))
}

/// The name in upper case, as the tables write it; a function or variable also without its dollar sign.
fn named(what: &str) -> Option<String> {
    let bare = what.trim();
    if !bare.starts_with(|c: char| c.is_ascii_alphabetic())
        && let Some(text) = terms(bare)
    {
        return Some(text);
    }
    let name = what.trim().trim_end_matches(['/', '(', ')']).to_uppercase();
    let dollar = format!("${name}");
    let word = || word(&name);
    statement(&name)
        .or_else(|| function(&name))
        .or_else(|| variable(&name))
        .or_else(|| identifier(&name))
        .or_else(|| keyword(&name))
        .or_else(word)
        .or_else(|| function(&dollar))
        .or_else(|| variable(&dollar))
}

fn entry(entry: &ExplainEntry) -> String {
    let result = entry.result.map(|result| format!("gives: {result}\n")).unwrap_or_default();
    format!("{}\n{result}\n{}\n", entry.form, entry.about)
}

fn statement(name: &str) -> Option<String> {
    explain::statements().iter().find(|entry| entry.name == name).map(entry)
}

fn function(name: &str) -> Option<String> {
    let way = func::named(name).map(|function| function.way);
    if let Some(EvaluationMethod::Missing(why)) = way {
        return Some(format!("{name}\n\nNot available in macros of the control emulator: {why}.\n"));
    }
    let text = explain::functions().iter().find(|entry| entry.name == name).map(entry)?;
    Some(match way {
        Some(EvaluationMethod::Host(HostFn::Absent(function))) => {
            let why = without::why(function);
            format!(
                "{text}\nThe function {why}: it reports this once in a run (2910070) and returns the result of a failed call.\n"
            )
        }
        _ => text,
    })
}

fn variable(name: &str) -> Option<String> {
    if let Some(product) = system::product_of(name) {
        return Some(format!("{name}\n\nThe control emulator has no such variable: it belongs to {product}.\n"));
    }
    let variable = system::find(name)?;
    let kind = variable.kind.map_or("any type", counterpoint_lang::value::ValueType::name);
    let access = match variable.access {
        system::ControlVariableAccess::Read => "read only",
        system::ControlVariableAccess::Write => "can be assigned",
        system::ControlVariableAccess::Start => "can be assigned until the machine startup macro ends",
    };
    let range = match variable.range {
        Some((low, high)) => format!(", {low} to {high}"),
        None => String::new(),
    };
    let category = variable.category;
    let model =
        if category == "model" { "\nMachine models are not emulated: only macros change this variable.\n" } else { "" };
    Some(format!("{}\n{kind}{range}, {access} ({category})\n\n{}\n{model}", variable.form(), variable.about))
}

fn identifier(name: &str) -> Option<String> {
    let built_in = |built_in: bool| if built_in { "a built-in action" } else { "no built-in action" };
    if let Some(facts) = control::code(name).and_then(control::code_facts) {
        let group = if facts.group == 0 { "no modal group".to_owned() } else { format!("modal group {}", facts.group) };
        let data = list("Uses", &takes::data_of(facts.name));
        return Some(format!(
            "{}\n\nCode with {group}, order {}, {}.\n{data}",
            facts.name,
            facts.order,
            built_in(facts.built_in)
        ));
    }
    let facts = control::data(name).and_then(control::data_facts)?;
    let codes = list("Used by", &takes::codes_of(facts.name));
    Some(format!("{}\n\nData with {}.\n{codes}", facts.name, built_in(facts.built_in)))
}

fn list(what: &str, names: &[&str]) -> String {
    if names.is_empty() { String::new() } else { format!("{what} {}.\n", names.join(", ")) }
}

/// A word of statements; as a minor word it may be a value, too.
fn keyword(name: &str) -> Option<String> {
    let text = terms(name)?;
    Some(match word(name) {
        Some(word) => format!("{text}\n{word}"),
        None => text,
    })
}

fn word(name: &str) -> Option<String> {
    if let Some(code) = ident::minor_code(name) {
        return Some(format!("{name}\n\nMinor word, a keyword; its code is {code}, so it can be written #{code}.\n"));
    }
    let code = ident::major_code(name)?;
    let class = ident::MAJOR_CLASS;
    Some(format!("{name}\n\nMajor word, a record of the post-processor product; it can be written #{class}:{code}.\n"))
}

/// The message for an unknown name.
pub(crate) fn unknown(what: &str) -> String {
    let name = what.trim().to_uppercase();
    if let Ok(number) = name.parse::<f64>() {
        return format!("diagnostic {} not found", format::wildcard_text(number));
    }
    let with_dollar = [name.clone(), format!("${name}")];
    let entries = explain::functions().iter().chain(explain::statements()).map(|entry| entry.name);
    let variables = system::table().iter().map(|variable| variable.name.as_str());
    let names: Vec<&str> = entries.chain(variables).chain(identifiers::names()).collect();
    let near = with_dollar.iter().find_map(|name| ident::nearest(name, names.iter().copied()));
    let word = name.to_lowercase().replace('_', "-");
    let diagnostic = || ident::nearest(&word, diag::ALL.iter().map(|facts| facts.name));
    let near = near.or_else(diagnostic);
    match near {
        Some(near) => format!("'{what}' not found; did you mean {near}?"),
        None => format!("'{what}' not found"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_there_is_can_be_explained() {
        for row in counterpoint_lang::diag::TABLE {
            assert!(page(row.name).is_some(), "{}", row.name);
            assert_eq!(page(&row.number.to_string()), page(row.name));
        }
        for facts in diag::ALL {
            assert_eq!(page(&facts.number.to_string()), page(facts.name));
            assert!(page(&facts.number.to_string()).is_some(), "{}", facts.number);
            let none = page(&facts.number.to_string()).is_some_and(|text| text.contains("**Remedy.** None needed"));
            let advice = remedy(facts.number);
            assert!(advice.as_ref().map_or(none, |text| text.len() > 5), "{}", facts.number);
            assert!(!advice.is_some_and(|text| text.contains("](")), "{}: a link in plain text", facts.number);
        }
        let functions = func::all().map(|function| function.name);
        let statements = counterpoint_lang::parse::COMMANDS.iter().copied();
        let variables = system::table().iter().map(|variable| variable.name.as_str());
        for name in functions.chain(statements).chain(variables).chain(identifiers::names()) {
            assert!(named(name).is_some_and(|text| text.contains(name.trim_start_matches('$'))), "{name}");
        }
    }
}
