//! The last digits of a shape: with the find in the model and the noise estimated without it.
//!
//! The screen found the period, the instant or the time constant under noise that still held the effect itself. The fit looks for
//! it again, by variable projection, within a narrow range; the exact robot and the smaller noise decide.

use crate::DiscoverError;
use crate::candidate::{Candidate, Change};
use crate::sample::sample;
use crate::working::{Ground, Working};
use serde_json::{Value, json};
use truepose_errormodel::{AnyEffect, Dataset, EffectRegistry};
use truepose_kinematics::Chain;

/// The find with its shapes looked for again; none when it has none, or nothing was gained.
pub(crate) fn polished(
    ground: &Ground<'_>,
    now: &Working,
    which: usize,
) -> Result<Option<Candidate>, DiscoverError> {
    // Much data gives the screen all digits that matter.
    if matches!(sample(&now.data, 0), std::borrow::Cow::Owned(_)) {
        return Ok(None);
    }
    let mut found = now.found.clone();
    let Some(free) = freed(&found[which], ground.chain, &now.data) else { return Ok(None) };
    found[which] = free;
    let fit = ground.fitted(&found, &now.data)?;
    let model = fit.fitted.model();
    let first = ground.declared.len() + found[..which].iter().map(|c| c.effects().len()).sum::<usize>();
    let count = found[which].effects().len();
    let effects: Option<Vec<Box<dyn AnyEffect>>> =
        model.effects()[first..first + count].iter().map(|effect| fixed(&**effect, ground.chain)).collect();
    let better =
        fit.chi_square.is_finite() && fit.residuals.positions().rms <= now.fit.residuals.positions().rms;
    Ok(effects
        .filter(|_| better)
        .map(|effects| Candidate { change: Change::Add(effects), ..now.found[which].clone() }))
}

/// The find with a range for each of its shapes.
pub(crate) fn freed(candidate: &Candidate, chain: &Chain, data: &Dataset) -> Option<Candidate> {
    let mut any = false;
    let effects: Vec<Box<dyn AnyEffect>> = candidate
        .effects()
        .iter()
        .map(|effect| match ranged(&**effect, chain, data) {
            Some(free) => {
                any = true;
                free
            }
            None => effect.clone(),
        })
        .collect();
    any.then(|| Candidate { change: Change::Add(effects), ..candidate.clone() })
}

fn ranged(effect: &dyn AnyEffect, chain: &Chain, data: &Dataset) -> Option<Box<dyn AnyEffect>> {
    let mut parameters = effect.parameters();
    let number = |key: &str| parameters.get(key).and_then(Value::as_f64);
    let (key, range) = match effect.kind() {
        "drift" => {
            let constant = number("time_constant")?;
            ("time_constant_range", [constant / 1.6, constant * 1.6])
        }
        "transmission" => {
            // A whole turn is known.
            let period = number("period").filter(|p| (p - std::f64::consts::TAU).abs() > 1e-9)?;
            let joint = truepose_kinematics::JointId(parameters.get("joint")?.as_u64()? as usize);
            let column = &data.joints[chain.coordinate(joint)?];
            let most = column.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            let range = most - column.iter().copied().fold(f64::INFINITY, f64::min);
            let half = (0.15 / range.max(1e-9)).min(0.5 / period);
            ("period_range", [1.0 / (1.0 / period + half), 1.0 / (1.0 / period - half)])
        }
        "backlash" => {
            let flank = number("flank_load")?;
            ("flank_range", [flank / 1.6, flank * 1.6])
        }
        _ => return None,
    };
    parameters.as_object_mut()?.insert(key.into(), json!(range));
    EffectRegistry::builtin().build(effect.kind(), parameters, chain).ok()
}

/// The same effect with its shapes held where they are.
fn fixed(effect: &dyn AnyEffect, chain: &Chain) -> Option<Box<dyn AnyEffect>> {
    let mut parameters = effect.parameters();
    if let Some(map) = parameters.as_object_mut() {
        map.retain(|key, _| {
            !(key.ends_with("_range")
                && ["period", "time_constant", "flank"].iter().any(|k| key.starts_with(k)))
        });
    }
    EffectRegistry::builtin().build(effect.kind(), parameters, chain).ok()
}
