//! For any bytes, loading returns findings or a machine.

use super::*;
use crate::package;

/// Small deterministic generator (xorshift).
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % limit as u64) as usize
    }
}

fn load_bytes(bytes: &[u8]) {
    let mut files = package::shipped();
    files.insert("m/machine.toml", bytes);
    let loaded = load(&files, "m");
    assert_eq!(loaded.machine.is_none(), loaded.findings.iter().any(|finding| finding.error));
}

fn sample() -> Vec<u8> {
    let tail = "[tool]\n[[tool.offsets]]\nnumber = 1\nvalues = { X1 = 1.5 }\n[time]\nm_codes = { \"3\" = 1 }\n\
                [variables]\nshared = [[100, 199]]\n[format]\ncomment = [\"(\", \")\"]\n";
    format!("initial = [\"CODE_RAPID\"]{BASE}{tail}").into_bytes()
}

#[test]
fn truncated_files_are_findings() {
    let sample = sample();
    for end in 0..sample.len() {
        load_bytes(&sample[..end]);
    }
}

#[test]
fn changed_files_are_findings_or_machines() {
    let sample = sample();
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let pieces: [&[u8]; 12] = [
        b"[",
        b"]]",
        b"=",
        b"\"",
        b"\n",
        b"{",
        b"-1e999",
        b"nan",
        b"\xff",
        b"[[codes]]",
        b"''",
        b"9999999999999999999",
    ];
    for _ in 0..400 {
        let mut bytes = sample.clone();
        for _ in 0..=random.below(4) {
            let at = random.below(bytes.len());
            match random.below(3) {
                0 => bytes[at] = random.below(256) as u8,
                1 => drop(bytes.remove(at)),
                _ => drop(bytes.splice(at..at, pieces[random.below(pieces.len())].iter().copied())),
            }
        }
        load_bytes(&bytes);
    }
}

#[test]
fn random_bytes_are_findings() {
    let mut random = Random(42);
    for length in 0..200 {
        let bytes: Vec<u8> = (0..length).map(|_| random.below(256) as u8).collect();
        load_bytes(&bytes);
    }
}

#[test]
fn bytes_that_are_no_text_are_placed() {
    let mut files = MemoryFiles::default();
    files.insert("m/machine.toml", b"a = 1\nbc\xff");
    let first = load(&files, "m").findings.into_iter().find(|finding| finding.line > 0).unwrap();
    assert_eq!((first.line, first.column), (2, 3));
}

#[test]
fn deep_and_huge_files_are_findings() {
    load_bytes("[".repeat(100_000).as_bytes());
    load_bytes(format!("a = {}", "[".repeat(100_000)).as_bytes());
    load_bytes(format!("a = {}1{}", "{b=".repeat(10_000), "}".repeat(10_000)).as_bytes());
    load_bytes("x = 1\n".repeat(20_000).as_bytes());
    load_bytes("[[codes]]\n".repeat(20_000).as_bytes());
    load_bytes(&vec![b' '; 2 << 20]);
}
