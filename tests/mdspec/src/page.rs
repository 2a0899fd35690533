//! A page: its machine, its examples, and the fences of each with their positions.
//!
//! *Invariant:* every fence of a page belongs to one example, or the page is refused with the line that is wrong.

use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};

use pulldown_cmark::{CodeBlockKind, Event, HeadingLevel, Parser, Tag, TagEnd};

use crate::marks::Marked;

/// Role of a fence in its example.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Prepares the example: a machine, a macro of it. After a program it begins the next example.
    Setup,
    /// The program to run. A second one starts the next example, unless it is numbered from 2 (`nc 2`).
    Program,
    /// Input of a run besides its program: options, further files.
    Input,
    /// The output.
    Outcome,
}

/// The fences that pages of a kind may have: first word and role.
pub type Fences = &'static [(&'static str, Role)];

/// Errors in a page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Line of the page.
    pub line: usize,
    /// The error.
    pub text: String,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}: {}", self.line, self.text)
    }
}

/// A name and the line it is written in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Named {
    /// The name.
    pub name: String,
    /// Line of the page.
    pub line: usize,
}

/// A fence.
#[derive(Debug, Clone)]
pub struct Fence {
    /// First word after the backquotes.
    pub kind: String,
    /// The words after it, joined by a space.
    pub words: String,
    /// Line of the backquotes.
    pub line: usize,
    /// The text, with the expectations beside its lines taken off.
    pub body: Marked,
    /// Bytes of the body in the page.
    pub range: Range<usize>,
    /// Bytes of the whole fence, its last line included.
    pub whole: Range<usize>,
    /// The last line of prose before the fence.
    pub above: String,
}

/// An example.
#[derive(Debug, Clone)]
pub struct Example {
    /// The page, the heading, and a number from the second example of a heading.
    pub name: String,
    /// Line of its first fence.
    pub line: usize,
    /// The machine written last before it in its section, otherwise that of the page, which is the first one of its
    /// head.
    pub machine: Option<Named>,
    /// Its fences in order.
    pub fences: Vec<Fence>,
}

impl Example {
    /// The fence of this kind.
    #[must_use]
    pub fn fence(&self, kind: &str) -> Option<&Fence> {
        self.fences.iter().find(|fence| fence.kind == kind)
    }

    /// The fences of this kind.
    pub fn all<'a>(&'a self, kind: &'a str) -> impl Iterator<Item = &'a Fence> {
        self.fences.iter().filter(move |fence| fence.kind == kind)
    }

    /// The text of the fence of this kind, empty without one.
    #[must_use]
    pub fn text(&self, kind: &str) -> &str {
        self.fence(kind).map_or("", |fence| &fence.body.text)
    }
}

/// A page.
#[derive(Debug, Clone)]
pub struct Page {
    /// Its file.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
    /// Its examples in order.
    pub examples: Vec<Example>,
}

impl Page {
    /// Reads a page from its file.
    ///
    /// # Errors
    /// When the file cannot be read, or when it has a fence that is unknown, indented, not closed, or without a
    /// program.
    pub fn read(path: &Path, fences: Fences) -> Result<Self, Fault> {
        let text = std::fs::read_to_string(path).map_err(|error| Fault { line: 0, text: error.to_string() })?;
        Self::parse(path, &text, fences)
    }

    /// Reads a page from its text.
    ///
    /// # Errors
    /// When it has a fence that is unknown, indented, not closed, or without a program.
    pub fn parse(path: &Path, text: &str, fences: Fences) -> Result<Self, Fault> {
        let mut reader = Reader {
            stem: path.file_stem().unwrap_or_default().to_string_lossy().into_owned(),
            fences,
            examples: Vec::new(),
            heading: String::new(),
            in_section: 0,
            begins: true,
            page_machine: None,
            machine: None,
            above: String::new(),
        };
        let mut heading: Option<(HeadingLevel, String)> = None;
        for (event, range) in Parser::new(text).into_offset_iter() {
            let line = text.get(..range.start).map_or(0, |before| before.matches('\n').count()) + 1;
            match event {
                Event::Start(Tag::Heading { level, .. }) => heading = Some((level, String::new())),
                Event::Text(words) | Event::Code(words) => {
                    if let Some((_, title)) = &mut heading {
                        title.push_str(&words);
                    }
                }
                Event::End(TagEnd::Heading(_)) => {
                    if let Some((level, title)) = heading.take() {
                        reader.heading(level, &title);
                    }
                }
                Event::Start(Tag::Paragraph) => reader.paragraph(text.get(range).unwrap_or_default().trim_end(), line),
                Event::Start(Tag::CodeBlock(CodeBlockKind::Fenced(info))) if !info.trim().is_empty() => {
                    let fence = fence(text, range, info.trim(), line, std::mem::take(&mut reader.above))?;
                    reader.fence(fence)?;
                }
                _ => {}
            }
        }
        reader.finish()?;
        Ok(Self { path: path.to_owned(), text: text.to_owned(), examples: reader.examples })
    }
}

/// A fence with its positions.
fn fence(text: &str, range: Range<usize>, info: &str, line: usize, above: String) -> Result<Fence, Fault> {
    let fault = |words: &str| Fault { line, text: format!("fence '{info}' {words}") };
    if range.start > 0 && text.as_bytes().get(range.start - 1) != Some(&b'\n') {
        return Err(fault("is indented: begin it in the first column"));
    }
    let inside = text.get(range.clone()).unwrap_or_default();
    let first = inside.find('\n').map_or(inside.len(), |end| end + 1);
    let trimmed = inside.trim_end();
    let last = trimmed.rfind('\n').map_or(0, |end| end + 1);
    if last < first || !trimmed.get(last..).is_some_and(|end| end.starts_with("```")) {
        return Err(fault("is not closed"));
    }
    let body = range.start + first..range.start + last;
    let end = range.start + trimmed.len();
    let end = end + usize::from(text.as_bytes().get(end) == Some(&b'\n'));
    let (kind, words) = info.split_once(' ').unwrap_or((info, ""));
    Ok(Fence {
        kind: kind.to_owned(),
        words: words.trim().to_owned(),
        line,
        body: Marked::split(text.get(body.clone()).unwrap_or_default()),
        range: body,
        whole: range.start..end,
        above,
    })
}

struct Reader {
    stem: String,
    fences: Fences,
    examples: Vec<Example>,
    heading: String,
    /// Examples of this section up to now.
    in_section: usize,
    /// The next fence begins an example.
    begins: bool,
    page_machine: Option<Named>,
    machine: Option<Named>,
    above: String,
}

impl Reader {
    fn heading(&mut self, level: HeadingLevel, title: &str) {
        if level == HeadingLevel::H1 {
            return;
        }
        self.heading = slug(title);
        (self.in_section, self.begins) = (0, true);
        self.machine.clone_from(&self.page_machine);
    }

    fn paragraph(&mut self, text: &str, line: usize) {
        self.above = text.lines().last().unwrap_or_default().to_owned();
        let Some(name) = text.strip_prefix("machine: ").filter(|name| !name.contains(char::is_whitespace)) else {
            return;
        };
        self.machine = Some(Named { name: name.to_owned(), line });
        if self.heading.is_empty() && self.page_machine.is_none() {
            self.page_machine.clone_from(&self.machine);
        }
    }

    fn fence(&mut self, fence: Fence) -> Result<(), Fault> {
        let Some((_, role)) = self.fences.iter().find(|(kind, _)| *kind == fence.kind) else {
            let known: Vec<&str> = self.fences.iter().map(|(kind, _)| *kind).collect();
            let text = format!("no fence is called '{}'; known are: {}", fence.kind, known.join(", "));
            return Err(Fault { line: fence.line, text });
        };
        let role_of = |fence: &Fence| self.fences.iter().find(|(kind, _)| *kind == fence.kind).map(|(_, role)| *role);
        let ready = |example: &Example| {
            example.fences.iter().any(|fence| matches!(role_of(fence), Some(Role::Program | Role::Outcome)))
        };
        let further = fence.words.split(' ').next().and_then(|word| word.parse().ok()).is_some_and(|n: u16| n > 1);
        let next = match role {
            Role::Setup => self.examples.last().is_some_and(ready),
            Role::Program => !further && self.examples.last().is_some_and(ready),
            Role::Input | Role::Outcome => false,
        };
        if self.begins || next {
            self.finish()?;
            self.begins = false;
            self.in_section += 1;
            let heading = if self.heading.is_empty() { String::new() } else { format!("::{}", self.heading) };
            let number = if self.in_section > 1 || heading.is_empty() {
                format!("::{}", self.in_section)
            } else {
                String::new()
            };
            let name = format!("{}{heading}{number}", self.stem);
            let machine = self.machine.clone();
            self.examples.push(Example { name, line: fence.line, machine, fences: Vec::new() });
        }
        if let Some(example) = self.examples.last_mut() {
            example.fences.push(fence);
        }
        Ok(())
    }

    /// The example that ends here has something to run or to look at.
    fn finish(&self) -> Result<(), Fault> {
        let Some((example, earlier)) = self.examples.split_last() else { return Ok(()) };
        if earlier.iter().any(|other| other.name == example.name) {
            let text = format!("another example is called {}: give the sections different headings", example.name);
            return Err(Fault { line: example.line, text });
        }
        let whole = example.fences.iter().any(|fence| {
            let role = self.fences.iter().find(|(kind, _)| *kind == fence.kind).map(|(_, role)| *role);
            matches!(role, Some(Role::Program | Role::Setup))
        });
        if whole {
            return Ok(());
        }
        Err(Fault {
            line: example.line,
            text: "this example has no program: put one before what is expected".to_owned(),
        })
    }
}

/// A heading as part of a name: words joined by hyphens.
fn slug(title: &str) -> String {
    let words = title.split(|c: char| !c.is_alphanumeric() && !matches!(c, '.' | '$' | '_' | '#'));
    let words = words.map(|word| word.trim_end_matches('.')).filter(|word| !word.is_empty());
    words.collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{Fault, Fences, Page, Role};

    const FENCES: Fences =
        &[("toml", Role::Setup), ("nc", Role::Program), ("options", Role::Input), ("events", Role::Outcome)];

    fn page(text: &str) -> Result<Page, Fault> {
        Page::parse(Path::new("cycles.md"), text, FENCES)
    }

    const TEXT: &str = "# Cycles\n\nmachine: mill\n\nProse.\n\n## G83 with `Q`\n\n```toml add\na = 1\n```\n\n```nc\nG83\n```\n\n\
        ```nc 2\nG4\n```\n\n```events\nrapid\n```\n\n```nc\nG1   ← warning no-feed\n```\n\n## Lathe\n\nmachine: lathe\n\n```nc\n```\n";

    #[test]
    fn examples_have_names_machines_and_fences() {
        let page = page(TEXT).unwrap();
        let names: Vec<_> = page.examples.iter().map(|example| example.name.as_str()).collect();
        assert_eq!(names, ["cycles::G83-with-Q", "cycles::G83-with-Q::2", "cycles::Lathe"]);
        let machines: Vec<_> = page.examples.iter().map(|example| &example.machine.as_ref().unwrap().name).collect();
        assert_eq!(machines, ["mill", "mill", "lathe"]);
        assert_eq!(page.examples[0].fences.len(), 4);
        assert_eq!(page.examples[0].fences[0].words, "add");
        assert_eq!(page.examples[1].text("nc"), "G1\n");
        let events = page.examples[0].fence("events").unwrap();
        assert_eq!((events.line, &page.text[events.range.clone()]), (21, "rapid\n"));
        assert_eq!(page.examples[2].text("nc"), "");
    }

    #[test]
    fn what_is_wrong_names_its_line() {
        let wrong = |text: &str| page(text).unwrap_err().to_string();
        assert_eq!(
            wrong("# A\n\n```ncc\nG1\n```\n"),
            "line 3: no fence is called 'ncc'; known are: toml, nc, options, events"
        );
        assert_eq!(
            wrong("\n```events\nrapid\n```\n"),
            "line 2: this example has no program: put one before what is expected"
        );
        assert_eq!(
            wrong("* x\n\n  ```nc\n  G1\n  ```\n"),
            "line 3: fence 'nc' is indented: begin it in the first column"
        );
        assert_eq!(wrong("```nc\nG1\n"), "line 1: fence 'nc' is not closed");
    }
}
