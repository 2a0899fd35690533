//! Time of motions and of codes.
//!
//! Facts: reference channel-synchronisation.md 3, control-emulator.md 6.9. A duration is computed in seconds once and
//! rounded once.

use counterpoint_channel::laws::note_law;
use counterpoint_channel::plausible::LONGEST_MOVE;
use counterpoint_channel::spindle::stopped;
use counterpoint_event::event::{FeedUnit, UnknownLaw};
use counterpoint_fault as diag;
use counterpoint_fault::Acted;
use counterpoint_motion::law::{FeedSchedule, SpindleRotation};
use counterpoint_motion::thread::Lead;

use crate::context::ActionContext;
use crate::improbable::{look_at_feed, look_at_revolutions, report_long_move};
use counterpoint_channel::timed_path::{TimedPath, paced, rapid_seconds};

/// The message about an unusable feed.
fn lack(feed: Option<f64>) -> (&'static diag::DiagnosticFacts, &'static str) {
    match feed {
        None => (&diag::NO_FEED, "no feed rate is programmed for"),
        Some(_) => (&diag::FEED_NOT_POSITIVE, "the feed rate is zero or negative in"),
    }
}

/// Seconds of a feed move that is timed as a rapid move.
#[cold]
fn seconds_as_rapid(act: &mut ActionContext<'_, '_>, path: &TimedPath<'_>) -> f64 {
    note_law(act.channel_mut(), |law| law.unknown = Some(UnknownLaw::WithoutFeed));
    rapid_seconds(act.channel(), path.from, path.to)
}

/// Notes that the feed of the next move follows a spindle, for the law of the move.
#[cold]
#[inline(never)]
pub(crate) fn note_turning(
    act: &mut ActionContext<'_, '_>,
    path: &TimedPath<'_>,
    lead: Lead,
    spindle: SpindleRotation,
) {
    let place = &act.channel().state.place;
    let radii = [path.from, path.to].map(|point| place.radius(point));
    let schedule = match (spindle, path.arc) {
        (SpindleRotation::Surface(speed), Some((arc, Some(radial)))) => {
            FeedSchedule::SurfaceArc { arc: *arc, radial, speed }
        }
        _ => FeedSchedule::Turning { lead, way: path.length, radii, spindle },
    };
    note_law(act.channel_mut(), |law| law.schedule = schedule);
}

/// Seconds of a feed move without a usable feed: at the smallest one of the control, otherwise those of a rapid
/// move.
#[cold]
fn without_feed(
    act: &mut ActionContext<'_, '_>,
    path: &TimedPath<'_>,
    facts: &diag::DiagnosticFacts,
    what: &str,
) -> f64 {
    let least = act.channel().env.machine.habits.least_feed;
    let how = match least {
        _ if act.channel().env.machine.stops_at(facts) => "no part of the block acts".to_owned(),
        Some(feed) => format!("the smallest feed {} is used", counterpoint_lang::format::wildcard_text(feed)),
        None => "the move is timed as rapid".to_owned(),
    };
    let text = format!("{what} '{}', {how}", act.channel().block_text());
    act.diagnose(facts, text);
    match least {
        Some(feed) => paced(act.channel_mut(), path, feed / 60.0),
        None => seconds_as_rapid(act, path),
    }
}

/// Stops the channel at a move without a usable feed before anything of it is made, where that is an alarm.
#[inline(always)]
pub(crate) fn check_feed(act: &mut ActionContext<'_, '_>, feed: Option<f64>) -> Acted {
    if feed.is_some_and(|feed| feed > 0.0) { Ok(()) } else { no_feed(act, feed) }
}

#[cold]
fn no_feed(act: &mut ActionContext<'_, '_>, feed: Option<f64>) -> Acted {
    let (facts, what) = lack(feed);
    if !act.channel().env.machine.stops_at(facts) {
        return Ok(());
    }
    let text = format!("{what} '{}', no part of the block acts", act.channel().block_text());
    act.diagnose(facts, text);
    act.channel().check_stop()
}

/// Seconds of a feed move; falls back to the rapid time (with a diagnostic) when there is no usable feed.
pub(crate) fn feed_seconds(
    act: &mut ActionContext<'_, '_>,
    path: &TimedPath<'_>,
    feed: Option<f64>,
    unit: FeedUnit,
) -> Result<f64, counterpoint_fault::Halt> {
    let Some(feed) = feed.filter(|feed| *feed > 0.0) else {
        let (facts, what) = lack(feed);
        return Ok(without_feed(act, path, facts, what));
    };
    let seconds = match unit {
        FeedUnit::PerMinute => {
            if feed > act.channel().reports.plausible.look_above {
                look_at_feed(act, feed, path)?;
            }
            paced(act.channel_mut(), path, feed / 60.0)
        }
        FeedUnit::InverseTime => 60.0 / feed,
        FeedUnit::PerRevolution => match revolution_minutes(act, path, feed)? {
            Some(minutes) => {
                if path.length > minutes * act.channel().reports.plausible.look_above_revolutions {
                    look_at_revolutions(act, path.length / minutes)?;
                }
                minutes * 60.0
            }
            None => seconds_as_rapid(act, path),
        },
        FeedUnit::Rapid => seconds_as_rapid(act, path),
    };
    if seconds > LONGEST_MOVE {
        report_long_move(act, seconds);
    }
    Ok(seconds)
}

/// Minutes at a feed per revolution, `None` (with a diagnostic) while the spindle is stopped.
fn revolution_minutes(
    act: &mut ActionContext<'_, '_>,
    path: &TimedPath<'_>,
    feed: f64,
) -> Result<Option<f64>, counterpoint_fault::Halt> {
    let Some(speed) = act.speed_of_cut()? else {
        let text = format!(
            "{} in '{}' with feed per revolution, the move is timed as rapid",
            stopped(act.channel()),
            act.channel().block_text()
        );
        act.diagnose(&diag::SPINDLE_STANDS, text);
        return Ok(None);
    };
    let minutes = match speed {
        SpindleRotation::Fixed(rpm) => path.length / (feed * rpm),
        SpindleRotation::Driven(driven, elapsed) => driven.minutes_of(elapsed, path.length / feed),
        SpindleRotation::Surface(surface) => match path.arc {
            Some((arc, Some(radial))) => surface.arc_minutes(arc, radial, feed) * path.length / arc.length(),
            _ => {
                let [start, end] = [path.from, path.to].map(|p| act.channel().state.place.radius(p));
                surface.line_minutes(start, end, path.length, feed)
            }
        },
    };
    if act.channel().state.law.is_some() {
        note_turning(act, path, Lead { start: feed, change: 0.0 }, speed);
    }
    act.assume_speed(minutes * 60.0);
    Ok(Some(minutes))
}
