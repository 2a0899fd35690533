//! The data of a machine that measured times can say something about.
//!
//! *Invariant:* a datum stays within its bounds; positive data are fitted by their logarithm, so a step is a factor.

use counterpoint_kernel::event::event::{Event, Kind, MotionKind};
use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::ident::kind::CodeKind;
use counterpoint_kernel::machine::index::{AxisId, CodeRowId};
use counterpoint_kernel::machine::rows::{CodeForm, CodeRow};

/// Acceleration of an axis that has none, mm/s² or degrees/s².
const ACCELERATION: f64 = 2000.0;

/// A datum.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum FitParameter {
    /// Acceleration of an axis, units per second squared.
    Acceleration(AxisId),
    /// Rapid rate of an axis, units per minute.
    Rapid(AxisId),
    /// `corner_deviation`.
    CornerDeviation,
    /// `block_time`.
    BlockTime,
    /// `tool_change`.
    ToolChange,
    /// `tool_step`.
    ToolStep,
    /// Seconds of an M number.
    M(u32, CodeRowId),
}

impl FitParameter {
    /// The data that the events of a run depend on.
    pub(crate) fn of(machine: &Machine, channel: u16, events: &[Event]) -> Vec<Self> {
        let mut all = Vec::new();
        let own = machine.channels.iter().find(|own| own.number == channel);
        let axes: Vec<AxisId> = own.map(|own| own.axes.iter().copied().collect()).unwrap_or_default();
        let moves = |at: usize, rapid: Option<bool>| {
            events.iter().any(|event| match &event.kind {
                Kind::Motion(motion) => {
                    let fits = rapid.is_none_or(|rapid| rapid == (motion.kind == MotionKind::Rapid));
                    fits && motion.moving & 1 << at != 0
                }
                _ => false,
            })
        };
        all.extend((0..).zip(&axes).filter(|(at, _)| moves(*at, None)).map(|(_, axis)| Self::Acceleration(*axis)));
        all.extend((0..).zip(&axes).filter(|(at, _)| moves(*at, Some(true))).map(|(_, axis)| Self::Rapid(*axis)));
        if (0..axes.len()).any(|at| moves(at, Some(false))) {
            all.extend([Self::CornerDeviation, Self::BlockTime]);
        }
        if events.iter().any(|event| matches!(event.kind, Kind::Tool(_))) {
            all.push(Self::ToolChange);
            if machine.time.stations > 0 {
                all.push(Self::ToolStep);
            }
        }
        all
    }

    /// The M numbers in texts of blocks, comments left out.
    pub(crate) fn of_codes<'t>(machine: &Machine, texts: impl Iterator<Item = &'t str>) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for text in texts {
            for number in m_numbers(text) {
                // Codes that change tools have their times in `tool_change`.
                let takes = |row: &CodeRow| row.enable && !matches!(row.id.kind(), CodeKind::Tool);
                let row = machine.codes.find(|row| is_m(machine, &row.form, number) && takes(row));
                if let Some(row) =
                    row.filter(|_| !all.iter().any(|known| matches!(known, Self::M(m, _) if *m == number)))
                {
                    all.push(Self::M(number, row));
                }
            }
        }
        all
    }

    /// Its name in reports.
    pub(crate) fn name(&self, machine: &Machine) -> String {
        match self {
            Self::Acceleration(axis) => format!("acceleration of {}", machine.axes[*axis].name),
            Self::Rapid(axis) => format!("rapid of {}", machine.axes[*axis].name),
            Self::CornerDeviation => "corner_deviation".to_owned(),
            Self::BlockTime => "block_time".to_owned(),
            Self::ToolChange => "tool_change".to_owned(),
            Self::ToolStep => "tool_step".to_owned(),
            Self::M(number, _) => format!("M{number}"),
        }
    }

    /// Its unit.
    pub(crate) fn unit(&self) -> &'static str {
        match self {
            Self::Acceleration(_) => "/s²",
            Self::Rapid(_) => "/min",
            Self::CornerDeviation => "",
            Self::BlockTime | Self::ToolChange | Self::ToolStep | Self::M(..) => "s",
        }
    }

    /// Whether it is above zero, and a step of it is a factor.
    pub(crate) fn is_factor(&self) -> bool {
        matches!(self, Self::Acceleration(_) | Self::Rapid(_) | Self::CornerDeviation)
    }

    /// Its value on a machine.
    pub(crate) fn value(&self, machine: &Machine) -> Option<f64> {
        match self {
            Self::Acceleration(axis) => machine.axes[*axis].dynamics.acceleration,
            Self::Rapid(axis) => Some(machine.axes[*axis].rapid),
            Self::CornerDeviation => machine.time.corner_deviation,
            Self::BlockTime => Some(machine.time.block_time),
            Self::ToolChange => Some(machine.time.tool_change),
            Self::ToolStep => Some(machine.time.tool_step),
            Self::M(_, row) => Some(machine.codes[*row].seconds),
        }
    }

    /// Where the fit begins.
    pub(crate) fn start(&self, machine: &Machine) -> f64 {
        let inch = machine.unit == counterpoint_kernel::event::info::MachineUnit::Inch;
        let length = if inch { 1.0 / 25.4 } else { 1.0 };
        self.value(machine).unwrap_or(match self {
            Self::Acceleration(axis) if !machine.axes[*axis].role.is_rotary() => ACCELERATION * length,
            Self::Acceleration(_) => ACCELERATION,
            _ => 0.01 * length,
        })
    }

    /// Makes a value active.
    pub(crate) fn put(&self, machine: &mut Machine, value: f64) {
        match self {
            Self::Acceleration(axis) => machine.axes[*axis].dynamics.acceleration = Some(value),
            Self::Rapid(axis) => machine.axes[*axis].rapid = value,
            Self::CornerDeviation => machine.time.corner_deviation = Some(value),
            Self::BlockTime => machine.time.block_time = value,
            Self::ToolChange => machine.time.tool_change = value,
            Self::ToolStep => machine.time.tool_step = value,
            Self::M(_, row) => machine.codes[*row].seconds = value,
        }
    }
}

/// Whether a row is a code with this M number alone.
fn is_m(machine: &Machine, form: &CodeForm, number: u32) -> bool {
    let (register, min, max) = match form {
        CodeForm::Register { register, min, max } | CodeForm::RegisterAsData { register, min, max, .. } => {
            (*register, *min, *max)
        }
        CodeForm::Text(_) | CodeForm::NotApplicable => return false,
    };
    machine.registers[register].name == "M" && min == f64::from(number) && max == min
}

/// M numbers of a block, without those in parentheses or after a semicolon.
fn m_numbers(text: &str) -> Vec<u32> {
    let mut numbers = Vec::new();
    let (mut depth, mut rest) = (0_u32, text);
    while let Some(first) = rest.chars().next() {
        rest = rest.get(first.len_utf8()..).unwrap_or_default();
        match first {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            ';' => break,
            'M' | 'm' if depth == 0 => {
                let digits: String = rest.chars().take_while(char::is_ascii_digit).collect();
                numbers.extend(digits.parse::<u32>().ok());
            }
            _ => {}
        }
    }
    numbers
}

#[cfg(test)]
mod tests {
    use super::m_numbers;

    #[test]
    fn m_numbers_outside_of_comments() {
        assert_eq!(m_numbers("N10 G1 X5 M8 (M9) m03"), [8, 3]);
        assert_eq!(m_numbers("M6 T1 ; M7"), [6]);
        assert_eq!(m_numbers("X1"), Vec::<u32>::new());
    }
}
