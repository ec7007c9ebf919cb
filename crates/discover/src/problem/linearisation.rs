//! The data as the present model sees it: linearised once, so that every candidate costs a product.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | J | `sites`: error Jacobian of every measured number at the real robot | m × sites | m or rad per m or rad |
//! | A | `base`: design matrix of the present model, its kept columns | m × r | m or rad per unit |
//! | y | `y`: residual + A β, what the model has to explain | m | m or rad |
//! | W | `prior`: rows that hold β near zero | r × r | 1 per unit |
//! | X | [`Linearisation::columns`]: what a candidate's unknowns, in expected sizes, would do | m × k | m or rad |
//!
//! A candidate's column is `P J_e Φ e_k`, as in the fit: J_e at the real posture, Φ there as well where it depends on what the
//! robot carries, else at the nominal one.

use crate::budget::Budget;
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::change::Change;
use crate::options::DiscoverOptions;
use crate::policy::Policy;
use crate::problem::evaluated::{Evaluated, Station};
use crate::problem::loads::Loads;
use crate::problem::noise::{Levers, Noise};
use crate::problem::normal::Normal;
use crate::problem::observation::{Observation, typical_sd};
use crate::problem::whitening::Whitener;
use crate::statistics::product::gram_matrix;
use nalgebra::{DMatrix, DVector};
use std::any::Any;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::{Arc, OnceLock};
use truepose_errormodel::{AnyEffect, Dataset, Emission, Equilibrium, ErrorJacobian, FittedModel, Visits};
use truepose_identify::Fit;
use truepose_kinematics::{Chain, JointId, JointKind, PostureBuffer, Site, rotation_log};

/// Of a type that this module does not know.
type Kept = OnceLock<Arc<dyn Any + Send + Sync>>;

/// The data, linearised at a fit.
#[derive(Debug)]
pub(crate) struct Linearisation<'a> {
    pub data: &'a Dataset,
    /// The data with the derived channels that the model reads.
    inputs: Cow<'a, Dataset>,
    pub fit: &'a Fit,
    pub policy: &'a Policy,
    pub budget: &'a Budget,
    pub observations: Vec<Observation>,
    /// How many visits the data has.
    pub visits: usize,
    pub base: DMatrix<f64>,
    pub y: DVector<f64>,
    pub prior: Option<DMatrix<f64>>,
    /// WᵀW, once it is needed.
    precision: OnceLock<DMatrix<f64>>,
    pub noise: Noise,
    /// Columns of the model that are not in `base`, though they are in the fit.
    muted: Range<usize>,
    /// How many columns of `base`, its last ones, are those of a wander ([`crate::problem::dependence`]).
    wander: usize,
    sites: Vec<f64>,
    site_count: usize,
    stations: Vec<Station>,
    /// Sums over the numbers, once they are asked for.
    normal: OnceLock<Option<Normal>>,
    levers: OnceLock<Levers>,
    /// What others keep beside it.
    kept: Kept,
    /// Columns of heavier payloads.
    pub(super) loads: Loads,
}

impl<'a> Linearisation<'a> {
    /// Linearises the data at a fit.
    pub fn new(fit: &'a Fit, data: &'a Dataset, options: &'a DiscoverOptions) -> Result<Self, DiscoverError> {
        let model = fit.fitted.model();
        let chain = model.chain();
        let inputs = data.derived_for(model)?;
        let bound = model.bind(&inputs.schema)?;
        let visits = Visits::of(data);
        let site_count = chain.site_count();
        let kept = &fit.reduction.kept;
        let mut place = vec![usize::MAX; model.columns().len()];
        kept.iter().enumerate().for_each(|(k, &c)| place[c] = k);

        let mut linearisation = Linearisation {
            data,
            inputs: inputs.clone(),
            fit,
            policy: &options.policy,
            budget: &options.budget,
            observations: Vec::new(),
            visits: visits.len(),
            base: DMatrix::zeros(0, 0),
            y: DVector::zeros(0),
            prior: fit.prior.rows(),
            precision: OnceLock::new(),
            noise: fit.noise.into(),
            muted: 0..0,
            wander: 0,
            sites: Vec::new(),
            site_count,
            stations: Vec::new(),
            normal: OnceLock::new(),
            levers: OnceLock::new(),
            kept: Kept::new(),
            loads: Loads::default(),
        };
        let (mut flat, mut y) = (Vec::new(), Vec::new());
        let mut rest = Equilibrium::of_rows(model, &inputs, fit.fitted.coefficients())?;
        for (visit, rows) in visits.rows.iter().enumerate() {
            for &row in rows {
                let seen = data.seen(row);
                if seen.count() == 0 {
                    continue;
                }
                let conditions = inputs.conditions(row);
                let first = linearisation.observations.len();
                let stands = linearisation
                    .stations
                    .last()
                    .is_some_and(|s| s.visit == visit && s.conditions == conditions);
                if !stands {
                    // What the model does not read, as the time mostly, does not move the robot.
                    let before = linearisation.stations.last().filter(|last| last.visit == visit);
                    let before = before.filter(|last| bound.same_conditions(&inputs, last.row, row));
                    let [nominal, settled] = match before {
                        Some(last) => [Arc::clone(&last.nominal), Arc::clone(&last.settled)],
                        None => {
                            rest.settle(&bound, &conditions, fit.fitted.coefficients());
                            let mut nominal = PostureBuffer::new(chain);
                            nominal.update(chain, &conditions);
                            let settled =
                                rest.posture_at_rest(&bound, &conditions, fit.fitted.coefficients());
                            [Arc::new(nominal), Arc::new(settled)]
                        }
                    };
                    let observations = first..first;
                    linearisation.stations.push(Station {
                        visit,
                        row,
                        conditions,
                        nominal,
                        settled,
                        observations,
                    });
                }
                let (real, errors) = (rest.real(), rest.errors());
                let jacobian = ErrorJacobian::new(chain, real, errors, data.aim(row));
                let Some(at) = linearisation.stations.last().map(|station| &station.conditions) else {
                    continue;
                };
                let matrix = rest.followed(&bound, at, fit.fitted.coefficients(), jacobian.matrix(chain));
                let difference = data.measured_position(row) - jacobian.point();
                let ray = data.ray(row);
                let along = ray.map(|w| w.transpose() * matrix.fixed_rows::<3>(0));
                let turn = data
                    .measured_rotation(row)
                    .map(|measured| rotation_log(&(measured * real.tool().rotation.transpose())));
                for component in 0..6 {
                    let residual = match component {
                        0 if let Some(w) = &ray => w.dot(&difference),
                        0..3 if seen.position[component] => difference[component],
                        3.. => match turn {
                            Some(turn) => turn[component - 3],
                            None => continue,
                        },
                        _ => continue,
                    };
                    linearisation.observations.push(Observation { row, component, visit });
                    let levers = |site: usize| match (&along, component) {
                        (Some(along), 0) => along[site],
                        _ => matrix[(component, site)],
                    };
                    linearisation.sites.extend((0..site_count).map(levers));
                    let start = flat.len();
                    flat.resize(start + kept.len(), 0.0);
                    for entry in rest.emission().entries() {
                        if place[entry.column] != usize::MAX {
                            flat[start + place[entry.column]] +=
                                entry.value * levers(chain.site_index(entry.site));
                        }
                    }
                    let explained: f64 =
                        flat[start..].iter().zip(kept).map(|(a, &c)| a * fit.fitted.coefficients()[c]).sum();
                    y.push(residual + explained);
                }
                if let Some(station) = linearisation.stations.last_mut() {
                    station.observations.end = linearisation.observations.len();
                }
            }
        }
        linearisation.base = DMatrix::from_row_slice(linearisation.observations.len(), kept.len(), &flat);
        linearisation.y = DVector::from_vec(y);
        Ok(linearisation)
    }

    /// The normal equations of `[A | y]`; none where noise has to be taken number by number.
    pub fn normal(&self) -> Option<&Normal> {
        self.normal.get_or_init(|| Normal::of(&self.observations, self.data, (&self.base, &self.y))).as_ref()
    }

    /// Precision of the prior of the present model's columns, r × r.
    pub fn prior_precision(&self) -> &DMatrix<f64> {
        let r = self.base.ncols();
        let made = || self.prior.as_ref().map_or_else(|| DMatrix::zeros(r, r), gram_matrix);
        self.precision.get_or_init(made)
    }

    /// What a later module keeps beside a problem that does not change any more; new each time if another type is kept already.
    pub fn kept<T: Any + Default + Send + Sync>(&self) -> Arc<T> {
        let kept = Arc::clone(self.kept.get_or_init(|| Arc::new(T::default())));
        kept.downcast().unwrap_or_default()
    }

    /// The whitening of these numbers under a noise model.
    pub fn whitener(&self, noise: impl Into<Noise>) -> Whitener {
        let Noise { rows, joints } = noise.into();
        let whitener = Whitener::new(&self.observations, self.data, rows);
        match joints.is_some() {
            true => whitener.beside(&self.observations, self.levers(), joints),
            false => whitener,
        }
    }

    /// What a unit deviation of each movable joint does to every observation.
    pub fn levers(&self) -> &Levers {
        let motions = || -> Vec<_> {
            let joints = self.chain().movable().iter();
            joints
                .filter_map(|&joint| {
                    let slides = self.chain().joint(joint).kind == JointKind::Prismatic;
                    Some((self.motion(joint)?, slides))
                })
                .collect()
        };
        self.levers.get_or_init(|| Levers::new(&motions(), self.len(), |at| self.sites(at)))
    }

    /// How many numbers were measured.
    pub fn len(&self) -> usize {
        self.observations.len()
    }

    /// What the instrument states of a position's component in the median, m; NaN where it states nothing.
    pub fn typical_sd(&self) -> f64 {
        typical_sd(self.data)
    }

    /// The robot.
    pub fn chain(&self) -> &Chain {
        self.fit.fitted.chain()
    }

    /// Whether columns of other effects were dropped because those of these effects stand for them.
    pub fn entangled(&self, effects: Range<usize>) -> bool {
        let model = self.fit.fitted.model();
        let own = |column: usize| effects.contains(&model.effect_of(column));
        self.fit
            .reduction
            .dropped
            .iter()
            .any(|dropped| !own(dropped.column) && dropped.relation.iter().any(|&(kept, _)| own(kept)))
    }

    /// The same data and the same real robot, as a model sees it that lacks some of its effects, under the same noise. None when the
    /// effects that stay are entangled with those that go.
    pub fn muting(mut self, effects: Range<usize>) -> Option<Self> {
        let model = self.fit.fitted.model();
        if effects.is_empty() {
            return None;
        }
        let muted = model.columns_of(effects.start).start..model.columns_of(effects.end - 1).end;
        if self.entangled(effects) {
            return None;
        }
        let kept = &self.fit.reduction.kept;
        let out: Vec<usize> = (0..kept.len()).filter(|&k| muted.contains(&kept[k])).collect();
        self.base = self.base.remove_columns_at(&out);
        self.prior = self.prior.map(|prior| prior.remove_columns_at(&out).remove_rows_at(&out));
        self.muted = muted;
        self.loads = Loads::default();
        (self.normal, self.precision) = (OnceLock::new(), OnceLock::new());
        self.kept = Kept::new();
        Some(self)
    }

    /// Whether the present model has a constant error at this site, kept or reduced into others.
    pub fn has_constant(&self, site: Site) -> bool {
        let columns = self.fit.fitted.model().columns().iter().enumerate();
        columns.filter(|(k, _)| !self.muted.contains(k)).any(|(_, column)| column.site == Some(site))
    }

    /// The present model's coefficients, those of the columns of `base`; zero for a wander.
    pub fn coefficients(&self) -> DVector<f64> {
        let kept = self.fit.reduction.kept.iter().filter(|column| !self.muted.contains(column));
        let known = kept.map(|&column| self.fit.fitted.coefficients()[column]);
        DVector::from_iterator(self.base.ncols(), known.chain(std::iter::repeat_n(0.0, self.wander)))
    }

    /// Appends the columns of a wander (m × k) to `base`; `prior` are the rows of all columns.
    pub fn join_wander(&mut self, columns: &DMatrix<f64>, prior: DMatrix<f64>) {
        let (r, k) = (self.base.ncols(), columns.ncols());
        self.base = std::mem::replace(&mut self.base, DMatrix::zeros(0, 0)).resize_horizontally(r + k, 0.0);
        self.base.columns_mut(r, k).copy_from(columns);
        self.prior = Some(prior);
        self.wander = k;
        (self.normal, self.precision) = (OnceLock::new(), OnceLock::new());
        self.kept = Kept::new();
    }

    /// The columns of `base` that are those of a wander.
    pub fn wander(&self) -> Range<usize> {
        self.base.ncols() - self.wander..self.base.ncols()
    }

    /// The present model with its coefficients, those of muted effects zero.
    pub fn present(&self) -> Result<FittedModel, DiscoverError> {
        let mut coefficients = self.fit.fitted.coefficients().to_vec();
        coefficients[self.muted.clone()].fill(0.0);
        let model = self.fit.fitted.model().clone();
        Ok(FittedModel::new(model, coefficients, self.fit.fitted.covariance().clone())?)
    }

    /// The data with the derived channels of the present model.
    pub fn inputs(&self) -> &Dataset {
        &self.inputs
    }

    /// Where the robot stood, visit by visit.
    pub fn stations(&self) -> &[Station] {
        &self.stations
    }

    /// How many sites the robot has.
    pub fn site_count(&self) -> usize {
        self.site_count
    }

    /// J of one measured number: what an error at each site does to it.
    pub fn sites(&self, at: usize) -> &[f64] {
        &self.sites[at * self.site_count..(at + 1) * self.site_count]
    }

    /// What these effects say, their unknowns side by side.
    pub fn evaluate(&self, effects: &[Box<dyn AnyEffect>]) -> Result<Evaluated<'_>, DiscoverError> {
        Evaluated::new((self.fit.fitted.model(), &self.stations, &self.inputs), effects)
    }

    /// What effects' unknowns do to every measured number, in m or rad per expected size; m × k.
    pub fn columns(&self, effects: &[Box<dyn AnyEffect>]) -> Result<DMatrix<f64>, DiscoverError> {
        let evaluated = self.evaluate(effects)?;
        let mut columns = DMatrix::zeros(self.len(), evaluated.width());
        evaluated.each(0..self.stations.len(), &mut |station, entries| {
            for at in self.stations[station].observations.clone() {
                let sites = self.sites(at);
                for &(column, site, value) in entries {
                    columns[(at, column)] += value * sites[site];
                }
            }
        })?;
        Ok(columns)
    }

    /// What a candidate would do to every measured number, m or rad per expected size (per kg for a load); m × k.
    pub fn columns_of(&self, candidate: &Candidate) -> Result<DMatrix<f64>, DiscoverError> {
        match &candidate.change {
            Change::CorrectLoad { level, during, .. } => self.heavier(*level, *during),
            Change::Add(effects) => self.columns(effects),
            // Rows that are kept out have no coefficient.
            Change::Exclude { .. } => Ok(DMatrix::zeros(self.len(), 0)),
        }
    }

    /// The sites that a joint's own motion touches, with the share of each.
    pub fn motion(&self, joint: JointId) -> Option<Vec<(usize, f64)>> {
        let motion = self.chain().joint_motion(joint)?;
        let mut emission = Emission::new();
        emission.along(0, &motion, 1.0);
        Some(emission.entries().iter().map(|e| (self.chain().site_index(e.site), e.value)).collect())
    }

    /// How far a joint was moved, rad or m.
    pub fn travel(&self, joint: JointId) -> Option<f64> {
        let column = &self.data.joints[self.chain().coordinate(joint)?];
        let ends = column.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &q| [a.min(q), b.max(q)]);
        Some(ends[1] - ends[0])
    }

    /// A joint's value at a station.
    pub fn joint_at(&self, station: usize, joint: JointId) -> Option<f64> {
        Some(self.stations[station].conditions.joints[self.chain().coordinate(joint)?])
    }
}
