//! A fleet, and its next robot.

use crate::wording::heading;
use crate::{PositionStatistics, count, significant};
use serde::Serialize;
use std::fmt;
use truepose_errormodel::{Dataset, Visits};
use truepose_upkeep::{Fleet, Sister};

/// What robots of a type have in common.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FleetSummary {
    /// Name of the robot.
    pub robot: String,
    /// How many of them.
    pub robots: usize,
    /// Share of the correlations between coefficients that is put down to chance.
    pub shrinkage: f64,
    /// Each coefficient of the model that differs from zero in any robot.
    pub coefficients: Vec<FleetCoefficient>,
}

/// A coefficient over the fleet.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FleetCoefficient {
    /// Its name.
    pub name: String,
    /// Mean over the fleet.
    pub mean: f64,
    /// Standard deviation expected of the next robot.
    pub sd: f64,
    /// Unit of both.
    pub unit: String,
}

impl FleetSummary {
    /// Of a fleet.
    pub fn new(fleet: &Fleet) -> Self {
        let columns = fleet.prior.model().columns().iter();
        let values = fleet.prior.coefficients().iter().zip(fleet.deviations());
        let coefficients = columns.zip(values).map(|(column, (&mean, sd))| FleetCoefficient {
            name: column.name.clone(),
            mean,
            sd,
            unit: column.unit.clone(),
        });
        FleetSummary {
            robot: fleet.prior.chain().name().into(),
            robots: fleet.robots,
            shrinkage: fleet.shrinkage,
            coefficients: coefficients.filter(|c| c.sd > 0.0 || c.mean != 0.0).collect(),
        }
    }
}

/// Coefficients that are printed; the JSON has all.
const LISTED: usize = 12;

impl fmt::Display for FleetSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}: a fleet of {}\n", self.robot, count(self.robots, "robot"))?;
        // What the fleet has in common, the surest first.
        let mut common: Vec<&FleetCoefficient> = self.coefficients.iter().collect();
        let sure = |c: &FleetCoefficient| c.mean.abs() / c.sd.max(f64::MIN_POSITIVE);
        common.sort_by(|a, b| sure(b).total_cmp(&sure(a)));
        writeln!(
            f,
            "errors that its robots have in common, mean and standard deviation from robot to robot:"
        )?;
        for one in common.iter().take(LISTED) {
            writeln!(
                f,
                "  {} = {} ± {} {}",
                one.name,
                significant(one.mean, 3),
                significant(one.sd, 2),
                one.unit
            )?;
        }
        if common.len() > LISTED {
            writeln!(f, "  and {} more", common.len() - LISTED)?;
        }
        writeln!(f, "use: truepose identify --prior FILE, for a robot of this type with few poses")
    }
}

/// A robot with its sisters as prior.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SisterSummary {
    /// Name of the robot.
    pub robot: String,
    /// Rows of data.
    pub rows: usize,
    /// Pose measurements.
    pub poses: usize,
    /// Held-out position errors with the fleet as prior.
    pub with_fleet: PositionStatistics,
    /// The same rows without it; null where that could not be fitted.
    pub alone: Option<PositionStatistics>,
    /// Whether the fit uses the fleet.
    pub fleet_used: bool,
    /// p of the robot being like its sisters; null without degrees of freedom.
    pub like_its_sisters_p: Option<f64>,
    /// What was found of the installation.
    pub found: Vec<String>,
}

impl SisterSummary {
    /// Of an identification.
    pub fn new(found: &Sister, data: &Dataset) -> Self {
        SisterSummary {
            robot: found.made.fitted.chain().name().into(),
            rows: data.len(),
            poses: Visits::of(data).len(),
            with_fleet: found.held_out.positions().into(),
            alone: found.alone.as_ref().map(|alone| alone.positions().into()),
            fleet_used: found.helps(),
            like_its_sisters_p: found.made.fits.p_value,
            found: found.made.found.clone(),
        }
    }

    /// Held-out RMS of the fit that is written, mm.
    pub fn used_mm(&self) -> f64 {
        match (&self.alone, self.fleet_used) {
            (Some(alone), false) => alone.rms_mm,
            _ => self.with_fleet.rms_mm,
        }
    }
}

/// Level below which a robot is reported to be unlike its sisters.
const LEVEL: f64 = 0.01;

impl fmt::Display for SisterSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n", heading(&self.robot, self.rows, self.poses))?;
        let with = significant(self.with_fleet.rms_mm, 3);
        match &self.alone {
            Some(alone) => writeln!(
                f,
                "Position error (3-D RMS) on held-out configurations: {} mm alone → {with} mm with its sisters as prior.",
                significant(alone.rms_mm, 3)
            )?,
            None => writeln!(
                f,
                "Position error (3-D RMS) on held-out configurations: {with} mm with its sisters as prior; these rows alone cannot be fitted."
            )?,
        }
        if !self.fleet_used {
            writeln!(f, "Its sisters do not help: the fit is that of these rows alone.")?;
        }
        match self.like_its_sisters_p {
            Some(p) if p < LEVEL => writeln!(
                f,
                "The robot is unlike its sisters (p = {}): a row is wrong, the noise is larger than theirs, or it has an error that they have not.",
                significant(p, 2)
            )?,
            Some(p) => writeln!(f, "The robot is like its sisters (p = {}).", significant(p, 2))?,
            None => {}
        }
        if !self.found.is_empty() {
            writeln!(f, "Found: {}.", self.found.join(", "))?;
        }
        Ok(())
    }
}
