//! Counts in the code of a crate: methods of a type, types that share a name, types that dereference to another one,
//! names of machines, texts made for the scanner, names of a type that a folder must not know.
//!
//! Invariant: test code does not count.

use std::collections::{BTreeMap, BTreeSet};

use syn::visit::{self, Visit};

use crate::code::{Code, is_test};

/// Types of a crate, by name.
#[derive(Debug, Default)]
pub(crate) struct Types {
    /// How often each name is defined.
    pub(crate) defined: BTreeMap<String, usize>,
    /// Methods of each type, without those of traits.
    pub(crate) methods: BTreeMap<String, usize>,
    /// Files with such methods.
    pub(crate) files: BTreeMap<String, BTreeSet<String>>,
    /// `Deref` and `DerefMut` of each type.
    pub(crate) derefs: BTreeMap<String, usize>,
}

/// Collects the types of a file.
struct Reader<'t> {
    path: &'t str,
    types: &'t mut Types,
}

impl Reader<'_> {
    fn defined(&mut self, name: &syn::Ident, attributes: &[syn::Attribute]) {
        if !is_test(attributes) {
            *self.types.defined.entry(name.to_string()).or_default() += 1;
        }
    }
}

/// Name of the type of an `impl`.
fn type_name(of: &syn::Type) -> Option<String> {
    let syn::Type::Path(path) = of else { return None };
    path.path.segments.last().map(|segment| segment.ident.to_string())
}

impl<'ast> Visit<'ast> for Reader<'_> {
    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        self.defined(&item.ident, &item.attrs);
    }

    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        self.defined(&item.ident, &item.attrs);
    }

    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        self.defined(&item.ident, &item.attrs);
    }

    fn visit_item_impl(&mut self, item: &'ast syn::ItemImpl) {
        let methods = item.items.iter().filter(|item| matches!(item, syn::ImplItem::Fn(one) if !is_test(&one.attrs)));
        let methods = methods.count();
        let of = item.trait_.as_ref().and_then(|(_, path, _)| path.segments.last());
        if of.is_some_and(|of| of.ident == "Deref" || of.ident == "DerefMut")
            && let Some(name) = type_name(&item.self_ty)
        {
            *self.types.derefs.entry(name).or_default() += 1;
        }
        let own = item.trait_.is_none() && !is_test(&item.attrs) && methods > 0;
        if let Some(name) = type_name(&item.self_ty).filter(|_| own) {
            *self.types.methods.entry(name.clone()).or_default() += methods;
            self.types.files.entry(name).or_default().insert(self.path.to_owned());
        }
        visit::visit_item_impl(self, item);
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }
}

/// The types of a crate.
pub(crate) fn types(codes: &[Code]) -> Types {
    let mut types = Types::default();
    for code in codes {
        Reader { path: &code.path, types: &mut types }.visit_file(&code.file);
    }
    types
}

/// Percentage of types that share their name with another type, rounded up.
pub(crate) fn shared_names<'t>(crates: impl IntoIterator<Item = &'t Types>) -> usize {
    let mut all: BTreeMap<&str, usize> = BTreeMap::new();
    for types in crates {
        for (name, count) in &types.defined {
            *all.entry(name).or_default() += count;
        }
    }
    let shared: usize = all.values().filter(|count| **count > 1).sum();
    (100 * shared).div_ceil(all.values().sum::<usize>().max(1))
}

/// Finds string literals that equal one of some names, and paths that end with some names.
struct Mentions<'m> {
    texts: &'m BTreeSet<String>,
    path_end: [&'m str; 2],
    found: [usize; 2],
}

impl<'ast> Visit<'ast> for Mentions<'_> {
    // Doc comments are attributes.
    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}

    fn visit_lit_str(&mut self, text: &'ast syn::LitStr) {
        self.found[0] += usize::from(self.texts.contains(&text.value()));
    }

    fn visit_macro(&mut self, of: &'ast syn::Macro) {
        let tokens = of.tokens.to_string();
        let parts = tokens.split('"').skip(1).step_by(2);
        self.found[0] += parts.filter(|part| self.texts.contains(*part)).count();
        visit::visit_macro(self, of);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let mut names = path.segments.iter().rev().map(|segment| segment.ident.to_string());
        let last = [names.next(), names.next()].map(Option::unwrap_or_default);
        self.found[1] += usize::from(last == [self.path_end[1], self.path_end[0]]);
        visit::visit_path(self, path);
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_test(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if !is_test(&item.attrs) {
            visit::visit_item_fn(self, item);
        }
    }
}

/// How often a file names one of these machines, and how often it creates a text for the scanner (`Remaining::Text`).
pub(crate) fn mentions(code: &Code, machines: &BTreeSet<String>) -> [usize; 2] {
    let mut mentions = Mentions { texts: machines, path_end: ["Remaining", "Text"], found: [0, 0] };
    mentions.visit_file(&code.file);
    mentions.found
}

/// Folders that must not know a type.
const CLOSED: [(&str, &str); 1] = [("kernel/actions/src/", "Kernel")];

/// Files of these folders that connect the two.
const CONNECTS: [&str; 1] = ["kernel/actions/src/context.rs"];

/// How often a file names a type that its folder must not know, comments included.
pub(crate) fn closed(path: &str, text: &str) -> usize {
    let closed = CLOSED.iter().filter(|(folder, _)| path.starts_with(folder) && !CONNECTS.contains(&path));
    let names =
        |name: &str| text.split(|c: char| !(c.is_alphanumeric() || c == '_')).filter(|word| *word == name).count();
    closed.map(|(_, name)| names(name)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn code(path: &str, text: &str) -> Code {
        let file = syn::parse_file(text).expect("it parses");
        Code { path: path.to_owned(), module: Vec::new(), text: text.to_owned(), file }
    }

    #[test]
    fn methods_count_by_type_over_all_files_and_those_of_traits_do_not() {
        let types = types(&[
            code(
                "a.rs",
                "struct Wide; impl Wide { fn a() {} fn b() {} const C: u8 = 1; } impl Clone for Wide { fn c() {} }",
            ),
            code(
                "b.rs",
                "impl<'a> super::Wide<'a> { fn d() {} #[cfg(test)] fn e() {} } #[cfg(test)] mod t { struct T; }",
            ),
            code("c.rs", "#[cfg(test)] impl Wide { fn f() {} } mod inner { pub enum Wide {} pub trait T {} }"),
        ]);
        assert_eq!(types.methods["Wide"], 3);
        assert_eq!(types.files["Wide"].len(), 2);
        assert_eq!(types.defined, BTreeMap::from([("T".to_owned(), 1), ("Wide".to_owned(), 2)]));
    }

    #[test]
    fn both_forms_of_deref_count_for_their_type() {
        let types = types(&[code(
            "a.rs",
            "impl std::ops::Deref for A<'_> { fn deref(&self) {} } impl<T> DerefMut for A<'_> {} impl Clone for B {}",
        )]);
        assert_eq!(types.derefs, BTreeMap::from([("A".to_owned(), 2)]));
    }

    #[test]
    fn names_of_the_kernel_count_in_the_folder_of_actions_only() {
        let text = "/// `Kernel::new`\nfn f(kernel: &mut Kernel<'_>, of: KernelKind) {}";
        assert_eq!(closed("kernel/actions/src/motion.rs", text), 2);
        assert_eq!(closed("kernel/actions/src/context.rs", text), 0);
    }

    #[test]
    fn names_that_two_crates_have_are_shared() {
        let one = types(&[code("a.rs", "struct A; struct B; struct C;")]);
        let other = types(&[code("b.rs", "enum A {} trait D {}")]);
        assert_eq!(shared_names([&one, &other]), 40);
        assert_eq!(shared_names([&one]), 0);
    }

    #[test]
    fn machines_and_texts_for_the_scanner_are_found_outside_comments_and_tests() {
        let text = r#"
            /// "our-mill"
            fn f() -> Rest {
                g("our-mill"); println!("our-mill", "ours"); g("our-mill two");
                match x { Remaining::Text(a) => word::Remaining::Text(a), _ => Text(b) }
            }
            #[cfg(test)] mod tests { const M: &str = "our-mill"; }
        "#;
        assert_eq!(mentions(&code("a.rs", text), &BTreeSet::from(["our-mill".to_owned()])), [2, 2]);
    }
}
