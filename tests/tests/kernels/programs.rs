//! Random programs of channels that meet in every way.

use std::fmt::Write as _;

/// Channels as bits: bit 0 is channel 1.
pub type Set = u8;

/// The activity of a channel.
#[derive(Debug, Clone)]
pub enum Step {
    /// Milliseconds.
    Dwell(u64),
    /// Waits until all channels of the list wait at the mark.
    Sync(u32, Set),
    /// Waits until two channels wait at the mark.
    Meet(u32),
    /// Waits until the flags of these channels are set.
    Flag(u32, Set),
    Raise(u32),
    Lower(u32),
    /// Waits until all others have reached this number.
    Rank(u32),
    /// A signal to these channels, or to all channels.
    Send(u32, Option<Set>),
    /// Waits for a signal of each of these channels, or of any channel.
    Take(u32, Option<Set>),
    Get(u32),
    Put(u32),
    /// Waits until these channels have ended.
    Join(Set),
    /// Sets a shared variable to 1.
    Write(u32),
    /// Looks at a shared variable every so many milliseconds until it is 1; 0: as fast as it can.
    Poll(u32, u64),
    Loop(u64, Vec<Step>),
    /// A subprogram, this many times.
    Call(u64, Vec<Step>),
    /// Data outside any model: text of a block.
    Other(String),
}

/// Numbers that are the same in every run of a test.
pub struct Numbers(u64);

impl Numbers {
    pub fn of(case: u64) -> Self {
        Self(case.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    pub fn below(&mut self, limit: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 8) % limit
    }
}

/// The allowed content of the programs of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Content {
    /// A dwell of a random length after every step, so that hardly any two channels act at one instant, and nothing
    /// that the model does not know.
    Spaced,
    /// Everything.
    All,
}

/// Marks of each kind, and shared variables.
const MARKS: u64 = 3;

/// Makes the programs of all channels at once: related statements go into the programs of all participants, in the same
/// order everywhere, so that most jobs reach their end.
pub struct Writer<'a> {
    pub numbers: &'a mut Numbers,
    pub channels: u16,
    pub content: Content,
    /// Lists of the barriers by mark: a mark has the same list wherever it stands.
    lists: Vec<Set>,
    /// Largest number of an order so far.
    rank: u32,
}

type Programs = Vec<Vec<Step>>;

impl<'a> Writer<'a> {
    pub fn new(numbers: &'a mut Numbers, channels: u16, content: Content) -> Self {
        let mut writer = Self { numbers, channels, content, lists: Vec::new(), rank: 0 };
        writer.lists = (0..=MARKS).map(|_| writer.several()).collect();
        writer
    }

    /// Programs, of which a third has a mistake.
    pub fn programs(mut self) -> Programs {
        let mut programs = self.empty();
        (0..usize::from(self.channels)).for_each(|own| self.space(&mut programs, own));
        for _ in 0..2 + self.numbers.below(9) {
            self.event(0, &mut programs);
        }
        if self.numbers.below(4) == 0 {
            let own = self.channel();
            let mut list = self.several() & !(1 << own);
            if list == 0 {
                list = 1 << ((own + 1) % usize::from(self.channels));
            }
            programs[own].push(Step::Join(list));
            self.space(&mut programs, own);
        }
        if self.numbers.below(3) == 0 {
            self.mistake(&mut programs);
        }
        programs
    }

    fn empty(&self) -> Programs {
        vec![Vec::new(); usize::from(self.channels)]
    }

    fn channel(&mut self) -> usize {
        self.numbers.below(u64::from(self.channels)) as usize
    }

    /// Two channels at least.
    fn several(&mut self) -> Set {
        let all: Set = (1 << self.channels) - 1;
        let set = self.numbers.below(u64::from(all) + 1) as Set;
        if set.count_ones() < 2 { all } else { set }
    }

    fn two(&mut self) -> (usize, usize) {
        let one = self.channel();
        (one, (one + 1 + self.numbers.below(u64::from(self.channels) - 1) as usize) % usize::from(self.channels))
    }

    fn members(&self, set: Set) -> impl Iterator<Item = usize> + use<> {
        (0..usize::from(self.channels)).filter(move |channel| set & (1 << channel) != 0)
    }

    fn space(&mut self, programs: &mut Programs, own: usize) {
        match self.content {
            Content::Spaced => programs[own].push(Step::Dwell(1 + self.numbers.below(99_999))),
            Content::All if self.numbers.below(3) == 0 => programs[own].push(Step::Dwell(1 + self.numbers.below(4))),
            Content::All => {}
        }
    }

    fn push(&mut self, programs: &mut Programs, own: usize, step: Step) {
        programs[own].push(step);
        self.space(programs, own);
    }

    /// Something that one channel does, or several together.
    fn event(&mut self, depth: usize, programs: &mut Programs) {
        let mark = 1 + self.numbers.below(MARKS) as u32;
        let own = self.channel();
        match self.numbers.below(if depth < 2 { 26 } else { 22 }) {
            0..=2 => {
                let list = self.lists[mark as usize];
                self.members(list).for_each(|one| self.push(programs, one, Step::Sync(mark, list)));
            }
            3 => {
                let (one, other) = self.two();
                [one, other].into_iter().for_each(|one| self.push(programs, one, Step::Meet(mark)));
            }
            4 | 5 => {
                let list = self.several();
                self.members(list).for_each(|one| self.push(programs, one, Step::Flag(mark, list & !(1 << one))));
            }
            6 => {
                let (one, other) = self.two();
                self.push(programs, one, Step::Raise(mark));
                self.push(programs, other, Step::Flag(mark, 1 << one));
            }
            7 if self.numbers.below(3) == 0 => self.push(programs, own, Step::Lower(mark)),
            7 | 8 if depth == 0 => {
                self.rank += 1 + self.numbers.below(3) as u32;
                let list = (1 << self.channels) - 1;
                self.members(list).for_each(|one| self.push(programs, one, Step::Rank(self.rank)));
            }
            7..=9 => {
                let (one, other) = self.two();
                self.push(programs, one, Step::Send(mark, Some(1 << other)));
                self.push(programs, other, Step::Take(mark, Some(1 << one)));
            }
            10 => {
                self.push(programs, own, Step::Send(mark, None));
                let takers = self.several() & !(1 << own);
                self.members(takers).for_each(|one| self.push(programs, one, Step::Take(mark, None)));
            }
            11 | 12 => {
                let list = self.several();
                self.members(list).for_each(|one| {
                    self.push(programs, one, Step::Get(mark));
                    self.other(programs, one);
                    self.push(programs, one, Step::Put(mark));
                });
            }
            13 => {
                // Each holds one and asks for another one.
                let (one, other) = self.two();
                let marks = [mark, mark % MARKS as u32 + 1];
                let order = if self.numbers.below(2) == 0 { marks } else { [marks[1], marks[0]] };
                for (own, marks) in [(one, marks), (other, order)] {
                    let steps = [Step::Get(marks[0]), Step::Get(marks[1]), Step::Put(marks[1]), Step::Put(marks[0])];
                    steps.into_iter().for_each(|step| self.push(programs, own, step));
                }
            }
            14 | 15 => {
                let (one, other) = self.two();
                let fast = self.numbers.below(2) == 0;
                let every = if fast { 0 } else { 3 + self.numbers.below(40) };
                self.push(programs, one, Step::Write(mark));
                self.push(programs, other, Step::Poll(mark, every));
            }
            16..=21 => self.other(programs, own),
            22 | 23 => {
                let times = 1 + self.numbers.below(3);
                let bodies = self.bodies(depth);
                self.nest(programs, bodies, |body| Step::Loop(times, body));
            }
            _ => {
                let times = 1 + self.numbers.below(2);
                let bodies = self.bodies(depth);
                self.nest(programs, bodies, |body| Step::Call(times, body));
            }
        }
    }

    fn bodies(&mut self, depth: usize) -> Programs {
        let mut bodies = self.empty();
        for _ in 0..1 + self.numbers.below(3) {
            self.event(depth + 1, &mut bodies);
        }
        bodies
    }

    fn nest(&mut self, programs: &mut Programs, bodies: Programs, step: impl Fn(Vec<Step>) -> Step) {
        for (own, body) in bodies.into_iter().enumerate().filter(|(_, body)| !body.is_empty()) {
            self.push(programs, own, step(body));
        }
    }

    /// Actions of a channel alone: moves, commands to the spindle, sums in shared variables, macros, and rarely an
    /// alarm.
    fn other(&mut self, programs: &mut Programs, own: usize) {
        let number = self.numbers.below(9);
        let step = match self.numbers.below(120) {
            _ if self.content == Content::Spaced => Step::Dwell(1 + number),
            0 => Step::Other("#3000=1(ALARM)".to_owned()),
            1..=29 => Step::Other(format!("G1X{number}F{}", 6000 + number)),
            30..=44 => Step::Other(format!("S{}M3", 100 + number)),
            45..=69 => Step::Other(format!("#{}=#{}+{number}", 600 + number % 2, 600 + self.numbers.below(2))),
            70..=79 => Step::Other(format!("X#{}", 600 + number % 2)),
            _ => Step::Other("M1".to_owned()),
        };
        self.push(programs, own, step);
    }

    /// A channel lacks a step, has one twice, or has two in another order.
    fn mistake(&mut self, programs: &mut Programs) {
        let own = self.channel();
        let program = &mut programs[own];
        if program.is_empty() {
            return;
        }
        let (one, other) = (self.numbers.below(program.len() as u64), self.numbers.below(program.len() as u64));
        let (one, other) = (one as usize, other as usize);
        match self.numbers.below(3) {
            0 => drop(program.remove(one)),
            1 => program.insert(one, program[other].clone()),
            _ => program.swap(one, other),
        }
    }
}

/// Writes steps as a program.
#[derive(Default)]
pub struct Text {
    main: String,
    /// Subprograms.
    below: String,
    calls: u32,
    loops: u32,
}

impl Text {
    pub fn of(number: u16, steps: &[Step]) -> String {
        let mut text = Self { main: format!("O{number}\nG98\n"), ..Self::default() };
        text.steps(steps, 0);
        text.main + "M30\n" + &text.below
    }

    fn line(&mut self, line: std::fmt::Arguments<'_>) {
        self.main.write_fmt(line).unwrap();
        self.main.push('\n');
    }

    fn steps(&mut self, steps: &[Step], depth: u32) {
        steps.iter().for_each(|step| self.step(step, depth));
    }

    fn step(&mut self, step: &Step, depth: u32) {
        match step {
            Step::Dwell(ms) => self.line(format_args!("G4P{ms}")),
            Step::Sync(mark, list) => self.line(format_args!("SYNC{mark} P{}", digits(*list))),
            Step::Meet(mark) => self.line(format_args!("MEET{mark}")),
            Step::Flag(mark, list) => self.line(format_args!("FLAG{mark} P{}", digits(*list))),
            Step::Raise(mark) => self.line(format_args!("RAISE{mark}")),
            Step::Lower(mark) => self.line(format_args!("LOWER{mark}")),
            Step::Rank(number) => self.line(format_args!("RANK{number}")),
            Step::Send(mark, to) => self.line(format_args!("SEND{mark}{}", list(*to))),
            Step::Take(mark, from) => self.line(format_args!("TAKE{mark}{}", list(*from))),
            Step::Get(mark) => self.line(format_args!("GET{mark}")),
            Step::Put(mark) => self.line(format_args!("PUT{mark}")),
            Step::Join(channels) => self.line(format_args!("JOIN P{}", digits(*channels))),
            Step::Write(mark) => self.line(format_args!("#{}=1", 500 + mark)),
            Step::Poll(mark, ms) => {
                self.line(format_args!("WHILE[#{}NE1]DO3", 500 + mark));
                if *ms > 0 {
                    self.line(format_args!("G4P{ms}"));
                }
                self.line(format_args!("END3"));
            }
            Step::Loop(times, body) => {
                self.loops += 1;
                let (counter, level) = (self.loops % 30 + 1, depth + 1);
                self.line(format_args!("#{counter}=0\nWHILE[#{counter}LT{times}]DO{level}\n#{counter}=#{counter}+1"));
                self.steps(body, depth + 1);
                self.line(format_args!("END{level}"));
            }
            Step::Call(times, body) => {
                self.calls += 1;
                let name = 8000 + self.calls;
                self.line(format_args!("M98P{name}L{times}"));
                let main = std::mem::replace(&mut self.main, format!("O{name}\n"));
                self.steps(body, depth + 1);
                let text = std::mem::replace(&mut self.main, main);
                self.below += &text;
                self.below += "M99\n";
            }
            Step::Other(text) => self.line(format_args!("{text}")),
        }
    }
}

fn digits(set: Set) -> String {
    (1..=8).filter(|channel| set & (1 << (channel - 1)) != 0).map(|channel| channel.to_string()).collect()
}

fn list(set: Option<Set>) -> String {
    set.map(|set| format!(" P{}", digits(set))).unwrap_or_default()
}
