//! What follows a temperature, at once or late.

use crate::hypotheses::components::of_spot;
use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement, concrete};
use crate::hypotheses::penalty::Penalty;
use crate::hypotheses::place::Place;
use crate::hypotheses::setting::Setting;
use crate::hypotheses::variant::Variant;
use crate::hypotheses::view::TraceView;
use truepose_errormodel::effects::{Grows, Spot, Thermal};
use truepose_errormodel::{AnyEffect, Signal};
use truepose_kinematics::FrameId;

/// A joint, the base or the tool follows a temperature.
#[derive(Debug)]
pub(crate) struct Growth;

impl Hypothesis for Growth {
    fn family(&self) -> Family {
        Family::Thermal
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let channels = &setting.data.schema.channels;
        let mut all = Vec::new();
        for (k, channel) in channels.iter().enumerate() {
            let (Some([lower, upper]), true) = (setting.channel_range(k), channel.temperature) else {
                continue;
            };
            // A derived column has its source and its lag in its name.
            let (source, lag) = match setting.data.late(&channel.name) {
                Some((source, lag)) => (channels[source].name.as_str(), Some(lag)),
                None => (channel.name.as_str(), None),
            };
            let reference = 0.5 * (lower + upper);
            let mut put = |spot: Spot, grows: Option<Grows>| {
                // At which temperature a slide was adjusted is not known.
                let offset = grows == Some(Grows::Scale);
                let effect = Thermal { grows, reference, offset, lag, ..Thermal::of(spot, source) };
                all.push(Variant::new(Place::spot(chain, spot).following(source), effect));
            };
            for &joint in chain.movable() {
                for grows in [Grows::Length, Grows::Scale, Grows::Motion] {
                    put(Spot::Joint(joint), Some(grows));
                }
            }
            put(Spot::Frame(FrameId::BASE), None);
            put(Spot::Frame(chain.tool_frame()), None);
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The error of {} follows {}: thermal expansion. Warm up, shield, or compensate with the sensor.",
            place.part(),
            place.channel.as_deref().unwrap_or("a temperature")
        )
    }

    // A temperature moves with the time: a drift may be the other half of it.
    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Time]
    }

    fn view(&self, place: &Place, effects: &[Box<dyn AnyEffect>]) -> TraceView {
        let read = effects.iter().flat_map(|effect| effect.needs()).filter_map(|need| match need {
            Signal::Channel(name) => Some(name),
            _ => None,
        });
        TraceView::of_site(read.chain(place.channel.clone()).map(Driver::Channel))
    }

    // What follows the time in one way or another is equally simple.
    fn rank(&self) -> Family {
        Family::Shift
    }

    fn penalty(&self, _: &[Box<dyn AnyEffect>]) -> Penalty {
        Penalty::MarginalLikelihood
    }

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        Some(Nonlinear::new(concrete::<Thermal>(effect)?.lag?, Refinement::Grid))
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let growth = concrete::<Thermal>(effect)?.clone();
        Some(Box::new(Thermal { lag: Some(value), lag_range: range, ..growth }))
    }

    fn neighbours(&self, effect: &dyn AnyEffect) -> Vec<Box<dyn AnyEffect>> {
        let Some(growth) = concrete::<Thermal>(effect) else { return Vec::new() };
        of_spot(growth.spot, growth.components.as_deref(), |axes| {
            Thermal { components: Some(axes), ..growth.clone() }.boxed()
        })
    }
}
