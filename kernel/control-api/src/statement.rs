//! Statements that several controls have: their actions, given the values of their operands.
//!
//! A statement is a constant of this file. Each dialect that has the statement names it in a row of its table of
//! keywords, reads the operands in its own notation and evaluates them. *Invariant:* a statement reaches its kernel
//! only through `InterpreterHost`.

use counterpoint_fault as diag;
use counterpoint_fault::Acted;

use crate::host::InterpreterHost;

/// A statement.
#[derive(Debug, Clone, Copy)]
pub struct SharedStatement {
    /// Numbers that it takes.
    pub operands: usize,
    act: fn(&mut dyn InterpreterHost, &[f64]) -> Acted,
}

/// Most operands of a statement.
const OPERANDS: usize = 4;

/// Keywords of a dialect, or their replacements, with their statements.
pub type Statements<K> = &'static [(K, &'static SharedStatement)];

/// Returns from the subprogram, or ends the main program.
pub static RETURN: SharedStatement = SharedStatement {
    operands: 0,
    act: |host, _| {
        host.return_from();
        Ok(())
    },
};

/// Opens the output of the program.
pub static OPEN_OUTPUT: SharedStatement = SharedStatement {
    operands: 0,
    act: |host, _| {
        host.open_output(true);
        Ok(())
    },
};

/// Closes the output of the program.
pub static CLOSE_OUTPUT: SharedStatement = SharedStatement {
    operands: 0,
    act: |host, _| {
        host.open_output(false);
        Ok(())
    },
};

/// Understood, and without effect on the emulation.
pub static IDLE: SharedStatement = SharedStatement { operands: 0, act: |_, _| Ok(()) };

/// Raises an alarm by its number.
pub static ALARM: SharedStatement = SharedStatement {
    operands: 1,
    act: |host, operands| {
        let number = operands.first().copied().unwrap_or(0.0);
        let text = format!("alarm {number} raised by the program in '{}'", host.block_text());
        Err(host.alarm(&diag::MACRO_ALARM, text))
    },
};

impl PartialEq for SharedStatement {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other)
    }
}

impl SharedStatement {
    /// The statement of a keyword.
    pub fn of<K: PartialEq>(statements: Statements<K>, key: K) -> Option<&'static Self> {
        statements.iter().find(|(known, _)| *known == key).map(|(_, statement)| *statement)
    }

    /// Executes the statement; `value` gives its operands one after the other.
    ///
    /// # Errors
    /// An operand has no value, or the statement stops the channel.
    pub fn execute<X, E: From<diag::Halt>>(
        &self,
        host: &mut dyn InterpreterHost,
        operands: &[X],
        mut value: impl FnMut(&mut dyn InterpreterHost, &X) -> Result<f64, E>,
    ) -> Result<(), E> {
        let mut values = [0.0; OPERANDS];
        for (slot, operand) in values.iter_mut().zip(operands) {
            *slot = value(host, operand)?;
        }
        let values = values.get(..operands.len()).unwrap_or(&values);
        Ok((self.act)(host, values)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_statement_is_found_by_its_key_word() {
        const ROWS: Statements<&str> = &[("RTS", &RETURN), ("ERR", &ALARM)];
        assert_eq!(SharedStatement::of(ROWS, "ERR").map(|statement| statement.operands), Some(1));
        assert_eq!(SharedStatement::of(ROWS, "RTX").map(|statement| statement.operands), None);
        assert!(ROWS.iter().all(|(_, statement)| statement.operands <= OPERANDS));
    }
}
