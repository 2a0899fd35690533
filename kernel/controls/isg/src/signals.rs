//! `#SIGNAL`, `#WAIT`, `#SIGNAL READ`, `#SIGNAL REMOVE`: their notation, and their requests to the kernel.
//!
//! Facts: reference channel-synchronisation.md 1.7, and the control's own alarms, whose numbers the texts begin with.
//! Decisions: no block is decoded before it is executed, so a statement acts at the same time with `SYN` and without;
//! `AHEAD` saves a stop that motion here does not have; a signal outlives the run of no channel, so `KEEP_AT_RESET`
//! changes nothing. Invariant: values go with signals at the level of the decoder only.

use counterpoint_fault as diag;

use super::cursor::{IsgCursor, IsgSyntaxError};
use super::expr::{Expr, IsgExpressionReader, IsgVariable};
use super::{Isg, IsgBlockError, Outcome};
use counterpoint_control_api::host::{InterpreterHost, Signal};
use counterpoint_control_api::outline::SignalOp;

/// Indices of values: 0 to 11.
const VALUES: f64 = 12.0;

/// A value that goes with a signal, or where it goes.
#[derive(Debug, Clone, PartialEq)]
enum SignalValue {
    From(Expr),
    Into(IsgVariable),
}

/// A statement as written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SignalStatement {
    pub(super) deed: SignalOp,
    pub(super) number: Expr,
    pub(super) last: Option<Expr>,
    pub(super) channels: Vec<Expr>,
    pub(super) uses: Option<Expr>,
    values: Vec<(Expr, SignalValue)>,
}

impl SignalStatement {
    /// Name of its row in the machine.
    pub(super) fn row(&self) -> &'static str {
        match self.deed {
            SignalOp::Send | SignalOp::Remove => "SIGNAL",
            SignalOp::Wait | SignalOp::Read => "WAIT",
        }
    }
}

/// `#WAIT` may begin other statements, as `#WAIT MC_STATUS` or `#WAIT FOR`.
pub(super) fn is_one(word: &str, cursor: &IsgCursor<'_>) -> bool {
    let mut ahead = cursor.clone();
    let other = ahead.peek().is_some_and(|byte| byte.is_ascii_alphabetic());
    word == "SIGNAL" || !other || ahead.word("SYN")
}

/// Reads the text after the word.
pub(super) fn read(word: &str, cursor: &mut IsgCursor<'_>) -> Result<SignalStatement, IsgSyntaxError> {
    let deed = match word {
        "WAIT" => SignalOp::Wait,
        _ if cursor.word("REMOVE") => SignalOp::Remove,
        _ if cursor.word("READ") => SignalOp::Read,
        _ => SignalOp::Send,
    };
    let syn = cursor.word("SYN");
    if !cursor.take(b'[') {
        return Err(IsgSyntaxError::signal(format!(
            "20998 #{word} needs SYN or a bracket at column {}",
            cursor.at + 1
        )));
    }
    if syn && deed == SignalOp::Read {
        return Err(IsgSyntaxError::signal("21344 #SIGNAL READ cannot be synchronous"));
    }
    let (mut number, mut last) = (None, None);
    let (mut channels, mut uses, mut values) = (Vec::new(), None, Vec::new());
    while !cursor.take(b']') {
        cursor.take(b',');
        if deed == SignalOp::Remove && cursor.key("IDMAX") {
            once(&mut last, value(cursor)?)?;
        } else if deed == SignalOp::Remove && cursor.key("IDMIN") || cursor.key("ID") {
            once(&mut number, value(cursor)?)?;
        } else if deed == SignalOp::Send && cursor.key("COUNT") {
            once(&mut uses, value(cursor)?)?;
        } else if cursor.key("CH") {
            channels.push(value(cursor)?);
        } else if deed == SignalOp::Wait && cursor.word("AHEAD")
            || deed == SignalOp::Send && cursor.key("KEEP_AT_RESET")
        {
        } else if deed != SignalOp::Remove && cursor.key("P") {
            let index = IsgExpressionReader::new(cursor).index()?;
            cursor.expect(b'=', "'='")?;
            cursor.peek();
            let value = match deed {
                SignalOp::Send => SignalValue::From(IsgExpressionReader::new(cursor).expression()?),
                _ => SignalValue::Into(IsgExpressionReader::new(cursor).variable()?),
            };
            values.push((index, value));
        } else {
            return Err(IsgSyntaxError::expected("ID, CH or another key word of the statement, or ']'", cursor.at));
        }
    }
    if syn && !values.is_empty() {
        return Err(IsgSyntaxError::signal(format!(
            "21344 #{word} SYN cannot have values; they need #{word} without SYN"
        )));
    }
    let number =
        number.ok_or_else(|| IsgSyntaxError::signal(format!("#{word} needs the number of its signal (ID)")))?;
    Ok(SignalStatement { deed, number, last, channels, uses, values })
}

/// The value of a keyword, with or without `=`.
fn value(cursor: &mut IsgCursor<'_>) -> Result<Expr, IsgSyntaxError> {
    cursor.take(b'=');
    IsgExpressionReader::new(cursor).sum()
}

fn once(slot: &mut Option<Expr>, value: Expr) -> Result<(), IsgSyntaxError> {
    match slot.replace(value) {
        None => Ok(()),
        Some(_) => Err(IsgSyntaxError::signal("21056 a key word stands twice in the statement")),
    }
}

impl Isg {
    /// Executes a statement of signals.
    pub(super) fn signal(&mut self, host: &mut dyn InterpreterHost, statement: &SignalStatement) -> Outcome<()> {
        let mut signal = Signal { number: self.value(host, &statement.number)?, ..Signal::default() };
        for channel in &statement.channels {
            signal.channels.push(self.value(host, channel)?);
        }
        if let Some(last) = &statement.last {
            signal.last = Some(self.value(host, last)?);
        }
        if let Some(uses) = &statement.uses {
            signal.uses = Some(self.value(host, uses)?);
        }
        let mut targets: Vec<(u8, &IsgVariable)> = Vec::new();
        for (index, value) in &statement.values {
            let index = self.value(host, index)?;
            if index.fract() != 0.0 || !(0.0..VALUES).contains(&index) {
                return wrong(format!("P[{index}] is not possible, only 0 to 11"));
            }
            let index = index as u8;
            if signal.values.iter().any(|(known, _)| *known == index)
                || targets.iter().any(|(known, _)| *known == index)
            {
                return wrong(format!("21059 P[{index}] stands twice in the statement"));
            }
            match value {
                SignalValue::From(expression) => signal.values.push((index, self.value(host, expression)?)),
                SignalValue::Into(variable) => targets.push((index, variable)),
            }
        }
        let row = statement.row();
        match statement.deed {
            SignalOp::Send => Ok(host.send(row, &signal)?),
            SignalOp::Remove => Ok(host.remove_signal(row, &signal)?),
            SignalOp::Wait | SignalOp::Read => {
                let received = host.receive(row, &signal, statement.deed == SignalOp::Wait)?;
                if statement.deed == SignalOp::Read {
                    self.signal_read = received.is_some();
                }
                match received {
                    Some(values) => self.take_over(host, &targets, &values),
                    None => Ok(()),
                }
            }
        }
    }

    /// Assigns the values of signals; each of them has to go somewhere.
    fn take_over(
        &mut self,
        host: &mut dyn InterpreterHost,
        targets: &[(u8, &IsgVariable)],
        values: &[(u8, f64)],
    ) -> Outcome<()> {
        if let Some((index, _)) = values.iter().find(|(index, _)| targets.iter().all(|(target, _)| target != index)) {
            let text = format!("21549 the signal has a value P[{index}], which the statement does not take over");
            return Err(IsgBlockError::Alarm(&diag::SIGNAL_VALUE, text));
        }
        for (target, variable) in targets {
            let Some((_, value)) = values.iter().find(|(index, _)| index == target) else {
                let text = format!("21549 the signal has no value P[{target}]");
                return Err(IsgBlockError::Alarm(&diag::SIGNAL_VALUE, text));
            };
            self.assign(host, variable, *value)?;
        }
        Ok(())
    }
}

fn wrong<T>(text: String) -> Outcome<T> {
    Err(IsgBlockError::Alarm(&diag::SIGNAL_STATEMENT, text))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statement(text: &str) -> Result<SignalStatement, String> {
        let upper = text.to_ascii_uppercase();
        let mut cursor = IsgCursor::new(upper.as_bytes());
        cursor.at = 1;
        let word = cursor.run(|byte| byte.is_ascii_alphabetic());
        let read = read(word, &mut cursor).map_err(|mistake| mistake.text)?;
        cursor.end().map_err(|mistake| mistake.text)?;
        Ok(read)
    }

    #[test]
    fn every_spelling() {
        let plain = statement("#SIGNAL [ID4711 CH1 CH2]").unwrap();
        assert_eq!((plain.deed, plain.channels.len(), plain.number.as_constant()), (SignalOp::Send, 2, Some(&4711.0)));
        assert_eq!(statement("#signal[ id=4711, ch=1 ch = 2 ]").unwrap(), plain);
        assert_eq!(statement("#WAIT SYN [ID968 CH2 AHEAD]").unwrap().deed, SignalOp::Wait);
        assert_eq!(statement("#SIGNAL SYN [ID1 COUNT 3 KEEP_AT_RESET]").unwrap().uses, Some(Expr::constant(3.0)));
        assert_eq!(statement("#SIGNAL READ [ID1 P[0]=P5]").unwrap().values.len(), 1);
        let range = statement("#SIGNAL REMOVE [IDMIN=1 IDMAX=9]").unwrap();
        assert_eq!((range.deed, range.row(), range.last), (SignalOp::Remove, "SIGNAL", Some(Expr::constant(9.0))));
        assert_eq!(statement("#SIGNAL [IDP100 P[0]= V.P.SYNC CH3]").unwrap().values.len(), 1);
    }

    #[test]
    fn mistakes_have_the_numbers_of_the_control() {
        for (text, says) in [
            ("#SIGNAL ID1", "20998"),
            ("#WAIT", "20998"),
            ("#SIGNAL [ID1 ID2]", "21056"),
            ("#WAIT SYN [ID1 P[0]=P1]", "21344"),
            ("#SIGNAL SYN [ID1 P[0]=1]", "21344"),
            ("#SIGNAL READ SYN [ID1]", "21344"),
            ("#WAIT [CH1]", "needs the number"),
            ("#WAIT [ID1 P[0]=5]", "expected a variable"),
            ("#WAIT [ID1 COUNT2]", "expected ID"),
            ("#WAIT [ID1", "expected ID"),
            ("#SIGNAL [ID1] X5", "unexpected text"),
        ] {
            let mistake = statement(text).unwrap_err();
            assert!(mistake.contains(says), "{text}: {mistake}");
        }
    }

    #[test]
    fn other_statements_begin_alike() {
        for (text, is) in [(" [ID1]", true), (" SYN [ID1]", true), (" MC_STATUS [ID1]", false), (" FOR V.E.X", false)] {
            assert_eq!(is_one("WAIT", &IsgCursor::new(text.as_bytes())), is, "{text}");
        }
    }
}
