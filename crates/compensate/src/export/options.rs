//! Where, and under which conditions, an export is compared with the model.

use truepose_errormodel::{Domain, FittedModel, Interval};
use truepose_kinematics::{Chain, Conditions, TargetId};

/// Under which conditions, and where, an export is compared with the model.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportOptions {
    /// Load, time, approach and channels (in the order of the fit's); joints are not read. None takes those of the fit's rows;
    /// where it holds none they are spread over its domain, payloads at the tool's origin, every joint arriving from either
    /// side. Tables then hold for the middle of the domain, without a load.
    pub conditions: Option<Conditions>,
    /// Which point; none is that of each row of the fit, else the tool's origin.
    pub target: Option<TargetId>,
    /// How many configurations, where the fit holds none.
    pub samples: usize,
}

impl Default for ExportOptions {
    fn default() -> Self {
        ExportOptions { conditions: None, target: None, samples: 2000 }
    }
}

/// The caller's conditions, else the middle of the fit's domain.
pub(super) fn table_conditions(fitted: &FittedModel, options: &ExportOptions) -> Conditions {
    options.conditions.clone().unwrap_or_else(|| middle_conditions(fitted))
}

/// Time and channels (in the order of the fit's) in the middle of what the fit has seen, nothing carried, no joint moving;
/// without joint values.
pub fn middle_conditions(fitted: &FittedModel) -> Conditions {
    let mut conditions = Conditions { channels: vec![0.0; fitted.channels.len()], ..Conditions::default() };
    within(&fitted.domain, &mut conditions, |_| 0.5);
    conditions
}

/// Time and channels at a fraction of their ranges.
pub(super) fn within(domain: &Domain, conditions: &mut Conditions, share: impl Fn(usize) -> f64) {
    let at = |range: &Interval, k: usize| range.lower + (range.upper - range.lower) * share(k);
    conditions.time = domain.time.as_ref().map_or(0.0, |range| at(range, 0));
    for (k, (value, range)) in conditions.channels.iter_mut().zip(&domain.channels).enumerate() {
        *value = at(range, k + 1);
    }
}

/// The range of every joint: the fit's domain, else the limits, else a turn and a metre.
pub(super) fn ranges(fitted: &FittedModel) -> Vec<(f64, f64)> {
    let chain: &Chain = fitted.chain();
    let of = |(k, &joint): (usize, &_)| {
        let described = chain.joint(joint);
        let half = if described.unit() == "m" { 0.5 } else { std::f64::consts::PI };
        let limits =
            described.limits.filter(|(l, u)| l.is_finite() && u.is_finite()).unwrap_or((-half, half));
        fitted.domain.joints.get(k).map_or(limits, |range| (range.lower, range.upper))
    };
    chain.movable().iter().enumerate().map(of).collect()
}
