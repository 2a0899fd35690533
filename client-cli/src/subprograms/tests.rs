use super::*;

#[test]
fn files_are_taken_by_their_names() {
    for name in ["O9001", "o1.nc", "part.tps", "part_2.tps", "TOOLS.LIB"] {
        assert!(is_taken_by_name(name, "part"), "{name}");
    }
    for name in ["Other.nc", "part.nc", "partner.tps", "readme.md", "L20.SPF"] {
        assert!(!is_taken_by_name(name, "part"), "{name}");
    }
}

#[test]
fn a_program_of_a_text_begins_at_its_number() {
    let text = b"%\nO0001 (MAIN)\nM98 P100\nM30\n o0100\nM99\n:7\nM98 P5 (O0200)\n%";
    assert_eq!([1, 100, 7, 5, 200, 10].map(|number| holds(text, number)), [true, true, true, false, false, false]);
}

#[test]
fn of_several_files_of_a_number_the_one_like_the_program_is_taken() {
    let best = |names: &[&str], program: &str| {
        best_of_number(&names.iter().map(ToString::to_string).collect::<Vec<_>>(), program)
    };
    let taken = |name: &str| Ok(Some(name.to_owned()));
    assert_eq!(best(&["O0100.bak", "O0100.nc", "O100"], "O0001.nc"), taken("O0100.nc"));
    assert_eq!(best(&["O0100.bak", "O0100.nc", "O100"], "O0001"), taken("O100"));
    assert_eq!(best(&["O0100.bak", "O0100.eia"], "part.nc"), taken("O0100.eia"));
    assert_eq!(best(&["O0100.nc.bak", "O0100.nc~"], "part.nc"), Ok(None));
    assert_eq!(best(&["O0100.bak"], "part.nc"), Ok(None));
    assert_eq!(best(&["O0100.eia", "O0100.min"], "part.nc"), Err("'O0100.eia' and 'O0100.min'".to_owned()));
    assert_eq!(best(&["O0100.NC", "O100.nc"], "part.nc"), Err("'O0100.NC' and 'O100.nc'".to_owned()));
    for (text, calls) in
        [("M98 P0100", true), ("CALL o100", true), ("M98 P30100", true), ("G0 X100.", false), ("P1001", false)]
    {
        assert_eq!(may_call(text.as_bytes(), 100), calls, "{text}");
    }
    let numbered = by_number(["O1.nc", "o0001.h", "O10", "O", "Other"].map(str::to_owned).into_iter());
    assert_eq!(numbered.keys().copied().collect::<Vec<_>>(), [1, 10]);
}

#[test]
fn files_are_taken_if_a_text_mentions_them() {
    let mentioned = |text: &str| {
        let mut files = Mentionable::default();
        for name in ["L20.SPF", "SUB.h", "my-sub.H", "OPOCK.SUB", "pocket.nc", "X1.MPF", "notes", "L2.spf"] {
            files.add(name);
        }
        files.take_mentioned(text.as_bytes()).into_iter().collect::<Vec<_>>().join(" ")
    };
    let cases = [
        ("N10 L20 P2", "L20.SPF"),
        ("l20", "L20.SPF"),
        ("L200 L2.5", "L2.spf"),
        ("CALL PGM TNC:\\parts\\SUB.H", "SUB.h"),
        ("CALL PGM MY-SUB", "my-sub.H"),
        ("CALL OPOCK Q2", "OPOCK.SUB"),
        ("L pocket.nc", "pocket.nc"),
        ("pocket", ""),
        ("notes", ""),
        ("EXTCALL \"X1\"", "X1.MPF"),
        ("INIT(2,\"/_N_MPF_DIR/_N_X1_MPF\",\"S\")", "X1.MPF"),
        ("_N_L20_SPF _N_SUB", "L20.SPF"),
    ];
    for (text, names) in cases {
        assert_eq!(mentioned(text), names, "{text}");
    }
}

#[test]
fn calls_of_linuxcnc_mention_files_by_name_and_by_number() {
    let mut files = Mentionable::default();
    for name in ["besi.ngc", "100.ngc", "77.ngc", "78.ngc", "other.ngc"] {
        files.add(name);
    }
    let taken = files.take_mentioned(b"o<Besi> call [4]\nO100 call\nM98 P77\nG4 P2\n");
    assert_eq!(taken.into_iter().collect::<Vec<_>>(), ["100.ngc", "77.ngc", "besi.ngc"]);
}
