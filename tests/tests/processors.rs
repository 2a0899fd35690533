//! Jobs of several channels end on any machine: one processor, two, all, free and busy.
//!
//! Every run is watched (`watchdog`), so a wake-up that is lost fails the test with the state of every kernel.

use counterpoint_kernel::options::JobOptions;
use counterpoint_tests::processors::{PLACES, at};
use counterpoint_tests::{Work, machine};

/// Runs a job `rounds` times at every place with every number of threads; all logs are equal. Returns the digest.
fn everywhere(name: &str, work: &Work, rounds: usize) -> String {
    let mut digests = Vec::new();
    for place in PLACES {
        for threads in [0, 1, 2] {
            let mut work = work.clone();
            work.options.threads = threads;
            let since = std::time::Instant::now();
            let found = at(place, || {
                let mut found = Vec::new();
                for _ in 0..rounds {
                    found.push(work.run(None).unwrap().summary.log_digest.to_string());
                    found.push(work.results(None).unwrap().0.summary.log_digest.to_string());
                }
                found
            });
            if std::env::var_os("TIMES").is_some() {
                eprintln!("{name}: {place:?}, {threads} threads: {:?}", since.elapsed());
            }
            digests.extend(found.into_iter().map(|digest| (digest, place, threads)));
        }
    }
    let first = digests[0].0.clone();
    for (digest, place, threads) in &digests {
        assert_eq!(*digest, first, "{name} at {place:?} with {threads} threads");
    }
    first
}

fn two_path(texts: &[String]) -> Work {
    Work::texts(machine("fanuc-2path-lathe-exact", ""), texts, JobOptions::default())
}

#[test]
fn the_example_ends_everywhere() {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/two-turret");
    let texts = ["upper.nc", "lower.nc"].map(|name| std::fs::read_to_string(folder.join(name)).unwrap());
    everywhere("the example", &two_path(&texts), 3);
}

#[test]
fn a_shared_variable_before_a_wait_ends_everywhere() {
    let texts = ["O1\nG4P100\nM101\nM30\n", "O2\nG4P100\n#500=1\nM101\nM30\n"].map(str::to_owned);
    everywhere("four lines", &two_path(&texts), 5);
}

/// A machine on which channels of these numbers, each with one axis, meet at M100 to M199.
fn channels(numbers: &[u16]) -> String {
    let form = if numbers.iter().all(|number| *number < 10) { "list" } else { "bits" };
    let mut overlay = format!(
        "[sync]\ndialect = \"fanuc\"\npaths = \"{form}\"\n[[codes]]\nid = \"CODE_SYNC_REG\"\nword = \"M100-M199\"\n\
         as_data = \"REG_SYNC\"\n[[data]]\nid = \"REG_SYNC_PATHS\"\nregister = \"P\"\nmin = 0\n"
    );
    for number in numbers {
        overlay.push_str(&format!("[[axes]]\nname = \"X{number}\"\nrapid = 10_000\nhome = 0\n"));
        overlay.push_str(&format!("[[channels]]\nnumber = {number}\naxes = [\"X{number}\"]\n"));
    }
    overlay
}

#[test]
fn many_channels_that_meet_at_time_zero_end_everywhere() {
    let numbers: Vec<u16> = (1..=8).collect();
    let texts: Vec<String> = numbers
        .iter()
        .map(|own| {
            let meetings: String = (0..400).map(|round| format!("M{} P12345678\n", 101 + round % 50)).collect();
            format!("O{own}\n{meetings}#{}=1\nM30\n", 500 + own)
        })
        .collect();
    let work = Work::texts(machine("fanuc-turning", &channels(&numbers)), &texts, JobOptions::default());
    everywhere("eight channels", &work, 1);
}

/// Numbers of channels are names: nothing hangs, and nothing is reported of channels that do not exist.
#[test]
fn channels_with_gaps_between_their_numbers_meet() {
    for numbers in [[1_u16, 3], [2, 9], [4, 26]] {
        let [a, b] = numbers;
        let list = |n: u16| if n < 10 { format!(" P{a}{b}") } else { String::new() };
        let wait = list(a.max(b));
        let texts =
            [format!("O1\nG4P100\nM101{wait}\n#500=1\nM30\n"), format!("O2\nG4P200\n#500=2\nM101{wait}\nM30\n")];
        let work = Work::texts(machine("fanuc-turning", &channels(&numbers)), &texts, JobOptions::default());
        let done = work.run(None).unwrap();
        let story = format!("channels {numbers:?}: {:#?}", done.summary);
        assert_eq!(done.summary.makespan_ns, 200_000_000, "{story}");
        assert_eq!(done.summary.waits.len(), 1, "{story}");
        assert_eq!(done.summary.waits[0].arrivals.iter().map(|m| m.channel).collect::<Vec<_>>(), numbers, "{story}");
        assert!(done.summary.verdict.is_none() && done.summary.diagnostics.is_empty(), "{story}");
        everywhere("gaps", &work, 2);
        let alone = [texts[0].clone(), "O2\nM30\n".to_owned()];
        let done =
            Work { files: Work::texts(work.machine.clone(), &alone, JobOptions::default()).files, ..work }.run(None);
        let verdict = done.unwrap().summary.verdict.unwrap();
        assert!(verdict.text.contains(&format!("channel {b} has ended")), "{}", verdict.text);
    }
}
