//! Tests of tables of tools.

use super::*;

fn machine(axes: &[&str], edges: u32, by_name: bool) -> ToolImportContext {
    ToolImportContext {
        axes: axes.iter().map(|&axis| axis.to_owned()).collect(),
        edges,
        by_name,
        ..ToolImportContext::default()
    }
}

fn read(name: &str, text: &str) -> Result<ToolDefinitions, String> {
    read_for(name, text, &machine(&["X", "Y", "Z"], 0, false))
}

/// The tables of a file for a machine.
fn tables(text: &str, machine: &ToolImportContext) -> toml::Table {
    toml::from_str(&read_for("tools.csv", text, machine).unwrap().definition("m-tools", "m")).unwrap()
}

fn read_for(name: &str, text: &str, machine: &ToolImportContext) -> Result<ToolDefinitions, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, text).unwrap();
    let file = path.display().to_string();
    ToolDefinitions::read(&path, machine).map_err(|error| error.to_string().replace(&file, name))
}

#[test]
fn a_spreadsheet_becomes_rows_that_know_their_lines() {
    let text = "number;name;diameter;length;X\n# drills\nT1;DRILL 6,8;6,8;120,5;\n2;FACE;63;80;1\n";
    let mut tools = read("tools.csv", text).unwrap();
    let definition = tools.definition("m-tools", "m");
    let table: toml::Table = toml::from_str(&definition).unwrap();
    let offsets = table["tool"]["offsets"].as_array().unwrap();
    assert_eq!(offsets[0]["radius"].as_float(), Some(3.4));
    assert_eq!(offsets[0]["values"]["Z"].as_float(), Some(120.5));
    assert_eq!((offsets[1]["number"].as_integer(), offsets[1]["values"]["X"].as_float()), (Some(2), Some(1.0)));
    assert_eq!(table["tool"]["data"][0]["name"].as_str(), Some("DRILL 6,8"));
    let line = |text: &str| definition.lines().position(|line| line.contains(text)).unwrap() as u32 + 1;
    assert_eq!(tools.place(line("radius = 3.4")).map(|place| place.1), Some(3));
    assert_eq!(tools.place(line("name = \"FACE\"")).map(|place| place.1), Some(4));
    assert_eq!(tools.place(line("[ce]")), None);
}

#[test]
fn columns_of_wear_are_beside_those_of_geometry() {
    let mut tools =
        read("tools.csv", "no,radius,radius wear,X,wear X,wear_length\n3,0.8,-0.02,10,0.1,-0.05\n4,,,,,\n").unwrap();
    let table: toml::Table = toml::from_str(&tools.definition("m-tools", "m")).unwrap();
    let offset = &table["tool"]["offsets"][0];
    assert_eq!((offset["radius"].as_float(), offset["radius_wear"].as_float()), (Some(0.8), Some(-0.02)));
    assert_eq!((offset["values"]["X"].as_float(), offset["wear"]["X"].as_float()), (Some(10.0), Some(0.1)));
    assert_eq!(offset["wear"]["Z"].as_float(), Some(-0.05));
    assert!(table["tool"]["offsets"][1].get("wear").is_none());
}

#[test]
fn a_toml_file_keeps_its_lines() {
    let mut tools = read("tools.toml", "# mine\n[[tool.offsets]]\nnumber = 1\nradius = 5\n").unwrap();
    let definition = tools.definition("m-tools", "m");
    assert!(toml::from_str::<toml::Table>(&definition).is_ok(), "{definition}");
    let line = definition.lines().position(|line| line == "number = 1").unwrap() as u32 + 1;
    assert_eq!(tools.place(line).map(|place| place.1), Some(3));
}

#[test]
fn what_is_no_table_of_tools_is_refused_with_its_line() {
    for (name, text, with) in [
        ("tools.csv", "name,radius\nA,1\n", "tools.csv:1: the first line names the columns"),
        ("tools.csv", "number,radius\n1,round\n", "tools.csv:2: 'round' is not a number"),
        ("tools.csv", "number,radius\nA1,2\n", "tools.csv:2: 'A1' is not a tool number"),
        ("tools.csv", "number,radius\n1,2,3\n", "tools.csv:2: 3 columns"),
        (
            "tools.csv",
            "# mine\nT,Dia,Diameter,X\n1,2,2,3\n",
            "tools.csv:2: the columns 'Dia' and 'Diameter' mean the same",
        ),
        ("tools.csv", "T,Dia,Dia,Length\n1,2,2,3\n", "tools.csv:1: the columns 'Dia' and 'Dia' mean the same"),
        ("tools.csv", "T,length\n1,-352.1\n", "tools.csv:2: the length -352.1 is below zero; a distance from"),
        ("tools.csv", "number,radius\n,2\n", "tools.csv:2: the tool has no number"),
        ("tools.toml", "[[codes]]\nid = 1\n", "`codes` is not for a table of tools"),
        ("tools.toml", "[tool]\noffset_digits = 2\n", "`tool` is not for a table of tools"),
        ("tools.toml", "[[tool.offsets]\n", "tools.toml: TOML parse error at line 1"),
        ("tools.xls", "", "a file .toml or .csv"),
    ] {
        let error = read(name, text).unwrap_err();
        assert!(error.contains(with), "{error}");
    }
}

#[test]
fn a_tool_of_a_control_with_edges_gets_the_offsets_of_its_edges() {
    let mill = machine(&["X1", "Y1", "Z1"], 10, true);
    let tables = tables("T;D;name;length;radius\n5;;EM10;100;5\nT5;D2;EM10;90;4\n7;1;DR8;80;\n", &mill);
    let offsets = tables["tool"]["offsets"].as_array().unwrap();
    let seen: Vec<_> = offsets
        .iter()
        .map(|row| (row["number"].as_integer().unwrap(), row["values"]["Z1"].as_float().unwrap()))
        .collect();
    assert_eq!(seen, [(51, 100.0), (52, 90.0), (71, 80.0)]);
    let data = tables["tool"]["data"].as_array().unwrap();
    let seen: Vec<_> = data.iter().map(|row| (row["number"].as_integer(), row["offset"].as_integer())).collect();
    assert_eq!(seen, [(Some(5), Some(51)), (Some(7), Some(71))]);
    let error = read_for("tools.csv", "T;D\n5;D12\n", &mill).unwrap_err();
    assert!(error.contains("tools.csv:2: 'D12' is not an edge (D1 to D9)"), "{error}");
}

#[test]
fn a_tool_that_programs_call_by_name_needs_no_number() {
    let mill = machine(&["X1", "Y1", "Z1"], 10, true);
    for text in ["tool;radius\nEM10;5\nDR8;4\nem10;5\n", "name,radius,D\nEM10,5,\nDR8,4,\nEM10,5,2\n"] {
        let tables = tables(text, &mill);
        let data = tables["tool"]["data"].as_array().unwrap();
        let seen: Vec<_> = data.iter().map(|row| (row["number"].as_integer(), row["name"].as_str())).collect();
        assert_eq!(seen, [(Some(20_001), Some("EM10")), (Some(20_002), Some("DR8"))]);
        assert_eq!(tables["tool"]["offsets"][1]["number"].as_integer(), Some(200_021));
    }
}

#[test]
fn a_column_named_as_programs_write_it_means_the_axes_of_all_channels() {
    let lathe = machine(&["X1", "Z1", "C1", "X2", "Z2"], 0, false);
    let tables = tables("T,X,length,wear z\n1,-10.5,40,0.1\n", &lathe);
    let offset = &tables["tool"]["offsets"][0];
    for (axis, value) in [("X1", -10.5), ("X2", -10.5), ("Z1", 40.0), ("Z2", 40.0)] {
        assert_eq!(offset["values"][axis].as_float(), Some(value), "{axis}");
    }
    assert_eq!((offset["wear"]["Z1"].as_float(), offset["wear"]["Z2"].as_float()), (Some(0.1), Some(0.1)));
    let single = machine(&["X1", "X", "Z"], 0, false);
    assert_eq!(single.axes("X"), ["X"]);
    assert_eq!(single.axes("z"), ["Z"]);
    assert!(single.axes("B").is_empty());
}

#[test]
fn a_column_of_offsets_gives_a_tool_another_offset() {
    let tables = tables("T,H,length\n3,13,40\n", &machine(&["X", "Z"], 0, false));
    assert_eq!(tables["tool"]["offsets"][0]["number"].as_integer(), Some(13));
    assert_eq!(tables["tool"]["data"][0]["number"].as_integer(), Some(3));
    assert_eq!(tables["tool"]["data"][0]["offset"].as_integer(), Some(13));
}

#[test]
fn an_unknown_column_is_named_in_the_first_line() {
    for (text, with) in [
        ("number,foo\n1,2\n", "tools.csv:1: unknown column 'foo': columns are number, name"),
        ("# tools of the shop\nnumber,D\n1,2\n", "tools.csv:2: unknown column 'D'"),
        ("number,wear Q\n1,2\n", "and the axes of the machine (X, Y, Z)"),
        ("number,name mm\n1,A\n", "tools.csv:1: column 'name mm' has a unit of length"),
        ("number,length,unit\n1,2,cm\n", "tools.csv:2: 'cm' is not a unit of length (mm, inch)"),
        ("number,length,unit\n1,2,mm\n2,3,\n", "tools.csv:3: the row does not say the unit of its lengths"),
    ] {
        let error = read("tools.csv", text).unwrap_err();
        assert!(error.contains(with), "{error}");
    }
}

#[test]
fn titles_of_tool_tables_of_controls_are_known() {
    let mill = machine(&["X", "Y", "Z"], 0, true);
    let table = tables("T,NAME,L,R,R2,DL,DR\n5,BALL6,80,3,3,0.1,-0.02\n", &mill);
    let offset = &table["tool"]["offsets"][0];
    assert_eq!((offset["radius"].as_float(), offset["radius_wear"].as_float()), (Some(3.0), Some(-0.02)));
    assert_eq!((offset["values"]["Z"].as_float(), offset["wear"]["Z"].as_float()), (Some(80.0), Some(0.1)));
    let data = &table["tool"]["data"][0];
    assert_eq!((data["radius"].as_float(), data["length"].as_float()), (Some(3.0), Some(80.0)));
    let table = tables("T;Ø;L\n5;6;80\n", &machine(&["X", "L"], 0, false));
    assert_eq!(table["tool"]["offsets"][0]["values"]["L"].as_float(), Some(80.0));
}

#[test]
fn lengths_are_converted_into_the_unit_of_the_machine() {
    let facts = |units: &str| {
        let text = format!(
            "[ce]\nunits = \"{units}\"\n[[axes]]\nname = \"Z\"\n[[axes]]\nname = \"C1\"\n[[axes]]\nname = \"Y\"\n\
             role = \"rotary\"\n"
        );
        ToolImportContext::of([text.as_str()].into_iter())
    };
    let metric = facts("mm");
    let by_title = tables("T,Dia inch,Length (in),Z mm,C1,tip\n1,0.5,4,2,90,3\n", &metric);
    let by_row = tables("T,Dia,Length,Unit,Z,Y\n1,0.5,4,inches,1,45\n2,6,80,mm,1,45\n", &metric);
    let value = |table: &toml::Table, list: &str, row: usize, path: &[&str]| {
        let mut at = &table["tool"][list][row];
        for key in path {
            at = &at[*key];
        }
        at.as_float().unwrap()
    };
    for (table, z, turns) in [(&by_title, 2.0, ("C1", 90.0)), (&by_row, 25.4, ("Y", 45.0))] {
        assert_eq!(value(table, "offsets", 0, &["radius"]), 6.35);
        assert_eq!(value(table, "data", 0, &["length"]), 101.6);
        assert_eq!(value(table, "offsets", 0, &["values", "Z"]), z);
        assert_eq!(value(table, "offsets", 0, &["values", turns.0]), turns.1);
    }
    assert_eq!(value(&by_row, "offsets", 1, &["radius"]), 3.0);
    let table = tables("T,radius inch\n1,.03\n", &metric);
    assert_eq!(value(&table, "offsets", 0, &["radius"]), 0.762);
    let table = tables("T,length mm\n1,50.8\n", &facts("inch"));
    assert!((value(&table, "offsets", 0, &["values", "Z"]) - 2.0).abs() < 1e-12);
}

#[test]
fn a_table_without_a_unit_says_which_one_is_assumed() {
    let note = |text: &str| read("tools.csv", text).unwrap().note;
    assert!(note("T,length\n1,4\n").unwrap().contains("lengths are in mm, the unit of the machine"));
    for text in ["T,length mm\n1,4\n", "T,length,unit\n1,4,mm\n", "T,name\n1,A\n"] {
        assert_eq!(note(text), None, "{text}");
    }
}
