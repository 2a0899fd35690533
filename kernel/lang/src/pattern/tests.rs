use super::*;
use crate::diag::DiagnosticNumber;

fn edit(text: &str, pattern: &str, with: &str, which: usize) -> String {
    TextPattern::new(pattern).unwrap().replace(text, with, which).unwrap()
}

fn first(text: &str, pattern: &str) -> Option<String> {
    TextPattern::new(pattern).unwrap().nth(text, None, 1).unwrap()
}

#[test]
fn edits_of_the_reference() {
    assert_eq!(edit("X=1 Y=2", "\\([A-Z]\\)=", "\\1", 0), "X1 Y2");
    assert_eq!(edit("A1B22", "[0-9][0-9]*", "#", 2), "A1B#");
    assert_eq!(edit("/ N20 G64", "^/\\([^0-9]\\)", "/1\\1", 0), "/1 N20 G64");
    assert_eq!(edit("fizz", "zz*", "", 0), "fi");
    let number = TextPattern::new("N\\([0-9]*\\)").unwrap();
    assert_eq!(number.nth("N120 G1", Some("\\1"), 1).unwrap().as_deref(), Some("120"));
}

#[test]
fn signs_of_other_dialects_are_literal() {
    assert_eq!(first("a(b){c}+?|<>", "(b){c}+?|<>").as_deref(), Some("(b){c}+?|<>"));
    assert_eq!(first("a^b$c", "a^b$c").as_deref(), Some("a^b$c"));
    assert_eq!(first("*a", "*a").as_deref(), Some("*a"));
    assert_eq!(edit("ab", "b", "&\\0", 0), "a&0");
}

#[test]
fn sets_anchors_words() {
    assert_eq!(first("a]b", "[]]").as_deref(), Some("]"));
    assert_eq!(first("a-b", "[z-]").as_deref(), Some("-"));
    assert_eq!(first("xyz", "[^x-y]").as_deref(), Some("z"));
    assert_eq!(first("G10 G1", "\\<G1\\>"), Some("G1".into()));
    assert_eq!(first("G10", "\\<G1\\>"), None);
    assert_eq!(first("abc", "c$").as_deref(), Some("c"));
    assert_eq!(first("abc", "^b"), None);
}

#[test]
fn repetitions_and_back_references() {
    assert_eq!(first("aaaa", "a\\{2\\}").as_deref(), Some("aa"));
    assert_eq!(first("aaaa", "a\\{2,\\}").as_deref(), Some("aaaa"));
    assert_eq!(first("aaaa", "a\\{1,3\\}").as_deref(), Some("aaa"));
    assert_eq!(first("ababx", "\\(ab\\)*x").as_deref(), Some("ababx"));
    assert_eq!(first("abab", "\\(ab\\)\\1").as_deref(), Some("abab"));
    assert_eq!(first("abbbc", "a\\(b\\)\\1*c").as_deref(), Some("abbbc"));
    assert_eq!(first("ab", "\\(a*\\)*b").as_deref(), Some("ab"));
    assert_eq!(first("xyxyz", "\\(x\\(y\\)\\)\\{2\\}z").as_deref(), Some("xyxyz"));
    assert_eq!(first("ÄÖÜ", "Ö.").as_deref(), Some("ÖÜ"));
}

#[test]
fn empty_matches_are_replaced_once_per_place() {
    assert_eq!(edit("abc", "x*", "-", 0), "-a-b-c-");
    assert_eq!(edit("baaac", "a*", "x", 0), "xbxcx");
    assert_eq!(TextPattern::new(",").unwrap().split("a,b,,c", 0).unwrap(), ["a", "b", "", "c"]);
    assert_eq!(TextPattern::new(",").unwrap().split("a,b,,c", 2).unwrap(), ["a", "b,,c"]);
    assert_eq!(TextPattern::new("x").unwrap().split("abc", 0).unwrap(), ["abc"]);
}

#[test]
fn malformed_and_hostile_expressions_are_refused() {
    for text in ["\\(a", "a\\)", "[a", "a\\{2", "\\{2\\}", "a\\{300\\}", "a\\{3,2\\}", "\\1", "a\\", "[b-a]"] {
        assert_eq!(TextPattern::new(text).unwrap_err().number, DiagnosticNumber::BAD_PATTERN, "{text}");
    }
    let hostile = TextPattern::new("\\(\\(a*\\)*\\)*\\(a*\\)*\\1b").unwrap();
    assert_eq!(hostile.replace(&"a".repeat(2000), "", 0).unwrap_err().number, DiagnosticNumber::BACKTRACKING);
    assert!(TextPattern::new("\\(a\\{255\\}b\\)\\{255\\}").is_ok());
    assert!(TextPattern::new("\\(\\(\\(\\(ab\\)\\{200\\}\\)\\{200\\}\\)\\{200\\}\\)").is_err());
}

#[test]
fn every_match_contains_the_required_text() {
    let cases = [
        ("^%$", "%"),
        ("G71", "G71"),
        ("G7*1", "G"),
        ("M0*8", "M"),
        ("\\(AB\\)*C", "C"),
        ("\\(AB\\)\\{1,2\\}CD", "AB"),
        ("X[0-9]*YZ", "YZ"),
        ("[0-9]*", ""),
        ("AB.CDE", "CDE"),
    ];
    for (pattern, literal) in cases {
        let required = TextPattern::new(pattern).unwrap().required();
        assert!(required == literal || literal.contains(&required) && !required.is_empty(), "{pattern}: {required}");
    }
    assert_eq!(TextPattern::new("[0-9]*").unwrap().required(), "");
}

#[test]
fn memory_can_be_used_again() {
    let mut memory = SearchMemory::default();
    let pattern = TextPattern::new("\\(G\\)\\([0-9]*\\)").unwrap();
    for text in ["N1 G54", "N2", "G1"] {
        let mut budget = STEPS;
        let again = pattern.find_with(text, &mut budget, &mut memory).unwrap();
        assert_eq!(again, pattern.find(text, 0, &mut STEPS.clone()).unwrap(), "{text}");
        if let Some(found) = again {
            assert!(TextPattern::filled("<\\2>", text, &found).starts_with('<'));
        }
    }
}
