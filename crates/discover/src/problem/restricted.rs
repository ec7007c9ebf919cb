//! Variance components by restricted maximum likelihood, with the scatter of the joints among them, beside a candidate.
//!
//! ```text
//! V = S + Σ θ_i V_i,   V_τ = 1 (positions),  V_ρ = 1 1ᵀ by pose and component,  V_ω = 1 (orientations),  V_σ = G_v G_vᵀ by pose
//! P = V⁻¹ − V⁻¹A (AᵀV⁻¹A + K)⁻¹ AᵀV⁻¹,     H = XᵀP X + κ,     P_X = P − P X H⁻¹ XᵀP
//! −2 ln L_R = ln det V + ln det(AᵀV⁻¹A + K) + ln det H + yᵀP_X y
//! s_i = (yᵀP_X V_i P_X y − tr P_X V_i)/2,     I_ij = yᵀP_X V_i P_X V_j P_X y / 2
//! ```
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | S | what the instrument states | m × m |
//! | θ | τ², ρ², ω², σ² of turning joints, σ² of slides ([`crate::problem::variance`]) | 1 |
//! | A, K | columns of the model, with the precision of their prior: what [`crate::problem::anchor`] knows of them | m × r, r × r |
//! | X, κ | columns of the candidate, with the precision of their prior | m × k, 1 |
//! | s, I | score and average information | components |
//!
//! V is block-diagonal by pose, and every V_i has a factor of few columns there. Steps are Newton's with the average information (Gilmour,
//! Thompson and Cullis 1995), held at zero where the likelihood falls from there, and halved until the likelihood rises. Source of the
//! likelihood: Patterson and Thompson (1971).

use crate::problem::anchor::{Anchor, Anchors, Grid, scales, unit};
use crate::problem::linearisation::Linearisation;
use crate::problem::noise::{JointNoise, Noise};
use crate::problem::variance::{Component, Parts};
use crate::statistics::product::{cholesky, cross};
use crate::statistics::triangular::{inverse_lower, solve_lower};
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;
use truepose_identify::NoiseModel;

/// The noise beside a candidate is estimated.
pub(crate) struct Restricted<'l> {
    problem: &'l Linearisation<'l>,
    parts: Arc<Parts>,
    /// X.
    extra: &'l DMatrix<f64>,
    /// κ.
    precision: f64,
    /// Whether X is integrated out, as A is. Else it is estimated, and ln det H is left out.
    integrated: bool,
}

/// The likelihood at one noise.
pub(crate) struct State {
    anchor: Arc<Anchor>,
    /// −2 ln L_R, of which the second part is ln det V + yᵀP_X y: −2 ln of the likelihood at the estimated coefficients.
    pub restricted: f64,
    pub deviance: f64,
    /// γ, and its covariance H⁻¹.
    pub coefficients: DVector<f64>,
    pub covariance: DMatrix<f64>,
    /// P X turned, so that P_X = P − U Uᵀ: m × k.
    taken: DMatrix<f64>,
    /// P_X y, m × 1.
    weighed: DMatrix<f64>,
}

impl State {
    pub fn noise(&self) -> Noise {
        self.anchor.noise
    }
}

/// Score and average information of all components.
pub(crate) struct Derivatives {
    pub components: Vec<Component>,
    pub score: DVector<f64>,
    pub information: DMatrix<f64>,
}

impl Derivatives {
    /// z² of the score of a component at the best of all others, where it is positive: s²/(I_kk − I_ko I_oo⁻¹ I_ok).
    pub fn towards(&self, k: usize) -> Option<f64> {
        let inverse = self.information.clone().try_inverse()?;
        let step = (inverse.row(k) * &self.score)[(0, 0)];
        (step > 0.0 && inverse[(k, k)] > 0.0).then(|| step * step / inverse[(k, k)])
    }
}

/// Noises that may be asked for: the present model at one, and the nearest one.
struct Noises<'a> {
    anchor: &'a dyn Fn(Noise) -> Option<Arc<Anchor>>,
    nearest: &'a dyn Fn(Noise) -> Noise,
}

impl<'l> Restricted<'l> {
    /// Of a linearised problem with further raw columns (m × k), of which each coefficient has a prior of this precision.
    pub fn new(problem: &'l Linearisation<'l>, extra: &'l DMatrix<f64>, precision: f64) -> Self {
        let parts = problem.kept::<Anchors>().parts(problem);
        Restricted { problem, parts, extra, precision, integrated: true }
    }

    /// The same with the further columns estimated, so that its likelihood is comparable with that without them.
    pub fn beside(self) -> Self {
        Restricted { integrated: false, ..self }
    }

    /// The state of the largest restricted likelihood, from a start; where the start has no scatter of the joints, and `joints` does not allow
    /// it, there is none.
    pub fn fitted(&self, start: Noise, joints: bool) -> Option<State> {
        let anchor = |noise| Anchor::new(self.problem, noise).map(Arc::new);
        self.climbed(start, joints, &Noises { anchor: &anchor, nearest: &|noise| noise })
    }

    /// The same on the grid of noises around that of the present model, which all candidates share.
    pub fn on_grid(&self) -> Option<State> {
        let (anchors, start) = (self.problem.kept::<Anchors>(), self.problem.noise);
        let at = |noise| anchors.at(self.problem, noise);
        let grid = anchors.grid(|| {
            let alone = DMatrix::zeros(self.problem.len(), 0);
            let present = Restricted::new(self.problem, &alone, 0.0);
            let Derivatives { components, information, .. } = present.derivatives(&present.at(at(start)?)?);
            let known: Vec<_> = components.into_iter().zip(information.diagonal().iter().copied()).collect();
            Some(Grid::around(start, &known))
        })?;
        self.climbed(start, true, &Noises { anchor: &at, nearest: &|noise| grid.nearest(noise) })
    }

    fn climbed(&self, start: Noise, joints: bool, noises: &Noises<'_>) -> Option<State> {
        const STEPS: usize = 25;
        /// Decrease of −2 ln L that is none.
        const STILL: f64 = 0.01;
        let mut state = self.at((noises.anchor)(start)?)?;
        for _ in 0..STEPS {
            let Derivatives { components, score, information } = self.derivatives(&state);
            let value: Vec<f64> = components.iter().map(|c| c.of(state.noise())).collect();
            let free = |k: &usize| {
                (joints || !components[*k].is_of_joints())
                    && (value[*k] > least(components[*k], start) || score[*k] > 0.0)
            };
            let free: Vec<usize> = (0..components.len()).filter(free).collect();
            let Some(step) = newton(&score, &information, &free) else { break };
            let before = state.restricted;
            let mut better = None;
            for halving in 0..8 {
                let part = 0.5f64.powi(halving);
                let mut trial = state.noise();
                for (&k, step) in free.iter().zip(step.iter()) {
                    components[k].set(&mut trial, (value[k] + part * step).max(least(components[k], start)));
                }
                let trial = (noises.nearest)(trial);
                if trial == state.noise() {
                    break;
                }
                let next = (noises.anchor)(trial).and_then(|anchor| self.at(anchor));
                if let Some(next) = next.filter(|next| next.restricted < before) {
                    better = Some(next);
                    break;
                }
            }
            let Some(next) = better else { break };
            state = next;
            if before - state.restricted < STILL {
                break;
            }
        }
        Some(state)
    }

    /// Score and information at a noise.
    pub fn derivatives_at(&self, noise: Noise) -> Option<Derivatives> {
        Some(self.derivatives(&self.at(Arc::new(Anchor::new(self.problem, noise)?))?))
    }

    fn at(&self, anchor: Arc<Anchor>) -> Option<State> {
        let (base, whitener) = (&self.problem.base, &anchor.whitener);
        let k = self.extra.ncols();
        let white = whitener.of(self.extra);
        let mut weighed = white.clone();
        whitener.apply_transposed(&mut weighed);
        let turned = anchor.turned(base, &weighed);
        let along = cross(&white, &anchor.left);
        // H, in columns of unit length before A took its part.
        let mut whole = cross(&white, &white);
        (0..k).for_each(|j| whole[(j, j)] += self.precision);
        let scale = scales(whole.diagonal().iter());
        let mut left = whole - cross(&turned, &turned);
        unit(&mut left, &scale);
        let lower = cholesky(left)?.unpack_dirty();
        let mut solution = DMatrix::from_fn(k, 1, |i, _| along[(i, 0)] * scale[i]);
        solve_lower(&lower, &mut solution);
        let squares = anchor.squares - solution.norm_squared();
        let of_candidate: f64 = (0..k).map(|j| 2.0 * (lower[(j, j)] / scale[j]).ln()).sum();
        let [of_noise, of_model] = anchor.determinants;
        let deviance = of_noise + squares;
        let restricted = deviance + of_model + if self.integrated { of_candidate } else { 0.0 };
        // P X = Wᵀ W (X − A C⁻¹ AᵀV⁻¹X), turned by D L⁻ᵀ.
        let mut taken = whitener.of(&(self.extra - base * anchor.solved(turned)));
        whitener.apply_transposed(&mut taken);
        let mut inverse = inverse_lower(&lower).transpose();
        for (mut row, scale) in inverse.row_iter_mut().zip(&scale) {
            row *= *scale;
        }
        let taken = taken * &inverse;
        let mut weighed = anchor.left.clone();
        whitener.apply_transposed(&mut weighed);
        weighed -= &taken * &solution;
        let coefficients = (&inverse * solution).column(0).into_owned();
        let covariance = &inverse * inverse.transpose();
        restricted.is_finite().then_some(State {
            anchor,
            restricted,
            deviance,
            coefficients,
            covariance,
            taken,
            weighed,
        })
    }

    fn derivatives(&self, state: &State) -> Derivatives {
        let (base, anchor) = (&self.problem.base, &state.anchor);
        let through = self.parts.through(&state.weighed);
        let mut score = cross(&through, &state.weighed).column(0).into_owned();
        for (i, of_model) in anchor.traces(base, &self.parts).iter().enumerate() {
            // A candidate that is estimated takes nothing from the determinant.
            let part = &self.parts.each[i].1;
            let of_candidate = if self.integrated { self.parts.trace(part, &state.taken) } else { 0.0 };
            score[i] = 0.5 * (score[i] - (of_model - of_candidate));
        }
        let white = anchor.whitener.of(&through);
        let mut weighed = white.clone();
        anchor.whitener.apply_transposed(&mut weighed);
        let turned = anchor.turned(base, &weighed);
        let along = cross(&state.taken, &through);
        let information = (cross(&white, &white) - cross(&turned, &turned) - cross(&along, &along)) * 0.5;
        Derivatives { components: self.parts.each.iter().map(|part| part.0).collect(), score, information }
    }
}

/// θ below which a component is not taken: the scatter of rows of which nothing is stated is never nothing.
fn least(component: Component, start: Noise) -> f64 {
    /// Of the start's standard deviation.
    const LEAST: f64 = 1e-3;
    match component {
        Component::Rows | Component::Turns => LEAST * LEAST * component.of(start),
        _ => 0.0,
    }
}

/// The step of some components; none where their information is singular.
fn newton(score: &DVector<f64>, information: &DMatrix<f64>, free: &[usize]) -> Option<DVector<f64>> {
    if free.is_empty() {
        return None;
    }
    let size: Vec<f64> = free.iter().map(|&k| information[(k, k)].sqrt()).collect();
    if size.iter().any(|s| s.is_nan() || *s <= 0.0) {
        return None;
    }
    let n = free.len();
    let scaled = DMatrix::from_fn(n, n, |i, j| {
        information[(free[i], free[j])] / (size[i] * size[j]) + if i == j { 1e-9 } else { 0.0 }
    });
    let right = DVector::from_fn(n, |i, _| score[free[i]] / size[i]);
    let step = scaled.cholesky()?.solve(&right);
    Some(DVector::from_fn(n, |i, _| step[i] / size[i]))
}

/// Without a scatter of the joints.
pub(crate) fn plain(rows: NoiseModel) -> Noise {
    Noise { rows, joints: JointNoise::default() }
}
