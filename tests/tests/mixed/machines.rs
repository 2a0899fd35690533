//! The machines: a mill with an A and a C table, and a lathe of two channels whose upper turret has live tools and a C
//! axis. Each also with macros that show the positions of its axes, and with macros that change the course of the
//! program.

use std::sync::Arc;

use counterpoint_kernel::files::MemoryFiles;
use counterpoint_kernel::machine::package::Overlay;
use counterpoint_kernel::machine::{Machine, load};

/// The macros of a machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Macros {
    None,
    /// After each block they tell where the axes are.
    Shown,
    /// They change ends of moves, heights of cycles, tools, and start the program again.
    Meddling,
    /// The machine is started again with the first program, at last as if it were the first time.
    Rounds,
}

const MILL: &str = "
[[axes]]
name = \"X\"
rapid = 30_000
home = 0
references = [10]
limits = [-200, 200]

[[axes]]
name = \"Y\"
rapid = 30_000
home = 0
acceleration = 2000

[[axes]]
name = \"Z\"
rapid = 20_000
home = 100

[[axes]]
name = \"A\"
rapid = 6000
turn = \"shortest\"
center = [0, 0, -50]
limits = [-120, 120]

[[axes]]
name = \"C\"
rapid = 9000

[[spindles]]
number = 1
max = 12_000

[[channels]]
number = 1
axes = [\"X\", \"Y\", \"Z\", \"A\", \"C\"]
spindle = 1
polar = [\"X\", \"C\"]

[[work_offsets]]
number = 1
values = { X = 5, Y = -3, Z = 1, C = 10 }

[[work_offsets]]
number = 2
values = { X = -20, A = 15, Z = 4 }

[[tool.offsets]]
number = 1
radius = 2
values = { Z = 30 }

[[tool.offsets]]
number = 2
radius = 0.5
values = { Z = 12.5 }

[[codes]]
id = \"CODE_INTERP_THREAD_VAR\"
word = \"G34\"

[[codes]]
id = \"CODE_INTERP_ARC_3D\"
word = \"G102\"

[[codes]]
id = \"CODE_C2P_CART_ON\"
word = \"G12.1\"

[[codes]]
id = \"CODE_C2P_POLAR_ON\"
word = \"G12.2\"

[[codes]]
id = \"CODE_C2P_CART_OFF\"
word = \"G13.1\"

[[codes]]
id = \"CODE_RTCP2_ON\"
word = \"G43.5\"

[[codes]]
id = \"CODE_RTCP_OFF\"
word = \"G43.9\"

[[codes]]
id = \"CODE_RTCP_ORIENT_VECTOR\"
word = \"G120\"

[[codes]]
id = \"CODE_RTCP_ORIENT_AXES\"
word = \"G121\"

[[codes]]
id = \"CODE_LCS_ROTATE_ADD\"
word = \"G168\"

[[codes]]
id = \"CODE_COMP_CORNER_ARC\"
word = \"G151\"

[[codes]]
id = \"CODE_COMP_3D_VECTOR\"
word = \"G141\"

[[codes]]
id = \"CODE_CLAMP_AT\"
word = \"M10\"

[[codes]]
id = \"CODE_UNCLAMP_AT\"
word = \"M11\"

[[codes]]
id = \"CODE_UNWIND_ROTARY\"
word = \"M12\"

[[codes]]
id = \"CODE_INTERP_LINEAR_X10\"
word = \"G110\"

[[data]]
id = \"REG_ARC_3D_POINT_X\"
register = \"I\"

[[data]]
id = \"REG_ARC_3D_POINT_Y\"
register = \"J\"

[[data]]
id = \"REG_ARC_3D_POINT_Z\"
register = \"K\"

[[data]]
id = \"REG_RTCP_VECTOR_X\"
register = \"I\"

[[data]]
id = \"REG_RTCP_VECTOR_Y\"
register = \"J\"

[[data]]
id = \"REG_RTCP_VECTOR_Z\"
register = \"K\"

[[data]]
id = \"REG_INTERP_THREAD_PITCH_VAR\"
register = \"K\"

[[data]]
id = \"REG_COMP_DIAM_P\"
register = \"P\"

[[data]]
id = \"REG_C2P_INTERP_PLRX\"
register = \"R\"

[[data]]
id = \"REG_COOLANT_PRESSURE\"
register = \"Q\"
";

const LATHE: &str = "
[[axes]]
name = \"X1\"
diameter = true
rapid = 20_000
home = 300
acceleration = 3000

[[axes]]
name = \"Z1\"
rapid = 24_000
home = 500
limits = [-200, 600]

[[axes]]
name = \"C1\"
rapid = 7200
home = 30

[[channels]]
number = 1
name = \"UPPER\"
axes = [\"X1\", \"Z1\", \"C1\"]
spindle = 1

[[work_offsets]]
number = 1
values = { X1 = 10, Z1 = 100, X2 = 10, Z2 = 100 }

[[work_offsets]]
number = 2
values = { Z1 = 50, C1 = 45 }

[[tool.offsets]]
number = 1
radius = 2
tip = 3
values = { X1 = 4, Z1 = 60, X2 = 8 }

[[tool.offsets]]
number = 2
radius = 0.5
tip = 9
values = { X1 = -6, Z2 = 30 }

[[codes]]
id = \"CODE_INTERP_ARC_3D\"
word = \"G102\"

[[codes]]
id = \"CODE_INTERP_THREAD_ON\"
word = \"G132\"

[[codes]]
id = \"CODE_INTERP_THREAD_OFF\"
word = \"G133\"

[[codes]]
id = \"CODE_C2P_POLAR_ON\"
word = \"G12.2\"

[[codes]]
id = \"CODE_LCS_MIRROR_ON\"
word = \"G51.1\"

[[codes]]
id = \"CODE_LCS_MIRROR_OFF\"
word = \"G50.1\"

[[codes]]
id = \"CODE_LCS_SCALE_ON\"
word = \"G51\"

[[codes]]
id = \"CODE_LCS_SCALE_OFF\"
word = \"G50.9\"

[[codes]]
id = \"CODE_CLAMP_CT\"
word = \"M10\"

[[codes]]
id = \"CODE_UNCLAMP_CT\"
word = \"M11\"

[[codes]]
id = \"CODE_UNWIND_ROTARY\"
word = \"M12\"

[[data]]
id = \"REG_LCS_SCALE\"
register = \"P\"
mul = 0.001

[[data]]
id = \"REG_ARC_3D_POINT_X\"
register = \"I\"

[[data]]
id = \"REG_ARC_3D_POINT_Z\"
register = \"K\"
";

const SHOW: &str = "PPRINT/'J !(*) !(*) !(*) !(*) !(*)',$XJ,$YJ,$ZJ,$AJ,$CJ\n";

const MOTION: &str = "
IF/$P1.EQ.5.AND.$P2(1).GT.20
  $P2(1)=20
ENDOF/IF
IF/$P1.EQ.5.AND.$P2(3).GE.30
  $P1=4
ENDOF/IF
IF/$P1.EQ.4.AND.$P2(3).LT.-8
  TERMAC
ENDOF/IF
OUTPUT
";

const CYCLE: &str = "
$P3=$P3+1
IF/$P5.LT.-9
  $P5=-9
ENDOF/IF
OUTPUT
";

const TOOL: &str = "
IF/$P1.EQ.2.AND.$P3.EQ.2
  EXEC/NOW,'G91 G28 Z0'
  EXEC/NOW,'G90'
ENDOF/IF
OUTPUT
";

const AGAIN: &str = "
IF/SERIES.LT.2
  SERIES=SERIES+1
  %L01=$FCERST('p1.nc',1,SERIES.EQ.2)
ENDOF/IF
";

const ROUNDS: &str = "
IF/SERIES.LT.2
  SERIES=SERIES+1
  %L01=$FCERST('p1.nc',1,SERIES.EQ.2)
ENDOF/IF
";

/// A machine.
pub fn machine(mill: bool, macros: Macros) -> Arc<Machine> {
    let mut text = format!(
        "extends = \"{}\"\n[ce]\nname = \"mixed\"\n{}",
        if mill { "fanuc-mill-exact" } else { "fanuc-2path-lathe-exact" },
        if mill { MILL } else { LATHE }
    );
    let mut files = MemoryFiles::default();
    let mut add = |name: &str, macro_text: &str| files.insert(format!("mixed/{name}.mac"), macro_text);
    match macros {
        Macros::None | Macros::Rounds => {}
        Macros::Shown => {
            text += "\n[macros]\nblock_shutdown = \"show.mac\"\n";
            add("show", SHOW);
        }
        Macros::Meddling => {
            text += "\n[macros]\nmotion = \"motion.mac\"\ncycle = \"cycle.mac\"\ntool = \"tool.mac\"\n\
                     declaration = \"declare.mac\"\nprogram_shutdown = \"again.mac\"\n";
            add("motion", MOTION);
            add("cycle", CYCLE);
            add("tool", TOOL);
            add("declare", "DECLAR/OBJECT,INTEGER,SERIES=0\n");
            add("again", AGAIN);
        }
    }
    if macros == Macros::Rounds {
        text += "\n[macros]\ndeclaration = \"declare.mac\"\nmachine_shutdown = \"rounds.mac\"\n";
        files.insert("mixed/declare.mac", "DECLAR/GLOBAL,INTEGER,SERIES=0\n");
        files.insert("mixed/rounds.mac", ROUNDS);
    }
    files.insert("mixed/machine.toml", text);
    let loaded = load(&Overlay::new(files, counterpoint_tests::library()), "mixed");
    let findings: Vec<String> = loaded.findings.iter().map(ToString::to_string).collect();
    loaded.machine.map(Arc::new).unwrap_or_else(|| panic!("the machine does not load: {findings:#?}"))
}
