//! What the library has no word for: between the joint values that are commanded and those at which the robot stands.
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

use super::draw::Draw;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, JointKind};

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
