use super::*;

use counterpoint_kernel::machine::length_units::begins_in_inches;

#[test]
fn only_the_range_of_waiting_codes_is_replaced() {
    let text = "a = 1\n[[codes]]\nid = \"CODE_IGNORE\"\nword = \"M20-M29\"\n[[codes]]\nid = \"CODE_SYNC_REG\" # waits\n\
                word = \"M100-M199\" # these\n[[waits]]\nword = \"M50\"\n[[waits]]\nword = \"M300-M310\"\n";
    let with = with_waits(text, &(900..=999)).unwrap();
    assert_eq!(with, text.replace("M100-M199", "M900-M999").replace("M300-M310", "M900-M999"));
    assert_eq!(with_waits("[[waits]]\nword = \"M50\"\n", &(900..=999)), None);
}

fn memory(files: &PackedFiles) -> counterpoint_kernel::files::MemoryFiles {
    let mut memory = counterpoint_kernel::files::MemoryFiles::default();
    for (path, blob) in &files.0 {
        memory.insert(path.clone(), blob.content());
    }
    memory
}

/// The control of a composite is that of its components; only its lathes have systems of G codes.
#[test]
fn settings_of_a_composite_are_those_of_its_components() {
    let settings = [MachineSetting::Increments, MachineSetting::System('B')];
    let (name, files) = machine("composite-millturn", &settings).unwrap();
    assert_eq!(name, "composite-millturn-set-inc-b");
    let loaded = counterpoint_kernel::machine::load(&package::Overlay::over_shipped(memory(&files)), &name);
    assert_eq!(loaded.findings, []);
    let text = |component: &str| {
        let path = definition(&format!("{name}/{component}"));
        String::from_utf8_lossy(files.0.get(&path).unwrap().content()).into_owned()
    };
    let numbers = "[control]\nnumbers = \"increments\"\n";
    assert_eq!(text("fanuc-turning"), format!("extends = \"fanuc-turning\"\n{numbers}system = \"B\"\n"));
    assert_eq!(text("fanuc-milling"), format!("extends = \"fanuc-milling\"\n{numbers}"));
}

/// Machines whose programs can be in either unit begin in the set unit. So do the components of a composite.
#[test]
fn programs_begin_in_the_unit_that_is_set() {
    use counterpoint_kernel::log::info::MachineUnit;
    let load = |of: &str, unit: MachineUnit| {
        let (name, files) = machine(of, &[MachineSetting::Units(unit)]).unwrap();
        let loaded = counterpoint_kernel::machine::load(&package::Overlay::over_shipped(memory(&files)), &name);
        assert_eq!(loaded.findings, []);
        (name, loaded.machine.unwrap())
    };
    for of in ["fanuc-mill", "siemens-lathe", "heidenhain-mill", "citizen-3system", "isg-3channel", "haas-mill"] {
        let (name, machine) = load(of, MachineUnit::Inch);
        assert_eq!(name, format!("{of}-set-inch"));
        assert!(begins_in_inches(machine.of_channel(1)), "{of}");
        let (name, machine) = load(of, MachineUnit::Mm);
        assert_eq!(name, format!("{of}-set-mm"));
        assert!(!begins_in_inches(machine.of_channel(1)), "{of}");
    }
    let (_, composite) = load("composite-millturn", MachineUnit::Inch);
    let begin = composite.channels.iter().map(|channel| begins_in_inches(composite.of_channel(channel.number)));
    assert!(begin.into_iter().all(|inches| inches));
    for of in ["okuma-lathe", "okuma-mill"] {
        let error = machine(of, &[MachineSetting::Units(MachineUnit::Inch)]).unwrap_err().to_string();
        assert!(error.contains(&format!("machine '{of}' has no codes for both units")), "{error}");
    }
}

#[test]
fn a_machine_comes_with_its_families() {
    let (name, files) = machine("fanuc-2path-lathe", &[MachineSetting::Waits(900..=999)]).unwrap();
    let text = |path: &str| String::from_utf8_lossy(files.0.get(path).unwrap().content()).into_owned();
    assert_eq!(name, "fanuc-2path-lathe-set");
    assert!(text("fanuc-2path-lathe-set/machine.toml").contains("word = \"M900-M999\""));
    assert_eq!(
        text("fanuc-common/machine.toml").as_bytes(),
        include_bytes!("../../../machines/fanuc-common/machine.toml")
    );
    let (name, files) = machine("fanuc-mill", &[MachineSetting::Increments]).unwrap();
    let loaded = counterpoint_kernel::machine::load(&package::Overlay::over_shipped(memory(&files)), &name);
    assert_eq!((name.as_str(), loaded.findings), ("fanuc-mill-set-inc", Vec::new()));
    let settings = [MachineSetting::Increments, MachineSetting::System('C'), MachineSetting::System('B')];
    let (name, files) = machine("fanuc-lathe", &settings).unwrap();
    let loaded = counterpoint_kernel::machine::load(&package::Overlay::over_shipped(memory(&files)), &name);
    assert_eq!((name.as_str(), loaded.findings), ("fanuc-lathe-set-inc-b", Vec::new()));
    let text = String::from_utf8_lossy(files.0.get(&definition(&name)).unwrap().content()).into_owned();
    assert!(text.contains("numbers = \"increments\"\nsystem = \"B\"\n"), "{text}");
    for other in ["okuma-lathe", "fanuc-mill"] {
        let error = machine(other, &[MachineSetting::System('B')]).unwrap_err().to_string();
        assert!(error.contains(&format!("machine '{other}' has only one G-code system")), "{error}");
    }
    let (name, files) = machine(
        "fanuc-2path-lathe",
        &[MachineSetting::Increments, MachineSetting::Shared(150, 199), MachineSetting::Shared(180, 520)],
    )
    .unwrap();
    let loaded = counterpoint_kernel::machine::load(&package::Overlay::over_shipped(memory(&files)), &name);
    assert_eq!((name.as_str(), loaded.findings), ("fanuc-2path-lathe-set-inc-shared", Vec::new()));
    let variables = &loaded.machine.unwrap().variables;
    assert_eq!(variables.shared, [(150, 199), (200, 520)]);
    assert_eq!(variables.channel, [(100, 149), (521, 999)]);
    for (other, why) in
        [("fanuc-mill", "no second channel"), ("siemens-2channel", "no common"), ("heidenhain-mill", "no common")]
    {
        let error = machine(other, &[MachineSetting::Shared(500, 549)]).unwrap_err().to_string();
        assert!(error.contains(&format!("--set shared: machine '{other}' has {why}")), "{error}");
    }
    for other in ["fanuc-3path-lathe", "citizen-3system", "composite-millturn", "merging-lathe"] {
        assert!(machine(other, &[MachineSetting::Shared(500, 549)]).is_ok(), "{other}");
    }
    let error = machine("fanuc-mill", &[MachineSetting::Waits(900..=999)]).unwrap_err().to_string();
    assert!(error.contains("machine 'fanuc-mill' has no range of M codes that wait"), "{error}");
}

#[test]
fn a_name_with_a_further_end_is_not_too_long() {
    assert_eq!(with_end("fanuc-mill", "-set"), "fanuc-mill-set");
    let stops = with_end("fanuc-lathe-subspindle", "-set-stops");
    assert_eq!((stops.as_str(), stops.len()), ("fanuc-lathe-subspindle-set-stops", LONGEST_NAME));
    assert_eq!(with_end(&stops, TOOLS), "fanuc-lathe-subspindle-set-tools");
}
