//! From the text of a line to a [`FanucLine`]: its statement.

use super::cursor::{FanucParser, FanucSyntaxError, NESTING};
use super::expr::{Expr, variable_index};
use super::statement::{AssignmentTarget, FanucLine, FanucStatement, TemplateWord, WordName};
use super::vocabulary::{KEY_WORDS, STATEMENTS, macro_call};
use counterpoint_control_api::statement::SharedStatement;
use counterpoint_program::key_words::{StatementVocabulary, key_word};

/// Compiles a line (comments and optional-skip marks already blanked out) of a machine that has these names.
///
/// # Errors
/// [`FanucSyntaxError`] with the column and the expected input.
pub(super) fn compile(text: &[u8], names: StatementVocabulary<'_>) -> Result<FanucLine, FanucSyntaxError> {
    let mut parser = FanucParser { text, at: 0, depth: 0, names, written: None, name: None };
    let mut sequence = None;
    parser.blanks();
    if matches!(parser.peek(), Some(b'N' | b'n')) {
        let start = parser.at;
        parser.at += 1;
        match parser.unsigned() {
            Some(number) => sequence = Some(number),
            None => parser.at = start,
        }
    }
    parser.blanks();
    let place = (parser.at as u32, text.trim_ascii_end().len() as u32);
    let statement = parser.statement()?;
    parser.blanks();
    if parser.at < text.len() {
        return Err(parser.error("the end of the statement"));
    }
    let executes = match &statement {
        FanucStatement::Words(words) => words.iter().any(|word| word.value.as_constant().is_none()),
        _ => true,
    };
    Ok(FanucLine { sequence, statement, place, name: parser.name, messages: Box::default(), executes })
}

impl FanucParser<'_> {
    fn statement(&mut self) -> Result<FanucStatement, FanucSyntaxError> {
        if self.peek() == Some(b'#') {
            return self.assignments();
        }
        if self.stands_long_name() || !key_word(self.names, self.text, self.at) {
            return self.words();
        }
        match self.keyword(KEY_WORDS.all) {
            Some("IF") => self.conditional(),
            Some("WHILE") => {
                let condition = self.condition()?;
                if self.keyword(&["DO"]).is_none() {
                    return Err(self.error("DO after the condition"));
                }
                Ok(FanucStatement::While(condition, self.loop_number()?))
            }
            Some("DO") => Ok(FanucStatement::Do(self.loop_number()?)),
            Some("END") => Ok(FanucStatement::End(self.loop_number()?)),
            Some("ENDIF") => Ok(FanucStatement::EndIf),
            Some("ELSE") => Ok(FanucStatement::Else),
            Some("GOTO") => Ok(FanucStatement::Goto(self.jump_target()?)),
            Some("THEN") => Err(self.error("IF before THEN")),
            Some("DPRNT") => Ok(FanucStatement::Print(self.items(2)?)),
            Some("BPRNT") => Ok(FanucStatement::PrintBinary(self.items(1)?)),
            Some(word) => match SharedStatement::of(STATEMENTS, word) {
                Some(shared) => Ok(FanucStatement::Shared(shared, self.operands(shared.operands)?)),
                None => self.words(),
            },
            None => self.words(),
        }
    }

    /// This many operands in brackets, with commas between them.
    fn operands(&mut self, count: usize) -> Result<Box<[Expr]>, FanucSyntaxError> {
        let mut operands = Vec::with_capacity(count);
        for at in 0..count {
            if !self.accept(if at == 0 { b'[' } else { b',' }) {
                return Err(self.error("an operand in brackets"));
            }
            let mut ops = Vec::new();
            self.relation(&mut ops)?;
            operands.push(self.checked(ops)?);
        }
        if count > 0 && !self.accept(b']') {
            return Err(self.error("']'"));
        }
        Ok(operands.into())
    }

    fn conditional(&mut self) -> Result<FanucStatement, FanucSyntaxError> {
        let condition = self.condition()?;
        match self.keyword(&["GOTO", "THEN"]) {
            Some("GOTO") => Ok(FanucStatement::IfGoto(condition, self.jump_target()?)),
            Some(_) if self.peek().is_none() => Ok(FanucStatement::IfBlock(condition)),
            Some(_) => self.then(condition),
            None if self.names.formulas.bare_conditions && self.peek().is_some() => self.then(condition),
            None => Err(self.error("GOTO or THEN after the condition")),
        }
    }

    /// The statement of a condition.
    fn then(&mut self, condition: Expr) -> Result<FanucStatement, FanucSyntaxError> {
        self.depth += 1;
        if self.depth > NESTING {
            return Err(self.error("less nesting"));
        }
        let start = self.at;
        let inner = self.statement()?;
        if self.names.formulas.one_then && matches!(&inner, FanucStatement::Assign(list) if list.len() > 1) {
            self.at = start;
            return Err(self.error("one statement after THEN"));
        }
        if self.names.formulas.macro_then && matches!(&inner, FanucStatement::Words(words) if !calls_macro(words)) {
            self.at = start;
            return Err(self.error("a macro statement after THEN; jump over the block with IF GOTO instead"));
        }
        self.depth -= 1;
        Ok(FanucStatement::IfThen(condition, Box::new(inner)))
    }

    fn loop_number(&mut self) -> Result<u8, FanucSyntaxError> {
        let most = self.names.formulas.loops.unwrap_or(3);
        match self.unsigned().map(u8::try_from) {
            Some(Ok(number)) if (1..=most).contains(&number) => Ok(number),
            _ => Err(self.error(&format!("a loop number from 1 to {most}"))),
        }
    }

    fn jump_target(&mut self) -> Result<Expr, FanucSyntaxError> {
        match self.peek() {
            Some(b'0'..=b'9') => Ok(Expr::constant(f64::from(self.unsigned().unwrap_or(0)))),
            Some(b'[' | b'#') => {
                let mut ops = Vec::new();
                self.primary(&mut ops)?;
                Ok(Expr::new(ops))
            }
            _ => Err(self.error("a sequence number")),
        }
    }

    fn condition(&mut self) -> Result<Expr, FanucSyntaxError> {
        if self.peek() != Some(b'[') {
            return Err(self.error("'[' before the condition"));
        }
        // Its own brackets are not a level.
        self.at += 1;
        let mut ops = Vec::new();
        self.relation(&mut ops)?;
        if !self.accept(b']') {
            return Err(self.error("']'"));
        }
        self.checked(ops)
    }

    fn assignments(&mut self) -> Result<FanucStatement, FanucSyntaxError> {
        let mut list = Vec::new();
        while self.accept(b'#') {
            let mut target = Vec::new();
            self.variable_number(&mut target)?;
            if !self.accept(b'=') {
                return Err(self.error("'=' after the variable"));
            }
            let mut value = Vec::new();
            self.logical(&mut value)?;
            let target = self.checked(target)?;
            let number = target.as_constant().and_then(|number| variable_index(*number).ok());
            list.push((
                number.map_or(AssignmentTarget::Indirect(target), AssignmentTarget::Variable),
                self.checked(value)?,
            ));
        }
        Ok(FanucStatement::Assign(list))
    }
}

/// Whether the words are a macro call, which is a macro statement.
fn calls_macro(words: &[TemplateWord]) -> bool {
    words.iter().any(|word| {
        word.name == WordName::Letter(b'G') && word.value.as_constant().is_some_and(|&code| macro_call(code).is_some())
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use counterpoint_control_api::statement::OPEN_OUTPUT;

    fn plain(text: &[u8]) -> Result<FanucLine, FanucSyntaxError> {
        compile(text, StatementVocabulary { key_words: KEY_WORDS, ..StatementVocabulary::default() })
    }

    #[test]
    fn operands_of_statements_stand_in_brackets() {
        let operands = |text: &str, count| {
            let names = StatementVocabulary::default();
            let mut parser = FanucParser { text: text.as_bytes(), at: 0, depth: 0, names, written: None, name: None };
            parser.operands(count).map(|operands| operands.len())
        };
        assert_eq!((operands("", 0), operands("[#1+2]", 1), operands("[1, [2]]", 2)), (Ok(0), Ok(1), Ok(2)));
        assert!(operands("[1,2]", 1).is_err() && operands("[1]", 2).is_err() && operands("1", 1).is_err());
    }

    #[test]
    fn statements() {
        let kind = |text: &str| plain(text.as_bytes()).map(|l| l.statement);
        assert!(matches!(kind("IF[#4GT0]GOTO10"), Ok(FanucStatement::IfGoto(..))));
        assert!(matches!(kind("N10 IF [#1 EQ 2] THEN #3=4"), Ok(FanucStatement::IfThen(..))));
        assert!(matches!(kind("WHILE[#1LT200000]DO1"), Ok(FanucStatement::While(_, 1))));
        assert!(matches!(kind("WH[#1LT3]DO2"), Ok(FanucStatement::While(_, 2))));
        assert!(matches!(kind("END1"), Ok(FanucStatement::End(1))));
        assert!(matches!(kind("EN2"), Ok(FanucStatement::End(2))));
        assert!(matches!(kind("ENDIF"), Ok(FanucStatement::EndIf)));
        assert!(matches!(kind("GO20"), Ok(FanucStatement::Goto(_))));
        assert!(matches!(kind("DPRNT[X#1[42]]"), Ok(FanucStatement::Print(_))));
        assert!(matches!(kind("BP[C**#1[2]D]"), Ok(FanucStatement::PrintBinary(items)) if items.len() == 3));
        assert_eq!(kind("POPEN"), Ok(FanucStatement::Shared(&OPEN_OUTPUT, Box::default())));
        for wrong in
            ["DPRNT", "DPRNT[X#1]", "DPRNT[X#1[4]]", "DPRNT[X#1[42]", "BPRNT[#1[42]]", "DPRNT[]]", "DPRNT[A[B]"]
        {
            assert!(kind(wrong).is_err(), "{wrong}");
        }
        assert_eq!(plain(b"N20 G1 X#4 Y-#5 Z[#6+1]").unwrap().sequence, Some(20));
        assert!(plain(b"#1=[1+2").is_err());
        assert!(plain(b"IF[1EQ1]").is_err());
        assert!(plain("#1=".repeat(2).as_bytes()).is_err());
        assert!(plain(format!("#1={}1", "[".repeat(10_000)).as_bytes()).is_err());
        assert!(plain(format!("#1={}1", "#".repeat(10_000)).as_bytes()).is_err());
    }
}
