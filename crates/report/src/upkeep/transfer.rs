//! The summary of a transfer.

use super::{quantity, row_words};
use crate::wording::heading;
use crate::wording::p_text;
use crate::{PositionStatistics, millimetres, significant};
use serde::Serialize;
use std::fmt;
use truepose_errormodel::{Dataset, Visits};
use truepose_kinematics::{Chain, JointKind};
use truepose_upkeep::{Band, Transfer};

/// Level below which the arm is reported not to fit.
const LEVEL: f64 = 0.01;

/// Whether the arm as identified explains the new measurements.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ArmFitsSummary {
    /// True, false, or null where nothing is left to test it with.
    pub fits: Option<bool>,
    /// p of the residual.
    pub p_value: Option<f64>,
    /// Its chi-square.
    pub chi_square: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Row (1-based) with the largest residual, in standard deviations.
    pub worst_row: Option<usize>,
    /// That residual in standard deviations.
    pub worst_in_sd: Option<f64>,
}

/// Standard deviation of one coordinate of the installation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct InstallationSummary {
    /// Coordinate, e.g. `x@base`.
    pub name: String,
    /// Standard deviation.
    pub sd: f64,
    /// m or rad.
    pub unit: String,
}

/// 3-D standard deviation of predicted positions over the configurations of the fit, mm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct BandSummary {
    /// Root mean square.
    pub rms_mm: f64,
    /// Largest.
    pub max_mm: f64,
}

impl From<Band> for BandSummary {
    fn from(band: Band) -> Self {
        BandSummary { rms_mm: 1e3 * band.rms, max_mm: 1e3 * band.max }
    }
}

/// A configuration to measure next.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AdvisedSummary {
    /// Joint values, deg or mm, in the order of the robot.
    pub joints: Vec<f64>,
    /// What the installation leaves open with this one and those before it, RMS, mm.
    pub band_mm: f64,
}

/// Everything that is shown of a transfer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct TransferSummary {
    /// Name of the robot.
    pub robot: String,
    /// Rows of data.
    pub rows: usize,
    /// Pose measurements.
    pub poses: usize,
    /// Whether the arm still fits.
    pub arm: ArmFitsSummary,
    /// What was found: base, tool, targets.
    pub found: Vec<String>,
    /// How well.
    pub installation: Vec<InstallationSummary>,
    /// Position error of the rows that determined the installation.
    pub residual: PositionStatistics,
    /// RMS that noise and uncertainty lead one to expect, mm.
    pub expected_rms_mm: f64,
    /// What coefficients leave open in the installation of the fit; null where the fit file holds no configurations.
    pub band_of_fit: Option<BandSummary>,
    /// What coefficients and installation leave open here.
    pub band_here: Option<BandSummary>,
    /// Rows (1-based) beyond the data of the fit.
    pub extrapolated_rows: Vec<usize>,
    /// What to measure next.
    pub advised: Vec<AdvisedSummary>,
    /// Largest change of a coefficient, in its standard deviations, where the arm was updated.
    pub largest_update_in_sd: Option<f64>,
    #[serde(skip)]
    joints: Vec<(String, &'static str)>,
    #[serde(skip)]
    worst: Option<String>,
}

impl TransferSummary {
    /// Summary of a transfer to the installation of `data`.
    pub fn new(made: &Transfer, data: &Dataset) -> Self {
        let chain = made.fitted.chain();
        let p_value = made.fits.p_value;
        TransferSummary {
            robot: chain.name().into(),
            rows: data.len(),
            poses: Visits::of(data).len(),
            arm: ArmFitsSummary {
                fits: p_value.map(|p| p >= LEVEL),
                p_value,
                chi_square: made.fits.chi_square,
                degrees_of_freedom: made.fits.degrees_of_freedom,
                worst_row: made.fits.worst.map(|(row, _)| row + 1),
                worst_in_sd: made.fits.worst.map(|(_, sd)| sd),
            },
            found: made.found.clone(),
            installation: made
                .deviations
                .iter()
                .map(|&(site, sd)| InstallationSummary {
                    name: chain.site_word(site),
                    sd,
                    unit: site.axis().unit().into(),
                })
                .collect(),
            residual: made.residual.into(),
            expected_rms_mm: 1e3 * made.expected,
            band_of_fit: made.bands.map(|(before, _)| before.into()),
            band_here: made.bands.map(|(_, here)| here.into()),
            extrapolated_rows: made.beyond.iter().map(|row| row + 1).collect(),
            advised: made
                .advised
                .iter()
                .map(|one| AdvisedSummary {
                    joints: one
                        .joints
                        .iter()
                        .zip(units(chain))
                        .map(|(q, (_, factor, _))| q * factor)
                        .collect(),
                    band_mm: 1e3 * one.band,
                })
                .collect(),
            largest_update_in_sd: made.largest_update,
            joints: units(chain).map(|(name, _, unit)| (name, unit)).collect(),
            worst: made.fits.worst.map(|(row, _)| row_words(row, &data.line)),
        }
    }
}

/// Name, factor and unit of each movable joint, as people read them.
fn units(chain: &Chain) -> impl Iterator<Item = (String, f64, &'static str)> + '_ {
    chain.movable().iter().map(|&joint| match chain.joint(joint).kind {
        JointKind::Prismatic => (chain.joint(joint).name.clone(), 1e3, "mm"),
        _ => (chain.joint(joint).name.clone(), 180.0 / std::f64::consts::PI, "°"),
    })
}

impl fmt::Display for TransferSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n", heading(&self.robot, self.rows, self.poses))?;
        let rms = millimetres(1e-3 * self.residual.rms_mm);
        let expected = millimetres(1e-3 * self.expected_rms_mm);
        match (self.arm.fits, self.arm.p_value) {
            (Some(true), Some(p)) => writeln!(
                f,
                "The arm as identified fits in this installation: residual {rms} RMS, {expected} expected ({}).",
                p_text(p)
            )?,
            (Some(false), Some(p)) => {
                writeln!(
                    f,
                    "The arm as identified does not fit in this installation: residual {rms} RMS, {expected} expected ({}).",
                    p_text(p)
                )?;
                if let (Some(worst), Some(sd)) = (&self.worst, self.arm.worst_in_sd) {
                    writeln!(
                        f,
                        "The largest residual is in {worst}: {} standard deviations.",
                        significant(sd, 2)
                    )?;
                }
                writeln!(
                    f,
                    "A row is wrong, tool or targets are not those of the fit (--tool, --targets), or the arm has changed (truepose monitor)."
                )?;
            }
            _ => writeln!(
                f,
                "As many measured numbers as unknowns: whether the arm still fits cannot be tested. Measure more poses."
            )?,
        }
        if !self.found.is_empty() {
            writeln!(f, "Found: {}.", self.found.join(", "))?;
        }
        let each: Vec<String> = self
            .installation
            .iter()
            .map(|one| format!("{} {}", one.name, quantity(one.sd, &one.unit)))
            .collect();
        if !each.is_empty() {
            writeln!(f, "Standard deviations: {}.", each.join(", "))?;
        }
        if let (Some(before), Some(here)) = (self.band_of_fit, self.band_here) {
            let text = |band: BandSummary| {
                format!(
                    "{} RMS, {} at most",
                    millimetres(1e-3 * band.rms_mm),
                    millimetres(1e-3 * band.max_mm)
                )
            };
            writeln!(
                f,
                "Standard deviation of a predicted position over the configurations of the fit: {} in the installation of the fit, {} here.",
                text(before),
                text(here)
            )?;
        }
        if let Some(largest) = self.largest_update_in_sd {
            writeln!(
                f,
                "Update of the arm: the largest change is {} standard deviations.",
                significant(largest, 2)
            )?;
        }
        if !self.extrapolated_rows.is_empty() {
            writeln!(
                f,
                "{} beyond the data of the fit, where its effects are not known.",
                crate::count(self.extrapolated_rows.len(), "row")
            )?;
        }
        for (k, one) in self.advised.iter().enumerate() {
            let joints: Vec<String> = self
                .joints
                .iter()
                .zip(&one.joints)
                .map(|((name, unit), value)| format!("{name} {value:.1}{unit}"))
                .collect();
            let begin = if k == 0 { "Measure next" } else { "then" };
            writeln!(
                f,
                "{begin}: {} (installation then {} RMS).",
                joints.join(", "),
                millimetres(1e-3 * one.band_mm)
            )?;
        }
        Ok(())
    }
}
