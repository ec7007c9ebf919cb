//! The fitted robot in the numbers of its own description: nominal, change, calibrated, and 95 % interval.

use crate::document::{Block, Document, Only};
use crate::layout::Alignment::{Left, Right};
use crate::significant;
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
    /// Whether joints that are described by rows of Denavit and Hartenberg are given by origins, since no rows describe the fitted robot.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub by_origins: bool,
    /// Base, joints, tool and targets, in this order.
    pub parameters: Vec<ParameterSummary>,
    /// What has to be added to the reading of each joint, in degrees or mm: effective values, with what the joints yield on average.
    pub joint_zero_offsets: Vec<ParameterSummary>,
    /// The same apart, where the model has other effects beside its constants.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub zero_offsets_apart: Vec<OffsetApart>,
}

/// An effective zero offset as the zero of the joint and the mean of what else moves it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OffsetApart {
    /// The joint.
    pub joint: String,
    /// Unit of the numbers.
    pub unit: String,
    /// Effective value.
    pub effective: f64,
    /// The zero itself: the constant of the model.
    pub own: f64,
    /// Half width of its 95 % interval; null where it was not estimated.
    pub own_half_width_95: Option<f64>,
    /// Effective value minus the zero itself: the mean of all other effects over the poses of the fit.
    pub difference: f64,
    /// Half width of its 95 % interval; null where it was not estimated.
    pub difference_half_width_95: Option<f64>,
}

impl OffsetApart {
    fn row(&self) -> Vec<String> {
        let with = |value: f64, half: Option<f64>| {
            let shown = ParameterSummary {
                part: String::new(),
                parameter: String::new(),
                unit: self.unit.clone(),
                nominal: None,
                delta: None,
                calibrated: value,
                half_width_95: half,
                remark: String::new(),
            };
            let [_, _, value, half] = shown.cells();
            [value, half]
        };
        let [effective, _] = with(self.effective, self.difference_half_width_95);
        let ([own, of_own], [difference, of_difference]) =
            (with(self.own, self.own_half_width_95), with(self.difference, self.difference_half_width_95));
        vec![self.joint.clone(), effective, own, of_own, difference, of_difference, self.unit.clone()]
    }
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

    /// A table of poses and points, a row each: value ± half width of the 95 % interval; none of nothing.
    pub(crate) fn as_places(caption: &str, numbers: &[Self]) -> Option<Block> {
        let lines: Vec<&[Self]> = numbers.chunk_by(|a, b| a.part == b.part).collect();
        let longest = lines.iter().max_by_key(|line| line.len())?;
        let heads = longest.iter().map(|number| format!("{}, {}", number.parameter, number.unit));
        let head: Vec<String> = std::iter::once(String::new()).chain(heads).collect();
        let cell = |number: &Self| {
            let [.., value, half] = number.cells();
            if number.half_width_95.is_some() {
                format!("{value} ± {half}")
            } else {
                format!("{value} ({})", number.remark)
            }
        };
        let row = |line: &&[Self]| {
            let cells = std::iter::once(line[0].part.clone()).chain(line.iter().map(cell));
            cells.chain(std::iter::repeat(String::new())).take(head.len()).collect()
        };
        let sides: Vec<_> = std::iter::once(Left).chain(longest.iter().map(|_| Right)).collect();
        let rows = lines.iter().map(row).collect();
        Some(Block::Table { caption: caption.into(), head, sides, rows })
    }

    fn row(&self) -> Vec<String> {
        let [nominal, delta, calibrated, half] = self.cells();
        let part = vec![self.part.clone(), self.parameter.clone(), self.unit.clone()];
        [part, vec![nominal, delta, calibrated, half, self.remark.clone()]].concat()
    }
}

impl ParametersSummary {
    const HEAD: [&'static str; 8] =
        ["part", "parameter", "unit", "nominal", "Δ", "calibrated", "± 95 %", "remark"];
    const OFFSETS: [&'static str; 5] = ["joint", "effective zero offset", "± 95 %", "unit", "remark"];
    const APART: [&'static str; 7] =
        ["joint", "effective", "zero itself", "± 95 %", "difference", "± 95 %", "unit"];
    const OF_OFFSETS: &'static str = "Effective zero offsets of the joints, added to the reading of each; valid together with the parameters above, and not for mastering";
    const OF_APART: &'static str = "Zero offsets apart: the zero of each joint itself, and what the other effects of the model add to it on average over the poses of the fit";

    /// Base, tool and targets that were found, by their words.
    pub fn found(&self, words: &[String]) -> Vec<ParameterSummary> {
        self.parameters.iter().filter(|row| words.contains(&row.part)).cloned().collect()
    }

    /// Rows of the list of zero offsets.
    fn offsets(&self) -> Vec<Vec<String>> {
        let row = |offset: &ParameterSummary| {
            let [_, _, value, half] = offset.cells();
            vec![offset.part.clone(), value, half, offset.unit.clone(), offset.remark.clone()]
        };
        self.joint_zero_offsets.iter().map(row).collect()
    }

    /// What effective zero offsets are.
    fn of_offsets(&self) -> &'static str {
        match self.left_out.is_empty() {
            true => {
                "The model has constants alone: what the joints yield on average is in these offsets. They are no errors of the encoders."
            }
            false => {
                "These offsets contain the mean of all other effects over the poses of the fit. They are no errors of the encoders."
            }
        }
    }

    /// What the table is, and the frames of its rows.
    fn note(&self) -> String {
        const FRAMES: &str = "Rows of the base: its place in the measurement frame; of joints: as in the robot file; of the tool: its place on the flange; \
                              of targets: in the tool's axes.";
        const ORIGINS: &str = " No rows of Denavit and Hartenberg describe the fitted robot: its joints are given by their origins at zero, each in the frame of \
                               the one before, with z as the axis.";
        let origins = if self.by_origins { ORIGINS } else { "" };
        if self.left_out.is_empty() {
            return format!("These parameters are the whole fitted model. {FRAMES}{origins}");
        }
        format!(
            "Constant parameters cannot carry: {}. These are the least-squares projection of the whole model at the poses of the fit. {FRAMES}{origins}",
            self.left_out.join(", ")
        )
    }
}

impl ParametersSummary {
    /// The table of parameters and those of the zero offsets, or why there is none.
    pub(crate) fn document(&self) -> Document {
        let mut document = Document::default();
        if let Some(why) = &self.absent {
            document.push(Only::Both, Block::Gap);
            document.sentence(&format!("There is no table of parameters: {why}."));
            return document;
        }
        let sides = [Left, Left, Left, Right, Right, Right, Right, Left];
        let caption =
            "parameters in the convention and the units of the robot file, with 95 % confidence intervals";
        document.table(
            caption,
            &Self::HEAD,
            &sides,
            self.parameters.iter().map(ParameterSummary::row).collect(),
        );
        document.note(self.note());
        let sides = [Left, Right, Right, Left, Left];
        document.table(Self::OF_OFFSETS, &Self::OFFSETS, &sides, self.offsets());
        document.note(self.of_offsets());
        if !self.zero_offsets_apart.is_empty() {
            let sides = [Left, Right, Right, Right, Right, Right, Left];
            let rows = self.zero_offsets_apart.iter().map(OffsetApart::row).collect();
            document.table(Self::OF_APART, &Self::APART, &sides, rows);
        }
        document
    }
}

impl fmt::Display for ParametersSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.document().fmt(f)
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
