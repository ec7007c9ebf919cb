//! Creep: a drive goes on yielding after its load has changed, with a spectrum of times.
//!
//! ```text
//! δ(t) = C Σ_i (τ_i − τ_(i−1)) (1 − exp(−((t − t_i)/T)^β))          Boltzmann's superposition of a stretched exponential
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | C | `compliance`: what is added in the end | rad/(N·m) or m/N |
//! | T, β | `time`, `stretch`: 1 is one time constant, less a spectrum | s, 1 |
//! | τ_i, t_i | load from pose i on, and when it was reached | N·m or N, s |
//!
//! The load of the first pose has acted for ever. Source: Findley, Lai and Onaran, *Creep and Relaxation of Nonlinear Viscoelastic Materials*, chapter 5.

/// A drive that creeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Creep {
    /// rad/(N·m) or m/N.
    pub compliance: f64,
    /// s.
    pub time: f64,
    /// Between 0 and 1.
    pub stretch: f64,
}

impl Creep {
    /// The late deflection at each pose, rad or m, of poses at these times (s) with these loads.
    pub fn errors(&self, times: &[f64], loads: &[f64]) -> Vec<f64> {
        let after = |age: f64| 1.0 - (-(age / self.time).powf(self.stretch)).exp();
        let first = loads.first().copied().unwrap_or(0.0);
        let one = |k: usize| {
            let steps = (1..=k).map(|i| (loads[i] - loads[i - 1]) * after(times[k] - times[i]));
            self.compliance * (first + steps.sum::<f64>())
        };
        (0..times.len()).map(one).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_that_stays_is_reached_in_the_end() {
        let creep = Creep { compliance: 1e-6, time: 300.0, stretch: 0.6 };
        let times: Vec<f64> = (0..400).map(|k| 60.0 * f64::from(k)).collect();
        let loads: Vec<f64> = (0..400).map(|k| if k < 3 { 20.0 } else { 100.0 }).collect();
        let errors = creep.errors(&times, &loads);
        assert!((errors[2] - 20e-6).abs() < 1e-18 && (errors[3] - 20e-6).abs() < 1e-18);
        assert!(errors.windows(2).all(|pair| pair[1] >= pair[0]));
        assert!((errors[399] - 100e-6).abs() < 1e-6);
        // With one time constant: 63 % after it.
        let plain = Creep { stretch: 1.0, time: 600.0, ..creep };
        let after = plain.errors(&[0.0, 1.0, 601.0], &[0.0, 50.0, 50.0])[2];
        assert!((after / 50e-6 - (1.0 - (-1f64).exp())).abs() < 1e-12);
    }
}
