//! Causes that the data cannot test beside the present model.
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | X̃ᵀX̃ | information on a candidate's coefficients in prior standard deviations, what the model absorbs projected out, whitened | 1 |
//! | λ, v | its largest eigenvalue, and that direction | 1 |
//! | c | score statistic of one unknown that is significant at α in the last screen | 1 |
//! | f | repeatability limit | m |
//!
//! ```text
//! not testable     λ < 1                                       the data narrows the prior of no direction by more than √2
//! detectable       |γ| = (√c + Φ⁻¹(0.8)) / √λ prior standard deviations,   as 3-D RMS  f |γ| √(vᵀXᵀX v / m)
//! poses            N (√c + Φ⁻¹(0.8))² / λ                      of the same kind, for an effect of prior size
//! ```
//!
//! How much of an effect the model absorbs does not matter by itself: what is left of a large effect can still stand out of the noise.

use crate::hypotheses::family::Family;
use crate::hypotheses::levels::Levels;
use crate::hypotheses::place::Place;
use crate::policy::Policy;
use crate::problem::linearisation::Linearisation;
use crate::screen::candidates::Screen;
use crate::screen::screened::Screened;
use nalgebra::SymmetricEigen;
use rayon::prelude::*;
use serde::Serialize;
use truepose_kinematics::JointId;

/// A cause that the data cannot test.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Untestable {
    /// What kind of cause.
    pub family: Family,
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// Share of its effect that the declared model does not imitate.
    pub share: f64,
    /// Information on its best direction times the square of the prior standard deviation; zero when it does nothing at all here.
    pub information: f64,
    /// 3-D RMS over the data that it would need to be detected with 80 % probability at α, m; none when it does nothing at all here.
    pub detectable: Option<f64>,
    /// How many times as many poses of the same kind it would take to detect an effect of prior size.
    pub more_poses: Option<f64>,
    /// Whether the search tested it nevertheless.
    tested: bool,
}

impl Untestable {
    /// The same where the noise is this many times what the fit took it for.
    pub(crate) fn with_noise(self, ratio: f64) -> Self {
        Untestable {
            information: self.information / (ratio * ratio),
            detectable: self.detectable.map(|rms| rms * ratio),
            more_poses: self.more_poses.map(|times| times * ratio * ratio),
            ..self
        }
    }

    /// Whether the data cannot test it: too little information, or so little that the search left it out.
    pub(crate) fn holds(&self, policy: &Policy) -> bool {
        self.information < policy.untestable_information || !self.tested
    }
}

/// Sum of squares, in standard deviations of the observations, that an effect of prior size has at least: below it does nothing but round.
const NOTHING: f64 = 1e-6;

/// All named causes with the size that could have been detected; `significant` is the score statistic of one unknown that is significant.
pub(crate) fn untestable(
    linearisation: &Linearisation<'_>,
    screen: &Screen,
    significant: f64,
) -> Vec<Untestable> {
    let policy = linearisation.policy;
    // Where there is no such statistic: of some 10⁴ tests.
    let significant = if significant.is_finite() && significant > 0.0 { significant } else { 21.0 };
    let wanted = (significant.sqrt() + policy.power).powi(2);
    let floor = linearisation.floor(linearisation.noise);
    let named: Vec<&Screened> = screen.candidates.iter().filter(|s| s.candidate.family.is_named()).collect();
    let judged = |screened: &&Screened| {
        let (family, place) = (screened.candidate.family, screened.candidate.place.clone());
        let mut own = Untestable {
            family,
            place,
            share: 0.0,
            information: 0.0,
            detectable: None,
            more_poses: None,
            tested: screened.score.is_some(),
        };
        let sums = screen.projection.sums(linearisation, &screened.candidate).ok();
        if let Some(sums) = sums.filter(|sums| sums.raw.trace() > NOTHING && screened.acts) {
            let left = &sums.raw - sums.along.tr_mul(&sums.along);
            own.share = match &screened.score {
                Some(score) => score.share,
                None => (left.trace() / sums.raw.trace()).max(0.0),
            };
            let eigen = SymmetricEigen::new(left);
            let best = eigen.eigenvalues.imax();
            own.information = eigen.eigenvalues[best].max(0.0);
            let direction = eigen.eigenvectors.column(best);
            let raw = (direction.transpose() * &sums.raw * direction)[(0, 0)];
            let relative = wanted / own.information.max(1e-9);
            own.detectable = Some(floor * (relative * raw / linearisation.len() as f64).sqrt());
            own.more_poses = Some(relative);
        }
        own
    };
    let each: Vec<Untestable> = named.par_iter().map(judged).collect();
    let mut list: Vec<Untestable> = Vec::new();
    for own in each {
        match list.iter_mut().find(|u| u.family == own.family && u.place == own.place) {
            Some(known) => {
                let tested = known.tested || own.tested;
                if known.information < own.information {
                    *known = own;
                }
                known.tested = tested;
            }
            None => list.push(own),
        }
    }
    for own in of_few_values(linearisation) {
        list.retain(|u| u.family != own.family || u.place != own.place);
        list.push(own);
    }
    // What is declared already is no question; what does nothing at all here is one that other data could answer.
    list.retain(|u| u.detectable.is_none() || u.share > policy.untestable_declared);
    list
}

/// Errors of joints that stood at too few values to tell a function of theirs.
fn of_few_values(linearisation: &Linearisation<'_>) -> Vec<Untestable> {
    let chain = linearisation.chain();
    let few = |joint: &&JointId| {
        let levels = Levels::of(chain, linearisation.data, **joint);
        levels.count > 1 && !levels.are_enough()
    };
    let drive = |&joint: &JointId| Untestable {
        family: Family::Transmission,
        place: Place::joint(chain, joint),
        share: 1.0,
        information: 0.0,
        detectable: None,
        more_poses: None,
        tested: false,
    };
    chain.movable().iter().filter(few).map(drive).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypotheses::library::Library;
    use crate::options::DiscoverOptions;
    use crate::problem::synthetic::{data, fitted};
    use truepose_identify::NoiseModel;

    #[test]
    fn what_is_testable_is_a_matter_of_noise_and_not_of_the_share() {
        let (chain, data) = data(60, 3, &|_, _, _| [0.0; 3]);
        let fit = fitted(&chain, &data);
        let options = DiscoverOptions::default();
        let mut linearisation = Linearisation::new(&fit, &data, &options).expect("a linearisation");
        let mut list = |factor: f64| {
            linearisation.noise.rows = NoiseModel {
                position_sd: factor * 2e-5,
                visit_sd: factor * 3e-5,
                orientation_sd: factor * 1e-4,
            };
            let mut screen = Screen::new(&linearisation, &Library::standard(), &[]);
            screen.candidates.truncate(500);
            untestable(&linearisation, &screen, 21.0)
        };
        let policy = Policy::default();
        let quiet = list(1.0);
        let testable = |list: &[Untestable]| list.iter().filter(|u| !u.holds(&policy)).count();
        // Causes of which the model absorbs more than four fifths stand out of little noise.
        assert!(
            quiet.iter().any(|u| u.share < 0.2 && u.detectable.is_some() && !u.holds(&policy)),
            "{quiet:?}"
        );
        let loud = list(300.0);
        assert!(testable(&loud) < testable(&quiet), "{} {}", testable(&loud), testable(&quiet));
        for one in quiet.iter().filter(|u| u.information > 1e-9) {
            // √(c + …) prior sizes at the least detectable one.
            let times = (21f64.sqrt() + policy.power).powi(2);
            assert!((one.more_poses.unwrap() * one.information / times - 1.0).abs() < 1e-9, "{one:?}");
            let other = one.clone().with_noise(2.0);
            assert!((other.information * 4.0 / one.information - 1.0).abs() < 1e-12);
            assert!((other.detectable.unwrap() / one.detectable.unwrap() - 2.0).abs() < 1e-12);
        }
    }
}
