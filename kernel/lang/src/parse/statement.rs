//! Statements: assignments and commands.
//!
//! Facts: reference macro-language.md 1.5, 3 and 6. The undocumented reserved words ENDIF, ENDDO, ENDWHILE, ENDCASE and
//! LEAVE are taken as `ENDOF/…` and `EXIT`.

use super::{LineParser, Parsed};
use crate::ast::{
    CompoundStatement, DeclaredName, Expr, ExprKind, FunctionHeader, MacroVariableScope, StatementKind, VariableName,
    WhenItem,
};
use crate::diag::{DiagnosticNumber, MacroDiagnostic};
use crate::ident;
use crate::lex::{Sign, TokenKind};
use crate::value::ValueType;

/// Words a statement of the control emulator may start with.
pub const COMMANDS: &[&str] = &[
    "CASE", "CLOSE", "DECLAR", "DO", "ELSE", "ELSEIF", "ENDMAC", "ENDOF", "ERROR", "EXEC", "EXIT", "IF", "INCLUD",
    "JUMPTO", "LPRINT", "MACRO", "MATCH", "OPEN", "OUTPUT", "PPRINT", "READ", "REPEAT", "RSTMODAL", "SAVMODAL",
    "SEARCH", "SYSTEM", "TAPERD", "TAPEWT", "TERMAC", "UNTIL", "WHEN", "WHILE", "WRITE",
];

impl LineParser<'_> {
    /// Reads the statement of the line.
    pub(crate) fn statement(&mut self) -> Parsed<StatementKind> {
        let kind = match (self.peek(), self.peek_at(1)) {
            (None, _) => StatementKind::Empty,
            (Some(TokenKind::Name(name)), None | Some(TokenKind::Sign(Sign::Slash))) => {
                let span = self.span();
                self.at += 1;
                let arguments = self.eat(Sign::Slash);
                match self.named(name, arguments)? {
                    Some(kind) => kind,
                    None if is_record(name) => self.record(name, span, arguments)?,
                    None => return self.unknown(name, span),
                }
            }
            (Some(TokenKind::Record(..)), None | Some(TokenKind::Sign(Sign::Slash))) => {
                let span = self.span();
                self.at += 1;
                let arguments = self.eat(Sign::Slash);
                self.record("this", span, arguments)?
            }
            _ => self.assignment()?,
        };
        self.done()?;
        Ok(kind)
    }

    /// Reads a record of the post-processor product, which does nothing here.
    fn record(&mut self, name: &str, span: crate::source::Span, arguments: bool) -> Parsed<StatementKind> {
        if arguments && self.peek().is_some() {
            self.list()?;
        }
        let message =
            format!("{name} is a record of the post-processor product and does nothing in the control emulator");
        let help = (name == "GOTO").then(|| "JUMPTO/label jumps".to_owned());
        self.diagnostics
            .push(MacroDiagnostic::new(self.source, span, DiagnosticNumber::RECORD_IGNORED, message).help(help));
        Ok(StatementKind::Empty)
    }

    fn unknown<T>(&mut self, name: &str, span: crate::source::Span) -> Parsed<T> {
        if COMMANDS.contains(&name) {
            return self.fail_at(span, DiagnosticNumber::SYNTAX, format!("wrong syntax for {name}"), None);
        }
        if ident::reserved(name) == Some(ident::Reserved::Control) {
            return self.fail_at(
                span,
                DiagnosticNumber::RESERVED_WORD,
                format!("{name} is reserved, but is not a statement"),
                None,
            );
        }
        let help = match name {
            "RETURN" => Some("TERMAC ends a macro or function".to_owned()),
            "CALL" | "USRFUN" => Some("functions are called inside expressions".to_owned()),
            "LOOP" => Some("the loops are DO, WHILE and REPEAT".to_owned()),
            "DIALOG" => Some("a dialog is the function $FDIALOG()".to_owned()),
            _ => ident::nearest(name, COMMANDS.iter().copied()).map(|near| format!("did you mean {near}?")),
        };
        self.fail_at(span, DiagnosticNumber::UNKNOWN_COMMAND, format!("unknown command {name}"), help)
    }

    fn named(&mut self, name: &str, arguments: bool) -> Parsed<Option<StatementKind>> {
        Ok(Some(match (name, arguments) {
            ("IF", true) => StatementKind::If(self.expression()?),
            ("ELSEIF", true) => StatementKind::ElseIf(self.expression()?),
            ("ELSE", false) => StatementKind::Else,
            ("CASE", true) => StatementKind::Case(self.expression()?),
            ("WHEN", true) => self.when()?,
            ("WHILE", true) => StatementKind::While(self.expression()?),
            ("REPEAT", false) => StatementKind::Repeat,
            ("UNTIL", true) => StatementKind::Until(self.expression()?),
            ("DO", true) => self.do_loop()?,
            ("ENDOF", true) => self.end_of()?,
            ("ENDIF", false) => StatementKind::EndOf(CompoundStatement::If),
            ("ENDCASE" | "ENDC", false) => StatementKind::EndOf(CompoundStatement::Case),
            ("ENDWHILE" | "ENDW", false) => StatementKind::EndOf(CompoundStatement::While),
            ("ENDDO", false) => StatementKind::EndOf(CompoundStatement::Do),
            ("EXIT" | "LEAVE", false) => StatementKind::Exit(1),
            ("EXIT" | "LEAVE", true) => self.exit()?,
            ("JUMPTO", true) => self.jump()?,
            ("TERMAC", false) => StatementKind::Terminate,
            ("ENDMAC", false) => StatementKind::EndMacro,
            ("DECLAR", true) => self.declare()?,
            ("OUTPUT", false) => StatementKind::Output,
            ("TAPERD", false) => StatementKind::TapeRead,
            ("TAPEWT", false) => StatementKind::TapeWrite,
            ("SAVMODAL", false) => StatementKind::SaveModal,
            ("RSTMODAL", false) => StatementKind::RestoreModal,
            ("MATCH", true) => StatementKind::Match(self.on_or_off()?),
            ("SEARCH", true) => StatementKind::Search(self.expression()?),
            ("EXEC", true) => self.exec()?,
            ("LPRINT", true) => match self.switch() {
                Some(on) => StatementKind::Listing(on),
                None => StatementKind::Skip(self.expression()?),
            },
            ("PPRINT", true) => StatementKind::Print(self.list()?),
            ("OPEN", true) => StatementKind::Open(self.counted(1, 3)?),
            ("CLOSE", true) => StatementKind::Close(self.expression()?),
            ("WRITE", true) => StatementKind::Write(self.counted(2, usize::MAX)?),
            ("READ", true) => self.read()?,
            ("ERROR", true) => StatementKind::Error(self.list()?),
            ("SYSTEM", true) => StatementKind::System(self.expression()?),
            ("INCLUD", true) => self.include()?,
            _ => return Ok(None),
        }))
    }

    fn counted(&mut self, least: usize, most: usize) -> Parsed<Vec<Expr>> {
        let list = self.list()?;
        if list.len() < least || list.len() > most {
            let message =
                if list.len() < least { "an argument is missing here" } else { "there are too many arguments" };
            return self.fail(DiagnosticNumber::WRONG_COUNT, message);
        }
        Ok(list)
    }

    fn switch(&mut self) -> Option<bool> {
        if self.tokens.len() != self.at + 1 {
            return None;
        }
        if self.eat_word("ON") { Some(true) } else { self.eat_word("OFF").then_some(false) }
    }

    fn on_or_off(&mut self) -> Parsed<bool> {
        match self.switch() {
            Some(on) => Ok(on),
            None => self.fail(DiagnosticNumber::SYNTAX, "ON or OFF is expected here"),
        }
    }

    fn end_of(&mut self) -> Parsed<StatementKind> {
        let Some(TokenKind::Name(name)) = self.peek() else {
            return self.fail(DiagnosticNumber::SYNTAX, "IF, CASE, WHILE or DO is expected here");
        };
        let block = match name.as_str() {
            "IF" => CompoundStatement::If,
            "CASE" => CompoundStatement::Case,
            "WHILE" => CompoundStatement::While,
            "DO" => CompoundStatement::Do,
            "REPEAT" => return self.fail(DiagnosticNumber::SYNTAX, "REPEAT ends with UNTIL/condition"),
            _ => return self.fail(DiagnosticNumber::SYNTAX, "IF, CASE, WHILE or DO is expected here"),
        };
        self.at += 1;
        Ok(StatementKind::EndOf(block))
    }

    fn when(&mut self) -> Parsed<StatementKind> {
        if self.eat_word("OTHERS") {
            return Ok(StatementKind::When(Vec::new()));
        }
        let mut items = Vec::new();
        loop {
            let first = self.expression()?;
            let thru = matches!(
                (self.peek(), self.peek_at(1), self.peek_at(2)),
                (Some(TokenKind::Sign(Sign::Comma)), Some(TokenKind::Name(word)), Some(TokenKind::Sign(Sign::Comma))) if word == "THRU"
            );
            if thru {
                self.at += 3;
                items.push(WhenItem::Thru(first, self.expression()?));
            } else {
                items.push(WhenItem::One(first));
            }
            if !self.eat(Sign::Comma) {
                return Ok(StatementKind::When(items));
            }
        }
    }

    fn do_loop(&mut self) -> Parsed<StatementKind> {
        let variable = self.target()?;
        self.expect(Sign::Assign)?;
        let start = self.expression()?;
        self.expect(Sign::Comma)?;
        let end = self.expression()?;
        let step = if self.eat(Sign::Comma) { Some(self.expression()?) } else { None };
        Ok(StatementKind::Do { variable, start, end, step })
    }

    fn exit(&mut self) -> Parsed<StatementKind> {
        if let Some(TokenKind::Number(number)) = self.peek()
            && (1.0..=100.0).contains(number)
            && number.fract() == 0.0
        {
            self.at += 1;
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            return Ok(StatementKind::Exit(*number as u32));
        }
        self.fail(DiagnosticNumber::BAD_EXIT, "EXIT takes a whole number of loops")
    }

    fn jump(&mut self) -> Parsed<StatementKind> {
        let start = self.span();
        let mut label = String::new();
        while let Some(token) = self.peek() {
            match token {
                TokenKind::Name(name) | TokenKind::Percent(name) => label.push_str(name),
                TokenKind::Number(number) if number.fract() == 0.0 => {
                    let span = self.span();
                    label.push_str(self.source.slice(span));
                }
                _ => return self.fail(DiagnosticNumber::BAD_LABEL, "a label is expected here"),
            }
            self.at += 1;
        }
        if label.is_empty() {
            return self.fail(DiagnosticNumber::BAD_LABEL, "a label is expected here");
        }
        Ok(StatementKind::Jump(label, start.to(self.before())))
    }

    fn exec(&mut self) -> Parsed<StatementKind> {
        let now = match (self.peek(), self.peek_at(1)) {
            (Some(TokenKind::Name(name)), Some(TokenKind::Sign(Sign::Comma))) if name == "NOW" || name == "NEXT" => {
                self.at += 2;
                name == "NOW"
            }
            _ => false,
        };
        Ok(StatementKind::Exec(now, self.list()?))
    }

    fn read(&mut self) -> Parsed<StatementKind> {
        let source = self.expression()?;
        self.expect(Sign::Comma)?;
        let mut again = false;
        for (word, decr) in [("INCR", false), ("DECR", true)] {
            if self.eat_word(word) {
                again = decr;
                self.expect(Sign::Comma)?;
                break;
            }
        }
        let format = self.expression()?;
        let mut targets = Vec::new();
        while self.eat(Sign::Comma) {
            targets.push(self.target()?);
        }
        Ok(StatementKind::Read { source, again, format, targets })
    }

    fn include(&mut self) -> Parsed<StatementKind> {
        let Some(TokenKind::Text(name)) = self.peek() else {
            return self.fail(DiagnosticNumber::SYNTAX, "INCLUD takes the name of a file between quotes");
        };
        self.at += 1;
        Ok(StatementKind::Include(name.clone()))
    }

    fn kind(&mut self) -> Option<ValueType> {
        let Some(TokenKind::Name(name)) = self.peek() else { return None };
        let kind = ValueType::named(name)?;
        self.at += 1;
        Some(kind)
    }

    fn declare(&mut self) -> Parsed<StatementKind> {
        let (mut scope, mut kind, mut channel) = (MacroVariableScope::Local, None, false);
        loop {
            let words = [
                ("LOCAL", MacroVariableScope::Local),
                ("OBJECT", MacroVariableScope::Object),
                ("GLOBAL", MacroVariableScope::Global),
            ];
            if let Some((_, found)) = words.into_iter().find(|(word, _)| self.eat_word(word)) {
                scope = found;
            } else if let Some(found) = self.kind() {
                kind = Some(found);
            } else if self.eat_word("CHANNEL") {
                channel = true;
            } else if self.eat_word("EXTERN") {
                let span = self.before();
                let message = "external functions are not supported: macros run in a sandbox";
                return self.fail_at(
                    span,
                    DiagnosticNumber::NOT_HERE,
                    message,
                    Some("write the function as a MACRO".into()),
                );
            } else {
                break;
            }
            self.expect(Sign::Comma)?;
        }
        let mut names = vec![self.declared()?];
        while self.eat(Sign::Comma) {
            names.push(self.declared()?);
        }
        Ok(StatementKind::Declare { scope, kind, channel, names })
    }

    fn declared(&mut self) -> Parsed<DeclaredName> {
        let span = self.span();
        let name = self.new_name()?;
        let mut sizes = Vec::new();
        if self.eat(Sign::Open) {
            sizes = self.list()?;
            self.expect(Sign::Close)?;
        }
        let value = if self.eat(Sign::Assign) { Some(self.expression()?) } else { None };
        Ok(DeclaredName { name, sizes, value, span })
    }

    /// Reads a name that is being declared.
    fn new_name(&mut self) -> Parsed<String> {
        let span = self.span();
        match self.peek() {
            Some(TokenKind::Percent(name)) => {
                self.at += 1;
                Ok(name.clone())
            }
            Some(TokenKind::Name(name)) if !ident::needs_percent(name) => {
                self.at += 1;
                Ok(name.clone())
            }
            Some(TokenKind::Name(name)) => {
                let help = Some(format!("write %{name} for a variable of this name"));
                self.fail_at(span, DiagnosticNumber::REDECLARED, format!("{name} is a word of the language"), help)
            }
            Some(TokenKind::Global(_) | TokenKind::Local(_) | TokenKind::Param(_) | TokenKind::System(_)) => {
                self.fail(DiagnosticNumber::REDECLARED, "%Gnn, %Lnn and $ names exist without a declaration")
            }
            _ => self.fail(DiagnosticNumber::SYNTAX, "a name is expected here"),
        }
    }

    /// Reads the header of a function after `MACRO/`.
    pub(crate) fn header(&mut self) -> Parsed<FunctionHeader> {
        let result = self.kind();
        if result.is_some() {
            self.expect(Sign::Comma)?;
        }
        let span = self.span();
        let name = self.new_name()?;
        let mut parameters: Vec<(String, Option<ValueType>)> = Vec::new();
        self.expect(Sign::Open)?;
        if !self.eat(Sign::Close) {
            loop {
                let kind = self.kind();
                if kind.is_some() {
                    self.expect(Sign::Comma)?;
                }
                let place = self.span();
                let parameter = self.new_name()?;
                if parameter == name || parameters.iter().any(|(other, _)| *other == parameter) {
                    let message = format!("{parameter} occurs twice in this header");
                    return self.fail_at(place, DiagnosticNumber::DUPLICATE_FUNCTION, message, None);
                }
                parameters.push((parameter, kind));
                if !self.eat(Sign::Comma) {
                    break;
                }
            }
            self.expect(Sign::Close)?;
        }
        self.done()?;
        Ok(FunctionHeader { name, result, parameters, span })
    }

    /// Reads the target of an assignment: a variable or an element.
    fn target(&mut self) -> Parsed<Expr> {
        let start = self.span();
        let Some(token) = self.peek() else {
            return self.fail(DiagnosticNumber::SYNTAX, "a variable is missing here");
        };
        let variable = match token {
            TokenKind::Name(name) if self.assignable(name) => VariableName::User(name.clone()),
            TokenKind::Name(name) => {
                let help = Some(format!("write %{name} for a variable of this name"));
                let message = format!("{name} is a word of the language and cannot be assigned to");
                return self.fail_at(start, DiagnosticNumber::BAD_TARGET, message, help);
            }
            TokenKind::Percent(name) => VariableName::User(name.clone()),
            TokenKind::Global(number) => VariableName::Global(*number),
            TokenKind::Local(number) => VariableName::Local(*number),
            TokenKind::Param(number) => VariableName::Param(*number),
            TokenKind::System(name) if matches!(name.as_str(), "$TRUE" | "$FALSE" | "$NULL" | "$PI") => {
                return self.fail(DiagnosticNumber::BAD_TARGET, format!("{name} is a constant"));
            }
            TokenKind::System(name) => VariableName::System(name.clone()),
            _ => return self.fail(DiagnosticNumber::BAD_TARGET, "a variable is expected here"),
        };
        self.at += 1;
        let kind = self.variable(variable)?;
        let span = start.to(self.before());
        if matches!(kind, ExprKind::Range(..)) {
            return self.fail_at(span, DiagnosticNumber::BAD_TARGET, "a range cannot be assigned to", None);
        }
        Ok(Expr::new(kind, span))
    }

    fn assignable(&self, name: &str) -> bool {
        !ident::needs_percent(name) && !["CODE_", "REG_", "DATA_"].iter().any(|prefix| name.starts_with(prefix))
    }

    fn assignment(&mut self) -> Parsed<StatementKind> {
        let start = self.span();
        if self.is_bare_call() {
            let help = Some("assign its result, for instance %L01=…".to_owned());
            return self.fail_at(
                start,
                DiagnosticNumber::BARE_CALL,
                "a function call is a value, not a statement",
                help,
            );
        }
        let target = self.target()?;
        let sign = match self.sign() {
            Some(sign) if is_assignment(sign) => sign,
            _ => return self.fail(DiagnosticNumber::SYNTAX, "`=` is expected here"),
        };
        self.at += 1;
        let value = self.expression()?;
        Ok(StatementKind::Assign { target, sign, value })
    }

    fn is_bare_call(&self) -> bool {
        let called = matches!(self.peek(), Some(TokenKind::System(_) | TokenKind::Name(_)))
            && matches!(self.peek_at(1), Some(TokenKind::Sign(Sign::Open)));
        let assigns = |token: &crate::lex::Spanned| matches!(token.token, TokenKind::Sign(sign) if is_assignment(sign));
        called && !self.tokens.iter().any(assigns)
    }
}

fn is_assignment(sign: Sign) -> bool {
    matches!(sign, Sign::Assign | Sign::AddAssign | Sign::SubtractAssign | Sign::MultiplyAssign | Sign::DivideAssign)
}

fn is_record(name: &str) -> bool {
    !COMMANDS.contains(&name)
        && (ident::reserved(name) == Some(ident::Reserved::Post) || ident::major_code(name).is_some())
}
