//! Errors that no named family describes: between commanded and true joint values.
//!
//! ```text
//! nonsense      δ_j(q) = A Σ_m c_jm cos(w_jm · q̂ + φ_jm)                q̂: rad; slides over half a travel
//! hysteresis    x ← clamp(x + Δq, −r, r),   δ_j = −A Σ x_k/r_k / 3        three elements, r 2, 10 and 35 % of half a range: a memory of many moves
//! scatter       δ_j ~ N(0, s²) at each visit                             repeatability in the joints
//! wander        w ← ρ w + √(1 − ρ²) N(0, s²), axis by axis               the instrument, row by row
//! ```
//!
//! The first two are the robot's and belong to the truth; scatter and wander are not.
//! Source of the elements: Al-Bender and Swevers, *Characterization of friction force dynamics* (2008), the Maxwell slip model.

use crate::prelude::*;

const WAVES: usize = 5;
/// Where the elements slip, of half a joint's range.
const SLIP: [f64; 3] = [0.02, 0.1, 0.35];

/// A cosine over all joints.
struct Wave {
    size: f64,
    phase: f64,
    along: Vec<f64>,
}

/// What one robot has of these; the default has nothing.
#[derive(Default)]
pub struct Unnamed {
    /// Of each joint.
    waves: Vec<Vec<Wave>>,
    /// Amplitude in each joint, rad or m.
    friction: Vec<f64>,
    /// In each joint, rad or m.
    scatter: Vec<f64>,
    /// Size, m, and memory, rows.
    wander: Option<(f64, f64)>,
    /// Half of each joint's range, rad or m.
    half: Vec<f64>,
    turns: Vec<bool>,
}

impl Unnamed {
    pub fn of(chain: &Chain) -> Self {
        let described = || chain.movable().iter().map(|&joint| chain.joint(joint));
        let half = described().map(|joint| joint.limits.map_or(1.0, |(lower, upper)| 0.5 * (upper - lower)));
        let turns = described().map(|joint| joint.kind == JointKind::Revolute);
        Unnamed { half: half.collect(), turns: turns.collect(), ..Unnamed::default() }
    }

    /// A size for each joint: mrad of a turn, a fifth of that in mm of a slide.
    fn sizes(&self, mrad: f64) -> Vec<f64> {
        self.turns.iter().map(|&turn| 1e-3 * mrad * if turn { 1.0 } else { 0.2 }).collect()
    }

    pub fn with_nonsense(mut self, mrad: f64, draw: &mut Draw) -> Self {
        let n = self.half.len();
        let wave = |size: f64, draw: &mut Draw| Wave {
            size: size * draw.normal() * (2.0 / WAVES as f64).sqrt(),
            phase: draw.between(0.0, std::f64::consts::TAU),
            along: (0..n).map(|_| 1.2 * draw.normal() / (n as f64).sqrt()).collect(),
        };
        self.waves =
            self.sizes(mrad).iter().map(|&size| (0..WAVES).map(|_| wave(size, draw)).collect()).collect();
        self
    }

    pub fn with_hysteresis(mut self, mrad: f64) -> Self {
        self.friction = self.sizes(mrad);
        self
    }

    pub fn with_scatter(mut self, mrad: f64) -> Self {
        self.scatter = self.sizes(mrad);
        self
    }

    pub fn with_wander(mut self, size: f64, rows: f64) -> Self {
        self.wander = Some((size, rows));
        self
    }

    /// Where the joints stand when these are commanded one after the other; `scatter` differs each time.
    pub fn performed(&self, commanded: &[Vec<f64>], mut scatter: Option<&mut Draw>) -> Vec<Vec<f64>> {
        let mut pressed = vec![[0.0; 3]; self.half.len()];
        let mut last: Option<&Vec<f64>> = None;
        let mut all = Vec::with_capacity(commanded.len());
        for q in commanded {
            let mut stands = q.clone();
            for (j, value) in stands.iter_mut().enumerate() {
                let scaled = |k: usize| if self.turns[k] { q[k] } else { q[k] / self.half[k] };
                for wave in self.waves.get(j).into_iter().flatten() {
                    let x: f64 = wave.along.iter().enumerate().map(|(k, w)| w * scaled(k)).sum();
                    *value += wave.size * (x + wave.phase).cos();
                }
                if let Some(size) = self.friction.get(j) {
                    let step = last.map_or(0.0, |last| q[j] - last[j]);
                    for (x, slip) in pressed[j].iter_mut().zip(SLIP) {
                        let slip = slip * self.half[j];
                        *x = (*x + step).clamp(-slip, slip);
                        *value -= size * *x / slip / 3.0;
                    }
                }
                if let (Some(size), Some(draw)) = (self.scatter.get(j), scatter.as_deref_mut()) {
                    *value += size * draw.normal();
                }
            }
            last = Some(q);
            all.push(stands);
        }
        all
    }

    /// Adds the instrument's wandering to what was measured.
    pub fn wander(&self, data: &mut Dataset, draw: &mut Draw) {
        let Some((size, rows)) = self.wander else { return };
        let keep = (-1.0 / rows).exp();
        let mut off = [0.0; 3].map(|_: f64| size * draw.normal());
        for position in &mut data.position {
            for (value, off) in position.iter_mut().zip(&mut off) {
                *off = keep * *off + (1.0 - keep * keep).sqrt() * size * draw.normal();
                *value += *off;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::robots::Stream;
    use super::*;

    #[test]
    fn nothing_is_nothing() {
        let chain = samples::heavy();
        let commanded = vec![vec![0.1; 6], vec![0.4; 6]];
        assert_eq!(Unnamed::of(&chain).performed(&commanded, None), commanded);
    }

    #[test]
    fn friction_remembers_more_than_the_last_move() {
        let chain = samples::heavy();
        let friction = Unnamed::of(&chain).with_hysteresis(0.3);
        let way = |first: f64| -> Vec<Vec<f64>> { [0.0, first, 0.2, 0.21].map(|q| vec![q; 6]).into() };
        let [far, near] = [1.5, 0.15].map(|first| friction.performed(&way(first), None)[3][0] - 0.21);
        // The same last move to the same place: from below by 0.01 rad. The long element (0.7 rad) was turned by 1.3 rad before.
        assert!((far - near).abs() > 5e-5 && far.abs() < 3.01e-4 && near.abs() < 3.01e-4, "{far} {near}");
    }

    #[test]
    fn nonsense_is_smooth_and_has_its_size() {
        let chain = samples::heavy();
        let mut draw = Stream::Unnamed.draw(5);
        let field = Unnamed::of(&chain).with_nonsense(0.2, &mut draw);
        let off = |q: &[f64]| field.performed(&[q.to_vec()], None)[0][1] - q[1];
        let mut square = 0.0;
        for _ in 0..500 {
            let q: Vec<f64> = (0..6).map(|_| draw.between(-2.0, 2.0)).collect();
            let mut beside = q.clone();
            beside[3] += 0.01;
            square += off(&q).powi(2) / 500.0;
            assert!((off(&q) - off(&beside)).abs() < 2e-5);
        }
        // Five waves of normal size: the root mean square of one joint is drawn as well.
        assert!((5e-5..8e-4).contains(&square.sqrt()), "{}", square.sqrt());
    }

    #[test]
    fn the_instrument_wanders_with_a_memory() {
        let wandering = Unnamed::default().with_wander(1e-4, 20.0);
        let mut data = Dataset { position: vec![[0.0; 3]; 20_000], ..Dataset::default() };
        wandering.wander(&mut data, &mut Stream::Scatter.draw(1));
        let x = |k: usize| data.position[k][0];
        let square: f64 = (0..19_980).map(|k| x(k) * x(k)).sum();
        let later: f64 = (0..19_980).map(|k| x(k) * x(k + 20)).sum();
        // 20 000 rows hold some 500 independent ones: 5 % of the size, 0.06 of the correlation e⁻¹ = 0.368.
        assert!(((square / 19_980.0).sqrt() / 1e-4 - 1.0).abs() < 0.15, "{square}");
        assert!((later / square - 0.368).abs() < 0.15, "{}", later / square);
    }
}
