//! The seam through which effects enter: the only trait that an author of an effect implements.

use crate::emission::Emission;
use crate::error::ModelError;
use crate::lanes::{LaneEmission, LanePosture};
use crate::signal::Signal;
use serde::{Serialize, de::DeserializeOwned};
use std::any::Any;
use std::fmt::Debug;
use truepose_kinematics::{Chain, JointId, Posture, Site};

/// One unknown of an effect.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// What it is, in a reader's words: `compliance j2`.
    pub name: String,
    /// SI unit of the coefficient.
    pub unit: String,
    /// Expected size in that unit: it scales the column, and is its prior standard deviation where one is wanted.
    pub scale: f64,
    /// The site, when the column is a constant generalized error and nothing else.
    pub site: Option<Site>,
    /// Between which values physics, or the user, allows it to be; solvers that hold bounds hold these.
    pub bounds: [f64; 2],
}

/// No bounds at all.
pub const UNBOUNDED: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

impl Column {
    /// An unknown that is not a constant generalized error.
    pub fn new(name: impl Into<String>, unit: impl Into<String>, scale: f64) -> Self {
        Column { name: name.into(), unit: unit.into(), scale, site: None, bounds: UNBOUNDED }
    }

    /// The same, between these values.
    pub fn within(self, lower: f64, upper: f64) -> Self {
        Column { bounds: [lower, upper], ..self }
    }
}

/// A parameter in which an effect is not linear: a period, a time constant, an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct NonlinearParameter {
    /// Its name.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Present value.
    pub value: f64,
    /// Smallest value that makes sense.
    pub lower: f64,
    /// Largest value that makes sense.
    pub upper: f64,
    /// How it is looked for.
    pub search: Search,
}

/// How the residual depends on a parameter in which an effect is not linear, and so how it is looked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Search {
    /// One valley, or few, over the range: a time constant, a load, an exponent.
    Smooth,
    /// A period in the travel of a joint: as many valleys as periods fit into it, times this harmonic.
    Period(JointId, u32),
    /// An instant at which something jumps: flat between two visits, so that no slope leads there.
    Instant,
}

/// A physical cause that makes generalized errors: at a posture it *emits* triples (column, site, value), "per
/// unit of coefficient k the generalized error at this site is v" (one row of Φ in `ε(s) = Φ(s) c`).
///
/// The design matrix multiplies an emission by the error Jacobian, the evaluator by the coefficients: so fit
/// and compensation cannot disagree, and no effect touches a Jacobian, an index or a solver. Parameters that
/// are not unknowns of the fit are the struct's fields; they are what a file stores.
///
/// A complete effect, an encoder that reads a constant fraction too much:
///
/// ```
/// use serde::{Deserialize, Serialize};
/// use truepose_errormodel::{Column, Effect, Emission};
/// use truepose_kinematics::{Chain, JointId, Posture};
///
/// #[derive(Debug, Clone, Serialize, Deserialize)]
/// struct EncoderGain { joint: JointId }
///
/// impl Effect for EncoderGain {
///     const FAMILY: &'static str = "acme/encoder_gain";
///     fn columns(&self, chain: &Chain) -> Vec<Column> {
///         vec![Column::new(format!("gain {}", chain.joint(self.joint).name), "1", 1e-3)]
///     }
///     fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
///         if let Some(motion) = at.chain().joint_motion(self.joint) {
///             out.along(0, &motion, at.joint(self.joint));
///         }
///     }
/// }
/// ```
pub trait Effect: Debug + Clone + Send + Sync + Serialize + DeserializeOwned + 'static {
    /// Its tag in files. Third parties prefix theirs: `acme/belt`.
    const FAMILY: &'static str;

    /// One line for a list of effects.
    const ABOUT: &'static str = "";

    /// The unknowns: name, unit, expected size.
    fn columns(&self, chain: &Chain) -> Vec<Column>;

    /// Emits Φ at a posture. Called for every row: no allocation, no panic.
    fn eval(&self, at: &Posture<'_>, out: &mut Emission);

    /// Emits Φ in a block of rows at once: the same as `eval` in each of them, faster. `false`, having said nothing: `eval` is asked.
    fn eval_lanes(&self, _at: &LanePosture<'_>, _out: &mut LaneEmission) -> bool {
        false
    }

    /// The signals that `eval` reads as `at.signal(0)`, `at.signal(1)`, … Checked once against the data's schema.
    fn needs(&self) -> Vec<Signal> {
        Vec::new()
    }

    /// Whether what it says depends on frames or wrenches. Then it is asked again where the real robot comes to rest,
    /// since weights act on the posture that they have bent; `false` saves that for what depends on joint values and
    /// signals alone.
    fn load_dependent(&self) -> bool {
        true
    }

    /// The joints that yield, one for each column, when this is all that the effect says: column k is joint k's own motion,
    /// in proportion to the load about (along) it, [`Posture::joint_load`]. Who evaluates many postures at once need not ask
    /// such an effect posture by posture. `None`, which is always right, leaves it to `eval`.
    fn compliances(&self, _chain: &Chain) -> Option<Vec<JointId>> {
        None
    }

    /// What is left of it where nothing tells the time: the same error at the same place, unchanging. `None` where it needs no time, or has
    /// no such form.
    fn without_time(&self) -> Option<Box<dyn AnyEffect>> {
        None
    }

    /// Checks the parameters against the robot, once, when a model is made.
    ///
    /// # Errors
    /// Says which parameter does not fit.
    fn validate(&self, _chain: &Chain) -> Result<(), ModelError> {
        Ok(())
    }

    /// Parameters in which it is not linear and that are to be found, with their present values: they are profiled by
    /// the fit (variable projection). Empty when all of them are known.
    fn shape(&self) -> Vec<NonlinearParameter> {
        Vec::new()
    }

    /// The same effect with other values of those parameters.
    fn with_nonlinear(&self, _values: &[f64]) -> Self {
        self.clone()
    }
}

/// Any effect, behind one object-safe trait. Implemented for every [`Effect`] and for [`Term`](crate::Term), which forwards to one;
/// no method has a default, so that nothing is forgotten when it is forwarded.
pub trait AnyEffect: Any + Debug + Send + Sync {
    /// [`Effect::FAMILY`].
    fn kind(&self) -> &'static str;
    /// [`Effect::columns`].
    fn columns(&self, chain: &Chain) -> Vec<Column>;
    /// [`Effect::eval`].
    fn eval(&self, at: &Posture<'_>, out: &mut Emission);
    /// [`Effect::eval_lanes`].
    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool;
    /// [`Effect::needs`].
    fn needs(&self) -> Vec<Signal>;
    /// [`Effect::load_dependent`].
    fn load_dependent(&self) -> bool;
    /// [`Effect::compliances`].
    fn compliances(&self, chain: &Chain) -> Option<Vec<JointId>>;
    /// [`Effect::without_time`].
    fn without_time(&self) -> Option<Box<dyn AnyEffect>>;
    /// [`Effect::validate`].
    ///
    /// # Errors
    /// As [`Effect::validate`].
    fn validate(&self, chain: &Chain) -> Result<(), ModelError>;
    /// [`Effect::shape`].
    fn shape(&self) -> Vec<NonlinearParameter>;
    /// [`Effect::with_nonlinear`].
    fn with_nonlinear(&self, values: &[f64]) -> Box<dyn AnyEffect>;
    /// Its parameters as they stand in a file.
    fn parameters(&self) -> serde_json::Value;
    /// A copy.
    fn boxed(&self) -> Box<dyn AnyEffect>;
}

impl<E: Effect> AnyEffect for E {
    fn kind(&self) -> &'static str {
        E::FAMILY
    }
    fn columns(&self, chain: &Chain) -> Vec<Column> {
        Effect::columns(self, chain)
    }
    fn eval(&self, at: &Posture<'_>, out: &mut Emission) {
        Effect::eval(self, at, out);
    }
    fn eval_lanes(&self, at: &LanePosture<'_>, out: &mut LaneEmission) -> bool {
        Effect::eval_lanes(self, at, out)
    }
    fn needs(&self) -> Vec<Signal> {
        Effect::needs(self)
    }
    fn load_dependent(&self) -> bool {
        Effect::load_dependent(self)
    }
    fn compliances(&self, chain: &Chain) -> Option<Vec<JointId>> {
        Effect::compliances(self, chain)
    }
    fn without_time(&self) -> Option<Box<dyn AnyEffect>> {
        Effect::without_time(self)
    }
    fn validate(&self, chain: &Chain) -> Result<(), ModelError> {
        Effect::validate(self, chain)
    }
    fn shape(&self) -> Vec<NonlinearParameter> {
        Effect::shape(self)
    }
    fn with_nonlinear(&self, values: &[f64]) -> Box<dyn AnyEffect> {
        Box::new(Effect::with_nonlinear(self, values))
    }
    fn parameters(&self) -> serde_json::Value {
        // A struct that serde cannot write as JSON (a map with keys that are not strings) has no parameters in a file.
        serde_json::to_value(self).unwrap_or(serde_json::Value::Null)
    }
    fn boxed(&self) -> Box<dyn AnyEffect> {
        Box::new(self.clone())
    }
}

impl Clone for Box<dyn AnyEffect> {
    fn clone(&self) -> Self {
        self.as_ref().boxed()
    }
}
