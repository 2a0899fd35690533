//! Options as a configuration file with a comment for each option.
//!
//! *Invariant:* the comments are the help texts of the flags, so every option with a flag has a comment. Reading the
//! file gives the same options.

use clap::Args as _;
use toml_edit::{DocumentMut, Item};

use super::{ServerFlags, ServerOptions};

/// Columns of a comment.
const WIDTH: usize = 100;
/// Comments of the tables, which have no flags.
const TABLES: [(&str, &str); 2] = [
    (
        "tenants",
        "Different quotas and retention of single tenants, each in a table [tenants.NAME]. Options must stand above all \
         tables",
    ),
    (
        "webhooks",
        "Targets that are notified when jobs end, each in a table [webhooks.NAME]. Options must stand above all tables",
    ),
];

impl ServerOptions {
    /// The options as a configuration file that explains them.
    #[must_use]
    pub fn to_commented_toml(&self) -> String {
        let plain = self.to_toml();
        let Ok(mut document) = plain.parse::<DocumentMut>() else { return plain };
        let flags = ServerFlags::augment_args(clap::Command::new("counterpointd"));
        // A line `[webhooks]` would make options that are appended to the file part of the table.
        let empty = |name: &&str| document.get(name).and_then(Item::as_table).is_some_and(toml_edit::Table::is_empty);
        let empty: Vec<&str> = TABLES.map(|(name, _)| name).into_iter().filter(empty).collect();
        empty.iter().for_each(|name| drop(document.remove(name)));
        for (mut key, item) in document.iter_mut() {
            let Some(text) = help(&flags, &key) else { continue };
            let comment = comment(&text);
            match item {
                Item::Table(table) => table.decor_mut().set_prefix(comment),
                _ => key.leaf_decor_mut().set_prefix(comment),
            }
        }
        let text = document.to_string().trim_start().to_owned();
        let absent =
            empty.iter().filter_map(|name| Some(format!("{}# [{name}.NAME]\n", comment(&help(&flags, name)?))));
        absent.fold(text, |text, table| text + &table)
    }
}

/// The help text of an option or a table.
fn help(flags: &clap::Command, name: &str) -> Option<String> {
    if let Some((_, text)) = TABLES.iter().find(|(table, _)| *table == name) {
        return Some((*text).to_owned());
    }
    let flag = flags.get_arguments().find(|flag| flag.get_id() == name)?;
    flag.get_help().map(ToString::to_string)
}

/// An empty line, then the text in lines that begin with `#`.
fn comment(text: &str) -> String {
    let mut lines = vec![String::from("#")];
    for word in text.split_whitespace() {
        if lines.last().is_some_and(|line| line.len() + 1 + word.len() > WIDTH) {
            lines.push(String::from("#"));
        }
        if let Some(line) = lines.last_mut() {
            line.push(' ');
            line.push_str(word);
        }
    }
    format!("\n{}\n", lines.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::{Tenant, Webhook};

    #[test]
    fn every_option_has_a_comment_and_reads_back_the_same() {
        let mut options = ServerOptions { queue: 7, ..ServerOptions::default() };
        options.guard.grpc_web_origins = "a\nqueue = 3\n".to_owned();
        options.tables.tenants.insert("cell".to_owned(), Tenant { queued: Some(9), ..Tenant::default() });
        let hook = Webhook {
            url: "https://mes.example".to_owned(),
            secret_file: "secret".into(),
            tenants: vec!["*".to_owned()],
            states: Vec::new(),
            ca_file: None,
        };
        options.tables.webhooks.insert("mes".to_owned(), hook);
        let text = options.to_commented_toml();
        assert_eq!(ServerOptions::parse(&text).unwrap(), options, "{text}");
        assert!(text.starts_with("# Address to listen on; port 0 = any free port\nlisten = "), "{text}");

        let text = ServerOptions::default().to_commented_toml();
        let lines: Vec<&str> = text.lines().collect();
        let options: toml::Table = ServerOptions::default().to_toml().parse().unwrap();
        for name in options.keys() {
            let begins = |line: &&str| line.starts_with(&format!("{name} = ")) || **line == format!("# [{name}.NAME]");
            let at = lines.iter().position(begins).unwrap_or_else(|| panic!("{name}: {text}"));
            assert!(lines[at - 1].starts_with("# "), "{name} has no comment: {text}");
        }
        assert!(lines.iter().all(|line| line.len() <= WIDTH), "{text}");
        // Options and tables may be appended.
        let more = format!("{text}[tenants.cell]\nqueued = 9\n");
        assert_eq!(ServerOptions::parse(&more).unwrap().tables.tenants["cell"].queued, Some(9));
        assert!(text.contains("\n# Format of the log on standard error: text or json\nlog_format"), "{text}");
    }
}
