//! Synchronous spindles: COUPDEF, COUPON, COUPONC, COUPOF, COUPOFS, COUPDEL, COUPRES, WAITC; and WAITS, SPCON and SPCOF
//! of several spindles.
//!
//! Facts: programming manual, work preparation: the following spindle is named before the leading spindle, an angle
//! selects coupling in phase, COUPOFS also stops the following spindle. Decisions: the ratio is the numerator divided
//! by the denominator, as in a generic coupling; COUPON waits until the spindles are synchronous, whatever block change
//! COUPDEF selects, so WAITC never waits; COUPONC acts like COUPON; a definition applies in its channel only.
//! *Invariant:* the words of the machine name both spindles.

use super::compiled::SiemensArgument;
use super::left::SiemensRemainder;
use super::value::Data;
use super::{Outcome, Siemens, syntax, wrong_type};
use counterpoint_control_api::host::InterpreterHost;

/// Codes of the machine: same speed, in phase, and the end.
const PAIRED: &str = "SC_PAIRED";
const IN_PHASE: &str = "SC_INPHASE";
const UNPAIRED: &str = "SC_UNPAIRED";

/// Executes a statement on synchronous spindles. Returns whether the statement is one of these.
pub(super) fn statement(
    siemens: &mut Siemens,
    host: &mut dyn InterpreterHost,
    name: &str,
    arguments: &[SiemensArgument],
    left: &mut SiemensRemainder,
) -> Outcome<bool> {
    match name {
        "WAITS" | "SPCON" | "SPCOF" if host.is_code_text("SETMS") => {
            for argument in arguments {
                spindle(siemens, host, name, argument)?;
            }
            return Ok(true);
        }
        "COUPDEF" | "COUPON" | "COUPONC" | "COUPOF" | "COUPOFS" | "COUPDEL" | "COUPRES" | "WAITC" => {}
        _ => return Ok(false),
    }
    if !host.is_code_text(PAIRED) {
        return Ok(false);
    }
    if name == "WAITC" {
        let [follower, ..] = arguments else { return syntax("WAITC needs a spindle") };
        return spindle(siemens, host, name, follower).map(|_| true);
    }
    let [follower, leader, rest @ ..] = arguments else {
        return syntax(format!("{name} needs the following and the leading spindle"));
    };
    let pair = (spindle(siemens, host, name, follower)?, spindle(siemens, host, name, leader)?);
    let words = format!("COUP_F={} COUP_L={}", pair.0, pair.1);
    match (name, rest) {
        ("COUPDEF", rest) => {
            let numerator = number(siemens, host, rest.first())?.unwrap_or(1.0);
            let denominator = number(siemens, host, rest.get(1))?.unwrap_or(1.0);
            let ratio = numerator / denominator;
            if ratio == 0.0 || !ratio.is_finite() {
                return wrong_type("the ratio of COUPDEF is zero or infinite");
            }
            siemens.held.couplings.insert(pair, ratio);
        }
        ("COUPON" | "COUPONC", rest @ ([] | [_])) => {
            let ratio = siemens.held.couplings.get(&pair).copied().unwrap_or(1.0);
            let ratio = Data::Real(ratio).word();
            match number(siemens, host, rest.first())? {
                Some(angle) if angle.abs() > 1e6 => return wrong_type(format!("the angle of {name} is out of range")),
                Some(angle) => {
                    left.add(&format!("{IN_PHASE} {words} COUP_R={ratio} COUP_A={}", Data::Real(angle).word()));
                }
                None => left.add(&format!("{PAIRED} {words} COUP_R={ratio}")),
            }
        }
        ("COUPOF" | "COUPOFS", [] | [_] | [_, _]) => {
            left.add(&format!("{UNPAIRED} {words}"));
            if name == "COUPOFS" {
                left.add(&format!("M{}=5", pair.0));
            }
        }
        ("COUPDEL", []) => {
            siemens.held.couplings.remove(&pair);
            left.add(&format!("{UNPAIRED} {words}"));
        }
        ("COUPRES", []) => {
            siemens.held.couplings.remove(&pair);
        }
        _ => return syntax(format!("{name} has too many arguments")),
    }
    Ok(true)
}

/// Number of a spindle: `S2`, `SPI(2)`, `2`.
fn spindle(
    siemens: &mut Siemens,
    host: &mut dyn InterpreterHost,
    statement: &str,
    argument: &SiemensArgument,
) -> Outcome<u8> {
    let text = argument.text.trim().trim_matches('"').to_ascii_uppercase();
    let inner = text.strip_prefix("SPI(").and_then(|rest| rest.strip_suffix(')'));
    let named = inner.or_else(|| text.strip_prefix('S')).and_then(|digits| digits.trim().parse::<u8>().ok());
    let number = match named {
        Some(number) => Some(f64::from(number)),
        None => number(siemens, host, Some(argument))?,
    };
    let known = |number: u8| host.is_code_text(&format!("M{number}=19"));
    match number.map(|number| (number, number as u8)) {
        Some((number, whole)) if f64::from(whole) == number && known(whole) => Ok(whole),
        _ => wrong_type(format!("the channel has no spindle {} for {statement}", argument.text.trim())),
    }
}

fn number(
    siemens: &mut Siemens,
    host: &mut dyn InterpreterHost,
    argument: Option<&SiemensArgument>,
) -> Outcome<Option<f64>> {
    let Some(argument) = argument else { return Ok(None) };
    Ok(siemens.argument(host, argument)?.and_then(|value| value.number()))
}
