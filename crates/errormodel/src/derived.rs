//! The channels that a model reads and that can be made from other columns of the data.

use crate::dataset::{Channel, Dataset, history_of, presliding_of, step_of};
use crate::error::ModelError;
use crate::model::ErrorModel;
use crate::signal::Signal;
use std::borrow::Cow;
use truepose_kinematics::Chain;

impl Dataset {
    /// The data with the derived channels that a model needs and the data lacks, where they can be made. What cannot be made is told when
    /// the model is bound.
    ///
    /// # Errors
    /// [`ModelError::MissingSignal`] for a late channel of data without a time.
    pub fn derived_for(&self, model: &ErrorModel) -> Result<Cow<'_, Dataset>, ModelError> {
        let mut data = Cow::Borrowed(self);
        for effect in model.effects() {
            for need in effect.needs() {
                let Signal::Channel(name) = &need else { continue };
                if data.schema.channel(name).is_some() {
                    continue;
                }
                let lags = self.late(name).is_some() || history_of(name).is_some();
                if lags && !self.has_clock() {
                    return Err(ModelError::MissingSignal {
                        kind: effect.kind().into(),
                        signal: format!("{} to make `{name}`", Signal::Time.describe(model.chain())),
                        have: self.schema.channels.iter().map(|channel| channel.name.clone()).collect(),
                    });
                }
                if let Some((made, column)) = self.derived_channel(name, model.chain()) {
                    let more = data.to_mut();
                    more.schema.channels.push(made);
                    more.channels.push(column);
                }
            }
        }
        Ok(data)
    }

    /// The derived channel of this name, at every row; none where it cannot be made. What follows the order of poses is the same at all rows of a
    /// pose.
    pub fn derived_channel(&self, name: &str, chain: &Chain) -> Option<(Channel, Vec<f64>)> {
        let lags = self.late(name).is_some() || history_of(name).is_some();
        if lags && !self.has_clock() {
            return None;
        }
        self.along_the_way(name, chain).or_else(|| self.made(name))
    }

    /// A derived channel of this name that follows from the order of poses; none of other names.
    fn along_the_way(&self, name: &str, chain: &Chain) -> Option<(Channel, Vec<f64>)> {
        let channel = |unit: &str| Channel { name: name.to_owned(), unit: unit.into(), temperature: false };
        if let Some((joint, width)) = presliding_of(name) {
            return Some((channel("1"), self.presliding(chain.coordinate(joint)?, width)));
        }
        if let Some((history, lag)) = history_of(name)
            && self.late(name).is_none()
        {
            return Some((channel(history.unit(chain)), self.history(history, lag, chain)?));
        }
        let joint = step_of(name)?;
        let column = chain.coordinate(joint)?;
        Some((channel(chain.joint(joint).unit()), self.last_step(column)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Basis, Expansion, Factor, Input, Place};
    use crate::{CARRIED, Schema};
    use truepose_kinematics::{Axis, FrameId, Load, Payload, Wrench, samples};

    fn model() -> ErrorModel {
        let factor = Factor {
            of: Input::Channel(CARRIED.into()),
            basis: Basis::Chebyshev { lower: 0.0, upper: 10.0, degrees: vec![1] },
        };
        let at = Place::Frame { frame: FrameId::BASE, components: vec![Axis::Tx] };
        ErrorModel::new(samples::ur10(), vec![Box::new(Expansion { at, factors: vec![factor] })]).unwrap()
    }

    fn carrying(load: Vec<Load>) -> Dataset {
        Dataset { schema: Schema { load: true, ..Schema::default() }, load, ..Dataset::default() }
    }

    #[test]
    fn the_mass_that_is_carried_is_a_channel() {
        let mass = |mass| Load::Payload(Payload { mass, com: [0.1; 3].into() });
        let mut data = carrying(vec![mass(5.0), Load::None, mass(2.5)]);
        let derived = data.derived_for(&model()).unwrap().into_owned();
        assert_eq!(derived.channels[derived.schema.channel(CARRIED).unwrap()], [5.0, 0.0, 2.5]);
        assert!(model().bind(&derived.schema).is_ok());
        data.add_carried();
        assert_eq!(data.channels, derived.channels);
        // One mass tells nothing, and a wrench is none.
        let mut one = carrying(vec![mass(5.0); 3]);
        one.add_carried();
        assert!(one.channels.is_empty());
        let wrench = carrying(vec![Load::Wrench(Wrench::default()), Load::None]);
        assert!(wrench.derived_for(&model()).unwrap().channels.is_empty());
        assert!(model().bind(&wrench.schema).is_err());
    }
}
