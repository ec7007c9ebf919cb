//! Two finds that one cause explains: a cause that was told in two shapes, one after the other, is one finding.
//!
//! ```text
//! score(a + b) = −2 ln L(a + b) + C_a + C_b + odds of each          against the best score of a single cause
//! ```
//!
//! Taken out one at a time they cannot fall: each leaves the other's half of the cause behind. So both are taken out that have the same
//! driver (a joint's motion, the load, time), and one cause is asked for in their place. Where the data cannot tell, one is
//! believed rather than two.

use crate::accept::accepted::Accepted;
use crate::accept::evidence::{collect, parametric};
use crate::contest::competition::contest;
use crate::contest::rival::{adopted, cost, losers, odds};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::policy::TIE;
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Scene;
use crate::screen::candidates::Screen;
use crate::search::Search;
use nalgebra::DMatrix;
use std::ops::Range;
use truepose_errormodel::Visits;

/// Looks for one cause in place of one of the finds and any other; true when there is one.
pub(crate) fn merge(search: &mut Search<'_>, which: usize) -> Result<bool, DiscoverError> {
    for other in (0..search.accepted.len()).rev().filter(|&k| k != which) {
        let pair = [&search.accepted[which].candidate, &search.accepted[other].candidate];
        if !share_a_driver(pair[0], pair[1]) {
            continue;
        }
        if let Some(one) = one_for_both(search, [which.min(other), which.max(other)])? {
            search.accepted[which.min(other)] = one;
            search.accepted.remove(which.max(other));
            search.refit()?;
            return Ok(true);
        }
    }
    Ok(false)
}

/// The cause that explains what two finds do.
fn one_for_both(search: &Search<'_>, pair: [usize; 2]) -> Result<Option<Accepted>, DiscoverError> {
    let Search { ground, now, accepted, options, .. } = search;
    let others: Vec<Candidate> =
        (0..accepted.len()).filter(|k| !pair.contains(k)).map(|k| accepted[k].candidate.clone()).collect();
    let fewer = ground.working(others.clone(), &now.outliers.suspects)?;
    let scene = Scene::new(&fewer.fit, &fewer.data)?;
    let both = pair.map(|k| &accepted[k]);
    let shortlist: Vec<Candidate> = both.iter().flat_map(|a| a.shortlist.iter().cloned()).collect();
    let screen = Screen::again(&scene, &options.without, (&shortlist, &others), &search.asked);
    let contest = contest(&scene, &screen, &others, false)?;
    let Some(best) = contest.rivals.iter().min_by(|a, b| a.score.total_cmp(&b.score)) else {
        return Ok(None);
    };
    let columns = [scene.columns_of(&both[0].candidate)?, scene.columns_of(&both[1].candidate)?];
    let (first, width) = (columns[0].ncols(), columns[0].ncols() + columns[1].ncols());
    let mut joined = DMatrix::zeros(scene.len(), width);
    joined.columns_mut(0, first).copy_from(&columns[0]);
    joined.columns_mut(first, width - first).copy_from(&columns[1]);
    let likelihood = Likelihood::new(&scene, &joined, &Visits::of(scene.data))?;
    let pays = |k: usize, columns: Range<usize>| {
        let Accepted { candidate, evidence, .. } = both[k];
        cost(candidate, &likelihood.law(columns), evidence.unknowns, &scene)
            + odds(&scene, &screen, candidate)
    };
    let score = likelihood.deviance + pays(0, 0..first) + pays(1, first..width);
    if best.score > score + TIE {
        return Ok(None);
    }
    let p = (search.own_p(&scene, &others, best), parametric(&screen, best));
    let evidence = collect(&scene, &contest.present, best, p, options.seed)?;
    let rivals = losers(&contest.rivals, best);
    Ok(Some(Accepted { candidate: adopted(best), evidence, rivals, shortlist }))
}

/// Whether two causes are driven by the same thing, so that one may be half of the other.
fn share_a_driver(a: &Candidate, b: &Candidate) -> bool {
    let drivers = drivers(a);
    self::drivers(b).iter().any(|driver| drivers.contains(driver))
}

/// What drives a cause.
fn drivers(candidate: &Candidate) -> Vec<&str> {
    let place = &candidate.place;
    let names: Vec<&Option<String>> = match candidate.family {
        Family::Transmission | Family::Guideway | Family::Backlash => vec![&place.joint],
        Family::Coupling => vec![&place.driver],
        Family::Unmodelled if candidate.follows_the_time() => return vec!["the time"],
        Family::Unmodelled => vec![&place.covariate, &place.covariate2],
        Family::Thermal | Family::Drift | Family::Shift => return vec!["the time"],
        Family::JointCompliance
        | Family::LinkCompliance
        | Family::BaseCompliance
        | Family::LoadNonlinearity => return vec!["the load"],
        Family::Geometric | Family::Target | Family::Payload | Family::Outlier => Vec::new(),
    };
    names.into_iter().filter_map(|name| name.as_deref()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypotheses::place::Place;
    use truepose_errormodel::effects::{Coupling, Guideway};
    use truepose_kinematics::JointId;

    #[test]
    fn a_rail_and_what_it_does_to_another_slide_have_one_driver() {
        let at = |joint: &str| Place { joint: Some(joint.into()), ..Place::default() };
        let rail = Candidate::new(Family::Guideway, at("d1"), Guideway::of(JointId(1)));
        let dragged = |driver: &str| {
            let place = Place { driver: Some(driver.into()), ..at("d3") };
            Candidate::new(Family::Coupling, place, Coupling::of(JointId(3), JointId(1)))
        };
        assert!(share_a_driver(&rail, &dragged("d1")));
        assert!(!share_a_driver(&rail, &dragged("d2")));
        let frame = Candidate::new(Family::Geometric, at("d1"), Guideway::of(JointId(1)));
        assert!(!share_a_driver(&rail, &frame));
    }
}
