//! Many rows at once: J_e, Φ and y(c) of a block of [`LANES`] rows, number by number.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | s | [`Lanes::gather`]: conditions, measurements | `LANES` each | SI |
//! | ε = Φ c | `errors` | sites × `LANES` | m, rad |
//! | J_e | rows of `store`, position and rotation of each site | 6 × sites × `LANES` | m or rad per m or rad |
//! | P J_e Φ | [`Lanes::columns`], component by component | columns × `LANES` | m or rad per unit |
//!
//! The same mathematics as [`crate::Rest`] and [`crate::ErrorJacobian`], which do one row after the other and against which a test holds
//! this. Effects that speak of a block at once ([`crate::Effect::eval_lanes`]) are asked so; a model in which one does not, or
//! whose gravity turns with a base that yields, is brought to rest row by row, and only the rest of the arithmetic is wide.
//! What is zero in a whole block is known and left out: slides do not turn, a joint that stands at zero has no powers.

mod columns;
mod emission;
mod errors;
mod jacobian;
mod loads;
mod posture;
mod store;
mod walk;

pub use columns::Component;
pub use emission::{LaneEmission, LaneValue};
pub use jacobian::error_jacobians;
pub use posture::LanePosture;

use crate::model::Pace;
use crate::{BoundModel, Dataset, Rest};
use errors::LaneErrors;
use loads::LaneLoad;
use nalgebra::Vector3;
use store::Store;
use truepose_kinematics::pulp::Arch;
use truepose_kinematics::{Conditions, GravityFrame};

/// How many rows a block has at most.
pub const LANES: usize = 128;

/// How often the weights follow the deflections, as in [`crate::Rest`].
const STEPS: usize = 2;

/// A block of rows.
#[derive(Debug, Clone)]
pub struct Lanes<'m> {
    bound: BoundModel<'m>,
    rows: Vec<usize>,
    conditions: Conditions,
    joints: Vec<f64>,
    signals: Vec<f64>,
    load: LaneLoad,
    store: Store,
    emission: LaneEmission,
    errors: LaneErrors,
    /// ε of a change of the coefficients.
    change: LaneErrors,
    /// Effects speak of blocks.
    wide: bool,
    /// Row by row, where they do not.
    rest: Rest,
    settles: bool,
    fill: columns::Fill,
}

impl<'m> Lanes<'m> {
    /// Memory for this model.
    pub fn new(bound: BoundModel<'m>) -> Self {
        let model = bound.model();
        let chain = model.chain();
        let mut lanes = Lanes {
            rows: Vec::with_capacity(LANES),
            conditions: Conditions::default(),
            joints: vec![0.0; chain.movable().len() * LANES],
            signals: vec![0.0; bound.slots().len() * LANES],
            load: LaneLoad::default(),
            store: Store::new(chain),
            emission: LaneEmission::new(),
            errors: LaneErrors::new(chain),
            change: LaneErrors::new(chain),
            wide: false,
            rest: Rest::new(model),
            settles: model.effects().iter().any(|effect| effect.settles()),
            fill: columns::Fill::default(),
            bound,
        };
        lanes.wide = lanes.speaks_wide();
        lanes
    }

    /// On these registers, instead of the widest that the processor has: the same numbers but for their last digits.
    pub fn on(mut self, arch: Arch) -> Self {
        (self.store.arch, self.errors.arch, self.change.arch) = (arch, arch, arch);
        self
    }

    /// The model.
    pub fn bound(&self) -> &BoundModel<'m> {
        &self.bound
    }

    /// Whether all effects speak of blocks: otherwise a block is no faster than its rows.
    pub fn speaks_of_blocks(&self) -> bool {
        self.wide
    }

    /// The rows of the block, as they were gathered.
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Asks every effect once whether it speaks of blocks.
    fn speaks_wide(&mut self) -> bool {
        let posture = LanePosture {
            chain: self.bound.model().chain(),
            joints: &self.joints,
            signals: &[],
            load: &self.load,
            store: &self.store,
        };
        let effects = self.bound.model().effects();
        let all = (0..effects.len()).all(|k| {
            let signals = &self.signals[self.bound.slots_of(k).start * LANES..];
            effects[k].eval_lanes(&LanePosture { signals, ..posture }, &mut self.emission)
        });
        self.emission.clear();
        all
    }

    /// Takes the inputs and measurements of some rows, [`LANES`] at most.
    pub fn gather(&mut self, data: &Dataset, rows: &[usize]) {
        let rows = &rows[..rows.len().min(LANES)];
        self.rows.clear();
        self.rows.extend_from_slice(rows);
        let put = |to: &mut [f64], from: &[f64]| {
            to.iter_mut().zip(rows).for_each(|(to, &row)| *to = from[row]);
            to[rows.len()..LANES].fill(0.0);
        };
        for (to, from) in self.joints.chunks_exact_mut(LANES).zip(&data.joints) {
            put(to, from);
        }
        for (to, slot) in self.signals.chunks_exact_mut(LANES).zip(self.bound.slots()) {
            put(to, data.slot(*slot));
        }
        self.load.gather(data, rows);
        self.store.aim(self.bound.model().chain(), data, rows);
    }

    /// Brings the block to rest with these coefficients (one a column of the model): Φ, ε and the frames.
    pub fn settle(&mut self, data: &Dataset, coefficients: &[f64]) {
        let moves = coefficients.iter().any(|&c| c != 0.0);
        if !self.wide || (moves && self.turns_with_base()) {
            self.row_by_row(data, coefficients);
            return;
        }
        let chain = self.bound.model().chain();
        let gravity = chain.gravity_in_measurement_frame();
        self.emission.clear();
        self.errors.clear();
        self.store.turn(chain, &self.joints);
        if self.settles {
            // The nominal posture, with its weights.
            self.walk(&gravity);
        }
        self.emit(|pace| pace != Pace::Settling);
        let still = self.emission.mark();
        if moves {
            self.errors.add(&self.emission, 0, coefficients);
        }
        self.emit(|pace| pace == Pace::Settling);
        if self.emission.mark() == still || !moves {
            if moves || !self.settles {
                self.walk(&gravity);
            }
            return;
        }
        let stiff = self.errors.clone();
        self.errors.add(&self.emission, still, coefficients);
        for _ in 0..STEPS {
            self.walk(&gravity);
            self.emission.truncate(still);
            self.emit(|pace| pace == Pace::Settling);
            self.errors.clone_from(&stiff);
            self.errors.add(&self.emission, still, coefficients);
        }
        self.walk(&gravity);
    }

    /// Asks effects of some paces.
    fn emit(&mut self, wanted: impl Fn(Pace) -> bool) {
        let model = self.bound.model();
        let posture = LanePosture {
            chain: model.chain(),
            joints: &self.joints,
            signals: &[],
            load: &self.load,
            store: &self.store,
        };
        for (k, effect) in model.effects().iter().enumerate().filter(|(k, _)| wanted(model.pace(*k))) {
            self.emission.start_at(model.columns_of(k).start);
            let signals = &self.signals[self.bound.slots_of(k).start * LANES..];
            effect.eval_lanes(&LanePosture { signals, ..posture }, &mut self.emission);
        }
    }

    /// Frames with the errors that there are, and weights under this gravity.
    fn walk(&mut self, gravity: &Vector3<f64>) {
        let chain = self.bound.model().chain();
        self.store.walk(chain, &self.joints, &self.errors, self.rows.len());
        if self.settles {
            self.store.weigh(chain, &self.load, gravity, self.rows.len());
        }
    }

    /// Whether gravity goes with the base, whose own error then turns it.
    fn turns_with_base(&self) -> bool {
        let model = self.bound.model();
        model.chain().gravity().frame == GravityFrame::Base && self.settles
    }

    /// As [`Lanes::settle`], one row after the other.
    fn row_by_row(&mut self, data: &Dataset, coefficients: &[f64]) {
        let chain = self.bound.model().chain();
        self.emission.clear();
        self.errors.clear();
        self.store.turn(chain, &self.joints);
        for lane in 0..self.rows.len() {
            let row = self.rows[lane];
            let alike = lane > 0 && self.bound.same_conditions(data, self.rows[lane - 1], row);
            if !alike {
                data.conditions_into(row, &mut self.conditions);
                self.rest.settle(&self.bound, &self.conditions, coefficients);
            }
            self.emission.take(lane, self.rest.emission().entries(), chain);
            self.errors.take(lane, self.rest.errors(), chain);
        }
        self.store.walk(chain, &self.joints, &self.errors, self.rows.len());
    }
}

#[cfg(test)]
mod tests;
