use super::*;

#[test]
fn a_job_that_has_not_stopped_after_its_cancel_is_cancelling() {
    let shown = |state: v1::JobState, paused: bool| {
        let job = v1::JobStatus { state: state.into(), paused, cancel_requested: true, ..Default::default() };
        assert_eq!(as_json(&job)["cancel_requested"], true);
        state_name(&job)
    };
    assert_eq!(shown(v1::JobState::Running, false), "CANCELLING");
    assert_eq!(shown(v1::JobState::Queued, true), "CANCELLING");
    assert_eq!(shown(v1::JobState::Cancelled, false), "CANCELLED");
    assert_eq!(shown(v1::JobState::Succeeded, false), "SUCCEEDED", "it ended before it could stop");
}

#[test]
fn the_progress_of_a_running_job_is_in_its_json() {
    let state = v1::ChannelState::Running.into();
    let channel = v1::ChannelProgress { channel: 2, state, blocks: 7, t_ns: 5, ..Default::default() };
    let progress = v1::Progress { position: 12, channels: vec![channel], ..Default::default() };
    let line = json_line_with(&v1::JobStatus::default(), Some(&progress));
    let json: serde_json::Value = serde_json::from_str(&line).unwrap();
    assert_eq!(json["events"], 12);
    let channel = &json["progress"][0];
    let shown = (&channel["channel"], &channel["state"], &channel["blocks"], &channel["t_ns"]);
    assert_eq!(shown, (&2.into(), &"RUNNING".into(), &7.into(), &5.into()));
    assert_eq!(json_line_with(&v1::JobStatus::default(), None), json_line(&v1::JobStatus::default()));
}

#[test]
fn a_job_that_waits_for_a_client_names_the_command() {
    let wait =
        |action: v1::OperatorAction| v1::OperatorWait { action: action.into(), since_ms: 1000, until_ms: 61_000 };
    let answer = wait(v1::OperatorAction::Answer);
    let times = "since 1970-01-01 00:00:01 UTC, until 1970-01-01 00:01:01 UTC";
    let text = format!("waits for an operator {times}: counterpoint attend a (needs the role operate)");
    assert_eq!(held("a", Some(&answer), false), Some(text));
    let text = format!("waits for a step command {times}: counterpoint step a (needs the role operate)");
    assert_eq!(held("a", Some(&wait(v1::OperatorAction::Command)), false), Some(text));
    assert_eq!(held("a", Some(&answer), true).as_deref(), Some("paused: counterpoint resume a"));
    assert_eq!(held("a", None, false), None);
    let job = v1::JobStatus { operator_wait: Some(answer), ..Default::default() };
    assert_eq!(
        as_json(&job)["operator_wait"],
        serde_json::json!({ "action": "ANSWER", "since_ms": 1000, "until_ms": 61_000 })
    );
    assert_eq!(as_json(&v1::JobStatus::default()).get("operator_wait"), None);
}

#[test]
fn a_waiting_job_says_why_it_waits() {
    let job = v1::JobStatus {
        state: v1::JobState::Queued.into(),
        waits_for_suspect: true,
        waits_for_job: "01938f2c-5d1e".to_owned(),
        ..Default::default()
    };
    let text = "waits while job 01938f2c-5d1e, suspected of causing the last crash, runs alone";
    assert_eq!(waits(&job).as_deref(), Some(text));
    assert_eq!(
        (&as_json(&job)["waits_for_suspect"], as_json(&job)["waits_for_job"].as_str()),
        (&true.into(), Some("01938f2c-5d1e"))
    );
    let other = v1::JobStatus { waits_for_job: String::new(), ..job };
    let text = "waits while a job of another tenant, suspected of causing the last crash, runs alone";
    assert_eq!(waits(&other).as_deref(), Some(text));
    assert_eq!(waits(&v1::JobStatus::default()), None);
    for (workers, waiting_for_client, tenant_running, text) in [
        (2, 2, false, "waits for a worker: all run jobs that wait for a client"),
        (2, 1, false, "waits for a worker: your jobs use all 2, and 1 of them waits for a client"),
        (1, 0, true, "waits for a worker: your tenant already uses its 1 (tenant_running)"),
        (
            3,
            2,
            true,
            "waits for a worker: your tenant already uses its 3 (tenant_running), and 2 of them wait for a client",
        ),
    ] {
        let wait = v1::WorkerWait { workers, waiting_for_client, tenant_running };
        let job = v1::JobStatus { worker_wait: Some(wait), ..Default::default() };
        assert_eq!(waits(&job).as_deref(), Some(text));
        let json = &as_json(&job)["worker_wait"];
        assert_eq!((&json["workers"], &json["tenant_running"]), (&workers.into(), &tenant_running.into()));
    }
}
