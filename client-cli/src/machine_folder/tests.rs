use super::*;

#[test]
fn a_definition_extends_what_stands_before_its_tables() {
    assert_eq!(extends("# A machine\nextends = \"mill\"\n\n[ce]\nname = \"own\""), Some("mill".to_owned()));
    assert_eq!(extends("[ce]\nextends = \"mill\""), None);
    assert_eq!(extends("limits = [\n[0, 1],\n]\nextends = \"mill\"\n[ce]\n"), Some("mill".to_owned()));
    assert_eq!(extends("extends = \"mill\"\r\n[ce]\r\n"), Some("mill".to_owned()));
    assert_eq!((extends("extends = 3"), extends("extends = ")), (None, None));
}

#[test]
fn a_machine_has_its_folders_and_those_it_extends() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    };
    write("own/machine.toml", "extends = \"family\"\nfiles = \"storage\"\n");
    write("own/macros/start.mac", "OUTPUT\n");
    write("own/storage/O9001", "M99\n");
    write("own/storage/resident/deep/park.nc", "G0 Z0\nM99\n");
    write("own/.git/config", "hidden");
    write("own/storage/.hidden", "hidden");
    write("family/machine.toml", "extends = \"shipped\"\n");
    write("family/macros/block.mac", "");
    write("other/machine.toml", "");
    let (name, files) = machine(&folder.path().join("own")).unwrap();
    let names: Vec<_> = files.0.keys().map(String::as_str).collect();
    assert_eq!(name, "own");
    assert_eq!(
        names,
        [
            "family/machine.toml",
            "family/macros/block.mac",
            "own/machine.toml",
            "own/macros/start.mac",
            "own/storage/O9001",
            "own/storage/resident/deep/park.nc",
        ]
    );
    assert_eq!(&files.0["own/storage/resident/deep/park.nc"].content()[..], b"G0 Z0\nM99\n");
}

#[test]
fn a_composite_comes_with_its_components() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name).join("machine.toml");
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    };
    let row = |machine: &str| format!("[[components]]\nmachine = {machine:?}\n");
    let rows = ["inside", "beside", "shipped", "../outside", "outside/deep"].map(row).concat();
    write("own", &format!("extends = \"family\"\n[ce]\nname = \"own\"\n{rows}"));
    write("own/inside", "extends = \"base\"\n");
    write("base", "");
    write("beside", "extends = \"turning\"\n");
    write("turning", "extends = \"own\"\n");
    write("family", &row("mill"));
    write("mill", "");
    write("outside/deep", "");
    let (_, files) = machine(&folder.path().join("own")).unwrap();
    let names: Vec<_> = files.0.keys().map(|path| path.trim_end_matches("/machine.toml")).collect();
    assert_eq!(names, ["base", "beside", "family", "mill", "own/inside", "own", "turning"]);
}

#[test]
fn folders_are_packed_eight_levels_deep_and_links_to_folders_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let own = folder.path().join("own");
    let deep = (0..10).fold(own.clone(), |path, level| path.join(level.to_string()));
    fs::create_dir_all(&deep).unwrap();
    fs::write(own.join("machine.toml"), "").unwrap();
    fs::write(own.join("0/1/2/3/4/5/6/7/last.nc"), "").unwrap();
    fs::write(own.join("0/1/2/3/4/5/6/7/8/beyond.nc"), "").unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink(&own, own.join("loop")).unwrap();
    let (_, files) = machine(&own).unwrap();
    let names: Vec<_> = files.0.keys().map(String::as_str).collect();
    assert_eq!(names, ["own/0/1/2/3/4/5/6/7/last.nc", "own/machine.toml"]);
}

#[cfg(unix)]
#[test]
fn nothing_outside_of_a_machine_folder_is_packed() {
    use std::os::unix::fs::symlink;
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for name in ["machines/own/macros", "secret", "machines/linked"] {
        fs::create_dir_all(at(name)).unwrap();
    }
    fs::write(at("secret/machine.toml"), "").unwrap();
    fs::write(at("secret/key"), "").unwrap();
    fs::write(at("machines/own/macros/real.mac"), "OUTPUT").unwrap();
    symlink("real.mac", at("machines/own/macros/same.mac")).unwrap();
    symlink(at("secret/key"), at("machines/own/macros/key.mac")).unwrap();
    symlink("../../secret/key", at("machines/own/key")).unwrap();
    let names = |machine: &str, definition: &str| {
        fs::write(at("machines/own/machine.toml"), definition).unwrap();
        let (_, files) = super::machine(&at(machine)).unwrap();
        files.0.keys().cloned().collect::<Vec<_>>()
    };
    let own = ["own/machine.toml", "own/macros/real.mac", "own/macros/same.mac"];
    assert_eq!(names("machines/own", ""), own);
    assert_eq!(names("machines/own", "extends = \"../../secret\""), own);
    let absolute = format!("extends = {:?}", at("secret"));
    assert_eq!(names("machines/own", &absolute), own);
    symlink(at("secret/machine.toml"), at("machines/linked/machine.toml")).unwrap();
    assert_eq!(names("machines/linked", ""), [""; 0]);
}
