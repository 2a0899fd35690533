//! Subjects of data: the typed column of the table of data.

/// The kind of a data identifier: the family that it belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DataKind {
    /// Data without a family; custom data of a machine are of this kind.
    Plain,
    /// Position of an axis, with the letter that `$AXES` gives it: a small one for a table and for the second
    /// attachable axis.
    Axis(char),
    /// Shape of an arc.
    Arc,
    /// Position in polar interpolation.
    Polar,
    /// Corner at the end of a line, direction of a line.
    Contour,
    /// Orientation of the tool.
    Orientation,
    /// A point of a local frame: its shift, the centre of a rotation or of a scale; an end of an area.
    FramePoint,
    /// Speed or angle of a spindle.
    Spindle,
    /// Feed or rapid rate.
    Feed,
    /// Number of a tool.
    Tool,
    /// Lead of a thread that is cut in one move, and its change.
    ThreadLead,
}

impl DataKind {
    /// Whether this is the position of an axis.
    #[must_use]
    pub fn is_axis(self) -> bool {
        matches!(self, Self::Axis(_))
    }

    /// Actions remember the last value by themselves.
    #[must_use]
    pub fn is_modal(self) -> bool {
        matches!(self, Self::Axis(_) | Self::Spindle | Self::Feed | Self::Tool)
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::data;
    use super::super::super::dimension::Dimension;
    use super::DataKind;

    #[test]
    fn names_kinds_and_dimensions_say_the_same() {
        for facts in data::TABLE {
            let name = facts.name.strip_prefix("REG_").unwrap();
            let starts = |prefixes: &[&str]| prefixes.iter().any(|prefix| name.starts_with(prefix));
            let kind = match () {
                () if starts(&["AXIS_"]) => {
                    let letter = name.chars().nth(5).unwrap();
                    let small = ["AXIS_AT", "AXIS_BT", "AXIS_CT", "AXIS_CT2", "AXIS_N2"].contains(&name);
                    DataKind::Axis(if small { letter.to_ascii_lowercase() } else { letter })
                }
                () if starts(&["ARC_"]) => DataKind::Arc,
                () if starts(&["C2P_INTERP_"]) => DataKind::Polar,
                () if starts(&["CORNER_", "LINE_ANGLE", "POLE_"]) => DataKind::Contour,
                () if starts(&["RTCP_"]) => DataKind::Orientation,
                () if starts(&["LCS_TRANS_", "LCS_ROT_CENTER_", "LCS_SCALE_CENTER_", "STORED_LIMIT_"]) => {
                    DataKind::FramePoint
                }
                // No action remembers an angle unless the machine says so.
                () if name == "SPINDLE_ORIENT" => DataKind::Plain,
                () if starts(&["SPINDLE_"]) => DataKind::Spindle,
                () if starts(&["FEED_", "RAPID_FEED"]) => DataKind::Feed,
                () if name == "TOOL" => DataKind::Tool,
                () if starts(&["INTERP_THREAD_PITCH"]) => DataKind::ThreadLead,
                () => DataKind::Plain,
            };
            assert_eq!(facts.kind, kind, "{name}");
            let has = |parts: &[&str]| parts.iter().any(|part| name.split('_').any(|word| word == *part));
            if let DataKind::Axis(letter) = facts.kind {
                let turns = letter.is_ascii_lowercase() || "ABCN".contains(letter);
                let dimension = if turns { Dimension::Angle } else { Dimension::Length };
                assert_eq!(facts.dimension, dimension, "{name}");
            }
            if has(&["ANGLE", "ORIENT", "RPY", "EULER"]) {
                assert_eq!(facts.dimension, Dimension::Angle, "{name}");
            }
            if has(&["UPM", "UPR"]) {
                assert_eq!(facts.dimension, Dimension::Feed, "{name}");
            }
            if has(&["DWELL", "DELAY"]) && !has(&["REV"]) {
                assert_eq!(facts.dimension, Dimension::Time, "{name}");
            }
            if facts.kind == DataKind::FramePoint || starts(&["ARC_CENTER_", "ARC_3D_POINT_", "ARC_RADIUS"]) {
                assert_eq!(facts.dimension, Dimension::Length, "{name}");
            }
            if has(&["ID", "COUNT", "CUTS", "STARTS", "REPEAT", "RPM", "SEQNO"]) {
                assert_eq!(facts.dimension, Dimension::None, "{name}");
            }
        }
    }
}
