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
mod tests {
    use super::*;
    use crate::Schema;
    use crate::effects::{Geometric, JointCompliance, LinkCompliance};
    use truepose_kinematics::{JointId, Load, Payload, samples};

    /// One turn about a horizontal axis with a mass at the end of an arm: `k δ = m g l cos(q + δ)`, solved by bisection.
    #[test]
    fn a_spring_holds_the_weight_where_it_comes_to_rest() {
        let chain = samples::ur10();
        let model = ErrorModel::new(chain.clone(), vec![Box::new(JointCompliance::of(JointId(2)))]).unwrap();
        let bound = model.bind(&Schema { load: true, ..Schema::default() }).unwrap();
        let load = Load::Payload(Payload { mass: 60.0, com: Vector3::new(0.0, 0.0, 0.1) });
        let q = [0.0, -0.4, 0.0, 0.0, 0.0, 0.0];
        let (conditions, compliance) = (Conditions::at(&chain, &q).with_load(load), 1e-5);
        let mut rest = Equilibrium::new(&model);
        rest.settle(&bound, &conditions, &[compliance]);
        let found = rest.real().after(FrameId(1)).rotation.column(0).angle(&Vector3::x());
        let torque = |delta: f64| {
            let mut bent = conditions.clone();
            bent.joints[1] += delta;
            PostureBuffer::new(&chain).update(&chain, &bent).joint_load(JointId(2))
        };
        let (mut low, mut high) = (0.0, 0.05_f64.copysign(torque(0.0)));
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if compliance * torque(middle) / middle > 1.0 { low = middle } else { high = middle }
        }
        // 7 mrad, of which the nominal posture's weights would miss 1 %; rad.
        assert!(low.abs() > 5e-3, "{low}");
        assert!((found - low.abs()).abs() < 1e-7, "{found} against {low}");
        let nominal = compliance * torque(0.0);
        assert!((nominal.abs() - low.abs()).abs() > 1e-5, "{nominal} against {low}");
    }

    #[test]
    fn more_steps_change_nothing_that_matters() {
        let chain = samples::heavy();
        let effects: Vec<Box<dyn crate::AnyEffect>> = vec![
            Box::new(Geometric::default()),
            Box::new(JointCompliance::default()),
            Box::new(LinkCompliance::default()),
        ];
        let model = ErrorModel::new(chain.clone(), effects).unwrap();
        let bound = model.bind(&Schema { load: true, ..Schema::default() }).unwrap();
        let c: Vec<f64> = model.columns().iter().map(|column| 0.1 * column.scale).collect();
        let load = Load::Payload(Payload { mass: 150.0, com: Vector3::new(0.1, 0.0, 0.2) });
        let conditions = Conditions::at(&chain, &[0.3, -0.4, 0.5, 0.6, -0.7, 0.8]).with_load(load);
        let mut rest = Equilibrium::new(&model);
        rest.settle(&bound, &conditions, &c);
        let tool = *rest.real().tool();
        for _ in 0..5 {
            let mut real = rest.real.clone();
            std::mem::swap(&mut real, &mut rest.real);
            let posture =
                rest.posture.settle(&chain, &conditions, &chain.gravity_in_measurement_frame(), |frame| {
                    *real.after(frame)
                });
            bound.emit(&posture, &mut rest.emission);
            rest.errors.weigh(&rest.emission, &c);
            rest.real.update(&posture, &rest.errors);
        }
        let moved = (rest.real().tool().translation - tool.translation).norm();
        let bent = (tool.translation - chain.forward(&conditions.joints).translation).norm();
        // The second power of a hundredth, and a factor for the lever.
        assert!(bent > 1e-3 && moved < 1e-3 * bent, "{moved} of {bent}");
    }

    /// Servo arms yield by degrees: where they come to rest is `δ = c τ(q + δ)`, and what a further compliance does is
    /// `dδ/dc = τ/(1 − c ∂τ/∂q)`, by differences of that.
    #[test]
    fn a_soft_arm_comes_to_rest_and_its_slope_is_that_of_the_rest() {
        let chain = samples::ur10();
        let of = |joint: usize| Box::new(JointCompliance::of(JointId(joint))) as Box<dyn crate::AnyEffect>;
        let model =
            ErrorModel::new(chain.clone(), vec![of(2), of(3), Box::new(Geometric::default())]).unwrap();
        let bound = model.bind(&Schema { load: true, ..Schema::default() }).unwrap();
        let load = Load::Payload(Payload { mass: 10.0, com: Vector3::new(0.02, 0.01, 0.1) });
        let conditions = Conditions::at(&chain, &[0.3, -0.9, 0.7, 0.2, 0.4, 0.1]).with_load(load);
        let mut c = vec![0.0; model.columns().len()];
        (c[0], c[1]) = (8e-4, 6e-4);
        let mut rest = Equilibrium::new(&model).soft(true);
        let mut tip = |c: &[f64]| {
            rest.settle(&bound, &conditions, c);
            rest.real().tool().translation
        };
        let at = tip(&c);
        let mut by_hand = conditions.clone();
        for _ in 0..200 {
            let mut buffer = PostureBuffer::new(&chain);
            let posture = buffer.update(&chain, &by_hand);
            let turns = [2, 3].map(|joint| posture.joint_load(JointId(joint)));
            by_hand.joints[1] = conditions.joints[1] + c[0] * turns[0];
            by_hand.joints[2] = conditions.joints[2] + c[1] * turns[1];
        }
        let expected = chain.forward(&by_hand.joints).translation;
        let bent = (chain.forward(&conditions.joints).translation - expected).norm();
        assert!(bent > 0.05 && (at - expected).norm() < 1e-9, "{} of {bent}", (at - expected).norm());
        for column in (0..c.len()).filter(|&k| model.columns()[k].scale > 0.0) {
            let step = 1e-3 * if column < 2 { 1e-2 } else { 1.0 };
            let mut moved = |by: f64| {
                let mut c = c.clone();
                c[column] += by * step;
                tip(&c)
            };
            let difference = (8.0 * (moved(1.0) - moved(-1.0)) - moved(2.0) + moved(-2.0)) / (12.0 * step);
            let mut again = Equilibrium::new(&model).soft(true);
            again.settle(&bound, &conditions, &c);
            let slope = again.slope(&bound, &conditions, &c).expect("soft");
            let jacobian =
                crate::ErrorJacobian::new(&chain, again.real(), again.errors(), None).matrix(&chain);
            let followed = jacobian.fixed_rows::<3>(0).columns(0, slope.nrows()) * slope;
            let entries = again.emission().entries().iter().filter(|entry| entry.column == column);
            let found: Vector3<f64> = entries
                .filter_map(|entry| {
                    Some(
                        entry.value * followed.column(chain.site_index(entry.site).min(followed.ncols() - 1)),
                    )
                })
                .sum();
            assert!(
                (found - difference).norm() < 1e-6 * (1.0 + difference.norm()),
                "{column}: {found} {difference}"
            );
        }
    }
}
