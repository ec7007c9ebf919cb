//! The many candidates that are a function of the visit at one site: functions are taken once, and all of a site go through the
//! model together.

use crate::DiscoverError;
use crate::candidate::Candidate;
use crate::projection::{Projection, Score};
use crate::scene::Scene;
use crate::shape::seen_as;
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::ops::Range;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{Expansion, Factor, Place};
use truepose_kinematics::{Axis, FrameId, Site};

/// Sets of functions of the visit, with the scores of each at every site.
pub(crate) struct Functions {
    sets: Vec<(Vec<Factor>, Range<usize>)>,
    /// By site, then by set.
    scores: Vec<Vec<Option<Score>>>,
}

/// The series of a candidate that acts at one site and knows joints, signals and time alone.
fn series(candidate: &Candidate) -> Option<(&Expansion, Site)> {
    let [effect] = candidate.effects() else { return None };
    let series = seen_as::<Expansion>(&**effect)?;
    match &series.at {
        Place::Frame { frame, components } if !AnyEffect::settles(series) => match components[..] {
            [axis] => Some((series, Site::Frame(*frame, axis))),
            _ => None,
        },
        _ => None,
    }
}

impl Functions {
    /// Of all candidates that have this form.
    pub fn new(
        scene: &Scene<'_>,
        projection: &Projection,
        candidates: &[Candidate],
    ) -> Result<Self, DiscoverError> {
        let mut sets: Vec<(Vec<Factor>, Range<usize>)> = Vec::new();
        let mut effects: Vec<Box<dyn AnyEffect>> = Vec::new();
        let mut width = 0;
        for (series, _) in candidates.iter().filter_map(series) {
            if position(&sets, &series.factors).is_none() {
                let one = Expansion {
                    at: Place::Frame { frame: FrameId::BASE, components: vec![Axis::ALL[0]] },
                    factors: series.factors.clone(),
                };
                let count = AnyEffect::columns(&one, scene.chain()).len();
                sets.push((series.factors.clone(), width..width + count));
                effects.push(Box::new(one));
                width += count;
            }
        }
        let stations = projection.tables.stations.iter().copied();
        let mut values = DMatrix::zeros(stations.len(), width);
        scene.ask(&effects)?.each(stations, &mut |visit, entries| {
            for &(column, _, value) in entries {
                values[(visit, column)] += value;
            }
        })?;
        let scores = (0..scene.site_count())
            .into_par_iter()
            .map(|site| {
                let pulses = projection.tables.pulses(&[(site, 1.0)]);
                let (along, by_unit) = pulses.through(&values, projection);
                sets.iter()
                    .map(|(_, own)| {
                        let part = |m: &'_ DMatrix<f64>| m.columns(own.start, own.len()).into_owned();
                        projection.judged(&pulses.products(&part(&values)), &part(&along), &part(&by_unit))
                    })
                    .collect()
            })
            .collect();
        Ok(Functions { sets, scores })
    }

    /// The score of a candidate; none when it has another form.
    pub fn score(&self, scene: &Scene<'_>, candidate: &Candidate) -> Option<Option<Score>> {
        let (series, site) = series(candidate)?;
        let set = position(&self.sets, &series.factors)?;
        Some(self.scores[scene.chain().site_index(site)][set].clone())
    }
}

/// Candidates that differ only in their site follow each other closely.
fn position(sets: &[(Vec<Factor>, Range<usize>)], factors: &[Factor]) -> Option<usize> {
    sets.iter().rposition(|(known, _)| known == factors)
}
