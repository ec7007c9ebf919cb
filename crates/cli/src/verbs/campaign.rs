//! What was measured, ready for a fit: rows of several installations in one frame, rows at landmarks where these were found.

use crate::failure::Failure;
use crate::terminal;
use std::path::Path;
use truepose_errormodel::{AnyEffect, Dataset, FittedModel, Installed, Landmark, Surroundings};
use truepose_identify::{FitOptions, LandmarkFold, Residuals, Touched, touched, unify};
use truepose_io::{CsvInfo, robot_sessions, robot_surroundings};
use truepose_kinematics::Chain;
use truepose_report::{LandmarksSummary, SessionSummary, session_summaries};
use truepose_solvers::Solver;

/// Rows, robot and effects of a fit.
pub(super) struct Campaign {
    pub chain: Chain,
    pub effects: Vec<Box<dyn AnyEffect>>,
    pub data: Dataset,
    /// The installations; none where it is one.
    installed: Vec<Installed>,
    /// RMS of each placement with the nominal arm, m.
    placed: Vec<Option<f64>>,
    /// Landmarks that were touched.
    touched: Option<Touched>,
}

impl Campaign {
    /// Of what was read; `robot` is the file that may say what sessions share, and what is known of landmarks.
    pub fn of(
        (robot, file): (&Path, &Path),
        chain: Chain,
        effects: Vec<Box<dyn AnyEffect>>,
        data: Dataset,
        info: &CsvInfo,
        fit: (&dyn Solver, &FitOptions),
    ) -> Result<Self, Failure> {
        let about =
            |error: truepose_identify::IdentifyError| Failure::Input(format!("{}: {error}", file.display()));
        if !info.landmarks.is_empty() {
            if info.sessions.len() > 1 {
                let words = "landmarks and several sessions in one table are not read: a socket does not move with an instrument";
                return Err(Failure::Input(format!("{}: {words}", file.display())));
            }
            let mut data = data;
            let surroundings = declared(robot, file, &mut data, info)?;
            let found = touched(&chain, &effects, &data, &surroundings, fit).map_err(about)?;
            terminal::warn(found.remarks.as_slice());
            let (chain, effects, data) = (found.chain.clone(), found.effects.clone(), found.data.clone());
            return Ok(Campaign {
                touched: Some(found),
                ..Campaign { chain, effects, data, installed: Vec::new(), placed: Vec::new(), touched: None }
            });
        }
        if info.sessions.len() < 2 {
            let (installed, placed) = (Vec::new(), Vec::new());
            return Ok(Campaign { chain, effects, data, installed, placed, touched: None });
        }
        let rules = robot_sessions(robot)?;
        let found = unify(&chain, &data, &info.sessions, rules).map_err(about)?;
        terminal::warn(found.remarks.as_slice());
        let mut effects = effects;
        effects.extend(found.effects);
        let placed = found.placed.iter().map(|session| session.rms).collect();
        let (chain, data, installed) = (found.chain, found.data, found.installed);
        Ok(Campaign { chain, effects, data, installed, placed, touched: None })
    }

    /// A fit as it is used: it knows its sessions, and landmarks are no part of it.
    pub fn used(&self, fitted: &FittedModel) -> Result<FittedModel, Failure> {
        let mut used = fitted.without_landmarks()?;
        used.sessions.clone_from(&self.installed);
        if let (Some(found), Some(moved)) = (&self.touched, fitted.landmarks_displaced()) {
            let at = found.positions.iter().zip(moved).map(|(at, by)| <[f64; 3]>::from(at + by));
            let places = found.names.iter().zip(at).map(|(name, at)| (name.clone(), serde_json::json!(at)));
            used.provenance.insert("landmarks_m".into(), serde_json::Value::Object(places.collect()));
        }
        Ok(used)
    }

    /// Each session on its own: none where it is one. The fit is in the frame of the first.
    pub fn sessions(
        &self,
        fitted: &FittedModel,
        held_out: Option<&Residuals>,
    ) -> Result<Vec<SessionSummary>, Failure> {
        if self.installed.is_empty() {
            return Ok(Vec::new());
        }
        let residuals = Residuals::of(fitted, &self.data)?;
        let names: Vec<&str> = self.installed.iter().map(|session| session.name.as_str()).collect();
        Ok(session_summaries(&names, &self.placed, &self.data, &residuals, held_out))
    }

    /// Spread at each landmark and known distances: none without landmarks.
    pub fn landmarks(
        &self,
        fitted: &FittedModel,
        held_out: Option<&Residuals>,
        folds: &[LandmarkFold],
    ) -> Result<Option<LandmarksSummary>, Failure> {
        let Some(found) = &self.touched else { return Ok(None) };
        let residuals = Residuals::of(fitted, &self.data)?;
        let moved = fitted.landmarks_displaced().unwrap_or_default();
        Ok(Some(LandmarksSummary::new(found, &moved, &self.data, (&residuals, held_out), folds)))
    }
}

/// What the robot file says of the landmarks of a table; where it names none, all of them are unknown points. The rows count as it does.
fn declared(robot: &Path, file: &Path, data: &mut Dataset, info: &CsvInfo) -> Result<Surroundings, Failure> {
    let mut known = robot_surroundings(robot)?;
    if known.landmarks.is_empty() {
        let point = |name: &String| Landmark { name: name.clone(), position: None, known: false };
        known.landmarks = info.landmarks.iter().map(point).collect();
    }
    let mut numbers = Vec::new();
    for (k, name) in info.landmarks.iter().enumerate() {
        let Some(number) = known.landmarks.iter().position(|landmark| landmark.name == *name) else {
            let row = (0..data.len()).find(|&row| data.landmark(row) == Some(k)).unwrap_or(0);
            let line = data.line.get(row).map_or(String::new(), |line| format!("{line}: "));
            let names: Vec<&str> = known.landmarks.iter().map(|landmark| landmark.name.as_str()).collect();
            return Err(Failure::Input(format!(
                "{}:{line}the robot file has no landmark `{name}`; declare it in [[landmarks]] (its landmarks: {})",
                file.display(),
                names.join(", ")
            )));
        };
        numbers.push(number);
    }
    let of_row: Vec<Option<usize>> =
        (0..data.len()).map(|row| data.landmark(row).map(|k| numbers[k])).collect();
    data.set_landmarks(Some(&of_row));
    Ok(known)
}
