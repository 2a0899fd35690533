//! SYSTEM: a command of the operating system, where the owner of the server allows it.
//!
//! Facts: reference macro-language.md 3.5. Decisions: the command sees the files that macros see, in its current
//! folder; its changes count from the instant of simulated time at which it was started; its output comes as messages.

use std::collections::BTreeMap;

use counterpoint_lang::diag::DiagnosticNumber;
use counterpoint_lang::fault::{MacroFault, Outcome};
use counterpoint_lang::vm::MacroState;
use counterpoint_sync::races::AccessMode;

use crate::context::KernelHost;
use counterpoint_channel::burden::shortened;
use counterpoint_event::event::{Kind, OperatorMessage};
use counterpoint_ports::files::Bytes;
use counterpoint_ports::system::{CommandOutcome, SystemCommand};

/// Steps that a command costs.
const TICKS: usize = 50_000;
/// Lines of its output that are kept.
const MOST_LINES: usize = 100;

impl KernelHost<'_, '_> {
    pub(crate) fn system_command(&mut self, state: &mut MacroState, command: &str) -> Outcome<i32> {
        let control = self.kernel.ports.control;
        let Some(system) = control.system() else {
            return Err(MacroFault::new(DiagnosticNumber::SYSTEM_INHIBITED, "SYSTEM commands are switched off"));
        };
        control.note_outside();
        state.spend(TICKS)?;
        let written = match self.job_files(AccessMode::Read, |written| written.all()) {
            Ok(written) => written,
            Err(status) => return Ok(status),
        };
        let read = |path: String| Some((path.clone(), self.kernel.channel.env.files.read(&path).ok()?));
        let mut files: BTreeMap<String, Bytes> =
            self.kernel.channel.env.files.list().into_iter().filter_map(read).collect();
        for (path, text) in written {
            match text {
                Some(text) => files.insert(path, Bytes::copy_from_slice(text.as_bytes())),
                None => files.remove(&path),
            };
        }
        let folder = self.kernel.macros.outside.folder.path().to_owned();
        let storage = self
            .kernel
            .channel
            .env
            .machine
            .storage
            .iter()
            .map(|file| (file.path.clone(), file.content.clone()))
            .collect();
        let call = SystemCommand { command, folder: &folder, files: files.into_iter().collect(), storage };
        let answer = system.run(&call, &|| control.cancelled());
        self.take_answer(answer)
    }

    fn take_answer(&mut self, CommandOutcome { status, output, written, removed }: CommandOutcome) -> Outcome<i32> {
        let refused = self.job_files(AccessMode::Write, |files| {
            removed.iter().for_each(|path| files.remove(path));
            written.iter().find_map(|(path, text)| files.put(path, text).err())
        });
        if let Ok(Some(text)) = refused {
            self.kernel.diagnose(&counterpoint_fault::MACRO_FILES, text);
        }
        for line in output.lines().take(MOST_LINES) {
            self.kernel
                .channel
                .emit(0, Kind::Message(OperatorMessage { text: shortened(line).into(), printed: false }));
        }
        Ok(status)
    }
}
