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
use crate::accept::model::Model;
use crate::accept::winner::own_p;
use crate::contest::competition::contest;
use crate::contest::rival::{adopted, cost, losers, odds};
use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::family::Family;
use crate::model::current::Ground;
use crate::policy::TIE;
use crate::problem::likelihood::Likelihood;
use crate::problem::linearisation::Scene;
use crate::screen::candidates::{Questions, Screen};
use nalgebra::DMatrix;
use std::ops::Range;
use truepose_errormodel::Visits;

/// The model with one cause in place of one of the findings and any other; none when there is no such cause.
pub(crate) fn merged(
    context: &Ground<'_>,
    model: &Model,
    which: usize,
    asked: &Questions,
) -> Result<Option<Model>, DiscoverError> {
    let findings = &model.findings;
    for other in (0..findings.len()).rev().filter(|&k| k != which) {
        if !share_a_driver(&findings[which].candidate, &findings[other].candidate) {
            continue;
        }
        let pair = [which.min(other), which.max(other)];
        if let Some(one) = one_for_both(context, model, pair, asked)? {
            let mut findings = findings.clone();
            findings[pair[0]] = one;
            findings.remove(pair[1]);
            return Ok(Some(model.refitted(context, findings)?));
        }
    }
    Ok(None)
}

/// The cause that explains what two findings do.
fn one_for_both(
    context: &Ground<'_>,
    model: &Model,
    pair: [usize; 2],
    asked: &Questions,
) -> Result<Option<Accepted>, DiscoverError> {
    let options = context.options;
    let others = model.others(&pair);
    let fewer = context.working(others.clone(), &model.current.outliers.suspects)?;
    let both = pair.map(|k| &model.findings[k]);
    let scene = Scene::new(&fewer.fit, &fewer.data)?;
    let shortlist: Vec<Candidate> = both.iter().flat_map(|a| a.shortlist.iter().cloned()).collect();
    let screen = Screen::again(&scene, &options.without, (&shortlist, &others), asked);
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
    let p = (own_p(context, &scene, &others, best), parametric(&screen, best));
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
