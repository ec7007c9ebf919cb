//! The real robot at rest: what yields is asked under the weights of the posture that it has itself bent.
//!
//! ```text
//! ε⁰ = Φ(s; nominal) c,    ε^{k+1} = Φ(s; wrenches at T(ε^k)) c,    k = 0, 1 (…)
//! dε = (I − G)⁻¹ Φ dc,       G = ∂(Φ c)/∂ε
//! ```
//!
//! | symbol | here | unit | frame |
//! | --- | --- | --- | --- |
//! | T(ε) | [`RealPosture`], exact `E_i` | m | measurement |
//! | Φ | `emission`, at the last ε | each its own | |
//!
//! Joint values, signals and loads stay those of the conditions; only frames and wrenches follow. A joint that yields by 5 mrad under
//! 20 kN·m carries another moment where it comes to rest than where it was sent: on a heavy arm that is 0.05 mm, as much as
//! repeatability. Each step leaves the share (load × compliance / arm ≈ 1e-2) of the change before, so that two are
//! enough: a deflection of 10 mm is right to 10 nm. Where the second still moves something (servo arms whose joints yield by degrees), the
//! steps go on until nothing moves, and the weights that follow a further deflection are part of its slope ([`Equilibrium::slope`]).
//! Source: the fixed-point form of K(x) x = w(x) of structural mechanics.

use crate::generalized::error_matrix_of_small;
use crate::model::Pace;
use crate::{
    BoundModel, Dataset, Emission, Entry, ErrorModel, GeneralizedErrors, ModelError, RealPosture,
    error_matrix,
};
use nalgebra::{DMatrix, Vector3};
use truepose_kinematics::{Chain, Conditions, FrameId, GravityFrame, Pose, Posture, PostureBuffer, Site};

/// How often the weights follow the deflections.
pub(crate) const STEPS: usize = 2;
/// What the last of them may move, m or rad: more than that is a soft robot.
pub(crate) const SOFT: f64 = 1e-5;
/// There it goes on until nothing moves by more than this, so often at most.
const STILL: f64 = 1e-12;
const MOST: usize = 80;

/// A robot with errors, brought to rest posture after posture; memory is used again and again.
#[derive(Debug, Clone)]
pub struct Equilibrium {
    posture: PostureBuffer,
    emission: Emission,
    errors: GeneralizedErrors,
    /// Those that do not yield.
    stiff: GeneralizedErrors,
    real: RealPosture,
    /// Entries of effects that say the same everywhere: the first ones, once they have been asked.
    constant: Option<usize>,
    /// Entries of effects that depend on no wrench: the first ones.
    still: usize,
    /// ε of the step before.
    last: GeneralizedErrors,
    /// How often the weights followed the deflections at the last posture.
    steps: usize,
    /// Whether steps always go on until nothing moves.
    soft: bool,
}

impl Equilibrium {
    /// Memory for this model, so that no posture allocates.
    pub fn new(model: &ErrorModel) -> Self {
        let chain = model.chain();
        Equilibrium {
            posture: PostureBuffer::new(chain),
            // An effect speaks of a column at most once a component of two frames or so.
            emission: Emission::with_capacity(12 * model.columns().len()),
            errors: GeneralizedErrors::zero(chain),
            stiff: GeneralizedErrors::zero(chain),
            real: RealPosture::new(chain),
            constant: None,
            still: 0,
            last: GeneralizedErrors::zero(chain),
            steps: 0,
            soft: false,
        }
    }

    /// The same, [`Equilibrium::soft`] where the robot is in some of these rows with these coefficients.
    ///
    /// # Errors
    /// When the data lacks a signal that the model needs.
    pub fn of_rows(model: &ErrorModel, data: &Dataset, coefficients: &[f64]) -> Result<Self, ModelError> {
        Ok(Equilibrium::new(model).soft(Equilibrium::is_soft(model, data, coefficients)?))
    }

    /// Φ where the robot comes to rest.
    pub fn emission(&self) -> &Emission {
        &self.emission
    }

    /// The same without the effects that say the same at every posture.
    pub fn changing(&self) -> &[Entry] {
        &self.emission.entries()[self.constant.unwrap_or(0)..]
    }

    /// ε = Φ c.
    pub fn errors(&self) -> &GeneralizedErrors {
        &self.errors
    }

    /// The frames with these errors.
    pub fn real(&self) -> &RealPosture {
        &self.real
    }

    /// Φ of other effects where this robot came to rest, under the conditions of the last [`Equilibrium::settle`]: replaces what
    /// `out` holds.
    pub fn emit(&self, bound: &BoundModel<'_>, conditions: &Conditions, out: &mut Emission) {
        bound.emit(&self.posture.view(bound.model().chain(), conditions), out);
    }

    /// Frames and wrenches where this robot came to rest, under the conditions of the last [`Equilibrium::settle`], whether or not one of
    /// its own effects asks for them.
    pub fn posture_at_rest(
        &self,
        bound: &BoundModel<'_>,
        conditions: &Conditions,
        coefficients: &[f64],
    ) -> PostureBuffer {
        let chain = bound.model().chain();
        let still = self.emission.entries().len().min(self.still);
        let gravity = self.gravity(chain, still, coefficients);
        let mut buffer = self.posture.clone();
        buffer.settle(chain, conditions, &gravity, |frame| *self.real.after(frame));
        buffer
    }

    /// Moves to these conditions, with these coefficients (one a column of the model).
    pub fn settle(&mut self, bound: &BoundModel<'_>, conditions: &Conditions, coefficients: &[f64]) {
        self.settle_errors(bound, conditions, coefficients);
        self.real.update(&self.posture.view(bound.model().chain(), conditions), &self.errors);
    }

    /// As [`Equilibrium::settle`], for who asks for Φ and ε alone: [`Equilibrium::real`] stays behind.
    pub fn settle_errors(&mut self, bound: &BoundModel<'_>, conditions: &Conditions, coefficients: &[f64]) {
        let chain = bound.model().chain();
        let posture = self.posture.update(chain, conditions);
        match self.constant {
            Some(entries) => self.emission.truncate(entries),
            None => {
                self.emission.clear();
                bound.emit_paced(Pace::Constant, &posture, &mut self.emission);
                self.constant = Some(self.emission.entries().len());
            }
        }
        bound.emit_paced(Pace::Moving, &posture, &mut self.emission);
        let still = self.emission.entries().len();
        self.still = still;
        self.stiff.weigh(&self.emission, coefficients);
        bound.emit_paced(Pace::Settling, &posture, &mut self.emission);
        self.yielding(still, coefficients);

        let moves = self.emission.entries().iter().any(|entry| coefficients[entry.column] != 0.0);
        self.steps = 0;
        if self.emission.entries().len() == still || !moves {
            return;
        }
        let gravity = self.gravity(chain, still, coefficients);
        for step in 1..=MOST {
            self.last.copy_from(&self.errors);
            // Levers of weights: what the fourth power of a small angle adds to them is nothing.
            let matrix = if step <= STEPS { error_matrix_of_small } else { error_matrix };
            let posture = bent(&mut self.posture, chain, (conditions, &gravity), &self.errors, matrix);
            self.emission.truncate(still);
            bound.emit_paced(Pace::Settling, &posture, &mut self.emission);
            self.yielding(still, coefficients);
            let moved = if step < STEPS { f64::INFINITY } else { self.errors.furthest(&self.last) };
            if moved <= if step == STEPS && !self.soft { SOFT } else { STILL } {
                break;
            }
            self.steps = step + 1;
        }
    }

    /// Whether a robot with these coefficients is soft: in some of the rows of a data set, two steps are not enough.
    ///
    /// # Errors
    /// When the data lacks a signal that the model needs.
    pub fn is_soft(model: &ErrorModel, data: &Dataset, coefficients: &[f64]) -> Result<bool, ModelError> {
        /// Rows that are looked at, over all of them.
        const SOME: usize = 24;
        let moves = |k: usize| coefficients[model.columns_of(k)].iter().any(|&c| c != 0.0);
        if !model.effects().iter().enumerate().any(|(k, effect)| effect.load_dependent() && moves(k)) {
            return Ok(false);
        }
        let (bound, mut rest) = (model.bind(&data.schema)?, Equilibrium::new(model));
        let mut conditions = Conditions::default();
        Ok((0..data.len()).step_by(data.len().div_ceil(SOME).max(1)).any(|row| {
            data.conditions_into(row, &mut conditions);
            rest.settle_errors(&bound, &conditions, coefficients);
            rest.steps > STEPS
        }))
    }

    /// As one of a soft robot: until nothing moves at any posture, so that all are alike.
    #[must_use]
    pub fn soft(mut self, soft: bool) -> Self {
        self.soft = soft;
        self
    }

    /// J_e, rows × sites, with the weights following each error under these conditions, those of the last [`Equilibrium::settle`]: J_e (I − G)⁻¹.
    pub fn followed(
        &self,
        bound: &BoundModel<'_>,
        conditions: &Conditions,
        coefficients: &[f64],
        mut jacobian: DMatrix<f64>,
    ) -> DMatrix<f64> {
        if let Some(slope) = self.slope(bound, conditions, coefficients) {
            let followed = jacobian.columns(0, slope.nrows()) * &slope;
            jacobian.columns_mut(0, slope.nrows()).copy_from(&followed);
        }
        jacobian
    }

    /// (I − G)⁻¹ over the sites of frames, sites × sites, in the order of [`Chain::site_index`], under the conditions of the last
    /// [`Equilibrium::settle`]: what a further error at each site becomes once the weights have followed it. None of a robot that is not
    /// [`Equilibrium::soft`]: there it is the identity for all that matters.
    pub fn slope(
        &self,
        bound: &BoundModel<'_>,
        conditions: &Conditions,
        coefficients: &[f64],
    ) -> Option<DMatrix<f64>> {
        /// Of differences to the fourth order, m or rad.
        const STEP: f64 = 1e-3;
        const STENCIL: [(f64, f64); 4] =
            [(-2.0, 1.0 / 12.0), (-1.0, -8.0 / 12.0), (1.0, 8.0 / 12.0), (2.0, -1.0 / 12.0)];
        if !self.soft {
            return None;
        }
        let chain = bound.model().chain();
        let gravity = self.gravity(chain, self.still, coefficients);
        let mut posture = self.posture.clone();
        let (mut emission, mut at) = (Emission::new(), self.errors.clone());
        let sites = 6 * chain.frames().len();
        let mut left = DMatrix::identity(sites, sites);
        for column in 0..sites {
            for (by, share) in STENCIL {
                at.copy_from(&self.errors);
                at.add(chain.site_at(column), by * STEP);
                emission.clear();
                let view = bent(&mut posture, chain, (conditions, &gravity), &at, error_matrix);
                bound.emit_paced(Pace::Settling, &view, &mut emission);
                for entry in emission.entries() {
                    let row = chain.site_index(entry.site);
                    if row < sites {
                        left[(row, column)] -= share / STEP * entry.value * coefficients[entry.column];
                    }
                }
            }
        }
        left.try_inverse()
    }

    /// ε of what is stiff and of the entries that yield.
    fn yielding(&mut self, still: usize, coefficients: &[f64]) {
        self.errors.copy_from(&self.stiff);
        self.errors.add_those(&self.emission.entries()[still..], coefficients);
    }

    /// Gravity in the measurement frame. Where it was given in the base's axes it goes with the base, wherever that stands:
    /// constant errors of frame 0 (the first entries) turn it as well. A base that yields turns under a gravity that stays.
    fn gravity(&self, chain: &Chain, still: usize, coefficients: &[f64]) -> Vector3<f64> {
        if chain.gravity().frame == GravityFrame::Measurement {
            return chain.gravity_in_measurement_frame();
        }
        let mut turned = [0.0; 6];
        for entry in &self.emission.entries()[..still] {
            if let Site::Frame(FrameId::BASE, axis) = entry.site {
                turned[axis.index()] += entry.value * coefficients[entry.column];
            }
        }
        chain.base().pose.rotation * (error_matrix(&turned).rotation * chain.gravity().vector)
    }
}

/// Frames and wrenches where the frames have these errors, each as this matrix.
fn bent<'p>(
    posture: &'p mut PostureBuffer,
    chain: &'p Chain,
    (conditions, gravity): (&'p Conditions, &Vector3<f64>),
    errors: &GeneralizedErrors,
    matrix: fn(&[f64; 6]) -> Pose,
) -> Posture<'p> {
    posture.bend(chain, conditions, gravity, |frame| {
        let e = errors.frame(frame);
        e.iter().any(|&v| v != 0.0).then(|| matrix(&e))
    })
}

#[cfg(test)]
mod tests;
