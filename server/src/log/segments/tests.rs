use std::io::Cursor;

use super::*;
use crate::log::reader::tests::plain;

/// A log of this many events and its compressed form.
fn both(events: u64) -> (Vec<u8>, Vec<u8>) {
    let (plain, mut packed) = (plain("j", events), Vec::new());
    assert_eq!(pack("j", &mut plain.as_slice(), &mut packed).unwrap(), packed.len() as u64);
    (plain, packed)
}

#[test]
fn read_it_is_the_plain_file() {
    for events in [0, 1, 255, 256, 257, 40_000] {
        let (plain, packed) = both(events);
        let mut segments = CompressedLog::of(Cursor::new(&packed)).unwrap();
        assert_eq!(segments.length(), plain.len() as u64);
        let mut read = Vec::new();
        segments.read_to_end(&mut read).unwrap();
        assert!(read == plain, "{events} events");
        for at in [0, 7, plain.len() / 3, plain.len() - 1, 1] {
            let mut part = vec![0; (plain.len() - at).min(1000)];
            segments.seek(SeekFrom::Start(at as u64)).unwrap();
            segments.read_exact(&mut part).unwrap();
            assert!(part == plain[at..at + part.len()]);
        }
    }
    let (plain, packed) = both(40_000);
    assert!(packed.len() * 2 < plain.len(), "{} of {} bytes", packed.len(), plain.len());
}

#[test]
fn a_cursor_needs_the_head_and_its_own_segment() {
    let (_, packed) = both(40_000);
    let mut segments = CompressedLog::of(Cursor::new(&packed)).unwrap();
    let entries: Vec<_> = (0..segments.count).map(|number| segments.entry(number).unwrap()).collect();
    assert!(entries.len() > 4 && entries[0].first == 0 && entries[1].first == 1);
    let wanted = entries[3];
    let mut damaged = packed.clone();
    for entry in entries.iter().filter(|entry| entry.first != 0 && **entry != wanted) {
        damaged[entry.at as usize + 3] ^= 0x55;
    }
    let mut segments = CompressedLog::of(Cursor::new(&damaged)).unwrap();
    for after in [wanted.first - 1, wanted.first, wanted.first + 300] {
        assert_eq!(segments.place(after).unwrap(), wanted.plain);
    }
    let mut whole = vec![0; wanted.length as usize];
    segments.seek(SeekFrom::Start(wanted.plain)).unwrap();
    segments.read_exact(&mut whole).unwrap();
    let error = segments.read(&mut [0]).unwrap_err();
    assert!(error.kind() == io::ErrorKind::InvalidData && error.to_string().contains("submit the job again"));
}

#[test]
fn damage_is_reported_and_no_panic() {
    let (plain, packed) = both(3000);
    let read = |bytes: &[u8]| {
        let mut read = Vec::new();
        CompressedLog::of(Cursor::new(bytes)).and_then(|mut segments| segments.read_to_end(&mut read)).map(|_| read)
    };
    assert!(read(&packed).unwrap() == plain);
    for cut in (0..packed.len()).step_by(97) {
        assert!(read(&packed[..cut]).is_err());
    }
    assert!(CompressedLog::of(Cursor::new(&packed)).unwrap().check_beginning().is_ok());
    for at in 0..8 {
        let mut bad = packed.clone();
        bad[at] ^= 0x55;
        let error = CompressedLog::of(Cursor::new(bad)).unwrap().check_beginning().unwrap_err();
        assert!(error.kind() == io::ErrorKind::InvalidData, "byte {at}: {error}");
    }
    for at in (8..packed.len()).step_by(61) {
        let mut bad = packed.clone();
        bad[at] ^= 0x55;
        assert!(read(&bad).is_err(), "byte {at}");
    }
    let mut bad = plain.clone();
    bad[plain.len() - 9] ^= 0x55;
    assert!(pack("j", &mut bad.as_slice(), &mut Vec::new()).is_err(), "a damaged log is not packed");
    assert!(pack("k", &mut plain.as_slice(), &mut Vec::new()).is_err(), "nor is that of another job");
}
