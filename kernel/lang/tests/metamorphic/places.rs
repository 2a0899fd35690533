//! Where operands are and where results go.

use super::values::Known;
use std::fmt::Write as _;

/// Where an operand comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    Literal,
    Parenthesised,
    Local,
    Declared,
    DeclaredUntyped,
    Constant,
    PredefinedLocal,
    PredefinedGlobal,
    Global,
    Object,
    Element,
    Element2,
    ObjectElement,
    Part,
    Function,
    TypedFunction,
    BuiltIn,
    Channel,
    Argument,
    System,
    Range,
    /// The target of the assignment, with the value it had.
    Target,
}

use Origin as F;

pub(crate) const ORIGINS: [Origin; 22] = [
    F::Literal,
    F::Parenthesised,
    F::Local,
    F::Declared,
    F::DeclaredUntyped,
    F::Constant,
    F::PredefinedLocal,
    F::PredefinedGlobal,
    F::Global,
    F::Object,
    F::Element,
    F::Element2,
    F::ObjectElement,
    F::Part,
    F::Function,
    F::TypedFunction,
    F::BuiltIn,
    F::Channel,
    F::Argument,
    F::System,
    F::Range,
    F::Target,
];

/// Where a result goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Goal {
    Local,
    Declared,
    DeclaredUntyped,
    PredefinedLocal,
    PredefinedGlobal,
    Global,
    GlobalUntyped,
    Object,
    ObjectUntyped,
    Element,
    ElementUntyped,
    Element2,
    ObjectElement2,
    Part,
    Channel,
    Argument,
    Result,
    TypedResult,
    System,
    UntypedSystem,
    Initial,
    GlobalInitial,
    Passed,
    PassedTyped,
    BuiltIn,
    Braces,
    Added,
    AddedGlobal,
    AddedElement,
    Scaled,
    ScaledGlobal,
    ScaledElement,
    Print,
    Exec,
    Written,
    Formatted,
    Message,
    Case,
    DoStart,
    Index,
    If,
    ElseIf,
    IfNot,
    While,
    Until,
}

use Goal as G;

pub(crate) const GOALS: [Goal; 45] = [
    G::Local,
    G::Declared,
    G::DeclaredUntyped,
    G::PredefinedLocal,
    G::PredefinedGlobal,
    G::Global,
    G::GlobalUntyped,
    G::Object,
    G::ObjectUntyped,
    G::Element,
    G::ElementUntyped,
    G::Element2,
    G::ObjectElement2,
    G::Part,
    G::Channel,
    G::Argument,
    G::Result,
    G::TypedResult,
    G::System,
    G::UntypedSystem,
    G::Initial,
    G::GlobalInitial,
    G::Passed,
    G::PassedTyped,
    G::BuiltIn,
    G::Braces,
    G::Added,
    G::AddedGlobal,
    G::AddedElement,
    G::Scaled,
    G::ScaledGlobal,
    G::ScaledElement,
    G::Print,
    G::Exec,
    G::Written,
    G::Formatted,
    G::Message,
    G::Case,
    G::DoStart,
    G::Index,
    G::If,
    G::ElseIf,
    G::IfNot,
    G::While,
    G::Until,
];

impl Goal {
    /// Tells whether a value of this type can go here.
    pub(crate) fn takes(self, value: &Known) -> bool {
        match self {
            G::If | G::ElseIf | G::IfNot | G::While | G::Until => matches!(value, Known::Logical(_)),
            G::DoStart | G::Scaled | G::ScaledGlobal | G::ScaledElement => matches!(value, Known::Real(_)),
            G::Index => matches!(value, Known::Real(number) if (1.0..6.0).contains(number)),
            G::Added | G::AddedGlobal | G::AddedElement => matches!(value, Known::Real(_) | Known::Text(_)),
            _ => true,
        }
    }

    /// The variable that is assigned, if it is one that can be read.
    fn variable(self) -> Option<&'static str> {
        Some(match self {
            G::Local | G::Declared | G::DeclaredUntyped => "ZT",
            G::PredefinedLocal => "%L98",
            G::PredefinedGlobal => "%G98",
            G::Global | G::GlobalUntyped => "ZG",
            G::Object | G::ObjectUntyped => "ZO",
            G::Element | G::ElementUntyped => "ZA(2)",
            G::Element2 => "ZA(2,3)",
            G::ObjectElement2 => "ZOA(2,3)",
            G::Part => "ZQ(2)",
            G::Channel => "ZC",
            G::Argument => "$P9",
            G::Result | G::TypedResult => "RESULT",
            G::System => "$ZT",
            G::UntypedSystem => "$ZU",
            _ => return None,
        })
    }

    fn in_function(self) -> bool {
        matches!(self, G::Result | G::TypedResult)
    }
}

/// A macro that computes one expression, piece by piece.
pub(crate) struct Writer {
    goal: Goal,
    result: Known,
    declared: String,
    set: String,
    number: usize,
    arguments: Vec<Known>,
    /// System variables with their values.
    pub(crate) system: Vec<(String, Known)>,
}

impl Writer {
    pub(crate) fn new(goal: Goal, result: Known) -> Writer {
        let system = vec![("$ZT".to_owned(), result.other())];
        Writer { goal, result, declared: String::new(), set: String::new(), number: 0, arguments: Vec::new(), system }
    }

    fn line(&mut self, text: &str) {
        let _ = writeln!(self.set, "{text}");
    }

    fn declare(&mut self, text: &str) {
        let _ = writeln!(self.declared, "DECLAR/{text}");
    }

    /// Makes an operand of this value and gives its text; another origin is taken where this one cannot hold it.
    pub(crate) fn operand(&mut self, value: &Known, origin: Origin) -> String {
        self.number += 1;
        let (n, text, kind) = (self.number, value.written(), value.type_name());
        let single = !value.is_list();
        match origin {
            F::Parenthesised => format!("({text})"),
            F::Local => self.assigned(format!("V{n}"), &text),
            F::Declared => {
                self.declare(&format!("{kind},V{n}"));
                self.assigned(format!("V{n}"), &text)
            }
            F::DeclaredUntyped => {
                self.declare(&format!("V{n}"));
                self.assigned(format!("V{n}"), &text)
            }
            F::Constant => {
                self.declare(&format!("{kind},V{n}={text}"));
                format!("V{n}")
            }
            F::PredefinedLocal if n < 90 => self.assigned(format!("%L{n}"), &text),
            F::PredefinedGlobal if n < 90 => self.assigned(format!("%G{n}"), &text),
            F::Global => {
                self.declare(&format!("GLOBAL,{kind},VG{n}"));
                self.assigned(format!("VG{n}"), &text)
            }
            F::Object => {
                self.declare(&format!("OBJECT,VO{n}"));
                self.assigned(format!("VO{n}"), &text)
            }
            F::Element if single => {
                self.declare(&format!("{kind},VA{n}(3)"));
                self.assigned(format!("VA{n}(2)"), &text)
            }
            F::Element2 if single => {
                self.declare(&format!("VB{n}(2,3)"));
                self.assigned(format!("VB{n}(2,1)"), &text)
            }
            F::ObjectElement if single => {
                self.declare(&format!("OBJECT,{kind},VC{n}(3,2)"));
                self.assigned(format!("VC{n}(3,2)"), &text)
            }
            F::Part if single => {
                self.line(&format!("VQ{n}={{0,{text},'x'}}"));
                format!("VQ{n}(2)")
            }
            F::Function => format!("TWIN({text})"),
            F::TypedFunction => format!("TWIN{kind}({text})"),
            F::BuiltIn => format!("$FIF(.TRUE.,{text},0)"),
            F::Channel if single => {
                self.declare(&format!("{kind},CHANNEL,VH{n}"));
                self.assigned(format!("VH{n}"), &text)
            }
            F::Argument if !self.goal.in_function() && self.arguments.len() < 8 => {
                self.arguments.push(value.clone());
                format!("$P{}", self.arguments.len())
            }
            F::System => {
                self.system.push((format!("$V{n}"), value.clone()));
                format!("$V{n}")
            }
            F::Range if matches!(value, Known::Text(_) | Known::List(_)) => {
                self.line(&format!("VR{n}={text}"));
                format!("VR{n}(1:)")
            }
            F::Target if self.result.other() == *value => match self.goal.variable() {
                Some(variable) => variable.to_owned(),
                None => text,
            },
            _ => text,
        }
    }

    fn assigned(&mut self, name: String, text: &str) -> String {
        self.line(&format!("{name}={text}"));
        name
    }

    /// The whole macro; it prints the value of `expression` at the end.
    pub(crate) fn finish(mut self, expression: &str) -> (String, Vec<(String, Known)>, Vec<Known>) {
        let kind = self.result.type_name();
        let old = self.result.other().written();
        let mut arguments = std::mem::take(&mut self.arguments);
        if self.goal == G::Argument {
            arguments.resize(9, self.result.other());
        }
        let declared = match self.goal {
            G::Declared => format!("{kind},ZT"),
            G::DeclaredUntyped => "ZT".into(),
            G::Global => format!("GLOBAL,{kind},ZG"),
            G::GlobalUntyped => "GLOBAL,ZG".into(),
            G::Object => format!("OBJECT,{kind},ZO"),
            G::ObjectUntyped => "OBJECT,ZO".into(),
            G::Element => format!("{kind},ZA(3)"),
            G::ElementUntyped => "ZA(3)".into(),
            G::Element2 => format!("{kind},ZA(2,3)"),
            G::ObjectElement2 => format!("OBJECT,{kind},ZOA(2,3)"),
            G::Channel => format!("{kind},CHANNEL,ZC"),
            _ => String::new(),
        };
        if !declared.is_empty() {
            self.declare(&declared);
        }
        match self.goal {
            G::Part => self.line(&format!("ZQ={{1,{old},3}}")),
            G::Argument | G::System => {}
            goal => {
                if let Some(variable) = goal.variable() {
                    self.line(&format!("{variable}={old}"));
                }
            }
        }
        let lines = self.lines(expression);
        let types = ["REAL", "STRING", "LOGICAL", "KEYWORD", "SEQUENCE"];
        let mut text = String::from("MACRO/TWIN(X)\nTWIN=X\nENDMAC\n");
        for kind in types {
            let _ = writeln!(text, "MACRO/{kind},TWIN{kind}({kind},X)\nTWIN{kind}=X\nENDMAC");
        }
        if self.goal.in_function() {
            let typed = if self.goal == G::TypedResult { format!("{kind},") } else { String::new() };
            let _ = writeln!(text, "MACRO/{typed}RESULT()\n{}{}{lines}\nENDMAC", self.declared, self.set);
            let _ = write!(text, "ZR=RESULT()\n{}", shown("ZR"));
        } else {
            let _ = write!(text, "{}{}{lines}", self.declared, self.set);
        }
        (text, self.system, arguments)
    }

    /// The statements that compute the expression and print the outcome.
    fn lines(&self, expression: &str) -> String {
        let kind = self.result.type_name();
        let e = expression;
        if let Some(variable) = self.goal.variable() {
            let assignment = format!("{variable}={e}");
            return if self.goal.in_function() { assignment } else { format!("{assignment}\n{}", shown(variable)) };
        }
        let kinds = types_of(&self.result);
        let truth = |before: &str, after: &str| format!("ZR=.FALSE.\n{before}\nZR=.TRUE.\n{after}\n{}", shown("ZR"));
        match self.goal {
            G::Initial => format!("DECLAR/{kind},ZI={e}\n{}", shown("ZI")),
            G::GlobalInitial => format!("DECLAR/GLOBAL,{kind},ZI={e}\n{}", shown("ZI")),
            G::Passed => format!("ZR=TWIN({e})\n{}", shown("ZR")),
            G::PassedTyped => format!("ZR=TWIN{kind}({e})\n{}", shown("ZR")),
            G::BuiltIn => format!("ZR=$FIF(.TRUE.,{e},'other')\n{}", shown("ZR")),
            G::Braces if self.result.is_list() => format!("ZR={{{e}}}\n{}", shown("ZR")),
            G::Braces => format!("ZQ={{0,{e}}}\nZR=ZQ(2)\n{}", shown("ZR")),
            G::Added | G::AddedGlobal | G::AddedElement | G::Scaled | G::ScaledGlobal | G::ScaledElement => {
                let variable = match self.goal {
                    G::AddedGlobal | G::ScaledGlobal => "%G97",
                    G::AddedElement | G::ScaledElement => "ZQ(2)",
                    _ => "ZR",
                };
                let first = match (self.goal, &self.result) {
                    (G::Scaled | G::ScaledGlobal | G::ScaledElement, _) => "2",
                    (_, Known::Real(_)) => "0",
                    _ => "$FSUBST('x',2,1)",
                };
                let sign = if first == "2" { "*" } else { "+" };
                let last = if first == "2" { format!("{variable}/=2\n") } else { String::new() };
                format!("ZQ={{1,2,3}}\n{variable}={first}\n{variable}{sign}={e}\n{last}{}", shown(variable))
            }
            G::Print => format!("PPRINT/'!(*) {kinds}',{e}"),
            G::Exec => format!("EXEC/NOW,'!(*) {kinds}',{e}"),
            G::Written => format!("OPEN/20,'out'\nWRITE/20,'!(*) {kinds}',{e}\nCLOSE/20"),
            G::Formatted => format!("ZR=$FSWRIT('!(*) {kinds}',{e})\nPPRINT/ZR"),
            G::Message => format!("ERROR/0,'!(*) {kinds}',{e}"),
            G::Case => {
                format!(
                    "ZR='wrong'\nCASE/{e}\nWHEN/{}\nZR={}\nENDOF/CASE\n{}",
                    self.result.written(),
                    self.result.written(),
                    shown("ZR")
                )
            }
            G::DoStart => format!("DO/ZR={e},10**9\nEXIT\nENDOF/DO\n{}", shown("ZR")),
            G::Index => {
                format!("ZQ={{1,2,3,4,5}}\nZR=ZQ({e})+$FFRAC({})\n{}", self.result.written(), shown("ZR"))
            }
            G::If => truth(&format!("IF/{e}"), "ENDOF/IF"),
            G::ElseIf => truth(&format!("IF/.FALSE.\nZR=0\nELSEIF/{e}"), "ENDOF/IF"),
            G::IfNot => truth(&format!("IF/.NOT.({e})\nELSE"), "ENDOF/IF"),
            G::While => truth(&format!("WHILE/{e}"), "EXIT\nENDOF/WHILE"),
            G::Until => {
                truth(&format!("ZN=0\nREPEAT\nZN+=1\nIF/ZN.GT.1\nEXIT\nENDOF/IF\nUNTIL/{e}\nIF/ZN.EQ.1"), "ENDOF/IF")
            }
            _ => String::new(),
        }
    }
}

/// Prints a variable with its type.
fn shown(variable: &str) -> String {
    format!("PPRINT/'!(*) !(*) !(*) !(*)',{variable},$FISNUM({variable}),$FISSTR({variable}),$FISSEQ({variable})")
}

/// Text that [`shown`] prints for the type of a value.
pub(crate) fn types_of(value: &Known) -> String {
    let is = |name: &str| if value.type_name() == name { "TRUE" } else { "FALSE" };
    format!("{} {} {}", is("REAL"), is("STRING"), is("SEQUENCE"))
}
