//! Joint values that are evidently in another unit than that of their header.

use super::columns::Column;
use std::f64::consts::PI;
use truepose_kinematics::{Chain, Joint, JointId, JointKind};

/// Nobody turns a joint without limits further than two turns to either side.
const TWO_TURNS: f64 = 4.0 * PI;

/// What one joint's values may be.
#[derive(Debug, Clone)]
pub(crate) struct Plausible {
    kind: JointKind,
    limits: Option<(f64, f64)>,
    /// Values in between need no further look.
    pub lower: f64,
    pub upper: f64,
}

impl Plausible {
    /// Of the values that the controller reports of a joint.
    pub fn of(chain: &Chain, joint: JointId) -> Self {
        Plausible::new(&Joint { limits: chain.controller_limits(joint), ..chain.joint(joint).clone() })
    }

    pub fn new(joint: &Joint) -> Self {
        let limits = joint.limits.filter(|(lower, upper)| lower.is_finite() && upper.is_finite());
        let (lower, upper) = match (limits, joint.kind) {
            // A millionth of the range above the limit is rounding.
            (Some((lower, upper)), _) => {
                let slack = 1e-6 * (upper - lower).max(1e-3);
                (lower - slack, upper + slack)
            }
            (None, JointKind::Prismatic) => (f64::NEG_INFINITY, f64::INFINITY),
            (None, _) => (-TWO_TURNS, TWO_TURNS),
        };
        Plausible { kind: joint.kind, limits, lower, upper }
    }

    /// Judges a value (SI) outside of `lower … upper`; passing means that it is merely beyond the limits.
    ///
    /// # Errors
    /// Why it cannot be meant in its unit.
    pub fn judge(&self, value: f64, column: &Column) -> Result<(), String> {
        let raw = format!("{} {}", column.conversion.from_si(value), column.unit);
        let near = |value: f64, (lower, upper): (f64, f64)| {
            let slack = 0.05 * (upper - lower);
            (lower - slack..=upper + slack).contains(&value)
        };
        let Some((lower, upper)) = self.limits else {
            let hint = if column.unit == "rad" {
                format!("looks like degrees; if so, call the column `{}[deg]`", column.name)
            } else {
                "is not plausible; check the unit".into()
            };
            return Err(format!(
                "{raw} is beyond any plausible turn and {hint}. A joint that really turns further than two turns \
                 needs `limits` in the robot description"
            ));
        };
        let reach = lower.abs().max(upper.abs());
        let limits = format!(
            "the joint's limits, {} … {} {}",
            rounded(column.conversion.from_si(lower)),
            rounded(column.conversion.from_si(upper)),
            column.unit
        );
        let far = value.abs() > 2.0 * reach + 0.1;
        match (self.kind, column.unit.as_str()) {
            (JointKind::Revolute, "rad") if far && near(value.to_radians(), (lower, upper)) => Err(format!(
                "{raw} is far beyond {limits}, and looks like degrees; if so, call the column `{}[deg]`",
                column.name
            )),
            (JointKind::Prismatic, "m") if far && near(value / 1e3, (lower, upper)) => Err(format!(
                "{raw} is far beyond {limits}, and looks like millimetres; if so, call the column `{}[mm]`",
                column.name
            )),
            (JointKind::Revolute, _) if value.abs() > reach + TWO_TURNS => {
                Err(format!("{raw} is beyond any plausible turn and far beyond {limits}; check the unit"))
            }
            _ => Ok(()),
        }
    }

    /// Whether all values of a column, given by its smallest and largest (SI), look as if they were in the larger
    /// unit: `[deg]` that are radians, `[mm]` that are metres. None where a joint does not tell.
    pub fn looks_too_small(&self, smallest: f64, largest: f64, unit: &str) -> Option<bool> {
        let most = smallest.abs().max(largest.abs());
        let moved = largest - smallest > 0.0;
        let range = self.limits.map(|(lower, upper)| upper - lower);
        match (self.kind, unit) {
            (JointKind::Revolute, "deg") if moved && range.is_none_or(|range| range > PI / 3.0) => {
                Some(most <= (2.0 * PI).to_radians())
            }
            (JointKind::Prismatic, "mm") if moved && range.is_some_and(|range| range > 0.1) => {
                self.limits.map(|(lower, upper)| most <= 1.05e-3 * lower.abs().max(upper.abs()))
            }
            _ => None,
        }
    }
}

/// A number for a message, without the noise of a conversion.
pub(crate) fn rounded(value: f64) -> String {
    if value.abs() >= 1e9 {
        return format!("{value:.1e}");
    }
    let text = format!("{value:.4}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    fn judge(robot: &truepose_kinematics::Chain, header: &str, raw: f64) -> Result<bool, String> {
        let (column, _) = Column::parse(header, robot, 0).unwrap();
        let plausible = Plausible::new(robot.joint(robot.joint_named(&column.name).unwrap()));
        let value = column.conversion.to_si(raw);
        if value >= plausible.lower && value <= plausible.upper {
            return Ok(true);
        }
        plausible.judge(value, &column).map(|()| false)
    }

    #[test]
    fn degrees_under_rad() {
        let (pps, skewed) = (samples::pps(), samples::skewed());
        assert_eq!(judge(&pps, "theta[rad]", 1.5), Ok(true));
        assert_eq!(judge(&pps, "theta[rad]", 1.7), Ok(false));
        assert_eq!(judge(&pps, "theta[deg]", 89.0), Ok(true));
        assert_eq!(
            judge(&pps, "theta[rad]", -45.0).unwrap_err(),
            "-45 rad is far beyond the joint's limits, -1.5708 … 1.5708 rad, and looks like degrees; if so, call the \
             column `theta[deg]`"
        );
        assert_eq!(
            judge(&pps, "roll[rad]", 2.5).unwrap_err(),
            "2.5 rad is far beyond the joint's limits, -0.0524 … 0.0524 rad, and looks like degrees; if so, call the \
             column `roll[deg]`"
        );
        assert_eq!(
            judge(&skewed, "s1[rad]", 45.0).unwrap_err(),
            "45 rad is beyond any plausible turn and looks like degrees; if so, call the column `s1[deg]`. A joint that \
             really turns further than two turns needs `limits` in the robot description"
        );
        assert!(judge(&skewed, "s1[deg]", 900.0).unwrap_err().contains("is not plausible; check the unit"));
        assert!(judge(&pps, "theta[deg]", 1e300).unwrap_err().contains("check the unit"));
    }

    #[test]
    fn millimetres_under_m() {
        let pps = samples::pps();
        assert_eq!(judge(&pps, "d1[m]", 1.3), Ok(false));
        assert_eq!(
            judge(&pps, "d1[m]", 900.0).unwrap_err(),
            "900 m is far beyond the joint's limits, -1.125 … 1.125 m, and looks like millimetres; if so, call the \
             column `d1[mm]`"
        );
        assert_eq!(judge(&samples::skewed(), "s2[m]", 900.0), Ok(true));
    }

    #[test]
    fn radians_under_deg() {
        let plausible = |k: usize| Plausible::new(&samples::pps().joints()[k]);
        assert_eq!(plausible(3).looks_too_small(-0.02, 0.03, "deg"), Some(true));
        assert_eq!(plausible(3).looks_too_small(-0.02, 1.5, "deg"), Some(false));
        assert_eq!(plausible(4).looks_too_small(-0.02, 0.03, "deg"), None);
        assert_eq!(plausible(0).looks_too_small(-0.001, 0.001, "mm"), Some(true));
        assert_eq!(plausible(0).looks_too_small(-1.0, 0.001, "mm"), Some(false));
    }
}
