//! Statements between channels: `WAITM(mark, channels)`, `SETM(marks)`, `WAITE(channels)`, `INIT(channel, program)` and
//! the like.
//!
//! Facts: reference channel-synchronisation.md 1.4, scenario M06. Data of the machine define the statements, the events
//! they wait for and their marks; the arguments are read here. A channel may be given by its name, unless a variable
//! has that name.

use super::compiled::{SiemensArgument, as_name};
use super::value::Data;
use super::{Outcome, Siemens, SiemensBlockError};
use counterpoint_control_api::host::{InterpreterHost, Operands};
use counterpoint_fault as diag;

fn wrong<T>(text: String) -> Outcome<T> {
    Err(SiemensBlockError::Alarm(&diag::STATEMENT_ARGUMENTS, text))
}

impl Siemens {
    /// Executes a statement between channels; whether it is one.
    pub(super) fn coordination(
        &mut self,
        host: &mut dyn InterpreterHost,
        name: &str,
        arguments: &[SiemensArgument],
    ) -> Outcome<bool> {
        let Some(operands) = host.coordinates(name) else { return Ok(false) };
        if host.reads_contour() {
            return Err(SiemensBlockError::Alarm(&diag::CONTOUR_CODE, format!("a contour has no {name}")));
        }
        match operands {
            Operands::Program => return self.select(host, name, arguments).map(|()| true),
            Operands::Axes => return self.exchange(host, name, (arguments, 1)).map(|()| true),
            Operands::AxesAndChannels => return self.exchange(host, name, (arguments, 2)).map(|()| true),
            Operands::MarkAndChannels | Operands::Channels | Operands::Marks => {}
        }
        let mut numbers = Vec::with_capacity(arguments.len());
        for (at, argument) in arguments.iter().enumerate() {
            let is_channel = match operands {
                Operands::MarkAndChannels => at > 0,
                Operands::Channels => true,
                _ => false,
            };
            numbers.push(self.mark_or_channel(host, (name, argument), is_channel)?);
        }
        match (operands, numbers.as_slice()) {
            (Operands::MarkAndChannels, [mark, channels @ ..]) if !channels.is_empty() => {
                host.coordinate(name, *mark, channels)?;
            }
            (Operands::Channels, channels) if !channels.is_empty() => host.coordinate(name, 0, channels)?,
            (Operands::Marks, marks) if !marks.is_empty() => {
                for mark in marks {
                    host.coordinate(name, *mark, &[])?;
                }
            }
            (Operands::MarkAndChannels, _) => return wrong(format!("{name} needs a mark and channels")),
            (Operands::Channels, _) => return wrong(format!("{name} needs a channel")),
            _ => return wrong(format!("{name} needs a mark")),
        }
        Ok(true)
    }

    /// GET, GETD and RELEASE: axes; AXTOCHAN: pairs of an axis and a channel.
    fn exchange(
        &mut self,
        host: &mut dyn InterpreterHost,
        statement: &str,
        (arguments, each): (&[SiemensArgument], usize),
    ) -> Outcome<()> {
        if arguments.is_empty() || !arguments.len().is_multiple_of(each) {
            let needs = if each == 2 { "pairs of an axis and a channel" } else { "an axis" };
            return wrong(format!("{statement} needs {needs}"));
        }
        for pair in arguments.chunks(each) {
            let [axis, channel @ ..] = pair else { continue };
            let axis = self.axis_or_spindle(host, (statement, axis))?;
            let channel = match channel {
                [channel] => Some(self.mark_or_channel(host, (statement, channel), true)?),
                _ => None,
            };
            host.exchange(statement, &axis, channel)?;
        }
        Ok(())
    }

    /// Name of an axis or a spindle as an argument: `C1`, `S2`, `SPI(2)`, a variable of the type AXIS, a text.
    fn axis_or_spindle(
        &mut self,
        host: &mut dyn InterpreterHost,
        (statement, argument): (&str, &SiemensArgument),
    ) -> Outcome<String> {
        if let Ok(Some(expression)) = &argument.value
            && let Some(name) = as_name(expression)
            && name.index.is_empty()
            && !self.variables.knows(&name.name)
        {
            return Ok(name.name.clone());
        }
        let spindle = argument.text.trim().to_ascii_uppercase();
        if let Some(number) = spindle.strip_prefix("SPI(").and_then(|rest| rest.strip_suffix(')')) {
            return Ok(format!("S{}", number.trim()));
        }
        match self.argument(host, argument)? {
            Some(Data::Axis(name) | Data::Text(name)) => Ok(name),
            _ => wrong(format!("{} is not an axis for {statement}", argument.text)),
        }
    }

    /// INIT: a channel, the path of its program, and whether a program that is missing is reported here (`"S"`, as
    /// without) or at the start (`"N"`).
    fn select(
        &mut self,
        host: &mut dyn InterpreterHost,
        statement: &str,
        arguments: &[SiemensArgument],
    ) -> Outcome<()> {
        let ([channel, path] | [channel, path, _]) = arguments else {
            return wrong(format!("{statement} needs a channel and a program"));
        };
        let channel = self.mark_or_channel(host, (statement, channel), true)?;
        let path = match self.argument(host, path)? {
            Some(Data::Text(path)) if !path.trim().is_empty() => path.trim().to_owned(),
            _ => return wrong(format!("{statement} needs the name of a program as a text")),
        };
        let waits = match arguments.get(2) {
            Some(mode) => self.argument(host, mode)?.is_none_or(|mode| !mode.text().eq_ignore_ascii_case("N")),
            None => true,
        };
        let found = self.program_by_path(host, &path)?;
        if found.is_none() && waits {
            let text = format!("program {path} for channel {channel} not found");
            return Err(SiemensBlockError::Alarm(&diag::CHANNEL_NOT_STARTED, text));
        }
        Ok(host.select(channel, &path, found)?)
    }

    /// An argument as a number; a channel may have a name.
    fn mark_or_channel(
        &mut self,
        host: &mut dyn InterpreterHost,
        (statement, argument): (&str, &SiemensArgument),
        is_channel: bool,
    ) -> Outcome<i64> {
        if let Ok(Some(expression)) = &argument.value
            && is_channel
            && let Some(name) = as_name(expression)
            && name.index.is_empty()
            && !self.variables.knows(&name.name)
            && let Some(channel) = host.channel_named(&name.name)
        {
            return Ok(channel.into());
        }
        let Some(value) = self.argument(host, argument)? else {
            return wrong(format!("an argument of {statement} is missing"));
        };
        let number = super::conversions::number(&value)?;
        if number.fract() != 0.0 || number.abs() > 1e9 {
            return wrong(format!("{} is not a valid mark or channel of {statement}", argument.text));
        }
        Ok(number as i64)
    }
}
