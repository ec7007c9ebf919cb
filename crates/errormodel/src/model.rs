//! The effects that a robot is declared to have: Φ of `ε(s) = Φ(s) c`.

use crate::error::bounded;
use crate::{AnyEffect, Column, Dataset, Emission, MOST_UNKNOWNS, ModelError, Schema, Signal};
use std::ops::Range;
use std::sync::Arc;
use truepose_kinematics::{Chain, Conditions, Posture, Slot};

/// A robot and the effects that its model has. Immutable; coefficients live elsewhere.
#[derive(Debug, Clone)]
pub struct ErrorModel {
    chain: Arc<Chain>,
    effects: Vec<Box<dyn AnyEffect>>,
    columns: Vec<Column>,
    first: Vec<usize>,
    paces: Vec<Pace>,
}

/// When an effect has to be asked again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pace {
    /// Never: constant generalized errors and nothing else.
    Constant,
    /// At every configuration.
    Moving,
    /// Wherever the robot comes to rest as well.
    Settling,
}

impl ErrorModel {
    /// A model of these effects.
    ///
    /// # Errors
    /// When an effect's parameters do not fit the robot.
    pub fn new(chain: impl Into<Arc<Chain>>, effects: Vec<Box<dyn AnyEffect>>) -> Result<Self, ModelError> {
        let chain = chain.into();
        let mut columns = Vec::new();
        let mut first = vec![0];
        let mut unknowns = 0;
        for effect in &effects {
            effect.validate(&chain)?;
            let own = effect.columns(&chain);
            unknowns += own.len();
            // Beyond the bound they are counted and not kept.
            if unknowns <= MOST_UNKNOWNS {
                columns.extend(own);
                first.push(columns.len());
            }
        }
        bounded(|| "the model".into(), unknowns)?;
        let pace = |k: usize| match columns[first[k]..first[k + 1]].iter().all(|c| c.site.is_some()) {
            true => Pace::Constant,
            false if effects[k].load_dependent() => Pace::Settling,
            false => Pace::Moving,
        };
        let paces = (0..effects.len()).map(pace).collect();
        Ok(ErrorModel { chain, effects, columns, first, paces })
    }

    /// The same model with one more effect.
    ///
    /// # Errors
    /// When the effect's parameters do not fit the robot.
    pub fn with(&self, effect: Box<dyn AnyEffect>) -> Result<Self, ModelError> {
        let mut effects = self.effects.clone();
        effects.push(effect);
        ErrorModel::new(Arc::clone(&self.chain), effects)
    }

    /// The same effects on another description of the robot (a placement that was found).
    ///
    /// # Errors
    /// When an effect does not fit it.
    pub fn on(&self, chain: impl Into<Arc<Chain>>) -> Result<Self, ModelError> {
        ErrorModel::new(chain, self.effects.clone())
    }

    /// The robot.
    pub fn chain(&self) -> &Chain {
        &self.chain
    }

    /// The robot, to be shared with another model.
    pub fn shared_chain(&self) -> Arc<Chain> {
        Arc::clone(&self.chain)
    }

    /// The effects, in order.
    pub fn effects(&self) -> &[Box<dyn AnyEffect>] {
        &self.effects
    }

    /// All unknowns, effect by effect.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The columns of the k-th effect.
    pub fn columns_of(&self, effect: usize) -> Range<usize> {
        self.first[effect]..self.first[effect + 1]
    }

    /// The first effect that is an E, whatever its scale and bounds, and its place among the effects.
    pub fn find<E: 'static>(&self) -> Option<(usize, &E)> {
        self.effects.iter().enumerate().find_map(|(k, effect)| Some((k, effect.concrete::<E>()?)))
    }

    /// The effect to which a column belongs.
    pub fn effect_of(&self, column: usize) -> usize {
        self.first.partition_point(|&first| first <= column) - 1
    }

    /// True where an effect is constant generalized errors and nothing else: it says the same at every posture.
    pub fn is_constant(&self, effect: usize) -> bool {
        self.paces[effect] == Pace::Constant
    }

    pub(crate) fn pace(&self, effect: usize) -> Pace {
        self.paces[effect]
    }

    /// Resolves every signal that the effects need, once, so that evaluation cannot fail.
    ///
    /// # Errors
    /// [`ModelError::MissingSignal`] when the data lacks one.
    pub fn bind(&self, schema: &Schema) -> Result<BoundModel<'_>, ModelError> {
        let mut slots = Vec::new();
        let mut first = vec![0];
        for effect in &self.effects {
            for need in effect.needs() {
                slots.push(self.resolve(effect.kind(), &need, schema)?);
            }
            first.push(slots.len());
        }
        Ok(BoundModel { model: self, slots, first })
    }

    fn resolve(&self, kind: &str, need: &Signal, schema: &Schema) -> Result<Slot, ModelError> {
        let slot = match need {
            Signal::Time => schema.time.then_some(Slot::Time),
            Signal::Approach(joint) => {
                self.chain.coordinate(*joint).filter(|_| schema.approach).map(Slot::Approach)
            }
            Signal::Channel(name) => schema.channel(name).map(Slot::Channel),
        };
        slot.ok_or_else(|| ModelError::MissingSignal {
            kind: kind.into(),
            signal: need.describe(&self.chain),
            have: schema.channels.iter().map(|channel| channel.name.clone()).collect(),
        })
    }
}

/// A model whose signals have been found in the data.
#[derive(Debug, Clone)]
pub struct BoundModel<'m> {
    model: &'m ErrorModel,
    slots: Vec<Slot>,
    first: Vec<usize>,
}

impl<'m> BoundModel<'m> {
    /// The model.
    pub fn model(&self) -> &'m ErrorModel {
        self.model
    }

    /// Where the signals stand that the effects need, effect after effect.
    pub(crate) fn slots(&self) -> &[Slot] {
        &self.slots
    }

    /// Those of the k-th effect.
    pub(crate) fn slots_of(&self, effect: usize) -> Range<usize> {
        self.first[effect]..self.first[effect + 1]
    }

    /// True when Φ is the same in both rows: joints, load and every signal that an effect reads, to the last bit.
    pub fn same_conditions(&self, data: &Dataset, a: usize, b: usize) -> bool {
        let alike = |column: &[f64]| column[a].to_bits() == column[b].to_bits();
        data.same_inputs(a, b)
            && self.slots.iter().all(|slot| match *slot {
                Slot::Time => alike(&data.time),
                Slot::Approach(k) => alike(&data.approach[k]),
                Slot::Channel(k) => alike(&data.channels[k]),
            })
    }

    /// The same of conditions, whose loads are compared elsewhere.
    pub(crate) fn reads_same(&self, a: &Conditions, b: &Conditions) -> bool {
        let alike = |a: f64, b: f64| a.to_bits() == b.to_bits();
        a.tool == b.tool
            && a.joints.len() == b.joints.len()
            && a.joints.iter().zip(&b.joints).all(|(a, b)| alike(*a, *b))
            && self.slots.iter().all(|slot| match *slot {
                Slot::Time => alike(a.time, b.time),
                Slot::Approach(k) => alike(a.approach[k], b.approach[k]),
                Slot::Channel(k) => alike(a.channels[k], b.channels[k]),
            })
    }

    /// Φ at a posture: replaces what `out` holds.
    pub fn emit(&self, at: &Posture<'_>, out: &mut Emission) {
        out.clear();
        for k in 0..self.model.effects.len() {
            self.emit_effect(k, at, out);
        }
    }

    /// What the effects say that do, or do not, depend on what the robot carries: adds to what `out` holds.
    pub fn emit_those(&self, settle: bool, at: &Posture<'_>, out: &mut Emission) {
        for k in 0..self.model.effects.len() {
            if (self.model.paces[k] == Pace::Settling) == settle {
                self.emit_effect(k, at, out);
            }
        }
    }

    /// What the effects of one pace say: adds to what `out` holds.
    pub(crate) fn emit_paced(&self, pace: Pace, at: &Posture<'_>, out: &mut Emission) {
        for k in 0..self.model.effects.len() {
            if self.model.paces[k] == pace {
                self.emit_effect(k, at, out);
            }
        }
    }

    /// What the k-th effect alone says at a posture: adds to what `out` holds.
    pub fn emit_effect(&self, k: usize, at: &Posture<'_>, out: &mut Emission) {
        out.start_at(self.model.first[k]);
        let slots = &self.slots[self.first[k]..self.first[k + 1]];
        self.model.effects[k].eval(&at.with_slots(slots), out);
    }
}
