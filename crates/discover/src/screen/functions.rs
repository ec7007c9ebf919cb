//! The many candidates that are a function of the visit at one site: functions are taken once, and all of a site go through the
//! model together.

use crate::error::DiscoverError;
use crate::hypotheses::candidate::Candidate;
use crate::hypotheses::nonlinear::seen_as;
use crate::problem::linearisation::Scene;
use crate::problem::projection::{Projection, Score};
use nalgebra::DMatrix;
use rayon::prelude::*;
use std::ops::Range;
use truepose_errormodel::AnyEffect;
use truepose_errormodel::effects::{Expansion, Factor, Place};
use truepose_kinematics::{Axis, FrameId, Site};

/// Sets of functions of the visit, with the scores of each at every component of every frame.
pub(crate) struct Functions {
    sets: Vec<(Vec<Factor>, Range<usize>)>,
    /// By frame, then by set.
    scores: Vec<Vec<AtFrame>>,
}

/// Scores of one set of functions at one frame.
struct AtFrame {
    /// At each component alone.
    single: [Option<Score>; 6],
    /// At all of them together, where that was asked for.
    all: Option<Option<Score>>,
}

/// The series of a candidate that acts on one component of a frame, or on all six, and knows joints, signals and time alone.
fn series(candidate: &Candidate) -> Option<(&Expansion, FrameId, &[Axis])> {
    let [effect] = candidate.effects() else { return None };
    let series = seen_as::<Expansion>(&**effect)?;
    match &series.at {
        Place::Frame { frame, components }
            if !AnyEffect::load_dependent(series)
                && (components.len() == 1 || components[..] == Axis::ALL) =>
        {
            Some((series, *frame, components))
        }
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
        // At which frames all components are asked for together.
        let mut together: Vec<Vec<FrameId>> = Vec::new();
        let mut effects: Vec<Box<dyn AnyEffect>> = Vec::new();
        let mut width = 0;
        for (series, frame, components) in candidates.iter().filter_map(series) {
            let known = position(&sets, &series.factors);
            let set = known.unwrap_or(sets.len());
            if known.is_none() {
                let one = Expansion {
                    at: Place::Frame { frame: FrameId::BASE, components: vec![Axis::ALL[0]] },
                    factors: series.factors.clone(),
                };
                let count = AnyEffect::columns(&one, scene.chain()).len();
                sets.push((series.factors.clone(), width..width + count));
                together.push(Vec::new());
                effects.push(Box::new(one));
                width += count;
            }
            if components.len() > 1 {
                together[set].push(frame);
            }
        }
        let stations = projection.tables.stations.iter().copied();
        let mut values = DMatrix::zeros(stations.len(), width);
        scene.ask(&effects)?.each(stations, &mut |visit, entries| {
            for &(column, _, value) in entries {
                values[(visit, column)] += value;
            }
        })?;
        let frames: Vec<FrameId> = scene.chain().frames().collect();
        let scores = frames
            .into_par_iter()
            .map(|frame| {
                let sites = Axis::ALL.map(|axis| scene.chain().site_index(Site::Frame(frame, axis)));
                let pulses = sites.map(|site| projection.tables.pulses(&[(site, 1.0)]));
                let through = pulses.each_ref().map(|pulses| pulses.through(&values, &projection.q_by_unit));
                let part =
                    |m: &DMatrix<f64>, own: &Range<usize>| m.columns(own.start, own.len()).into_owned();
                sets.iter()
                    .zip(&together)
                    .map(|((_, own), together)| {
                        let functions = part(&values, own);
                        let single = std::array::from_fn(|k| {
                            let raw = pulses[k].products(&functions);
                            projection.judged(&raw, &part(&through[k].0, own), &part(&through[k].1, own))
                        });
                        let all = together.contains(&frame).then(|| {
                            let raw = projection.tables.products(&sites, &functions);
                            let side_by_side = |parts: [&DMatrix<f64>; 6]| {
                                let columns: Vec<_> = parts
                                    .iter()
                                    .flat_map(|m| {
                                        m.columns(own.start, own.len())
                                            .column_iter()
                                            .map(|c| c.into_owned())
                                            .collect::<Vec<_>>()
                                    })
                                    .collect();
                                DMatrix::from_columns(&columns)
                            };
                            let along = side_by_side(through.each_ref().map(|t| &t.0));
                            let by_unit = side_by_side(through.each_ref().map(|t| &t.1));
                            projection.judged(&raw, &along, &by_unit)
                        });
                        AtFrame { single, all }
                    })
                    .collect()
            })
            .collect();
        Ok(Functions { sets, scores })
    }

    /// The score of a candidate; none when it has another form.
    pub fn score(&self, scene: &Scene<'_>, candidate: &Candidate) -> Option<Option<Score>> {
        let (series, frame, components) = series(candidate)?;
        let set = position(&self.sets, &series.factors)?;
        let at = scene.chain().frames().position(|known| known == frame)?;
        let scores = &self.scores[at][set];
        match components {
            [axis] => Some(scores.single[Axis::ALL.iter().position(|known| known == axis)?].clone()),
            _ => scores.all.clone(),
        }
    }
}

/// Candidates that differ only in their site follow each other closely.
fn position(sets: &[(Vec<Factor>, Range<usize>)], factors: &[Factor]) -> Option<usize> {
    sets.iter().rposition(|(known, _)| known == factors)
}
