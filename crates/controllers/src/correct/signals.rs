//! Channels that the model reads, with the values that they have while a program runs.

use super::options::CorrectOptions;
use crate::ControllerError;
use truepose_errormodel::{Channel, FittedModel, Schema, Signal, history_of, presliding_of};

/// The schema of the channels that the model reads, and their values.
pub(super) fn signals(
    fitted: &FittedModel,
    options: &CorrectOptions,
) -> Result<(Schema, Vec<f64>), ControllerError> {
    let mut schema = Schema { load: true, ..Schema::default() };
    let mut values = Vec::new();
    for need in fitted.model().effects().iter().flat_map(|effect| effect.needs()) {
        let name = match need {
            Signal::Channel(name) => name,
            Signal::Time => {
                let words = "the model depends on the time, which a program does not state: export or fit without drift";
                return Err(ControllerError::Fit(words.into()));
            }
            _ => continue,
        };
        if schema.channel(&name).is_some() {
            continue;
        }
        if presliding_of(&name).is_some() {
            let words =
                "the model depends on the way of a joint (presliding), which a list of points does not state";
            return Err(ControllerError::Fit(words.into()));
        }
        if history_of(&name).is_some() {
            let words = "the model depends on what the robot has done and carried before (creep, self-heating), which a list of points does not state";
            return Err(ControllerError::Fit(words.into()));
        }
        // A channel that lags behind another, or is its mean, has that one's value where that one is constant.
        let source = name.split('~').next().unwrap_or(&name);
        let given = options.channels.iter().find(|(other, _)| *other == name || other == source);
        let Some((_, value)) = given else {
            return Err(ControllerError::Option(format!(
                "the model reads the channel {source}: give its value while the program runs (--channel {source}=…)"
            )));
        };
        let known = fitted.channels.iter().find(|channel| channel.name == name);
        let known = known.or_else(|| fitted.channels.iter().find(|channel| channel.name == source));
        let channel = known.map_or_else(
            || Channel { name: name.clone(), unit: "1".into(), temperature: false },
            |channel| Channel { name: name.clone(), ..channel.clone() },
        );
        schema.channels.push(channel);
        values.push(*value);
    }
    Ok((schema, values))
}
