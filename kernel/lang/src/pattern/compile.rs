//! From the text of an expression to steps.

use super::{CharClass, CharSet, FIRST_LOOP, MAX_PROGRAM, PatternStep, TextPattern};
use crate::diag::DiagnosticNumber;
use crate::fault::{MacroFault, Outcome};

struct PatternCompiler {
    text: Vec<char>,
    at: usize,
    steps: Vec<PatternStep>,
    /// Open groups: number and position of their first step.
    open: Vec<(usize, usize)>,
    groups: usize,
    closed: [bool; 10],
    slots: usize,
}

fn bad<T>(message: &str) -> Outcome<T> {
    Err(MacroFault::new(DiagnosticNumber::BAD_PATTERN, message))
}

pub(super) fn compile(text: &str) -> Outcome<TextPattern> {
    if text.len() > MAX_PROGRAM {
        return bad("this regular expression is too large");
    }
    let mut compiler = PatternCompiler {
        text: text.chars().collect(),
        at: 0,
        steps: vec![PatternStep::Save(0)],
        open: Vec::new(),
        groups: 0,
        closed: [false; 10],
        slots: FIRST_LOOP,
    };
    if compiler.eat('^') {
        compiler.steps.push(PatternStep::Start);
    }
    // First step of the item that a repetition would repeat.
    let mut item: Option<usize> = None;
    while let Some(character) = compiler.next() {
        item = compiler.item(character, item)?;
        if compiler.steps.len() > MAX_PROGRAM {
            return bad("this regular expression is too large");
        }
    }
    if !compiler.open.is_empty() {
        return bad("a `\\(` has no `\\)`");
    }
    compiler.steps.push(PatternStep::Save(1));
    compiler.steps.push(PatternStep::Done);
    let anchored = compiler.steps.get(1) == Some(&PatternStep::Start);
    let first = match compiler.steps.iter().find(|step| !matches!(step, PatternStep::Save(_))) {
        Some(PatternStep::One(class) | PatternStep::Run(class, 1.., _)) => Some(class.clone()),
        _ => None,
    };
    Ok(TextPattern { steps: compiler.steps, slots: compiler.slots, groups: compiler.groups, first, anchored })
}

impl PatternCompiler {
    fn next(&mut self) -> Option<char> {
        let character = self.text.get(self.at).copied()?;
        self.at += 1;
        Some(character)
    }

    fn eat(&mut self, wanted: char) -> bool {
        let found = self.text.get(self.at) == Some(&wanted);
        self.at += usize::from(found);
        found
    }

    fn item(&mut self, character: char, before: Option<usize>) -> Outcome<Option<usize>> {
        let start = self.steps.len();
        match character {
            '*' if before.is_some() => {
                self.repeat(before.unwrap_or(start), 0, u32::MAX)?;
                return Ok(None);
            }
            '.' => self.steps.push(PatternStep::One(CharClass::Any)),
            '[' => {
                let set = self.set()?;
                self.steps.push(PatternStep::One(set));
            }
            '$' if self.at == self.text.len() => {
                self.steps.push(PatternStep::End);
                return Ok(None);
            }
            '\\' => return self.escape(before, start),
            other => self.steps.push(PatternStep::One(CharClass::One(other))),
        }
        Ok(Some(start))
    }

    fn escape(&mut self, before: Option<usize>, start: usize) -> Outcome<Option<usize>> {
        match self.next() {
            None => bad("a regular expression cannot end with `\\`"),
            Some('<') => {
                self.steps.push(PatternStep::WordStart);
                Ok(None)
            }
            Some('>') => {
                self.steps.push(PatternStep::WordEnd);
                Ok(None)
            }
            Some('(') => {
                self.groups += 1;
                if self.groups > 9 {
                    return bad("more than nine groups");
                }
                self.open.push((self.groups, start));
                self.steps.push(PatternStep::Save(2 * self.groups));
                Ok(None)
            }
            Some(')') => {
                let Some((number, start)) = self.open.pop() else { return bad("a `\\)` has no `\\(`") };
                if let Some(closed) = self.closed.get_mut(number) {
                    *closed = true;
                }
                self.steps.push(PatternStep::Save(2 * number + 1));
                Ok(Some(start))
            }
            Some('{') => {
                let (least, most) = self.bounds()?;
                let Some(item) = before else { return bad("there is nothing before this `\\{`") };
                self.repeat(item, least, most)?;
                Ok(None)
            }
            Some('}') => bad("a `\\}` has no `\\{`"),
            Some('0') => {
                self.steps.push(PatternStep::One(CharClass::One('0')));
                Ok(Some(start))
            }
            Some(digit @ '1'..='9') => {
                let number = digit.to_digit(10).map_or(0, |digit| digit as usize);
                if self.closed.get(number) != Some(&true) {
                    return bad("a back reference must follow its group");
                }
                self.steps.push(PatternStep::Reference(number));
                Ok(Some(start))
            }
            Some(other) => {
                self.steps.push(PatternStep::One(CharClass::One(other)));
                Ok(Some(start))
            }
        }
    }

    fn bounds(&mut self) -> Outcome<(u32, u32)> {
        let least = self.bound()?;
        let most = if self.eat(',') {
            if self.text.get(self.at) == Some(&'\\') { Some(u32::MAX) } else { self.bound()? }
        } else {
            least
        };
        match (least, most) {
            (Some(least), Some(most)) if least <= most && self.eat('\\') && self.eat('}') => Ok((least, most)),
            _ => bad("repetitions are written `\\{m\\}`, `\\{m,\\}` or `\\{m,n\\}`"),
        }
    }

    fn bound(&mut self) -> Outcome<Option<u32>> {
        let mut number: Option<u32> = None;
        while let Some(digit) = self.text.get(self.at).and_then(|c| c.to_digit(10)) {
            self.at += 1;
            let value = number.unwrap_or(0) * 10 + digit;
            if value > 255 {
                return bad("more than 255 repetitions");
            }
            number = Some(value);
        }
        Ok(number)
    }

    fn set(&mut self) -> Outcome<CharClass> {
        let negated = self.eat('^');
        let mut ranges = Vec::new();
        let mut first = true;
        loop {
            let Some(low) = self.next() else { return bad("a `[` has no `]`") };
            if low == ']' && !first {
                return Ok(CharClass::Set(Box::new(CharSet::new(ranges, negated))));
            }
            first = false;
            let dash = self.text.get(self.at) == Some(&'-');
            match self.text.get(self.at + 1).copied() {
                Some(high) if dash && high != ']' => {
                    self.at += 2;
                    if high < low {
                        return bad("a range in a set runs backwards");
                    }
                    ranges.push((low, high));
                }
                _ => ranges.push((low, low)),
            }
        }
    }

    fn repeat(&mut self, start: usize, least: u32, most: u32) -> Outcome<()> {
        let body: Vec<PatternStep> = self.steps.split_off(start.min(self.steps.len()));
        if let [PatternStep::One(class)] = body.as_slice() {
            self.steps.push(PatternStep::Run(class.clone(), least, most));
            return Ok(());
        }
        let copies = if most == u32::MAX { least + 1 } else { most };
        let ranges: usize = body.iter().map(PatternStep::size).sum();
        if (body.len() + ranges / 8).saturating_mul(copies as usize) > MAX_PROGRAM {
            return bad("this regular expression is too large");
        }
        for _ in 0..least {
            self.copy(&body, start);
        }
        if most == u32::MAX {
            let slot = self.slots;
            self.slots += 1;
            let begin = self.steps.len();
            self.steps.push(PatternStep::Split(begin + body.len() + 4));
            self.steps.push(PatternStep::Mark(slot));
            self.copy(&body, start);
            self.steps.push(PatternStep::Moved(slot));
            self.steps.push(PatternStep::Jump(begin));
        } else {
            let end = self.steps.len() + (most - least) as usize * (body.len() + 1);
            for _ in least..most {
                self.steps.push(PatternStep::Split(end));
                self.copy(&body, start);
            }
        }
        Ok(())
    }

    /// Appends a copy of steps that were compiled at `from`, moving the targets of their jumps.
    fn copy(&mut self, body: &[PatternStep], from: usize) {
        let here = self.steps.len();
        let moved = |target: usize| target - from + here;
        self.steps.extend(body.iter().map(|step| match step {
            PatternStep::Split(target) => PatternStep::Split(moved(*target)),
            PatternStep::Jump(target) => PatternStep::Jump(moved(*target)),
            other => other.clone(),
        }));
    }
}
