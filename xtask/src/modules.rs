//! Which modules of a crate use which, read off the paths in the code, and the cycles among them.

use std::collections::{BTreeMap, BTreeSet};

use petgraph::algo::tarjan_scc;
use petgraph::graph::DiGraph;
use syn::visit::{self, Visit};

use crate::code::{Code, is_test};

/// Arrows from each first-level module to others of the crate.
pub(crate) type Arrows = BTreeMap<String, BTreeSet<String>>;

/// Collects the first-level modules that a file names.
struct Uses<'c> {
    module: &'c [String],
    found: BTreeSet<String>,
}

impl Uses<'_> {
    /// A path as it is written: its first names.
    fn path(&mut self, names: &[String]) {
        let Some(first) = names.first() else { return };
        let target = match first.as_str() {
            "crate" => names.get(1).cloned(),
            "super" => {
                let ups = names.iter().take_while(|name| *name == "super").count();
                // Inline modules are left out: none of the crates has modules in files besides those of tests.
                match self.module.len().checked_sub(ups) {
                    Some(0) => names.get(ups).cloned(),
                    _ => None,
                }
            }
            _ => None,
        };
        self.found.extend(target);
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
        let mut uses = Uses { module: &code.module, found: BTreeSet::new() };
        uses.visit_file(&code.file);
        let others = uses.found.into_iter().filter(|found| found != own && modules.contains(found));
        arrows.entry(own.clone()).or_default().extend(others);
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
        Code { path: String::new(), module: module.iter().map(|&m| m.to_owned()).collect(), lines: 0, file }
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
}
