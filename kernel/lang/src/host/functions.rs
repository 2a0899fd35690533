//! The functions of the language that a host computes.
//!
//! Invariant: the enum, the list and what the compiler checks of a call come from one table, so that they cannot differ; a
//! host matches on [`HostFn`], never on a name. Facts: the function catalogue of the reference.

use crate::value::Kind;

macro_rules! host_functions {
    (rows { $($function:ident $name:literal $arguments:literal $result:ident,)* }
     parts { $($part:ident $part_name:literal,)* }) => {
        /// A function, or a part of one, that the host computes.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum HostFn {
            $(#[doc = concat!("`", $name, "`")] $function,)*
            $(#[doc = concat!("The part of `", $part_name, "` that needs a control")] $part,)*
        }

        /// Functions that macros call by name, with the types of their arguments and of their result.
        pub(crate) const ROWS: &[(HostFn, &str, Option<Kind>)] =
            &[$((HostFn::$function, $arguments, $result),)*];

        impl HostFn {
            /// Name with its dollar sign.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(HostFn::$function => $name,)*
                    $(HostFn::$part => $part_name,)*
                }
            }

            /// Type of the result if there is only one.
            #[must_use]
            pub const fn result(self) -> Option<Kind> {
                match self {
                    $(HostFn::$function => $result,)*
                    $(HostFn::$part => None,)*
                }
            }
        }
    };
}

const R: Option<Kind> = Some(Kind::Real);
const S: Option<Kind> = Some(Kind::Text);
const Q: Option<Kind> = Some(Kind::Sequence);
const L: Option<Kind> = Some(Kind::Logical);
const A: Option<Kind> = None;

host_functions! { rows {
    FileAccess "$FACCESS" "sN" L,
    FileStatus "$FSTAT" "ss" R,
    CurrentFolder "$FGETCWD" "" S,
    ChangeFolder "$FSETCWD" "s" S,
    TemporaryFile "$FTMPFILE" "S" S,
    Dialog "$FDIALOG" "sS" S,
    Pause "$FPAUSE" "S" L,
    Document "$FDOC" "sS" R,
    MruOpen "$FMRU_OPEN" "S" R,
    MruClose "$FMRU_CLOSE" "n" A,
    MruKey "$FMRU_GETKEY" "nA" A,
    MruKeys "$FMRU_GETKEYS" "nN" A,
    MruDeleteKey "$FMRU_DELKEY" "nA" A,
    MruDeleteKeys "$FMRU_DELKEYS" "nQ" A,
    MruParameter "$FMRU_GETPARAM" "nasA" A,
    MruParameters "$FMRU_GETPARAMS" "nA" A,
    MruSetParameter "$FMRU_SETPARAM" "nasa" A,
    MruDeleteParameter "$FMRU_DELPARAM" "nas" A,
    MruDeleteParameters "$FMRU_DELPARAMS" "naQ" A,
    DiagnosticSeverity "$FERSEV" "nN" R,
    DiagnosticState "$FERSTA" "nL" L,
    DiagnosticText "$FERTXT" "n" S,
    MacroNames "$FMACID" "SN" Q,
    MacroStates "$FMACSTA" "aL" Q,
    RegisterFormat "$FREGFMT" "a" S,
    RegisterPosition "$FREGPOS" "s" R,
    AddItem "$FCEADD" "aN" L,
    TakeItem "$FCEGET" "a" A,
    SeekItem "$FCESEEK" "aK" A,
    ActiveCode "$FCEGAC" "c" A,
    SetActiveCode "$FCESAC" "c" A,
    DataAsCode "$FCEDAC" "rN" L,
    NcVariable "$FCEGNCV" "sNNN" A,
    SetNcVariable "$FCESNCV" "saNNN" L,
    PreProcessorSetting "$FCEPP" "aA+" A,
    Restart "$FCERST" "sNL" L,
    TimeSync "$FCETIMESYNC" "" L,
    SearchForward "$FGET" "aNN" R,
    SearchBackward "$FGETR" "aNN" R,
    Apply "$FAPPLY" "a" L,
    ForwardKinematics "$FDK" "Q" Q,
    InverseKinematics "$FIK" "AN" Q,
    ConfigureKinematics "$FKINCFG" "aA+" R,
    SelectRotaryAxes "$FKINROT" "aA+" R,
    Unwind "$FUNWIND" "aA+" R,
    ModelNewChannel "$FMSNCH" "N" R,
    ModelDeleteChannel "$FMSDCH" "n" R,
    ModelActivateChannel "$FMSACH" "nnN" R,
    ModelBindAxis "$FMSGAX" "nn" R,
    ModelReleaseAxis "$FMSRAX" "nn" R,
    ModelControllingChannel "$FMSGCH" "a" R,
    ModelMarks "$FMSWCH" "nnN+" R,
    ModelPosition "$FMSGPOS" "n" A,
    ModelJointPositions "$FMSGPOSJ" "A+" A,
    ModelLocalPositions "$FMSGPOSW" "A+" A,
    ModelLimits "$FMSLIMIT" "A+" Q,
    ModelMapAxes "$FMSMAX" "nnnN+" R,
    ModelMove "$FMSMOVE" "nnnA+" R,
    ModelFollow "$FMSSLAV" "nnNNA+" R,
    ModelUnwind "$FMSUNWIND" "nA+" R,
    ModelUpdatePositions "$FMSUPDPOS" "A" R,
    CutterDiameter "$FMSGDCV" "nn" R,
    CornerRadius "$FMSGRCV" "nn" R,
    LengthOffset "$FMSGLCV" "nnA+" A,
    WorkOffset "$FMSGFCV" "nnA+" A,
    SetCutterDiameter "$FMSSDCV" "nnn" R,
    SetCornerRadius "$FMSSRCV" "nnn" R,
    SetLengthOffset "$FMSSLCV" "nnaA+" R,
    SetWorkOffset "$FMSSFCV" "nnaA+" R,
    ModelFrame "$FMSGCS" "nNNN" Q,
    ModelSetFrame "$FMSSCS" "qnNNN" R,
    LocalFrame "$FMSLCS" "Q" R,
    ModelReference "$FMSGREF" "nnA+" A,
    ModelSetReference "$FMSSREF" "nnq" R,
    ModelDelay "$FMSDELAY" "n" R,
    ModelMasterSpindle "$FMSMSP" "nA" R,
    ModelChuck "$FMSCHUCK" "nk" R,
    ModelAttach "$FMSATA" "nn" R,
    ModelComponent "$FMSID" "aA+" R,
    ModelComponentName "$FMSIDN" "n" S,
    ModelComponentType "$FMSIDT" "n" R,
    ModelTool "$FMSTOOL" "A+" R,
    ModelHolder "$FMSHLD" "A+" R,
    ModelPart "$FMSPART" "A+" R,
    ModelFixture "$FMSFIXTURE" "A+" R,
    ModelChips "$FMSCHIP" "A+" R,
    ModelToolPath "$FMSTPS" "A+" R,
    ModelCamera "$FMSCMRA" "A+" R,
    ModelPicture "$FMSPIC" "A+" R,
    ModelComponents "$FMSIDS" "A+" Q,
    ModelPocket "$FMSPCK" "n" R,
    ModelAddTool "$FMSADDTOOL" "aaA" R,
    ModelBeginToolChange "$FMSBTC" "" R,
    ModelEndToolChange "$FMSETC" "" R,
    ModelColour "$FMSCOLR" "A+" R,
    ModelGouges "$FMSGOUG" "N" R,
    ModelExportSurface "$FMSESF" "A+" R,
    ModelSetup "$FMSSETUP" "N" R,
    ModelTransfer "$FMSTRN" "nnA" R,
    ModelProbe "$FMSPROB" "N" R,
    ModelProbeComponent "$FMSPRID" "N" R,
    ModelProbePosition "$FMSPPOS" "" A,
    ModelProbeData "$FMSPDAT" "nn" A,
    ModelClearanceZone "$FMSCEZ" "n" R,
    ModelLaser "$FMSLSR" "A+" A,
    ModelNearMisses "$FMSNEAR" "A+" A,
    ModelCollisions "$FMSVCL" "A+" A,
    ModelAdaptiveFeed "$FMSADPT" "A+" A,
    ModelMaterialRemoval "$FMSMRS" "N" R,
    ModelTolerance "$FMSTOLER" "A+" R,
}
parts {
    // `$FEOF` without arguments: whether the NC program has been read to its end.
    EndOfProgram "$FEOF",
    // `$FMX` with one truth value: the machine frame, the last one if true.
    MachineFrame "$FMX",
} }

impl HostFn {
    /// Whether it works on a machine model only.
    #[must_use]
    pub fn needs_model(self) -> bool {
        let works_without = matches!(
            self,
            HostFn::CutterDiameter
                | HostFn::CornerRadius
                | HostFn::LengthOffset
                | HostFn::WorkOffset
                | HostFn::SetCutterDiameter
                | HostFn::SetCornerRadius
                | HostFn::SetLengthOffset
                | HostFn::SetWorkOffset
                | HostFn::LocalFrame
        );
        self == HostFn::TimeSync || (self.name().starts_with("$FMS") && !works_without)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_there_once() {
        let mut names: Vec<&str> = ROWS.iter().map(|(function, ..)| function.name()).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), ROWS.len());
        assert!(ROWS.iter().all(|(function, _, result)| function.result() == *result));
    }

    #[test]
    fn offsets_and_the_local_frame_need_no_model() {
        assert!(HostFn::ModelPosition.needs_model() && HostFn::TimeSync.needs_model());
        for function in [HostFn::LengthOffset, HostFn::LocalFrame, HostFn::Dialog, HostFn::EndOfProgram] {
            assert!(!function.needs_model(), "{}", function.name());
        }
    }
}
