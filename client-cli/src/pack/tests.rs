use super::*;
use crate::arguments::ProgramFiles;

#[test]
fn a_number_behind_the_file_picks_a_program() {
    assert_eq!(program("a/b.nc#2102").unwrap(), (PathBuf::from("a/b.nc"), Some(Inside::Number(2102))));
    assert_eq!(program("a/b.nc#O0007").unwrap(), (PathBuf::from("a/b.nc"), Some(Inside::Number(7))));
    assert_eq!(program("a/b.nc").unwrap(), (PathBuf::from("a/b.nc"), None));
    let name = |name: &str| Some(Inside::Name(name.to_owned()));
    assert_eq!(program("b.nc#$2").unwrap(), (PathBuf::from("b.nc"), name("$2")));
    assert_eq!(program("b.arc#PART_1").unwrap(), (PathBuf::from("b.arc"), name("PART_1")));
    assert!(program("b.nc#").is_err());
}

#[test]
fn a_program_is_text() {
    let path = Path::new("p.nc");
    let refused = |content: &[u8], with: &str| {
        let error = is_program(path, content).unwrap_err().to_string();
        assert!(error.contains(with), "{error}");
    };
    refused(b"", "is empty");
    refused(b" \r\n\n", "is empty");
    refused(&(0..=255).collect::<Vec<u8>>(), "is not a text file (29 of 256 bytes");
    for content in
        [&b"%\r\nG0 X1\r\n"[..], b"\0\0\0%\nO1\n\0\0", b"(\xe4\xf6)\nG0\n", b"\xff\xfeG\x000\0", b"M208 M02\x1a"]
    {
        assert!(is_program(path, content).is_ok(), "{content:?}");
    }
}

/// A folder with 1,200 programs; `main.nc` has this text.
fn crowded(text: &str) -> (tempfile::TempDir, Inputs) {
    let folder = tempfile::tempdir().unwrap();
    for number in 1..=1200 {
        let text = if number == 100 { "O0100\nM98 P0200\nM99" } else { "M99" };
        fs::write(folder.path().join(format!("O{number:04}.nc")), text).unwrap();
    }
    fs::write(folder.path().join("O9010.nc"), "O9010\nM98 P0300\nM99").unwrap();
    fs::write(folder.path().join("main.nc"), text).unwrap();
    let inputs = Inputs::plain(&[folder.path().join("main.nc").display().to_string()]);
    (folder, inputs)
}

#[test]
fn of_many_numbered_files_those_that_may_be_called_are_taken() {
    let (_folder, mut inputs) = crowded("N500 G0\nM98 P0100\nM30\n");
    let pack = job(&inputs).unwrap();
    let names: Vec<_> = pack.files.0.keys().map(String::as_str).collect();
    let called = ["O0030.nc", "O0098.nc", "O0099.nc", "O0100.nc", "O0200.nc", "O0300.nc", "O9010.nc", "main.nc"];
    assert!(names.iter().all(|name| called.contains(name) || *name == "O0000.nc"), "{names:?}");
    assert!(called[3..].iter().all(|name| names.contains(name)), "{names:?}");
    assert_eq!(pack.computed, None);
    inputs.files.no_neighbours = true;
    assert_eq!(job(&inputs).unwrap().files.0.len(), 1);
    let (_folder, inputs) = crowded("#1=100\nM98 P#1\nM30\n");
    let pack = job(&inputs).unwrap();
    let computed = Computed { file: "main.nc".to_owned(), line: 2, files: 1201 };
    assert_eq!((pack.files.0.len(), pack.computed), (1202, Some(computed)));
}

#[test]
fn an_ambiguous_number_after_a_repeat_count_is_refused() {
    for call in ["M98 P1005", "M98 P31005", "M98 P00031005"] {
        let (folder, inputs) = crowded(&format!("N500 G0\n{call}\nM30\n"));
        fs::remove_file(folder.path().join("O1005.nc")).unwrap();
        for name in ["O1005.tap", "O1005.txt"] {
            fs::write(folder.path().join(name), "O1005\nM99\n").unwrap();
        }
        let error = job(&inputs).map(drop).unwrap_err().to_string();
        assert!(error.contains("may call O1005, but 'O1005.tap' and 'O1005.txt' beside it"), "{call}: {error}");
    }
}

#[test]
fn a_job_has_programs_neighbours_and_extra_files() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in [
        ("part.nc", "L20"),
        ("L20.SPF", "CALL L30"),
        ("L30.spf", "M17"),
        ("L40.SPF", "M17"),
        ("part_1.tps", ""),
        ("O9001", ""),
        ("notes.txt", ""),
        ("other/part.nc", "M30"),
        ("lib/macro.nc", ""),
    ] {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    let at = |name: &str| folder.path().join(name).display().to_string();
    let inputs = Inputs {
        programs: vec![at("part.nc"), at("other/part.nc"), at("part.nc#2")],
        files: ProgramFiles { with: vec![folder.path().join("lib")], ..ProgramFiles::default() },
        ..Inputs::plain(&[])
    };
    let pack = job(&inputs).unwrap();
    let names: Vec<_> = pack.files.0.keys().map(String::as_str).collect();
    assert_eq!(names, ["L20.SPF", "L30.spf", "O9001", "macro.nc", "other/part.nc", "part.nc", "part_1.tps"]);
    let programs: Vec<_> = pack.programs.iter().map(|p| (p.path.as_str(), p.number)).collect();
    assert_eq!(programs, [("part.nc", None), ("other/part.nc", None), ("part.nc", Some(2))]);
}
