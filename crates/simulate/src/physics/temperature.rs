//! The temperature of the shop, and that of a body which follows it late.
//!
//! ```text
//! τ dT/dt = T_a(t) − T,    T(0) = T_a(0)            ΔL = α L (T − T_ref)
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | T_a | `Shop::air` | °C over s |
//! | τ | `lag` | s; zero follows at once |
//! | T_ref | `Shop::reference` | °C, where everything has its nominal size |
//!
//! The body's temperature is integrated by the classical Runge–Kutta rule at no more than a twentieth of τ.
//! Source: lumped heat capacity, e.g. Incropera and DeWitt, *Fundamentals of Heat and Mass Transfer*, chapter 5.

use super::curve::{Centred, SmoothCurve};
use crate::SimulateError;
use rand::Rng;

/// The air of the shop over the time of the measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct Shop {
    /// Where everything has its nominal size, °C.
    pub reference: f64,
    /// Temperature of the air, °C over s.
    pub air: SmoothCurve,
}

impl Shop {
    /// Air that stays at one temperature, °C.
    ///
    /// # Errors
    /// None in practice: the duration is a constant.
    pub fn steady(temperature: f64) -> Result<Self, SimulateError> {
        Ok(Shop { reference: temperature, air: SmoothCurve::through(0.0, 3600.0, vec![temperature; 2])? })
    }

    /// A day in the shop: it begins at `start` °C, rises by `rise` K to the end of `duration` s and wanders by
    /// `wander` K about that with a memory of a sixth of the duration.
    ///
    /// # Errors
    /// Those of [`SmoothCurve::draw`].
    pub fn day(
        (start, rise, wander): (f64, f64, f64),
        duration: f64,
        rng: &mut impl Rng,
    ) -> Result<Self, SimulateError> {
        let curve = SmoothCurve::draw((0.0, duration), duration / 6.0, wander, Centred::Mean, rng)?;
        Ok(Shop { reference: 20.0, air: curve.tilted(start, rise / duration) })
    }

    /// The temperature above the reference of a body that follows the air with this lag, K over s.
    ///
    /// # Errors
    /// When the lag is negative.
    pub fn body(&self, lag: f64) -> Result<SmoothCurve, SimulateError> {
        if lag.is_nan() || lag < 0.0 {
            return Err(SimulateError::Size { what: "a thermal lag", value: lag, need: "zero or more" });
        }
        let (from, to) = self.air.range();
        let air = |t: f64| self.air.value(t) - self.reference;
        let fine = if lag > 0.0 { lag / 20.0 } else { f64::INFINITY };
        let steps = ((to - from) / fine.min((to - from) / 400.0)).ceil().min(2e5);
        let h = (to - from) / steps;
        let rate = |t: f64, body: f64| (air(t) - body) / lag;
        let mut body = air(from);
        let mut values = vec![body];
        for k in 1..=steps as usize {
            let t = from + h * (k - 1) as f64;
            if lag > 0.0 {
                let a = rate(t, body);
                let b = rate(t + h / 2.0, body + h / 2.0 * a);
                let c = rate(t + h / 2.0, body + h / 2.0 * b);
                let d = rate(t + h, body + h * c);
                body += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
            } else {
                body = air(t + h);
            }
            values.push(body);
        }
        SmoothCurve::through(from, h, values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warming() -> Shop {
        let air = SmoothCurve::through(0.0, 7200.0, vec![20.0, 27.2]).expect("a line");
        Shop { reference: 20.0, air }
    }

    #[test]
    fn a_body_follows_a_ramp_with_a_first_order_lag() {
        // dT/dt = (r t − T)/τ from 0: T = r (t − τ + τ e^{−t/τ}).
        let (rate, lag) = (1e-3, 900.0);
        let body = warming().body(lag).expect("a body");
        for t in [60.0, 900.0, 2500.0, 7200.0] {
            let expected = rate * (t - lag + lag * (-t / lag).exp());
            // A microkelvin: the natural spline's end, where the second derivative is not zero.
            assert!((body.value(t) - expected).abs() < 1e-6, "{} {expected}", body.value(t));
        }
    }

    #[test]
    fn without_lag_it_is_the_air() {
        let body = warming().body(0.0).expect("a body");
        assert!((body.value(3000.0) - 3.0).abs() < 1e-12);
        assert!(warming().body(-1.0).is_err());
    }
}
