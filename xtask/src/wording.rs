//! Words in comments that make sentences hard to read, and lines that are too long to review.

/// Words of a comment line, in lower case.
fn words(line: &str) -> impl Iterator<Item = String> + '_ {
    let words = line.split(|c: char| !(c.is_alphabetic() || c == '\'')).filter(|word| !word.is_empty());
    words.map(str::to_lowercase)
}

/// Counts of words in comments.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Words {
    pub(crate) all: usize,
    /// "what", which often introduces a clause used as a noun.
    pub(crate) what: usize,
    /// "somebody", "nobody", "whoever" and similar words.
    pub(crate) people: usize,
}

const PEOPLE: [&str; 7] = ["somebody", "nobody", "whoever", "anybody", "everybody", "someone", "anyone"];

impl Words {
    /// Adds the comments of a source file.
    pub(crate) fn add(&mut self, source: &str) {
        for line in source.lines().map(str::trim_start) {
            let Some(comment) = line.strip_prefix("//").or_else(|| line.split_once(" // ").map(|(_, after)| after))
            else {
                continue;
            };
            for word in words(comment) {
                self.all += 1;
                self.what += usize::from(word == "what");
                self.people += usize::from(PEOPLE.contains(&word.as_str()));
            }
        }
    }

    /// Frequency per 10,000 words, rounded up: "what", and indefinite words for people.
    pub(crate) fn shares(&self) -> [usize; 2] {
        [self.what, self.people].map(|count| (10_000 * count).div_ceil(self.all.max(1)))
    }
}

/// Lines longer than `most` characters. Table rows and single links are exempt, because they cannot be divided.
pub(crate) fn long_lines(text: &str, most: usize) -> usize {
    let long = text.lines().filter(|line| line.chars().count() > most);
    long.filter(|line| !line.trim_start().starts_with('|') && line.split_whitespace().count() > 1).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_comments_count_and_those_of_code_do_not() {
        let mut words = Words::default();
        words.add(
            "//! Says what\n    /// Nobody knows.\nlet what = \"nobody\"; // What it is\nlet url = \"a://what\";\n",
        );
        assert_eq!(words, Words { all: 7, what: 2, people: 1 });
        assert_eq!(words.shares(), [2858, 1429]);
    }

    #[test]
    fn rows_and_single_words_may_be_long() {
        let text = format!("| {0} |\n{0}\nsome {0}\nshort\n", "x".repeat(130));
        assert_eq!(long_lines(&text, 120), 1);
    }
}
