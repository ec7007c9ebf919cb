//! The last digits of a shape: with the find in the model, under the noise that is left with it.
//!
//! The screen found the period, the instant or the time constant under noise that still held the effect itself. Here each shape is looked
//! for again near where it is, everything else of the model, and of the find, projected out.

use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, Change};
use crate::hypotheses::nonlinear::has_shape;
use crate::model::current::{Ground, Working};
use crate::problem::likelihood::without;
use crate::problem::linearisation::Scene;
use crate::problem::projection::Projection;
use crate::screen::refine::refined;
use rayon::prelude::*;

/// Times that the shapes of a find with several effects are gone through: each moves the others a little.
const SWEEPS: usize = 2;

/// The find with its shapes looked for again; none when it has none, or nothing was gained.
pub(crate) fn polished(
    ground: &Ground<'_>,
    now: &Working,
    which: usize,
) -> Result<Option<Candidate>, DiscoverError> {
    let mut parts: Vec<Candidate> = now.found[which]
        .effects()
        .iter()
        .map(|effect| Candidate { change: Change::Add(vec![effect.clone()]), ..now.found[which].clone() })
        .collect();
    if !parts.iter().any(has_shape) {
        return Ok(None);
    }
    let own = ground.effects_of(&now.found, which);
    let Some(mut scene) = without(Scene::new(&now.fit, &now.data)?, own)? else { return Ok(None) };
    scene.noise = now.fit.noise;
    let present = Projection::new(&scene);
    let mut gained = false;
    for _ in 0..if parts.len() > 1 { SWEEPS } else { 1 } {
        let better: Vec<Option<Candidate>> = (0..parts.len())
            .into_par_iter()
            .map(|k| -> Result<Option<Candidate>, DiscoverError> {
                if !has_shape(&parts[k]) {
                    return Ok(None);
                }
                let others: Vec<_> =
                    (0..parts.len()).filter(|&l| l != k).flat_map(|l| parts[l].effects().to_vec()).collect();
                let with = if others.is_empty() { None } else { present.with(&scene.columns(&others)?) };
                let projection = with.as_ref().unwrap_or(&present);
                let gain = |candidate: &Candidate| {
                    projection.judge(&scene, candidate).map_or(f64::NEG_INFINITY, |score| score.gain)
                };
                let better = refined(&scene, projection, &parts[k]);
                Ok((gain(&better) > gain(&parts[k])).then_some(better))
            })
            .collect::<Result<_, _>>()?;
        for (part, better) in parts.iter_mut().zip(better) {
            if let Some(better) = better {
                part.change = better.change;
                gained = true;
            }
        }
    }
    let effects = parts.iter().flat_map(|part| part.effects().to_vec()).collect();
    Ok(gained.then(|| Candidate { change: Change::Add(effects), ..now.found[which].clone() }))
}
