//! Friction with memory: a joint that comes to its command by another path ends elsewhere.
//!
//! ```text
//! Dahl           dz/dq = (1 − z sgn(dq)) / w                    z in [−1, 1]
//! Maxwell slip   z_i ← clamp(z_i + Δq / w_i, −1, 1)             z = Σ s_i z_i,   Σ s_i = 1
//! δ = −A z
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | z | state of the friction: its torque over the largest | 1 |
//! | w, w_i | `width`, `widths` | rad or m: pre-sliding distance |
//! | s_i | `parts` | 1: the part of each element in the whole |
//! | A | `amplitude` | rad or m: wind-up of the drive under the full friction torque |
//!
//! The encoder sits on the motor: friction at the link winds the drive up, so that the link stays behind by A z. Along a
//! segment on which the joint moves one way the Dahl equation has the solution z' = s − (s − z) e^(−|Δq|/w) with
//! s = sgn Δq. Poses are connected by straight moves in joint space.
//!
//! Sources: Dahl, *A solid friction model* (1968), exponent 1; Al-Bender, Lampaert and Swevers, *The generalized
//! Maxwell-slip model* (2005), in pre-sliding.

use crate::SimulateError;

/// Friction in a joint's drive that depends on the path.
#[derive(Debug, Clone, PartialEq)]
pub enum Presliding {
    /// One exponential transition after each reversal.
    Dahl {
        /// Wind-up under the full friction torque, rad or m.
        amplitude: f64,
        /// Pre-sliding distance, rad or m.
        width: f64,
    },
    /// Elements in parallel, each of which sticks, then slips.
    MaxwellSlip {
        /// Wind-up under the full friction torque, rad or m.
        amplitude: f64,
        /// Distance after which each element slips, rad or m.
        widths: Vec<f64>,
        /// The part of each element in the whole; they are scaled to a sum of one.
        parts: Vec<f64>,
    },
}

/// What the friction of one joint remembers: one number for Dahl, one for each element of Maxwell slip.
#[derive(Debug, Clone, PartialEq)]
pub struct Memory(Vec<f64>);

impl Presliding {
    /// The same friction, if its numbers make sense.
    ///
    /// # Errors
    /// For a width or a part that is not positive, or lists of different lengths.
    pub fn checked(self) -> Result<Self, SimulateError> {
        let positive = |what: &'static str, values: &[f64]| {
            let wrong = values.iter().find(|value| !(value.is_finite() && **value > 0.0));
            wrong.map_or(Ok(()), |&value| Err(SimulateError::Size { what, value, need: "positive" }))
        };
        match &self {
            Presliding::Dahl { width, .. } => positive("a pre-sliding distance", &[*width])?,
            Presliding::MaxwellSlip { widths, parts, .. } => {
                positive("a pre-sliding distance", widths)?;
                positive("the part of a Maxwell element", parts)?;
                if widths.len() != parts.len() || widths.is_empty() {
                    let what = "parts of Maxwell elements";
                    return Err(SimulateError::Shape { what, have: parts.len(), need: widths.len().max(1) });
                }
            }
        }
        Ok(self)
    }

    /// Before the first move: nothing is wound up.
    pub fn fresh(&self) -> Memory {
        Memory(vec![
            0.0;
            match self {
                Presliding::Dahl { .. } => 1,
                Presliding::MaxwellSlip { widths, .. } => widths.len(),
            }
        ])
    }

    /// Moves the joint one way by `step`, rad or m.
    pub fn advance(&self, memory: &mut Memory, step: f64) {
        match self {
            Presliding::Dahl { width, .. } => {
                let side = if step == 0.0 { return } else { step.signum() };
                for z in &mut memory.0 {
                    *z = side - (side - *z) * (-step.abs() / width).exp();
                }
            }
            Presliding::MaxwellSlip { widths, .. } => {
                for (z, width) in memory.0.iter_mut().zip(widths) {
                    *z = (*z + step / width).clamp(-1.0, 1.0);
                }
            }
        }
    }

    /// The joint's error in this state, rad or m.
    pub fn error(&self, memory: &Memory) -> f64 {
        match self {
            Presliding::Dahl { amplitude, .. } => -amplitude * memory.0.first().copied().unwrap_or(0.0),
            Presliding::MaxwellSlip { amplitude, parts, .. } => {
                let sum: f64 = parts.iter().sum();
                -amplitude * memory.0.iter().zip(parts).map(|(z, part)| z * part).sum::<f64>() / sum
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn both() -> [Presliding; 2] {
        [
            Presliding::Dahl { amplitude: 2e-4, width: 0.05 },
            Presliding::MaxwellSlip {
                amplitude: 2e-4,
                widths: vec![0.01, 0.05, 0.2],
                parts: vec![3.0, 2.0, 1.0],
            },
        ]
    }

    /// Errors on the way from one end to the other and back, `count` steps each way.
    fn loop_of(friction: &Presliding, memory: &mut Memory, travel: f64, count: usize) -> Vec<f64> {
        let step = travel / count as f64;
        let steps = std::iter::repeat_n(step, count).chain(std::iter::repeat_n(-step, count));
        steps
            .map(|step| {
                friction.advance(memory, step);
                friction.error(memory)
            })
            .collect()
    }

    #[test]
    fn a_loop_closes_and_encloses_an_area() {
        for friction in both() {
            let mut memory = friction.fresh();
            // The first loops are the transient from the fresh state.
            for _ in 0..20 {
                loop_of(&friction, &mut memory, 0.3, 50);
            }
            let begin = friction.error(&memory);
            let errors = loop_of(&friction, &mut memory, 0.3, 50);
            let closed = errors.last().copied().expect("a loop") - begin;
            assert!(closed.abs() < 1e-12, "{friction:?}: {closed:e}");
            // At each place the way out lies below the way back: the link stays behind.
            for k in 0..49 {
                assert!(errors[k] < errors[98 - k], "{friction:?} at {k}");
            }
        }
    }

    #[test]
    fn after_a_long_move_the_past_is_forgotten() {
        for friction in both() {
            for before in [-0.02, 0.0, 0.4] {
                let mut memory = friction.fresh();
                friction.advance(&mut memory, before);
                friction.advance(&mut memory, 3.0);
                assert!((friction.error(&memory) + 2e-4).abs() < 1e-15);
            }
        }
    }

    #[test]
    fn a_move_may_be_cut_into_pieces() {
        for friction in both() {
            let (mut one, mut many) = (friction.fresh(), friction.fresh());
            friction.advance(&mut one, 0.037);
            for _ in 0..37 {
                friction.advance(&mut many, 0.001);
            }
            assert!((friction.error(&one) - friction.error(&many)).abs() < 1e-16);
        }
    }

    #[test]
    fn a_short_reversal_is_neither_side() {
        // Dahl from saturation, back by one width: z = −1 + 2/e.
        let [dahl, _] = both();
        let mut memory = dahl.fresh();
        dahl.advance(&mut memory, 5.0);
        dahl.advance(&mut memory, -0.05);
        let expected = -2e-4 * (-1.0 + 2.0 * (-1f64).exp());
        assert!((dahl.error(&memory) - expected).abs() < 1e-15);
    }

    #[test]
    fn senseless_friction_is_refused() {
        assert!(Presliding::Dahl { amplitude: 1.0, width: 0.0 }.checked().is_err());
        let uneven = Presliding::MaxwellSlip { amplitude: 1.0, widths: vec![0.1], parts: vec![1.0, 2.0] };
        assert!(uneven.checked().is_err());
        assert!(both().into_iter().all(|friction| friction.checked().is_ok()));
    }
}
