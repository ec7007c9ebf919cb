//! From the word in a file to the effect that it names.

use crate::effects::{
    Backlash, BaseCompliance, Coupling, Drift, Expansion, Geometric, Guideway, Instrument, JointCompliance,
    Landmarks, LinkCompliance, LoadNonlinearity, Polynomial, Session, Shift, Thermal, Transmission,
};
use crate::{AnyEffect, Effect, ModelError};
use serde_json::Value;
use std::collections::BTreeMap;
use truepose_kinematics::Chain;

type Build = fn(Value) -> Result<Box<dyn AnyEffect>, serde_json::Error>;

/// The effects that a program knows: ours, and those that a stranger adds.
#[derive(Debug, Clone)]
pub struct EffectRegistry {
    kinds: BTreeMap<&'static str, (Build, &'static str)>,
}

impl EffectRegistry {
    /// No effects at all.
    pub fn empty() -> Self {
        EffectRegistry { kinds: BTreeMap::new() }
    }

    /// The effects of this crate.
    pub fn builtin() -> Self {
        EffectRegistry::empty()
            .with::<Geometric>()
            .with::<JointCompliance>()
            .with::<LinkCompliance>()
            .with::<BaseCompliance>()
            .with::<LoadNonlinearity>()
            .with::<Transmission>()
            .with::<Backlash>()
            .with::<Coupling>()
            .with::<Guideway>()
            .with::<Thermal>()
            .with::<Drift>()
            .with::<Landmarks>()
            .with::<Session>()
            .with::<Shift>()
            .with::<Instrument>()
            .with::<Expansion>()
            .with::<Polynomial>()
    }

    /// With one more kind; one of the same tag is replaced.
    pub fn with<E: Effect>(mut self) -> Self {
        let build: Build = |value| Ok(Box::new(serde_json::from_value::<E>(value)?));
        self.kinds.insert(E::FAMILY, (build, E::ABOUT));
        self
    }

    /// The known kinds and what each is, in alphabetical order.
    pub fn kinds(&self) -> impl Iterator<Item = (&'static str, &'static str)> + '_ {
        self.kinds.iter().map(|(kind, (_, about))| (*kind, *about))
    }

    /// The effect of this kind with these parameters (a JSON object; ids are numbers), checked against the robot.
    ///
    /// # Errors
    /// An unknown kind, parameters that do not parse, or that do not fit the robot.
    pub fn build(
        &self,
        kind: &str,
        parameters: Value,
        chain: &Chain,
    ) -> Result<Box<dyn AnyEffect>, ModelError> {
        let Some((build, _)) = self.kinds.get(kind) else {
            return Err(ModelError::UnknownFamily {
                kind: kind.into(),
                known: self.kinds.keys().map(|k| (*k).to_string()).collect(),
            });
        };
        let effect = build(parameters)
            .map_err(|error| ModelError::Parameters { kind: kind.into(), reason: error.to_string() })?;
        effect.validate(chain)?;
        Ok(effect)
    }
}

impl Default for EffectRegistry {
    fn default() -> Self {
        EffectRegistry::builtin()
    }
}
