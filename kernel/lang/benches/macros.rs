//! Macro loops, to be compared with the same loops in Lua (`tests/peers/lua.py`).

#![allow(missing_docs, clippy::unwrap_used)]

use counterpoint_lang::compile::{self, Options, Program};
use counterpoint_lang::host::Test;
use counterpoint_lang::source::Source;
use counterpoint_lang::vm::{self, Limits, State};
use criterion::{Criterion, criterion_group, criterion_main};

const LOOPS: [(&str, &str); 6] = [
    ("arithmetic", "S=0\nDO/I=1,100000\nS=S+I*2-S/3\nENDOF/DO"),
    ("branches", "N=0\nI=0\nWHILE/I.LT.100000\nI+=1\nIF/$FMOD(I,3).EQ.0.AND.I.GT.5\nN+=1\nENDOF/IF\nENDOF/WHILE"),
    ("array", "DECLAR/REAL,A(1000)\nDO/J=1,100\nDO/I=1,1000\nA(I)=A(I)+I\nENDOF/DO\nENDOF/DO"),
    ("sequence", "DO/J=1,100\nQ={}\nDO/I=1,1000\nQ+=I\nENDOF/DO\nENDOF/DO"),
    ("edit", "DO/I=1,10000\nT=$FEDIT('N120 X1.5 Y22.75 Z-3','[XYZ]\\([-0-9.]*\\)','<\\1>')\nENDOF/DO"),
    ("function", "MACRO/ADDED(A,B)\nADDED=A+B\nENDMAC\nS=0\nDO/I=1,100000\nS=ADDED(S,I)\nENDOF/DO"),
];

fn loops(criterion: &mut Criterion) {
    for (name, text) in LOOPS {
        let (mut program, mut host) = (Program::new(), Test::new());
        let added = compile::add(&mut program, &mut host, Source::new(name, text), Options::default());
        assert!(!added.has_errors(), "{:?}", added.diagnostics);
        let mut state = State::new(Limits { ticks: u64::MAX, ..Limits::default() });
        let index = *added.macros.last().unwrap();
        criterion.bench_function(name, |bencher| {
            bencher.iter(|| vm::run(&program, &mut state, &mut host, index, &mut []));
        });
        assert!(host.diagnostics.is_empty());
    }
}

criterion_group!(benches, loops);
criterion_main!(benches);
