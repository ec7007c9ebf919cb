//! Channels that are made from other columns: late ones, and the mass that is carried.
//!
//! | name | what it is | made from |
//! | --- | --- | --- |
//! | `temperature~lag=600` | a body that follows the channel late ([`late_channel`](super::late_channel)) | the channel and `time` |
//! | `payload` ([`CARRIED`]) | the mass that is declared to be carried, kg; none is zero | the load |
//!
//! They are made at fit time and wherever a fit is used, so that no file has to hold them.

use super::late::LATE;
use super::{Channel, Dataset};
use crate::{ErrorModel, ModelError, Signal};
use std::borrow::Cow;
use truepose_kinematics::Load;

/// The channel of the mass that is declared to be carried, kg.
pub const CARRIED: &str = "payload";

/// Whether a channel of this name is made from other columns.
pub fn is_derived(channel: &str) -> bool {
    channel == CARRIED || channel.contains(LATE)
}

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
                if self.late(name).is_some() && !self.schema.time {
                    return Err(ModelError::MissingSignal {
                        kind: effect.kind().into(),
                        signal: format!("{} to make `{name}`", Signal::Time.describe(model.chain())),
                        have: self.schema.channels.iter().map(|channel| channel.name.clone()).collect(),
                    });
                }
                if let Some((made, column)) = self.made(name) {
                    let more = data.to_mut();
                    more.schema.channels.push(made);
                    more.channels.push(column);
                }
            }
        }
        Ok(data)
    }

    /// A derived channel of this name; none where it cannot be made.
    fn made(&self, name: &str) -> Option<(Channel, Vec<f64>)> {
        if let Some((source, lag)) = self.late(name) {
            let made = Channel { name: name.to_owned(), ..self.schema.channels[source].clone() };
            return Some((made, self.following(source, lag)));
        }
        let made = Channel { name: CARRIED.into(), unit: "kg".into(), temperature: false };
        (name == CARRIED).then(|| self.carried()).flatten().map(|column| (made, column))
    }

    /// The mass that is carried at every row, kg; none where the data has no load, or a measured wrench in place of a mass.
    fn carried(&self) -> Option<Vec<f64>> {
        let mass = |load: &Load| match load {
            Load::None => Some(0.0),
            Load::Payload(payload) => Some(payload.mass),
            Load::Wrench(_) => None,
        };
        self.schema.load.then(|| self.load.iter().map(mass).collect()).flatten()
    }

    /// Adds the channel of the mass that is carried, where it is not always the same.
    pub fn add_carried(&mut self) {
        if self.schema.channel(CARRIED).is_none()
            && let Some((made, column)) = self.made(CARRIED)
            && column.iter().any(|mass| (mass - column[0]).abs() > 0.0)
        {
            self.schema.channels.push(made);
            self.channels.push(column);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Schema;
    use crate::effects::{Basis, Expansion, Factor, Input, Place};
    use truepose_kinematics::{Axis, FrameId, Payload, Wrench, samples};

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
