//! A prior on the grouped errors that does not depend on which members of a group were kept.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | s | expected sizes of all columns | p | each its own |
//! | G | grouping, β = G c: 1 at the kept column, −c_j at what passes into it | r × p | |
//! | κ | `kappa` | 1 | 1 |
//! | w | `widths`: of each kind, 1 at the least | kinds | 1 |
//! | Σ = κ² G W² S² Gᵀ | prior covariance of β | r × r | |
//! | R Σ₁^{1/2} = U diag(d) Vᵀ | whitened data in prior units (κ = 1) | r × r | 1 |
//!
//! κ comes from the data, by the marginal likelihood of `t = Uᵀ z ~ N(0, 1 + κ² d²)`:
//! `min_κ Σ_k ln(1 + κ² d_k²) + t_k² / (1 + κ² d_k²)` (Robbins 1956; MacKay 1992; here in the form for ridge
//! regression). Directions with κ d ≫ 1 are untouched: for them the fit is least squares.
//!
//! The unknowns of one family in one unit are a *kind*. One that is much larger than its expected size beside the others, soft springs
//! among well made frames, would be drawn towards zero by a κ that the others ask for, and its intervals would not hold it. Such a kind
//! gets a width of its own, `w² ← w² Σ u² / Σ γ` over its columns until it stays (MacKay 1992), with
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | Q = Σ^{−1/2} κ G W S | members of the groups in prior units | r × p |
//! | X = R Σ^{1/2}, H = I − (XᵀX + I)⁻¹ | what the data decides | r × r |
//! | u = Qᵀ Σ^{−1/2} β | the most likely errors in prior units | p |
//! | γ_j = (Qᵀ H Q)_jj | how much of u_j the data decides, 0…1 | p |
//!
//! Unknowns that are counted from where an earlier fit has found them have a width that holds them to nothing: places of landmarks, unknowns of
//! sensors, a base, tool or target that was not known, the bases of further sessions. κ is looked for without those of the installation. None gets narrower than κ: what the data leaves open would seem to be known to be nothing. And a kind of few unknowns is held no closer
//! than ten expected sizes: what the many others are like says nothing of a gap or a spring, and one or two of them say too little
//! about what is usual.

use crate::IdentifyError;
use crate::evidence::{Evidence, LEAST, MOST, START};
use crate::reduction::{Group, Reduction};
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::effects::{Landmarks, Observed, Own, Session};
use truepose_errormodel::{Effect, ErrorModel};
use truepose_solvers::accumulator::{Factor, Triangular};
use truepose_solvers::kernels::{cholesky_lower, gram, solve_lower_many};

/// How strongly coefficients are held to their expected sizes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PriorStrength {
    /// Not at all: plain least squares.
    None,
    /// Standard deviations of κ expected sizes.
    Fixed(f64),
    /// κ from the data, by marginal likelihood.
    Evidence,
    /// κ from the data, and a width of its own for each kind of unknown (of one family, in one unit) that is larger than the others
    /// let expect, or has few.
    VarianceGroups,
}

impl PriorStrength {
    /// Whether the data is asked for κ.
    pub(crate) fn asks_the_data(self) -> bool {
        matches!(self, PriorStrength::Evidence | PriorStrength::VarianceGroups)
    }
}

/// A prior for the kept columns: rows `W (β + δ) = 0` with `WᵀW = Σ⁻¹`.
#[derive(Debug, Clone, PartialEq)]
pub struct Prior {
    /// L⁻¹ of `G S² Gᵀ = L Lᵀ`, r × r, for κ = 1.
    unit: DMatrix<f64>,
    /// L.
    spread: DMatrix<f64>,
    /// κ; infinite without a prior.
    pub kappa: f64,
    /// w, one a kind of unknown.
    pub widths: Vec<f64>,
    /// Groups with an error of an installation that was found.
    free: Vec<usize>,
}

impl Prior {
    /// No prior, before there is a reduction.
    pub(crate) fn none() -> Self {
        Prior {
            unit: DMatrix::zeros(0, 0),
            spread: DMatrix::zeros(0, 0),
            kappa: f64::INFINITY,
            widths: Vec::new(),
            free: Vec::new(),
        }
    }

    /// The prior over a reduction's groups, with κ still at its start.
    pub fn new(model: &ErrorModel, reduction: &Reduction, strength: PriorStrength) -> Self {
        let kappa = match strength {
            PriorStrength::None => f64::INFINITY,
            PriorStrength::Fixed(kappa) => kappa,
            PriorStrength::Evidence | PriorStrength::VarianceGroups => START,
        };
        let recentred = recentred(model);
        let widths = recentred.into_iter().map(|flat| if flat { FLAT } else { 1.0 }).collect();
        Self::wide(model, reduction, kappa, widths)
    }

    /// With these widths of the kinds.
    pub(crate) fn wide(model: &ErrorModel, reduction: &Reduction, kappa: f64, widths: Vec<f64>) -> Self {
        let rank = reduction.rank();
        let scale = |c: usize| model.columns()[c].scale;
        let grouped = members(model, reduction, &widths);
        let mut spread = root(&grouped);
        let mut unit = DMatrix::identity(rank, rank);
        solve_lower_many(&spread, &mut unit);
        for (k, group) in reduction.groups.iter().enumerate() {
            unit.column_mut(k).scale_mut(1.0 / scale(group.column));
            spread.row_mut(k).scale_mut(scale(group.column));
        }
        let held_to_nothing = |group: &Group| {
            let members = group.members.iter().filter(|(_, share)| *share != 0.0).map(|(column, _)| *column);
            std::iter::once(group.column).chain(members).any(|column| installed(model, column))
        };
        let free = (0..rank).filter(|&k| held_to_nothing(&reduction.groups[k])).collect();
        Prior { unit, spread, kappa, widths, free }
    }

    /// W, r × r; none without a prior.
    pub fn rows(&self) -> Option<DMatrix<f64>> {
        self.kappa.is_finite().then(|| &self.unit / self.kappa)
    }

    /// κ of a kind of few unknowns that is not yet in the model.
    pub(crate) fn of_few(&self, strength: PriorStrength) -> f64 {
        if strength == PriorStrength::VarianceGroups { self.kappa.max(LOOSE) } else { self.kappa }
    }

    /// How many times wider than its expected size, on top of κ, each column of the model is held: the width w of its kind.
    pub fn widths_of_columns(&self, model: &ErrorModel) -> Vec<f64> {
        let found =
            |column: usize| model.columns()[column].site.is_some_and(|site| model.chain().was_found(site));
        let width = |(column, kind): (usize, usize)| match found(column) {
            // Any model on this robot holds it to nothing.
            true => 1.0,
            false => self.widths.get(kind).copied().unwrap_or(1.0),
        };
        kinds(model).0.into_iter().enumerate().map(width).collect()
    }

    /// L = W₁⁻¹, r × r.
    pub(crate) fn spread(&self) -> &DMatrix<f64> {
        &self.spread
    }

    /// W for κ = 1, whatever κ is: what "an expected size" means for each direction.
    pub fn unit_rows(&self) -> &DMatrix<f64> {
        &self.unit
    }

    /// ‖W β‖².
    pub fn penalty(&self, grouped: &[f64]) -> f64 {
        if !self.kappa.is_finite() {
            return 0.0;
        }
        (&self.unit * DVector::from_column_slice(grouped)).norm_squared() / (self.kappa * self.kappa)
    }

    /// The most likely grouped errors when coarser groups `G β` have these values: `Σ Gᵀ (G Σ Gᵀ)⁻¹ values`; none where those
    /// groups are not independent.
    pub(crate) fn shared_out(&self, groups: &DMatrix<f64>, values: &[f64]) -> Option<DVector<f64>> {
        let spread = groups * &self.spread;
        let covariance = &spread * spread.transpose();
        let pulled = covariance.cholesky()?.solve(&DVector::from_column_slice(values));
        Some(&self.spread * spread.tr_mul(&pulled))
    }

    /// The factor with the prior's rows, given that its unknowns are `β − at` (zero for absolute ones).
    ///
    /// # Errors
    /// When a factorisation fails.
    pub fn joined(&self, factor: &Factor, at: &[f64]) -> Result<Factor, IdentifyError> {
        let Some(rows) = self.rows() else { return Ok(factor.clone()) };
        let pull = -(&rows * DVector::from_column_slice(at));
        let mut all = Triangular::new(factor.columns(), 1);
        all.update(&factor.r, &factor.z)?;
        all.update(&rows, &DMatrix::from_column_slice(pull.len(), 1, pull.as_slice()))?;
        let mut joined = all.finish();
        joined.rss[0] += factor.rss[0];
        Ok(joined)
    }

    /// With κ from the data: `factor` is whitened, over the kept columns, with absolute coefficients on its right.
    ///
    /// # Errors
    /// When a factorisation fails.
    pub fn from_evidence(&self, factor: &Factor) -> Result<Self, IdentifyError> {
        let evidence = Evidence::new(factor, &self.spread, &self.free)?;
        Ok(Prior { kappa: evidence.kappa(), ..self.clone() })
    }

    /// κ and a factor on all standard deviations, by the marginal likelihood of a first linear picture; κ stays where it is not asked, and
    /// the factor is 1 where no number of measurements is given. `factor` as in [`Prior::from_evidence`].
    pub(crate) fn at_first_sight(
        &self,
        factor: &Factor,
        numbers: Option<usize>,
        ask: bool,
    ) -> Result<(f64, f64), IdentifyError> {
        let evidence = Evidence::new(factor, &self.spread, &self.free)?;
        Ok(match (numbers, ask) {
            (None, true) => (evidence.kappa(), 1.0),
            (None, false) => (self.kappa, 1.0),
            (Some(numbers), true) => evidence.kappa_and_scale(factor.rss[0], numbers),
            (Some(numbers), false) => (self.kappa, evidence.scale(self.kappa, factor.rss[0], numbers)),
        })
    }
}

impl Prior {
    /// With the width of each kind nearer to what the data says of it; `factor` as in [`Prior::from_evidence`], `beta` its solution with
    /// this prior. None where there is but one.
    pub(crate) fn by_variance_groups(
        &self,
        model: &ErrorModel,
        reduction: &Reduction,
        factor: &Factor,
        beta: &[f64],
    ) -> Option<Self> {
        if self.widths.len() < 2 {
            return None; // what κ says is all there is to say
        }
        let rank = reduction.rank();
        // Q: the columns' sizes over those of their groups drop out of L⁻¹ G S.
        let mut sized = members(model, reduction, &self.widths);
        for (row, group) in reduction.groups.iter().enumerate() {
            sized.row_mut(row).scale_mut(model.columns()[group.column].scale);
        }
        let members = &self.unit * sized;
        let data = &factor.r * &self.spread * self.kappa;
        let own = data.tr_mul(&data);
        // qᵀ H q = |q|² − |C⁻¹ q|² with XᵀX + I = C Cᵀ.
        let open = (own + DMatrix::identity(rank, rank)).cholesky()?.l().solve_lower_triangular(&members)?;
        let likely = members.tr_mul(&(&self.unit * DVector::from_column_slice(beta) / self.kappa));
        let (kinds, count) = kinds(model);
        let mut sums = vec![(0, 0.0, 0.0); count];
        for (column, &kind) in kinds.iter().enumerate() {
            let (columns, squares, decided) = &mut sums[kind];
            *columns += 1;
            *squares += likely[column] * likely[column];
            *decided += members.column(column).norm_squared() - open.column(column).norm_squared();
        }
        let mut widths = self.widths.clone();
        let adapted = widths.iter_mut().zip(sums).zip(recentred(model)).filter(|(_, flat)| !flat);
        for ((width, (columns, squares, decided)), _) in adapted {
            let least = if columns <= FEW { (LOOSE / self.kappa).max(1.0) } else { 1.0 };
            // A kind of which the data decides next to nothing has no size to be seen.
            let seen = if decided > LEAST_DECIDED { *width * (squares / decided).sqrt() } else { *width };
            *width = seen.clamp(least, least.max(MOST / LEAST));
        }
        Some(Self::wide(model, reduction, self.kappa, widths))
    }
}

/// G W S over the kept columns' sizes, so that the Cholesky factor of its square is well conditioned; r × p.
fn members(model: &ErrorModel, reduction: &Reduction, widths: &[f64]) -> DMatrix<f64> {
    let width: Vec<f64> = kinds(model).0.into_iter().map(|kind| widths[kind]).collect();
    let scale = |c: usize| model.columns()[c].scale;
    let mut grouped = DMatrix::zeros(reduction.rank(), width.len());
    for (row, group) in reduction.groups.iter().enumerate() {
        grouped[(row, group.column)] = width[group.column];
        for &(column, coefficient) in &group.members {
            grouped[(row, column)] = coefficient * width[column] * scale(column) / scale(group.column);
        }
    }
    grouped
}

/// L of `G Gᵀ = L Lᵀ`.
fn root(grouped: &DMatrix<f64>) -> DMatrix<f64> {
    let rank = grouped.nrows();
    let mut covariance = DMatrix::zeros(rank, rank);
    gram(&mut covariance, &grouped.transpose());
    let Some(mut root) = cholesky_lower(covariance, rank) else {
        // Sizes too far apart for the quick way.
        let covariance = grouped * grouped.transpose();
        return covariance.cholesky().map_or_else(|| DMatrix::identity(rank, rank), |c| c.unpack());
    };
    root.fill_upper_triangle(0.0, 1);
    root
}

/// A kind of no more unknowns than this is held no closer than so many expected sizes.
const FEW: usize = 10;
const LOOSE: f64 = 10.0;

/// The kind of each column, and how many kinds there are: those of one family in one unit, of which what is held to nothing is one of its own.
fn kinds(model: &ErrorModel) -> (Vec<usize>, usize) {
    let flat = flat_columns(model);
    let mut known: Vec<(&str, &str, bool)> = Vec::new();
    let mut of = Vec::with_capacity(model.columns().len());
    for effect in 0..model.effects().len() {
        for column in model.columns_of(effect) {
            let unit = model.columns()[column].unit.as_str();
            let kind = (model.effects()[effect].kind(), unit, flat[column]);
            let place = known.iter().rposition(|k| *k == kind).unwrap_or_else(|| {
                known.push(kind);
                known.len() - 1
            });
            of.push(place);
        }
    }
    let count = known.len();
    (of, count)
}

/// What is counted from where an earlier fit has found it is near zero, which says nothing of how well it is known: it is held by so many of its
/// expected sizes, which is nothing.
const FLAT: f64 = 1e3;

/// For each column: whether it is counted from where it was found.
fn flat_columns(model: &ErrorModel) -> Vec<bool> {
    let own = [Landmarks::FAMILY, Observed::FAMILY];
    let flat = |column: usize| {
        own.contains(&model.effects()[model.effect_of(column)].kind()) || installed(model, column)
    };
    (0..model.columns().len()).map(flat).collect()
}

/// Whether a column is of a base, tool or target that was found, or of the base of a further session.
fn installed(model: &ErrorModel, column: usize) -> bool {
    let base = |of: &Session| of.own == Own::Base;
    model.effects()[model.effect_of(column)].concrete::<Session>().is_some_and(base)
        || model.columns()[column].site.is_some_and(|site| model.chain().was_found(site))
}

/// For each kind: whether its unknowns are counted from where they were found.
fn recentred(model: &ErrorModel) -> Vec<bool> {
    let (kinds, count) = kinds(model);
    let mut flat = vec![false; count];
    kinds.into_iter().zip(flat_columns(model)).for_each(|(kind, of)| flat[kind] = of);
    flat
}

/// Columns, in sum, of which the data has to decide before their kind's width is looked at.
const LEAST_DECIDED: f64 = 0.1;

#[cfg(test)]
mod tests;
