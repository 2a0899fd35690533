//! Commands of an operator who steps through a job, as text.

use counterpoint_proto::v1;
use counterpoint_proto::v1::breakpoint::At;
use counterpoint_proto::v1::debug_command::What;

/// All commands.
pub(super) const HELP: &str = "\
step [CHANNEL|all] [xN]   run one block, or N, of the channel with the earliest time, of CHANNEL, or of all channels
over [CHANNEL|all] [xN]   do the same, but a call counts as one block
out [CHANNEL|all] [xN]    run to the block after the return from one call, or from N calls
continue                  run to the next breakpoint or to the end
until PLACE [xN]          run to the first (Nth) hit of PLACE
break PLACE [xN]          stop at every (every Nth) hit of PLACE
clear [NUMBER]            delete one breakpoint, or all breakpoints
hold [CHANNEL]            start the feed hold of one channel, or of all channels
resume [CHANNEL]          end the feed hold of one channel, or of all channels
reset CHANNEL             reset a channel: its program ends before its next block
show                      show channels, positions, remembered words, variables, breakpoints
quit                      run to the end without stops, as the end of the input does
PLACE is: wait [MARK] (wait M101), write VARIABLE (write #500), line [FILE:]LINE (line upper.nc:12), time SECONDS (time 2.5)
Short: s, o, c, u, b, q. Ctrl-C pauses a running job and cancels a stopped job. Text after a ; is a comment.";

/// A line of the input.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum StepInput {
    Nothing,
    Help,
    Quit,
    Show,
    /// A command whose answer is the next stop.
    Run(What),
    /// A command with an answer of its own.
    Set(What),
    /// A breakpoint for once, and to run.
    Until(v1::Breakpoint),
}

/// Reads a line.
pub(super) fn read(text: &str) -> Result<StepInput, String> {
    let text = text.split(';').next().unwrap_or("");
    let mut words: Vec<&str> = text.split_whitespace().collect();
    if words.is_empty() {
        return Ok(StepInput::Nothing);
    }
    let command = words.remove(0).to_lowercase();
    let count = match words.last().and_then(|word| times(word)) {
        // A variable may have such a name.
        _ if matches!(&words[..], ["write", _]) => 0,
        Some(count) if matches!(&*command, "until" | "u" | "break" | "b") || step_calls(&command).is_some() => {
            words.pop();
            count?
        }
        _ => 0,
    };
    if let Some(calls) = step_calls(&command) {
        match &words[..] {
            [] => return Ok(step(0, false, count, calls)),
            ["all"] => return Ok(step(0, true, count, calls)),
            [of] => return Ok(step(channel(of)?, false, count, calls)),
            _ => {}
        }
    }
    let line = match (&*command, &words[..]) {
        ("continue" | "c", []) => StepInput::Run(What::Action(v1::DebugAction::Continue.into())),
        ("until" | "u", place) => StepInput::Until(v1::Breakpoint { at: Some(at(place)?), count, once: true, id: 0 }),
        ("break" | "b", place) => {
            StepInput::Set(What::Add(v1::Breakpoint { at: Some(at(place)?), count, once: false, id: 0 }))
        }
        ("clear", []) => StepInput::Set(What::Remove(0)),
        ("clear", [id]) => StepInput::Set(What::Remove(number(id, "the number of a breakpoint")?)),
        ("hold", []) => StepInput::Set(What::Hold(0)),
        ("hold", [of]) => StepInput::Set(What::Hold(channel(of)?)),
        ("resume", []) => StepInput::Set(What::Resume(0)),
        ("resume", [of]) => StepInput::Set(What::Resume(channel(of)?)),
        ("reset", [of]) => StepInput::Set(What::Reset(channel(of)?)),
        ("show", []) => StepInput::Show,
        ("quit" | "q", []) => StepInput::Quit,
        ("help" | "?", []) => StepInput::Help,
        _ => return Err(format!("'{}' is not a command; help lists the commands", text.trim())),
    };
    Ok(line)
}

/// How a step command treats calls; none for any other command.
fn step_calls(command: &str) -> Option<v1::StepCalls> {
    Some(match command {
        "step" | "s" => v1::StepCalls::Into,
        "over" | "o" => v1::StepCalls::Over,
        "out" => v1::StepCalls::Out,
        _ => return None,
    })
}

fn step(channel: u32, all: bool, blocks: u32, calls: v1::StepCalls) -> StepInput {
    StepInput::Run(What::Step(v1::DebugStep { channel, all, blocks, calls: calls.into() }))
}

/// `x3`; none for another word.
fn times(word: &str) -> Option<Result<u32, String>> {
    let digits = word.strip_prefix(['x', 'X']).filter(|digits| digits.starts_with(|c: char| c.is_ascii_digit()))?;
    Some(number(digits, "how often"))
}

/// A whole number above 0.
fn number(text: &str, what: &str) -> Result<u32, String> {
    let number = text.parse().ok().filter(|number| *number > 0);
    number.ok_or_else(|| format!("'{text}' is not {what}: expected a whole number above 0"))
}

fn channel(text: &str) -> Result<u32, String> {
    number(text, "a channel")
}

/// A place to stop at.
fn at(words: &[&str]) -> Result<At, String> {
    match words {
        ["wait", key @ ..] => Ok(At::Wait(key.join(" "))),
        ["write", name] => Ok(At::Write((*name).to_owned())),
        ["line", place] | [place] if place.contains(':') || words.len() == 2 => {
            let (file, line) = place.rsplit_once(':').unwrap_or(("", place));
            let line = number(line, "a line")?;
            Ok(At::Line(v1::BreakLine { file: file.to_owned(), line }))
        }
        ["time", seconds] => match seconds.parse::<f64>() {
            Ok(seconds) if (0.0..9e9).contains(&seconds) => Ok(At::TNs((seconds * 1e9).round() as i64)),
            _ => Err(format!("'{seconds}' is not a time in seconds, such as 2.5")),
        },
        _ => Err(format!(
            "'{}' is not a place: expected wait MARK, write VARIABLE, line FILE:LINE or time SECONDS",
            words.join(" ")
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn added(text: &str) -> (At, u32) {
        match read(text) {
            Ok(StepInput::Set(What::Add(breakpoint))) => (breakpoint.at.unwrap(), breakpoint.count),
            other => panic!("{text}: {other:?}"),
        }
    }

    #[test]
    fn commands_are_read() {
        use v1::StepCalls::{Into, Out, Over};
        assert_eq!(read("step"), Ok(step(0, false, 0, Into)));
        assert_eq!(read(" S 2 x3 ; the lower turret"), Ok(step(2, false, 3, Into)));
        assert_eq!(read("step all X2"), Ok(step(0, true, 2, Into)));
        assert_eq!((read("over"), read("o 2 x4")), (Ok(step(0, false, 0, Over)), Ok(step(2, false, 4, Over))));
        assert_eq!((read("out"), read("out all x2")), (Ok(step(0, false, 0, Out)), Ok(step(0, true, 2, Out))));
        assert_eq!(read("hold"), Ok(StepInput::Set(What::Hold(0))));
        assert_eq!(read("resume 2"), Ok(StepInput::Set(What::Resume(2))));
        assert_eq!(read("clear 4"), Ok(StepInput::Set(What::Remove(4))));
        assert_eq!(read("; nothing"), Ok(StepInput::Nothing));
        assert_eq!(read("q"), Ok(StepInput::Quit));
        let until = v1::Breakpoint { id: 0, at: Some(At::Wait(String::new())), count: 3, once: true };
        assert_eq!(read("until wait x3"), Ok(StepInput::Until(until)));
    }

    #[test]
    fn places_are_read() {
        let line = |file: &str, line| At::Line(v1::BreakLine { file: file.into(), line });
        assert_eq!(added("break wait M101 P12"), (At::Wait("M101 P12".into()), 0));
        assert_eq!(added("b write #500 x2"), (At::Write("#500".into()), 2));
        assert_eq!(added("b write X2"), (At::Write("X2".into()), 0));
        assert_eq!(added("break line upper.nc:12"), (line("upper.nc", 12), 0));
        assert_eq!(added("break C:/p.nc:7"), (line("C:/p.nc", 7), 0));
        assert_eq!(added("break line 12"), (line("", 12), 0));
        assert_eq!(added("break time 2.5"), (At::TNs(2_500_000_000), 0));
    }

    #[test]
    fn what_is_no_command_is_said() {
        for (text, why) in [
            ("jump 3", "'jump 3' is not a command; help lists the commands"),
            ("step 0", "'0' is not a channel: expected a whole number above 0"),
            ("step x0", "'0' is not how often: expected a whole number above 0"),
            ("reset", "'reset' is not a command; help lists the commands"),
            ("break", "'' is not a place: expected wait MARK, write VARIABLE, line FILE:LINE or time SECONDS"),
            ("break line p.nc:0", "'0' is not a line: expected a whole number above 0"),
            ("until time -1", "'-1' is not a time in seconds, such as 2.5"),
        ] {
            assert_eq!(read(text), Err(why.to_owned()), "{text}");
        }
    }
}
