//! Service `MachinesService`.

use counterpoint_kernel::machine::Machine;
use counterpoint_kernel::machine::finding::Finding;
use counterpoint_kernel::machine::show::{self, Show};
use counterpoint_proto::v1;
use counterpoint_proto::v1::machines_server::Machines as Service;
use prost::Message as _;
use tonic::{Request, Response, Status};

use super::door::{enter, some_entries};
use super::{MachinesService, look_up, page, submit, to_the_end};
use crate::access::Role;
use crate::jobs::Core;
use crate::jobs::describe::finding;
use crate::machines::{CheckedMachine, MachineRecord, is_name, is_shipped, shipped};
use crate::net::MAX_MESSAGE;
use crate::reason::Refusal;

/// Refuses an answer that does not fit into a message.
fn fitting(answer: v1::GetMachineResponse, most: usize) -> Result<v1::GetMachineResponse, Refusal> {
    const REMEDY: &str = "ask for one section, or for none and read the files with Download";
    match answer.encoded_len() {
        bytes if bytes > most => Err(Refusal::AnswerTooLarge(bytes, REMEDY)),
        _ => Ok(answer),
    }
}

#[tonic::async_trait]
impl Service for MachinesService {
    async fn put_machine(
        &self,
        request: Request<v1::PutMachineRequest>,
    ) -> Result<Response<v1::PutMachineResponse>, Status> {
        let (core, (caller, request)) = (self.0.clone(), enter(request)?);
        caller.about(&request.name);
        if self.0.reserved(&request.name) {
            return Err(Refusal::MachineShipped(request.name).into());
        }
        let (tenant, trusted) = (caller.tenant().to_owned(), caller.identity.role >= Role::Admin);
        let identity = caller.identity.key();
        let (definition, checked) = look_up(&self.0, &identity, move || {
            core.within_quotas(&tenant)?;
            let definition = MachineRecord { trusted, ..definition(&core, tenant, request.name, request.files)? };
            let checked = core.machines.load(&definition)?;
            match checked.machine {
                Some(_) => Ok((definition, checked)),
                None => Err(invalid(&checked.findings)),
            }
        })
        .await?;
        let machine = Some(summary(&definition, &checked));
        let blobs = self.0.blobs.of(caller.tenant());
        let check = Box::new(move |definition: &MachineRecord| blobs.require(&mut definition.files.values()));
        let core = self.0.clone();
        to_the_end(&caller, async move { core.ledger.put_machine(definition, check).await }).await?;
        Ok(Response::new(v1::PutMachineResponse { machine, findings: findings(checked.findings) }))
    }

    async fn get_machine(
        &self,
        request: Request<v1::GetMachineRequest>,
    ) -> Result<Response<v1::GetMachineResponse>, Status> {
        let (core, (caller, request)) = (self.0.clone(), enter(request)?);
        caller.about(&request.name);
        let section = v1::MachineSection::try_from(request.section)
            .map_err(|_| Refusal::field("section", format!("{} is not a section", request.section)))?;
        let identity = caller.identity.key();
        let answer = look_up(&self.0, &identity, move || {
            let definition = submit::machine(&core, caller.tenant(), &request.name)?;
            let checked = core.machines.load(&definition)?;
            let machine = Some(summary(&definition, &checked));
            let text = match &checked.machine {
                Some(machine) => shown(machine, section, request.json),
                None => return Err(invalid(&checked.findings)),
            };
            let file = |(path, digest)| v1::MachineFile { path, digest };
            let files = definition.files.into_iter().map(file).collect();
            fitting(v1::GetMachineResponse { machine, files, text }, MAX_MESSAGE)
        });
        Ok(Response::new(answer.await?))
    }

    async fn list_machines(
        &self,
        request: Request<v1::ListMachinesRequest>,
    ) -> Result<Response<v1::ListMachinesResponse>, Status> {
        let (core, (caller, request)) = (self.0.clone(), enter(request)?);
        let identity = caller.identity.key();
        let answer = look_up(&self.0, &identity, move || {
            let mut all = core.ledger.machines(caller.tenant())?;
            all.retain(|definition| !core.reserved(&definition.name));
            let shadowed = |name: &String| all.iter().any(|d| d.name == *name);
            let shipped: Vec<_> = shipped().iter().filter(|name| !shadowed(name)).collect();
            all.extend(shipped.iter().map(|name| MachineRecord::shipped(name)));
            all.sort_by(|a, b| a.name.cmp(&b.name));
            let summary = |definition: &MachineRecord| Ok(summary(definition, &core.machines.load(definition)?));
            let size = (request.page_size, 500);
            let (machines, next_page_token) = page(&all, size, &request.page_token, |d| d.name.as_str(), summary)?;
            Ok(v1::ListMachinesResponse { machines, next_page_token })
        });
        Ok(Response::new(answer.await?))
    }

    async fn delete_machine(
        &self,
        request: Request<v1::DeleteMachineRequest>,
    ) -> Result<Response<v1::DeleteMachineResponse>, Status> {
        let (caller, v1::DeleteMachineRequest { name }) = enter(request)?;
        caller.about(&name);
        if self.0.reserved(&name) {
            return Err(Refusal::MachineShipped(name).into());
        }
        if !is_name(&name) {
            return Err(Refusal::field("name", "must be the name of a machine, without a revision").into());
        }
        let (tenant, trusted) = (caller.tenant().to_owned(), caller.identity.role >= Role::Admin);
        let (core, removed) = (self.0.clone(), name.clone());
        match to_the_end(&caller, async move { core.ledger.remove_machine(tenant, removed, trusted).await }).await? {
            true => Ok(Response::new(v1::DeleteMachineResponse {})),
            false => Err(submit::unknown_machine(&self.0, caller.tenant(), &name)?.into()),
        }
    }

    async fn check_machine(
        &self,
        request: Request<v1::CheckMachineRequest>,
    ) -> Result<Response<v1::CheckMachineResponse>, Status> {
        let (core, (caller, request)) = (self.0.clone(), enter(request)?);
        caller.about(&request.name);
        let identity = caller.identity.key();
        let checked = look_up(&self.0, &identity, move || {
            let definition = if request.files.is_empty() {
                submit::machine(&core, caller.tenant(), &request.name)?
            } else {
                definition(&core, caller.tenant().to_owned(), request.name, request.files)?
            };
            core.machines.load(&definition)
        })
        .await?;
        let usable = checked.machine.is_some();
        Ok(Response::new(v1::CheckMachineResponse { usable, findings: findings(checked.findings) }))
    }
}

fn definition(
    core: &Core,
    tenant: String,
    name: String,
    files: Vec<v1::MachineFile>,
) -> Result<MachineRecord, Refusal> {
    if !is_name(&name) {
        return Err(Refusal::field("name", "must be 1 to 64 characters of A-Z a-z 0-9 . _ - and not begin with a dot"));
    }
    some_entries("files", files.len(), core.options.maxima.max_files, "max_files")?;
    core.blobs.of(&tenant).require(&mut files.iter().map(|file| &file.digest))?;
    let files = files.into_iter().map(|f| (f.path, f.digest)).collect();
    Ok(MachineRecord { name, files, tenant, trusted: false })
}

fn invalid(findings: &[Finding]) -> Refusal {
    let place = |f: &Finding| match f.line {
        0 => (f.file.clone(), f.text.clone()),
        line => (format!("{}:{line}:{}", f.file, f.column), f.text.clone()),
    };
    Refusal::MachineInvalid(findings.iter().filter(|f| f.error).map(place).collect())
}

fn findings(findings: Vec<Finding>) -> Vec<v1::Finding> {
    findings.into_iter().map(|f| finding(f.into())).collect()
}

fn summary(definition: &MachineRecord, checked: &CheckedMachine) -> v1::MachineSummary {
    let machine = checked.machine.as_deref();
    v1::MachineSummary {
        name: definition.name.clone(),
        revision: definition.revision(),
        shipped: definition.files.is_empty() && is_shipped(&definition.name),
        description: machine.map_or_else(String::new, |m| m.description.clone()),
        channels: machine.map_or(0, |m| m.channels.len() as u32),
    }
}

fn shown(machine: &Machine, section: v1::MachineSection, json: bool) -> String {
    let part = match section {
        v1::MachineSection::Unspecified => return String::new(),
        v1::MachineSection::All => Show::All,
        v1::MachineSection::Codes => Show::Codes,
        v1::MachineSection::Data => Show::Data,
        v1::MachineSection::Axes => Show::Axes,
        v1::MachineSection::Channels => Show::Channels,
        v1::MachineSection::Groups => Show::Groups,
        v1::MachineSection::Macros => Show::Macros,
        v1::MachineSection::Refusals => Show::Refusals,
    };
    if json { format!("{:#}\n", show::json_part(machine, part)) } else { show::show(machine, part) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_beyond_a_message_is_refused_with_a_remedy() {
        let answer = v1::GetMachineResponse { text: "x".repeat(1000), ..Default::default() };
        assert!(fitting(answer.clone(), 1003).is_ok(), "tag and length of the text take three bytes");
        let refused = fitting(answer, 1002).unwrap_err();
        assert_eq!(refused.reason().0, "ANSWER_TOO_LARGE");
        assert!(refused.to_string().contains("has 1003 bytes") && refused.to_string().contains("one section"));
    }
}
