//! A machine is found again from the times of its own runs.

use super::*;

const PROGRAM: &str = "G17 G21 G90 G94\nT1 M6\nG0 X0 Y0 Z10.\nM8\nG1 Z0 F600\nX40. F6000\nY30.\nX0\nY0\nX12. Y5.\nG2 X20. Y13. R8.\nG1 X60.\n\
                       G0 Z200.\nM9\nG0 X-150.\nT2 M6\nG0 X10. Y10.\nG1 X10.4 F4000\nX10.8\nX11.2\nX11.6\nX12. Y11.\nM30\n";

/// A trial with the times that a machine takes.
fn trial(change: impl FnOnce(&mut Machine)) -> Trial {
    let mut files = MemoryFiles::default();
    files.insert("part.nc".to_owned(), PROGRAM);
    let loaded = load(&Overlay::over_shipped(MemoryFiles::default()), "fanuc-mill");
    let machine = loaded.machine.unwrap();
    let mut real = machine.clone();
    change(&mut real);
    let programs = vec![ProgramSelection { file: "part.nc".to_owned(), number: None, section: None, channel: None }];
    let mut trial = Trial { machine, programs, files, channel: 1, lines: Lines::new() };
    let seconds = trial.seconds(&trial.run(real).unwrap());
    trial.lines = seconds.into_iter().filter(|(_, seconds)| *seconds > 0.0).collect();
    trial
}

#[test]
fn the_data_of_a_machine_are_found_from_its_times() {
    let trial = trial(|machine| {
        let ids: Vec<_> = machine.axes.ids().collect();
        for (axis, acceleration) in ids.into_iter().zip([3000.0, 4500.0, 2500.0]) {
            machine.axes[axis].dynamics.acceleration = Some(acceleration);
            machine.axes[axis].rapid *= 0.8;
        }
        machine.time.corner_deviation = Some(0.03);
        machine.time.tool_change = 3.5;
    });
    let calibration = trial.calibrate().unwrap();
    let of = |name: &str| {
        calibration.data.iter().find(|fitted| fitted.datum.name(&trial.machine) == name).unwrap().after().unwrap()
    };
    for (name, real) in [
        ("acceleration of X", 3000.0),
        ("acceleration of Y", 4500.0),
        ("acceleration of Z", 2500.0),
        ("rapid of X", 28_800.0),
        ("rapid of Z", 24_000.0),
        ("corner_deviation", 0.03),
        ("tool_change", 3.5),
    ] {
        assert!((of(name) / real - 1.0).abs() < 0.02, "{name}: {} {real}\n{calibration:#?}", of(name));
    }
    let worst = calibration.lines.iter().map(|(_, [measured, _, after])| (measured - after).abs()).fold(0.0, f64::max);
    assert!(worst < 2e-3, "{worst}");
    let text = report::text(&trial.machine, &calibration, false);
    assert!(text.contains("tool_change") && text.contains("largest differences"), "{text}");
}

#[test]
fn a_definition_has_what_was_fitted() {
    let trial = trial(|machine| machine.time.tool_change = 3.5);
    let axis = trial.machine.axes.ids().next().unwrap();
    let row = trial.machine.codes.ids().next().unwrap();
    let fitted = |datum, after| Fitted { datum, before: None, fitted: Some((after, 0.1)) };
    let data = vec![
        fitted(FitParameter::Acceleration(axis), 3123.456),
        fitted(FitParameter::ToolChange, 3.5),
        fitted(FitParameter::M(8, row), 0.25),
    ];
    let calibration = Calibration { data, lines: Vec::new() };
    let text = "[time]\ntool_change = 0\n\n[[axes]]\nname = \"X\"\nrapid = 1\n";
    let made = report::definition(text, &trial.machine, &calibration).unwrap();
    let table: toml::Table = toml::from_str(&made).unwrap();
    assert_eq!(table["time"]["tool_change"].as_float(), Some(3.5));
    assert_eq!(table["time"]["m_codes"]["8"].as_float(), Some(0.25));
    assert_eq!(table["axes"][0]["acceleration"].as_float(), Some(3123.0));
}

/// The time of one rapid move says nothing about the rate and the acceleration of its axis apart, and nothing at all about
/// data without a measured line.
#[test]
fn data_that_are_not_determined_keep_their_values() {
    let mut trial = trial(|_| {});
    trial.lines = Lines::from([(3, 2.5), (13, 400.0)]);
    let calibration = trial.calibrate().unwrap();
    let open: Vec<_> = calibration.data.iter().filter(|one| one.fitted.is_none()).collect();
    assert!(!open.is_empty(), "{calibration:#?}");
    for one in &open {
        assert_eq!(one.after(), one.datum.value(&trial.machine));
    }
    for one in &calibration.data {
        assert!(one.after().is_none_or(|value| value.is_finite() && value <= MOST), "{one:?}");
    }
    let base = "[[axes]]\nname = \"X\"\nrapid = 1\n\n[[axes]]\nname = \"Z\"\nrapid = 2\n";
    let made = report::definition(base, &trial.machine, &calibration).unwrap();
    assert!(!made.contains("inf"), "{made}");
    let text = report::text(&trial.machine, &calibration, false);
    assert!(text.contains("not determined, unchanged"), "{text}");
}
