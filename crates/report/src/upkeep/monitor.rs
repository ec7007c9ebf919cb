//! The summary of a look at a robot.

use super::{quantity, size};
use crate::wording::p_text;
use crate::{Correction, SpecificationSummary, millimetres, significant, value_with_interval};
use serde::Serialize;
use std::fmt;
use truepose_errormodel::Dataset;
use truepose_identify::Residuals;
use truepose_upkeep::{Change, Coefficient, Detectable, Look, Part};

/// Changes that are shown when there is an alarm, and detectable changes that are always shown.
const SHOWN: usize = 5;

/// The change of a constant error, or of an effect, if it alone has changed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChangeSummary {
    /// What.
    pub what: String,
    /// What no measurement at these poses tells from it.
    pub also: Vec<String>,
    /// Family of the effect.
    pub family: String,
    /// Change of each coefficient, with its 95 % interval.
    pub coefficients: Vec<Coefficient>,
    /// RMS by which it moves the measured positions, mm.
    pub moves_mm: f64,
    /// p of this suspect alone.
    pub p_value: f64,
    /// Whether these poses cannot tell it from the first one.
    pub tied: bool,
}

/// The smallest change that these poses show.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DetectableSummary {
    /// What.
    pub what: String,
    /// Change of one coefficient found with 90 % probability.
    pub change: f64,
    /// Its unit.
    pub unit: String,
    /// RMS by which that moves the measured positions, mm.
    pub moves_mm: f64,
}

/// The part of the installation that explains a change alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SetUpAnew {
    /// `base`, `tool` or `targets`; the option of `monitor` that finds it anew has the same word.
    pub part: &'static str,
    /// p that is left when it is found anew.
    pub p_value: f64,
}

impl SetUpAnew {
    fn of(part: Part, p_value: f64) -> Self {
        let part = match part {
            Part::Base => "base",
            Part::Tool => "tool",
            Part::Targets => "targets",
        };
        SetUpAnew { part, p_value }
    }

    /// For a person: what may have happened, and what to do.
    fn text(&self) -> String {
        let p = p_text(self.p_value);
        let part = self.part;
        let (happened, moved) = match part {
            "base" => ("the instrument or the robot was set up anew", "neither was moved"),
            "tool" => ("another tool was mounted, or the tool anew", "the tool was not touched"),
            _ => ("the targets were mounted anew", "no target was touched"),
        };
        format!(
            "Most likely {happened}: with the {part} found anew nothing else has changed ({p}). Repeat with --{part}.\n\
             If {moved}, the change is in the arm, as follows."
        )
    }
}

/// Everything that is shown of a look.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MonitorSummary {
    /// Name of the robot.
    pub robot: String,
    /// Number of this look, from one.
    pub look: usize,
    /// Rows of data.
    pub rows: usize,
    /// Pose measurements.
    pub poses: usize,
    /// The verdict.
    pub changed: bool,
    /// p of this look.
    pub p_value: f64,
    /// Its level.
    pub level: f64,
    /// Probability that an unchanged robot ever raises an alarm, over all looks.
    pub alpha: f64,
    /// RMS of the residual, mm.
    pub rms_mm: f64,
    /// RMS that an unchanged robot would have, mm.
    pub expected_rms_mm: f64,
    /// What was found anew.
    pub found: Vec<String>,
    /// The part of the installation that alone explains the change.
    pub set_up_anew: Option<SetUpAnew>,
    /// Suspects, the best first.
    pub changes: Vec<ChangeSummary>,
    /// What change would be found, the least visible first.
    pub detectable: Vec<DetectableSummary>,
    /// Suspects that these poses cannot show.
    pub invisible: Vec<String>,
    /// When the robot was measured, year-month-day, where it is stated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Measured poses against a specification, each as the fit predicts it; where one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub specification: Option<SpecificationSummary>,
}

impl MonitorSummary {
    /// Summary of look number `look` (from one) at this error rate.
    pub fn new(robot: &str, seen: &Look, look: usize, alpha: f64) -> Self {
        let change = |(k, change): (usize, &Change)| ChangeSummary {
            what: change.what.clone(),
            also: change.also.clone(),
            family: change.family.clone(),
            coefficients: change.coefficients.clone(),
            moves_mm: 1e3 * change.moves,
            p_value: change.p_value,
            tied: k < seen.tied,
        };
        let detectable = |one: &Detectable| DetectableSummary {
            what: one.what.clone(),
            change: one.change,
            unit: one.unit.clone(),
            moves_mm: 1e3 * one.moves,
        };
        MonitorSummary {
            robot: robot.into(),
            look,
            rows: seen.rows,
            poses: seen.poses,
            changed: seen.changed,
            p_value: seen.p_value,
            level: seen.level,
            alpha,
            rms_mm: 1e3 * seen.rms,
            expected_rms_mm: 1e3 * seen.expected,
            found: seen.placed.clone(),
            set_up_anew: seen.set_up_anew.map(|(part, p)| SetUpAnew::of(part, p)),
            changes: seen.changes.iter().enumerate().map(change).collect(),
            detectable: seen.detectable.iter().map(detectable).collect(),
            invisible: seen.invisible.clone(),
            date: None,
            specification: None,
        }
    }

    /// The same, with the measured poses compared with a limit of the distance to where the fit predicts them, m.
    #[must_use]
    pub fn with_specification(self, limit: f64, data: &Dataset, errors: &Residuals) -> Self {
        let rows: Vec<usize> = (0..data.len()).collect();
        let worst = crate::poses::largest_error_and_uncertainty_by_pose(data, &rows, errors);
        let alone: Vec<f64> = worst.iter().map(|pose| pose.0).collect();
        let of = SpecificationSummary::new(limit, &alone).with_guard_band(&worst);
        let specification = Some(SpecificationSummary { correction: Correction::Commands, ..of });
        MonitorSummary { specification, ..self }
    }

    /// The verdict in one sentence.
    pub fn verdict(&self) -> String {
        let p = p_text(self.p_value);
        let level = significant(self.level, 2);
        match self.changed {
            false => format!(
                "No change: {p}, level of this look {level} (look {}, {} % over all looks).",
                self.look,
                significant(100.0 * self.alpha, 2)
            ),
            true => {
                format!("The robot has changed: {p}, level of this look {level} (look {}).", self.look)
            }
        }
    }
}

impl fmt::Display for MonitorSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: {}\n", self.robot, size(self.rows, self.poses))?;
        writeln!(f, "{}", self.verdict())?;
        writeln!(
            f,
            "Residual: {} RMS; an unchanged robot has {}.",
            millimetres(1e-3 * self.rms_mm),
            millimetres(1e-3 * self.expected_rms_mm)
        )?;
        if let Some(specification) = &self.specification {
            writeln!(f, "{}", specification.sentence())?;
        }
        if !self.found.is_empty() {
            writeln!(f, "Found anew from these data: {}.", self.found.join(", "))?;
        }
        if let Some(anew) = &self.set_up_anew {
            writeln!(f, "\n{}", anew.text())?;
        }
        if self.changed {
            let tied = self.changes.iter().filter(|change| change.tied).count();
            writeln!(f)?;
            for change in self.changes.iter().take(tied.clamp(1, SHOWN)) {
                let coefficients: Vec<String> = change
                    .coefficients
                    .iter()
                    .map(|c| {
                        let half = 0.5 * (c.ci95[1] - c.ci95[0]);
                        let (value, half, unit) = value_with_interval(c.change, half, &c.unit);
                        format!("{}: {value} ± {half} {unit}", c.name)
                    })
                    .collect();
                writeln!(
                    f,
                    "{}: moves the measured positions by {} RMS ({})",
                    change.what,
                    millimetres(1e-3 * change.moves_mm),
                    p_text(change.p_value)
                )?;
                if !change.also.is_empty() {
                    writeln!(f, "   the same for these poses: {}", change.also.join(", "))?;
                }
                coefficients.iter().take(SHOWN).try_for_each(|text| writeln!(f, "   change of {text}"))?;
            }
            if tied > 1 {
                writeln!(f, "These poses do not tell {} from each other.", crate::count(tied, "suspect"))?;
            }
        }
        if !self.detectable.is_empty() {
            writeln!(f, "\nFound with 90 % probability by these poses, the least visible changes:")?;
            for one in self.detectable.iter().take(SHOWN) {
                writeln!(
                    f,
                    "   {}: {} ({} RMS at these poses)",
                    one.what,
                    quantity(one.change, &one.unit),
                    millimetres(1e-3 * one.moves_mm)
                )?;
            }
        }
        if !self.invisible.is_empty() {
            writeln!(f, "Not visible with these poses: {}.", self.invisible.join(", "))?;
        }
        Ok(())
    }
}
