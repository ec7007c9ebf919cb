//! Derived columns: the order of poses where there is no time, first-order lags of temperatures on a grid of time constants, and the carried
//! mass.

use crate::data::independent::independent;
use crate::policy::Policy;
use truepose_errormodel::{AnyEffect, Dataset, Signal, Visits, is_derived};

/// Thermometers that have lags. Convention: what is proposed of each is as much as joints times time constants.
pub(crate) const LAGGED: usize = 8;

/// The data with the order of its rows as the time where it has none, so that what drifts or jumps shows; not where a declared effect needs a
/// time: then it is missing, and not of a small campaign. With the carried mass (kg) and with first-order lags of each temperature channel: [`LAGS`] time
/// constants in equal ratios, from twice the mean interval between poses to [`LONGEST`] of the length of the
/// record.
pub(crate) fn with_derived(data: &Dataset, declared: &[Box<dyn AnyEffect>], policy: &Policy) -> Dataset {
    let needs_time = declared.iter().any(|effect| effect.needs().contains(&Signal::Time));
    // A small campaign has too few poses to tell an order from everything else.
    let small = Visits::of(data).len() < policy.small_campaign;
    let mut more = if needs_time || small { data.clone() } else { data.clone().ordered() };
    more.add_carried();
    let from = data.time.iter().copied().fold(f64::INFINITY, f64::min);
    let until = data.time.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let length = until - from;
    if !data.has_clock() || !length.is_finite() || length <= 0.0 {
        return more;
    }
    let visits = data.visit.iter().max().map_or(1, |last| last + 1);
    let shortest = (2.0 * length / visits as f64).max(1e-3 * length);
    // Equal channels have equal lags.
    let repeated = data.repeated_channels();
    let channels = &data.schema.channels;
    let own: Vec<usize> =
        (0..channels.len()).filter(|&k| channels[k].temperature && repeated[k].is_none()).collect();
    for channel in independent(data, &own, LAGGED).into_iter().map(|k| &channels[k]) {
        let longest = (policy.longest_lag * length).max(shortest);
        for k in 0..policy.lags {
            let lag = shortest * (longest / shortest).powf(k as f64 / (policy.lags.max(2) - 1) as f64);
            // Three digits: the lag is part of a name.
            let digits = 10f64.powf(lag.log10().floor() - 2.0);
            more.follow_late(&channel.name, (lag / digits).round() * digits);
        }
    }
    more
}

/// The data without derived channels.
pub(crate) fn own_channels(data: &Dataset) -> Dataset {
    let mut own = data.clone();
    own.schema.channels = Vec::new();
    own.channels = Vec::new();
    for (channel, column) in data.schema.channels.iter().zip(&data.channels) {
        if !is_derived(&channel.name) {
            own.schema.channels.push(channel.clone());
            own.channels.push(column.clone());
        }
    }
    own
}
