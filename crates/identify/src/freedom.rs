//! How many numbers are left to scatter once the unknowns have taken theirs, within visits, between visits, and of orientations.
//!
//! ```text
//! H = A (AᵀA + WᵀW)⁻¹ Aᵀ        E ‖S (1 − H) y‖² = tr S − tr S H,    tr S H = ‖R_S (RᵀR + WᵀW)^{−1/2}‖²
//! ```
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | A, R | whitened design matrix and its triangular factor | m × r, r × r |
//! | W | rows of the prior | r × r |
//! | S | projector on the deviations from the means of visits, on those means, or on orientations | m × m |
//! | R_S | triangular factor of S A | r × r |
//!
//! Unknowns are found by where the robot stands, which all rows of a visit share: where visits are few they take a large part of what the means
//! of visits say and hardly any of what differs within them. To share their number out evenly makes what is between visits look smaller
//! than it is. With the prior as the law of the unknowns the expectation is exact, whatever it holds (Searle, Casella and McCulloch
//! 1992, §6.6, for the equations of restricted likelihood that have the same traces).
//!
//! Both projections are the whitening itself, in the limit: by a visit that shares infinitely much only deviations from its mean are left.

use crate::linearise::{factorise, gram};
use crate::noise::{rays_of, spanned};
use crate::{IdentifyError, NoiseModel, Prior};
use nalgebra::DMatrix;
use truepose_errormodel::{Dataset, ErrorModel, Visits};
use truepose_solvers::accumulator::Factor;

/// Deviation that leaves nothing of what it belongs to, m.
const INFINITE: f64 = 1e6;

/// Numbers that are free to scatter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Freedom {
    /// Positions about the mean of their visit; numbers along directions about a displacement of it in space.
    pub within: f64,
    /// Those means and displacements; of a visit with one row its position.
    pub between: f64,
    /// Orientations.
    pub turns: f64,
}

impl Freedom {
    /// All numbers that were measured.
    pub fn all(data: &Dataset, visits: &Visits) -> Self {
        let mut all = Freedom::default();
        for rows in &visits.rows {
            for axis in 0..3 {
                let seen: Vec<usize> =
                    rows.iter().copied().filter(|&row| data.seen(row).position[axis]).collect();
                let rays = rays_of(data, axis, seen.iter().copied());
                let shared = match rays.is_empty() {
                    true => seen.len().min(1),
                    false => spanned(&rays.iter().map(|w| w * w.transpose()).sum()).len(),
                };
                all.between += shared as f64;
                all.within += (seen.len() - shared) as f64;
            }
            all.turns += 3.0 * rows.iter().filter(|&&row| data.orientation[row].is_some()).count() as f64;
        }
        all
    }

    /// This share of each.
    #[must_use]
    pub fn share(self, share: f64) -> Self {
        Freedom { within: share * self.within, between: share * self.between, turns: share * self.turns }
    }

    /// Of positions.
    pub fn positions(self) -> f64 {
        self.within + self.between
    }
}

/// Where the unknowns are.
pub(crate) struct Taken<'a> {
    pub model: &'a ErrorModel,
    pub data: &'a Dataset,
    pub visits: &'a Visits,
    pub noise: NoiseModel,
    pub coefficients: &'a [f64],
    pub kept: &'a [usize],
}

impl Taken<'_> {
    /// What they leave; `factor` is that of the kept columns with this noise.
    pub fn left(&self, factor: &Factor, prior: &Prior) -> Result<Freedom, IdentifyError> {
        /// Of each stratum so much is left at the least.
        const LEAST: f64 = 0.02;
        let all = Freedom::all(self.data, self.visits);
        let numbers = all.positions() + all.turns;
        let rank = self.kept.len();
        if rank == 0 {
            return Ok(all);
        }
        let joined = prior.joined(factor, &vec![0.0; rank])?.r;
        let Some(whole) = taken(&joined, &factor.r) else {
            return Ok(all.share((1.0 - rank as f64 / numbers).max(LEAST)));
        };
        let of = |noise: NoiseModel| -> Result<f64, IdentifyError> {
            let (model, data, visits, at, kept) =
                (self.model, self.data, self.visits, self.coefficients, Some(self.kept));
            // A number that is wanted to a few digits: sums of products do where they can.
            let quick = gram(model, data, visits, noise, at, kept)?.norm_behind(&joined)?;
            match quick {
                Some(squares) => Ok(squares),
                None => {
                    Ok(taken(&joined, &factorise(model, data, visits, noise, at, kept)?.r).unwrap_or(0.0))
                }
            }
        };
        let turns = match all.turns > 0.0 {
            true => of(NoiseModel { position_sd: INFINITE, ..self.noise })?,
            false => 0.0,
        };
        let within = match all.within > 0.0 {
            true => of(NoiseModel { visit_sd: INFINITE, ..self.noise })? - turns,
            false => 0.0,
        };
        let left = |all: f64, taken: f64| (all - taken.max(0.0)).max(LEAST * all);
        Ok(Freedom {
            within: left(all.within, within),
            between: left(all.between, whole - within - turns),
            turns: left(all.turns, turns),
        })
    }
}

/// ‖R_S (JᵀJ)^{−1/2}‖²; none where J is singular.
fn taken(joined: &DMatrix<f64>, part: &DMatrix<f64>) -> Option<f64> {
    let turned = joined.tr_solve_upper_triangular(&part.transpose())?;
    let squares = turned.norm_squared();
    squares.is_finite().then_some(squares)
}
