//! Whether a channel does better than surrogates of itself: the same record at other times.
//!
//! ```text
//! p = (1 + #{SS_s ≥ SS}) / (S + 1),     SS_s: the candidate with its channel moved by s of S + 1 equal parts of the record, in a circle
//! ```
//!
//! Anything that wanders slowly goes with any channel that wanders slowly. A surrogate has the channel's distribution and autocorrelation
//! (Theiler et al. 1992), but nothing to do with the errors. All are judged beside a curve over time at
//! the same place, where the library has one and the data a clock.

use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::covariate::Covariate;
use crate::options::DiscoverOptions;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use truepose_errormodel::{Dataset, Signal, is_derived};

/// p of a candidate among surrogates of the channel that it reads; none where it reads no channel, or the present model reads it as well.
pub(crate) fn among_surrogates(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    candidate: &Candidate,
    options: &DiscoverOptions,
) -> Result<Option<f64>, DiscoverError> {
    let (data, surrogates) = (linearisation.data, linearisation.budget.surrogates);
    let read = candidate.effects().iter().flat_map(|effect| effect.needs());
    let channel = read.into_iter().find_map(|signal| match signal {
        Signal::Channel(name) if !is_derived(&name) || data.late(&name).is_some() => {
            data.schema.channel(&name)
        }
        _ => None,
    });
    let Some(channel) = channel else { return Ok(None) };
    let name = &data.schema.channels[channel].name;
    let model = linearisation.fit.fitted.model();
    let is_read = |signal: &Signal| matches!(signal, Signal::Channel(other) if other == name);
    if model.effects().iter().any(|effect| effect.needs().iter().any(is_read)) {
        return Ok(None);
    }
    let over_time = screen.candidates.iter().map(|s| &s.candidate).filter(|other| {
        other.place.covariate == Some(Covariate::Time)
            && other.place.joint == candidate.place.joint
            && other.place.covariate2.is_none()
    });
    // The order of poses is worth less than a channel that explains as much: the channel need not do better than it.
    let over_time = over_time.max_by_key(|other| other.effects().len()).filter(|_| data.has_clock());
    let beside = match over_time {
        Some(curve) => screen.projection.with(&linearisation.columns_of(curve)?),
        None => None,
    };
    let projection = beside.as_ref().unwrap_or(&screen.projection);
    let own = projection.explained(&linearisation.columns_of(candidate)?);
    let mut as_large = 0;
    for part in 1..=surrogates {
        let moved = moved(data, channel, part * data.len() / (surrogates + 1));
        // The present model does not read the channel: its linearisation is the same.
        let other = Linearisation::new(linearisation.fit, &moved, options)?.columns_of(candidate)?;
        as_large += usize::from(projection.explained(&other) >= own);
    }
    Ok(Some((1 + as_large) as f64 / (surrogates + 1) as f64))
}

/// The data with one channel moved by so many rows in the order of time, in a circle.
fn moved(data: &Dataset, channel: usize, by: usize) -> Dataset {
    let mut order: Vec<usize> = (0..data.len()).collect();
    order.sort_by(|&a, &b| data.time[a].total_cmp(&data.time[b]));
    let mut moved = data.clone();
    for (k, &row) in order.iter().enumerate() {
        moved.channels[channel][row] = data.channels[channel][order[(k + by) % order.len()]];
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::problem::synthetic::data;
    use truepose_errormodel::Channel;

    #[test]
    fn a_surrogate_has_the_values_of_its_channel_at_other_times() {
        let (_, mut data) = data(12, 1, &|_, _, _| [0.0; 3]);
        let rows = data.len();
        data.time = (0..rows).map(|row| (rows - row) as f64).collect();
        data.schema.time = true;
        let oil = Channel { name: "oil".into(), unit: "degC".into(), temperature: true };
        data.schema.channels.push(oil);
        data.channels.push((0..rows).map(|row| 20.0 + row as f64).collect());
        let channel = data.schema.channels.len() - 1;
        let other = moved(&data, channel, 3);
        // Three places on in time is three rows back in this record.
        for row in 0..rows {
            assert!(
                (other.channels[channel][row] - data.channels[channel][(row + rows - 3) % rows]).abs()
                    < 1e-12
            );
        }
        assert_eq!(moved(&data, channel, rows).channels[channel], data.channels[channel]);
    }
}
