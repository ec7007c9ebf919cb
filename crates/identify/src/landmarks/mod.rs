//! Measurement without an instrument: one point touched again and again from many postures.
//!
//! ```text
//! 0 = l_k − p(q_i; c)           row i touched landmark k
//! |l_j − l_k| = d_jk            where the distance is known
//! ```
//!
//! A row says that its target was at the landmark, and where that is nobody knows: three unknowns a landmark, beside those of the robot. A
//! known distance fixes the scale; it is taken as exact and keeps one landmark on a sphere around the other. Directions on that sphere are
//! angles, in which the fit is not linear: it is made again with the landmarks where it has found them, until they rest.
//!
//! Where nothing outside of the robot was measured, its base has no place: errors of the base are left out, and the arm is described in the
//! frame of its base.

mod held_out;
mod ties;

pub use held_out::{LandmarkFold, landmark_cross_validation};

use crate::{FitOptions, IdentifyError, fit};
use nalgebra::Vector3;
use std::any::Any;
use ties::tied;
use truepose_errormodel::effects::{AllTargets, Geometric, Landmarks, Where};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel, FittedModel, Surroundings};
use truepose_kinematics::nalgebra::DMatrix;
use truepose_kinematics::{Chain, Conditions, FrameId, Placed, Target};
use truepose_solvers::Solver;

/// Rows and model of a campaign with landmarks, ready for every step of an identification.
#[derive(Debug, Clone)]
pub struct Touched {
    /// The rows: those that touched a landmark are measured where it was found.
    pub data: Dataset,
    /// The robot; all known where nothing outside of it was measured.
    pub chain: Chain,
    /// The declared effects as far as they can be known, and the landmarks.
    pub effects: Vec<Box<dyn AnyEffect>>,
    /// Landmarks of unknown place that were touched, by their number.
    pub names: Vec<String>,
    /// Where they were found, m, measurement frame.
    pub positions: Vec<Vector3<f64>>,
    /// Known distances that the fit keeps: which landmarks, m.
    pub distances: Vec<([usize; 2], f64)>,
    /// The group of each landmark: those that known distances join are left out of a fit together.
    pub groups: Vec<usize>,
    /// What a user has to know, in sentences.
    pub remarks: Vec<String>,
}

/// Fits from one set of places to the next.
const ROUNDS: usize = 12;
/// A move, m, below which landmarks rest.
const STILL: f64 = 1e-8;

/// Makes measurements of the rows that touched landmarks. The landmark of a row counts in `surroundings`.
///
/// # Errors
/// [`IdentifyError::Landmark`] where one was touched once only, or a row has both a landmark and a measured position; what a fit refuses.
pub fn touched(
    chain: &Chain,
    effects: &[Box<dyn AnyEffect>],
    data: &Dataset,
    surroundings: &Surroundings,
    (solver, options): (&dyn Solver, &FitOptions),
) -> Result<Touched, IdentifyError> {
    data.validate(chain)?;
    let mut data = data.clone();
    let mut of_row: Vec<Option<usize>> = (0..data.len()).map(|row| data.landmark(row)).collect();
    let outside = settle_known(&mut data, &mut of_row, surroundings);
    let chain = if outside { chain.clone() } else { all_known(chain)? };
    let mut remarks = Vec::new();
    let structure = tied(&of_row, surroundings, &mut remarks)?;
    for at in &mut of_row {
        *at = at.and_then(|k| structure.number[k]);
    }
    data.set_landmarks(Some(&of_row));
    let mut declared = effects.to_vec();
    if !outside {
        declared = without_base(declared, &chain);
        remarks.push(
            "the base is not determined: nothing outside of the robot was measured; positions are in the frame of its base".into(),
        );
        if structure.distances.is_empty() {
            remarks.push(
                "the scale is not determined: add one known distance ([[distances]]); without it the spread at the landmarks says nothing about lengths".into(),
            );
        }
    }
    let mut at = start(&chain, &data, structure.points.len(), surroundings, &structure.declared)?;
    let mut last = declared.clone();
    for _ in 0..ROUNDS {
        let points = structure.placed(&mut at);
        put(&mut data, &at);
        let model = ErrorModel::new(chain.clone(), with(&declared, points.clone()))?;
        let found = fit(&model, &data, solver, options)?;
        last = with(&declared, points);
        let moved = found.fitted.landmarks_displaced().unwrap_or_default();
        at.iter_mut().zip(&moved).for_each(|(at, by)| *at += by);
        if moved.iter().all(|by| by.norm() < STILL) {
            break;
        }
    }
    let names = structure.points.iter().map(|point| point.name.clone()).collect();
    let (distances, groups) = (structure.distances.clone(), structure.groups.clone());
    Ok(Touched { data, chain, effects: last, names, positions: at, distances, groups, remarks })
}

/// The group of each landmark of a model, which known distances join; none without landmarks.
pub fn landmark_groups(effects: &[Box<dyn AnyEffect>]) -> Option<Vec<usize>> {
    let landmarks = effects.iter().find_map(|effect| (&**effect as &dyn Any).downcast_ref::<Landmarks>())?;
    let mut groups: Vec<usize> = Vec::new();
    for point in &landmarks.points {
        let next = groups.iter().max().map_or(0, |last| last + 1);
        groups.push(point.tied.map_or(next, |tied| groups[tied.to]));
    }
    Some(groups)
}

/// Landmarks whose place is known are measured positions; whether anything outside of the robot was measured.
fn settle_known(data: &mut Dataset, of_row: &mut [Option<usize>], surroundings: &Surroundings) -> bool {
    let mut outside = false;
    for (row, at) in of_row.iter_mut().enumerate() {
        let known = at.and_then(|k| surroundings.landmarks.get(k)).filter(|landmark| landmark.known);
        if let Some(position) = known.and_then(|landmark| landmark.position) {
            data.position[row] = position.into();
            *at = None;
        }
        outside |= at.is_none() && data.seen(row).count() > 0;
    }
    outside
}

/// The robot as described: nothing of it can be found.
fn all_known(chain: &Chain) -> Result<Chain, IdentifyError> {
    let known = |placed: &Placed| Placed { known: true, ..*placed };
    let targets = chain.targets().iter().map(|target| Target { known: true, ..target.clone() }).collect();
    let (base, tool) = (known(chain.base()), known(chain.tool()));
    let all =
        chain.clone().with_base(base).and_then(|c| c.with_tool(tool)).and_then(|c| c.with_targets(targets));
    all.map_err(|error| IdentifyError::Landmark { name: "all".into(), why: error.to_string() })
}

/// The effects without errors of the base.
fn without_base(effects: Vec<Box<dyn AnyEffect>>, chain: &Chain) -> Vec<Box<dyn AnyEffect>> {
    let one = |effect: Box<dyn AnyEffect>| -> Option<Box<dyn AnyEffect>> {
        let Some(geometric) = (&*effect as &dyn Any).downcast_ref::<Geometric>() else { return Some(effect) };
        let all = || {
            let targets = (!chain.targets().is_empty()).then_some(Where::Targets(AllTargets::All));
            chain.frames().map(Where::Frame).chain(targets).collect::<Vec<_>>()
        };
        let frames = geometric.frames.clone().unwrap_or_else(all);
        let frames: Vec<Where> =
            frames.into_iter().filter(|place| *place != Where::Frame(FrameId::BASE)).collect();
        (!frames.is_empty()).then(|| {
            let rest = Geometric { frames: Some(frames), components: geometric.components.clone() };
            Box::new(rest) as Box<dyn AnyEffect>
        })
    };
    effects.into_iter().filter_map(one).collect()
}

fn with(declared: &[Box<dyn AnyEffect>], landmarks: Landmarks) -> Vec<Box<dyn AnyEffect>> {
    let mut all = declared.to_vec();
    all.push(Box::new(landmarks));
    all
}

/// Where the nominal robot touches each landmark in the mean; where it is declared to be, if it is.
fn start(
    chain: &Chain,
    data: &Dataset,
    points: usize,
    surroundings: &Surroundings,
    declared: &[usize],
) -> Result<Vec<Vector3<f64>>, IdentifyError> {
    // With measured positions beside the landmarks the base may have to be found from these.
    let chain = crate::place(chain, data)?.chain;
    let bare = FittedModel::new(ErrorModel::new(chain, Vec::new())?, Vec::new(), DMatrix::zeros(0, 0))?;
    let mut predictor = bare.bind(&data.schema)?;
    let mut conditions = Conditions::default();
    let mut sums = vec![(Vector3::zeros(), 0.0); points];
    for row in 0..data.len() {
        if let Some(k) = data.landmark(row) {
            data.conditions_into(row, &mut conditions);
            sums[k].0 += predictor.predict(&conditions, data.target[row]).translation;
            sums[k].1 += 1.0;
        }
    }
    let place = |(k, (sum, count)): (usize, &(Vector3<f64>, f64))| {
        surroundings.landmarks[declared[k]].position.unwrap_or(sum / *count)
    };
    Ok(sums.iter().enumerate().map(place).collect())
}

/// Rows are measured where their landmark is.
fn put(data: &mut Dataset, at: &[Vector3<f64>]) {
    for row in 0..data.len() {
        if let Some(k) = data.landmark(row) {
            data.position[row] = at[k].into();
        }
    }
}

#[cfg(test)]
mod tests;
