//! Configurations among which is chosen, and where accuracy matters when nobody says.

use super::options::PlanOptions;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::{FittedModel, Interval};
use truepose_kinematics::{Conditions, Load};

/// Conditions spread over the joints' ranges, with each load in turn and sides of approach drawn.
pub(super) fn spread(fitted: &FittedModel, options: &PlanOptions) -> Vec<Conditions> {
    let mut random = ChaCha8Rng::seed_from_u64(options.seed);
    let loads = if options.loads.is_empty() { vec![Load::None] } else { options.loads.clone() };
    (0..options.pool).map(|k| drawn(fitted, loads[k % loads.len()], &mut random)).collect()
}

/// Conditions where accuracy matters: spread over the ranges that the fit has seen, without a load.
pub(super) fn everywhere(fitted: &FittedModel, count: usize, seed: u64) -> Vec<Conditions> {
    let mut random = ChaCha8Rng::seed_from_u64(seed ^ 0x90a1);
    (0..count).map(|_| drawn(fitted, Load::None, &mut random)).collect()
}

fn drawn(fitted: &FittedModel, load: Load, random: &mut ChaCha8Rng) -> Conditions {
    let chain = fitted.chain();
    let mut unit = || f64::from(random.next_u32()) / f64::from(u32::MAX);
    let mut joints: Vec<f64> = chain
        .movable()
        .iter()
        .enumerate()
        .map(|(k, &joint)| {
            let range = range(chain.controller_limits(joint), fitted.domain.joints.get(k));
            range.lower + (range.upper - range.lower) * unit()
        })
        .collect();
    chain.joints_from_controller(&mut joints);
    let mut conditions = Conditions::at(chain, &joints).with_load(load);
    conditions.approach = joints.iter().map(|_| if unit() < 0.5 { -1.0 } else { 1.0 }).collect();
    conditions.channels = fitted.domain.channels.iter().map(|r| 0.5 * (r.lower + r.upper)).collect();
    conditions.time = fitted.domain.time.map_or(0.0, |range| range.upper);
    conditions
}

/// The limits where there are any, else what was seen, else half a turn to either side.
fn range(limits: Option<(f64, f64)>, seen: Option<&Interval>) -> Interval {
    match (limits, seen) {
        (Some((lower, upper)), _) if lower.is_finite() && upper.is_finite() && lower < upper => {
            Interval { lower, upper }
        }
        (_, Some(seen)) => *seen,
        _ => Interval { lower: -std::f64::consts::PI, upper: std::f64::consts::PI },
    }
}
