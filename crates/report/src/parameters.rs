//! The fitted robot in the numbers of its own description: nominal, change, calibrated, and 95 % interval.

use crate::layout::Alignment::{Left, Right};
use crate::{significant, table};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Parameters of a fitted robot.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ParametersSummary {
    /// Why there is no table, where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub absent: Option<String>,
    /// Families of the effects that constant parameters cannot carry; the table is the projection of the whole model.
    pub left_out: Vec<String>,
    /// Base, joints, tool and targets, in this order.
    pub parameters: Vec<ParameterSummary>,
    /// What has to be added to the reading of each joint, in degrees or mm.
    pub joint_zero_offsets: Vec<ParameterSummary>,
}

/// One number of the description.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ParameterSummary {
    /// Base, joint, tool or target.
    pub part: String,
    /// Its name in the robot file.
    pub parameter: String,
    /// Unit of the numbers: that of the robot file.
    pub unit: String,
    /// As described; null where the description has none.
    pub nominal: Option<f64>,
    /// Calibrated minus nominal.
    pub delta: Option<f64>,
    /// As fitted.
    pub calibrated: f64,
    /// Half width of the 95 % interval; null where the number was not estimated.
    pub half_width_95: Option<f64>,
    /// Why it was not estimated; empty where it was.
    pub remark: String,
}

impl ParameterSummary {
    /// Nominal, change, calibrated and interval as text, in one rounding: as many decimals as the interval has two significant digits of.
    pub fn cells(&self) -> [String; 4] {
        let decimals = match self.half_width_95 {
            Some(half) if half > 0.0 => (1 - half.log10().floor() as i32).clamp(0, 7) as usize,
            _ if self.unit == "m" || self.unit == "rad" => 6,
            _ => 4,
        };
        let shown = |value: f64| {
            let text = format!("{value:.decimals$}");
            // No sign in front of zero.
            if text.trim_start_matches(['-', '0', '.']).is_empty() { text.replace('-', "") } else { text }
        };
        let none = || "–".to_owned();
        [
            self.nominal.map_or_else(none, shown),
            self.delta.map_or_else(none, shown),
            shown(self.calibrated),
            self.half_width_95.map_or_else(none, |half| match half {
                half if half > 1e7 => significant(half, 2),
                half => shown(half),
            }),
        ]
    }

    fn row(&self) -> Vec<String> {
        let [nominal, delta, calibrated, half] = self.cells();
        let part = vec![self.part.clone(), self.parameter.clone(), self.unit.clone()];
        [part, vec![nominal, delta, calibrated, half, self.remark.clone()]].concat()
    }
}

impl ParametersSummary {
    pub(crate) const HEAD: [&'static str; 8] =
        ["part", "parameter", "unit", "nominal", "Δ", "calibrated", "± 95 %", "remark"];
    pub(crate) const OFFSETS: [&'static str; 5] = ["joint", "zero offset", "± 95 %", "unit", "remark"];

    /// Rows of the table.
    pub(crate) fn rows(&self) -> Vec<Vec<String>> {
        self.parameters.iter().map(ParameterSummary::row).collect()
    }

    /// Rows of the list of zero offsets.
    pub(crate) fn offsets(&self) -> Vec<Vec<String>> {
        let row = |offset: &ParameterSummary| {
            let [_, _, value, half] = offset.cells();
            vec![offset.part.clone(), value, half, offset.unit.clone(), offset.remark.clone()]
        };
        self.joint_zero_offsets.iter().map(row).collect()
    }

    /// What the table is.
    pub(crate) fn note(&self) -> String {
        if self.left_out.is_empty() {
            return "These parameters are the whole fitted model.".into();
        }
        format!(
            "Constant parameters cannot carry: {}. These are the least-squares projection of the whole model at the poses of the fit.",
            self.left_out.join(", ")
        )
    }
}

impl fmt::Display for ParametersSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "\nparameters of the robot, as it is described")?;
        if let Some(why) = &self.absent {
            return writeln!(f, " none: {why}");
        }
        let sides = [Left, Left, Left, Right, Right, Right, Right, Left];
        write!(f, "{}", table(&Self::HEAD, &sides, &self.rows()))?;
        writeln!(f, " {}", self.note())?;
        writeln!(
            f,
            "\nzero offsets of the joints (to be added to the reading; valid together with the parameters above)"
        )?;
        write!(f, "{}", table(&Self::OFFSETS, &[Left, Right, Right, Left, Left], &self.offsets()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(calibrated: f64, half: Option<f64>) -> ParameterSummary {
        ParameterSummary {
            part: "a2".into(),
            parameter: "a".into(),
            unit: "mm".into(),
            nominal: Some(-612.0),
            delta: Some(calibrated + 612.0),
            calibrated,
            half_width_95: half,
            remark: String::new(),
        }
    }

    #[test]
    fn all_numbers_of_a_row_have_the_decimals_of_its_interval() {
        assert_eq!(parameter(-612.345678, Some(0.0123)).cells(), ["-612.000", "-0.346", "-612.346", "0.012"]);
        assert_eq!(parameter(-612.345678, Some(12.3)).cells(), ["-612", "0", "-612", "12"]);
        assert_eq!(parameter(-612.0, None).cells(), ["-612.0000", "0.0000", "-612.0000", "–"]);
    }

    #[test]
    fn the_table_shows_why_a_number_did_not_change() {
        let mut fixed = parameter(-612.0, None);
        fixed.remark = "part of base".into();
        let summary = ParametersSummary {
            parameters: vec![parameter(-612.3, Some(0.02))],
            joint_zero_offsets: vec![fixed],
            ..ParametersSummary::default()
        };
        let text = summary.to_string();
        assert!(text.contains("a2    a          mm    -612.000  -0.300    -612.300   0.020"), "{text}");
        assert!(text.contains("part of base") && text.contains("whole fitted model"), "{text}");
    }
}
