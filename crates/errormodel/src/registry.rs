//! From the word in a file to the effect that it names.

use crate::effects::{
    Backlash, BaseCompliance, Coupling, Drift, Expansion, Geometric, Guideway, Instrument, JointCompliance,
    Landmarks, LinkCompliance, LoadNonlinearity, Observed, Polynomial, Session, Shift, Thermal, Transmission,
};
use crate::{AnyEffect, Effect, ModelError};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::Arc;
use truepose_kinematics::Chain;

/// Makes an effect of its parameters, or says what is wrong with them.
type Build = dyn Fn(Value) -> Result<Box<dyn AnyEffect>, String> + Send + Sync;

/// The effects that a program knows: ours, and those that a stranger adds.
#[derive(Clone)]
pub struct EffectRegistry {
    kinds: BTreeMap<&'static str, (Arc<Build>, &'static str)>,
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
            .with::<Observed>()
            .with::<Session>()
            .with::<Shift>()
            .with::<Instrument>()
            .with::<Expansion>()
            .with::<Polynomial>()
    }

    /// With one more kind; one of the same tag is replaced.
    pub fn with<E: Effect>(mut self) -> Self {
        let build = |value| match serde_json::from_value::<E>(value) {
            Ok(effect) => Ok(Box::new(effect) as Box<dyn AnyEffect>),
            Err(error) => Err(error.to_string()),
        };
        self.kinds.insert(E::FAMILY, (Arc::new(build), E::ABOUT));
        self
    }

    /// With one more kind that is no type of its own: an effect of another language, say. `build` makes it of its parameters, or says what
    /// is wrong with them.
    #[must_use]
    pub fn with_builder(
        mut self,
        kind: &'static str,
        about: &'static str,
        build: impl Fn(Value) -> Result<Box<dyn AnyEffect>, String> + Send + Sync + 'static,
    ) -> Self {
        self.kinds.insert(kind, (Arc::new(build), about));
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
        let effect =
            build(parameters).map_err(|reason| ModelError::Parameters { kind: kind.into(), reason })?;
        effect.validate(chain)?;
        Ok(effect)
    }
}

impl fmt::Debug for EffectRegistry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_set().entries(self.kinds.keys()).finish()
    }
}

impl Default for EffectRegistry {
    fn default() -> Self {
        EffectRegistry::builtin()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn a_kind_without_a_type_is_built_from_its_parameters() {
        let registry = EffectRegistry::builtin().with_builder("acme/bent", "bent", |value| {
            match value.get("times").and_then(Value::as_u64) {
                Some(1) => Ok(Box::new(Geometric::default())),
                _ => Err("`times` has to be 1".into()),
            }
        });
        let chain = samples::pps();
        let built = |times: u64| registry.build("acme/bent", serde_json::json!({"times": times}), &chain);
        assert_eq!(built(1).unwrap().kind(), "geometric");
        assert!(built(2).unwrap_err().to_string().contains("`times` has to be 1"));
        assert!(registry.kinds().any(|known| known == ("acme/bent", "bent")));
    }
}
