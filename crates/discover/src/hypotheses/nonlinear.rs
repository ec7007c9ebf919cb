//! Parameters in which an effect is not linear: a period, an instant, a time constant, a load.

use truepose_kinematics::JointId;

/// A nonlinear parameter of an effect that was found rather than known.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Nonlinear {
    /// Its value, SI.
    pub value: f64,
    /// How it is searched.
    pub search: Refinement,
}

impl Nonlinear {
    /// A parameter at its value.
    pub fn new(value: f64, search: Refinement) -> Self {
        Nonlinear { value, search }
    }

    /// Whether variants have it on a coarse grid only, so that it is penalised as an unknown. Parameters on a fine grid are penalised by the
    /// number of variants.
    pub fn is_scale(&self) -> bool {
        matches!(self.search, Refinement::Scale(_) | Refinement::Within(_))
    }
}

/// How the best value of a nonlinear parameter is found near the one of a variant.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Refinement {
    /// A period in the value of a joint: one maximum within a quarter of a cycle over the range of the joint to either side, over the
    /// frequency. Every period of a cause is a hypothesis of its own.
    Period(JointId),
    /// An instant, s: all instants between neighbouring pose measurements nearby are tried.
    Instant {
        /// Between which instants it is known to lie.
        gap: Option<[f64; 2]>,
    },
    /// A positive number: one maximum between these multiples of the value, over the logarithm.
    Scale([f64; 2]),
    /// A positive number at which rows change sides: flat between two rows, so that the middle of the best stretch between these
    /// multiples of the value is taken, and there is no interval.
    Plateau([f64; 2]),
    /// A number of either sign: one maximum between these values.
    Within([f64; 2]),
    /// An end of a part of the travel of a joint, rad or m: all places between neighbouring values nearby are tried.
    Edge(JointId),
    /// The values of the variants are all that the data has (lags of derived channels).
    Grid,
}
