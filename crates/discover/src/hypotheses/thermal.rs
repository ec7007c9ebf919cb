//! What follows a temperature, at once or late: a place, the whole arm, or the difference of two thermometers.
//!
//! Differences are proposed of neighbouring columns and of each with the first one, so that there are as many as channels; of many thermometers
//! those that say the most different things take part.

use crate::data::derived::LAGGED;
use crate::data::independent::independent;
use crate::hypotheses::components::of_spot;
use crate::hypotheses::driver::Driver;
use crate::hypotheses::family::Family;
use crate::hypotheses::hypothesis::Hypothesis;
use crate::hypotheses::nonlinear::{Nonlinear, Refinement};
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
        Some(Nonlinear::new(effect.concrete::<Thermal>()?.lag?, Refinement::Grid))
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        let growth = effect.concrete::<Thermal>()?.clone();
        Some(Box::new(Thermal { lag: Some(value), lag_range: range, ..growth }))
    }

    fn second(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        Some(Nonlinear::new(effect.concrete::<Thermal>()?.second_lag?, Refinement::Grid))
    }

    // A second part of the body, five times as slow.
    fn richer_in(&self, effect: &dyn AnyEffect, setting: &Setting<'_>) -> Vec<Box<dyn AnyEffect>> {
        let Some(growth) = effect.concrete::<Thermal>() else { return Vec::new() };
        let Some(lag) = growth.lag else { return Vec::new() };
        let grid = setting.data.schema.channels.iter().filter_map(|channel| setting.data.late(&channel.name));
        let own = |(source, _): &(usize, f64)| setting.data.schema.channels[*source].name == growth.channel;
        let near = |a: &f64, b: &f64| (a / (5.0 * lag)).ln().abs().total_cmp(&(b / (5.0 * lag)).ln().abs());
        let second = grid.filter(own).map(|(_, lag)| lag).min_by(near);
        let second = second.filter(|second| *second > 2.0 * lag);
        second
            .map(|second| Thermal { second_lag: Some(second), ..growth.clone() }.boxed())
            .into_iter()
            .collect()
    }

    fn neighbours(&self, effect: &dyn AnyEffect) -> Vec<Box<dyn AnyEffect>> {
        let Some(growth) = effect.concrete::<Thermal>() else { return Vec::new() };
        of_spot(growth.spot, growth.components.as_deref(), |axes| {
            Thermal { components: Some(axes), ..growth.clone() }.boxed()
        })
    }
}

/// A place follows the difference of two temperatures.
#[derive(Debug)]
pub(crate) struct Gradient;

impl Hypothesis for Gradient {
    fn family(&self) -> Family {
        Family::Thermal
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let (chain, channels) = (setting.chain, &setting.data.schema.channels);
        let own: Vec<usize> = (0..channels.len())
            .filter(|&k| channels[k].temperature && setting.data.late(&channels[k].name).is_none())
            .filter(|&k| setting.channel_range(k).is_some())
            .collect();
        let own: Vec<&str> =
            independent(setting.data, &own, LAGGED).into_iter().map(|k| channels[k].name.as_str()).collect();
        let mut pairs: Vec<(usize, usize)> = (1..own.len()).map(|k| (k, k - 1)).collect();
        pairs.extend((2..own.len()).map(|k| (k, 0)));
        let mut all = Vec::new();
        for (warm, cool) in pairs {
            let mut put = |spot: Spot, grows: Option<Grows>| {
                let effect = Thermal { grows, ..Thermal::gradient(spot, own[warm], own[cool]) };
                let place = Place::spot(chain, spot).following(&format!("{} - {}", own[warm], own[cool]));
                all.push(Variant::new(place, effect));
            };
            for &joint in chain.movable() {
                put(Spot::Joint(joint), Some(Grows::Motion));
            }
            // A column or link that is warmer on one side bends: the frame at its end.
            for frame in chain.frames() {
                put(Spot::Frame(frame), None);
            }
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "The error of {} follows the difference of two temperatures ({}): what is warmer on one side bends. Shield it from the sun, drives \
             and draughts, or compensate with both sensors.",
            place.part(),
            place.channel.as_deref().unwrap_or("two channels")
        )
    }

    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Time]
    }

    fn view(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_site([Driver::Time])
    }

    fn rank(&self) -> Family {
        Family::Shift
    }

    fn penalty(&self, _: &[Box<dyn AnyEffect>]) -> Penalty {
        Penalty::MarginalLikelihood
    }

    fn neighbours(&self, effect: &dyn AnyEffect) -> Vec<Box<dyn AnyEffect>> {
        Growth.neighbours(effect)
    }
}

/// All lengths of the arm follow one temperature.
#[derive(Debug)]
pub(crate) struct ArmGrowth;

impl Hypothesis for ArmGrowth {
    fn family(&self) -> Family {
        Family::Thermal
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let channels = &setting.data.schema.channels;
        let mut all = Vec::new();
        for (k, channel) in channels.iter().enumerate() {
            let (Some([lower, upper]), true) = (setting.channel_range(k), channel.temperature) else {
                continue;
            };
            let (source, lag) = match setting.data.late(&channel.name) {
                Some((source, lag)) => (channels[source].name.as_str(), Some(lag)),
                None => (channel.name.as_str(), None),
            };
            let effect = Thermal { reference: 0.5 * (lower + upper), lag, ..Thermal::arm(source) };
            let place = Place { mode: Some("arm".into()), ..Place::default() };
            all.push(Variant::new(place.following(source), effect));
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        format!(
            "All lengths of the arm grow with {}: thermal expansion of the whole robot. Warm up, or compensate with the sensor.",
            place.channel.as_deref().unwrap_or("a temperature")
        )
    }

    fn drivers(&self, _: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        vec![Driver::Time]
    }

    fn view(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_site(place.channel.clone().map(Driver::Channel))
    }

    fn rank(&self) -> Family {
        Family::Shift
    }

    fn penalty(&self, _: &[Box<dyn AnyEffect>]) -> Penalty {
        Penalty::MarginalLikelihood
    }

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        Growth.nonlinear(effect)
    }

    fn with_value(
        &self,
        effect: &dyn AnyEffect,
        value: f64,
        range: Option<[f64; 2]>,
    ) -> Option<Box<dyn AnyEffect>> {
        Growth.with_value(effect, value, range)
    }
}
