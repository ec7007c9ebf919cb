//! Fits from one linearisation to the next, until landmarks, sensors and robot rest.
//!
//! A row along a direction holds near the robot at which it was linearised. Where a thing that observed it moved, or has a lens that is not the stated
//! one, a fit can find it likelier that the arm is wrong by half a metre, as far as straight lines go, and the next linearisation
//! is about a robot that does not exist. Such rounds are taken again with the errors of the arm held to their expected sizes, and the result says so.

use super::HELD;
use super::carried::Carried;
use super::contacts::{self, Contact};
use super::sensors::{self, Sensors};
use super::ties::Structure;
use crate::{FitOptions, IdentifyError, fit};
use nalgebra::Vector3;
use truepose_errormodel::effects::{Landmarks, Observed};
use truepose_errormodel::{AnyEffect, Dataset, ErrorModel};
use truepose_kinematics::{Chain, Pose};
use truepose_solvers::Solver;

/// Fits from one set of places to the next.
const ROUNDS: usize = 12;
/// A move, m, below which landmarks rest.
const STILL: f64 = 1e-8;
/// Rows along a direction rest where the robot and their sensors have moved by less since they were linearised: the square of this, over the
/// distance to an anchor, is far below what anything measures. m, and expected sizes of a sensor's unknowns.
const NEAR: f64 = 1e-5;
/// Relative change of the weight of a kind below which it rests: its standard deviation is not known to a hundredth.
const WEIGHED: f64 = 1e-2;
/// Of the length of the arm, so far no round after the first moves it.
const FAR: f64 = 0.1;
/// Where the last round still moves the robot by more than this, m, its straight lines are not those of the robot that it found.
const UNSETTLED: f64 = 1e-4;

/// What does not change from one round to the next.
pub(super) struct Rounds<'a> {
    pub declared: &'a [Box<dyn AnyEffect>],
    pub carried: &'a Carried,
    pub contacts: &'a [Contact],
    pub placed: &'a Chain,
    /// The rows without targets of their own.
    pub plain: &'a Dataset,
    pub length: f64,
}

/// What does.
#[derive(Clone)]
pub(super) struct State {
    pub data: Dataset,
    pub sensors: Sensors,
    pub structure: Structure,
    /// Places of landmarks.
    pub at: Vec<Vector3<f64>>,
    /// The tool in each row.
    pub poses: Vec<Pose>,
    /// The robot as a fit takes it, and the effects.
    pub chain: Chain,
    pub effects: Vec<Box<dyn AnyEffect>>,
}

/// How rounds end.
enum End {
    Rests,
    /// The last one moves the robot by so much at a row, m.
    Moves(f64),
    /// A round moved the arm by a tenth of its length.
    Far,
}

impl Rounds<'_> {
    /// The state in which all rest, and a remark where the arm had to be held.
    pub fn settled(
        &self,
        start: State,
        solver: &dyn Solver,
        options: &FitOptions,
    ) -> Result<(State, Option<String>), IdentifyError> {
        let mut free = start.clone();
        let words = match self.run(&mut free, solver, options) {
            Ok(End::Rests) => return Ok((free, None)),
            Err(error) if start.sensors.is_empty() => return Err(error),
            Ok(End::Moves(_)) => {
                "the rounds in which landmarks and sensors are found do not end with the arm's errors free; these are held to their expected sizes"
            }
            Ok(End::Far) | Err(_) => {
                "these rows would have the arm wrong by more than a tenth of its length; its errors are held to their expected sizes"
            }
        };
        let mut held = start;
        let options = FitOptions { prior: HELD, ..options.clone() };
        let end = self.run(&mut held, solver, &options)?;
        let mut words = format!(
            "{words} while landmarks and sensors are found: something that observed it may have moved, or differ from its description"
        );
        if let End::Moves(by) = end {
            words += &format!(
                ". Even so the last round moves the robot by {:.1} mm at a row: residuals and intervals are not those of the robot that is found",
                1e3 * by
            );
        }
        Ok((held, Some(words)))
    }

    /// Rounds until all rest, or as many as there are.
    fn run(
        &self,
        state: &mut State,
        solver: &dyn Solver,
        options: &FitOptions,
    ) -> Result<End, IdentifyError> {
        let mut last = 0.0;
        for round in 0..ROUNDS {
            let State { data, sensors, structure, at, poses, chain, effects } = &mut *state;
            let points = structure.placed(at);
            put(data, at);
            let own = sensors.effect(self.length);
            if !sensors.is_empty() || !self.contacts.is_empty() {
                let mut rays = sensors.linearised(poses, data, self.carried)?;
                contacts::measured(self.contacts, poses, data, &mut rays);
                data.set_rays(rays.iter().any(Option::is_some).then_some(&rays));
                *chain = self.carried.with_targets(self.placed, poses)?;
            }
            *effects = with(self.declared, points, own);
            let model = ErrorModel::new(chain.clone(), effects.clone())?;
            let found = fit(&model, data, solver, options)?;
            let moved = found.fitted.landmarks_displaced().unwrap_or_default();
            at.iter_mut().zip(&moved).for_each(|(at, by)| *at += by);
            let mut rests = moved.iter().all(|by| by.norm() < STILL);
            if data.rays().is_some() {
                let weighed = sensors.weigh(&found, data)?;
                let turned = sensors.moved(&found.fitted.sensors_moved().unwrap_or_default(), self.length);
                let next = sensors::poses(&found.fitted.without_landmarks()?, self.plain)?;
                let away = |row: usize| match self.carried.seen_from(row, &poses[row]) {
                    Some(own) => {
                        let point = self.carried.point(row);
                        point.map_or(0.0, |at| (next[row].apply(&own.translation) - at).norm())
                    }
                    None => (next[row].translation - poses[row].translation).norm(),
                };
                let far =
                    (0..data.len()).filter(|&row| data.ray(row).is_some()).map(away).fold(0.0, f64::max);
                *poses = next;
                if round > 0 && far > FAR * self.length && !sensors.is_empty() {
                    return Ok(End::Far);
                }
                last = far;
                rests = moved.iter().all(|by| by.norm() < NEAR)
                    && turned < NEAR
                    && far < NEAR
                    && weighed < WEIGHED;
            }
            if rests {
                return Ok(End::Rests);
            }
        }
        Ok(if last > UNSETTLED { End::Moves(last) } else { End::Rests })
    }
}

/// The declared effects, the landmarks and the unknowns of sensors.
pub(super) fn with(
    declared: &[Box<dyn AnyEffect>],
    landmarks: Landmarks,
    sensors: Observed,
) -> Vec<Box<dyn AnyEffect>> {
    let mut all = declared.to_vec();
    if !landmarks.points.is_empty() {
        all.push(Box::new(landmarks));
    }
    if !sensors.sensors.is_empty() {
        all.push(Box::new(sensors));
    }
    all
}

/// Rows that touched a landmark are measured where it is.
pub(super) fn put(data: &mut Dataset, at: &[Vector3<f64>]) {
    for row in 0..data.len() {
        if let Some(k) = data.landmark(row) {
            data.position[row] = at[k].into();
        }
    }
}
