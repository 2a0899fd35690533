//! The functions of the language that a host computes.
//!
//! *Invariant:* the enums, the list and the compiler's checks of a call come from one table, so that they cannot
//! differ; a host matches on [`HostFn`], never on a name. Facts: the function catalogue of the reference.

use crate::value::ValueType;

macro_rules! host_functions {
    (control { $($function:ident $name:literal $arguments:literal $result:ident,)* }
     files { $($file:ident $file_name:literal $file_arguments:literal $file_result:ident,)* }
     absent { $($absent:ident $absent_name:literal $absent_arguments:literal $absent_result:ident $need:ident,)* }
     parts { $($part:ident $part_name:literal,)* }) => {
        /// A function, or a part of one, that the host computes.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum HostFn {
            $(#[doc = concat!("`", $name, "`")] $function,)*
            /// A function of files.
            File(FileFn),
            /// A function that works on something that a control does not have.
            Absent(AbsentFn),
            $(#[doc = concat!("The part of `", $part_name, "` that needs a control")] $part,)*
        }

        /// A function of files: a [`MacroFolder`](crate::host::MacroFolder) computes it.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum FileFn {
            $(#[doc = concat!("`", $file_name, "`")] $file,)*
        }

        /// A function that works on something that a control does not have.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum AbsentFn {
            $(#[doc = concat!("`", $absent_name, "`")] $absent,)*
        }

        /// Functions that macros call by name, with the types of their arguments and of their result.
        pub(crate) const ROWS: &[(HostFn, &str, Option<ValueType>)] = &[
            $((HostFn::$function, $arguments, $result),)*
            $((HostFn::File(FileFn::$file), $file_arguments, $file_result),)*
            $((HostFn::Absent(AbsentFn::$absent), $absent_arguments, $absent_result),)*
        ];

        impl HostFn {
            /// Name with its dollar sign.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(HostFn::$function => $name,)*
                    $(HostFn::File(FileFn::$file) => $file_name,)*
                    $(HostFn::Absent(AbsentFn::$absent) => $absent_name,)*
                    $(HostFn::$part => $part_name,)*
                }
            }

            /// Type of the result if there is only one.
            #[must_use]
            pub const fn result(self) -> Option<ValueType> {
                match self {
                    $(HostFn::$function => $result,)*
                    $(HostFn::File(FileFn::$file) => $file_result,)*
                    $(HostFn::Absent(AbsentFn::$absent) => $absent_result,)*
                    $(HostFn::$part => None,)*
                }
            }
        }

        impl AbsentFn {
            /// The operand of the function.
            #[must_use]
            pub const fn needs(self) -> Need {
                match self {
                    $(AbsentFn::$absent => Need::$need,)*
                }
            }
        }
    };
}

/// Subjects of functions that a control does not have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// A machine model.
    Model,
    /// A machine model with a time of its own.
    ModelTime,
    /// A composite machine.
    Composite,
    /// A screen.
    Screen,
    /// A word processor.
    WordProcessor,
}

const R: Option<ValueType> = Some(ValueType::Real);
const S: Option<ValueType> = Some(ValueType::Text);
const Q: Option<ValueType> = Some(ValueType::Sequence);
const L: Option<ValueType> = Some(ValueType::Logical);
const A: Option<ValueType> = None;

host_functions! { control {
    Dialog "$FDIALOG" "sS" S,
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
    SearchForward "$FGET" "aNN" R,
    SearchBackward "$FGETR" "aNN" R,
    ForwardKinematics "$FDK" "Q" Q,
    InverseKinematics "$FIK" "AN" Q,
    ConfigureKinematics "$FKINCFG" "aA+" R,
    SelectRotaryAxes "$FKINROT" "aA+" R,
    Unwind "$FUNWIND" "aA+" R,
    CutterDiameter "$FMSGDCV" "nn" R,
    CornerRadius "$FMSGRCV" "nn" R,
    LengthOffset "$FMSGLCV" "nnA+" A,
    WorkOffset "$FMSGFCV" "nnA+" A,
    SetCutterDiameter "$FMSSDCV" "nnnN" R,
    SetCornerRadius "$FMSSRCV" "nnn" R,
    SetLengthOffset "$FMSSLCV" "nnaA+" R,
    SetWorkOffset "$FMSSFCV" "nnaA+" R,
    LocalFrame "$FMSLCS" "Q" R,
}
files {
    FileAccess "$FACCESS" "sN" L,
    FileStatus "$FSTAT" "ss" R,
    CurrentFolder "$FGETCWD" "" S,
    ChangeFolder "$FSETCWD" "s" S,
    TemporaryFile "$FTMPFILE" "S" S,
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
}
absent {
    Pause "$FPAUSE" "S" L Screen,
    Document "$FDOC" "sS" R WordProcessor,
    TimeSync "$FCETIMESYNC" "" L ModelTime,
    Apply "$FAPPLY" "a" L Composite,
    ModelNewChannel "$FMSNCH" "N" R Model,
    ModelDeleteChannel "$FMSDCH" "n" R Model,
    ModelActivateChannel "$FMSACH" "nnN" R Model,
    ModelBindAxis "$FMSGAX" "nn" R Model,
    ModelReleaseAxis "$FMSRAX" "nn" R Model,
    ModelControllingChannel "$FMSGCH" "a" R Model,
    ModelMarks "$FMSWCH" "nnN+" R Model,
    ModelPosition "$FMSGPOS" "n" A Model,
    ModelJointPositions "$FMSGPOSJ" "A+" A Model,
    ModelLocalPositions "$FMSGPOSW" "A+" A Model,
    ModelLimits "$FMSLIMIT" "A+" Q Model,
    ModelMapAxes "$FMSMAX" "nnnN+" R Model,
    ModelMove "$FMSMOVE" "nnnA+" R Model,
    ModelFollow "$FMSSLAV" "nnNNA+" R Model,
    ModelUnwind "$FMSUNWIND" "nA+" R Model,
    ModelUpdatePositions "$FMSUPDPOS" "A" R Model,
    ModelFrame "$FMSGCS" "nNNN" Q Model,
    ModelSetFrame "$FMSSCS" "qnNNN" R Model,
    ModelReference "$FMSGREF" "nnA+" A Model,
    ModelSetReference "$FMSSREF" "nnq" R Model,
    ModelDelay "$FMSDELAY" "n" R Model,
    ModelMasterSpindle "$FMSMSP" "nA" R Model,
    ModelChuck "$FMSCHUCK" "nk" R Model,
    ModelAttach "$FMSATA" "nn" R Model,
    ModelComponent "$FMSID" "aA+" R Model,
    ModelComponentName "$FMSIDN" "n" S Model,
    ModelComponentType "$FMSIDT" "n" R Model,
    ModelTool "$FMSTOOL" "A+" R Model,
    ModelHolder "$FMSHLD" "A+" R Model,
    ModelPart "$FMSPART" "A+" R Model,
    ModelFixture "$FMSFIXTURE" "A+" R Model,
    ModelChips "$FMSCHIP" "A+" R Model,
    ModelToolPath "$FMSTPS" "A+" R Model,
    ModelCamera "$FMSCMRA" "A+" R Model,
    ModelPicture "$FMSPIC" "A+" R Model,
    ModelComponents "$FMSIDS" "A+" Q Model,
    ModelPocket "$FMSPCK" "n" R Model,
    ModelAddTool "$FMSADDTOOL" "aaA" R Model,
    ModelBeginToolChange "$FMSBTC" "" R Model,
    ModelEndToolChange "$FMSETC" "" R Model,
    ModelColour "$FMSCOLR" "A+" R Model,
    ModelGouges "$FMSGOUG" "N" R Model,
    ModelExportSurface "$FMSESF" "A+" R Model,
    ModelSetup "$FMSSETUP" "N" R Model,
    ModelTransfer "$FMSTRN" "nnA" R Model,
    ModelProbe "$FMSPROB" "N" R Model,
    ModelProbeComponent "$FMSPRID" "N" R Model,
    ModelProbePosition "$FMSPPOS" "" A Model,
    ModelProbeData "$FMSPDAT" "nn" A Model,
    ModelClearanceZone "$FMSCEZ" "n" R Model,
    ModelLaser "$FMSLSR" "A+" A Model,
    ModelNearMisses "$FMSNEAR" "A+" A Model,
    ModelCollisions "$FMSVCL" "A+" A Model,
    ModelAdaptiveFeed "$FMSADPT" "A+" A Model,
    ModelMaterialRemoval "$FMSMRS" "N" R Model,
    ModelTolerance "$FMSTOLER" "A+" R Model,
}
parts {
    // `$FEOF` without arguments: whether the NC program has been read to its end.
    EndOfProgram "$FEOF",
    // `$FMX` with one truth value: the machine frame, the last one if true.
    MachineFrame "$FMX",
} }

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
    fn functions_of_the_model_need_one_but_for_offsets_and_the_local_frame() {
        let without = ["GDCV", "GRCV", "GLCV", "GFCV", "SDCV", "SRCV", "SLCV", "SFCV", "LCS"];
        for (function, ..) in ROWS {
            let works = without.iter().any(|name| function.name() == format!("$FMS{name}"));
            let model = function.name().starts_with("$FMS") && !works;
            let needs = matches!(function, HostFn::Absent(absent) if absent.needs() == Need::Model);
            assert_eq!(needs, model, "{}", function.name());
        }
    }
}
