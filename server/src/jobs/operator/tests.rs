use std::sync::Arc;

use super::*;

fn plain() -> Dialog {
    Dialog { name: "D".into(), title: "D".into(), fields: Vec::new(), buttons: Vec::new() }
}

fn ask(desk: &Desk, channel: u16) -> QuestionOutcome {
    let dialog = plain();
    desk.put(&OpenDialog { channel, file: "p.nc", line: 3, dialog: &dialog, values: &[], problem: None })
}

fn claimed(channel: u16, question: u64) -> Option<Claimed> {
    Some(Claimed { channel, question, dialog: "D".into() })
}

fn answer(dialog: &str) -> DialogAnswer {
    DialogAnswer { dialog: dialog.into(), ..DialogAnswer::default() }
}

#[test]
fn the_first_answer_counts() {
    let desk = Arc::new(Desk::new());
    desk.set_patience(Duration::from_secs(60));
    let changes = desk.follow();
    let kernel = std::thread::spawn({
        let desk = desk.clone();
        move || ask(&desk, 2)
    });
    while desk.questions().is_empty() {
        std::thread::yield_now();
    }
    let question = desk.questions().remove(0);
    let id = question.id;
    assert_eq!((question.channel, question.line, id), (2, 3, (2 << 32) + 1));
    assert_eq!(desk.claim(1), None, "that is a question of channel 1");
    assert_eq!(desk.claim(id), claimed(2, 1));
    assert_eq!(desk.claim(id), None, "another client has taken it");
    assert_eq!(desk.asking(), 1);
    assert!(desk.questions().is_empty());
    desk.answer(id, Ok(answer("D")));
    assert_eq!(kernel.join().unwrap(), QuestionOutcome::Answered(Ok(answer("D"))));
    assert_eq!(desk.asking(), 0);
    assert_eq!(desk.claim(id), None);
    assert_eq!(*changes.borrow(), 3, "asked, claimed, closed");
}

#[test]
fn what_was_answered_before_is_answered_again() {
    let desk = Desk::new();
    desk.record(vec![(1, Ok(answer("A"))), (2, Err(Silence::Declined)), (1, Ok(answer("B")))]);
    assert_eq!(ask(&desk, 1), QuestionOutcome::Answered(Ok(answer("A"))));
    assert_eq!(ask(&desk, 2), QuestionOutcome::Answered(Err(Silence::Declined)));
    assert_eq!(ask(&desk, 1), QuestionOutcome::Answered(Ok(answer("B"))));
    assert!(desk.questions().is_empty());
}

#[test]
fn a_question_has_the_same_id_in_every_run() {
    let desk = Arc::new(Desk::new());
    for earlier in 0..3 {
        desk.begin_again();
        desk.set_patience(Duration::from_secs(60));
        desk.record(vec![(1, Ok(answer("D"))); earlier]);
        let kernel = std::thread::spawn({
            let desk = desk.clone();
            move || (0..=earlier).map(|_| ask(&desk, 1)).collect::<Vec<_>>()
        });
        while desk.questions().is_empty() {
            std::thread::yield_now();
        }
        // The answer to the last question of the run before, once more.
        assert_eq!(desk.claim(earlier as u64), None);
        let next = earlier as u64 + 1;
        assert_eq!(desk.claim(next), claimed(1, next));
        desk.answer(next, Ok(answer("D")));
        let all = (0..=earlier).map(|_| QuestionOutcome::Answered(Ok(answer("D"))));
        assert_eq!(kernel.join().unwrap(), all.collect::<Vec<_>>());
    }
}

#[test]
fn a_question_whose_answer_was_not_stored_is_open_again() {
    let desk = Arc::new(Desk::new());
    desk.set_patience(Duration::from_secs(60));
    let kernel = std::thread::spawn({
        let desk = desk.clone();
        move || ask(&desk, 1)
    });
    while desk.questions().is_empty() {
        std::thread::yield_now();
    }
    assert_eq!(desk.claim(1), claimed(1, 1));
    desk.release(1);
    assert_eq!(desk.questions().len(), 1);
    assert_eq!(desk.claim(1), claimed(1, 1));
    desk.answer(1, Err(Silence::Declined));
    assert_eq!(kernel.join().unwrap(), QuestionOutcome::Answered(Err(Silence::Declined)));
}

#[test]
fn nobody_waits_for_ever() {
    let desk = Desk::new();
    assert_eq!(ask(&desk, 1), QuestionOutcome::Unanswered(1), "no patience at all");
    desk.set_patience(Duration::from_secs(3600));
    desk.close();
    let changes = desk.follow();
    assert_eq!(ask(&desk, 1), QuestionOutcome::Closed, "the run is over");
    assert!(!changes.has_changed().unwrap(), "so no follower sees a question");
}
