//! A prepared job: its programs are loaded and assigned to channels.

use std::sync::Arc;

use counterpoint_lang::compile;

use counterpoint_emulator::channel::components::PreparedComponent;
use counterpoint_emulator::channel::plan::ExecutionPlan;
use counterpoint_event::info::Info;
use counterpoint_machine::Machine;
use counterpoint_machine::finding::Finding;
use counterpoint_ports::control::StopSignal;
use counterpoint_ports::files::JobFiles;
use counterpoint_program::sources::Sources;
use counterpoint_program::spec::Spec;

use crate::plans::{PlanRequest, Plans};

/// A prepared job: programs are loaded and assigned to channels.
#[derive(Debug)]
pub struct Job {
    spec: Spec,
    info: Arc<Info>,
    sources: Sources,
    /// The machine's macros as its kernels run them.
    macros: Option<Arc<compile::MacroProgram>>,
    /// The same of each component of a composite machine.
    components: Vec<Option<Arc<compile::MacroProgram>>>,
    /// Where plans of machines are kept.
    plans: Option<Arc<Plans>>,
}

/// Why a job cannot be run at all.
#[derive(Debug, Clone, thiserror::Error)]
#[error("the job cannot be run: {}", .findings.first().map_or("", |f| f.text.as_str()))]
pub struct PrepareError {
    /// All reasons.
    pub findings: Vec<Finding>,
    /// Nothing is wrong with the job as far as is known: it was asked to end meanwhile.
    pub cancelled: bool,
}

/// Bytes of a text that are searched between two looks at whether the job is to end.
const PIECE: usize = 1 << 20;

/// Whether a program of the job has embedded macro code, which needs no macro of the machine.
fn has_embedded(info: &Info, files: &dyn JobFiles, stop: &StopSignal) -> bool {
    let has = |text: &[u8]| {
        // Piece by piece, with the byte after each: a mark has two.
        let pieces = (0..text.len()).step_by(PIECE).take_while(|_| !stop.asked_once_resumed());
        let mut pieces = pieces.filter_map(|at| text.get(at..text.len().min(at + PIECE + 1)));
        pieces.any(|piece| [&b"#{"[..], b"!{"].into_iter().any(|mark| memchr::memmem::find(piece, mark).is_some()))
    };
    info.files.iter().any(|file| match file.text.get() {
        Some(text) => text.as_ref().is_some_and(|text| has(text.bytes())),
        None => files.read(&file.name).is_ok_and(|bytes| has(&bytes)),
    })
}

/// Numbers of switched warnings that are diagnostics neither of this project nor of the machine.
fn unknown_warnings(spec: &Spec) -> Vec<Finding> {
    let components = spec.machine.components.iter().map(|component| &component.machine);
    let machines: Vec<_> = components.chain([&spec.machine]).collect();
    let unknown = |number: &&u32| {
        counterpoint_fault::severity(**number).is_none()
            && machines.iter().all(|machine| machine.diagnostics.rule(**number).is_none())
    };
    let switched = spec.options.warnings_off.iter().chain(&spec.options.warnings_on);
    let text = |number: &u32| {
        format!(
            "cannot switch the warning {number}: no diagnostic has this number; give the number or the word that stands \
             before a warning, such as 2900680 or feed-above-rates"
        )
    };
    switched.filter(unknown).map(|number| Finding::error("job", 0, 0, text(number))).collect()
}

impl Job {
    /// Loads the programs and assigns them to channels.
    ///
    /// # Errors
    /// Every reason why the job cannot run: missing files, unknown channels, too many programs, bad options.
    pub fn prepare(spec: Spec, files: &dyn JobFiles) -> Result<Self, PrepareError> {
        Self::prepare_until(spec, files, &StopSignal::default())
    }

    /// The same, unless `stop` is requested: programs may be long. The job is run by a control with that `stop`.
    ///
    /// # Errors
    /// Those of [`prepare`](Self::prepare), and that it was asked to end.
    pub fn prepare_until(mut spec: Spec, files: &dyn JobFiles, stop: &StopSignal) -> Result<Self, PrepareError> {
        let cancelled = || PrepareError {
            findings: vec![Finding::error("job", 0, 0, "the job was cancelled before it began")],
            cancelled: true,
        };
        let unknown = unknown_warnings(&spec);
        if !unknown.is_empty() {
            return Err(PrepareError { findings: unknown, cancelled: false });
        }
        spec.options.limits = spec.options.limits.capped();
        let syntax = |machine: &Machine| counterpoint_controls::of(machine).syntax();
        let (info, sources) = match counterpoint_program::layout::assign(&spec, syntax, files, stop) {
            _ if stop.asked_once_resumed() => return Err(cancelled()),
            Ok(assigned) => assigned,
            Err(findings) => return Err(PrepareError { findings, cancelled: false }),
        };
        let executes = !spec.options.lint;
        let embedded = (executes && has_embedded(&info, files, stop)).then(|| Arc::new(compile::MacroProgram::new()));
        let compiled = |machine: &Machine| {
            let own = machine.macros.as_deref().filter(|_| executes);
            let own = own.map(|macros| macros.program_for(machine.macro_environment(), info.trace));
            own.or_else(|| embedded.clone())
        };
        let macros = compiled(&spec.machine);
        let components = spec.machine.components.iter().map(|component| compiled(&component.machine)).collect();
        if stop.asked_once_resumed() {
            return Err(cancelled());
        }
        Ok(Self { spec, info: Arc::new(info), sources, macros, components, plans: None })
    }

    /// Takes the plan of its machine from these, and leaves it there for other jobs.
    #[must_use]
    pub fn sharing(self, plans: &Arc<Plans>) -> Self {
        Self { plans: Some(Arc::clone(plans)), ..self }
    }

    /// Plans that its kernels have derived from the machine, and from each component of a composite.
    pub(crate) fn plans(&self) -> (Arc<ExecutionPlan>, Vec<Arc<ExecutionPlan>>) {
        let of = |machine: &Arc<Machine>, macros: bool| {
            let wanted = PlanRequest { machine, opskip: &self.spec.options.opskip, hooks: macros };
            match &self.plans {
                Some(plans) => plans.of(&wanted),
                None => Arc::new(wanted.plan()),
            }
        };
        let components = self.spec.machine.components.iter().zip(&self.components);
        let components = components.map(|(component, macros)| of(&component.machine, macros.is_some()));
        (of(&self.spec.machine, self.macros.is_some()), components.collect())
    }

    /// The fixed facts of the job.
    #[must_use]
    pub fn info(&self) -> &Arc<Info> {
        &self.info
    }

    /// Its program files.
    pub(crate) fn sources(&self) -> &Sources {
        &self.sources
    }

    /// Its inputs.
    #[must_use]
    pub fn spec(&self) -> &Spec {
        &self.spec
    }

    /// The machine's macros as its kernels run them.
    pub(crate) fn macros(&self) -> Option<&Arc<compile::MacroProgram>> {
        self.macros.as_ref()
    }

    /// The components of a composite machine as its kernels work with them.
    pub(crate) fn components<'a>(&'a self, plans: &'a [Arc<ExecutionPlan>]) -> Vec<PreparedComponent<'a>> {
        let all = self.spec.machine.components.iter().zip(plans).zip(&self.components);
        let fitted = all.map(|((component, plan), macros)| PreparedComponent {
            designator: &component.designator,
            name: &component.name,
            channels: &component.channels,
            machine: &component.machine,
            plan,
            macros: macros.as_ref(),
        });
        fitted.collect()
    }

    /// Whether one of its kernels runs macros, which need a large stack.
    pub(crate) fn has_macros(&self) -> bool {
        self.macros.is_some() || self.components.iter().any(Option::is_some)
    }
}
