//! A derived channel: one that follows another late.
//!
//! `τ dT/dt = u(t) − T`, u the channel, straight between its rows; T = u at the first row. From one row to the next, h later:
//!
//! ```text
//! T_1 = u_1 − τ s + (T_0 − u_0 + τ s) exp(−h/τ),   s = (u_1 − u_0)/h
//! ```
//!
//! Its name is the channel's with the lag in seconds: `temperature~lag=600`. Effects have no memory: history is a column, made
//! by this formula at fit time and wherever a fit is used.

use super::schema::Channel;
use super::table::Dataset;

/// What stands between a channel's name and its lag.
pub(super) const LATE: &str = "~lag=";

/// The name of a channel that follows another with this time constant, s.
pub fn late_channel(channel: &str, lag: f64) -> String {
    format!("{channel}{LATE}{lag}")
}

impl Dataset {
    /// Adds the column of a body that follows a channel with this time constant, s; nothing happens where there is no such
    /// channel, no time, or where the column is there already.
    pub fn follow_late(&mut self, channel: &str, lag: f64) {
        let name = late_channel(channel, lag);
        if let Some((source, lag)) = self.late(&name)
            && self.schema.time
            && self.schema.channel(&name).is_none()
        {
            let column = self.following(source, lag);
            self.schema.channels.push(Channel { name, ..self.schema.channels[source].clone() });
            self.channels.push(column);
        }
    }

    /// Channel and lag of a late channel's name.
    pub fn late(&self, name: &str) -> Option<(usize, f64)> {
        let (source, lag) = name.rsplit_once(LATE)?;
        let lag = lag.parse().ok().filter(|lag: &f64| lag.is_finite() && *lag > 0.0)?;
        Some((self.schema.channel(source)?, lag))
    }

    /// The channel as a body sees it that follows with this time constant.
    pub(super) fn following(&self, channel: usize, lag: f64) -> Vec<f64> {
        let u = &self.channels[channel];
        let mut order: Vec<usize> = (0..u.len()).collect();
        order.sort_by(|&a, &b| self.time[a].total_cmp(&self.time[b]));
        let mut body = u.clone();
        for pair in order.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let h = self.time[to] - self.time[from];
            // Rows of one instant share the body's temperature, whatever their channel says.
            if h <= 0.0 {
                body[to] = body[from];
                continue;
            }
            let behind = lag * (u[to] - u[from]) / h;
            body[to] = u[to] - behind + (body[from] - u[from] + behind) * (-h / lag).exp();
        }
        body
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Spot, Thermal};
    use crate::{ErrorModel, Schema};
    use std::borrow::Cow;
    use truepose_kinematics::{JointId, samples};

    fn warming(time: bool) -> Dataset {
        let t: Vec<f64> = (0..50).map(|k| 60.0 * f64::from((k * 17) % 50)).collect();
        let channel = Channel { name: "T".into(), unit: "degC".into(), temperature: true };
        Dataset {
            schema: Schema { channels: vec![channel], time, ..Schema::default() },
            channels: vec![t.iter().map(|t| 20.0 + 1e-3 * t).collect()],
            time: t,
            ..Dataset::default()
        }
    }

    fn model() -> ErrorModel {
        let late = Thermal { lag: Some(900.0), ..Thermal::of(Spot::Joint(JointId(3)), "T") };
        ErrorModel::new(samples::ur10(), vec![Box::new(late)]).unwrap()
    }

    #[test]
    fn a_body_lags_behind_a_ramp() {
        // Rows in any order; behind a ramp the formula of a text book holds.
        let data = warming(true);
        let derived = data.derived_for(&model()).unwrap();
        let at = derived.schema.channel(&late_channel("T", 900.0)).expect("the column");
        assert!(derived.schema.channels[at].temperature);
        for (t, body) in derived.time.iter().zip(&derived.channels[at]) {
            let expected = 20.0 + 1e-3 * (t - 900.0 + 900.0 * (-t / 900.0).exp());
            assert!((body - expected).abs() < 1e-12, "{t} {body} {expected}");
        }
        assert!(matches!(derived.derived_for(&model()).unwrap(), Cow::Borrowed(_)), "made once");
    }

    #[test]
    fn without_a_time_it_is_refused() {
        let error = warming(false).derived_for(&model()).unwrap_err().to_string();
        assert!(error.contains("needs a `time` column to make `T~lag=900`"), "{error}");
    }
}
