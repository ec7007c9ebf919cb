//! The data as the present model sees it: linearised once, so that every candidate costs a product.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | J | `sites`: error Jacobian of every measured number at the real robot | m × sites | m or rad per m or rad |
//! | A | `base`: design matrix of the present model, its kept columns | m × r | m or rad per unit |
//! | y | `y`: residual + A β, what the model has to explain | m | m or rad |
//! | W | `prior`: rows that hold β near zero | r × r | 1 per unit |
//! | X | [`Scene::columns`]: what a candidate's unknowns, in expected sizes, would do | m × k | m or rad |
//!
//! A candidate's column is `P J_e Φ e_k`, as in the fit: J_e at the real posture, Φ there as well where it depends on what the
//! robot carries, else at the nominal one.

use crate::DiscoverError;
use nalgebra::{DMatrix, DVector};
use truepose_errormodel::{
    AnyEffect, Dataset, Emission, ErrorJacobian, ErrorModel, FittedModel, Rest, Visits,
};
use truepose_identify::{Fit, NoiseModel};
use truepose_kinematics::{Chain, Conditions, JointId, PostureBuffer, rotation_log};

/// One measured number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Observation {
    pub row: usize,
    /// 0…2 position, 3…5 orientation.
    pub component: usize,
    pub visit: usize,
}

/// The data, linearised at a fit.
#[derive(Debug)]
pub(crate) struct Scene<'a> {
    pub data: &'a Dataset,
    pub fit: &'a Fit,
    pub observations: Vec<Observation>,
    /// How many visits the data has.
    pub visits: usize,
    pub base: DMatrix<f64>,
    pub y: DVector<f64>,
    pub prior: Option<DMatrix<f64>>,
    pub noise: NoiseModel,
    sites: Vec<f64>,
    site_count: usize,
    rows: Vec<Row>,
}

/// One row's inputs and postures.
#[derive(Debug, Clone)]
struct Row {
    conditions: Conditions,
    nominal: PostureBuffer,
    /// Frames and wrenches where the real robot comes to rest.
    settled: PostureBuffer,
    /// First observation of the row, and how many.
    first: usize,
    count: usize,
}

impl<'a> Scene<'a> {
    /// Linearises the data at a fit.
    pub fn new(fit: &'a Fit, data: &'a Dataset) -> Result<Self, DiscoverError> {
        let model = fit.fitted.model();
        let chain = model.chain();
        let bound = model.bind(&data.schema)?;
        let visits = Visits::of(data);
        let site_count = chain.site_count();
        let kept = &fit.reduction.kept;
        let mut place = vec![usize::MAX; model.columns().len()];
        kept.iter().enumerate().for_each(|(k, &c)| place[c] = k);

        let mut scene = Scene {
            data,
            fit,
            observations: Vec::new(),
            visits: visits.len(),
            base: DMatrix::zeros(0, 0),
            y: DVector::zeros(0),
            prior: fit.prior.rows(),
            noise: fit.noise,
            sites: Vec::new(),
            site_count,
            rows: Vec::new(),
        };
        let (mut flat, mut y) = (Vec::new(), Vec::new());
        let mut rest = Rest::new(model);
        for (visit, rows) in visits.rows.iter().enumerate() {
            for &row in rows {
                let seen = data.seen(row);
                if seen.count() == 0 {
                    continue;
                }
                let conditions = data.conditions(row);
                rest.settle(&bound, &conditions, fit.fitted.coefficients());
                let (real, errors) = (rest.real(), rest.errors());
                let mut nominal = PostureBuffer::new(chain);
                nominal.update(chain, &conditions);
                let mut settled = nominal.clone();
                settled.settle(chain, &conditions, |frame| *real.after(frame));
                let jacobian = ErrorJacobian::new(chain, real, errors, data.target[row]);
                let matrix = jacobian.matrix(chain);
                let difference = data.measured_position(row) - jacobian.point();
                let turn = data
                    .measured_rotation(row)
                    .map(|measured| rotation_log(&(measured * real.tool().rotation.transpose())));
                let first = scene.observations.len();
                for component in 0..6 {
                    let residual = match component {
                        0..3 if seen.position[component] => difference[component],
                        3.. => match turn {
                            Some(turn) => turn[component - 3],
                            None => continue,
                        },
                        _ => continue,
                    };
                    scene.observations.push(Observation { row, component, visit });
                    scene.sites.extend(matrix.row(component).iter());
                    let start = flat.len();
                    flat.resize(start + kept.len(), 0.0);
                    for entry in rest.emission().entries() {
                        if place[entry.column] != usize::MAX {
                            flat[start + place[entry.column]] +=
                                entry.value * matrix[(component, chain.site_index(entry.site))];
                        }
                    }
                    let explained: f64 =
                        flat[start..].iter().zip(kept).map(|(a, &c)| a * fit.fitted.coefficients()[c]).sum();
                    y.push(residual + explained);
                }
                let count = scene.observations.len() - first;
                scene.rows.push(Row { conditions, nominal, settled, first, count });
            }
        }
        scene.base = DMatrix::from_row_slice(scene.observations.len(), kept.len(), &flat);
        scene.y = DVector::from_vec(y);
        Ok(scene)
    }

    /// How many numbers were measured.
    pub fn len(&self) -> usize {
        self.observations.len()
    }

    /// The robot.
    pub fn chain(&self) -> &Chain {
        self.fit.fitted.chain()
    }

    /// The present model's coefficients, kept ones only.
    pub fn coefficients(&self) -> DVector<f64> {
        DVector::from_vec(self.fit.reduction.grouped(self.fit.fitted.coefficients()))
    }

    /// What an effect's unknowns do to every measured number, in m or rad per expected size; m × k.
    pub fn columns(&self, effect: &dyn AnyEffect) -> Result<DMatrix<f64>, DiscoverError> {
        let model = ErrorModel::new(self.chain().clone(), vec![effect.boxed()])?;
        let bound = model.bind(&self.data.schema)?;
        let scales: Vec<f64> = model.columns().iter().map(|column| column.scale).collect();
        let mut columns = DMatrix::zeros(self.len(), scales.len());
        let mut emission = Emission::new();
        let settles = effect.settles();
        for row in &self.rows {
            let buffer = if settles { &row.settled } else { &row.nominal };
            let posture = buffer.view(self.chain(), &row.conditions);
            bound.emit(&posture, &mut emission);
            for entry in emission.entries() {
                let site = self.chain().site_index(entry.site);
                let value = entry.value * scales[entry.column];
                for at in row.first..row.first + row.count {
                    columns[(at, entry.column)] += value * self.sites[at * self.site_count + site];
                }
            }
        }
        Ok(columns)
    }

    /// What another kilogram at one declared level of payload would do, through the compliances of the present model:
    /// a difference of predictions, m or rad per kg; m × 1.
    pub fn heavier(&self, level: f64) -> Result<DMatrix<f64>, DiscoverError> {
        const STEP: f64 = 1e-2;
        let fitted: &FittedModel = &self.fit.fitted;
        let mut predictor = fitted.bind(&self.data.schema)?;
        let mut column = DMatrix::zeros(self.len(), 1);
        for row in &self.rows {
            let Some(changed) = crate::payload::changed(&row.conditions, level, level + STEP) else {
                continue;
            };
            let target = self.data.target[self.observations[row.first].row];
            let before = predictor.predict(&row.conditions, target);
            let after = predictor.predict(&changed, target);
            let moved = (after.translation - before.translation) / STEP;
            let turned = rotation_log(&(after.rotation * before.rotation.transpose())) / STEP;
            for at in row.first..row.first + row.count {
                let component = self.observations[at].component;
                column[(at, 0)] = if component < 3 { moved[component] } else { turned[component - 3] };
            }
        }
        Ok(column)
    }

    /// Displacement of every measured number per unit of a joint's own motion (m), and the joint's value there.
    pub fn motion(&self, joint: JointId) -> Option<(DVector<f64>, Vec<f64>)> {
        let motion = self.chain().joint_motion(joint)?;
        let coordinate = self.chain().coordinate(joint)?;
        let mut emission = Emission::new();
        emission.along(0, &motion, 1.0);
        let mut moved = DVector::zeros(self.len());
        let mut values = vec![0.0; self.len()];
        for row in &self.rows {
            for at in row.first..row.first + row.count {
                values[at] = row.conditions.joints[coordinate];
                moved[at] = emission
                    .entries()
                    .iter()
                    .map(|e| e.value * self.sites[at * self.site_count + self.chain().site_index(e.site)])
                    .sum();
            }
        }
        Some((moved, values))
    }
}
