//! Numbers and findings in words.

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

/// A length in millimetres.
pub fn millimetres(metres: f64) -> String {
    format!("{} mm", significant(metres * 1e3, 3))
}

/// An angle in milliradians.
pub fn milliradians(radians: f64) -> String {
    format!("{} mrad", significant(radians * 1e3, 3))
}

/// `3 rows`, `1 row`.
pub fn count(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
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

/// A size of a find with its interval, and its unit: `0.21 ± 0.02`, or `3014 (3002 to 3027)` where the interval is not centred. Periods
/// of a turning joint are in degrees.
pub fn parameter_words(parameter: &Parameter) -> (String, String) {
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

/// A warning of a fit as a sentence that says what to do.
pub fn warning_words(warning: &Warning) -> String {
    match warning {
        Warning::UnclearRank { structural: true, gap } => format!(
            "the singular values over the whole workspace show no clear gap where the rank was cut (ratio {}): the \
             groups depend on the tolerance",
            significant(*gap, 2)
        ),
        Warning::UnclearRank { structural: false, gap } => format!(
            "the singular values of this data show no clear gap where the rank was cut (ratio {}): which errors count \
             as not excited depends on the tolerance; more varied configurations would settle it",
            significant(*gap, 2)
        ),
        Warning::FewerRowsThanUnknowns { observations, unknowns } => format!(
            "{} for {}: errors that cannot be told apart were reduced to groups, and what is left is held by the prior; \
             measure more configurations",
            count(*observations, "measured number"),
            count(*unknowns, "unknown")
        ),
        Warning::NotConverged { rounds } => {
            format!(
                "NOT CONVERGED: the fit still moved after {}; no figure of it is final, and coefficients and intervals may be far off. \
                 Measure more varied configurations, declare fewer effects, or raise --rounds",
                count(*rounds, "round")
            )
        }
        Warning::NoEffect { column } => format!(
            "`{column}` has no effect on anything in this data (no load declared, no link weights, or a signal that never \
             changes): it stays zero"
        ),
        Warning::NonlinearAtBound { effect, name, value } => format!(
            "the best `{name}` of effect `{effect}` is {}, at an end of the range in which it was looked for: widen the range, or \
             doubt the effect",
            significant(*value, 6)
        ),
        Warning::OutOfBounds { column, value, bounds: [lower, upper] } => format!(
            "`{column}` is {}, outside of [{lower}, {upper}] by more than its interval: `--solver bounded(qr)` holds it, and \
             something else in the model may be missing",
            significant(*value, 3)
        ),
        Warning::LeftOut { effect, column } => {
            format!("the solver left the effect `{effect}` out as a whole (`{column}` …)")
        }
        Warning::FellBack { solver, why: Refusal::Objective } => format!(
            "`{solver}` was refused: by a robust measure it leaves more of this data than plain least squares does; this is the fit of `qr`"
        ),
        Warning::FellBack { solver, why: Refusal::HeldOut(ratio) } => format!(
            "`{solver}` was refused: it predicts configurations that it did not see worse than plain least squares, by a factor of {} \
             (errors beyond three medians bounded); this is the fit of `qr`",
            significant(*ratio, 3)
        ),
        Warning::WorseThanPlain { solver, ratio } => format!(
            "`{solver}` predicts configurations that it did not see worse than plain least squares (`qr`), by a factor of {} (errors \
             beyond three medians bounded)",
            significant(*ratio, 3)
        ),
        Warning::NoRedundancy => {
            "there are no more measured numbers than grouped errors: the residual says nothing about the accuracy".into()
        }
        other => format!("{other:?}"),
    }
}

/// `move j5 over more than 12° (it can move over 350°)`.
pub fn advice_words(chain: &Chain, advice: &Advice) -> String {
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
            "move {}: it never moved in this data (it can over {}); determines {gain}",
            joint.name,
            show(possible)
        );
    }
    format!(
        "move {} over more than {} (up to {} is possible); determines {gain}",
        joint.name,
        show(seen),
        show(possible)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(significant(0.11234, 4), "0.1123");
        assert_eq!(significant(1234.5, 4), "1234");
        assert_eq!(significant(0.0, 4), "0");
        assert_eq!(significant(2.0e-9, 3), "2.00e-9");
        let (value, half, unit) = value_with_interval(1.23456e-3, 1.7e-5, "m");
        assert_eq!((value.as_str(), half.as_str(), unit.as_str()), ("1.235", "0.017", "mm"));
        let (value, half, unit) = value_with_interval(3.21e-6, 4.4e-7, "rad/(N*m)");
        assert_eq!((value.as_str(), half.as_str(), unit.as_str()), ("3.21", "0.44", "µrad/(N*m)"));
    }
}
