//! The linear picture in which shape parameters are looked for: everything but the columns of their effects projected out.

use crate::linearise::{Lineariser, Stations, stand};
use crate::{Fit, FitOptions, IdentifyError, NoiseModel, NoiseSource};
use nalgebra::{DMatrix, DVector};
use std::sync::OnceLock;
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, NonlinearParameter, Signal, Visits};
use truepose_solvers::accumulator::Triangular;

/// The effects that leave parameters free.
pub(super) struct Trial {
    /// Which effects of the model, in order.
    effects: Vec<(usize, Box<dyn AnyEffect>)>,
    /// For each free parameter: the position in `effects`.
    pub owner: Vec<usize>,
    /// Expected sizes of the columns of each.
    scales: Vec<Vec<f64>>,
}

impl Trial {
    pub fn new(model: &ErrorModel, free: &[(usize, NonlinearParameter)]) -> Result<Self, IdentifyError> {
        let mut effects: Vec<(usize, Box<dyn AnyEffect>)> = Vec::new();
        let mut owner = Vec::new();
        for (k, _) in free {
            if effects.last().is_none_or(|last| last.0 != *k) {
                effects.push((*k, model.effects()[*k].clone()));
            }
            owner.push(effects.len() - 1);
        }
        let scales = effects
            .iter()
            .map(|(k, _)| model.columns()[model.columns_of(*k)].iter().map(|c| c.scale).collect())
            .collect();
        Ok(Trial { effects, owner, scales })
    }

    /// How many effects.
    pub fn len(&self) -> usize {
        self.effects.len()
    }

    /// The values that belong to one of the effects.
    fn values(&self, effect: usize, theta: &[f64]) -> Vec<f64> {
        theta.iter().zip(&self.owner).filter(|(_, owner)| **owner == effect).map(|(v, _)| *v).collect()
    }
}

/// The picture.
pub(super) struct Picture<'a> {
    pub trial: &'a Trial,
    pub data: &'a Dataset,
    pub visits: Visits,
    /// The robot at which columns are taken: its model and coefficients.
    at: (ErrorModel, Vec<f64>),
    noise: NoiseModel,
    /// Square roots of the weights that a robust solver ended with, visit by visit.
    weights: Option<Vec<Vec<f64>>>,
    /// Visits that are looked at.
    used: Vec<usize>,
    /// Where it stands in the visits that are looked at, once that was asked for.
    stations: OnceLock<Stations>,
    /// Basis of all other columns, with their rows of the prior below.
    q: DMatrix<f64>,
    /// Their triangle: the columns are `q` times it.
    pub triangle: DMatrix<f64>,
    /// ỹ.
    pub target: DVector<f64>,
    /// Rows of the prior in the columns of each effect.
    prior: Vec<DMatrix<f64>>,
    /// Which columns of each effect take part.
    kept: Vec<Vec<usize>>,
    /// Where the other columns stand among those that the fit kept, and where those of the effects do.
    pub places: (Vec<usize>, Vec<usize>),
    /// Coefficients of the columns of the effects that take part; none before they were fitted.
    pub coefficients: DVector<f64>,
}

impl<'a> Picture<'a> {
    /// Beside a model that lacks the effects altogether, on at most so many visits, evenly taken.
    pub fn without(
        rest: &ErrorModel,
        base: Option<&Fit>,
        trial: &'a Trial,
        data: &'a Dataset,
        most: usize,
        options: &FitOptions,
    ) -> Result<Self, IdentifyError> {
        let noise = match (base, options.noise) {
            (Some(fit), _) => fit.noise,
            (None, NoiseSource::Fixed(noise)) => noise,
            (None, NoiseSource::Estimate) => NoiseModel::default(),
        };
        let others = base.map_or_else(Vec::new, |fit| fit.reduction.kept.clone());
        let above = base.and_then(|fit| fit.prior.rows()).unwrap_or_else(|| DMatrix::zeros(0, others.len()));
        // Each of the effects' columns is held by its own expected size, as in the fit to come.
        let kappa = base.map_or(f64::INFINITY, |fit| fit.prior.of_few(options.prior));
        let own: usize = trial.scales.iter().map(Vec::len).sum();
        let height = above.nrows() + if kappa.is_finite() { own } else { 0 };
        let mut next = above.nrows();
        let rows = |scales: &Vec<f64>| {
            let mut rows = DMatrix::zeros(height, scales.len());
            if kappa.is_finite() {
                for (k, scale) in scales.iter().enumerate() {
                    rows[(next, k)] = 1.0 / (kappa * scale);
                    next += 1;
                }
            }
            rows
        };
        let prior = trial.scales.iter().map(rows).collect();
        let visits = Visits::of(data);
        let step = visits.len().div_ceil(most).max(1);
        let picture = Picture {
            used: (0..visits.len()).step_by(step).collect(),
            at: (rest.clone(), base.map_or_else(Vec::new, |fit| fit.fitted.coefficients().to_vec())),
            weights: base.and_then(|fit| weights(fit, data, &visits)),
            stations: OnceLock::new(),
            q: DMatrix::zeros(0, 0),
            triangle: DMatrix::zeros(0, 0),
            target: DVector::zeros(0),
            kept: trial.scales.iter().map(|s| (0..s.len()).collect()).collect(),
            places: (Vec::new(), Vec::new()),
            coefficients: DVector::zeros(0),
            trial,
            data,
            visits,
            noise,
            prior,
        };
        picture.projected(&others, above.resize_vertically(height, 0.0))
    }

    /// At a fit that has the effects.
    pub fn at(fit: &Fit, trial: &'a Trial, data: &'a Dataset) -> Result<Self, IdentifyError> {
        Picture::on(fit, trial, data, usize::MAX)
    }

    /// As [`Picture::at`], on at most so many visits, evenly taken.
    pub fn on(fit: &Fit, trial: &'a Trial, data: &'a Dataset, most: usize) -> Result<Self, IdentifyError> {
        let model = fit.fitted.model();
        let all = &fit.reduction.kept;
        let rows = fit.prior.rows().unwrap_or_else(|| DMatrix::zeros(0, all.len()));
        let (mut kept, mut prior, mut mine) = (Vec::new(), Vec::new(), Vec::new());
        for (k, _) in &trial.effects {
            let range = model.columns_of(*k);
            let places: Vec<usize> = (0..all.len()).filter(|&p| range.contains(&all[p])).collect();
            kept.push(places.iter().map(|&p| all[p] - range.start).collect::<Vec<usize>>());
            prior.push(rows.select_columns(&places));
            mine.extend(places);
        }
        let others: Vec<usize> = (0..all.len()).filter(|p| !mine.contains(p)).collect();
        let columns: Vec<usize> = others.iter().map(|&p| all[p]).collect();
        let above = rows.select_columns(&others);
        let visits = Visits::of(data);
        let at = fit.fitted.coefficients();
        let picture = Picture {
            used: (0..visits.len()).step_by(visits.len().div_ceil(most).max(1)).collect(),
            at: (model.clone(), at.to_vec()),
            weights: weights(fit, data, &visits),
            stations: OnceLock::new(),
            q: DMatrix::zeros(0, 0),
            triangle: DMatrix::zeros(0, 0),
            target: DVector::zeros(0),
            coefficients: DVector::from_iterator(mine.len(), mine.iter().map(|&p| at[all[p]])),
            places: (others, mine),
            noise: fit.noise,
            trial,
            data,
            visits,
            prior,
            kept,
        };
        picture.projected(&columns, above)
    }

    /// Makes basis and target from these columns of the model and their rows of the prior.
    fn projected(mut self, columns: &[usize], above: DMatrix<f64>) -> Result<Self, IdentifyError> {
        let (model, at) = &self.at;
        let data = self.data.derived_for(model)?;
        let mut lineariser = Lineariser::new(model, &data, self.noise, at)?;
        let whole = self.rows(&mut lineariser);
        let p = at.len();
        let y = whole.column(p) + whole.columns(0, p) * DVector::from_column_slice(at);
        let (rows, height) = (whole.nrows(), above.nrows());
        let mut a = whole.select_columns(columns).resize_vertically(rows + height, 0.0);
        a.rows_mut(rows, height).copy_from(&above);
        let y = y.resize_vertically(rows + height, 0.0);
        if !columns.is_empty() {
            let mut triangle = Triangular::new(columns.len(), 1);
            triangle.update(&a, &DMatrix::from_column_slice(y.len(), 1, y.as_slice()))?;
            self.triangle = triangle.finish().r;
            let turned = self.triangle.tr_solve_upper_triangular(&a.transpose());
            let lost = || IdentifyError::NoAnswer {
                solver: "shape".into(),
                status: "the columns beside the effect depend on each other".into(),
            };
            self.q = turned.ok_or_else(lost)?.transpose();
        } else {
            self.q = DMatrix::zeros(rows + height, 0);
        }
        self.target = &y - &self.q * self.q.tr_mul(&y);
        Ok(self)
    }

    /// Weighted rows of the visits that are looked at: columns, then residual.
    fn rows(&self, lineariser: &mut Lineariser<'_>) -> DMatrix<f64> {
        let width = lineariser.width();
        let mut flat: Vec<f64> = Vec::new();
        for &visit in &self.used {
            let start = flat.len();
            flat.extend_from_slice(lineariser.visit(&self.visits.rows[visit]).rows);
            if let Some(weights) = &self.weights {
                for (row, w) in flat[start..].chunks_exact_mut(width).zip(&weights[visit]) {
                    row.iter_mut().for_each(|v| *v *= w);
                }
            }
        }
        DMatrix::from_row_slice(flat.len() / width, width, &flat)
    }

    /// Share of the visits that are looked at.
    pub fn share(&self) -> f64 {
        self.used.len() as f64 / self.visits.len().max(1) as f64
    }

    /// Where the columns of one effect stand among those of all.
    pub fn columns_of(&self, effect: usize) -> std::ops::Range<usize> {
        let first: usize = self.kept[..effect].iter().map(Vec::len).sum();
        first..first + self.kept[effect].len()
    }

    /// Columns of one effect with these values of all parameters, their rows of the prior below.
    pub fn columns(&self, effect: usize, theta: &[f64]) -> Result<DMatrix<f64>, IdentifyError> {
        self.columns_on(self.data, self.shaped(effect, theta)?, effect)
    }

    /// A model of one effect with these values of all parameters.
    fn shaped(&self, effect: usize, theta: &[f64]) -> Result<ErrorModel, IdentifyError> {
        let shaped = self.trial.effects[effect].1.with_nonlinear(&self.trial.values(effect, theta));
        Ok(ErrorModel::new(self.at.0.chain().clone(), vec![shaped])?)
    }

    fn columns_on(
        &self,
        data: &Dataset,
        model: ErrorModel,
        effect: usize,
    ) -> Result<DMatrix<f64>, IdentifyError> {
        let derived = data.derived_for(&model)?;
        let derived = match derived.derived_for(&self.at.0)? {
            std::borrow::Cow::Owned(both) => std::borrow::Cow::Owned(both),
            std::borrow::Cow::Borrowed(_) => derived,
        };
        let zero = vec![0.0; model.columns().len()];
        let lineariser = Lineariser::new(&model, &derived, self.noise, &zero)?;
        // Effects that read the data's channels may be asked about others than those of the picture: then nothing is known beforehand.
        let mut lineariser = match std::ptr::eq(data, self.data) {
            true => lineariser.at_stations(self.stations(&derived)?),
            false => lineariser.beside(&self.at.0, &self.at.1)?,
        };
        let whole = self.rows(&mut lineariser).select_columns(&self.kept[effect]);
        let (rows, prior) = (whole.nrows(), &self.prior[effect]);
        let mut columns = whole.resize_vertically(rows + prior.nrows(), 0.0);
        columns.rows_mut(rows, prior.nrows()).copy_from(prior);
        Ok(columns)
    }

    /// Where the robot stands in the visits that are looked at; `data` has the channels that its model reads.
    fn stations(&self, data: &Dataset) -> Result<&Stations, IdentifyError> {
        if let Some(known) = self.stations.get() {
            return Ok(known);
        }
        let rows = self.used.iter().flat_map(|&visit| self.visits.rows[visit].iter().copied());
        let stations = stand(&self.at.0, data, &self.at.1, rows)?;
        Ok(self.stations.get_or_init(|| stations))
    }

    /// Of an effect that follows a channel late: the channel, the lag, and how much the rows change with a unit of what the effect sees; the
    /// effect's coefficients are `b`.
    pub fn late(
        &self,
        effect: usize,
        theta: &[f64],
        b: &DVector<f64>,
    ) -> Result<Option<(usize, f64, DVector<f64>)>, IdentifyError> {
        let model = self.shaped(effect, theta)?;
        let mut bent = self.data.derived_for(&model)?.into_owned();
        for need in model.effects()[0].needs() {
            let Signal::Channel(name) = &need else { continue };
            let (Some((channel, lag)), Some(at)) = (self.data.late(name), bent.schema.channel(name)) else {
                continue;
            };
            let before = self.columns_on(&bent, self.shaped(effect, theta)?, effect)?;
            bent.channels[at].iter_mut().for_each(|value| *value += 1.0);
            let after = self.columns_on(&bent, model, effect)?;
            return Ok(Some((channel, lag, (after - before) * b)));
        }
        Ok(None)
    }

    /// For each row of the picture the place of its visit among all.
    pub fn visit_of_rows(&self) -> Vec<usize> {
        let count = |visit: usize| -> usize {
            self.visits.rows[visit].iter().map(|&row| self.data.seen(row).count()).sum()
        };
        self.used.iter().flat_map(|&visit| std::iter::repeat_n(visit, count(visit))).collect()
    }

    /// Basis of all other columns.
    pub fn basis(&self) -> &DMatrix<f64> {
        &self.q
    }

    /// The robot.
    pub fn chain(&self) -> &'_ truepose_kinematics::Chain {
        self.at.0.chain()
    }

    /// What no other column reaches.
    pub fn beyond(&self, columns: DMatrix<f64>) -> DMatrix<f64> {
        let along = self.q.tr_mul(&columns);
        columns - &self.q * along
    }

    /// The part of other columns in these: `q` times it is what [`Picture::beyond`] takes away.
    pub fn along(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        self.q.tr_mul(columns)
    }

    /// Columns of all effects, side by side.
    pub fn all(&self, theta: &[f64]) -> Result<DMatrix<f64>, IdentifyError> {
        let mut all = DMatrix::zeros(self.target.len(), 0);
        for effect in 0..self.trial.len() {
            let columns = self.columns(effect, theta)?;
            let at = all.ncols();
            all = all.resize_horizontally(at + columns.ncols(), 0.0);
            all.columns_mut(at, columns.ncols()).copy_from(&columns);
        }
        Ok(all)
    }
}

/// Square roots of the weights that a robust solver ended with, visit by visit.
fn weights(fit: &Fit, data: &Dataset, visits: &Visits) -> Option<Vec<Vec<f64>>> {
    let mut all = fit.solution.info.row_weights.as_ref()?.iter().map(|w| w.sqrt());
    let count = |rows: &Vec<usize>| rows.iter().map(|&row| data.seen(row).count()).sum();
    Some(visits.rows.iter().map(|rows| all.by_ref().take(count(rows)).collect()).collect())
}
