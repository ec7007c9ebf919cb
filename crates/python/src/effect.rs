//! An effect that is written in Python: it gives Φ for a batch of postures.
//!
//! What it reads (joint values, signals, loads) is all that it may depend on, so that its answers are kept: while nothing that it reads changes,
//! it is asked once. A data set is evaluated in one call before a fit begins; what is not known by then is asked block by block.

use crate::arrays::Given2;
use crate::error::{at_row, input};
use crate::postures::Layout;
use crate::robot::Robot;
use crate::run::Raised;
use pyo3::prelude::*;
use serde_json::Value;
use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, RwLock};
use truepose_errormodel::lanes::{LaneEmission, LanePosture};
use truepose_errormodel::{AnyEffect, Column, Dataset, Emission, ModelError, NonlinearParameter, Signal};
use truepose_kinematics::{Axis, Chain, Conditions, JointId, Posture, PostureBuffer, Site};

/// Numbers that are kept at most, in all answers of an effect.
const KEPT: usize = 1 << 23;

/// Where a column of Φ acts.
#[derive(Debug, Clone, PartialEq)]
enum Act {
    /// The joint's own motion.
    Along(JointId),
    At(Site),
}

/// What an effect is on a robot.
#[derive(Debug, Clone)]
struct OnRobot {
    columns: Vec<Column>,
    acts: Vec<Act>,
    layout: Layout,
    signals: Vec<Signal>,
}

/// Rows of Φ by the bits of the inputs.
type Known = HashMap<Vec<u64>, Arc<[f64]>>;

/// An object of Python with the methods of `truepose.Effect`.
#[derive(Debug, Clone)]
pub struct PythonEffect {
    object: Arc<Py<PyAny>>,
    kind: &'static str,
    parameters: Value,
    loads: bool,
    needs: Vec<String>,
    bound: Arc<OnceLock<OnRobot>>,
    known: Arc<RwLock<Known>>,
    raised: Raised,
}

/// A word for ever; each is stored once.
pub fn interned(word: &str) -> &'static str {
    static WORDS: Mutex<Vec<&'static str>> = Mutex::new(Vec::new());
    let mut words = WORDS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = words.iter().find(|known| **known == word) {
        return known;
    }
    let kept: &'static str = Box::leak(word.to_owned().into_boxed_str());
    words.push(kept);
    kept
}

impl PythonEffect {
    /// Of an object, which is asked for its family, its parameters and what it reads.
    pub fn new(object: &Bound<'_, PyAny>, raised: Raised) -> PyResult<Self> {
        let family: String = object.getattr("family")?.extract()?;
        if !family.contains('/') || family.chars().any(|c| c.is_whitespace() || c.is_control()) {
            return Err(input(format!(
                "the family of an effect of your own needs a prefix and no blanks, as in `acme/belt`; this one is called `{family}`"
            )));
        }
        let parameters = object.call_method0("parameters")?;
        let json = object.py().import("json")?.call_method1("dumps", (parameters,)).map_err(|error| {
            input(format!("effect `{family}`: its parameters cannot be written as JSON: {error}"))
        })?;
        let parameters = serde_json::from_str(&json.extract::<String>()?).map_err(input)?;
        Ok(PythonEffect {
            object: Arc::new(object.clone().unbind()),
            kind: interned(&family),
            parameters,
            loads: object.getattr("loads")?.extract()?,
            needs: object.getattr("needs")?.extract()?,
            bound: Arc::default(),
            known: Arc::default(),
            raised,
        })
    }

    /// The object.
    pub fn object(&self) -> &Py<PyAny> {
        &self.object
    }

    fn bind(&self, chain: &Chain) -> PyResult<&OnRobot> {
        if let Some(bound) = self.bound.get() {
            return Ok(bound);
        }
        let made = Python::attach(|py| self.bound_to(py, chain))?;
        Ok(self.bound.get_or_init(|| made))
    }

    fn bound_to(&self, py: Python<'_>, chain: &Chain) -> PyResult<OnRobot> {
        let joint = |name: &str| {
            chain.joint_named(name).ok_or_else(|| {
                let known: Vec<&str> = chain.joints().iter().map(|joint| joint.name.as_str()).collect();
                input(format!(
                    "effect `{}`: the robot has no joint `{name}` (known: {})",
                    self.kind,
                    known.join(", ")
                ))
            })
        };
        let mut signals = Vec::new();
        for need in &self.needs {
            signals.push(match need.strip_prefix("approach_") {
                Some(name) => Signal::Approach(joint(name)?),
                None if need == "time" => Signal::Time,
                None => Signal::Channel(need.clone()),
            });
        }
        let names = chain.movable().iter().map(|&joint| chain.joint(joint).name.clone()).collect();
        let layout = Layout { joints: names, signals: self.needs.clone(), loads: self.loads };
        let module = py.import("truepose")?;
        let robot = module.getattr("Robot")?.call_method1("_of", (Robot::bare(chain),))?;
        let (mut columns, mut acts) = (Vec::new(), Vec::new());
        for item in self.object.bind(py).call_method1("columns", (robot,))?.try_iter()? {
            let item = item?;
            let text = |key: &str| item.getattr(key)?.extract::<Option<String>>();
            let name: String = item.getattr("name")?.extract()?;
            let wrong = |words: String| input(format!("effect `{}`, column `{name}`: {words}", self.kind));
            let size: f64 = item.getattr("size")?.extract()?;
            if !(size.is_finite() && size > 0.0) {
                return Err(wrong("its size has to be a number above 0".into()));
            }
            let axis = || -> PyResult<Axis> {
                let word = text("component")?
                    .ok_or_else(|| wrong("it needs a component, one of x y z rx ry rz".into()))?;
                Axis::from_word(&word)
                    .ok_or_else(|| wrong(format!("`{word}` is no component (x y z rx ry rz)")))
            };
            acts.push(match (text("along")?, text("frame")?, text("target")?) {
                (Some(name), None, None) => {
                    let joint = joint(&name)?;
                    if chain.joint_motion(joint).is_none() {
                        return Err(wrong(format!("joint `{name}` does not move")));
                    }
                    Act::Along(joint)
                }
                (None, Some(name), None) => {
                    let frame = chain
                        .frame_named(&name)
                        .ok_or_else(|| wrong(format!("the robot has no frame `{name}`")))?;
                    Act::At(Site::Frame(frame, axis()?))
                }
                (None, None, Some(name)) => {
                    let target = chain
                        .target_named(&name)
                        .ok_or_else(|| wrong(format!("the robot has no target `{name}`")))?;
                    let axis = axis()?;
                    if axis.is_rotation() {
                        return Err(wrong("a target has the components x y z".into()));
                    }
                    Act::At(Site::Target(target, axis))
                }
                _ => return Err(wrong("name one of along (a joint), frame or target".into())),
            });
            let unit: String = item.getattr("unit")?.extract()?;
            columns.push(Column::new(name, unit, size));
        }
        if columns.is_empty() {
            return Err(input(format!("effect `{}` has no columns", self.kind)));
        }
        Ok(OnRobot { columns, acts, layout, signals })
    }

    /// Asks Python about rows of inputs; the answers, columns of each row after another.
    fn ask(&self, bound: &OnRobot, rows: &[f64]) -> PyResult<Vec<f64>> {
        let width = bound.layout.width();
        let (count, columns) = (rows.len() / width.max(1), bound.columns.len());
        Python::attach(|py| {
            let at = py
                .import("truepose")?
                .getattr("Postures")?
                .call((), Some(&bound.layout.arrays(py, rows)?))?;
            let answer = self.object.bind(py).call_method1("evaluate", (at,))?;
            let wrong = |words: String| input(format!("effect `{}`: {words}", self.kind));
            let numpy = py.import("numpy")?;
            let answer = numpy.call_method1("asarray", (&answer, "float64")).map_err(|error| {
                wrong(format!("`evaluate` has to return an array of numbers, {count} × {columns}: {error}"))
            })?;
            let Ok(values) = answer.extract::<Given2<'_, f64>>() else {
                let shape: String = answer.getattr("shape")?.str()?.extract()?;
                return Err(wrong(format!(
                    "`evaluate` has to return {count} × {columns} numbers and returned the shape {shape}"
                )));
            };
            let values = values.as_array();
            if values.dim() != (count, columns) {
                let (a, b) = values.dim();
                return Err(wrong(format!(
                    "`evaluate` has to return {count} × {columns} numbers and returned {a} × {b}"
                )));
            }
            if let Some(((row, column), _)) = values.indexed_iter().find(|(_, value)| !value.is_finite()) {
                let name = format!("{} of effect `{}`", bound.columns[column].name, self.kind);
                return Err(at_row(row as u64 + 1, &name, "`evaluate` returned a number that is not finite"));
            }
            Ok(values.iter().copied().collect())
        })
    }

    /// Φ of rows of inputs, from what is known or by asking; zeros once Python code has raised something.
    fn answers(&self, bound: &OnRobot, rows: &[f64]) -> Vec<Arc<[f64]>> {
        let width = bound.layout.width().max(1);
        let key = |row: &[f64]| -> Vec<u64> { row.iter().map(|v| v.to_bits()).collect() };
        let keys: Vec<Vec<u64>> = rows.chunks(width).map(key).collect();
        let mut found: Vec<Option<Arc<[f64]>>> = {
            let known = self.known.read().unwrap_or_else(PoisonError::into_inner);
            keys.iter().map(|key| known.get(key).cloned()).collect()
        };
        let missing: Vec<usize> = (0..keys.len()).filter(|&k| found[k].is_none()).collect();
        let columns = bound.columns.len();
        let zeros: Arc<[f64]> = vec![0.0; columns].into();
        if !missing.is_empty() && !self.raised.any() {
            let asked: Vec<f64> =
                missing.iter().flat_map(|&k| &rows[k * width..][..width]).copied().collect();
            match self.ask(bound, &asked) {
                Ok(values) => {
                    let mut known = self.known.write().unwrap_or_else(PoisonError::into_inner);
                    if (known.len() + missing.len()) * (columns + width) > KEPT {
                        known.clear();
                    }
                    for (&k, answer) in missing.iter().zip(values.chunks(columns)) {
                        let answer: Arc<[f64]> = answer.into();
                        known.insert(keys[k].clone(), answer.clone());
                        found[k] = Some(answer);
                    }
                }
                Err(error) => self.raised.keep(error),
            }
        }
        found.into_iter().map(|answer| answer.unwrap_or_else(|| zeros.clone())).collect()
    }

    /// Evaluates a data set in one call, so that errors come before the work begins.
    ///
    /// # Errors
    /// Those of its Python code, and what is wrong with its answers.
    pub fn prepare(&self, chain: &Chain, data: &Dataset) -> PyResult<()> {
        let bound = self.bind(chain)?;
        let column = |signal: &Signal| match signal {
            Signal::Time => data.schema.time.then_some(&data.time),
            Signal::Approach(joint) => chain.coordinate(*joint).map(|k| &data.approach[k]),
            Signal::Channel(name) => data.schema.channel(name).map(|k| &data.channels[k]),
        };
        // What is missing, the model says when it is bound.
        let Some(signals) = bound.signals.iter().map(column).collect::<Option<Vec<_>>>() else {
            return Ok(());
        };
        let mut buffer = PostureBuffer::new(chain);
        let mut conditions = Conditions::default();
        let mut rows = Vec::with_capacity(data.len() * bound.layout.width());
        for row in 0..data.len() {
            rows.extend(data.joints.iter().map(|column| column[row]));
            rows.extend(signals.iter().map(|column| column[row]));
            if self.loads {
                data.conditions_into(row, &mut conditions);
                let posture = buffer.update(chain, &conditions);
                rows.extend(chain.movable().iter().map(|&joint| posture.joint_load(joint)));
            }
        }
        if bound.layout.width() > 0 && !rows.is_empty() {
            self.answers(bound, &rows);
        }
        self.raised.take().map_or(Ok(()), Err)
    }
}

impl AnyEffect for PythonEffect {
    fn kind(&self) -> &'static str {
        self.kind
    }

    fn columns(&self, chain: &Chain) -> Vec<Column> {
        self.bind(chain).map_or_else(|_| Vec::new(), |bound| bound.columns.clone())
    }

    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        let Ok(bound) = self.bind(at.chain()) else { return };
        let chain = at.chain();
        let mut row: Vec<f64> = chain.movable().iter().map(|&joint| at.joint(joint)).collect();
        row.extend((0..bound.signals.len()).map(|k| at.signal(k)));
        if self.loads {
            row.extend(chain.movable().iter().map(|&joint| at.joint_load(joint)));
        }
        let answer = &self.answers(bound, &row)[0];
        for (column, (act, &value)) in bound.acts.iter().zip(answer.iter()).enumerate() {
            match act {
                Act::At(site) => out.push(column, *site, value),
                Act::Along(joint) => {
                    if let Some(motion) = chain.joint_motion(*joint) {
                        out.along(column, &motion, value);
                    }
                }
            }
        }
    }

    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        let Ok(bound) = self.bind(at.chain()) else { return false };
        let chain = at.chain();
        let mut rows = Vec::with_capacity(at.rows() * bound.layout.width());
        for lane in 0..at.rows() {
            rows.extend(
                chain.movable().iter().map(|&joint| at.joint(joint).map_or(0.0, |values| values[lane])),
            );
            rows.extend((0..bound.signals.len()).map(|k| at.signal(k)[lane]));
            if self.loads {
                rows.extend(chain.movable().iter().map(|&joint| at.joint_load(joint)[lane]));
            }
        }
        let answers = self.answers(bound, &rows);
        for (column, act) in bound.acts.iter().enumerate() {
            let value = out.value(|into| {
                into.iter_mut().zip(&answers).for_each(|(into, answer)| *into = answer[column]);
            });
            match act {
                Act::At(site) => out.push(column, *site, value),
                Act::Along(joint) => {
                    if let Some(motion) = chain.joint_motion(*joint) {
                        out.along(column, &motion, value);
                    }
                }
            }
        }
        true
    }

    fn needs(&self) -> Vec<Signal> {
        self.bound.get().map_or_else(Vec::new, |bound| bound.signals.clone())
    }

    fn load_dependent(&self) -> bool {
        self.loads
    }

    fn compliances(&self, _: &Chain) -> Option<Vec<JointId>> {
        None
    }

    fn without_time(&self) -> Option<Box<dyn AnyEffect>> {
        None
    }
    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        match self.bind(chain) {
            Ok(_) => Ok(()),
            Err(error) => {
                let reason = error.to_string();
                self.raised.keep(error);
                Err(ModelError::Parameters { kind: self.kind.into(), reason })
            }
        }
    }

    fn shape(&self) -> Vec<NonlinearParameter> {
        Vec::new()
    }

    fn with_nonlinear(&self, _: &[f64]) -> Box<dyn AnyEffect> {
        self.boxed()
    }

    fn parameters(&self) -> Value {
        self.parameters.clone()
    }

    fn boxed(&self) -> Box<dyn AnyEffect> {
        Box::new(self.clone())
    }
}
