//! Whether a robot has changed since it was calibrated.
//!
//! ```text
//! T_0 = rᵀ Q r,  T_0/(m − k) ~ F(m − k, ν)                          anything at all
//! G_i = gᵀ (H_iᵀ Q H_i)⁻¹ g,  G_i/n_i ~ F(n_i, ν),  g = H_iᵀ Q r     the coefficients of suspect i
//! Δ_i = (H_iᵀ Q H_i)⁻¹ g ± t √diag (H_iᵀ Q H_i)⁻¹
//! p = min(1, 2 min(p_0, K min_i p_i))                               Bonferroni over both tests and K groups of suspects
//! ```
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | r | residuals of the new measurements, m numbers | m | m, rad |
//! | k | unknowns of an installation that is found anew | 1 | |
//! | H_i, n_i | derivative by the coefficients of suspect i, their number | m × n_i | of the coefficient |
//! | Δ_i | [`Change::coefficients`] | n_i | of the coefficient |
//! | ν | degrees of freedom of the noise that the fit estimated | 1 | |
//!
//! Q as in [`crate::transfer`]: residuals weighed with noise and with what the fit leaves open, an installation that is found anew projected out.
//! Source: score tests, Rao (1948). A change that one coefficient explains is looked for in the directions of the suspects; any other one in
//! T_0. Where the residuals of the fit have tails, numbers far out are bounded first ([`crate::tails`]). Suspects that move the measured points alike ([`alike`]) are one question and one test.

mod alike;
mod check_poses;
mod score;
mod spending;
mod suspects;

pub use check_poses::{CheckPoses, check_poses};
pub use spending::level;

use crate::UpkeepError;
use crate::installation::Installation;
use crate::prediction::{Prediction, oriented, seen};
use crate::tails::Tails;
use score::ScoreTest;
use serde::Serialize;
use suspects::suspects;
use truepose_errormodel::{Dataset, FittedModel, Visits};
use truepose_identify::place_fitted;

/// Suspects whose −2 ln L is within this of the best one are listed beside it: odds below ten to one.
const TIED: f64 = 4.6;

/// A part of the installation explains a change where, with it found anew, nothing is left at this p.
const EXPLAINED: f64 = 0.05;

/// How a robot is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MonitorOptions {
    /// Probability that an unchanged robot ever raises an alarm, over all looks.
    pub alpha: f64,
    /// Looks before this one.
    pub looks: usize,
    /// What is found anew from these data, because instrument, base, tool or targets were moved.
    pub installation: Installation,
}

impl Default for MonitorOptions {
    fn default() -> Self {
        MonitorOptions { alpha: 0.01, looks: 0, installation: Installation::SAME }
    }
}

/// The change of one coefficient.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Coefficient {
    /// Its name in the fit.
    pub name: String,
    /// Δ, in its unit.
    pub change: f64,
    /// 95 % interval.
    pub ci95: [f64; 2],
    /// Its unit.
    pub unit: String,
}

/// The change of a constant error, or of an effect, if it alone has changed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Change {
    /// What: `rz@j3`, `transmission j1`.
    pub what: String,
    /// What moves the measured points alike, so that it is as likely: `ry@j2` beside `zero of j3 (rz@j3)`.
    pub also: Vec<String>,
    /// Family of the effect.
    pub family: String,
    /// Its coefficients.
    pub coefficients: Vec<Coefficient>,
    /// RMS by which it moves the measured positions, m.
    pub moves: f64,
    /// Of this suspect alone, as a single test.
    pub p_value: f64,
    /// −2 ln L of the best suspect less that of this one.
    pub behind: f64,
}

/// The smallest change that these poses show.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Detectable {
    /// What.
    pub what: String,
    /// Smallest change of one coefficient found with 90 % probability at the level of this look, in its unit.
    pub change: f64,
    /// Its unit.
    pub unit: String,
    /// RMS by which that moves the measured positions, m.
    pub moves: f64,
}

/// What one look says.
#[derive(Debug, Clone, PartialEq)]
pub struct Look {
    /// Rows and pose measurements.
    pub rows: usize,
    /// Pose measurements.
    pub poses: usize,
    /// 3-D RMS of the residual, m.
    pub rms: f64,
    /// What to expect of an unchanged robot, m.
    pub expected: f64,
    /// p of the look.
    pub p_value: f64,
    /// p of anything at all.
    pub p_overall: f64,
    /// Level of this look.
    pub level: f64,
    /// Whether p is below it.
    pub changed: bool,
    /// Suspects, the best first; those that these poses cannot show are left out.
    pub changes: Vec<Change>,
    /// How many of the first ones these poses cannot tell apart.
    pub tied: usize,
    /// What change would be found, the least visible first.
    pub detectable: Vec<Detectable>,
    /// Suspects that these poses cannot show.
    pub invisible: Vec<String>,
    /// What was found anew.
    pub placed: Vec<String>,
    /// The part of the installation that, found anew, would leave no change at all, and the p that is left then. Looked
    /// for where the robot has changed.
    pub set_up_anew: Option<(Part, f64)>,
}

/// A part of the installation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Where the robot stands in the measurement frame, or the instrument in the cell.
    Base,
    /// What is mounted on the flange.
    Tool,
    /// The points on the tool.
    Targets,
}

/// Holds new measurements against a fit.
///
/// # Errors
/// When the data lacks what the model reads, or does not determine what is found anew; when the fit has no uncertainty.
pub fn monitor(fitted: &FittedModel, data: &Dataset, options: MonitorOptions) -> Result<Look, UpkeepError> {
    let mut seen = look(fitted, data, options)?;
    if seen.changed {
        seen.set_up_anew = set_up_anew(fitted, data, options);
    }
    Ok(seen)
}

/// The first part of the installation that explains a change alone. A part that these data do not determine explains nothing.
fn set_up_anew(fitted: &FittedModel, data: &Dataset, options: MonitorOptions) -> Option<(Part, f64)> {
    let known = options.installation;
    let parts = [
        (Part::Base, known.base, Installation { base: true, ..known }),
        (Part::Tool, known.tool, Installation { tool: true, ..known }),
        (Part::Targets, known.targets, Installation { targets: true, ..known }),
    ];
    parts.into_iter().filter(|(_, found, _)| !found).find_map(|(part, _, installation)| {
        let again = look(fitted, data, MonitorOptions { installation, ..options }).ok()?;
        (again.p_value > EXPLAINED).then_some((part, again.p_value))
    })
}

fn look(fitted: &FittedModel, data: &Dataset, options: MonitorOptions) -> Result<Look, UpkeepError> {
    if !(options.alpha > 0.0 && options.alpha < 1.0) {
        let value = options.alpha;
        return Err(UpkeepError::Option { option: "alpha", value, expected: "between 0 and 1" });
    }
    let placement = place_fitted(fitted, &options.installation.unknown(fitted.chain())?, data)?;
    let sites = options.installation.sites(&placement, &seen(data), oriented(fitted, data))?;
    // Its rows were measured in the installation of the fit.
    let tails = Tails::of(fitted)?;
    let fitted = fitted.on(placement.chain)?;
    let mut rows = Prediction::of(&fitted, &sites, data)?;
    if rows.len() <= sites.len() {
        return Err(UpkeepError::TooFew { have: rows.len(), need: sites.len() + 1 });
    }
    let expected = rows.expected(&fitted, fitted.covariance());
    tails.iter().for_each(|tails| tails.bound(&mut rows));
    let test = ScoreTest::of(&fitted, &rows, tails)?;
    let level = level(options.alpha, options.looks + 1);
    let candidates = suspects(&fitted, &sites);
    let groups = alike::groups(&test.information(&rows), &candidates);
    let (mut changes, mut invisible) = (Vec::new(), Vec::new());
    let mut detectable = Vec::new();
    let count = groups.len().max(1) as f64;
    for group in &groups {
        let suspect = &candidates[group[0]];
        match test.judge(&fitted, &rows, suspect) {
            Some((deviance, found)) => {
                let also = group[1..].iter().map(|&k| candidates[k].word.clone()).collect();
                changes.push((deviance, Change { also, ..found }));
                detectable.extend(test.detectable(&fitted, &rows, suspect, level / (2.0 * count)));
            }
            None => invisible.extend(group.iter().map(|&k| candidates[k].word.clone())),
        }
    }
    changes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let best = changes.first().map_or(0.0, |first| first.0);
    let least = changes.iter().map(|(_, change)| change.p_value).fold(1.0, f64::min);
    let changes: Vec<Change> =
        changes.into_iter().map(|(deviance, change)| Change { behind: deviance - best, ..change }).collect();
    let p_overall = test.overall();
    let p_value = (2.0 * p_overall.min(count * least)).min(1.0);
    detectable.sort_by(|a, b| b.moves.total_cmp(&a.moves));
    let squares = rows.distances.iter().map(|d| d * d).sum::<f64>() / rows.distances.len().max(1) as f64;
    Ok(Look {
        rows: data.len(),
        poses: Visits::of(data).len(),
        rms: squares.sqrt(),
        expected,
        p_value,
        p_overall,
        level,
        changed: p_value < level,
        tied: changes.iter().take_while(|change| change.behind < TIED).count(),
        changes,
        detectable,
        invisible,
        placed: placement.found,
        set_up_anew: None,
    })
}
