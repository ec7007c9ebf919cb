//! Pure error from repeated visits, and lack of fit against it.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | n_i | visits of configuration i in which a target's position was measured | 1 |
//! | SS_PE = Σ_ij ‖p_ij − p̄_i‖² | around the mean of each configuration and target | m² |
//! | df_PE = 3 Σ (n_i − 1) | | 1 |
//! | SS_LOF = RSS − SS_PE, df_LOF = m − r − df_PE | what the model misses beyond it | m² |
//! | F = (SS_LOF / df_LOF) / (SS_PE / df_PE) | ~ F(df_LOF, df_PE) when nothing is missing | 1 |
//!
//! Source: Fisher's lack-of-fit test, as in Draper and Smith, *Applied Regression Analysis*, 3rd ed., §2.1. Visits that came
//! from different sides of approach are repeats of each other: so backlash counts as lack of fit when both
//! sides stand in the model's data, and as pure error when it is ignored; `one_sided` says which repeats there are.

use crate::{Fit, Residuals};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use std::collections::BTreeMap;
use truepose_errormodel::{Dataset, configurations};

/// What repeated visits say.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Repeats {
    /// Configurations (with their target) that were visited more than once.
    pub groups: usize,
    /// Degrees of freedom of the pure error.
    pub freedom: usize,
    /// 3-D RMS of one row around its configuration's mean, m.
    pub rms: f64,
    /// Whether all repeats of a configuration came with the same directions of approach.
    pub one_sided: bool,
    /// Lack of fit of the model, where it has degrees of freedom.
    pub lack_of_fit: Option<LackOfFit>,
}

/// Lack of fit against the pure error.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LackOfFit {
    /// F statistic.
    pub f: f64,
    /// Degrees of freedom of its numerator.
    pub freedom: usize,
    /// Probability of a larger F when nothing is missing.
    pub p_value: f64,
}

/// Pure error of repeated visits; none when no configuration was visited twice.
pub fn repeats(fit: &Fit, data: &Dataset) -> Option<Repeats> {
    let configuration = configurations(data);
    let mut members: BTreeMap<(usize, Option<usize>), Vec<usize>> = BTreeMap::new();
    for row in 0..data.len() {
        if data.position[row].iter().all(|v| !v.is_nan()) {
            let target = data.target[row].map(|t| t.0);
            members.entry((configuration[data.visit[row]], target)).or_default().push(row);
        }
    }
    let groups: Vec<&Vec<usize>> =
        members.values().filter(|rows| rows.iter().any(|&r| data.visit[r] != data.visit[rows[0]])).collect();
    if groups.is_empty() {
        return None;
    }
    let mut squares = 0.0;
    let mut freedom = 0;
    let mut one_sided = true;
    for rows in &groups {
        // Residuals, not positions: channels and time may differ between repeats, and the model knows them.
        squares += around_mean(&fit.residuals, rows);
        freedom += 3 * (rows.len() - 1);
        one_sided &=
            rows.iter().all(|&r| data.approach.iter().all(|side| (side[r] - side[rows[0]]).abs() < 0.5));
    }
    let variance = squares / freedom as f64;
    let measured: usize = members.values().map(|rows| 3 * rows.len()).sum();
    let total: f64 = members.values().flatten().map(|&row| fit.residuals.position[row].norm_squared()).sum();
    let left = measured.saturating_sub(fit.reduction.rank()).saturating_sub(freedom);
    let lack_of_fit = (left > 0 && variance > 0.0).then(|| {
        let f = ((total - squares).max(0.0) / left as f64) / variance;
        let p_value = FisherSnedecor::new(left as f64, freedom as f64).map_or(1.0, |d| d.sf(f));
        LackOfFit { f, freedom: left, p_value }
    });
    Some(Repeats { groups: groups.len(), freedom, rms: (3.0 * variance).sqrt(), one_sided, lack_of_fit })
}

fn around_mean(residuals: &Residuals, rows: &[usize]) -> f64 {
    let mean =
        rows.iter().map(|&r| residuals.position[r]).sum::<nalgebra::Vector3<f64>>() / rows.len() as f64;
    rows.iter().map(|&r| (residuals.position[r] - mean).norm_squared()).sum()
}
