//! Variance components by restricted maximum likelihood, with the scatter of the joints among them.
//!
//! ```text
//! V = S + Σ θ_i V_i,   V_τ = 1 (positions),  V_ρ = 1 1ᵀ by pose and component,  V_ω = 1 (orientations),  V_σ = G_v G_vᵀ by pose
//! −2 ln L_R = ln det V + ln det(AᵀV⁻¹A + K) + yᵀP y,     P = V⁻¹ − V⁻¹A (AᵀV⁻¹A + K)⁻¹ AᵀV⁻¹
//! s_i = (yᵀP V_i P y − tr P V_i)/2,     I_ij = yᵀP V_i P V_j P y / 2
//! ```
//!
//! | symbol | here | shape |
//! | --- | --- | --- |
//! | S | what the instrument states | m × m |
//! | θ | τ², ρ², ω², σ² of turning joints, σ² of slides | 1 |
//! | A, K | columns of the model, with the precision of their prior | m × n, n × n |
//! | s, I | score and average information | components |
//!
//! V is block-diagonal by pose, and every V_i has a factor of few columns there: a step costs about two Gram matrices of the model. Steps are
//! Newton's with the average information (Gilmour, Thompson and Cullis 1995), held at zero where the likelihood falls from there, and halved
//! until the likelihood rises. Source of the likelihood: Patterson and Thompson (1971).

use crate::problem::linearisation::Linearisation;
use crate::problem::noise::{JointNoise, Noise};
use crate::problem::whitening::Whitener;
use crate::statistics::product::{cholesky, cross, gram_matrix};
use crate::statistics::triangular::solve_lower;
use nalgebra::{DMatrix, DVector};
use truepose_identify::NoiseModel;

/// A variance component.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Component {
    Rows,
    Poses,
    Turns,
    Turning,
    Sliding,
}

impl Component {
    /// Those of the joints.
    pub const JOINTS: [Component; 2] = [Component::Turning, Component::Sliding];

    fn is_of_joints(self) -> bool {
        Component::JOINTS.contains(&self)
    }

    /// θ, m² or rad².
    fn of(self, noise: Noise) -> f64 {
        let sd = match self {
            Component::Rows => noise.rows.position_sd,
            Component::Poses => noise.rows.visit_sd,
            Component::Turns => noise.rows.orientation_sd,
            Component::Turning => noise.joints.turning,
            Component::Sliding => noise.joints.sliding,
        };
        sd * sd
    }

    fn set(self, noise: &mut Noise, variance: f64) {
        *match self {
            Component::Rows => &mut noise.rows.position_sd,
            Component::Poses => &mut noise.rows.visit_sd,
            Component::Turns => &mut noise.rows.orientation_sd,
            Component::Turning => &mut noise.joints.turning,
            Component::Sliding => &mut noise.joints.sliding,
        } = variance.max(0.0).sqrt();
    }
}

/// V_i: the observations that it has to themselves, or a factor with columns of each pose.
enum Part {
    Own(Vec<bool>),
    Shared(DMatrix<f64>),
}

/// Columns [A | y] whose noise is estimated.
pub(crate) struct Restricted<'l> {
    linearisation: &'l Linearisation<'l>,
    /// Raw [A | y].
    raw: DMatrix<f64>,
    /// K.
    prior: DMatrix<f64>,
    /// Columns that are integrated out: the first ones. The others are estimated (their determinant is left out).
    integrated: usize,
    parts: Vec<(Component, Part)>,
    /// First observation of each pose, and the end.
    poses: Vec<usize>,
}

/// Likelihood and projections at one noise.
struct State {
    noise: Noise,
    whitener: Whitener,
    deviance: f64,
    /// Whitened columns A, m × n, the scale of each, and L of L Lᵀ = AᵀV⁻¹A + K, scaled.
    white: DMatrix<f64>,
    scale: Vec<f64>,
    lower: DMatrix<f64>,
    /// Whitened y − A β̂.
    left: DMatrix<f64>,
}

impl State {
    /// L⁻¹ (AᵀV⁻¹A + K)^{-1/2}-turned whitened columns, n × m: Qᵀ.
    fn turned(&self) -> DMatrix<f64> {
        let mut turned = self.white.transpose();
        for (mut row, scale) in turned.row_iter_mut().zip(&self.scale) {
            row *= *scale;
        }
        solve_lower(&self.lower, &mut turned);
        turned
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

impl<'l> Restricted<'l> {
    /// Of a linearised problem with further raw columns (m × k); `prior` is the precision of the prior of all.
    pub fn new(linearisation: &'l Linearisation<'l>, extra: &DMatrix<f64>, prior: DMatrix<f64>) -> Self {
        let observations = &linearisation.observations;
        let (m, r, k) = (linearisation.len(), linearisation.base.ncols(), extra.ncols());
        let mut raw = linearisation.base.clone().resize_horizontally(r + k + 1, 0.0);
        raw.columns_mut(r, k).copy_from(extra);
        raw.column_mut(r + k).copy_from(&linearisation.y);
        let mut poses = vec![0];
        for pose in observations.chunk_by(|a, b| a.visit == b.visit) {
            poses.push(poses[poses.len() - 1] + pose.len());
        }
        let mut parts = Vec::new();
        let own = |position: bool| -> Vec<bool> {
            observations.iter().map(|o| (o.component < 3) == position).collect()
        };
        if own(true).contains(&true) {
            parts.push((Component::Rows, Part::Own(own(true))));
            // Of poses with one row each, what they share is what they have.
            let several = poses.windows(2).any(|pose| {
                let rows = observations[pose[0]..pose[1]].iter().filter(|o| o.component < 3).map(|o| o.row);
                rows.clone().any(|row| rows.clone().any(|other| other != row))
            });
            if several {
                let shared =
                    DMatrix::from_fn(m, 3, |at, k| f64::from(u8::from(observations[at].component == k)));
                parts.push((Component::Poses, Part::Shared(shared)));
            }
        }
        if own(false).contains(&true) {
            parts.push((Component::Turns, Part::Own(own(false))));
        }
        for (component, slides) in [(Component::Turning, false), (Component::Sliding, true)] {
            let levers = linearisation.levers().of(slides);
            if levers.ncols() > 0 && levers.amax() > 0.0 {
                parts.push((component, Part::Shared(levers)));
            }
        }
        Restricted { linearisation, integrated: prior.ncols(), raw, prior, parts, poses }
    }

    /// The same with only so many columns integrated out, so that its likelihood is comparable with that of those alone.
    pub fn beside(self, integrated: usize) -> Self {
        Restricted { integrated, ..self }
    }

    /// The noise of the largest restricted likelihood and −2 ln of it, from a start; where the start has no scatter of the joints,
    /// and `joints` does not allow it, there is none.
    pub fn fitted(&self, start: Noise, joints: bool) -> Option<(Noise, f64)> {
        const STEPS: usize = 25;
        /// Decrease of −2 ln L that is none.
        const STILL: f64 = 0.01;
        let mut state = self.at(start)?;
        for _ in 0..STEPS {
            let Derivatives { components, score, information } = self.derivatives(&state);
            let value: Vec<f64> = components.iter().map(|c| c.of(state.noise)).collect();
            let free = |k: &usize| {
                (joints || !components[*k].is_of_joints())
                    && (value[*k] > self.least(components[*k], start) || score[*k] > 0.0)
            };
            let free: Vec<usize> = (0..components.len()).filter(free).collect();
            let Some(step) = newton(&score, &information, &free) else { break };
            let before = state.deviance;
            let mut better = None;
            for halving in 0..8 {
                let part = 0.5f64.powi(halving);
                let mut trial = state.noise;
                for (&k, step) in free.iter().zip(step.iter()) {
                    let least = self.least(components[k], start);
                    components[k].set(&mut trial, (value[k] + part * step).max(least));
                }
                if let Some(next) = self.at(trial).filter(|next| next.deviance < before) {
                    better = Some(next);
                    break;
                }
            }
            let Some(next) = better else { break };
            state = next;
            if before - state.deviance < STILL {
                break;
            }
        }
        Some((state.noise, state.deviance))
    }

    /// Score and information at a noise.
    pub fn derivatives_at(&self, noise: Noise) -> Option<Derivatives> {
        Some(self.derivatives(&self.at(noise)?))
    }

    /// θ below which a component is not taken: the scatter of rows of which nothing is stated is never nothing.
    fn least(&self, component: Component, start: Noise) -> f64 {
        /// Of the start's standard deviation.
        const LEAST: f64 = 1e-3;
        match component {
            Component::Rows | Component::Turns => LEAST * LEAST * component.of(start),
            _ => 0.0,
        }
    }

    fn at(&self, noise: Noise) -> Option<State> {
        let n = self.raw.ncols() - 1;
        let whitener = self.linearisation.whitener(noise);
        let white = whitener.of(&self.raw);
        let gram = gram_matrix(&white);
        let mut normal = gram.view((0, 0), (n, n)) + &self.prior;
        let scale: Vec<f64> =
            normal.diagonal().iter().map(|&d| if d > 0.0 { 1.0 / d.sqrt() } else { 1.0 }).collect();
        for j in 0..n {
            (0..n).for_each(|i| normal[(i, j)] *= scale[i] * scale[j]);
            normal[(j, j)] += 1e-12;
        }
        let factor = cholesky(normal)?;
        let lower = factor.l_dirty();
        let right = DVector::from_fn(n, |i, _| gram[(i, n)] * scale[i]);
        let solution = factor.solve(&right).component_mul(&DVector::from_column_slice(&scale));
        let left = white.column(n) - white.columns(0, n) * &solution;
        let held = (&self.prior * &solution).dot(&solution);
        let logarithm: f64 = (0..self.integrated).map(|k| 2.0 * (lower[(k, k)] / scale[k]).ln()).sum();
        let deviance = whitener.log_determinant() + logarithm + left.norm_squared() + held;
        let left = DMatrix::from_column_slice(left.len(), 1, left.as_slice());
        let lower = factor.unpack_dirty();
        let white = white.remove_column(n);
        deviance.is_finite().then_some(State { noise, whitener, deviance, white, scale, lower, left })
    }

    fn derivatives(&self, state: &State) -> Derivatives {
        let m = state.left.nrows();
        // P y, and V⁻¹A turned.
        let mut weighed = state.left.clone();
        state.whitener.apply_transposed(&mut weighed);
        // Of the columns that are integrated out: the others take nothing from the determinant.
        let all = state.turned();
        let turned = all.rows(0, self.integrated).transpose();
        let mut taken = turned.clone();
        let precisions = state.whitener.precisions(m);
        state.whitener.apply_transposed(&mut taken);
        let mut score = DVector::zeros(self.parts.len());
        let mut through = DMatrix::zeros(m, self.parts.len());
        for (i, (_, part)) in self.parts.iter().enumerate() {
            let trace = match part {
                Part::Own(own) => {
                    let mut trace = 0.0;
                    for at in (0..m).filter(|&at| own[at]) {
                        trace += precisions[at] - taken.row(at).norm_squared();
                        through[(at, i)] = weighed[(at, 0)];
                    }
                    trace
                }
                Part::Shared(factor) => {
                    let mut white = factor.clone();
                    state.whitener.apply(&mut white);
                    let mut trace = white.norm_squared();
                    for pose in self.poses.windows(2) {
                        let (first, size) = (pose[0], pose[1] - pose[0]);
                        let own = white.rows(first, size);
                        trace -= turned.rows(first, size).tr_mul(&own).norm_squared();
                        let raw = factor.rows(first, size);
                        let along = raw.tr_mul(&weighed.rows(first, size));
                        through.view_mut((first, i), (size, 1)).copy_from(&(raw * along));
                    }
                    trace
                }
            };
            score[i] = 0.5 * (through.column(i).dot(&weighed.column(0)) - trace);
        }
        let white = state.whitener.of(&through);
        let along = &all * &white;
        let information = (cross(&white, &white) - cross(&along, &along)) * 0.5;
        Derivatives { components: self.parts.iter().map(|part| part.0).collect(), score, information }
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
