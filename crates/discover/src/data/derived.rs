//! Derived channels: temperatures that a body follows late, for a grid of time constants, and the mass that is carried.

use truepose_errormodel::{Dataset, is_derived};

/// Time constants tried for each temperature.
const LAGS: usize = 12;

/// Longest time constant, of the length of the record: what follows later than that hardly turns when the temperature does, and cannot be
/// told from a drift.
const LONGEST: f64 = 1.0 / 3.0;

/// The data with the mass that is carried, and with each temperature channel as bodies of several time constants follow it: from the pace of
/// the visits to a part of the length of the record, in equal ratios.
pub(crate) fn with_derived(data: &Dataset) -> Dataset {
    let mut more = data.clone();
    more.add_carried();
    let from = data.time.iter().copied().fold(f64::INFINITY, f64::min);
    let until = data.time.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let length = until - from;
    if !data.schema.time || !length.is_finite() || length <= 0.0 {
        return more;
    }
    let visits = data.visit.iter().max().map_or(1, |last| last + 1);
    let shortest = (2.0 * length / visits as f64).max(1e-3 * length);
    for channel in data.schema.channels.iter().filter(|channel| channel.temperature) {
        let longest = (LONGEST * length).max(shortest);
        for k in 0..LAGS {
            let lag = shortest * (longest / shortest).powf(k as f64 / (LAGS - 1) as f64);
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
