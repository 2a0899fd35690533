//! The activity of a channel, for watchers and for stepping.

/// Current activity of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(u8)]
pub enum ChannelActivity {
    /// Not yet started.
    #[default]
    Ready = 0,
    /// Executing blocks.
    Running = 1,
    /// Standing at a meeting point.
    Waiting = 2,
    /// Program ended.
    Ended = 3,
    /// Alarm.
    Alarmed = 4,
    /// No program.
    NotStarted = 5,
    /// Stopped by a limit or cancel.
    Stopped = 6,
    /// Can never continue.
    Blocked = 7,
}
