//! The exact fitted model, evaluated as leanly as it goes.
//!
//! ```text
//! ε(s) = ε_0 + Φ(s) c        ε_0: effects that are constant generalized errors and nothing else, summed once
//! T(s) = C_0 M(q_1) C_1 …    see `arm`: only frames whose ε some effect moves are computed anew
//! ```
//!
//! Compliances are evaluated in static equilibrium, as at fit time ([`Equilibrium`]). The result is that of
//! `Predictor::predict`, to round-off.

use crate::arm::{Arm, Reached};
use crate::command::MOST;
use nalgebra::Vector3;
use truepose_errormodel::{BoundModel, Emission, Equilibrium, FittedModel, ModelError, Schema};
use truepose_kinematics::{Conditions, PostureBuffer, Site, TargetId, ToolId, sin_cos};

/// The real robot of a fitted model.
#[derive(Debug, Clone)]
pub(crate) struct RealArm<'m> {
    fitted: &'m FittedModel,
    bound: BoundModel<'m>,
    /// Effects that have to be evaluated at every posture.
    moving: Vec<usize>,
    /// ε_0, in the order of `Chain::site_index`.
    constant: Vec<f64>,
    errors: Vec<f64>,
    moves: Vec<bool>,
    /// Constants multiplied out at the components that no effect moved when it was bound.
    lean: Arm,
    /// Every component computed: for the posture at which an effect speaks of one that it had not spoken of before.
    full: Arm,
    posture: PostureBuffer,
    emission: Emission,
    /// For models of which some effect depends on what the robot carries.
    rest: Option<Equilibrium>,
}

impl<'m> RealArm<'m> {
    pub fn bind(fitted: &'m FittedModel, schema: &Schema, tool: ToolId) -> Result<Self, ModelError> {
        // For its check of the channels' units.
        fitted.bind(schema)?;
        let model = fitted.model();
        let chain = fitted.chain();
        let (still, moving): (Vec<usize>, Vec<usize>) =
            (0..model.effects().len()).partition(|&k| model.is_constant(k));
        let frames = chain.frames().len();
        let moving_columns: usize = moving.iter().map(|&k| model.columns_of(k).len()).sum();
        let mut arm = RealArm {
            fitted,
            bound: model.bind(schema)?,
            moving,
            constant: vec![0.0; chain.site_count()],
            errors: vec![0.0; chain.site_count()],
            moves: vec![false; 6 * frames],
            lean: Arm::to_tool(chain, tool, &[], &[]),
            full: Arm::to_tool(chain, tool, &[], &vec![true; 6 * frames]),
            posture: PostureBuffer::new(chain),
            // An effect speaks of a column at most once a component of two frames or so.
            emission: Emission::with_capacity(12 * moving_columns.max(still.len())),
            rest: model
                .effects()
                .iter()
                .any(|effect| effect.load_dependent())
                .then(|| Equilibrium::new(model)),
        };
        let mut conditions = Conditions::at(chain, &vec![0.0; chain.movable().len()]);
        conditions.channels = vec![0.0; schema.channels.len()];
        conditions.tool = tool;
        let coefficients = fitted.coefficients();
        {
            let posture = arm.posture.update(chain, &conditions);
            for &k in &still {
                arm.bound.emit_effect(k, &posture, &mut arm.emission);
            }
            for entry in arm.emission.entries() {
                arm.constant[chain.site_index(entry.site)] += entry.value * coefficients[entry.column];
            }
        }
        // Which frames move: those of which the moving effects speak at a few postures, under load.
        for round in 0..4_u32 {
            for (k, q) in conditions.joints.iter_mut().enumerate() {
                *q = 0.1 + 0.37 * f64::from(round) - 0.21 * k as f64;
            }
            let side = if round % 2 == 0 { 1.0 } else { -1.0 };
            conditions.approach.iter_mut().for_each(|a| *a = side);
            conditions.channels.iter_mut().for_each(|c| *c = 20.0 + side);
            conditions.time = 1e4 * f64::from(round);
            arm.emit(&conditions);
            for entry in arm.emission.entries() {
                if let Site::Frame(..) = entry.site
                    && coefficients[entry.column] != 0.0
                {
                    arm.moves[chain.site_index(entry.site)] = true;
                }
            }
        }
        arm.errors.copy_from_slice(&arm.constant);
        arm.lean = Arm::to_tool(chain, tool, &arm.constant, &arm.moves);
        Ok(arm)
    }

    /// Moves to these conditions.
    pub fn reach(&mut self, conditions: &Conditions, out: &mut Reached) {
        let chain = self.fitted.chain();
        let mut own = [(0.0, 1.0); MOST];
        let mut turns: &[(f64, f64)] = &[];
        if self.moving.is_empty() || self.rest.is_some() {
            own.iter_mut().zip(&conditions.joints).for_each(|(turn, &q)| *turn = sin_cos(q));
            turns = &own;
        }
        if self.moving.is_empty() {
            self.lean.reach(&conditions.joints, turns, &self.constant, out);
            return;
        }
        let coefficients = self.fitted.coefficients();
        self.errors.copy_from_slice(&self.constant);
        let entries = match &mut self.rest {
            Some(rest) => {
                rest.settle_errors(&self.bound, conditions, coefficients);
                rest.changing()
            }
            None => {
                let posture = self.posture.update(chain, conditions);
                self.emission.clear();
                for &k in &self.moving {
                    self.bound.emit_effect(k, &posture, &mut self.emission);
                }
                turns = posture.turns();
                self.emission.entries()
            }
        };
        let mut surprised = false;
        for entry in entries {
            let coefficient = coefficients[entry.column];
            if coefficient == 0.0 {
                continue;
            }
            let site = chain.site_index(entry.site);
            // Beyond the frames stand the targets, which are no factor of the arm.
            surprised |= self.moves.get(site) == Some(&false);
            self.errors[site] += entry.value * coefficient;
        }
        let arm = if surprised { &self.full } else { &self.lean };
        arm.reach(&conditions.joints, turns, &self.errors, out);
    }

    /// The constant generalized errors, in the order of `Chain::site_index`.
    pub fn constant(&self) -> &[f64] {
        &self.constant
    }

    /// The same as [`RealArm::point`] where no effect that moves speaks of targets, m.
    pub fn still_point(&self, target: Option<TargetId>) -> Vector3<f64> {
        self.place_of(target, &self.constant)
    }

    /// The real place of a target in the tool's axes at the conditions reached last, m.
    pub fn point(&self, target: Option<TargetId>) -> Vector3<f64> {
        self.place_of(target, &self.errors)
    }

    fn place_of(&self, target: Option<TargetId>, errors: &[f64]) -> Vector3<f64> {
        let chain = self.fitted.chain();
        target.map_or(Vector3::zeros(), |t| {
            let at = 6 * chain.frames().len() + 3 * t.0;
            chain.targets()[t.0].position + Vector3::new(errors[at], errors[at + 1], errors[at + 2])
        })
    }

    fn emit(&mut self, conditions: &Conditions) {
        let posture = self.posture.update(self.fitted.chain(), conditions);
        self.emission.clear();
        for &k in &self.moving {
            self.bound.emit_effect(k, &posture, &mut self.emission);
        }
    }
}
