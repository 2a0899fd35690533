//! Macro loops, to be compared with the same loops in Lua (`tests/peers/lua.py`).

#![allow(missing_docs, clippy::unwrap_used)]

use counterpoint_lang::compile::{self, CompileOptions, MacroProgram};
use counterpoint_lang::source::MacroSource;
use counterpoint_lang::value::MacroValue;
use counterpoint_lang::vm::{self, MacroLimits, MacroState};
use counterpoint_lang_standalone::Standalone;
use criterion::{Criterion, criterion_group, criterion_main};

const LOOPS: [(&str, &str); 22] = [
    ("arithmetic", "S=0\nDO/I=1,100000\nS=S+I*2-S/3\nENDOF/DO"),
    ("branches", "N=0\nI=0\nWHILE/I.LT.100000\nI+=1\nIF/$FMOD(I,3).EQ.0.AND.I.GT.5\nN+=1\nENDOF/IF\nENDOF/WHILE"),
    ("array", "DECLAR/REAL,A(1000)\nDO/J=1,100\nDO/I=1,1000\nA(I)=A(I)+I\nENDOF/DO\nENDOF/DO"),
    ("sequence", "DO/J=1,100\nQ={}\nDO/I=1,1000\nQ+=I\nENDOF/DO\nENDOF/DO"),
    ("edit", "DO/I=1,10000\nT=$FEDIT('N120 X1.5 Y22.75 Z-3','[XYZ]\\([-0-9.]*\\)','<\\1>')\nENDOF/DO"),
    ("function", "MACRO/ADDED(A,B)\nADDED=A+B\nENDMAC\nS=0\nDO/I=1,100000\nS=ADDED(S,I)\nENDOF/DO"),
    // A function that has to be called, as it may print.
    (
        "call",
        "MACRO/ADDED(A,B)\nIF/A.LT.0\nPPRINT/'NEGATIVE'\nENDOF/IF\nADDED=A+B\nENDMAC\nS=0\nDO/I=1,100000\nS=ADDED(S,I)\nENDOF/DO",
    ),
    // Elements with two indices: read, written, updated.
    (
        "matrix",
        "DECLAR/REAL,A(100,100)\nDECLAR/REAL,B(100,100)\nDO/K=1,10\nDO/I=1,100\nDO/J=1,100\nA(I,J)=A(I,J)+I\nB(J,I)=A(I,J)\n\
         ENDOF/DO\nENDOF/DO\nENDOF/DO",
    ),
    ("locals", "%L01=0\n%L02=1\nDO/%L03=1,100000\n%L01=%L01+%L02*%L03\nENDOF/DO"),
    ("globals", "%G01=0\n%G02=1\nDO/I=1,100000\n%G01=%G01+%G02*I\nENDOF/DO"),
    (
        "object",
        "DECLAR/OBJECT,REAL,TOTAL\nDECLAR/OBJECT,REAL,FACTOR=2\nTOTAL=0\nDO/I=1,100000\nTOTAL=TOTAL+FACTOR*I\nENDOF/DO",
    ),
    ("object_text", "DECLAR/OBJECT,WORK\nWORK='MILL'\nN=0\nDO/I=1,100000\nIF/WORK.EQ.'MILL'\nN+=1\nENDOF/IF\nENDOF/DO"),
    ("object_array", "DECLAR/OBJECT,REAL,WEAR(1000)\nDO/J=1,100\nDO/I=1,1000\nWEAR(I)=WEAR(I)+I\nENDOF/DO\nENDOF/DO"),
    (
        "object_matrix",
        "DECLAR/OBJECT,REAL,LIFE(100,100)\nDO/K=1,10\nDO/I=1,100\nDO/J=1,100\nLIFE(I,J)=LIFE(I,J)+I\nENDOF/DO\nENDOF/DO\nENDOF/DO",
    ),
    // Records are sequences of values of any type: made, a field written, fields read.
    ("record_made", "S=0\nDO/I=1,100000\nR={I,'MILL',ON}\nS=S+R(1)\nENDOF/DO"),
    (
        "record_fields",
        "R={1,'MILL',3,4}\nN=0\nDO/I=1,100000\nR(3)=R(1)+I\nR(4)=R(3)-R(1)\nIF/R(2).EQ.'MILL'\nN+=1\nENDOF/IF\nENDOF/DO",
    ),
    // A table of names and numbers is searched.
    (
        "table",
        "DECLAR/T(50,3)\nDO/I=1,50\nT(I,1)=$FSWRIT('TOOL!(2)',I)\nT(I,2)=I\nT(I,3)=0\nENDOF/DO\nDO/J=1,1000\n\
         DO/I=1,50\nIF/T(I,1).EQ.'TOOL50'\nT(I,3)=T(I,3)+T(I,2)\nNAME=T(I,1)\nENDOF/IF\nENDOF/DO\nENDOF/DO",
    ),
    ("text", "DO/J=1,1000\nT=''\nDO/I=1,50\nT=T//'G1 X'//' '\nENDOF/DO\nENDOF/DO"),
    ("format", "DO/I=1,10000\nT=$FSWRIT('N!(5) X!(F5.3) !(A)',I,I,'F100')\nENDOF/DO"),
    (
        "untyped",
        "MACRO/PICK(NAME,A,B)\nIF/NAME.EQ.'MILL'\nPICK=A\nELSE\nPICK=B\nENDOF/IF\nENDMAC\nS=0\nDO/I=1,100000\nS=PICK('MILL',I,'NONE')\nENDOF/DO",
    ),
    ("arguments", "S=0\nDO/I=1,100000\n$P1=$P1+$P2*I\nIF/$P3.EQ.$TRUE\nS=S+1\nENDOF/IF\nENDOF/DO"),
    (
        "cases",
        "N=0\nDO/I=1,100000\nK=$FMOD(I,7)\nCASE/K\nWHEN/0\nN+=1\nWHEN/1,2\nN+=2\nWHEN/3,THRU,5\nN+=3\nWHEN/OTHERS\nN+=4\nENDOF/CASE\nENDOF/DO",
    ),
];

fn loops(criterion: &mut Criterion) {
    for (name, text) in LOOPS {
        let (mut program, mut host) = (MacroProgram::new(), Standalone::new());
        let added = compile::add(&mut program, &mut host, MacroSource::new(name, text), CompileOptions::default());
        assert!(!added.has_errors(), "{:?}", added.diagnostics);
        let mut state = MacroState::new(MacroLimits { ticks: u64::MAX, ..MacroLimits::default() });
        let index = *added.macros.last().unwrap();
        criterion.bench_function(name, |bencher| {
            bencher.iter(|| {
                let mut arguments = [MacroValue::Real(0.0), MacroValue::Real(2.0), MacroValue::Logical(true)];
                vm::run(&program, &mut state, &mut host, index, &mut arguments)
            });
        });
        assert!(host.output.diagnostics.is_empty(), "{name}: {:?}", host.output.diagnostics);
    }
}

criterion_group!(benches, loops);
criterion_main!(benches);
