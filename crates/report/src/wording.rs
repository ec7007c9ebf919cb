//! Numbers, parameters, warnings and advice as text.

use truepose_discover::Parameter;
use truepose_identify::{Advice, Refusal, Warning};
use truepose_kinematics::Chain;

/// A number with so many significant digits and no exponent where that can be read.
pub fn significant(value: f64, digits: usize) -> String {
    if value.is_nan() {
        return "–".into();
    }
    if value.abs() < f64::MIN_POSITIVE {
        return "0".into();
    }
    let magnitude = value.abs().log10().floor() as i32;
    if !(-5..7).contains(&magnitude) {
        return format!("{value:.*e}", digits - 1);
    }
    let decimals = (digits as i32 - 1 - magnitude).max(0) as usize;
    format!("{value:.decimals$}")
}

/// `p = 0.012`; what is below all numbers is no zero.
pub fn p_text(p: f64) -> String {
    if p < f64::MIN_POSITIVE { "p < 1e-300".into() } else { format!("p = {}", significant(p, 2)) }
}

/// A length in millimetres.
pub fn millimetres(metres: f64) -> String {
    format!("{} mm", significant(metres * 1e3, 3))
}

/// `3 rows`, `1 row`.
pub fn count(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

/// The first line of a text: `welder: 300 rows, 100 pose measurements`.
pub(crate) fn heading(robot: &str, rows: usize, poses: usize) -> String {
    format!("{robot}: {}, {}", count(rows, "row"), count(poses, "pose measurement"))
}

/// A coefficient with the half width of its interval, in the unit that people use for it: mm, mrad, µrad/(N*m) …
pub fn value_with_interval(value: f64, half_width: f64, unit: &str) -> (String, String, String) {
    let (factor, shown) = match unit {
        "m" => (1e3, "mm".to_string()),
        "rad" => (1e3, "mrad".to_string()),
        _ if unit.starts_with("rad/") => (1e6, format!("µ{unit}")),
        _ if unit.starts_with("m/") => (1e6, format!("µ{unit}")),
        _ => (1.0, unit.to_string()),
    };
    let (value, half) = (value * factor, half_width * factor);
    if half <= 0.0 || !half.is_finite() {
        return (significant(value, 4), "–".into(), shown);
    }
    // As many decimals as the interval has two significant digits of.
    let decimals = (1 - half.log10().floor() as i32).clamp(0, 9) as usize;
    (format!("{value:.decimals$}"), format!("{half:.decimals$}"), shown)
}

/// A parameter with its interval, and its unit: `0.21 ± 0.02`, or `3014 (3002 to 3027)` where the interval is not centred.
/// Periods of a revolute joint are in degrees.
pub fn parameter_text(parameter: &Parameter) -> (String, String) {
    let degrees = parameter.name.starts_with("period") && parameter.unit == "rad";
    let factor = if degrees { 180.0 / std::f64::consts::PI } else { 1.0 };
    let unit = if degrees { "°" } else { &parameter.unit };
    let [lower, upper] = parameter.ci95.map(|end| end * factor);
    let value = parameter.value * factor;
    let half = 0.5 * (upper - lower);
    if (value - lower - half).abs() <= 1e-6 * half {
        let (value, half, unit) = value_with_interval(value, half, unit);
        return (format!("{value} ± {half}"), unit);
    }
    let (value, _, shown) = value_with_interval(value, 0.1 * half, unit);
    let ends = [lower, upper].map(|end| value_with_interval(end, 0.1 * half, unit).0);
    (format!("{value} ({} to {})", ends[0], ends[1]), shown)
}

/// A warning of a fit as a sentence, with what to do.
pub fn warning_text(warning: &Warning) -> String {
    match warning {
        Warning::UnclearRank { structural: true, gap } => format!(
            "the singular values over the whole workspace show no clear gap where the rank was cut (ratio {}): the \
             groups depend on the tolerance",
            significant(*gap, 2)
        ),
        Warning::UnclearRank { structural: false, gap } => format!(
            "the singular values of this data show no clear gap where the rank was cut (ratio {}): which errors count \
             as not excited depends on the tolerance; measure more varied configurations",
            significant(*gap, 2)
        ),
        Warning::FewerRowsThanUnknowns { observations, unknowns } => format!(
            "{} for {}: errors that are not distinguishable were reduced to groups, and weakly determined groups are shrunk by the prior; \
             measure more configurations",
            count(*observations, "scalar observation"),
            count(*unknowns, "unknown")
        ),
        Warning::NotConverged { rounds, all } => {
            format!(
                "NOT CONVERGED: the fit still moved after {}; no figure of it is final, and coefficients and intervals may be far off. \
                 Measure more varied configurations, {}",
                count(*rounds, "iteration"),
                match all {
                    true => "declare fewer effects, or raise --rounds",
                    false => "or declare fewer effects; more rounds do not help, as no step made the fit better",
                }
            )
        }
        Warning::NoEffect { column } => format!(
            "`{column}` has no effect on anything in this data (no load declared, no link weights, or a signal that never \
             changes): it stays zero"
        ),
        Warning::NonlinearAtBound { effect, name, value } => format!(
            "the best `{name}` of effect `{effect}` is {}, at an end of its search range: widen the range, or \
             remove the effect",
            significant(*value, 6)
        ),
        Warning::OutOfBounds { column, value, bounds: [lower, upper] } => format!(
            "`{column}` is {}, outside of [{lower}, {upper}] by more than its interval: `--solver bounded(qr)` enforces the bounds; \
             the model may lack another effect",
            significant(*value, 3)
        ),
        Warning::LeftOut { effect, column } => {
            format!("the solver removed the whole effect `{effect}` (`{column}` …)")
        }
        Warning::FellBack { solver, why: Refusal::Objective } => format!(
            "`{solver}` was rejected: its residual by a robust measure is larger than that of ordinary least squares; this is the fit of `qr`"
        ),
        Warning::FellBack { solver, why: Refusal::HeldOut(ratio) } => format!(
            "`{solver}` was rejected: it predicts held-out configurations worse than ordinary least squares, by a factor of {} \
             (errors limited to three medians); this is the fit of `qr`",
            significant(*ratio, 3)
        ),
        Warning::WorseThanPlain { solver, ratio } => format!(
            "`{solver}` predicts held-out configurations worse than ordinary least squares (`qr`), by a factor of {} (errors \
             limited to three medians)",
            significant(*ratio, 3)
        ),
        Warning::NoRedundancy => {
            "there are no more scalar observations than grouped errors: the residual does not estimate the accuracy".into()
        }
        other => format!("{other:?}"),
    }
}

/// `move j5 over more than 12° (it can move over 350°)`.
pub fn advice_text(chain: &Chain, advice: &Advice) -> String {
    let joint = chain.joint(advice.joint);
    let show = |width: f64| {
        if joint.unit() == "m" {
            format!("{} mm", significant(width * 1e3, 3))
        } else {
            format!("{}°", significant(width.to_degrees(), 3))
        }
    };
    let seen = advice.seen.upper - advice.seen.lower;
    let possible = advice.possible.upper - advice.possible.lower;
    let gain = count(advice.gains, "more direction");
    if seen < 1e-9 {
        return format!(
            "move {}: it never moves in this data (possible: {}); makes {gain} identifiable",
            joint.name,
            show(possible)
        );
    }
    format!(
        "move {} over more than {} (possible: {}); makes {gain} identifiable",
        joint.name,
        show(seen),
        show(possible)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_significant_digits_and_units() {
        assert_eq!(significant(0.11234, 4), "0.1123");
        assert_eq!(significant(1234.5, 4), "1234");
        assert_eq!(significant(0.0, 4), "0");
        assert_eq!(significant(2.0e-9, 3), "2.00e-9");
        let (value, half, unit) = value_with_interval(1.23456e-3, 1.7e-5, "m");
        assert_eq!((value.as_str(), half.as_str(), unit.as_str()), ("1.235", "0.017", "mm"));
        let (value, half, unit) = value_with_interval(3.21e-6, 4.4e-7, "rad/(N*m)");
        assert_eq!((value.as_str(), half.as_str(), unit.as_str()), ("3.21", "0.44", "µrad/(N*m)"));
    }

    #[test]
    fn a_p_below_all_numbers_is_no_zero() {
        assert_eq!([0.0, 1.4e-6, 0.5].map(p_text), ["p < 1e-300", "p = 1.4e-6", "p = 0.50"]);
    }

    #[test]
    fn more_rounds_are_advised_where_they_were_used_up() {
        let words = |all| warning_text(&Warning::NotConverged { rounds: 28, all });
        assert!(words(true).contains("raise --rounds") && !words(false).contains("--rounds"));
    }
}
