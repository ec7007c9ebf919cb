//! Held-out residuals with the structure of the model frozen.
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | G = AᵀA | of the whitened, reduced design matrix at the solution | r × r |
//! | A_F, r_F | rows and residuals of a fold | m_F × r, m_F |
//! | H_FF = A_F G⁻¹ A_Fᵀ | leverage of the fold | m_F × m_F |
//!
//! For a linear fit, leaving out fold F changes the coefficients by `δ_F = −G⁻¹ A_Fᵀ (I − H_FF)⁻¹ r_F`, so that the
//! held-out residual is `e_F = (I − H_FF)⁻¹ r_F`: one factorisation serves all folds. Where the gradient does not vanish
//! to the last digit (the noise was looked at after the last step), r_F is taken after the step δ_0 that makes it vanish. Folds with more rows than
//! unknowns are taken out of the triangular factor instead (the factors of all other folds are merged), which gives
//! the same numbers. Folds without which the rest loses rank, and solvers that are not plain least squares, are
//! fitted again; so are folds whose coefficients lie so far off that the linear picture does not hold there: where it misses what
//! the exact robot then leaves by a twentieth. Residuals are those of the exact robot in every case.
//!
//! A fit of a single linear step is judged by single linear steps, from where it began.

use crate::linearise::{Lineariser, triangular_of};
use crate::{Fit, FitOptions, Folds, IdentifyError, NoiseSource, Residuals, fit_again};
use nalgebra::{DMatrix, DVector, Vector3};
use rayon::prelude::*;
use truepose_errormodel::{Dataset, Visits};
use truepose_solvers::accumulator::{Factor, Triangular};
use truepose_solvers::{Need, Solver};

/// Residuals of every row by a fit that did not see its configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct CrossValidation {
    /// Held-out residuals, row by row.
    pub residuals: Residuals,
    /// The folds.
    pub folds: Folds,
    /// RMS of the 3-D position error of each fold, m.
    pub fold_rms: Vec<f64>,
    /// How many folds had to be fitted again.
    pub refitted: usize,
}

/// How a fold is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// The cheapest exact one.
    #[default]
    Auto,
    /// The block formula.
    Block,
    /// Merging the factors of the other folds.
    Merge,
    /// A fit of its own for every fold.
    Refit,
}

/// Cross-validates a fit on the data that it was made from.
///
/// # Errors
/// When the data does not fit the model, or a refit fails.
pub fn cross_validate(
    fit: &Fit,
    data: &Dataset,
    folds: &Folds,
    solver: &dyn Solver,
    method: Method,
) -> Result<CrossValidation, IdentifyError> {
    let data = &*data.derived_for(fit.fitted.model())?;
    let visits = Visits::of(data);
    let members: Vec<Vec<usize>> = by_fold(folds);
    // Bounds bind in one fold and not in another: as good as a penalty.
    let held = solver.supports(Need::Bounds) || solver.supports(Need::Outliers);
    let plain = solver.supports(Need::Unpenalised) && !held;
    let longest: usize = members.iter().map(|visits_of| visits_of.len()).max().unwrap_or(0);
    let method = match method {
        _ if !plain => Method::Refit,
        _ if !fit.refined => Method::Merge,
        Method::Auto if longest > 4 * fit.reduction.rank() || folds.count <= 20 => Method::Merge,
        Method::Auto => Method::Block,
        other => other,
    };
    let at = match fit.refined {
        true => fit.fitted.coefficients().to_vec(),
        false => vec![0.0; fit.fitted.coefficients().len()],
    };
    let work = Work { fit, data, visits: &visits, solver, at };
    let mut steps: Vec<Step> = match method {
        Method::Merge => work.merge(&members)?,
        Method::Refit => members.par_iter().map(|out| work.again(out)).collect::<Result<_, _>>()?,
        _ => members.par_iter().map(|out| work.block(out)).collect::<Result<_, _>>()?,
    };
    let parts: Vec<Vec<HeldOutRow>> = members
        .par_iter()
        .zip(&mut steps)
        .map(|(out, step)| {
            if fit.refined && !step.refitted && work.bends(out, &step.change)? {
                *step = work.again(out)?;
            }
            work.held_out(out, &step.change)
        })
        .collect::<Result<_, _>>()?;
    let mut residuals = Residuals {
        position: vec![Vector3::repeat(f64::NAN); data.len()],
        orientation: vec![None; data.len()],
    };
    let mut fold_rms = Vec::with_capacity(parts.len());
    for part in parts {
        let rows: Vec<usize> = part.iter().map(|p| p.0).collect();
        for (row, position, orientation) in part {
            residuals.position[row] = position;
            residuals.orientation[row] = orientation;
        }
        fold_rms.push(residuals.positions_of(&rows).rms);
    }
    let refitted = steps.iter().filter(|step| step.refitted).count();
    Ok(CrossValidation { residuals, folds: folds.clone(), fold_rms, refitted })
}

fn by_fold(folds: &Folds) -> Vec<Vec<usize>> {
    let mut members = vec![Vec::new(); folds.count];
    for (visit, &fold) in folds.of_visit.iter().enumerate() {
        members[fold].push(visit);
    }
    members
}

/// A row with the residuals of its position and orientation.
type HeldOutRow = (usize, Vector3<f64>, Option<Vector3<f64>>);

/// What leaving a fold out does to the coefficients of the model.
struct Step {
    change: Vec<f64>,
    refitted: bool,
}

struct Work<'a> {
    fit: &'a Fit,
    data: &'a Dataset,
    visits: &'a Visits,
    solver: &'a dyn Solver,
    /// Where the linear picture was taken: at the solution, or where a single step began.
    at: Vec<f64>,
}

impl Work<'_> {
    /// Factors of each fold, merged from both ends so that every complement is one merge of two.
    fn merge(&self, members: &[Vec<usize>]) -> Result<Vec<Step>, IdentifyError> {
        let parts: Vec<Triangular> = members
            .par_iter()
            .map(|of_fold| {
                let (model, at) = (self.fit.fitted.model(), &*self.at);
                let (kept, of_fold) = (Some(&*self.fit.reduction.kept), of_fold.iter().copied());
                triangular_of(model, self.data, self.visits, self.fit.noise, at, kept, of_fold)
            })
            .collect::<Result<_, _>>()?;
        let empty = Triangular::new(self.fit.reduction.rank(), 1);
        let mut after = vec![empty.clone()];
        for part in parts.iter().rev() {
            let mut next = after[after.len() - 1].clone();
            next.merge(part)?;
            after.push(next);
        }
        let mut before = empty;
        let mut steps = Vec::with_capacity(parts.len());
        for (fold, part) in parts.iter().enumerate() {
            let mut others = before.clone();
            others.merge(&after[parts.len() - 1 - fold])?;
            before.merge(part)?;
            let factor = self.with_prior(&others.finish())?;
            match triangle_solve(&factor) {
                Some(change) => {
                    let mut change = self.expand(&change);
                    let from = self.at.iter().zip(self.fit.fitted.coefficients());
                    change.iter_mut().zip(from).for_each(|(change, (at, c))| *change += at - c);
                    steps.push(Step { change, refitted: false });
                }
                None => steps.push(self.again(&members[fold])?),
            }
        }
        Ok(steps)
    }

    /// A factor over the kept columns with the rows of the prior, which belong to no fold.
    fn with_prior(&self, factor: &Factor) -> Result<Factor, IdentifyError> {
        let at = self.fit.reduction.grouped(&self.at);
        self.fit.prior.joined(factor, &at)
    }

    /// The block formula.
    fn block(&self, out: &[usize]) -> Result<Step, IdentifyError> {
        let kept = &self.fit.reduction.kept;
        let mut lineariser = self.lineariser()?.of_columns(kept);
        let mut flat: Vec<f64> = Vec::new();
        for &visit in out {
            flat.extend_from_slice(lineariser.visit(&self.visits.rows[visit]).rows);
        }
        let rows = flat.len() / (kept.len() + 1);
        let whole = DMatrix::from_row_slice(rows, kept.len() + 1, &flat);
        let residual: DVector<f64> = whole.column(kept.len()).into_owned();
        let a = whole.columns(0, kept.len());
        // V = R⁻ᵀ A_Fᵀ, so that H = Vᵀ V and G⁻¹ A_Fᵀ = R⁻¹ V.
        // `factor` has absolute coefficients on its right-hand side: the prior pulls at them as a whole.
        let zero = vec![0.0; kept.len()];
        let all = self.fit.prior.joined(&self.fit.factor, &zero)?;
        let r = &all.r;
        let at = DVector::from_vec(self.fit.reduction.grouped(self.fit.fitted.coefficients()));
        let Some(best) = r.solve_upper_triangular(&all.z.column(0).into_owned()) else {
            return self.again(out);
        };
        let first = best - at;
        let Some(v) = r.tr_solve_upper_triangular(&a.transpose()) else { return self.again(out) };
        let rest = DMatrix::identity(rows, rows) - v.tr_mul(&v);
        let Some(cholesky) = rest.cholesky() else { return self.again(out) };
        let smallest = cholesky.l_dirty().diagonal().iter().fold(f64::INFINITY, |m, d| m.min(d * d));
        if smallest < 1e-10 {
            return self.again(out);
        }
        let held_out = cholesky.solve(&(residual - a * &first));
        let Some(change) = r.solve_upper_triangular(&(v * held_out)) else { return self.again(out) };
        Ok(Step { change: self.expand(&(first - change)), refitted: false })
    }

    /// A fit of its own, with the reduction and the noise as they are.
    fn again(&self, out: &[usize]) -> Result<Step, IdentifyError> {
        let mut left_out = vec![false; self.visits.len()];
        out.iter().for_each(|&visit| left_out[visit] = true);
        let rows: Vec<usize> = (0..self.data.len()).filter(|&row| !left_out[self.data.visit[row]]).collect();
        let rest = self.data.select(&rows);
        let options = FitOptions {
            noise: NoiseSource::Fixed(self.fit.noise),
            refine: self.fit.refined,
            ..FitOptions::default()
        };
        let other = fit_again(self.fit, &rest, self.solver, &options)?;
        let change =
            other.fitted.coefficients().iter().zip(self.fit.fitted.coefficients()).map(|(a, b)| a - b);
        Ok(Step { change: change.collect(), refitted: true })
    }

    /// Whether the linear picture at the solution misses what the exact robot leaves of these visits by a twentieth or more.
    fn bends(&self, visits: &[usize], change: &[f64]) -> Result<bool, IdentifyError> {
        const SHARE: f64 = 0.05;
        let (to, mut linear) = (self.changed(change), self.lineariser()?);
        let mut exact =
            Lineariser::new(self.fit.fitted.model(), self.data, self.fit.noise, &to)?.of_columns(&[]);
        let width = linear.width();
        let (mut missed, mut left) = (0.0, 0.0);
        for &visit in visits {
            let rows = &self.visits.rows[visit];
            let pictured = linear.visit(rows).rows.chunks_exact(width);
            for (numbers, value) in pictured.zip(exact.visit(rows).rows) {
                let moved: f64 = numbers[..width - 1].iter().zip(change).map(|(a, d)| a * d).sum();
                missed += (numbers[width - 1] - moved - value).powi(2);
                left += value * value;
            }
        }
        Ok(missed > SHARE * SHARE * left)
    }

    fn changed(&self, change: &[f64]) -> Vec<f64> {
        self.fit.fitted.coefficients().iter().zip(change).map(|(c, d)| c + d).collect()
    }

    /// Residuals of these visits when the coefficients change, at the exact robot, in metres and radians.
    fn held_out(&self, visits: &[usize], change: &[f64]) -> Result<Vec<HeldOutRow>, IdentifyError> {
        let to = self.changed(change);
        let model = self.fit.fitted.model();
        let mut lineariser = Lineariser::new(model, self.data, self.fit.noise, &to)?.of_columns(&[]);
        let mut residuals = Vec::new();
        for &visit in visits {
            let rows = &self.visits.rows[visit];
            let start = residuals.len();
            for &row in rows {
                let turned = self.data.orientation[row].is_some().then(Vector3::zeros);
                residuals.push((row, Vector3::repeat(f64::NAN), turned));
            }
            let block = lineariser.unweighted(rows);
            for (&value, &(row, component)) in block.rows.iter().zip(block.source) {
                let Some(place) = rows.iter().position(|&r| r == row) else { continue };
                let entry = &mut residuals[start + place];
                match (&mut entry.2, self.data.ray(row)) {
                    (_, Some(w)) => entry.1 = w * (value / w.norm_squared()),
                    (Some(turn), _) if component >= 3 => turn[component - 3] = value,
                    _ => entry.1[component] = value,
                }
            }
        }
        Ok(residuals)
    }

    fn lineariser(&self) -> Result<Lineariser<'_>, IdentifyError> {
        let at = self.fit.fitted.coefficients();
        Lineariser::new(self.fit.fitted.model(), self.data, self.fit.noise, at)
    }

    fn expand(&self, grouped: &DVector<f64>) -> Vec<f64> {
        self.fit.reduction.expand(grouped.as_slice(), self.fit.fitted.coefficients().len())
    }
}

/// R⁻¹ z, unless the triangle has lost rank.
fn triangle_solve(factor: &Factor) -> Option<DVector<f64>> {
    let norms = factor.column_norms();
    let lost = (0..factor.columns()).any(|k| factor.r[(k, k)].abs() <= 1e-10 * norms[k]);
    if lost {
        return None;
    }
    factor.r.solve_upper_triangular(&factor.z.column(0).into_owned())
}
