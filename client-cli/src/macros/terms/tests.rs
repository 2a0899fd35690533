use super::*;

#[test]
fn operators_formats_patterns_and_keywords_are_explained() {
    for name in [
        "**",
        "*",
        "/",
        "//",
        "+",
        "-",
        "==",
        ".eq.",
        "!=",
        "<=",
        ".NOT.",
        "!",
        "&&",
        ".OR.",
        "^^",
        "+=",
        "/=",
        "{",
        "}",
        "$$",
        "$NULL",
        "$pi",
        ".TRUE.",
        "!!",
        "^",
        "[]",
        "\\<",
        "\\{",
        "\\1",
        "thru",
        "GLOBAL",
        "NOW",
        "ENDIF",
        "CUTTER",
        "TAPEOP",
        "FOR",
        "%L1",
        "%G07",
        "!(s34)",
        "!(e3:2:2)",
        "!(A5)",
        "!(*)",
        "!@X",
        "!(T14)",
        "!(X3)",
        "!(Xs3.1)",
        "$P1",
        "$p10",
        "$P44",
    ] {
        assert!(terms(name).is_some_and(|text| text.ends_with(".\n")), "{name}: {:?}", terms(name));
    }
    for name in ["", "$P0", "$P100", "%X1", "!(Q)", "NOTHING", "1.5"] {
        assert_eq!(terms(name), None, "{name}");
    }
    assert!(terms("!(s34)").is_some_and(|text| text.contains("7.35 gives '73500'")));
    assert!(terms("*").is_some_and(|text| text.contains("Product") && text.contains("regular expression")));
}

#[test]
fn every_reserved_word_is_explained() {
    let words = include_str!("../../../../kernel/lang/data/reserved-words.tsv");
    for word in words.lines().filter_map(|line| line.split('\t').next()) {
        assert!(terms(word).is_some(), "{word}");
    }
}
