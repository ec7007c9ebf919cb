//! A hypothesis that is written in Python: where the search suspects an effect of its own.

use crate::effect::{PythonEffect, interned};
use crate::robot::Robot;
use crate::run::Raised;
use pyo3::prelude::*;
use std::sync::Arc;
use truepose_discover::{Driver, Family, Hypothesis, Place, Setting, TraceView, Variant};
use truepose_errormodel::AnyEffect;

/// An object of Python with the methods of `truepose.Hypothesis`.
#[derive(Debug, Clone)]
pub struct PythonHypothesis {
    object: Arc<Py<PyAny>>,
    family: &'static str,
    raised: Raised,
}

impl PythonHypothesis {
    pub fn new(object: &Bound<'_, PyAny>, raised: Raised) -> PyResult<Self> {
        let family: String = object.getattr("family")?.extract()?;
        Ok(PythonHypothesis { object: Arc::new(object.clone().unbind()), family: interned(&family), raised })
    }

    fn made(&self, setting: &Setting<'_>) -> PyResult<Vec<Variant>> {
        Python::attach(|py| {
            let module = py.import("truepose")?;
            let robot = module.getattr("Robot")?.call_method1("_of", (Robot::bare(setting.chain),))?;
            let ranges: Vec<(String, Option<[f64; 2]>)> = setting
                .chain
                .movable()
                .iter()
                .map(|&joint| (setting.chain.joint(joint).name.clone(), setting.range(joint)))
                .collect();
            let channels: Vec<&str> =
                setting.data.schema.channels.iter().map(|channel| channel.name.as_str()).collect();
            let at = module.getattr("Setting")?.call1((robot, ranges, channels))?;
            let mut all = Vec::new();
            for item in self.object.bind(py).call_method1("variants", (at,))?.try_iter()? {
                let item = item?;
                let effect = PythonEffect::new(&item.getattr("effect")?, self.raised.clone())?;
                let place = Place {
                    joint: item.getattr("joint")?.extract()?,
                    component: item.getattr("component")?.extract()?,
                    channel: item.getattr("channel")?.extract()?,
                    ..Place::default()
                };
                effect.prepare(setting.chain, setting.data)?;
                all.push(Variant::new(place, effect));
            }
            Ok(all)
        })
    }
}

impl Hypothesis for PythonHypothesis {
    fn family(&self) -> Family {
        Family::Other(self.family)
    }

    fn variants(&self, setting: &Setting<'_>) -> Vec<Variant> {
        if self.raised.any() {
            return Vec::new();
        }
        self.made(setting).unwrap_or_else(|error| {
            self.raised.keep(error);
            Vec::new()
        })
    }

    fn meaning(&self, place: &Place) -> String {
        let said = Python::attach(|py| -> PyResult<String> {
            self.object.bind(py).call_method1("meaning", (place.part(),))?.extract()
        });
        said.unwrap_or_else(|error| {
            self.raised.keep(error);
            String::new()
        })
    }

    fn drivers(&self, place: &Place, _: &[Box<dyn AnyEffect>]) -> Vec<Driver> {
        place.joint.clone().map(Driver::Joint).into_iter().collect()
    }

    fn view(&self, place: &Place, effects: &[Box<dyn AnyEffect>]) -> TraceView {
        TraceView::of_motion(self.drivers(place, effects))
    }
}
