//! Many rows at once: J_e, Φ and y(c) of a block of [`LANES`] rows, number by number.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | s | [`Lanes::gather`]: conditions, measurements | `LANES` each | SI |
//! | ε = Φ c | `errors` | sites × `LANES` | m, rad |
//! | J_e | rows of `store`, position and rotation of each site | 6 × sites × `LANES` | m or rad per m or rad |
//! | P J_e Φ | [`Lanes::columns`], component by component | columns × `LANES` | m or rad per unit |
//!
//! The same mathematics as [`crate::Equilibrium`] and [`crate::ErrorJacobian`], which do one row after the other and against which a test holds
//! this. Effects that speak of a block at once ([`crate::Effect::eval_lanes`]) are asked so; others row by row, at the frames and weights of
//! the block. A model whose gravity turns with a base that yields, and a soft robot, are brought to rest row by row, and only the rest of the
//! arithmetic is wide.
//! What is zero in a whole block is known and left out: slides do not turn, a joint that stands at zero has no powers. Rows of one standstill
//! are brought to rest once.

use super::fill::Fill;
use crate::dataset::Dataset;
use crate::emission::Emission;
use crate::equilibrium::{Equilibrium, SOFT, STEPS};
use crate::lanes::{LANES, LaneEmission, LaneErrors, LaneLoad, LanePosture, Standing, Store};
use crate::model::{BoundModel, Pace};
use nalgebra::Vector3;
use std::cell::Cell;
use truepose_kinematics::pulp::Arch;
use truepose_kinematics::{Conditions, FrameId, GravityFrame, PostureBuffer, Site};

/// What one column says of one site in a block of rows: `factor` times a value a row, m or rad per unit of the coefficient.
#[derive(Debug, Clone, Copy)]
pub struct Phi<'a> {
    /// The column of the model.
    pub column: usize,
    /// The site.
    pub site: Site,
    /// The same in all rows.
    pub factor: f64,
    /// One a row.
    pub values: &'a [f64],
}

/// A block of rows.
#[derive(Debug, Clone)]
pub struct Lanes<'m> {
    pub(super) bound: BoundModel<'m>,
    pub(super) rows: Vec<usize>,
    standing: Standing,
    conditions: Conditions,
    joints: Vec<f64>,
    signals: Vec<f64>,
    load: LaneLoad,
    pub(super) store: Store,
    pub(super) emission: LaneEmission,
    pub(super) errors: LaneErrors,
    /// None at all.
    plain: LaneErrors,
    /// Of what does not settle.
    stiff: LaneErrors,
    /// ε of the step before.
    last: LaneErrors,
    /// ε of a change of the coefficients.
    pub(super) change: LaneErrors,
    /// For each effect: whether it speaks of blocks.
    wide: Vec<bool>,
    /// One row at a time, for those that do not.
    seat: PostureBuffer,
    said: Emission,
    /// Row by row, where gravity turns.
    rest: Equilibrium,
    settles: bool,
    soft: bool,
    /// Whether some effect asked for frames or weights of the last block: it is likely to ask for those of the next one.
    asks: bool,
    pub(super) fill: Fill,
}

impl<'m> Lanes<'m> {
    /// Memory for this model.
    pub fn new(bound: BoundModel<'m>) -> Self {
        let model = bound.model();
        let chain = model.chain();
        let mut lanes = Lanes {
            rows: Vec::with_capacity(LANES),
            standing: Standing::default(),
            conditions: Conditions::default(),
            joints: vec![0.0; chain.movable().len() * LANES],
            signals: vec![0.0; bound.slots().len() * LANES],
            load: LaneLoad::default(),
            store: Store::new(chain),
            emission: LaneEmission::new(),
            errors: LaneErrors::new(chain),
            plain: LaneErrors::new(chain),
            stiff: LaneErrors::new(chain),
            last: LaneErrors::new(chain),
            change: LaneErrors::new(chain),
            wide: Vec::new(),
            seat: PostureBuffer::new(chain),
            said: Emission::new(),
            rest: Equilibrium::new(model),
            settles: model.effects().iter().any(|effect| effect.load_dependent()),
            soft: false,
            asks: true,
            fill: Fill::default(),
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

    /// As one of a soft robot ([`Equilibrium::soft`]).
    #[must_use]
    pub fn soft(mut self, soft: bool) -> Self {
        self.soft = soft && self.settles;
        self.rest = self.rest.soft(self.soft);
        self
    }

    /// The model.
    pub fn bound(&self) -> &BoundModel<'m> {
        &self.bound
    }

    /// The rows of the block, as they were gathered.
    pub fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// Asks every effect once whether it speaks of blocks.
    fn speaks_wide(&mut self) -> Vec<bool> {
        let asked = Cell::new(false);
        let posture = LanePosture {
            chain: self.bound.model().chain(),
            joints: &self.joints,
            signals: &[],
            load: &self.load,
            store: &self.store,
            rows: 0,
            asked: &asked,
        };
        let effects = self.bound.model().effects();
        let ask = |k: usize| {
            let signals = &self.signals[self.bound.slots_of(k).start * LANES..];
            effects[k].eval_lanes(&LanePosture { signals, ..posture }, &mut self.emission)
        };
        let wide = (0..effects.len()).map(ask).collect();
        self.emission.clear();
        wide
    }

    /// Takes the inputs and measurements of some rows, [`LANES`] at most.
    pub fn gather(&mut self, data: &Dataset, rows: &[usize]) {
        let rows = &rows[..rows.len().min(LANES)];
        self.rows.clear();
        self.rows.extend_from_slice(rows);
        self.standing.gather(rows, |a, b| self.bound.same_conditions(data, a, b));
        let standing = &self.standing.rows;
        let put = |to: &mut [f64], from: &[f64]| {
            to.iter_mut().zip(standing).for_each(|(to, &row)| *to = from[row]);
            to[standing.len()..LANES].fill(0.0);
        };
        for (to, from) in self.joints.chunks_exact_mut(LANES).zip(&data.joints) {
            put(to, from);
        }
        for (to, slot) in self.signals.chunks_exact_mut(LANES).zip(self.bound.slots()) {
            put(to, data.slot(*slot));
        }
        self.load.gather(data, standing, self.store.branches());
        self.store.aim(self.bound.model().chain(), data, rows);
    }

    /// Brings the block to rest with these coefficients (one a column of the model): Φ, ε and the frames.
    pub fn settle(&mut self, data: &Dataset, coefficients: &[f64]) {
        self.come_to_rest(data, coefficients);
        if self.standing.shared() {
            self.store.spread(&self.standing);
            self.emission.spread(&self.standing);
            self.errors.spread(&self.standing);
        }
    }

    /// Φ of the block where the robot has come to rest, entry by entry; a column may speak of a site twice.
    pub fn phi(&self) -> impl Iterator<Item = Phi<'_>> {
        self.emission.entries.iter().map(|entry| Phi {
            column: entry.column as usize,
            site: entry.site,
            factor: entry.factor,
            values: &self.emission.numbers(entry.value)[..self.rows.len()],
        })
    }

    /// The standstills of the block, one a lane.
    fn come_to_rest(&mut self, data: &Dataset, coefficients: &[f64]) {
        let moves = coefficients.iter().any(|&c| c != 0.0);
        if moves && (self.turns_with_base() || self.soft) {
            self.row_by_row(data, coefficients);
            return;
        }
        let chain = self.bound.model().chain();
        let gravity = chain.gravity_in_measurement_frame();
        self.emission.clear();
        self.errors.clear();
        self.store.turn(chain, &self.joints);
        self.emit(data, |_, pace| pace != Pace::Settling);
        let still = self.emission.mark();
        if moves {
            self.errors.add(&self.emission, 0, coefficients);
        }
        let acts = self.acting(coefficients);
        let weighed = self.settles && self.weighed_at_nominal(data, still, &gravity, &acts);
        let yields = weighed && moves && self.emission.mark() > still;
        if !yields {
            if moves {
                self.errors.add(&self.emission, still, coefficients);
            }
            if moves || !weighed {
                self.store.walk(chain, &self.joints, &self.errors, self.standing.rows.len());
            }
            return;
        }
        self.stiff.become_as(&self.errors);
        self.errors.add(&self.emission, still, coefficients);
        for step in 1..=STEPS {
            self.walk(&gravity);
            self.emission.truncate(still);
            self.emit(data, |k, pace| pace == Pace::Settling && (acts[k] || step == STEPS));
            if step == STEPS {
                self.last.become_as(&self.errors);
            }
            self.errors.become_as(&self.stiff);
            self.errors.add(&self.emission, still, coefficients);
        }
        if self.errors.furthest(&self.last, self.standing.rows.len()) > SOFT {
            self.row_by_row(data, coefficients);
            return;
        }
        self.store.walk(chain, &self.joints, &self.errors, self.standing.rows.len());
    }

    /// For each effect: whether it moves the robot. What does not is asked where it has come to rest, and not before.
    fn acting(&self, coefficients: &[f64]) -> Vec<bool> {
        let model = self.bound.model();
        let moves = |k: usize| coefficients[model.columns_of(k)].iter().any(|&c| c != 0.0);
        (0..model.effects().len()).map(moves).collect()
    }

    /// What effects say at the nominal posture that may ask for frames and weights: those that move the robot, where these do ask, else all of
    /// them. Whether one did.
    fn weighed_at_nominal(
        &mut self,
        data: &Dataset,
        still: usize,
        gravity: &Vector3<f64>,
        acts: &[bool],
    ) -> bool {
        let some = acts.contains(&true) && acts.contains(&false);
        let acting = some && self.emit_at_nominal(data, still, gravity, &|k| acts[k]);
        (acting && self.emission.mark() > still) || self.emit_at_nominal(data, still, gravity, &|_| true)
    }

    /// What some of the effects say that may ask for frames and weights, at the nominal posture; whether one did: otherwise nothing that they say depends
    /// on where the robot comes to rest (a polynomial in a measured wrench), and the nominal frames need not be there.
    fn emit_at_nominal(
        &mut self,
        data: &Dataset,
        still: usize,
        gravity: &Vector3<f64>,
        wanted: &dyn Fn(usize) -> bool,
    ) -> bool {
        let chain = self.bound.model().chain();
        let mut ready = false;
        loop {
            if self.asks && !ready {
                self.store.walk(chain, &self.joints, &self.plain, self.standing.rows.len());
                self.store.weigh(chain, &self.load, gravity, self.standing.rows.len());
                ready = true;
            }
            self.emission.truncate(still);
            self.asks = self.emit(data, |k, pace| pace == Pace::Settling && wanted(k));
            if ready || !self.asks {
                return self.asks;
            }
        }
    }

    /// Asks some of the effects, by their number and pace; whether one of them asked for frames or weights.
    fn emit(&mut self, data: &Dataset, wanted: impl Fn(usize, Pace) -> bool) -> bool {
        let model = self.bound.model();
        let asked = Cell::new(false);
        let mut narrow = false;
        for k in (0..model.effects().len()).filter(|&k| wanted(k, model.pace(k))) {
            if !self.wide[k] {
                narrow = true;
                continue;
            }
            self.emission.start_at(model.columns_of(k).start);
            let posture = LanePosture {
                chain: model.chain(),
                joints: &self.joints,
                signals: &self.signals[self.bound.slots_of(k).start * LANES..],
                load: &self.load,
                store: &self.store,
                rows: self.standing.rows.len(),
                asked: &asked,
            };
            model.effects()[k].eval_lanes(&posture, &mut self.emission);
        }
        if narrow {
            for pace in [Pace::Constant, Pace::Moving, Pace::Settling] {
                self.emit_row_by_row(data, pace, &|k| wanted(k, pace), &asked);
            }
        }
        asked.get()
    }

    /// Asks those of some effects of a pace that do not speak of blocks, at the frames and weights of the block.
    fn emit_row_by_row(
        &mut self,
        data: &Dataset,
        pace: Pace,
        wanted: &dyn Fn(usize) -> bool,
        asked: &Cell<bool>,
    ) {
        let model = self.bound.model();
        let narrow = |&k: &usize| !self.wide[k] && model.pace(k) == pace && wanted(k);
        let those: Vec<usize> = (0..model.effects().len()).filter(narrow).collect();
        if those.is_empty() {
            return;
        }
        // What depends on no frame is asked at the nominal posture, as it is row by row.
        let settling = pace == Pace::Settling;
        asked.set(asked.get() || settling);
        self.emission.begin(model.columns().len(), model.chain());
        for (lane, &row) in self.standing.rows.iter().enumerate() {
            data.conditions_into(row, &mut self.conditions);
            let (store, seat) = (&self.store, &mut self.seat);
            let at = |f: FrameId| (store.frame(f.0, lane), store.carries(f.0, lane));
            let posture = match settling {
                true => seat.place(model.chain(), &self.conditions, at),
                false => seat.update(model.chain(), &self.conditions),
            };
            self.said.clear();
            those.iter().for_each(|&k| self.bound.emit_effect(k, &posture, &mut self.said));
            self.emission.take(lane, self.said.entries(), model.chain());
        }
    }

    /// Frames with the errors that there are, and weights under this gravity.
    fn walk(&mut self, gravity: &Vector3<f64>) {
        let chain = self.bound.model().chain();
        self.store.walk(chain, &self.joints, &self.errors, self.standing.rows.len());
        self.store.weigh(chain, &self.load, gravity, self.standing.rows.len());
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
        self.emission.begin(self.bound.model().columns().len(), chain);
        self.errors.clear();
        self.store.turn(chain, &self.joints);
        for (lane, &row) in self.standing.rows.iter().enumerate() {
            data.conditions_into(row, &mut self.conditions);
            self.rest.settle(&self.bound, &self.conditions, coefficients);
            self.emission.take(lane, self.rest.emission().entries(), chain);
            self.errors.take(lane, self.rest.errors(), chain);
        }
        self.store.walk(chain, &self.joints, &self.errors, self.standing.rows.len());
    }
}
