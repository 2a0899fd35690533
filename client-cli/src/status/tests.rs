use super::*;

#[test]
fn what_is_not_known_is_left_out() {
    let job = v1::JobStatus {
        job_id: "01938f2c".to_owned(),
        state: v1::JobState::Running.into(),
        submitted_ms: 1000,
        started_ms: 3000,
        attempt: 1,
        labels: [("name".to_owned(), "bracket 17".to_owned()), ("shift".to_owned(), "early".to_owned())].into(),
        machine_guess: "T1 M6 (line 2)".to_owned(),
        suspect: true,
        operator_wait: Some(v1::OperatorWait {
            action: v1::OperatorAction::Answer.into(),
            since_ms: 4000,
            until_ms: 64_000,
        }),
        priority: v1::JobPriority::Normal.into(),
        ..Default::default()
    };
    let text = shown(&job, ("fanuc-mill", String::new()), 4500);
    assert_eq!(
        text.lines().collect::<Vec<_>>(),
        [
            "job           01938f2c",
            "labels        bracket 17 shift=early",
            "state         RUNNING",
            "machine       fanuc-mill, guessed from T1 M6 (line 2)",
            "submitted     1970-01-01 00:00:01 UTC",
            "started       1970-01-01 00:00:03 UTC",
            "ran           00:01.500",
            "waits         for an operator since 1970-01-01 00:00:04 UTC, until 1970-01-01 00:01:04 UTC: counterpoint attend \
             01938f2c (needs the role operate)",
            "suspect       the server died while this job was at work: it runs alone at first, and other jobs wait",
        ]
    );
    assert_eq!(heading(&job), "job 01938f2c  bracket 17 shift=early  submitted 1970-01-01 00:00:01 UTC\n");
}

#[test]
fn a_running_job_has_its_progress() {
    let channel = v1::ChannelProgress {
        name: "UPPER".to_owned(),
        state: v1::ChannelState::Waiting.into(),
        blocks: 500,
        line: 12,
        percent: 40.2,
        t_ns: 61_234_000_000,
        waiting_for: "M101 with 2".to_owned(),
        ..Default::default()
    };
    let progress = v1::Progress { position: 1200, channels: vec![channel], ..Default::default() };
    assert_eq!(
        running(Some(&progress)).lines().collect::<Vec<_>>(),
        ["UPPER         40 %, line 12, block 500  01:01.234  waits for M101 with 2", "events        1200",]
    );
    assert_eq!(running(None), "");
}

#[test]
fn only_a_job_that_has_succeeded_has_a_cycle_time() {
    let shown_of = |state: v1::JobState, log_digest: &str| {
        let (state, log_digest) = (state.into(), log_digest.to_owned());
        let job = v1::JobStatus { state, log_digest, ended_ms: 1000, makespan_ns: 2_500_000_000, ..Default::default() };
        shown(&job, ("fanuc-mill", String::new()), 2000)
    };
    assert!(shown_of(v1::JobState::Succeeded, "aa").contains("\ncycle time    00:02.500\n"));
    assert!(shown_of(v1::JobState::Failed, "aa").contains("\nstopped after 00:02.500\n"));
    for absent in ["cycle time", "stopped after"] {
        let text = shown_of(v1::JobState::Cancelled, "");
        assert!(!text.contains(absent), "the job was not run: {text}");
    }
}
