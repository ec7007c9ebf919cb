//! Values of frames, tools, loads and settings by their names in the program.

use crate::reference::{Carried, Reference};
use std::collections::BTreeMap;
use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::Vector3;

/// Values of frames and tools by their names in the program.
#[derive(Debug, Clone, Default)]
pub struct Definitions(pub(crate) BTreeMap<String, Definition>);

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Definition {
    Value(Pose),
    SameAs(String),
    /// Mass, kg, and centre of gravity in the flange, m.
    Load(f64, Vector3<f64>),
    /// A setting of the controller that is on or off.
    Switch(bool),
    /// Pulses of each axis that make a degree, without their signs.
    PulsesPerDegree(Vec<f64>),
    /// In the axes of a unit that moves: a positioner. Known where it is stated which one it is.
    Carried(Reference),
    /// It has a value that cannot be used, for this reason.
    Unusable(String),
    /// Its points are not compensated, whatever else is stated.
    Excluded(String),
}

/// The name of [`Definition::PulsesPerDegree`].
pub(crate) const PULSES: &str = "pulses per degree";

impl Definitions {
    pub(crate) fn put(&mut self, name: String, definition: Definition) {
        if matches!(definition, Definition::Excluded(_)) {
            self.0.insert(name, definition);
            return;
        }
        // A name with two values is neither.
        if let Some(old) = self.0.get(&name) {
            let same = *old == definition;
            if !same && !matches!(old, Definition::Excluded(_)) {
                let words = format!("{name} has more than one value in the files given");
                self.0.insert(name, Definition::Unusable(words));
            }
            return;
        }
        self.0.insert(name, definition);
    }

    /// The value of a name; none where the files do not have it.
    ///
    /// # Errors
    /// When it has one that cannot be used.
    pub fn get(&self, name: &str) -> Result<Option<Pose>, String> {
        let mut name = name;
        // Chains of names are short; a ring of them has no value.
        for _ in 0..8 {
            match self.0.get(name) {
                None
                | Some(Definition::Load(..) | Definition::Switch(_) | Definition::PulsesPerDegree(_)) => {
                    return Ok(None);
                }
                Some(Definition::Value(pose)) => return Ok(Some(*pose)),
                Some(Definition::Unusable(words) | Definition::Excluded(words)) => return Err(words.clone()),
                Some(Definition::Carried(_)) => {
                    return Err(format!(
                        "a unit that moves carries it (--work {name}=TOOL where the fit has the unit)"
                    ));
                }
                Some(Definition::SameAs(other)) => name = other,
            }
        }
        Ok(None)
    }

    /// The value of a frame in the axes of the unit that carries it.
    pub(crate) fn carried(&self, name: &str) -> Result<Option<Pose>, String> {
        match self.0.get(self.last_name(name)) {
            Some(Definition::Carried(Reference::Value(pose))) => Ok(Some(*pose)),
            Some(Definition::Carried(Reference::Named(other))) => self.get(other),
            _ => self.get(name),
        }
    }

    /// The load of a reference.
    pub(crate) fn load(&self, reference: &Reference) -> Carried {
        match reference {
            Reference::Named(name) => {
                let name = self.last_name(name);
                // `GRIP.TLOAD` is the load of GRIP.
                let shown = name.split('.').next().unwrap_or(name);
                match self.0.get(name) {
                    Some(Definition::Load(mass, com)) => {
                        Carried::Mass { name: shown.into(), mass: *mass, com: *com }
                    }
                    Some(Definition::Unusable(words)) => Carried::Open(words.clone()),
                    _ => Carried::Open(format!("the load of {shown} has no value in the files given")),
                }
            }
            Reference::Unknown(words) => Carried::Open(words.clone()),
            _ => Carried::unstated(),
        }
    }

    /// Pulses of each axis that make a degree, without their signs, by the parameters of the controller.
    pub(crate) fn pulses_per_degree(&self) -> Option<&[f64]> {
        match self.0.get(PULSES) {
            Some(Definition::PulsesPerDegree(pulses)) => Some(pulses),
            _ => None,
        }
    }

    /// Whether a setting of the controller is on; none where the files do not have it.
    pub(crate) fn switch(&self, name: &str) -> Option<bool> {
        match self.0.get(name) {
            Some(Definition::Switch(on)) => Some(*on),
            _ => None,
        }
    }

    /// Why points with this frame or tool are not compensated, whatever else is stated.
    pub(crate) fn excluded(&self, name: &str) -> Option<&str> {
        match self.0.get(self.last_name(name)) {
            Some(Definition::Excluded(words)) => Some(words),
            _ => None,
        }
    }

    /// The last name in a chain of names.
    pub fn last_name<'a>(&'a self, name: &'a str) -> &'a str {
        let mut name = name;
        for _ in 0..8 {
            match self.0.get(name) {
                Some(Definition::SameAs(other)) => name = other,
                _ => break,
            }
        }
        name
    }
}
