//! Causes that the data cannot test beside the declared model.

use crate::hypotheses::family::Family;
use crate::hypotheses::place::Place;
use crate::problem::linearisation::Scene;
use crate::screen::candidates::Screen;
use serde::{Deserialize, Serialize};

/// A cause that the data cannot test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Untestable {
    /// What kind of cause.
    pub family: Family,
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// Share of its effect that the declared model does not imitate.
    pub share: f64,
    /// 3-D RMS over the data that it would need to be seen, m; none when it does nothing at all here.
    pub detectable: Option<f64>,
}

/// Causes that this data cannot test, with the size that could have been seen.
pub(crate) fn untestable(scene: &Scene<'_>, screen: &Screen) -> Vec<Untestable> {
    /// Less of a cause than this is left by the declared model.
    const LEFT: f64 = 0.05;
    /// Less than this is left only of what the declared model has itself.
    const DECLARED: f64 = 1e-4;
    /// Noncentrality at which the screen finds one unknown four times in five.
    const POWER: f64 = 30.0;
    let mut list: Vec<Untestable> = Vec::new();
    for screened in screen.candidates.iter().filter(|s| s.candidate.family != Family::Unmodelled) {
        let (family, place) = (screened.candidate.family, screened.candidate.place.clone());
        let share = screened.score.as_ref().map_or(0.0, |score| score.share);
        // An effect of this 3-D RMS leaves a whitened sum of squares of POWER.
        let rms =
            (scene.noise.floor(scene.typical_sd()).powi(2) * POWER / scene.len() as f64 / share.max(1e-9))
                .sqrt();
        let detectable = screened.acts.then_some(rms);
        match list.iter_mut().find(|u| u.family == family && u.place == place) {
            Some(known) if known.share < share => (known.share, known.detectable) = (share, detectable),
            Some(_) => {}
            None => list.push(Untestable { family, place, share, detectable }),
        }
    }
    // What is declared already is no question; what does nothing at all here is one that other data could answer.
    list.retain(|u| u.detectable.is_none() || (u.share < LEFT && u.share > DECLARED));
    list
}
