//! Every operator into every kind of target from every kind of operand, against another way of computing it.
//!
//! The expected values are computed in `values.rs`, without the language. `every_operator_goes_everywhere` is a fixed
//! set; `trees_are_what_their_steps_are` makes random trees, which must give the same in one expression, with literals
//! only, and step by step through declared variables. `METAMORPHIC_CASES` is the number of trees (2 000 without it) and
//! `METAMORPHIC_SEED` where they begin.

#![allow(clippy::unwrap_used, clippy::panic, clippy::indexing_slicing, reason = "tests and their helpers")]

mod places;
mod values;

use counterpoint_lang::bytecode::fast::Fast;
use counterpoint_lang::compile::{self, CompileOptions, MacroProgram};
use counterpoint_lang::source::MacroSource;
use counterpoint_lang::value::{MacroValue, ValueType};
use counterpoint_lang::vm::{self, MacroLimits, MacroState};
use counterpoint_lang_standalone::Standalone;
use places::{GOALS, Goal, ORIGINS, Origin, Writer, types_of};
use std::sync::Arc;
use values::{Known, OPERATORS, Operator, Tree};

/// A row of numbers that is the same everywhere.
struct Chance(u64);

impl Chance {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as usize % limit
    }

    fn of<T: Clone>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())].clone()
    }
}

fn values_of(kind: &str) -> Vec<Known> {
    let text = |text: &str| Known::Text(text.into());
    match kind {
        "REAL" => [2.0, 3.0, -1.0, 0.5, 0.0, -2.5, 1.0, 7.0].map(Known::Real).to_vec(),
        "STRING" => ["ab", "", "B", " b", "it's", "ab ", "old"].map(text).to_vec(),
        "LOGICAL" => [true, false].map(Known::Logical).to_vec(),
        "KEYWORD" => vec![Known::Word("ON", 71), Known::Word("OFF", 72), Known::Word("MIST", 90)],
        _ => [&[1.0, 2.0][..], &[], &[1.0], &[1.0, 3.0], &[9.0]].map(|list| Known::List(list.to_vec())).to_vec(),
    }
}

/// Runs a macro and returns its only line of output, or the error.
fn outcome(text: &str, system: &[(String, Known)], arguments: &[Known], options: (bool, bool)) -> String {
    let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
    for (name, value) in system {
        host.variable(name, ValueType::named(value.type_name()), true);
        host.set_system(name, value.value());
    }
    host.variable("$ZU", None, true);
    let (short_forms, trace) = options;
    let options = CompileOptions { trace, ..CompileOptions::default() };
    let added = compile::add(&mut program, &mut host, MacroSource::new("case", text), options);
    if let Some(first) = added.diagnostics.first() {
        return first.to_string();
    }
    if !short_forms {
        program.macros.iter_mut().for_each(|code| Arc::make_mut(code).short.forms.fill(Fast::None));
    }
    let mut state = MacroState::new(MacroLimits::default());
    let mut values: Vec<MacroValue> = arguments.iter().map(Known::value).collect();
    for index in &added.macros {
        vm::run(&program, &mut state, &mut host, *index, &mut values);
    }
    let mut lines = host.output.printed;
    lines.extend(host.output.commands.iter().filter_map(|line| line.strip_prefix("EXEC/NOW,").map(str::to_owned)));
    lines.extend(host.disk.files.get("out").map(|text| text.trim_end_matches('\n').to_owned()));
    lines.extend(
        host.output.diagnostics.iter().map(|diagnostic| {
            if diagnostic.severity == 0 { diagnostic.message.clone() } else { diagnostic.to_string() }
        }),
    );
    lines.join("\n")
}

/// Checks one expression; the text of the macro if it is wrong.
fn check(
    goal: Goal,
    tree: &Tree,
    chance: &mut Chance,
    origin: &mut dyn FnMut(&mut Chance, &Known) -> Origin,
) -> Result<(), String> {
    let result = tree.value();
    let mut writer = Writer::new(goal, result.clone());
    let mut styles = Chance(chance.0 | 1);
    let expression = {
        let mut leaf = |value: &Known| {
            let origin = origin(chance, value);
            writer.operand(value, origin)
        };
        tree.written(&mut leaf, &mut || styles.below(2))
    };
    let (text, system, arguments) = writer.finish(&expression);
    let wanted = format!("{} {}", result.printed(), types_of(result));
    let options = (styles.below(2) == 0, styles.below(2) == 0);
    let found = outcome(&text, &system, &arguments, options);
    if found == wanted { Ok(()) } else { Err(format!("{goal:?}\n{text}\nwanted: {wanted}\nfound:  {found}")) }
}

/// Pairs of operands that an operator takes.
fn operands(operator: Operator, kind: &str) -> Vec<Tree> {
    let values = values_of(kind);
    let mut list = Vec::new();
    for a in &values {
        if operator.is_unary() {
            list.extend(Tree::node(operator, vec![Tree::Leaf(a.clone())]));
            continue;
        }
        for b in &values {
            list.extend(Tree::node(operator, vec![Tree::Leaf(a.clone()), Tree::Leaf(b.clone())]));
        }
    }
    list
}

#[test]
fn every_operator_goes_everywhere() {
    let mut chance = Chance(0x9E37_79B9_7F4A_7C15);
    let (mut cases, mut failures) = (0, Vec::new());
    for operator in OPERATORS {
        for kind in operator.takes() {
            let trees = operands(operator, kind);
            for goal in GOALS {
                let trees: Vec<&Tree> = trees.iter().filter(|tree| goal.takes(tree.value())).collect();
                if trees.is_empty() {
                    continue;
                }
                for left in ORIGINS {
                    // This place on one side, a random one on the other, and random values.
                    let tree = chance.of(&trees);
                    let other = chance.of(&ORIGINS);
                    let mut places = if chance.below(2) == 0 { [left, other] } else { [other, left] }.into_iter();
                    let mut origin = |_: &mut Chance, _: &Known| places.next().unwrap_or(Origin::Literal);
                    cases += 1;
                    failures.extend(check(goal, tree, &mut chance, &mut origin).err());
                }
            }
        }
    }
    assert!(failures.is_empty(), "{} of {cases} cases fail, the first:\n{}", failures.len(), failures[0]);
    assert!(cases > 20_000, "only {cases} cases");
}

/// A random tree whose value has this type.
fn tree(chance: &mut Chance, kind: &'static str, depth: usize) -> Tree {
    for _ in 0..20 {
        if depth == 0 || chance.below(5) == 0 {
            break;
        }
        let operator = chance.of(&OPERATORS);
        if operator.gives() != kind {
            continue;
        }
        let inner = chance.of(operator.takes());
        let count = if operator.is_unary() { 1 } else { 2 };
        let parts = (0..count).map(|_| tree(chance, inner, depth - 1)).collect();
        if let Some(node) = Tree::node(operator, parts) {
            return node;
        }
    }
    Tree::Leaf(chance.of(&values_of(kind)))
}

/// The tree as statements that compute one operator each into a declared variable; returns the name of the last one.
fn steps(tree: &Tree, lines: &mut String, number: &mut usize) -> String {
    let text = match tree {
        Tree::Leaf(value) => value.written(),
        Tree::Node(operator, parts, _) => {
            let names: Vec<String> = parts.iter().map(|part| steps(part, lines, number)).collect();
            let sign = operator.spellings()[0];
            match names.as_slice() {
                [only] => format!("{sign}{only}"),
                names => names.join(sign),
            }
        }
    };
    *number += 1;
    let name = format!("S{number}");
    lines.push_str(&format!("DECLAR/{},{name}\n{name}={text}\n", tree.value().type_name()));
    name
}

fn from_environment(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

#[test]
fn trees_are_what_their_steps_are() {
    let cases = from_environment("METAMORPHIC_CASES", 2_000);
    let seed = from_environment("METAMORPHIC_SEED", 1);
    for case in seed..seed + cases {
        let mut chance = Chance(case.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1);
        chance.below(2);
        let kind = chance.of(&["REAL", "STRING", "LOGICAL", "LOGICAL"]);
        let tree = tree(&mut chance, kind, 4);
        let goals: Vec<Goal> = GOALS.into_iter().filter(|goal| goal.takes(tree.value())).collect();
        let goal = chance.of(&goals);
        let literals = check(goal, &tree, &mut chance, &mut |_, _| Origin::Literal);
        let anywhere = check(goal, &tree, &mut chance, &mut |chance, _| chance.of(&ORIGINS));
        let mut text = String::new();
        let name = steps(&tree, &mut text, &mut 0);
        text.push_str(&format!("PPRINT/'!(*)',{name}"));
        let stepwise = outcome(&text, &[], &[], (true, false));
        for result in [literals, anywhere] {
            assert!(result.is_ok(), "seed {case}: {}", result.unwrap_err());
        }
        assert_eq!(stepwise, tree.value().printed(), "seed {case}:\n{text}");
    }
}
