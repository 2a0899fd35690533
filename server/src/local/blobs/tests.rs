use super::*;
use crate::blobs::digest;
use crate::local::disk::Disk;

fn blobs(max: u64) -> (tempfile::TempDir, LocalBlobs) {
    let folder = tempfile::tempdir().unwrap();
    let store = DataFolder::open(folder.path().to_owned(), false, Disk::default()).unwrap();
    (folder, LocalBlobs::new(store, max))
}

#[test]
fn what_comes_in_goes_out() {
    let (_folder, blobs) = blobs(100);
    let name = digest(b"G0X1\nM30\n");
    assert!(!blobs.has(&name));
    let mut receiver = blobs.receive(&name, None).unwrap();
    receiver.chunk(b"G0X1\n").unwrap();
    receiver.chunk(b"M30\n").unwrap();
    assert_eq!(receiver.finish().unwrap(), 9);
    assert_eq!(&*blobs.read(&name).unwrap(), b"G0X1\nM30\n");
}

#[test]
fn a_blob_that_is_offered_is_as_young_as_one_that_was_uploaded() {
    let (folder, blobs) = blobs(100);
    let name = digest(b"x");
    let mut receiver = blobs.receive(&name, None).unwrap();
    receiver.chunk(b"x").unwrap();
    receiver.finish().unwrap();
    let grace = Duration::from_secs(3600);
    let age = || {
        let file = fs::File::options().append(true).open(folder.path().join("blobs").join(&name[..2]).join(&name));
        file.unwrap().set_modified(SystemTime::now() - 2 * grace).unwrap();
    };
    age();
    assert_eq!(blobs.older_than(grace).collect::<Vec<_>>(), [[name.clone()]]);
    assert!(blobs.offers(&name) && blobs.older_than(grace).next().is_none() && !blobs.remove_older(&name, grace));
    age();
    let mut receiver = blobs.receive(&name, None).unwrap();
    receiver.chunk(b"x").unwrap();
    receiver.finish().unwrap();
    assert!(blobs.older_than(grace).next().is_none(), "uploaded again");
    age();
    assert!(blobs.remove_older(&name, grace) && !blobs.has(&name));
}

#[test]
fn uploads_of_one_content_at_the_same_time_count_once() {
    let (_folder, blobs) = blobs(100);
    assert_eq!(blobs.bytes().unwrap(), 0);
    let name = digest(b"common");
    for _ in 0..20 {
        let uploads = std::sync::Barrier::new(8);
        std::thread::scope(|scope| {
            for _ in 0..8 {
                scope.spawn(|| {
                    let mut receiver = blobs.receive(&name, None).unwrap();
                    receiver.chunk(b"common").unwrap();
                    uploads.wait();
                    receiver.finish().unwrap();
                });
            }
            scope.spawn(|| blobs.remove_older(&name, Duration::ZERO));
        });
        let there = blobs.size(&name);
        assert_eq!(blobs.bytes().unwrap(), there);
        assert_eq!(blobs.remove_older(&name, Duration::ZERO), there > 0);
        assert_eq!(blobs.bytes().unwrap(), 0);
    }
}

#[test]
fn memory_holds_them_too() {
    let blobs = LocalBlobs::in_memory(100);
    let name = digest(b"G0X1\n");
    let mut receiver = blobs.receive(&name, None).unwrap();
    receiver.chunk(b"G0X1\n").unwrap();
    assert!(!blobs.has(&name));
    receiver.finish().unwrap();
    let mut text = String::new();
    blobs.open(&name).unwrap().read_to_string(&mut text).unwrap();
    assert_eq!((text.as_str(), blobs.has(&name)), ("G0X1\n", true));
    assert_eq!(blobs.read(&digest(b"other")).unwrap_err().kind(), io::ErrorKind::NotFound);
}

#[test]
fn a_content_of_this_process_goes_to_its_place() {
    let (_folder, files) = blobs(4);
    for blobs in [files, LocalBlobs::in_memory(4)] {
        let name = digest(b"M30\n");
        blobs.put(&name, Bytes::from_static(b"M30\n")).unwrap();
        assert_eq!(&*blobs.read(&name).unwrap(), b"M30\n");
        let long = Bytes::from_static(b"12345");
        assert_eq!(blobs.put(&digest(&long), long.clone()), Err(Refusal::BlobTooLarge(4)));
        assert!(!blobs.has(&digest(&long)));
    }
}

#[test]
fn a_wrong_digest_or_too_much_is_refused_and_leaves_nothing() {
    let (folder, blobs) = blobs(4);
    let mut receiver = blobs.receive(&digest(b"x"), None).unwrap();
    receiver.chunk(b"y").unwrap();
    assert!(matches!(receiver.finish(), Err(Refusal::DigestMismatch { .. })));
    let mut receiver = blobs.receive(&digest(b"12345"), None).unwrap();
    assert_eq!(receiver.chunk(b"12345"), Err(Refusal::BlobTooLarge(4)));
    drop(receiver);
    let mut receiver = blobs.receive(&digest(b"123"), Some(2)).unwrap();
    assert!(matches!(receiver.chunk(b"123"), Err(Refusal::InvalidField { .. })), "more than announced");
    drop(receiver);
    let mut receiver = blobs.receive(&digest(b"123"), Some(4)).unwrap();
    receiver.chunk(b"123").unwrap();
    assert!(matches!(receiver.finish(), Err(Refusal::InvalidField { .. })), "less than announced");
    assert!(matches!(blobs.receive(&digest(b"12345"), Some(5)), Err(Refusal::BlobTooLarge(4))));
    assert!(matches!(blobs.receive("../../x", None), Err(Refusal::InvalidField { .. })));
    assert_eq!(fs::read_dir(folder.path().join("tmp")).unwrap().count(), 0);
}
