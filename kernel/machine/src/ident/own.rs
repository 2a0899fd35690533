//! Code identifiers that are this project's own: actions of controls that the emulated system has no identifier for.
//!
//! Invariant: they come after all others, in the order in which they were added, with what each of them means.

/// Hands rows to a list, with the own ones behind them.
macro_rules! with_own {
    ($list:ident { $($rows:tt)* }) => {
        $list! {
            $($rows)*
            POSITION_PRESET 0 450 true true Plain => ": preset of the work frame (Fanuc G50/G92 with axis words)";
            GOHOME_NTH 0 450 true true Plain => ": return to the 2nd, 3rd or 4th reference point (Fanuc G30)";
            FUNCTION 0 300 true true Plain => ": machine function that only takes time (M codes of the machine's own table)";
            POSITION_MACHINE 0 100 true true Plain => ": this block's positions are in the machine frame (Fanuc G53)";
            INTERP_ARC_TANGENT 1 500 true true Plain => ": circle that continues in the direction of the last move (Siemens CT)";
            CORNER_CHAMFER 0 450 true true Plain => ": the corner at the end of the move of this block is a chamfer (Okuma G75)";
            CORNER_ROUND 0 450 true true Plain => ": the corner at the end of the move of this block is a rounding (Okuma G76)";
            XAXIS_DIAMETER_ABSOLUTE 109 100 true true Mode("x diameter absolute") => ": positions of X are diameters, distances along it are radii (Siemens DIAM90)";
            POLE_TOOL 0 450 true true Plain => ": pole of polar coordinates, from where the tool is (Siemens G110)";
            POLE_ZERO 0 450 true true Plain => ": pole of polar coordinates, from the zero of the program (Siemens G111)";
            POLE_LAST 0 450 true true Plain => ": pole of polar coordinates, from the last pole (Siemens G112)";
            POLAR_WORDS_ON 126 100 true true Plain => ": words of the plane are a radius and an angle (Fanuc G16)";
            POLAR_WORDS_OFF 126 100 true true Plain => ": ends that (Fanuc G15)";
            CYLINDER_ON 26 100 true true Plain => ": moves are those on the surface of a cylinder; radius 0 ends it (Fanuc G7.1)";
            CYLINDER_MAP 0 100 true true Plain => ": a linear axis is the way round a cylinder; without words that ends (Haas G107)";
            CYLINDER_OFF 26 100 true true Plain => ": ends that (Siemens TRAFOOF)";
            OFFSET_SET 0 100 true true Plain => ": sets an offset of the control (Fanuc G10)";
            BALANCE_ON 0 100 true true Plain => ": two channels begin their cuts together (Fanuc G68)";
            BALANCE_OFF 0 100 true true Plain => ": ends that, both together (Fanuc G69)";
            COUPLE_SYNCHRONOUS 0 100 true true Plain => ": an axis of one channel follows an axis of another (Fanuc G51.4)";
            COUPLE_SYNCHRONOUS_OFF 0 100 true true Plain => ": ends that, in both channels together (Fanuc G50.4)";
            COUPLE_COMPOSITE 0 100 true true Plain => ": two channels exchange what their words of an axis move (Fanuc G51.5)";
            COUPLE_COMPOSITE_OFF 0 100 true true Plain => ": ends that, in both channels together (Fanuc G50.5)";
            COUPLE_SUPERIMPOSED 0 100 true true Plain => ": the moves of an axis of one channel are added to those of another (Fanuc G51.6)";
            COUPLE_SUPERIMPOSED_OFF 0 100 true true Plain => ": ends that, in both channels together (Fanuc G50.6)";
            TURN_FINISH 1 500 true true Turning(TurningCycle::Finish) => ": runs the blocks of a contour once (Fanuc G70)";
            TURN_ROUGH 1 500 true true Turning(TurningCycle::Rough { face: false }) => ": roughs a contour along Z (Fanuc G71)";
            TURN_ROUGH_FACE 1 500 true true Turning(TurningCycle::Rough { face: true }) => ": roughs a contour along X (Fanuc G72)";
            TURN_PATTERN 1 500 true true Turning(TurningCycle::Pattern) => ": repeats a contour nearer and nearer (Fanuc G73)";
            TURN_PECK 1 500 true true Turning(TurningCycle::Peck { along_x: false }) => ": pecks along Z (Fanuc G74)";
            TURN_GROOVE 1 500 true true Turning(TurningCycle::Peck { along_x: true }) => ": pecks along X (Fanuc G75)";
            TURN_SINGLE 1 500 true true Turning(TurningCycle::Single { face: false }) => ": one cut along Z and back (Fanuc G90)";
            TURN_SINGLE_FACE 1 500 true true Turning(TurningCycle::Single { face: true }) => ": one cut along X and back (Fanuc G94)";
            TURN_LAP_BAR 1 500 true true Turning(TurningCycle::Lap(Lap::Bar)) => ": roughs a named contour level by level (Okuma G85)";
            TURN_LAP_COPY 1 500 true true Turning(TurningCycle::Lap(Lap::Copy)) => ": roughs a named contour by passes along the whole of it (Okuma G86)";
            TURN_LAP_FINISH 1 500 true true Turning(TurningCycle::Lap(Lap::Finish)) => ": runs a named contour once (Okuma G87)";
            TURN_LAP_STAY 0 100 true true Plain => ": the tool stays at the end of the next cycle along a named contour (Okuma M85)";
            TILT_ON 161 100 true true Plane(Tilt::On(Lie::Said)) => ": a tilted plane in the form that the block says (Fanuc G68.2)";
            TILT_ADD 161 100 true true Plane(Tilt::Add(Lie::Said)) => ": the same in the plane that is active (Fanuc G68.4)";
            TILT_EULER 161 100 true true Plane(Tilt::On(Lie::Euler)) => ": a tilted plane by angles about Z, X and Z (Heidenhain PLANE EULER)";
            TILT_SPATIAL 161 100 true true Plane(Tilt::On(Lie::Fixed)) => ": by angles about X, Y and Z that stay (PLANE SPATIAL)";
            TILT_PROJECTED 161 100 true true Plane(Tilt::On(Lie::Projections)) => ": by the angles of two lines (PLANE PROJECTED)";
            TILT_VECTOR 161 100 true true Plane(Tilt::On(Lie::Directions)) => ": by the directions of X and Z (PLANE VECTOR)";
            TILT_POINTS 161 100 true true Plane(Tilt::On(Lie::Points)) => ": by three points (PLANE POINTS)";
            TILT_RELATIVE 161 100 true true Plane(Tilt::Add(Lie::Fixed)) => ": by angles in the plane that is active (PLANE RELATIV)";
            TILT_AXIAL 161 100 true true Plane(Tilt::On(Lie::Positions)) => ": by positions of the rotary axes (PLANE AXIAL)";
            TILT_OFF 161 100 true true Plane(Tilt::Off) => ": ends the tilted plane (PLANE RESET)";
            TILT_CANCEL 161 100 true true Plane(Tilt::Cancel) => ": the same, or ends the rotation of the local frame (Fanuc G69)";
            TILT_TURN 0 470 true true Plane(Tilt::Turn) => ": rotary axes turn into the plane (Fanuc G53.1, Heidenhain TURN)";
            TILT_MOVE 0 470 true true Plane(Tilt::Move) => ": the same, the tool keeps its place on the part (Fanuc G53.6, MOVE)";
            TILT_POSITIVE 0 90 true true Plane(Tilt::Side(true)) => ": of two ways the one with the tilting axis on the positive side (SEQ+)";
            TILT_NEGATIVE 0 90 true true Plane(Tilt::Side(false)) => ": on the negative side (SEQ-)";
            TILT_TABLE 0 90 true true Plane(Tilt::Table) => ": a rotary axis that has nothing to do turns the plane (TABLE ROT)";
            ENGRAVE 0 460 true true Plain => ": engraves the text in the comment of its block (Haas G47)";
            POCKET 0 90 true true Plain => ": clears a pocket whose outline a subprogram draws (Haas G150)";
            RETRACT_TOOL 0 460 true true Plain => ": the tool goes back along its axis (Heidenhain M140)";
            SMOOTH_LINE_IN 0 440 true true Plain => ": the tool comes to the contour on a line in its direction (Siemens G147)";
            SMOOTH_QUARTER_IN 0 440 true true Plain => ": on a quarter of a circle (Siemens G247)";
            SMOOTH_HALF_IN 0 440 true true Plain => ": on half a circle (Siemens G347)";
            SMOOTH_LINE_OUT 0 440 true true Plain => ": the tool leaves the contour on a line in its direction (Siemens G148)";
            SMOOTH_QUARTER_OUT 0 440 true true Plain => ": on a quarter of a circle (Siemens G248)";
            SMOOTH_HALF_OUT 0 440 true true Plain => ": on half a circle (Siemens G348)";
            SMOOTH_SIDE_TOOL 146 100 true true Mode("smooth side tool") => ": such circles lie on the side of the compensated tool (Siemens G140)";
            SMOOTH_SIDE_LEFT 146 100 true true Mode("smooth side left") => ": on the left of the contour (Siemens G141)";
            SMOOTH_SIDE_RIGHT 146 100 true true Mode("smooth side right") => ": on the right (Siemens G142)";
            SMOOTH_SIDE_POINT 146 100 true true Mode("smooth side point") => ": where the way to the contour begins, or the way from it ends (Siemens G143)";
            SMOOTH_IN_SPACE 147 100 true true Mode("smooth in space") => ": the tool goes down on the circle or line itself (Siemens G340)";
            SMOOTH_IN_PLANE 147 100 true true Mode("smooth in plane") => ": before it (Siemens G341)";
            CONTOUR_NORMAL 145 100 true true Mode("contour normal") => ": compensation begins and ends straight beside the contour (Siemens NORM)";
            CONTOUR_AROUND 145 100 true true Mode("contour around") => ": around the end of the contour, if the point is behind it (Siemens KONT)";
            COMP_IN_MACHINE 148 90 true true Mode("comp plane machine") => ": compensation of the radius is in the plane of the machine (Siemens CUT2D)";
            COMP_IN_FRAME 148 90 true true Mode("comp plane frame") => ": in the plane of the frame (Siemens CUT2DF)";
            FEED_AT_EDGE 149 100 true true Mode("feed edge") => ": beside arcs of a compensated contour the feed is that of the edge of the tool (Heidenhain M109)";
            FEED_AT_EDGE_INSIDE 149 100 true true Mode("feed edge inside") => ": only where the tool is inside of the arc (Heidenhain M110)";
            FEED_AT_CENTER 149 100 true true Mode("feed center") => ": the feed is that of the middle of the tool (Heidenhain M111)";
            FEED_DOWN 0 100 true true Plain => ": moves against the tool axis keep it to a share of the feed; without the share that ends (Heidenhain M103)";
            FEED_ROTARY_LENGTH 150 100 true true Plain => ": the feed of rotary axes is that of the tip on the part (Heidenhain M116)";
            FEED_ROTARY_ANGLE 150 100 true true Plain => ": ends that (Heidenhain M117)";
            ANGLES_SHORTEST 151 90 true true Plain => ": rotary axes without limits turn the shorter way to a position (Heidenhain M126)";
            ANGLES_AS_WRITTEN 151 90 true true Plain => ": ends that, whole turns are taken off (Heidenhain M127)";
            CONTOUR_SHARP 0 100 true true Plain => ": the offsets of this block and the next meet outside of the corner too (Heidenhain M97)";
            CONTOUR_EXTENDED 0 100 true true Plain => ": outside of the corner the offsets go on by a length before an arc joins them, up to where they meet (Heidenhain M197)";
            CONTOUR_OPEN 0 100 true true Plain => ": the offset of this block goes to its end, also inside of the corner (Heidenhain M98)";
            RTCP_AT_ENDS 20 100 true true TipControl => ": positions are those of the tip where moves end; rotary axes turn without the linear ones (Heidenhain M144)";
            INTERP_THREAD_ARC_CLW 1 500 true true Plain => ": a thread along a circle, clockwise (Okuma G112)";
            INTERP_THREAD_ARC_CCLW 1 500 true true Plain => ": counter-clockwise (Okuma G113)";
            THREAD_LEAD_Z 0 90 true true Plain => ": the lead of threads counts along Z (Okuma M26)";
            THREAD_LEAD_X 0 90 true true Plain => ": along X (Okuma M27)";
            TURN_LAP_THREAD 1 500 true true Turning(TurningCycle::Lap(Lap::Thread)) => ": the passes of a thread along a named contour (Okuma G88)";
            GOHOME_CHECK 0 450 true true Plain => ": rapid move that must end at the reference point (Fanuc G27)";
            GOHOME_FLOATING 0 450 true true Plain => ": return to the floating reference point (Fanuc G30.1)";
            RAPID_ONE_WAY 0 450 true true Plain => ": rapid move that comes to its end from one direction (Fanuc G60)";
            POSITION_PRESET_OFF 0 450 true true Plain => ": ends the presets and the local shift of the axes that the block names (Fanuc G92.1)";
            TOOL_MEASURE 0 450 true true Plain => ": rapid move to where the control measures the tool (Fanuc G37)";
            TOOL_LENGTHEN 0 480 true true Plain => ": the moves of the block are longer by an offset (Fanuc G45)";
            TOOL_SHORTEN 0 480 true true Plain => ": shorter (Fanuc G46)";
            TOOL_LENGTHEN_TWICE 0 480 true true Plain => ": longer by twice the offset (Fanuc G47)";
            TOOL_SHORTEN_TWICE 0 480 true true Plain => ": shorter by twice the offset (Fanuc G48)";
            CONTOUR_ROUND 0 100 true true Plain => ": an arc joins the offsets of the last block and the next outside of their corner (Fanuc G39)";
            CORNER_OVERRIDE 15 100 true true Mode("corner override") => ": the control slows down at inside corners (Fanuc G62)";
            TAPPING_MODE 15 100 true true Mode("tapping mode") => ": overrides and feed hold do not act (Fanuc G63)";
            FIGURE_TURN 0 300 true true Plain => ": calls a program several times, turned further each time (Fanuc G72.1)";
            FIGURE_SHIFT 0 300 true true Plain => ": calls a program several times, shifted further each time (Fanuc G72.2)";
            POLYGON_ON 120 100 true true Mode("polygon on") => ": a tool axis turns with the spindle (Fanuc G51.2)";
            POLYGON_OFF 120 100 true true Mode("polygon off") => ": ends that (Fanuc G50.2)";
            TURRET_OPPOSITE 104 100 true true Plain => ": X is mirrored for tools of the turret on the other side of the turning axis (Fanuc G68 of lathes)";
            TURRET_OWN 104 100 true true Plain => ": ends that (Fanuc G69)";
            TURN_PASS 0 100 true true Plain => ": one more pass of the thread along a named contour that comes (Okuma G88)";
            UNITS_SECONDARY_LENGTHS 6 100 true true Plain => ": lengths are in the secondary unit, feeds are not (Siemens G70)";
            AXES_BESIDE 0 600 true true Plain => ": positioning axes arrive, if no move of the block has taken them along (Siemens POS)";
            WORK_AREA_LOW 0 100 true true Plain => ": lower limits of the working area (Siemens G25)";
            WORK_AREA_HIGH 0 100 true true Plain => ": upper limits of the working area (Siemens G26)";
            WORK_AREA_ON 152 100 true true Plain => ": moves that end outside of the working area are alarms (Siemens WALIMON)";
            WORK_AREA_OFF 152 100 true true Plain => ": ends that (Siemens WALIMOF)";
        }
    };
}

pub(super) use with_own;
