//! What codes do. One file an idea; this one tells which code goes where.
//!
//! Facts: reference control-emulator.md 6. Invariant: an action takes its data in the documented order (feed before
//! axes) and never touches another channel except through a shared operation.

pub(crate) mod arc;
mod change_point;
pub(crate) mod clamp;
pub(crate) mod compensation;
pub(crate) mod coolant;
pub(crate) mod cutter;
pub(crate) mod cycle;
mod dwell;
pub(crate) mod frame;
mod head;
mod home;
pub(crate) mod local;
mod mode;
mod motion;
mod offsets;
mod polar;
mod rates;
pub(crate) mod skip;
pub(crate) mod spindle;
pub(crate) mod spindles;

mod stop;
pub(crate) mod subprogram;
pub(crate) mod sync;
pub(crate) mod thread;
mod time;
pub(crate) mod tip;
mod tool;
pub(crate) mod tool_data;
mod turned;
pub(crate) mod turning;

use crate::channel::Kernel;
use crate::log::event::{Direction, Stop};
use crate::machine::ident::{CodeId, DataId, codes, kind};
use crate::machine::model::CodeRow;
use crate::state::block::Firing;
use counterpoint_fault::Acted;
use counterpoint_motion::frame::local::Part;

/// A built-in action.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Action {
    Rapid,
    Linear,
    /// Straight feed over a multiple of the programmed distance.
    LinearTimes(f64),
    Arc(kind::arc::Form),
    ArcSpace,
    ArcCenter,
    ArcRadius,
    /// Clockwise or not, for circles whose code does not say.
    ArcDirection(bool),
    Thread(kind::thread::Change),
    ThreadOff,
    Probe,
    ThreadCycle(kind::thread::Kind),
    ThreadSetting(kind::thread::Setting),
    Dwell,
    DwellRevolutions,
    /// A modal state with its listing words; the kernel reads it from the group.
    Mode(&'static str),
    Units {
        secondary: bool,
    },
    ExactStopBlock,
    MachineFrame,
    GoHome,
    GoHomeNth,
    GoHomeReturn,
    Preset,
    WorkOffset,
    WorkOffsetOff,
    /// Length compensation: sign, and its type.
    Length(f64, u8),
    ExtendedOffset,
    OffsetSet,
    DynamicFixture(bool),
    Corner {
        arc: bool,
    },
    VectorCompensation,
    /// A code of the local frame.
    Local(Part, local::Change),
    Diameter(&'static str),
    Spindle {
        number: u16,
        direction: Direction,
        coolant: Option<bool>,
    },
    Css,
    Rpm,
    MaxRpm,
    CssDriver(u16),
    CssDriverById,
    CssRadial,
    SpindleInWork {
        rear: bool,
    },
    Apply {
        milling: bool,
    },
    Coolant(kind::coolant::Switch),
    Additive(bool),
    ToolSelect,
    ToolLoad,
    ToolPoint,
    ToolPointReturn,
    Head(Option<u32>),
    OtherHead(head::Event),
    Polar {
        cartesian: bool,
    },
    PolarOff,
    Tip(u8),
    TipOff,
    TipFormat(u8),
    Clamp(DataId, bool),
    Unwind(Option<DataId>),
    Stop(Stop),
    Call,
    CallRange,
    Return,
    Sync(sync::Mark),
    Function,
    Cycle(kind::cycle::Kind),
    CycleOn,
    CycleOff,
    Rigid(bool),
}

impl Action {
    /// Action of a code, if the kernel has one.
    pub(crate) fn of(id: CodeId) -> Option<Self> {
        use Action as A;
        Some(match id {
            codes::RAPID => A::Rapid,
            codes::INTERP_LINEAR => A::Linear,
            codes::INTERP_LINEAR_X10 => A::LinearTimes(10.0),
            codes::INTERP_LINEAR_X100 => A::LinearTimes(100.0),
            codes::INTERP_ARC_3D => A::ArcSpace,
            codes::INTERP_DEF_CENTER => A::ArcCenter,
            codes::INTERP_DEF_RADIUS => A::ArcRadius,
            codes::INTERP_DEF_CLW => A::ArcDirection(true),
            codes::INTERP_DEF_CCLW => A::ArcDirection(false),
            codes::INTERP_THREAD => A::Thread(kind::thread::Change::None),
            codes::INTERP_THREAD_ON => A::Thread(kind::thread::Change::May),
            codes::INTERP_THREAD_VAR => A::Thread(kind::thread::Change::Signed),
            codes::INTERP_THREAD_VAR_INC => A::Thread(kind::thread::Change::Up),
            codes::INTERP_THREAD_VAR_DEC => A::Thread(kind::thread::Change::Down),
            codes::INTERP_THREAD_OFF | codes::THREAD_OFF => A::ThreadOff,
            codes::INTERP_SKIP => A::Probe,
            codes::SKIP_ALARM_SIGNAL => A::Mode("skip alarm signal"),
            codes::SKIP_ALARM_SILENT => A::Mode("skip alarm silent"),
            codes::DELAY => A::Dwell,
            codes::DELAY_REV => A::DwellRevolutions,
            codes::PLANE_XY => A::Mode("plane xy"),
            codes::PLANE_ZX => A::Mode("plane zx"),
            codes::PLANE_YZ => A::Mode("plane yz"),
            codes::POSITION_ABSOLUTE => A::Mode("position absolute"),
            codes::POSITION_RELATIVE => A::Mode("position incremental"),
            codes::XAXIS_DIAMETER => A::Mode("x diameter"),
            codes::XAXIS_RADIUS => A::Mode("x radius"),
            codes::FEED_UPM => A::Mode("feed per minute"),
            codes::FEED_UPR => A::Mode("feed per revolution"),
            codes::FEED_1T => A::Mode("feed inverse time"),
            codes::EXACTSTOP_ON => A::Mode("exact stop on"),
            codes::EXACTSTOP_OFF => A::Mode("exact stop off"),
            codes::CYCLE_OFF => A::CycleOff,
            codes::CYCLE_ON => A::CycleOn,
            codes::RIGID_ON => A::Rigid(true),
            codes::RIGID_OFF => A::Rigid(false),
            codes::CYCLE_RETRACT_INITIAL => A::Mode("cycle retract initial"),
            codes::CYCLE_RETRACT_R => A::Mode("cycle retract r"),
            codes::UNITS_PRIMARY => A::Units { secondary: false },
            codes::UNITS_SECONDARY => A::Units { secondary: true },
            codes::EXACTSTOP => A::ExactStopBlock,
            codes::POSITION_MACHINE => A::MachineFrame,
            codes::GOHOME => A::GoHome,
            codes::GOHOME_NTH => A::GoHomeNth,
            codes::GOHOME_RETURN => A::GoHomeReturn,
            codes::POSITION_PRESET => A::Preset,
            codes::COMP_WORKP_ON => A::WorkOffset,
            codes::COMP_WORKP_OFF => A::WorkOffsetOff,
            codes::COMP_LENGTH_ON => A::Length(1.0, 1),
            codes::COMP_LENGTH_ON_NEG => A::Length(-1.0, 1),
            codes::COMP_LENGTH2_ON => A::Length(1.0, 2),
            codes::COMP_LENGTH3_ON => A::Length(1.0, 3),
            codes::COMP_LENGTH4_ON => A::Length(1.0, 4),
            codes::COMP_LENGTH_OFF => A::Length(0.0, 1),
            codes::COMP_EXTFIXT | codes::COMP_EXTFIXT_RANGE => A::ExtendedOffset,
            codes::OFFSET_SET => A::OffsetSet,
            codes::COMP_DYN_FIXT_ON => A::DynamicFixture(true),
            codes::COMP_DYN_FIXT_OFF => A::DynamicFixture(false),
            codes::COMP_CORNER_ARC => A::Corner { arc: true },
            codes::COMP_CORNER_LINEAR => A::Corner { arc: false },
            codes::COMP_3D_VECTOR => A::VectorCompensation,
            codes::COMP_DIAM_OFF => A::Diameter("off"),
            codes::COMP_DIAM_LEFT => A::Diameter("left"),
            codes::COMP_DIAM_RIGHT => A::Diameter("right"),
            codes::SPINDLE_CSS => A::Css,
            codes::SPINDLE_RPM => A::Rpm,
            codes::SPINDLE_MAXRPM => A::MaxRpm,
            codes::SPINDLE_CSS_MAIN => A::CssDriver(1),
            codes::SPINDLE_CSS_SIDE => A::CssDriver(2),
            codes::SPINDLE_CSS_ID => A::CssDriverById,
            codes::SPINDLE_CSS_RADIAL => A::CssRadial,
            codes::SPINDLE_FRONT => A::SpindleInWork { rear: false },
            codes::SPINDLE_REAR => A::SpindleInWork { rear: true },
            codes::APPLY_TURN => A::Apply { milling: false },
            codes::APPLY_MILL => A::Apply { milling: true },
            codes::C2P_CART_ON => A::Polar { cartesian: true },
            codes::C2P_POLAR_ON => A::Polar { cartesian: false },
            codes::C2P_CART_OFF | codes::C2P_POLAR_OFF => A::PolarOff,
            codes::RTCP_ON => A::Tip(1),
            codes::RTCP2_ON => A::Tip(2),
            codes::RTCP_OFF => A::TipOff,
            codes::AM_ON => A::Additive(true),
            codes::AM_OFF => A::Additive(false),
            codes::TOOL_SELECT => A::ToolSelect,
            codes::TOOL_LOAD => A::ToolLoad,
            codes::TOOL_LOAD_POINT => A::ToolPoint,
            codes::TOOL_LOAD_RETURN => A::ToolPointReturn,
            codes::HEAD_MAIN => A::Head(Some(1)),
            codes::HEAD_SIDE => A::Head(Some(2)),
            codes::HEAD_ID => A::Head(None),
            codes::STOP => A::Stop(Stop::Program),
            codes::OPSTOP => A::Stop(Stop::Optional),
            codes::END => A::Stop(Stop::End),
            codes::REWIND => A::Stop(Stop::Rewind),
            codes::CALSUB_ID => A::Call,
            codes::CALSUB_RANGE => A::CallRange,
            codes::CALSUB_RETURN => A::Return,
            codes::SYNC_REG => A::Sync(sync::Mark::Word),
            codes::SYNC_REG_MAIN => A::Sync(sync::Mark::Main),
            codes::SYNC_REG_SIDE => A::Sync(sync::Mark::Side),
            codes::SYNC_REG_START => A::Sync(sync::Mark::Start),
            codes::SYNC_REG_STOP => A::Sync(sync::Mark::Stop),
            codes::SYNC_START_MAIN => A::Sync(sync::Mark::StartBy(1)),
            codes::SYNC_START_SIDE => A::Sync(sync::Mark::StartBy(2)),
            codes::FUNCTION => A::Function,
            _ => {
                let local = || local::of(id).map(|(part, change)| A::Local(part, change));
                let head = || head::of(id).map(A::OtherHead);
                let clamp = || kind::axis::clamp_of(id).map(|(axis, on)| A::Clamp(axis, on));
                let unwind = || kind::axis::unwinds(id).map(A::Unwind);
                let one_axis = || clamp().or_else(unwind).or_else(|| tip::format_of(id).map(A::TipFormat));
                let arc = || kind::arc::Form::of(id).map(A::Arc);
                let setting = || kind::thread::Setting::of(id).map(A::ThreadSetting);
                let thread = || kind::thread::Kind::of(id).map(A::ThreadCycle).or_else(setting);
                let own = kind::cycle::Kind::of(id).map(A::Cycle).or_else(arc).or_else(thread);
                let own = own.or_else(|| kind::coolant::of(id).map(A::Coolant)).or_else(local).or_else(head);
                return own.or_else(one_axis).or_else(|| spindle_code(id));
            }
        })
    }

    /// A motion code of the program, which meets an active cycle.
    fn moves(self) -> bool {
        matches!(
            self,
            Self::Rapid
                | Self::Linear
                | Self::LinearTimes(_)
                | Self::Arc(_)
                | Self::ArcSpace
                | Self::Thread(_)
                | Self::ThreadCycle(_)
                | Self::Probe
        )
    }
}

/// Spindle codes: the channel's own spindle (0) or a numbered one.
fn spindle_code(id: CodeId) -> Option<Action> {
    let name = crate::machine::ident::code_facts(id)?.name.strip_prefix("CODE_SPINDLE")?;
    let (number, rest) = match name.split_once('_')? {
        ("", rest) => (0, rest),
        (digits, rest) => (digits.parse().ok()?, rest),
    };
    let (rest, coolant) = match rest.strip_suffix("_COOLNT") {
        Some(rest) => (rest, Some(rest != "OFF")),
        None => (rest, None),
    };
    let direction = match rest {
        "CLW" => Direction::Clockwise,
        "CCLW" => Direction::CounterClockwise,
        "OFF" => Direction::Off,
        "LOCK" => Direction::Locked,
        "NEUTRAL" => Direction::Neutral,
        "ORIENT" => Direction::Oriented,
        _ => return None,
    };
    Some(Action::Spindle { number, direction, coolant })
}

/// Carries out an action.
pub(crate) fn act(kernel: &mut Kernel<'_>, action: Action, row: &CodeRow, firing: Firing) -> Acted {
    if kernel.channel.state.cycle.running && !firing.implied && action.moves() {
        cycle::meets_motion(kernel)?;
    }
    if kernel.channel.state.place.frames.is_some() {
        cutter::before(kernel, action)?;
    }
    match action {
        Action::Rapid => motion::rapid(kernel),
        Action::Linear => motion::linear(kernel),
        Action::LinearTimes(factor) => motion::linear_times(kernel, factor),
        Action::Arc(form) => arc::arc(kernel, form, firing),
        Action::ArcSpace => arc::space::through(kernel),
        Action::ArcCenter => arc::define_center(kernel),
        Action::ArcRadius => arc::define_radius(kernel),
        Action::ArcDirection(clockwise) => arc::define_direction(kernel, clockwise),
        Action::Thread(change) => thread::thread(kernel, change, firing),
        Action::ThreadOff => thread::off(kernel),
        Action::Probe => skip::probe(kernel),
        Action::ThreadCycle(kind) => thread::cycle::cycle(kernel, kind),
        Action::ThreadSetting(setting) => thread::cycle::set(kernel, setting),
        Action::Dwell => dwell::seconds(kernel),
        Action::DwellRevolutions => dwell::revolutions(kernel),
        Action::Mode(text) => mode::mode(kernel, text),
        Action::Units { secondary } => mode::units(kernel, secondary),
        Action::ExactStopBlock => mode::exact_stop_block(kernel),
        Action::MachineFrame => frame::machine_frame(kernel),
        Action::GoHome => home::go(kernel, 1),
        Action::GoHomeNth => home::go_nth(kernel),
        Action::GoHomeReturn => home::come_back(kernel),
        Action::Preset => frame::preset(kernel),
        Action::WorkOffset => frame::work_offset(kernel),
        Action::WorkOffsetOff => frame::work_offset_off(kernel),
        Action::Length(sign, set) => frame::length(kernel, sign, set),
        Action::ExtendedOffset => compensation::extended(kernel),
        Action::OffsetSet => offsets::set(kernel),
        Action::DynamicFixture(on) => compensation::dynamic(kernel, on),
        Action::Corner { arc } => compensation::corner(kernel, arc),
        Action::VectorCompensation => compensation::vector(kernel),
        Action::Local(part, change) => local::change(kernel, part, change),
        Action::Diameter(side) => mode::diameter(kernel, side, row.id),
        Action::Spindle { number, direction, coolant } => spindle::turn(kernel, number, direction, coolant),
        Action::Css => spindle::css(kernel),
        Action::Rpm => spindle::rpm(kernel),
        Action::MaxRpm => spindle::limit(kernel),
        Action::CssDriver(channel) => spindle::driver(kernel, channel),
        Action::Coolant(switch) => coolant::switch(kernel, switch),
        Action::CssDriverById => spindles::driver_by_id(kernel),
        Action::CssRadial => spindle::radial(kernel),
        Action::SpindleInWork { rear } => spindles::in_work(kernel, rear),
        Action::Apply { milling } => spindles::apply(kernel, milling),
        Action::Additive(on) => mode::additive(kernel, on),
        Action::ToolSelect => tool::select(kernel),
        Action::ToolLoad => tool::load(kernel),
        Action::ToolPoint => change_point::go(kernel),
        Action::ToolPointReturn => change_point::come_back(kernel),
        Action::Head(number) => head::load(kernel, number),
        Action::OtherHead(event) => head::other(kernel, event, row),
        Action::Polar { cartesian } => polar::on(kernel, cartesian),
        Action::PolarOff => polar::off(kernel),
        Action::Tip(method) => tip::on(kernel, method),
        Action::TipOff => tip::off(kernel),
        Action::TipFormat(format) => tip::orient(kernel, format),
        Action::Clamp(axis, on) => clamp::clamp(kernel, axis, on),
        Action::Unwind(axis) => clamp::unwind(kernel, axis),
        Action::Stop(stop) => stop::stop(kernel, stop),
        Action::Call => subprogram::call(kernel),
        Action::CallRange => subprogram::call_range(kernel),
        Action::Return => subprogram::give_back(kernel),
        Action::Sync(mark) => sync::meet(kernel, row, mark),
        Action::Function => mode::function(kernel, row, firing),
        Action::Cycle(kind) => cycle::cycle(kernel, kind, row, firing),
        Action::CycleOn => cycle::on(kernel, row, firing),
        Action::CycleOff => cycle::off(kernel),
        Action::Rigid(on) => cycle::rigid(kernel, on),
    }
}
