//! A fit of data whose rows stand in an order, for poses that stand in none.
//!
//! ```text
//! ε̄ = (1/N) Σ_n Φ(n) c = Φ_0 (M c),      cov c̄ = M C Mᵀ,      n = 1 … N the pose measurements of the record
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | Φ(n) | an effect that reads the time, at the n-th pose measurement | |
//! | Φ_0 | the same error, unchanging ([`Effect::without_time`](crate::Effect::without_time)) | |
//! | M | mean of Φ(n) over the record in terms of Φ_0 | the columns' |
//!
//! At which moment of a later pose a drift or a jump stands is not known. Of all numbers that could be taken in its place, the mean over the
//! record has the smallest squared error over the record.

use super::domain::Domain;
use super::model::FittedModel;
use crate::{AnyEffect, Emission, ErrorModel, ModelError, Signal};
use nalgebra::{DMatrix, DVector};
use truepose_kinematics::{Chain, Conditions, PostureBuffer, Slot};

/// Moments over which the mean is taken, at most.
const MOMENTS: usize = 1000;

impl FittedModel {
    /// The same fit for poses of which nothing tells where in the order of the record they stand: each effect of the order becomes its mean over
    /// the record. The fit itself where the data has a time.
    ///
    /// # Errors
    /// When an effect does not fit the robot.
    pub fn without_order(&self) -> Result<FittedModel, ModelError> {
        if !self.domain.by_order {
            return Ok(self.clone());
        }
        let (chain, old) = (self.chain(), self.model());
        let last = self.domain.time.map_or(1.0, |time| time.upper);
        let mut effects: Vec<Box<dyn AnyEffect>> = Vec::new();
        let mut means: Vec<Option<DMatrix<f64>>> = Vec::new();
        for effect in old.effects() {
            let timed = effect.needs().contains(&Signal::Time);
            let constant = if timed { effect.without_time() } else { None };
            means.push(constant.as_ref().map(|constant| mean(&**effect, &**constant, chain, last)));
            effects.push(constant.unwrap_or_else(|| effect.clone()));
        }
        let model = ErrorModel::new(chain.clone(), effects)?;
        let mut all = DMatrix::zeros(model.columns().len(), old.columns().len());
        for (k, mean) in means.into_iter().enumerate() {
            let (to, from) = (model.columns_of(k), old.columns_of(k));
            let block = mean.unwrap_or_else(|| DMatrix::identity(to.len(), from.len()));
            all.view_mut((to.start, from.start), block.shape()).copy_from(&block);
        }
        let coefficients = &all * DVector::from_column_slice(self.coefficients());
        let covariance = &all * self.covariance() * all.transpose();
        let sample = self.domain.sample.clone().without_order();
        let domain = Domain { time: None, by_order: false, sample, ..self.domain.clone() };
        let fitted = FittedModel::new(model, coefficients.as_slice().to_vec(), covariance)?;
        Ok(fitted.like(self).with_sessions(self.sessions.clone()).with_domain(domain))
    }
}

/// M of one effect: a row for each column of the constant, a column for each of the effect's.
fn mean(effect: &dyn AnyEffect, constant: &dyn AnyEffect, chain: &Chain, last: f64) -> DMatrix<f64> {
    let mut buffer = PostureBuffer::new(chain);
    let mut said = Emission::new();
    let count = (last.max(1.0) as usize).min(MOMENTS);
    let mut mean = DMatrix::zeros(constant.columns(chain).len(), effect.columns(chain).len());
    let still = Conditions::at(chain, &vec![0.0; chain.movable().len()]);
    constant.eval(&buffer.update(chain, &still), &mut said);
    // Of a joint's motion, whose axis may be oblique, the largest of its sites.
    let mut sites = vec![None; mean.nrows()];
    for entry in said.entries() {
        let known: &mut Option<(_, f64)> = &mut sites[entry.column];
        if known.is_none_or(|(_, value)| entry.value.abs() > value.abs()) {
            *known = Some((entry.site, entry.value));
        }
    }
    for moment in 0..count {
        // The middle of each of so many equal parts of 1 … N.
        let time = 0.5 + last * (moment as f64 + 0.5) / count as f64;
        said.clear();
        let conditions = Conditions { time, ..still.clone() };
        effect.eval(&buffer.update(chain, &conditions).with_slots(&[Slot::Time]), &mut said);
        for entry in said.entries() {
            for (row, known) in sites.iter().enumerate() {
                if let Some((site, value)) = known
                    && *site == entry.site
                {
                    mean[(row, entry.column)] += entry.value / (value * count as f64);
                }
            }
        }
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::super::Interval;
    use super::*;
    use crate::effects::{Drift, Geometric, Shift, Spot};
    use crate::{Effect, Schema};
    use truepose_kinematics::{Axis, FrameId, JointId, samples};

    fn fitted(effect: Box<dyn AnyEffect>, own: &[f64]) -> FittedModel {
        let geometric: Box<dyn AnyEffect> = Box::new(Geometric::default());
        let model = ErrorModel::new(samples::ur10(), vec![geometric, effect]).unwrap();
        let n = model.columns().len();
        let mut coefficients: Vec<f64> = (0..n - own.len()).map(|k| 1e-4 * (k as f64).sin()).collect();
        coefficients.extend(own);
        let mut fitted = FittedModel::new(model, coefficients, DMatrix::identity(n, n) * 1e-10).unwrap();
        fitted.domain.time = Some(Interval { lower: 1.0, upper: 40.0 });
        fitted.domain.by_order = true;
        fitted
    }

    #[test]
    fn what_is_left_is_the_mean_over_the_record() {
        let (tool, joint) = (Spot::Frame(samples::ur10().tool_frame()), Spot::Joint(JointId(2)));
        let two = Some(vec![Axis::Tx, Axis::Rz]);
        let settling = Drift { components: two.clone(), ..Drift::settling(tool, [1.0, 40.0], 12.0) };
        let curve = Drift::smooth(joint, [1.0, 40.0], 2);
        let width = Effect::columns(&curve, &samples::ur10()).len();
        let all: Vec<(Box<dyn AnyEffect>, Vec<f64>)> = vec![
            (
                Box::new(Shift { components: two, ..Shift::of(Spot::Frame(FrameId::BASE), 10.5) }),
                vec![3e-4, -2e-4],
            ),
            (Box::new(Shift::of(joint, 30.5)), vec![5e-4]),
            (Box::new(settling), vec![2e-4, 1e-4]),
            (Box::new(curve), (0..width).map(|k| 1e-4 * (k as f64 + 1.0)).collect()),
        ];
        for (effect, own) in all {
            let timed = fitted(effect, &own);
            let average = timed.without_order().unwrap();
            let schema = Schema { time: true, ..Schema::default() };
            // Nothing tells the time any more.
            let mut later = average.bind(&Schema::default()).unwrap();
            let mut known = timed.bind(&schema).unwrap();
            let at =
                |time| Conditions { time, ..Conditions::at(timed.chain(), &[0.3, -1.0, 0.8, 0.1, 0.7, 0.2]) };
            let mut mean = nalgebra::Vector3::zeros();
            for time in 1..=40 {
                mean += known.predict(&at(f64::from(time)), None).translation / 40.0;
            }
            let off = (later.predict(&at(0.0), None).translation - mean).norm();
            let moved = (known.predict(&at(1.0), None).translation
                - known.predict(&at(40.0), None).translation)
                .norm();
            assert!(moved > 3e-5 && off < 1e-3 * moved, "{off} of {moved}");
            assert!(average.covariance().iter().all(|v| v.is_finite()));
            assert!(average.domain.time.is_none());
        }
    }

    #[test]
    fn a_fit_of_data_with_a_clock_stays_as_it_is() {
        let mut timed = fitted(Box::new(Shift::of(Spot::Joint(JointId(2)), 10.0)), &[5e-4]);
        timed.domain.by_order = false;
        assert!(timed.without_order().unwrap().bind(&Schema::default()).is_err());
    }
}
