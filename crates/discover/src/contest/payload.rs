//! Wrong payloads compared by whole fits, in which masses and stiffnesses move together.

use crate::contest::rival::{Rival, adopted};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, Change};
use crate::model::current::{Ground, Working};
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Scene;
use nalgebra::DMatrix;
use rayon::prelude::*;
use truepose_errormodel::Visits;

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
