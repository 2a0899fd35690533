// replaced when kernel::machine::{load, package, show} lands
//! Stand-in for the machine loader: every folder with a `machine.toml` is a machine of two channels with X and Z
//! (one channel when "mill" is in its name).

pub(crate) mod load {
    use counterpoint_kernel::files::Files;
    use counterpoint_kernel::log::info::Unit;
    use counterpoint_kernel::machine::Machine;
    use counterpoint_kernel::machine::finding::Finding;
    use counterpoint_kernel::machine::ident::DataId;
    use counterpoint_kernel::machine::model::*;

    pub(crate) struct Loaded {
        pub(crate) machine: Option<Machine>,
        pub(crate) findings: Vec<Finding>,
    }

    pub(crate) fn load(files: &dyn Files, folder: &str) -> Loaded {
        let path = format!("{folder}/machine.toml");
        let text = files.read(&path).map(|b| String::from_utf8_lossy(&b).into_owned());
        match text {
            Err(error) => Loaded { machine: None, findings: vec![Finding::error(path, 0, 0, error.to_string())] },
            Ok(text) if text.starts_with('!') => {
                Loaded { machine: None, findings: vec![Finding::error(path, 1, 1, "unexpected '!'")] }
            }
            Ok(_) => Loaded { machine: Some(machine(folder)), findings: Vec::new() },
        }
    }

    fn machine(name: &str) -> Machine {
        let axis = |name: &str, role| Axis {
            name: name.to_owned(),
            data: DataId(0),
            role,
            diameter: false,
            rapid: 10_000.0,
            acceleration: None,
            home: 0.0,
            references: [None; 3],
            limits: None,
        };
        let channel =
            |number: u16, name: &str| Channel { number, name: name.to_owned(), axes: vec![0, 1], spindle: None };
        let mut channels = vec![channel(1, "UPPER"), channel(2, "LOWER")];
        channels.truncate(if name.contains("mill") { 1 } else { 2 });
        Machine {
            name: name.to_owned(),
            number: 1,
            revision: 1,
            author: String::new(),
            description: "stand-in".to_owned(),
            unit: Unit::Mm,
            kind: MachineKind::Lathe,
            preprocessor: Preprocessor::None,
            format: Format {
                rws: String::new(),
                rws_at: RewindStop::None,
                comment: None,
                message: None,
                opskip_mark: None,
                opskip_default: 1,
                eob: None,
            },
            registers: Vec::new(),
            codes: Vec::new(),
            data: Vec::new(),
            custom_codes: Vec::new(),
            custom_data: Vec::new(),
            axes: vec![axis("X", AxisRole::X), axis("Z", AxisRole::Z)],
            channels,
            spindles: Vec::new(),
            initial: Vec::new(),
            subprograms: Subprograms {
                placement: Placement::SameFile,
                extension: String::new(),
                call: CallForm::Number,
                repeat_is_executions: true,
                main_return: MainReturn::End,
            },
            sync: Sync {
                dialect: SyncDialect::None,
                paths: PathsForm::Bits,
                alarm_scope: AlarmScope::Own,
                release_ns: 0,
                poll_ns: 0,
            },
            time: Time {
                tool_change: 0.0,
                tool_step: 0.0,
                stations: 0,
                rapid: RapidPath::SlowestAxis,
                spindle_speed: 0.0,
            },
            variables: Variables { shared: Vec::new(), channel: Vec::new() },
            tool: Tool { offset_digits: 2, offsets: Vec::new() },
            work_offsets: Vec::new(),
        }
    }
}

pub(crate) mod package {
    use counterpoint_kernel::files::Memory;

    pub(crate) fn shipped() -> Memory {
        let mut files = Memory::default();
        files.insert("fanuc-mill/machine.toml", "");
        files.insert("fanuc-2path-lathe/machine.toml", "");
        files
    }
}

pub(crate) mod show {
    use counterpoint_kernel::machine::Machine;

    pub(crate) fn text(machine: &Machine, section: &str) -> String {
        format!("{} {section}\n", machine.name)
    }

    pub(crate) fn json(machine: &Machine, section: &str) -> String {
        format!("{{\"name\":{:?},\"section\":{section:?}}}\n", machine.name)
    }
}
