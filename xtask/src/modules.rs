//! Dependencies between the modules and files of a crate, taken from the paths in the code, and their cycles.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::algo::tarjan_scc;
use petgraph::graph::DiGraph;
use syn::visit::{self, Visit};

use crate::code::{Code, is_test};

/// Arrows from each module to others of the crate.
pub(crate) type Arrows = BTreeMap<String, BTreeSet<String>>;

/// Collects the paths into the crate that a file names, from the root of the crate.
pub(crate) struct Uses<'c> {
    module: &'c [String],
    found: BTreeSet<Vec<String>>,
}

impl<'c> Uses<'c> {
    /// The paths that a file names.
    pub(crate) fn of(code: &'c Code) -> BTreeSet<Vec<String>> {
        let mut uses = Uses { module: &code.module, found: BTreeSet::new() };
        uses.visit_file(&code.file);
        uses.found
    }

    /// A path as written: its first names. Inline modules are left out, because the crates use them only for tests.
    fn path(&mut self, names: &[String]) {
        let Some(first) = names.first() else { return };
        let found = match first.as_str() {
            "crate" => names.get(1..).unwrap_or_default().to_vec(),
            "self" => [self.module, names.get(1..).unwrap_or_default()].concat(),
            "super" => {
                let ups = names.iter().take_while(|name| *name == "super").count();
                let Some(above) = self.module.len().checked_sub(ups) else { return };
                let above = self.module.get(..above).unwrap_or_default();
                [above, names.get(ups..).unwrap_or_default()].concat()
            }
            _ => return,
        };
        self.found.insert(found);
    }

    fn tree(&mut self, before: &[String], tree: &syn::UseTree) {
        match tree {
            syn::UseTree::Path(path) => {
                let names = [before, &[path.ident.to_string()]].concat();
                self.tree(&names, &path.tree);
            }
            syn::UseTree::Name(name) => self.path(&[before, &[name.ident.to_string()]].concat()),
            syn::UseTree::Rename(name) => self.path(&[before, &[name.ident.to_string()]].concat()),
            syn::UseTree::Glob(_) => self.path(before),
            syn::UseTree::Group(group) => group.items.iter().for_each(|tree| self.tree(before, tree)),
        }
    }
}

impl<'ast> Visit<'ast> for Uses<'_> {
    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        if !is_test(&item.attrs) {
            self.tree(&[], &item.tree);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.path(&names);
        visit::visit_path(self, path);
    }
}

/// The arrows between the first-level modules of a crate.
pub(crate) fn arrows(codes: &[Code]) -> Arrows {
    let modules: BTreeSet<String> = codes.iter().filter_map(|code| code.module.first().cloned()).collect();
    let mut arrows = Arrows::new();
    for code in codes {
        let Some(own) = code.module.first() else { continue };
        let uses = Uses::of(code).into_iter().filter_map(|path| path.into_iter().next());
        let others = uses.filter(|found| found != own && modules.contains(found));
        arrows.entry(own.clone()).or_default().extend(others);
    }
    arrows
}

/// The arrows between the files of a crate, by their modules. Arrows between a module and its descendants are left out.
pub(crate) fn file_arrows(codes: &[Code]) -> Arrows {
    let modules: BTreeSet<&[String]> = codes.iter().map(|code| code.module.as_slice()).collect();
    let mut arrows = Arrows::new();
    for code in codes.iter().filter(|code| !code.module.is_empty()) {
        let others = Uses::of(code).into_iter().filter_map(|path| {
            let module = (1..=path.len()).rev().filter_map(|n| path.get(..n)).find(|part| modules.contains(part))?;
            let family = module.starts_with(&code.module) || code.module.starts_with(module);
            (!family).then(|| module.join("::"))
        });
        arrows.entry(code.module.join("::")).or_default().extend(others);
    }
    arrows
}

/// Modules that use each other, directly or through others.
pub(crate) fn cycles(arrows: &Arrows) -> Vec<Vec<String>> {
    let mut graph = DiGraph::<&str, ()>::new();
    let nodes: BTreeMap<&str, _> = arrows.keys().map(|name| (name.as_str(), graph.add_node(name))).collect();
    for (from, targets) in arrows {
        for to in targets {
            if let (Some(&from), Some(&to)) = (nodes.get(from.as_str()), nodes.get(to.as_str())) {
                graph.add_edge(from, to, ());
            }
        }
    }
    let mut cycles: Vec<Vec<String>> = tarjan_scc(&graph)
        .into_iter()
        .filter(|part| part.len() > 1)
        .map(|part| {
            let mut names: Vec<String> =
                part.into_iter().filter_map(|node| graph.node_weight(node)).map(|name| (*name).to_owned()).collect();
            names.sort();
            names
        })
        .collect();
    cycles.sort();
    cycles
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(module: &[&str], text: &str) -> Code {
        let file = syn::parse_file(text).expect("it parses");
        Code {
            path: String::new(),
            module: module.iter().map(|&m| m.to_owned()).collect(),
            text: text.to_owned(),
            file,
        }
    }

    #[test]
    fn every_kind_of_path_is_an_arrow() {
        let codes = [
            code(&["a"], "use crate::{b::X, c}; #[cfg(test)] mod tests { use crate::d::Y; }"),
            code(&["a", "deep"], "fn f() { super::super::d::g(); super::own(); }"),
            code(&["b"], "use super::c::*;"),
            code(&["c"], "fn f(x: crate::a::X) {}"),
            code(&["d"], "use std::a;"),
        ];
        let arrows = arrows(&codes);
        let of = |name: &str| arrows[name].iter().map(String::as_str).collect::<Vec<_>>();
        assert_eq!((of("a"), of("b"), of("c"), of("d")), (vec!["b", "c", "d"], vec!["c"], vec!["a"], vec![]));
        assert_eq!(cycles(&arrows), [["a", "b", "c"]]);
    }

    #[test]
    fn files_are_in_a_circle_unless_they_are_parent_and_child() {
        let codes = [
            code(&["a"], "use self::left::X; use crate::b;"),
            code(&["a", "left"], "use super::right::Y; use super::Own;"),
            code(&["a", "right"], "fn f() { crate::a::left::g(); }"),
            code(&["b"], "use crate::a::right::deep::Z;"),
            code(&["a", "right", "deep"], "use super::Y;"),
        ];
        assert_eq!(cycles(&file_arrows(&codes)), [["a::left", "a::right"]]);
    }
}
