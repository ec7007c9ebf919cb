//! Held-out spread at landmarks: a group of landmarks is left out, and what the robot then says of its rows is held against their mean.
//!
//! ```text
//! e_i = p_i − (1/n_k) Σ_{i' of k} p_i'          p from a fit without the rows of k's group
//! ```
//!
//! The place of a landmark is known from its own rows only, so that rows that share it are left out together. What is left is precision at
//! this place; accuracy shows in distances between landmarks.

use super::found_in::found_in;
use crate::{CrossValidation, Fit, FitOptions, Folds, IdentifyError, Residuals, fit};
use nalgebra::{DMatrix, DVector, Vector3};
use std::collections::BTreeMap;
use truepose_errormodel::effects::{Landmarks, Observed};
use truepose_errormodel::{Dataset, ErrorModel, FittedModel, Visits, configurations, own_channel};
use truepose_kinematics::Conditions;
use truepose_solvers::Solver;

/// Where landmarks are by a fit that has not seen their rows.
#[derive(Debug, Clone, PartialEq)]
pub struct LandmarkFold {
    /// Landmarks of the group, by number.
    pub landmarks: Vec<usize>,
    /// Mean predicted position of each, m, measurement frame.
    pub positions: Vec<Vector3<f64>>,
    /// Whether no other row states how long anything is, so that the fold has the scale of the whole fit.
    pub keeps_scale: bool,
}

/// Leaves out one group of landmarks after the other, `groups` being that of each landmark. Rows without a landmark are left out in as many
/// parts, by their configurations. Where the scale is known from distances of one group alone, the fold without it keeps the scale of the whole fit. None with fewer than two groups, or fewer than three landmarks where a distance of the nominal robot holds the scale:
/// without the rows of one of them, two others hold it where the whole fit has them.
///
/// # Errors
/// When a fit fails.
pub fn landmark_cross_validation(
    known: &Fit,
    data: &Dataset,
    groups: &[Option<usize>],
    (solver, options): (&dyn Solver, &FitOptions),
) -> Result<Option<(CrossValidation, Vec<LandmarkFold>)>, IdentifyError> {
    let count = groups.iter().flatten().max().map_or(0, |last| last + 1);
    let landmarks = found_in::<Landmarks>(known.fitted.model().effects());
    let held = landmarks.is_some_and(Landmarks::hold_scale);
    let distances_alone =
        landmarks.filter(|_| !held && (0..data.len()).all(|row| data.landmark(row).is_some()));
    // Whether a fold has lost all distances.
    let loses_scale = |left_out: usize| {
        distances_alone.is_some_and(|of| {
            let tied = || of.points.iter().zip(groups).filter(|(point, _)| point.tied.is_some());
            tied().next().is_some() && tied().all(|(_, group)| *group == Some(left_out))
        })
    };
    if count < 2 || landmarks.is_some_and(|of| held && of.points.len() < 3) {
        return Ok(None);
    }
    let visits = Visits::of(data);
    let sensors = found_in::<Observed>(known.fitted.model().effects()).map_or(0, |of| of.sensors.len());
    let points = groups.len().saturating_sub(sensors);
    let configuration = configurations(data);
    let fold = |visit: usize| {
        let of = |row: usize| data.landmark(row).or_else(|| Some(points + data.sensor(row)?));
        let of = visits.rows[visit].first().and_then(|&row| of(row));
        of.and_then(|k| groups.get(k).copied().flatten()).unwrap_or(configuration[visit] % count)
    };
    let folds = Folds { of_visit: (0..visits.len()).map(fold).collect(), count };
    let mut residuals = Residuals {
        position: vec![Vector3::repeat(f64::NAN); data.len()],
        orientation: vec![None; data.len()],
    };
    let (mut fold_rms, mut places) = (Vec::new(), Vec::new());
    for left_out in 0..count {
        let (out, rest): (Vec<usize>, Vec<usize>) =
            (0..data.len()).partition(|&row| folds.of_visit[data.visit[row]] == left_out);
        let rest = data.select(&rest);
        let keeps_scale = loses_scale(left_out);
        let again = match landmarks.filter(|_| held || keeps_scale) {
            Some(landmarks) => fit(&with_scale(known, landmarks, &rest)?, &rest, solver, options)?,
            None => fit(known.fitted.model(), &rest, solver, options)?,
        };
        let part = judged(&again.fitted.without_landmarks()?, data, &out, &mut residuals)?;
        let part = LandmarkFold { keeps_scale, ..part };
        fold_rms.push(residuals.positions_of(&out).rms);
        places.push(part);
    }
    Ok(Some((CrossValidation { residuals, folds, fold_rms, refitted: count }, places)))
}

/// The model with its scale held between landmarks that the rows have.
fn with_scale(known: &Fit, landmarks: &Landmarks, rows: &Dataset) -> Result<ErrorModel, IdentifyError> {
    let moved = known.fitted.landmarks_displaced().unwrap_or_default();
    let mut at: BTreeMap<usize, Vector3<f64>> = BTreeMap::new();
    for row in 0..rows.len() {
        if let Some(k) = rows.landmark(row) {
            at.insert(k, Vector3::from(rows.position[row]) + moved.get(k).copied().unwrap_or_default());
        }
    }
    let here: Vec<usize> = at.keys().copied().collect();
    let places: Vec<Vector3<f64>> =
        (0..landmarks.points.len()).map(|k| at.get(&k).copied().unwrap_or_default()).collect();
    let mut held = landmarks.clone();
    held.held_between(&here, &places);
    let model = known.fitted.model();
    let effects = model.effects().iter().map(|effect| match effect.concrete::<Landmarks>() {
        Some(_) => effect.replaced(Box::new(held.clone())),
        None => effect.clone(),
    });
    Ok(ErrorModel::new(model.shared_chain(), effects.collect())?)
}

/// Residuals of the rows of a sensor, its own unknowns being fitted to them: nothing else knows these.
fn about_own(data: &Dataset, rows: &[(usize, Vector3<f64>)], residuals: &mut Residuals) {
    let own: Vec<&Vec<f64>> =
        (0..).map_while(|k| data.schema.channel(&own_channel(k))).map(|k| &data.channels[k]).collect();
    let left: Vec<f64> =
        rows.iter().map(|(row, at)| data.number(*row, &data.away(*row, at), 0).unwrap_or(0.0)).collect();
    let w = |row: usize| data.ray(row).unwrap_or_default();
    let a = DMatrix::from_fn(rows.len(), own.len(), |i, k| own[k][rows[i].0] * w(rows[i].0).norm_squared());
    let left = DVector::from_vec(left);
    // Columns of other sensors' unknowns are zero; a direction that these rows hardly show is left where it is.
    let norms: Vec<f64> = a.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
    let scaled = DMatrix::from_fn(a.nrows(), a.ncols(), |i, k| a[(i, k)] / norms[k]);
    // What is known altogether has nothing of its own to fit.
    let own = (!own.is_empty()).then(|| scaled.clone().svd(true, true).solve(&left, 1e-6));
    let moved = match own {
        Some(Ok(x)) => &left - scaled * x,
        _ => left,
    };
    for ((row, _), left) in rows.iter().zip(moved.iter()) {
        let w = w(*row);
        residuals.position[*row] = w * (left / w.norm_squared().max(f64::MIN_POSITIVE));
    }
}

/// Residuals of rows, those at a landmark about their own mean.
fn judged(
    robot: &FittedModel,
    data: &Dataset,
    rows: &[usize],
    residuals: &mut Residuals,
) -> Result<LandmarkFold, IdentifyError> {
    let data = &*data.derived_for(robot.model())?;
    let mut predictor = robot.bind(&data.schema)?;
    let mut conditions = Conditions::default();
    let mut of_landmark = BTreeMap::<usize, Vec<(usize, Vector3<f64>)>>::new();
    let mut of_sensor = BTreeMap::<usize, Vec<(usize, Vector3<f64>)>>::new();
    for &row in rows {
        data.conditions_into(row, &mut conditions);
        let at = predictor.predict(&conditions, data.aim(row)).translation;
        match (data.landmark(row), data.sensor(row)) {
            (Some(k), _) => of_landmark.entry(k).or_default().push((row, at)),
            (None, Some(k)) => of_sensor.entry(k).or_default().push((row, at)),
            (None, None) => residuals.position[row] = data.away(row, &at),
        }
    }
    for rows in of_sensor.values() {
        about_own(data, rows, residuals);
    }
    let mut fold = LandmarkFold { landmarks: Vec::new(), positions: Vec::new(), keeps_scale: false };
    for (&landmark, touches) in &of_landmark {
        let mean = touches.iter().map(|(_, at)| at).sum::<Vector3<f64>>() / touches.len() as f64;
        touches.iter().for_each(|&(row, at)| residuals.position[row] = mean - at);
        fold.landmarks.push(landmark);
        fold.positions.push(mean);
    }
    Ok(fold)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::landmarks::tests::{campaign, cell, geometric};
    use crate::landmarks::{landmark_groups, touched};
    use truepose_errormodel::AnyEffect;
    use truepose_errormodel::effects::{Sensor, Unknown};
    use truepose_solvers::PivotedQr;

    #[test]
    fn a_fold_without_the_only_distance_keeps_the_scale() {
        let of = cell(4);
        let (data, mut surroundings) = campaign(&of, 10, 2e-5, 9);
        surroundings.distances.truncate(1);
        let (solver, options) = (PivotedQr::default(), FitOptions::default());
        let made = touched(&of.chain, &geometric(), &data, &surroundings, (&solver, &options)).unwrap();
        let groups = landmark_groups(&made.effects).unwrap();
        let model = ErrorModel::new(made.chain.clone(), made.effects.clone()).unwrap();
        let found = fit(&model, &made.data, &solver, &options).unwrap();
        let (held, folds) =
            landmark_cross_validation(&found, &made.data, &groups, (&solver, &options)).unwrap().unwrap();
        let keeps: Vec<usize> = (0..folds.len()).filter(|&k| folds[k].keeps_scale).collect();
        assert_eq!((keeps.as_slice(), folds[0].landmarks.as_slice()), (&[0][..], &[0, 1][..]));
        // An arm that shrinks in that fold takes the spread with it.
        let apart = (folds[0].positions[0] - folds[0].positions[1]).norm();
        assert!((apart - 0.05).abs() < 2e-4, "{apart}");
        let (out, training) = (held.residuals.positions().rms, found.residuals.positions().rms);
        assert!(out > training, "{out} {training}");
    }

    #[test]
    fn rows_of_a_sensor_of_which_all_is_known_are_left_out_by_configuration() {
        let unknown = Unknown { name: "height".into(), unit: "m".into(), scale: 1e-3 };
        let sensor =
            |name: &str, unknowns: &[Unknown]| Sensor { name: name.into(), unknowns: unknowns.to_vec() };
        let of = |sensors: Vec<Sensor>| -> [Box<dyn AnyEffect>; 1] { [Box::new(Observed { sensors })] };
        assert_eq!(landmark_groups(&of(vec![sensor("A", &[]), sensor("B", &[])])), None);
        let free = || vec![unknown.clone()];
        let mixed = vec![sensor("A", &free()), sensor("B", &[]), sensor("C", &free()), sensor("D", &free())];
        assert_eq!(landmark_groups(&of(mixed)), Some(vec![Some(0), None, Some(1), Some(2)]));
    }
}
