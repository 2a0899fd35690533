//! Actions in the words of the trace, read off the events.
//!
//! Layout and words: reference listing-and-trace.md 4.3. Invariant: `rapid` and `feed` are written when they change,
//! and only axes that are coded or move are named.

use counterpoint_lang::format::wildcard_text;

use crate::geometry::Loop;
use counterpoint_event::event::{Event, FeedUnit, Kind, Motion, MotionKind, SpindleChange, SpindleDirection};
use counterpoint_event::info::JobAxis;

/// The last written value.
#[derive(Debug, Default)]
pub(super) struct ActionFormatter {
    rate: Option<(FeedUnit, u64, bool)>,
    /// Spindles as they were, those that have not turned yet left out.
    spindles: Vec<SpindleChange>,
}

impl ActionFormatter {
    /// The actions of an event, in order.
    pub(super) fn of(&mut self, axes: &[JobAxis], event: &Event) -> Vec<String> {
        match &event.kind {
            Kind::Motion(motion) => self.motion(axes, motion),
            Kind::Dwell(_) => vec![format!("dwell t={}", wildcard_text(event.dur_ns as f64 / 1e9))],
            Kind::Spindle(spindle) => vec![self.spindle(spindle)],
            kind => kind.action(wildcard_text).into_iter().collect(),
        }
    }

    /// Action of a spindle: its limit alone when nothing else is new, its speed when it is stopped before and after.
    fn spindle(&mut self, now: &SpindleChange) -> String {
        let stopped = SpindleChange {
            direction: SpindleDirection::Off,
            css: false,
            speed: 0.0,
            limit: f64::INFINITY,
            angle: 0.0,
            ..*now
        };
        let known = self.spindles.iter_mut().find(|known| known.spindle == now.spindle);
        let before = match known {
            Some(known) => std::mem::replace(known, *now),
            None => {
                self.spindles.push(*now);
                stopped
            }
        };
        let same = |a: &SpindleChange, b: &SpindleChange| {
            a.direction == b.direction
                && (a.direction == SpindleDirection::Off || (a.css, a.speed, a.angle) == (b.css, b.speed, b.angle))
        };
        if !now.css && now.limit.is_finite() && now.limit != before.limit && same(&before, now) {
            return numbered(now, (format!("spindle max={}", wildcard_text(now.limit)), true));
        }
        let stopped = now.direction == SpindleDirection::Off && before.direction == SpindleDirection::Off;
        if stopped && (now.css, now.speed) != (before.css, before.speed) {
            return match now.css {
                true => turning(&SpindleChange { direction: SpindleDirection::Clockwise, ..*now }),
                false => numbered(now, (format!("spindle rpm={}", wildcard_text(now.speed)), true)),
            };
        }
        turning(now)
    }

    fn motion(&mut self, axes: &[JobAxis], motion: &Motion) -> Vec<String> {
        let mut out = Vec::new();
        let thread = motion.kind == MotionKind::Thread;
        let rate = (motion.feed_unit, motion.feed.to_bits(), thread);
        if motion.kind == MotionKind::Rapid {
            if self.rate.is_none_or(|(unit, ..)| unit != FeedUnit::Rapid) {
                out.push("rapid".to_owned());
            }
            self.rate = Some((FeedUnit::Rapid, 0, false));
        } else if self.rate != Some(rate) {
            let feed = wildcard_text(motion.feed);
            out.push(match motion.feed_unit {
                _ if thread => format!("pitch f={feed}"),
                FeedUnit::PerRevolution => format!("feed f={feed} upr"),
                FeedUnit::InverseTime => format!("feed f={feed} 1t"),
                FeedUnit::PerMinute | FeedUnit::Rapid => format!("feed f={feed}"),
            });
            self.rate = Some(rate);
        }
        let verb = match motion.kind {
            MotionKind::Rapid | MotionKind::Linear => "goto",
            MotionKind::Thread => "thread",
            MotionKind::ArcCw => "arc cw",
            MotionKind::ArcCcw => "arc ccw",
            MotionKind::ArcSpace => "arc 3d",
        };
        let moves = |index: usize| motion.moving >> index & 1 != 0 || motion.from.get(index) != motion.to.get(index);
        let place = |(index, axis): (usize, &JobAxis)| {
            moves(index).then(|| format!("{}={}", axis.name.to_lowercase(), value(motion.to.get(index))))
        };
        let mut items: Vec<String> = axes.iter().enumerate().filter_map(place).collect();
        if matches!(motion.kind, MotionKind::ArcCw | MotionKind::ArcCcw) {
            let mut centers: Vec<String> = motion
                .plane_axes
                .iter()
                .zip(motion.center)
                .filter_map(|(&axis, center)| Some((axes.get(usize::from(axis))?, center)))
                .map(|(axis, center)| format!("{}={}", center_letter(axis), wildcard_text(center)))
                .collect();
            centers.sort_unstable();
            items.extend(centers);
        }
        if let Some(space) = Loop::of(motion, axes) {
            let centers = space.seen.values(space.circle.center).filter_map(|(at, value)| Some((axes.get(at)?, value)));
            items.extend(centers.map(|(axis, value)| format!("{}={}", center_letter(axis), wildcard_text(value))));
        }
        out.push(format!("{verb} {}", items.join(", ")).trim_end().to_owned());
        out
    }
}

/// State of a spindle.
fn turning(spindle: &SpindleChange) -> String {
    let number = wildcard_text;
    let text = match spindle.direction {
        SpindleDirection::Off => "spindle off".to_owned(),
        SpindleDirection::Oriented if spindle.angle == 0.0 => "spindle orient".to_owned(),
        SpindleDirection::Oriented => format!("spindle orient a={}", number(spindle.angle)),
        SpindleDirection::Locked => "spindle lock".to_owned(),
        SpindleDirection::Neutral => "spindle neutral".to_owned(),
        _ if spindle.css && spindle.limit.is_finite() => {
            format!("css v={}, max={}", number(spindle.speed), number(spindle.limit))
        }
        _ if spindle.css => format!("css v={}", number(spindle.speed)),
        SpindleDirection::Clockwise => format!("spindle clw, rpm={}", number(spindle.speed)),
        SpindleDirection::CounterClockwise => format!("spindle ccw, rpm={}", number(spindle.speed)),
    };
    let bare = match spindle.direction {
        SpindleDirection::Off | SpindleDirection::Locked | SpindleDirection::Neutral => true,
        SpindleDirection::Oriented => spindle.angle == 0.0,
        SpindleDirection::Clockwise | SpindleDirection::CounterClockwise => false,
    };
    numbered(spindle, (text, !bare))
}

/// With the number of the spindle, unless it is the first one; after a value a comma separates it.
fn numbered(spindle: &SpindleChange, (text, has_value): (String, bool)) -> String {
    match spindle.spindle {
        0 | 1 => text,
        other if has_value => format!("{text}, n={other}"),
        other => format!("{text} n={other}"),
    }
}

fn value(value: Option<&f64>) -> String {
    value.map_or_else(String::new, |value| wildcard_text(*value))
}

fn center_letter(axis: &JobAxis) -> &'static str {
    match axis.name.as_bytes().first() {
        Some(b'X') => "i",
        Some(b'Y') => "j",
        _ => "k",
    }
}
