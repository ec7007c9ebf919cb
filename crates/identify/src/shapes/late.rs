//! What the noise of a thermometer does to what follows it late.
//!
//! A body that follows a channel with a lag averages the channel's noise over the lag, so that rows err alike for as long: no scatter of the
//! rows shows it, and no number of rows averages it out.
//!
//! ```text
//! δu = (FᵀF)⁻¹ Fᵀ diag(e) L ε        cov u ← cov u + σ² G Gᵀ,  G = (FᵀF)⁻¹ Fᵀ diag(e) L
//! T_k = a T_{k−1} + (g − a) u_{k−1} + (1 − g) u_k,   a = exp(−h/τ), g = (τ/h)(1 − a)
//! σ² = mean of (w u_{k−1} + (1 − w) u_{k+1} − u_k)² / (1 + w² + (1 − w)²)
//! ```
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | F | whitened columns of all coefficients and slopes of all shape parameters, with the rows of the prior | m × (r + q) |
//! | e | what a kelvin of the late channel moves each row | m |
//! | L | the late channel by the readings (the recursion of [`truepose_errormodel`]'s late channels) | visits × visits |
//! | ε, σ | errors of the readings; their deviation, in the channel's unit | visits |
//! | w | share of the reading before in the straight line between its neighbours | 1 |
//!
//! σ comes from the channel alone: from how far each reading lies beside the line between its neighbours (Gasser, Sroka and
//! Jennen-Steinmetz 1986). What bends within three readings counts as noise: between readings the channel is as unknown as that.

use super::picture::Picture;
use crate::IdentifyError;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use truepose_errormodel::{Dataset, Visits};

/// What one error of the readings moves: shape parameters, other coefficients, the effects' own; a column a reading, in deviations of it.
pub(super) struct Moved {
    pub shapes: DMatrix<f64>,
    pub others: DMatrix<f64>,
    pub own: DMatrix<f64>,
}

/// How unknowns answer to rows: of shape parameters q × m, of other coefficients and the effects' own.
pub(super) struct Gains<'g> {
    pub shapes: &'g DMatrix<f64>,
    pub others: &'g DMatrix<f64>,
    pub own: &'g DMatrix<f64>,
}

/// What the noise of each channel moves that effects follow late.
pub(super) fn moved(
    picture: &Picture<'_>,
    theta: &[f64],
    gains: &Gains<'_>,
) -> Result<Vec<Moved>, IdentifyError> {
    let visits = Visits::of(picture.data);
    let of_rows = picture.visit_of_rows();
    // Effects that follow one channel err together.
    let mut by_channel: BTreeMap<usize, Moved> = BTreeMap::new();
    for effect in 0..picture.trial.len() {
        let b = picture.coefficients.rows_range(picture.columns_of(effect)).into_owned();
        let Some((channel, lag, response)) = picture.late(effect, theta, &b)? else { continue };
        let readings = Readings::of(picture.data, &visits, channel);
        let sd = readings.deviation();
        let through = |gain: &DMatrix<f64>| {
            let mut by_visit = DMatrix::zeros(gain.nrows(), visits.len());
            for (row, &visit) in of_rows.iter().enumerate() {
                by_visit.column_mut(visit).axpy(response[row] * sd, &gain.column(row), 1.0);
            }
            readings.followed(by_visit, lag)
        };
        let more =
            Moved { shapes: through(gains.shapes), others: through(gains.others), own: through(gains.own) };
        match by_channel.entry(channel) {
            Entry::Vacant(place) => {
                place.insert(more);
            }
            Entry::Occupied(mut place) => {
                let sum = place.get_mut();
                sum.shapes += more.shapes;
                sum.others += more.others;
                sum.own += more.own;
            }
        }
    }
    Ok(by_channel.into_values().collect())
}

/// One reading of a channel a visit, by time.
struct Readings {
    /// Visits, by time.
    order: Vec<usize>,
    /// s and the channel's unit, in that order.
    time: Vec<f64>,
    value: Vec<f64>,
}

impl Readings {
    fn of(data: &Dataset, visits: &Visits, channel: usize) -> Self {
        let first = |visit: usize| visits.rows[visit].first().copied();
        let mut order: Vec<usize> = (0..visits.len()).filter(|&visit| first(visit).is_some()).collect();
        let rows = |order: &[usize]| order.iter().filter_map(|&visit| first(visit)).collect::<Vec<usize>>();
        order.sort_by(|&a, &b| data.time[visits.rows[a][0]].total_cmp(&data.time[visits.rows[b][0]]));
        let rows = rows(&order);
        Readings {
            time: rows.iter().map(|&row| data.time[row]).collect(),
            value: rows.iter().map(|&row| data.channels[channel][row]).collect(),
            order,
        }
    }

    /// σ; zero of fewer than three.
    fn deviation(&self) -> f64 {
        let (mut squares, mut count) = (0.0, 0);
        for (t, u) in self.time.windows(3).zip(self.value.windows(3)) {
            let (whole, after) = (t[2] - t[0], t[2] - t[1]);
            if after > 0.0 && t[1] > t[0] {
                let w = after / whole;
                let beside = w * u[0] + (1.0 - w) * u[2] - u[1];
                squares += beside * beside / (1.0 + w * w + (1.0 - w) * (1.0 - w));
                count += 1;
            }
        }
        (squares / f64::from(count.max(1))).sqrt()
    }

    /// `by_visit` L: the recursion of the late channel, from the last reading to the first.
    fn followed(&self, by_visit: DMatrix<f64>, lag: f64) -> DMatrix<f64> {
        let mut through = DMatrix::zeros(by_visit.nrows(), by_visit.ncols());
        let mut carried: DVector<f64> = DVector::zeros(by_visit.nrows());
        for k in (0..self.order.len()).rev() {
            let visit = self.order[k];
            carried += by_visit.column(visit);
            if k == 0 {
                let mut first = through.column_mut(visit);
                first += &carried;
                break;
            }
            let h = self.time[k] - self.time[k - 1];
            if h > 0.0 {
                let a = (-h / lag).exp();
                let g = lag / h * (1.0 - a);
                through.column_mut(visit).axpy(1.0 - g, &carried, 1.0);
                through.column_mut(self.order[k - 1]).axpy(g - a, &carried, 1.0);
                carried *= a;
            }
        }
        through
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::{Channel, Schema, late_channel};

    /// A channel of these readings, a minute apart, in another order.
    fn day(values: &[f64]) -> Dataset {
        let n = values.len();
        let at = |k: usize| (k * 7) % n;
        Dataset {
            schema: Schema {
                channels: vec![Channel { name: "T".into(), unit: "degC".into(), temperature: true }],
                time: true,
                ..Schema::default()
            },
            visit: (0..n).collect(),
            channels: vec![(0..n).map(|k| values[at(k)]).collect()],
            time: (0..n).map(|k| 60.0 * at(k) as f64).collect(),
            position: vec![[0.0; 3]; n],
            ..Dataset::default()
        }
    }

    #[test]
    fn the_recursion_is_that_of_the_late_channel() {
        const LAG: f64 = 400.0;
        let n = 25;
        for reading in [0, 3, 24] {
            let mut impulse = vec![0.0; n];
            impulse[reading] = 1.0;
            let mut data = day(&impulse);
            let visits = Visits::of(&data);
            let readings = Readings::of(&data, &visits, 0);
            // Each visit's late value by this reading: a column of L.
            let place = readings.order[reading];
            let through = readings.followed(DMatrix::identity(n, n), LAG);
            data.follow_late("T", LAG);
            let late = data.schema.channel(&late_channel("T", LAG)).expect("the column");
            for visit in 0..n {
                let expected = data.channels[late][visits.rows[visit][0]];
                assert!((through[(visit, place)] - expected).abs() < 1e-14, "{reading} {visit}");
            }
        }
    }

    #[test]
    fn noise_is_what_lies_beside_the_line() {
        // ±σ in turn on a ramp: beside the line between neighbours by 2σ, of variance 1.5.
        let values: Vec<f64> =
            (0..25).map(|k| 20.0 + 0.3 * f64::from(k) + if k % 2 == 0 { 0.1 } else { -0.1 }).collect();
        let data = day(&values);
        let deviation = Readings::of(&data, &Visits::of(&data), 0).deviation();
        assert!((deviation - 0.2 / 1.5f64.sqrt()).abs() < 1e-12, "{deviation}");
    }
}
