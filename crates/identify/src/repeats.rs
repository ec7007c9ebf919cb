//! Pure error from repeated visits, and lack of fit against it.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | n_i | visits of configuration i in which a target's position was measured | 1 |
//! | SS_PE = Σ_ij ‖V^{−1/2} (p_ij − p̄_i)‖² | around the mean of each configuration and target | 1 |
//! | df_PE = 3 Σ (n_i − 1) | | 1 |
//! | SS_LOF = RSS − SS_PE, df_LOF = f − df_PE | what the model misses beyond it, whitened | 1 |
//! | f | [`Freedom`] of positions, less the shape parameters | 1 |
//! | F = (SS_LOF / df_LOF) / (SS_PE / df_PE) | ~ F(df_LOF, df_PE) when nothing is missing | 1 |
//!
//! V is the covariance of the rows of one visit ([`crate::NoiseModel`]): they share its repeatability, and without the whitening three
//! targets of one visit would pass for three looks at it.
//!
//! Source: Fisher's lack-of-fit test, as in Draper and Smith, *Applied Regression Analysis*, 3rd ed., §2.1. Visits that came
//! from different sides of approach are repeats of each other: so backlash counts as lack of fit when both
//! sides stand in the model's data, and as pure error when it is ignored; `one_sided` says which repeats there are.

use crate::noise::whiten;
use crate::{Fit, Freedom, NoiseModel};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use std::collections::BTreeMap;
use truepose_errormodel::{Dataset, Visits, configurations};

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
    let several = |rows: &&Vec<usize>| rows.iter().any(|&r| data.visit[r] != data.visit[rows[0]]);
    let groups: Vec<Vec<usize>> = members.values().filter(several).cloned().collect();
    if groups.is_empty() {
        return None;
    }
    let (mut squares, mut freedom, mut one_sided) = (0.0, 0, true);
    let mut around = fit.residuals.position.clone();
    for rows in &groups {
        // Residuals, not positions: channels and time may differ between repeats, and the model knows them.
        let sum: Vector3<f64> = rows.iter().map(|&r| fit.residuals.position[r]).sum();
        rows.iter().for_each(|&r| around[r] -= sum / rows.len() as f64);
        squares += rows.iter().map(|&r| around[r].norm_squared()).sum::<f64>();
        freedom += 3 * (rows.len() - 1);
        one_sided &=
            rows.iter().all(|&r| data.approach.iter().all(|side| (side[r] - side[rows[0]]).abs() < 0.5));
    }
    let variance = squares / freedom as f64;
    let repeated: Vec<usize> = groups.iter().flat_map(|rows| rows.iter().copied()).collect();
    let measured: Vec<usize> = members.into_values().flatten().collect();
    let pure = whitened_squares(fit.noise, data, &around, &repeated);
    let total = whitened_squares(fit.noise, data, &fit.residuals.position, &measured);
    // What the unknowns took of positions: orientations are no part of this.
    let taken = match Freedom::of(fit, data) {
        Ok(left) => Freedom::all(data, &Visits::of(data)).positions() - left.positions(),
        Err(_) => fit.reduction.rank() as f64,
    };
    let left = 3.0 * measured.len() as f64 - taken - (fit.shapes.len() + freedom) as f64;
    let lack_of_fit = (left >= 1.0 && pure > 0.0).then(|| {
        let f = ((total - pure).max(0.0) / left) / (pure / freedom as f64);
        let p_value = FisherSnedecor::new(left, freedom as f64).map_or(1.0, |d| d.sf(f));
        LackOfFit { f, freedom: left.round() as usize, p_value }
    });
    Some(Repeats { groups: groups.len(), freedom, rms: (3.0 * variance).sqrt(), one_sided, lack_of_fit })
}

/// Sum of the squares of these rows' residuals, whitened visit by visit.
fn whitened_squares(noise: NoiseModel, data: &Dataset, residuals: &[Vector3<f64>], rows: &[usize]) -> f64 {
    let mut visits: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    rows.iter().for_each(|&row| visits.entry(data.visit[row]).or_default().push(row));
    let one = |rows: &Vec<usize>| -> f64 {
        let places: Vec<usize> = (0..rows.len()).collect();
        let axis = |axis: usize| -> f64 {
            let mut block: Vec<f64> = rows.iter().map(|&row| residuals[row][axis]).collect();
            let sd: Vec<f64> = rows.iter().map(|&row| noise.position(data.position_sd[row][axis])).collect();
            whiten(&mut block, 1, &places, &sd, noise.visit_sd, &mut [0.0]);
            block.iter().map(|v| v * v).sum()
        };
        (0..3).map(axis).sum()
    };
    visits.values().map(one).sum()
}
