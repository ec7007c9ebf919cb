//! Ranges over which an effect is a function of something.

use super::checks::refused;
use crate::{ModelError, NonlinearParameter, Search};
use std::f64::consts::PI;
use truepose_kinematics::{Chain, JointId, JointKind};

/// The given range, else the joint's limits, else one turn (rad) or one metre about zero.
pub(super) fn travel(range: Option<[f64; 2]>, joint: JointId, chain: &Chain) -> [f64; 2] {
    let described = chain.joint(joint);
    match (range, described.limits) {
        (Some(range), _) => range,
        (None, Some((lower, upper))) if lower < upper && (upper - lower).is_finite() => [lower, upper],
        _ if described.kind == JointKind::Prismatic => [-1.0, 1.0],
        _ => [-PI, PI],
    }
}

/// Whether a value lies in a part of the travel, its upper end left out; everything does where there is none.
pub(super) fn within(part: Option<[f64; 2]>, value: f64) -> bool {
    part.is_none_or(|[lower, upper]| (lower..upper).contains(&value))
}

/// Refuses a range that is not finite and ascending.
pub(super) fn ascending(kind: &str, what: &str, range: Option<[f64; 2]>) -> Result<(), ModelError> {
    match range {
        Some([lower, upper]) if !(lower.is_finite() && upper.is_finite() && lower < upper) => {
            Err(refused(kind, format!("`{what}` has to be finite and ascending, not [{lower}, {upper}]")))
        }
        _ => Ok(()),
    }
}

/// A parameter that is free within a range, when one is given.
pub(super) fn free(
    name: &str,
    unit: &str,
    value: f64,
    range: Option<[f64; 2]>,
    search: Search,
) -> Vec<NonlinearParameter> {
    let shape = |[lower, upper]: [f64; 2]| NonlinearParameter {
        name: name.into(),
        unit: unit.into(),
        value,
        lower,
        upper,
        search,
    };
    range.map(shape).into_iter().collect()
}

/// Refuses a parameter that has to be positive, and a range for it that reaches to zero.
pub(super) fn positive(
    kind: &str,
    what: &str,
    value: f64,
    range: Option<[f64; 2]>,
) -> Result<(), ModelError> {
    if !value.is_finite() || value <= 0.0 {
        return Err(refused(kind, format!("`{what}` has to be positive, not {value}")));
    }
    let named = format!("{what}_range");
    ascending(kind, &named, range)?;
    match range {
        Some([lower, _]) if lower <= 0.0 => Err(refused(kind, format!("`{named}` has to be positive"))),
        _ => Ok(()),
    }
}
