//! Payloads whose declared mass is wrong.
//!
//! A wrong mass at one level and another stiffness look much alike from afar: the product of both is what is seen. So levels are held
//! against each other by whole fits, in which masses and stiffnesses move together.

use crate::DiscoverError;
use crate::candidate::{Candidate, Change};
use crate::likelihood::Likelihood;
use crate::rival::Rival;
use crate::scene::Scene;
use crate::winner::adopted;
use crate::working::{Ground, Working};
use nalgebra::DMatrix;
use rayon::prelude::*;
use truepose_errormodel::{Dataset, LoadCorrection, Visits};
use truepose_kinematics::{Conditions, Load};

fn replaced(load: Load, level: f64, mass: f64) -> Option<Load> {
    LoadCorrection { declared: level, carried: mass }.apply(load)
}

/// The same conditions with another mass, when they declare this level.
pub(crate) fn changed(conditions: &Conditions, level: f64, mass: f64) -> Option<Conditions> {
    replaced(conditions.load, level, mass).map(|load| Conditions { load, ..conditions.clone() })
}

/// The same data with another mass where this level is declared.
pub(crate) fn corrected(data: &Dataset, level: f64, mass: f64) -> Dataset {
    let mut data = data.clone();
    for load in &mut data.load {
        if let Some(other) = replaced(*load, level, mass) {
            *load = other;
        }
    }
    data
}

/// The levels of payload that the data declares, kg, ascending.
pub(crate) fn levels(data: &Dataset) -> Vec<f64> {
    let mut levels: Vec<f64> = Vec::new();
    for load in &data.load {
        if let Load::Payload(payload) = load
            && !levels.iter().any(|&known| replaced(*load, known, known).is_some())
        {
            levels.push(payload.mass);
        }
    }
    levels.sort_by(f64::total_cmp);
    levels
}

/// Rows (0-based) that declare a level.
pub(crate) fn rows_at(data: &Dataset, level: f64) -> Vec<usize> {
    (0..data.len()).filter(|&row| replaced(data.load[row], level, level).is_some()).collect()
}

/// Where a corrected load leads the rivals: puts that level first whose fit makes the data most likely.
pub(crate) fn weighed(ground: &Ground<'_>, now: &Working, rivals: &mut [Rival]) -> Result<(), DiscoverError> {
    let is_load = |rival: &Rival| matches!(rival.candidate.change, Change::CorrectLoad { .. });
    let levels: Vec<usize> = (0..rivals.len()).filter(|&k| is_load(&rivals[k])).collect();
    if levels.first() != Some(&0) || levels.len() < 2 {
        return Ok(());
    }
    let candidates: Vec<Candidate> = levels.iter().map(|&k| adopted(&rivals[k])).collect();
    let deviances: Vec<f64> = candidates
        .into_par_iter()
        .map(|candidate| {
            let mut found = now.found.clone();
            found.push(candidate);
            let with = ground.working(found, &now.outliers.suspects)?;
            let scene = Scene::new(&with.fit, &with.data)?;
            let nothing = DMatrix::zeros(scene.len(), 0);
            Ok(Likelihood::new(&scene, &nothing, &Visits::of(&with.data))?.deviance)
        })
        .collect::<Result<_, DiscoverError>>()?;
    let best = (0..levels.len()).min_by(|&a, &b| deviances[a].total_cmp(&deviances[b]));
    if let Some(best) = best.map(|best| levels[best]) {
        rivals[..=best].rotate_right(1);
    }
    Ok(())
}
