//! `counterpoint calibrate`: fits the times of a machine to measured times of the lines of a program.
//!
//! The program runs in this process with other data of the machine until the squares of the differences are least.
//! *Invariant:* the values reported as fitted are those with which the machine runs; data that the measured times do not
//! determine keep their values.

mod data;
mod fit;
mod measured;
mod report;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use counterpoint_kernel::control::JobControl;
use counterpoint_kernel::event::event::Event;
use counterpoint_kernel::files::{JobFiles as _, MemoryFiles};
use counterpoint_kernel::job::{Job, LogSink, ProgramSelection, RunEnd, Spec};
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::machine::{Machine, load};
use counterpoint_kernel::options::JobOptions;
use nalgebra::DVector;

use crate::arguments::Calibrate;
use crate::error::Error;
use crate::pack::{self, PackedFiles};
use crate::{changed_machine, machine_folder, own_machine, say};
use data::FitParameter;
use measured::Lines;

/// Smallest value of a datum that is above zero, as its logarithm.
const LEAST: f64 = -14.0;

/// Largest value of a datum: beyond it the measured times do not determine the datum.
const MOST: f64 = 1e9;

/// Measured lines named in a message.
const NAMED: usize = 5;

/// Programs and files of the runs, and the measured times.
struct Trial {
    machine: Machine,
    programs: Vec<ProgramSelection>,
    files: MemoryFiles,
    channel: u16,
    lines: Lines,
}

/// A datum with its values.
#[derive(Debug)]
struct Fitted {
    datum: FitParameter,
    before: Option<f64>,
    /// The fitted value with its standard error, if the measurements determine the datum; otherwise it is unchanged.
    fitted: Option<(f64, f64)>,
}

impl Fitted {
    /// The value with which the machine runs, if it has one.
    fn after(&self) -> Option<f64> {
        self.fitted.map(|(value, _)| value).or(self.before)
    }
}

/// The output.
#[derive(Debug)]
struct Calibration {
    data: Vec<Fitted>,
    /// Line, seconds measured, before and after.
    lines: Vec<(u32, [f64; 3])>,
}

/// Executes the command.
pub(crate) fn calibrate(arguments: &Calibrate) -> Result<u8, Error> {
    let lines = measured::read(&arguments.measured)?;
    let trial = Trial::new(arguments, lines)?;
    let calibration = trial.calibrate()?;
    let machine = &trial.machine;
    if arguments.json {
        say::data(report::json(machine, &calibration)?.as_bytes())?;
    } else {
        say::data(report::text(machine, &calibration, arguments.verbose).as_bytes())?;
    }
    for doubt in report::doubts(machine, &calibration) {
        say::status_line(format_args!("warning: {doubt}"));
    }
    if calibration.data.iter().all(|datum| datum.fitted.is_none()) {
        return Err(Error::Usage(
            "the measured times determine no datum of the machine: check that they belong to this program, and measure more \
             lines"
                .to_owned(),
        ));
    }
    if let Some(folder) = &arguments.out {
        write(folder, &arguments.machine, machine, &calibration)?;
    }
    Ok(0)
}

/// Writes a folder for a machine with the fitted data, based on a shipped one.
fn write(folder: &Path, from: &str, machine: &Machine, calibration: &Calibration) -> Result<(), Error> {
    if machine_folder::is_folder(from) {
        let text = format!("--out needs a shipped machine to base on: put the values into {from}/machine.toml");
        return Err(Error::Usage(text));
    }
    own_machine::create_with(folder, from, |text| report::definition(&text, machine, calibration))
}

impl Trial {
    fn new(arguments: &Calibrate, lines: Lines) -> Result<Self, Error> {
        let (name, machine) = changed_machine::machine(&arguments.machine, &[])?;
        let PackedFiles(packed) = machine;
        let mut files = MemoryFiles::default();
        for (path, blob) in packed {
            files.insert(path, blob.content());
        }
        let loaded = load(&Overlay::over_shipped(files), &name);
        let Some(machine) = loaded.machine else {
            let findings: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
            let text = format!("machine '{}' cannot be used: {}", arguments.machine, findings.join("; "));
            return Err(Error::Usage(text));
        };
        if !machine.channels.iter().any(|channel| channel.number == arguments.channel) {
            return Err(Error::Usage(format!("machine '{}' has no channel {}", arguments.machine, arguments.channel)));
        }
        let packed = pack::job(&arguments.inputs())?;
        let mut files = MemoryFiles::default();
        for (path, blob) in packed.files.0 {
            files.insert(path, blob.content());
        }
        let program = |program: counterpoint_proto::v1::Program| ProgramSelection {
            file: program.path,
            number: program.number,
            section: program.section,
            channel: None,
        };
        let programs = packed.programs.into_iter().map(program).collect();
        Ok(Self { machine, programs, files, channel: arguments.channel, lines })
    }

    /// Fits the data.
    fn calibrate(&self) -> Result<Calibration, Error> {
        let events = self.run(self.machine.clone())?;
        let before = self.seconds(&events);
        let file = self.programs.first().map(|program| program.file.as_str()).unwrap_or_default();
        let text = self.files.read(file).map(|text| String::from_utf8_lossy(&text).into_owned()).unwrap_or_default();
        let texts: Vec<&str> = text.lines().collect();
        let measured = self.lines.keys().filter_map(|line| texts.get((*line as usize).checked_sub(1)?).copied());
        let mut data = FitParameter::of(&self.machine, self.channel, &events);
        data.extend(FitParameter::of_codes(&self.machine, measured));
        let started = self.with(&data, &data.iter().map(|datum| self.parameter(datum)).collect::<Vec<_>>());
        let untouched = self.differences(&self.seconds(&self.run(started)?));
        // A datum that changes no measured line cannot be fitted.
        let mut kept = Vec::new();
        for datum in data {
            let start = self.parameter(&datum);
            let step = if datum.is_factor() { 0.5 } else { 0.1 };
            let mut all: Vec<(FitParameter, f64)> =
                kept.iter().map(|datum| (FitParameter::clone(datum), self.parameter(datum))).collect();
            all.push((datum.clone(), start + step));
            let (data, values): (Vec<FitParameter>, Vec<f64>) = all.into_iter().unzip();
            let moved = self.differences(&self.seconds(&self.run(self.with(&data, &values))?));
            if (moved - &untouched).amax() > 1e-9 {
                kept.push(datum);
            }
        }
        if kept.is_empty() {
            let lines: Vec<String> = self.lines.keys().take(NAMED).map(u32::to_string).collect();
            return Err(Error::Usage(format!(
                "nothing to calibrate: no datum of the machine changes the time of a measured line ({}); measure more lines, such \
                 as rapid moves, tool changes and codes that take time",
                lines.join(", ")
            )));
        }
        // Data that are not determined keep their values, and the others are fitted again without them.
        let mut open = Vec::new();
        let fit = loop {
            let start: Vec<f64> = kept.iter().map(|datum| self.parameter(datum)).collect();
            let steps: Vec<f64> = kept.iter().map(|datum| if datum.is_factor() { 1e-3 } else { 1e-4 }).collect();
            let fit = fit::fit(start, &steps, |values| {
                Ok::<_, Error>(self.differences(&self.seconds(&self.run(self.with(&kept, values))?)))
            })?;
            let found = kept.iter().zip(&fit.values).zip(&fit.errors);
            let is_open = |((datum, value), error): ((&FitParameter, &f64), &Option<f64>)| {
                let value = actual(datum, *value);
                let error = error.map(|error| if datum.is_factor() { error * value } else { error });
                !value.is_finite() || value > MOST || !error.is_some_and(f64::is_finite)
            };
            match found.map(is_open).collect::<Vec<_>>().iter().rposition(|open| *open) {
                Some(at) => open.push(kept.remove(at)),
                None => break fit,
            }
        };
        let after = self.seconds(&self.run(self.with(&kept, &fit.values))?);
        let found = kept.into_iter().zip(fit.values).zip(fit.errors).map(|((datum, value), error)| {
            let after = actual(&datum, value);
            let error = error.map(|error| if datum.is_factor() { error * after } else { error });
            Fitted { before: datum.value(&self.machine), fitted: error.map(|error| (after, error)), datum }
        });
        let unchanged = |datum: FitParameter| Fitted { before: datum.value(&self.machine), fitted: None, datum };
        let data = found.chain(open.into_iter().rev().map(unchanged));
        let of = |times: &BTreeMap<u32, f64>, line: &u32| times.get(line).copied().unwrap_or(0.0);
        let lines = self.lines.iter().map(|(line, seconds)| (*line, [*seconds, of(&before, line), of(&after, line)]));
        Ok(Calibration { data: data.collect(), lines: lines.collect() })
    }

    /// A datum as it is fitted.
    fn parameter(&self, datum: &FitParameter) -> f64 {
        let value = datum.start(&self.machine);
        if datum.is_factor() { value.max(1e-6).ln() } else { value }
    }

    /// The machine with other data.
    fn with(&self, data: &[FitParameter], values: &[f64]) -> Machine {
        let mut machine = self.machine.clone();
        for (datum, value) in data.iter().zip(values) {
            datum.put(&mut machine, actual(datum, *value));
        }
        machine
    }

    fn run(&self, machine: Machine) -> Result<Vec<Event>, Error> {
        let control = JobControl::new(machine.channels.len());
        let options = JobOptions { threads: 1, ..JobOptions::default() };
        let spec = Spec { machine: Arc::new(machine), programs: self.programs.clone(), options };
        let job = Job::prepare(spec, &self.files).map_err(|error| Error::Usage(error.to_string()))?;
        let mut sink = Timed { channel: self.channel, events: Vec::new() };
        let outcome: RunEnd = job.run(&self.files, &control, &mut sink);
        if outcome.cancelled {
            return Err(Error::Usage("the run was cancelled".to_owned()));
        }
        Ok(sink.events)
    }

    /// Seconds of each line of the first program; the time of a shipped cycle belongs to the line that calls it.
    fn seconds(&self, events: &[Event]) -> BTreeMap<u32, f64> {
        let mut lines = BTreeMap::new();
        let main = events.iter().find(|event| event.line > 0).map(|event| event.file);
        for (event, place) in events.iter().map(|event| (event, event.user_place())) {
            if Some(place.file) == main && place.is_some() {
                *lines.entry(place.line).or_insert(0.0) += event.dur_ns as f64 / 1e9;
            }
        }
        lines
    }

    fn differences(&self, seconds: &BTreeMap<u32, f64>) -> DVector<f64> {
        let of = |line: &u32| seconds.get(line).copied().unwrap_or(0.0);
        DVector::from_iterator(self.lines.len(), self.lines.iter().map(|(line, measured)| of(line) - measured))
    }
}

/// The value of a datum from its fitted parameter.
fn actual(datum: &FitParameter, value: f64) -> f64 {
    if datum.is_factor() { value.max(LEAST).exp() } else { value.max(0.0) }
}

/// Keeps the events of a channel.
struct Timed {
    channel: u16,
    events: Vec<Event>,
}

impl LogSink for Timed {
    fn events(&mut self, _first_seq: u64, batch: &[Event]) -> bool {
        self.events.extend(batch.iter().filter(|event| event.channel == self.channel).cloned());
        true
    }
}
