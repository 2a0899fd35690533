//! The commands for machines: check, new, list, show, and upload for a job.

use std::path::Path;

use counterpoint_proto::v1;

use crate::arguments::{MachineCommand, MachinePart, RowSelection};
use crate::client::ServerSession;
use crate::error::Error;
use crate::machine_view::TableView;
use crate::text::table;
use crate::tools::ToolDefinitions;
use crate::{findings, known, machine_diff, machine_folder, machine_view, own_machine, pack, say, tape_trial};

pub(crate) async fn dispatch(command: MachineCommand) -> Result<u8, Error> {
    match command {
        MachineCommand::Check { machine, json, at } => check(&machine, json, at.address()).await,
        MachineCommand::New { folder, from } => own_machine::create(&folder, &from),
        MachineCommand::List { json, at } => list(json, at.address()).await,
        MachineCommand::Delete { machine, remote } => delete(machine, &remote.server).await,
        MachineCommand::Show { machine, part, rows: RowSelection { changed: true, sort, filter }, json, .. } => {
            machine_diff::changed(&machine, part, &TableView { sort, filter }, json)
        }
        MachineCommand::Show { machine, part, rows, json, at } => {
            let view = TableView { sort: rows.sort, filter: rows.filter };
            show(&machine, part, &view, json, at.address()).await
        }
        MachineCommand::Diff { a, b, json } => machine_diff::diff(&a, &b, json),
        MachineCommand::Edit { machine, lines, all, json } => tape_trial::edit(&machine, &lines, all, json),
    }
}

async fn check(machine: &str, json: bool, server: Option<&str>) -> Result<u8, Error> {
    let client = ServerSession::at(server).await?;
    let mut request = v1::CheckMachineRequest { name: machine.to_owned(), files: Vec::new() };
    if machine_folder::is_folder(machine) {
        let (name, files) = machine_folder::machine(Path::new(machine))?;
        client.upload(&files.blobs()).await?;
        request = v1::CheckMachineRequest { name, files: machine_files(files) };
    } else {
        known::machine(machine, client.is_embedded())?;
    }
    let answer = client.machines().check_machine(request).await?.into_inner();
    if json {
        let findings = answer.findings.iter().map(findings::as_json).collect::<Vec<_>>();
        let found = serde_json::json!({ "machine": machine, "usable": answer.usable, "findings": findings });
        say::verdict(format!("{found}\n").as_bytes())?;
        return Ok(if answer.usable { 0 } else { 2 });
    }
    findings::print(&answer.findings);
    let verdict = if answer.usable { "usable" } else { "cannot be used" };
    let count = answer.findings.len();
    let plural = if count == 1 { "" } else { "s" };
    say::verdict(format!("{machine}: {verdict}, {count} finding{plural}\n").as_bytes())?;
    Ok(if answer.usable { 0 } else { 2 })
}

async fn list(json: bool, server: Option<&str>) -> Result<u8, Error> {
    let client = ServerSession::at(server).await?;
    let (mut request, mut machines) = (v1::ListMachinesRequest::default(), Vec::new());
    loop {
        let page = client.machines().list_machines(request.clone()).await?.into_inner();
        machines.extend(page.machines);
        if page.next_page_token.is_empty() {
            break;
        }
        request.page_token = page.next_page_token;
    }
    if json {
        let line = |m: &v1::MachineSummary| {
            let row = serde_json::json!({
                "machine": m.name, "revision": m.revision, "shipped": m.shipped, "channels": m.channels,
                "description": m.description,
            });
            format!("{row}\n")
        };
        say::data(machines.iter().map(line).collect::<String>().as_bytes())?;
        return Ok(0);
    }
    let mut rows = vec![["machine", "revision", "channels", "description"].map(str::to_owned).to_vec()];
    rows.extend(machines.into_iter().map(|m| {
        let revision = if m.shipped { "shipped".to_owned() } else { m.revision };
        vec![m.name, revision, m.channels.to_string(), m.description]
    }));
    say::data(table(&rows, 4).as_bytes())?;
    Ok(0)
}

async fn delete(name: String, server: &str) -> Result<u8, Error> {
    let client = ServerSession::connect(server).await?;
    client.machines().delete_machine(v1::DeleteMachineRequest { name }).await?;
    Ok(0)
}

async fn show(
    machine: &str,
    part: MachinePart,
    view: &TableView,
    json: bool,
    server: Option<&str>,
) -> Result<u8, Error> {
    let client = ServerSession::at(server).await?;
    let name = if machine_folder::is_folder(machine) {
        put_machine(&client, Path::new(machine)).await?
    } else {
        known::machine(machine, client.is_embedded())?;
        machine.to_owned()
    };
    let section = match part {
        MachinePart::All | MachinePart::Undefined => v1::MachineSection::All,
        MachinePart::Codes => v1::MachineSection::Codes,
        MachinePart::Data => v1::MachineSection::Data,
        MachinePart::Axes => v1::MachineSection::Axes,
        MachinePart::Channels => v1::MachineSection::Channels,
        MachinePart::Groups => v1::MachineSection::Groups,
        MachinePart::Macros => v1::MachineSection::Macros,
        MachinePart::Refusals => v1::MachineSection::Refusals,
    };
    let undefined = part == MachinePart::Undefined;
    let request = v1::GetMachineRequest { name, section: section.into(), json: json || undefined };
    let mut text = client.machines().get_machine(request).await?.into_inner().text;
    if undefined {
        let found = machine_view::undefined(&serde_json::from_str(&text).unwrap_or_default());
        text = if json { found.to_string() } else { machine_view::undefined_text(&found) };
    }
    let (text, any) = if json {
        view.json(&text)?
    } else {
        let text = view.text(&text)?;
        let any = !text.is_empty();
        (text, any)
    };
    say::data(text.as_bytes())?;
    match &view.filter {
        Some(filter) if !any => Ok(machine_view::no_row(filter)),
        _ => Ok(0),
    }
}

/// Uploads a machine folder to the server; returns `name@revision`.
pub(crate) async fn put_machine(client: &ServerSession, folder: &Path) -> Result<String, Error> {
    let (name, files) = machine_folder::machine(folder)?;
    put_files(client, name, files, None).await
}

/// Uploads the files of a machine to the server; returns `name@revision`. Findings in rows of a table of tools name its
/// lines.
pub(crate) async fn put_files(
    client: &ServerSession,
    name: String,
    files: pack::PackedFiles,
    tools: Option<&ToolDefinitions>,
) -> Result<String, Error> {
    let own = format!("{name}/machine.toml");
    let place = |file: &str, line: u32| tools.filter(|_| file == own).and_then(|tools| tools.place(line));
    client.upload(&files.blobs()).await?;
    let files = machine_files(files);
    let request = v1::PutMachineRequest { name: name.clone(), files };
    match client.machines().put_machine(request).await {
        Ok(response) => {
            let response = response.into_inner();
            let mut findings = response.findings;
            for finding in &mut findings {
                if let Some((file, line)) = place(&finding.file, finding.line) {
                    (finding.file, finding.line, finding.column) = (file.to_owned(), line, 0);
                }
            }
            findings::print(&findings);
            let machine = response.machine.unwrap_or_default();
            Ok(format!("{}@{}", machine.name, machine.revision))
        }
        Err(status) => {
            for violation in tonic_types::StatusExt::get_error_details(&status).bad_request().into_iter() {
                for v in &violation.field_violations {
                    let mut parts = v.field.splitn(3, ':');
                    let file = parts.next().unwrap_or_default();
                    let line = parts.next().and_then(|line| line.parse().ok()).unwrap_or(0);
                    match place(file, line) {
                        Some((file, line)) => say::status_line(format_args!("{file}:{line}: {}", v.description)),
                        None => say::status_line(format_args!("{}: {}", v.field, v.description)),
                    }
                }
            }
            Err(status.into())
        }
    }
}

/// Files of a machine in wire form.
fn machine_files(files: pack::PackedFiles) -> Vec<v1::MachineFile> {
    files.0.into_iter().map(|(path, blob)| v1::MachineFile { path, digest: blob.digest().to_owned() }).collect()
}
