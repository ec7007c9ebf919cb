//! The declared model: a file, texts of `[[effects]]`, and effects of Python, in their order.

use crate::effect::{PythonEffect, interned};
use crate::error::{input, of_io};
use crate::run::Raised;
use pyo3::prelude::*;
use std::path::PathBuf;
use truepose_errormodel::effects::Geometric;
use truepose_errormodel::{AnyEffect, Dataset, EffectRegistry};
use truepose_io::{model_from_text, read_model};
use truepose_kinematics::Chain;

/// Effects, and where those of Python put what they raise.
#[derive(Default)]
pub struct Model {
    pub effects: Vec<Box<dyn AnyEffect>>,
    pub raised: Raised,
    /// Objects of Python in the model.
    pub objects: Vec<Py<PyAny>>,
}

impl Model {
    /// Of what was declared; nothing: constant errors of every frame and target.
    pub fn of(py: Python<'_>, items: Option<Vec<(String, Py<PyAny>)>>, chain: &Chain) -> PyResult<Self> {
        let mut model = Model::default();
        let Some(items) = items else {
            model.effects.push(Box::new(Geometric::default()));
            return Ok(model);
        };
        let registry = EffectRegistry::builtin();
        for (sort, item) in items {
            let item = item.bind(py);
            match sort.as_str() {
                "file" => model
                    .effects
                    .extend(read_model(item.extract::<PathBuf>()?, chain, &registry).map_err(of_io)?),
                "text" => model.effects.extend(
                    model_from_text("model", item.extract::<String>()?, chain, &registry).map_err(of_io)?,
                ),
                _ => {
                    let effect = PythonEffect::new(item, model.raised.clone())?;
                    model.objects.push(item.clone().unbind());
                    if effect.validate(chain).is_err() {
                        return Err(model
                            .raised
                            .take()
                            .unwrap_or_else(|| input("the effect does not fit the robot")));
                    }
                    model.effects.push(Box::new(effect));
                }
            }
        }
        if model.effects.is_empty() {
            return Err(input(
                "the model has no effects; leave it out for constant errors of every frame and target",
            ));
        }
        for (k, effect) in model.effects.iter().enumerate() {
            let same = |other: &dyn AnyEffect| {
                other.kind() == effect.kind() && other.parameters() == effect.parameters()
            };
            if model.effects[..k].iter().any(|other| same(other.as_ref())) {
                return Err(input(format!(
                    "effect `{}` is declared twice in the same way; remove one",
                    effect.kind()
                )));
            }
        }
        Ok(model)
    }

    /// Evaluates the effects of Python on a data set.
    pub fn prepare(&self, chain: &Chain, data: &Dataset) -> PyResult<()> {
        prepare(&self.effects, chain, data)
    }
}

/// Evaluates the effects of Python on a data set.
pub fn prepare(effects: &[Box<dyn AnyEffect>], chain: &Chain, data: &Dataset) -> PyResult<()> {
    of_python(effects).try_for_each(|effect| effect.prepare(chain, data))
}

/// The effects of Python among these.
pub fn of_python(effects: &[Box<dyn AnyEffect>]) -> impl Iterator<Item = &PythonEffect> {
    effects.iter().filter_map(|effect| effect.concrete())
}

/// Built-in effects and these classes of Python, by their families.
pub fn registry(py: Python<'_>, classes: Vec<Py<PyAny>>, raised: &Raised) -> PyResult<EffectRegistry> {
    let mut registry = EffectRegistry::builtin();
    for class in classes {
        let family: String = class.bind(py).getattr("family")?.extract()?;
        let raised = raised.clone();
        registry = registry.with_builder(
            interned(&family),
            "an effect that is written in Python",
            move |parameters| {
                let made = Python::attach(|py| -> PyResult<PythonEffect> {
                    let text = serde_json::to_string(&parameters).map_err(input)?;
                    let parameters = py.import("json")?.call_method1("loads", (text,))?;
                    let object = class.bind(py).call_method1("from_parameters", (parameters,))?;
                    PythonEffect::new(&object, raised.clone())
                });
                match made {
                    Ok(effect) => Ok(Box::new(effect)),
                    Err(error) => Err(error.to_string()),
                }
            },
        );
    }
    Ok(registry)
}

/// The families that can be declared, with a line about each.
#[pyfunction]
pub fn families() -> Vec<(&'static str, &'static str)> {
    EffectRegistry::builtin().kinds().collect()
}
