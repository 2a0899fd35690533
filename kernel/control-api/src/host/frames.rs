//! Axes, frames and modes: where the tool is, and how the program counts.

use counterpoint_machine::ident::CodeId;
use counterpoint_machine::index::CodeRowId;

/// Number under which the frame that is active without a work offset (G500) keeps its values.
pub const NO_OFFSET: u32 = u32::MAX - 1;

/// An axis of the channel.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisPlace {
    /// Name on the machine.
    pub name: String,
    /// Name in the programs of the channel.
    pub letter: String,
    /// Programmed as a diameter.
    pub diameter: bool,
    /// A rotary axis.
    pub turns: bool,
    /// Where it is in the frame of the program, as the program counts now.
    pub work: f64,
    /// Reference of incremental words: the current position, or the position before a change of frames that is to be
    /// travelled.
    pub from: f64,
    /// Where it is in the machine frame, as the program counts now.
    pub machine: f64,
    /// Factor and shift in the programmable frame of an axis other than X, Y and Z; 1 and 0 for X, Y and Z.
    pub line: [f64; 2],
}

impl AxisPlace {
    /// Whether it has this name or letter, letter case ignored.
    pub fn is(&self, name: &str) -> bool {
        self.letter.eq_ignore_ascii_case(name) || self.name.eq_ignore_ascii_case(name)
    }
}

/// The active codes of all groups.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ModalSnapshot(pub Vec<(u16, CodeId, Option<CodeRowId>)>);

/// Positions, frames and modes of the channel.
pub trait FrameHost {
    /// Axes of the channel, in its order.
    fn axes(&self) -> Vec<AxisPlace>;

    /// By which letter the programs of the channel name an axis that is given by its name or letter, letter case
    /// ignored.
    fn axis_letter(&self, name: &str) -> Option<&str>;

    /// Positions of the channel's axes by name: in the work frame as programmed, in the machine frame.
    fn positions(&self) -> Vec<(&str, f64, f64)>;

    /// Whether positions count from where the axes are.
    fn relative(&self) -> bool;

    /// Active angle and distance from the pole, in program units; none if no block has set them.
    fn polar(&self) -> [Option<f64>; 2];

    /// Distances of axes that are programmed as diameters are radii.
    fn steps_are_radii(&self) -> bool;

    /// Whether moves are rapid or straight unless a block says otherwise.
    fn moves_straight(&self) -> bool;

    /// From the program to the work frame: three rows of a linear part and a shift, in the order X, Y, Z; shifts as the
    /// program counts now.
    fn local_frame(&self) -> [f64; 12];

    /// Positions of the rotary axes, by letter, that turn into the tilted plane; none without one, or before that is
    /// known.
    fn plane_angles(&self) -> Option<Vec<(String, f64)>>;

    /// Rate of an axis at rapid, by its letter, units of the machine a minute.
    fn rapid_rate(&self, letter: &str) -> Option<f64>;

    /// The rotary axis of a table that carries the part, by letter, with its direction in the frame of the program;
    /// none without one or under control of the tip.
    fn part_table(&self) -> Option<(String, [f64; 3])>;

    /// Direction from the tip of the tool to the spindle, in the frame of the part; along Z without control of the tip.
    fn tool_direction(&self) -> Option<[f64; 3]>;

    /// Compensation of the tool radius is on, so that moves are kept back.
    fn keeps_moves_back(&self) -> bool;

    /// Number of the active work offset, 0 for none.
    fn work_offset(&self) -> u32;

    /// Values of a work offset by axis, as the program counts now; 0 is the base, [`NO_OFFSET`] the frame without one.
    fn offset(&self, number: u32) -> Vec<f64>;

    /// Sets a work offset, which acts at once; whether it was set.
    fn set_offset(&mut self, number: u32, values: &[f64]) -> bool;

    /// Rotation of a work offset, row by row; none without one.
    fn offset_turn(&self, number: u32) -> Option<[f64; 9]>;

    /// Sets the rotation, which takes effect at once; returns whether it was set.
    fn turn_offset(&mut self, number: u32, turn: Option<[f64; 9]>) -> bool;

    /// Moves an axis to a position, together with the next move of the block or alone at the end of the block.
    /// Arguments: its letter, the position in program units, and its feed per minute (none is rapid).
    fn go_beside(&mut self, letter: &str, to: f64, feed: Option<f64>);

    /// Makes moves of an axis, given by its letter, end at its fixed stop, or ends this; false without such an axis.
    fn meet_fixed_stop(&mut self, letter: &str, meets: bool) -> bool;

    /// Whether an axis, given by its letter, is at the fixed stop that ends its moves.
    fn is_at_fixed_stop(&self, letter: &str) -> bool;

    /// Makes the feed of the path count only for these axes, given by their letters; without letters, for the initial
    /// axes of the control.
    fn count_feed(&mut self, letters: &[String]);

    /// Makes a degree of a rotary axis count in the feed of the path as the travel at this radius, in lengths of the
    /// program; false if the axis is not rotary.
    fn set_feed_radius(&mut self, letter: &str, radius: f64) -> bool;

    /// A side of the working area by the letter of an axis: its limit in program units, and whether it is enabled.
    fn area_side(&self, letter: &str, high: bool) -> Option<(Option<f64>, bool)>;

    /// Sets the limit of a side, or enables or disables it; false without such an axis.
    fn set_area_side(&mut self, letter: &str, high: bool, limit: Option<f64>, counts: Option<bool>) -> bool;

    /// Number of the tool that is loaded.
    fn tool(&self) -> u32;

    /// Number of the tool with this name: that of the tables of the machine, or one of the channel's own; none if the machine
    /// numbers no names.
    fn tool_number(&mut self, name: &str) -> Option<u32>;

    /// The same for a name that a table has or that has a number; none for others, which get no number.
    fn known_tool(&self, name: &str) -> Option<u32>;

    /// A tool is called by a name, which the results show.
    fn name_tool(&mut self, number: u32, name: &str);

    /// Length along the tool and radius that are active.
    fn tool_in_force(&self) -> [f64; 2];

    /// Length along the tool and radius of a tool offset.
    fn tool_size(&self, offset: u32) -> [f64; 2];

    /// Sets the length (0) or radius (1) of a tool offset, which acts when it is called next; whether it was set.
    fn set_tool_size(&mut self, offset: u32, at: usize, value: f64) -> bool;

    /// Lengths of a tool offset by axis, as the program counts now.
    fn tool_offset(&self, offset: u32) -> Vec<f64>;

    /// Sets these lengths. Returns whether they were set. If a word of the machine activates changed values, an active
    /// offset keeps its values until that word.
    fn set_tool_offset(&mut self, offset: u32, values: &[f64]) -> bool;

    /// Lengths of the tool that are active, by axis, as the program counts now.
    fn length_in_force(&self) -> Vec<f64>;

    /// Sets the shift of the zero of all work offsets, by axis of the machine, as the program counts now. The machine
    /// does not move.
    fn set_preset(&mut self, values: &[f64]);

    /// Travel limits of an axis by its letter, in the machine frame.
    fn travel(&self, letter: &str) -> Option<(f64, f64)>;

    /// Direction of the imaginary tip of a tool offset, 0 to 9.
    fn tip(&self, offset: u32) -> u8;

    /// Sets it; whether it was set.
    fn set_tip(&mut self, offset: u32, tip: f64) -> bool;

    /// Wear of a tool offset: 0 to 2 of its length along X, Y and Z as the table has it, 3 of its radius.
    fn wear(&self, offset: u32, of: usize) -> f64;

    /// Sets it; whether it was set.
    fn set_wear(&mut self, offset: u32, of: usize, value: f64) -> bool;

    /// The programmed feed of the active mode in units of the machine, 0 without one.
    fn feed(&self) -> f64;

    /// Whether a code is the active one of its group.
    fn is_active(&self, code: CodeId) -> bool;

    /// The active codes, to be restored later.
    fn modes(&self) -> ModalSnapshot;

    /// Makes such codes active again.
    fn restore_modes(&mut self, modes: &ModalSnapshot);
}
