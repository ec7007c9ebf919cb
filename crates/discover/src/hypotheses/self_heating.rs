//! What heats itself: a joint by its moves and its work, a robot that is at work and pauses.
//!
//! No thermometer is needed: the channels are histories of the record ([`truepose_errormodel::History`]), with time constants in equal ratios
//! from twice the mean interval of the poses to a third of the record. What is slower is a drift. A robot without pauses warms up once, which is a
//! drift as well, so that its time at work is proposed where there are pauses.

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
use truepose_errormodel::{AnyEffect, History, Visits};
use truepose_kinematics::FrameId;

/// Time constants tried for each place.
const LAGS: usize = 4;
/// Longest one, of the length of the record.
const LONGEST: f64 = 1.0 / 3.0;
/// An interval of so many median intervals is a pause.
const PAUSE: f64 = 5.0;

/// A joint, the base or the tool follows the heat that the robot makes.
#[derive(Debug)]
pub(crate) struct SelfHeating;

impl Hypothesis for SelfHeating {
    fn family(&self) -> Family {
        Family::Thermal
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        let chain = setting.chain;
        let Some((lags, pause)) = clock(setting) else { return Vec::new() };
        let mut all = Vec::new();
        let mut put = |spot: Spot, grows: Option<Grows>, history: History| {
            for &lag in &lags {
                let effect = Thermal { grows, ..Thermal::by(spot, history, lag) };
                all.push(Variant::new(Place::spot(chain, spot).following(&history.source()), effect));
            }
        };
        for &joint in chain.movable().iter().filter(|&&joint| setting.range(joint).is_some()) {
            // A joint without a load works against its friction alone: its moves say as much.
            let works = setting.load_range(joint).map(|_| History::Work(joint));
            let pauses = pause.map(History::Working);
            for history in [Some(History::Travel(joint)), works, pauses].into_iter().flatten() {
                for grows in [Grows::Length, Grows::Motion] {
                    put(Spot::Joint(joint), Some(grows), history);
                }
            }
        }
        if let Some(pause) = pause {
            put(Spot::Frame(FrameId::BASE), None, History::Working(pause));
            put(Spot::Frame(chain.tool_frame()), None, History::Working(pause));
        }
        all
    }

    fn meaning(&self, place: &Place) -> String {
        let source = place.channel.as_deref().and_then(History::of_source);
        let (cause, advice) = match source {
            Some(History::Working(_)) => (
                "the time at work, and goes back in pauses: warm-up",
                "Let the robot move through pauses, or warm it up after each of them.",
            ),
            Some(History::Work(_)) => (
                "the work that the joint has done: its gear heats itself",
                "Check lubrication and preload, or measure the temperature of the gear.",
            ),
            _ => (
                "how far the joint has moved lately: its motor and gear heat themselves",
                "Check lubrication and preload, or measure the temperature of the gear.",
            ),
        };
        format!("The error of {} follows {cause}. {advice}", place.part())
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

    fn nonlinear(&self, effect: &dyn AnyEffect) -> Option<Nonlinear> {
        let reach = Refinement::Scale([0.4, 2.5]);
        Some(Nonlinear::new(effect.concrete::<Thermal>()?.lag?, reach))
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

    fn neighbours(&self, effect: &dyn AnyEffect) -> Vec<Box<dyn AnyEffect>> {
        let Some(growth) = effect.concrete::<Thermal>() else { return Vec::new() };
        of_spot(growth.spot, growth.components.as_deref(), |axes| {
            Thermal { components: Some(axes), ..growth.clone() }.boxed()
        })
    }
}

/// Time constants to try, s, and from how long an interval on it is a pause, s, where there are pauses; none without a time.
pub(crate) fn clock(setting: &Setting<'_>) -> Option<(Vec<f64>, Option<f64>)> {
    let [from, until] = setting.time_range()?;
    let mut times: Vec<f64> = Visits::of(setting.data)
        .rows
        .iter()
        .filter_map(|rows| setting.data.time.get(*rows.first()?))
        .copied()
        .collect();
    times.sort_by(f64::total_cmp);
    let mut intervals: Vec<f64> =
        times.windows(2).map(|pair| pair[1] - pair[0]).filter(|h| *h > 0.0).collect();
    intervals.sort_by(f64::total_cmp);
    let median = *intervals.get(intervals.len() / 2)?;
    let (shortest, longest) = (2.0 * (until - from) / times.len() as f64, LONGEST * (until - from));
    if shortest >= longest {
        return None;
    }
    let step = |k: usize| rounded(shortest * (longest / shortest).powf(k as f64 / (LAGS - 1) as f64));
    let pause = rounded(PAUSE * median);
    let pauses = intervals.last().is_some_and(|&longest| longest > pause);
    Some(((0..LAGS).map(step).collect(), pauses.then_some(pause)))
}

/// Three digits: it is part of a name.
fn rounded(value: f64) -> f64 {
    let digits = 10f64.powf(value.log10().floor() - 2.0);
    (value / digits).round() * digits
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::Dataset;
    use truepose_kinematics::{Load, samples};

    fn record(pause: f64) -> Dataset {
        let rows = 40;
        let mut data = Dataset {
            joints: (0..6)
                .map(|j| (0..rows).map(|row| (0.7 * ((row * (j + 3)) as f64)).sin()).collect())
                .collect(),
            position: vec![[0.0; 3]; rows],
            target: vec![None; rows],
            visit: (0..rows).collect(),
            load: vec![Load::None; rows],
            time: (0..rows).map(|row| 30.0 * row as f64 + if row >= 20 { pause } else { 0.0 }).collect(),
            approach: vec![vec![0.0; rows]; 6],
            ..Dataset::default()
        };
        data.schema.time = true;
        data
    }

    #[test]
    fn the_time_at_work_is_proposed_where_there_are_pauses() {
        let chain = samples::ur10();
        let words =
            |data: &Dataset| {
                let all = SelfHeating.variants(&Setting::new(&chain, data));
                assert!(all.iter().all(|v| v.change.effects().iter().all(|e| e.validate(&chain).is_ok())
                    || v.place.joint.is_some()));
                let mut words: Vec<String> = all.iter().map(|v| v.place.words()).collect();
                words.dedup();
                words
            };
        let (steady, paused) = (words(&record(0.0)), words(&record(1000.0)));
        assert!(steady.contains(&"j3 on travel_3".into()) && steady.iter().all(|w| !w.contains("working")));
        assert!(paused.contains(&"base on working_150".into()), "{paused:?}");
        let mut timeless = record(0.0);
        timeless.schema.time = false;
        assert!(words(&timeless).is_empty());
    }
}
