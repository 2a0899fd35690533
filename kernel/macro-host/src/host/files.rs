//! Files of macros: files of the job and of the machine are read, and written files become results of the job.
//!
//! *Invariant:* the content that a kernel finds in a file depends on simulated time only, never on the speed of
//! threads.

use counterpoint_fault::Halt;
use counterpoint_lang::fault::Outcome;
use counterpoint_lang::host::{FAILED, FORBIDDEN, FileFacts, FileFn, FileHost, MacroFolder, NOT_FOUND, Shelf, stored};
use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm::{self, MacroState};
use counterpoint_machine::Machine;

use crate::context::KernelHost;
use counterpoint_channel::shared_target::SharedTarget;
use counterpoint_fault as diag;
use counterpoint_machine::stored::StoredFile;
use counterpoint_ports::files::Bytes;
use counterpoint_sync::files::SharedFiles;
use counterpoint_sync::races::AccessMode;

impl KernelHost<'_, '_> {
    /// Runs an operation on the folder of the run and its files.
    fn with_files<R>(&mut self, work: impl FnOnce(&mut MacroFolder, &mut dyn Shelf) -> R) -> R {
        let mut folder = std::mem::take(&mut self.kernel.macros.outside.folder);
        let result = work(&mut folder, self);
        self.kernel.macros.outside.folder = folder;
        result
    }

    /// A function of files.
    pub(crate) fn file_function(
        &mut self,
        state: &mut MacroState,
        function: FileFn,
        arguments: &[MacroValue],
    ) -> Outcome<MacroValue> {
        let program = self
            .kernel
            .flow
            .frames
            .first()
            .map_or("", |frame| self.kernel.channel.env.info.file_name(frame.file))
            .to_owned();
        self.with_files(|folder, shelf| folder.function(shelf, state, (function, arguments), &program))
    }

    /// Closes the units that are open at the end of the kernel, and removes its temporary files. Units of a stopped
    /// kernel are lost: its progress is random.
    pub(crate) fn close_files(&mut self, halt: Halt) {
        let runtime = &mut *self.kernel.macros;
        let Some(mut state) = runtime.calls.take_state() else { return };
        runtime.outside.leaving = true;
        if halt != Halt::Stopped {
            vm::close_all(&mut state, self);
        }
        self.with_files(MacroFolder::clean);
        self.kernel.macros.outside.leaving = false;
        self.kernel.macros.calls.put_state(state);
    }

    /// Works on the files that macros have written, in its turn.
    pub(crate) fn job_files<R>(
        &mut self,
        mode: AccessMode,
        work: impl FnOnce(&mut SharedFiles) -> R,
    ) -> Result<R, i32> {
        self.kernel.access(SharedTarget::File, mode, |shared| work(&mut shared.files)).map_err(|halt| {
            self.kernel.macros.calls.stop(halt);
            FAILED
        })
    }
}

impl FileHost for KernelHost<'_, '_> {
    fn may_open(&mut self, state: &mut MacroState, path: &str) -> i32 {
        self.with_files(|folder, shelf| folder.openable(shelf, state, path))
    }

    fn may_write(&mut self, path: &str) -> i32 {
        self.with_files(|folder, shelf| folder.writable(shelf, path))
    }

    fn read_file(&mut self, path: &str) -> Option<String> {
        self.with_files(|folder, shelf| folder.load(shelf, path)).ok()
    }

    fn write_file(&mut self, path: &str, text: &str) -> bool {
        self.with_files(|folder, shelf| folder.save(shelf, path, text)).is_ok()
    }
}

impl Shelf for KernelHost<'_, '_> {
    fn read(&mut self, path: &str) -> Result<String, i32> {
        if stored(path) {
            return stored_file(self.kernel.channel.env.machine, path)
                .map(|text| String::from_utf8_lossy(text).into_owned())
                .ok_or(NOT_FOUND);
        }
        match self.job_files(AccessMode::Read, |written| written.get(path))? {
            Some(text) => text.map(|text| (*text).to_owned()).ok_or(NOT_FOUND),
            None => match self.kernel.channel.env.files.read(path) {
                Ok(text) => Ok(String::from_utf8_lossy(&text).into_owned()),
                Err(counterpoint_ports::files::FileError::Missing(_)) => Err(NOT_FOUND),
                Err(counterpoint_ports::files::FileError::Unreadable { .. }) => Err(FAILED),
            },
        }
    }

    fn write(&mut self, path: &str, text: &str) -> Result<(), i32> {
        if stored(path) {
            return Err(FORBIDDEN);
        }
        if self.kernel.macros.outside.leaving {
            let tag = self.kernel.channel.tag();
            self.kernel.ports.coordinator.unordered(|order| order.shared.files.leave(tag, path, Some(text)));
            return Ok(());
        }
        let limit = self.kernel.channel.env.shares().common;
        let (done, over) = self.job_files(AccessMode::Write, |written| {
            let done = written.put(path, text);
            (done, written.bytes() as u64 > limit)
        })?;
        if over {
            let halt = self.kernel.out_of_memory("files that macros have written use most of it");
            self.kernel.macros.calls.stop(halt);
            return Err(FAILED);
        }
        done.map_err(|text| {
            self.kernel.diagnose(&diag::MACRO_FILES, text);
            FAILED
        })
    }

    fn facts(&mut self, path: &str) -> Result<FileFacts, i32> {
        if stored(path) {
            return stored_file(self.kernel.channel.env.machine, path)
                .map(|text| FileFacts::file(text.len(), true))
                .ok_or(NOT_FOUND);
        }
        let (text, folder) =
            self.job_files(AccessMode::Read, |written| (written.get(path), written.has_folder(path)))?;
        let size = match text {
            Some(text) => text.map(|text| text.len()),
            None => self.kernel.channel.env.files.read(path).ok().map(|text| text.len()),
        };
        let folder = || {
            let inside = |name: &String| name.strip_prefix(path).is_some_and(|rest| rest.starts_with('/'));
            path == "." || folder || self.kernel.channel.env.files.list().iter().any(inside)
        };
        match size {
            Some(size) => Ok(FileFacts::file(size, false)),
            None if folder() => Ok(FileFacts::folder()),
            None => Err(NOT_FOUND),
        }
    }

    fn remove(&mut self, path: &str) {
        // Only temporary files are removed, and they are there until all kernels have ended.
        let tag = self.kernel.channel.tag();
        self.kernel.ports.coordinator.unordered(|order| order.shared.files.leave(tag, path, None));
    }
}

/// A file stored with the machine.
fn stored_file<'m>(machine: &'m Machine, path: &str) -> Option<&'m Bytes> {
    StoredFile::find(&machine.storage, &path.replace('\\', "/"))
}
