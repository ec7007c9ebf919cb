//! A fitted model with what is known about the fit.

use super::warnings::Warning;
use crate::freedom::{Freedom, Taken};
use crate::reduction::Reduction;
use crate::student::student_quantile;
use crate::{IdentifyError, NoiseModel, Prior, Residuals, Spread};
use truepose_errormodel::{Dataset, FittedModel, Visits};
use truepose_solvers::Solution;
use truepose_solvers::accumulator::Factor;

/// A fitted model and everything that is known about the fit.
#[derive(Debug, Clone)]
pub struct Fit {
    /// The model with its coefficients and their covariance.
    pub fitted: FittedModel,
    /// What was reduced away, and what each kept coefficient stands for.
    pub reduction: Reduction,
    /// Standard deviations, given or estimated.
    pub noise: NoiseModel,
    /// Residuals on the data of the fit.
    pub residuals: Residuals,
    /// Whitened triangular factor of `[A B | r + A c]` at the solution: the small problem that says it all.
    pub factor: Factor,
    /// The prior on the grouped errors, with the κ that was used.
    pub prior: Prior,
    /// Rounds that were taken.
    pub rounds: usize,
    /// Whether the last round moved nothing any more; always of a single linear step, which is meant to be one.
    pub converged: bool,
    /// Whether rounds went on at the exact robot; otherwise this is a single linear step.
    pub refined: bool,
    /// Measured numbers m.
    pub observations: usize,
    /// Sum of whitened squares at the solution.
    pub chi_square: f64,
    /// What the solver said last.
    pub solution: Solution,
    /// Parameters in which effects are not linear, where they were looked for; the model of `fitted` holds their values.
    pub shapes: Vec<FittedNonlinear>,
    /// What their uncertainty adds to the variance of each coefficient of the model; empty without any.
    pub unknown_shapes: Vec<f64>,
    /// What was left to scatter where the noise was estimated; none where it was given, or comes from other rows.
    pub scatter: Option<Freedom>,
    /// Things that a user should know.
    pub warnings: Vec<Warning>,
}

impl Fit {
    /// Degrees of freedom of the noise that intervals rest on, at least one: where visits share what differs from one to the next, those
    /// between visits, for more rows of a visit say no more about it; otherwise m − r, or what positions or orientations alone have left.
    pub fn degrees_of_freedom(&self) -> usize {
        let shapes = self.shapes.len();
        let all = self.observations.saturating_sub(self.reduction.rank() + shapes);
        let fewest = self.scatter.map(|left| match self.noise.visit_sd > 0.0 {
            true => left.between,
            false if left.turns > 0.0 && left.positions() > 0.0 => left.positions().min(left.turns),
            false => left.positions() + left.turns,
        });
        fewest.map_or(all, |fewest| (fewest.round() as usize).saturating_sub(shapes).min(all)).max(1)
    }

    /// Half width of the 95 % interval of each coefficient of the model, in its unit; zero for dropped ones.
    pub fn half_widths(&self) -> Vec<f64> {
        let quantile = student_quantile(0.975, self.degrees_of_freedom());
        let covariance = self.fitted.covariance();
        let more = |k: usize| self.unknown_shapes.get(k).copied().unwrap_or(0.0);
        (0..covariance.nrows()).map(|k| quantile * (covariance[(k, k)].max(0.0) + more(k)).sqrt()).collect()
    }

    /// Statistics of the 3-D position error on the data of the fit, m.
    pub fn positions(&self) -> Spread {
        self.residuals.positions()
    }
}

/// A parameter that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedNonlinear {
    /// Which effect of the model.
    pub effect: usize,
    /// Its name.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Value.
    pub value: f64,
    /// Its 95 % interval; of an instant between the last visit that can be before it and the first that can be after it.
    pub interval: [f64; 2],
    /// The range in which it was looked for.
    pub range: [f64; 2],
}

impl FittedNonlinear {
    /// Whether the data leaves it open: the interval is the whole range.
    pub fn open(&self) -> bool {
        self.interval[0] <= self.range[0] && self.interval[1] >= self.range[1]
    }

    /// Whether it lies at an end of its range: the best value is then not inside.
    pub fn at_bound(&self) -> bool {
        let [lower, upper] = self.range;
        let near = 1e-6 * (upper - lower);
        self.value <= lower + near || self.value >= upper - near
    }
}

impl Freedom {
    /// Of a fit on its data.
    ///
    /// # Errors
    /// When the data is not that of the fit.
    pub fn of(fit: &Fit, data: &Dataset) -> Result<Self, IdentifyError> {
        let model = fit.fitted.model();
        let data = &*data.derived_for(model)?;
        let taken = Taken {
            model,
            data,
            visits: &Visits::of(data),
            noise: fit.noise,
            coefficients: fit.fitted.coefficients(),
            kept: &fit.reduction.kept,
        };
        taken.left(&fit.factor, &fit.prior)
    }
}
