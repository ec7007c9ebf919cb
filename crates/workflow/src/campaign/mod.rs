//! What was measured, ready for a fit: rows of several installations in one frame, rows at landmarks where these were found.

mod check;
mod declared;
mod held_out;
mod inputs;
mod installation;
mod mistakes;
mod nominal;
mod observers;
mod points;
mod vertical;

pub use check::{CheckedRows, check_rows};
pub(crate) use declared::declared;
pub use inputs::{InputFiles, Inputs};
pub use installation::Undeclared;
pub use mistakes::Mistakes;
pub use nominal::Nominal;
pub(crate) use observers::decided;

use crate::error::WorkflowError;
use crate::parameters;
use crate::recorded::record_columns;
use held_out::among_all;
use std::any::Any;
use std::path::Path;
use std::sync::Arc;
use truepose_discover::Diagnosis;
use truepose_errormodel::observation::Camera;
use truepose_errormodel::{AnyEffect, Dataset, FittedModel, Installed, SessionRules, Surroundings};
use truepose_identify::{
    CrossValidation, Fit, FitOptions, Folds, Identification, IdentifyError, LandmarkFold, Method, Residuals,
    SensorFound, Split, Suspect, Touched, allowed_for, cross_validate, landmark_cross_validation,
    landmark_groups, leverages, suspects, touched, unify,
};
use truepose_io::{CsvInfo, RobotDetails};
use truepose_kinematics::Chain;
use truepose_report::{
    DataCheck, DiscoverySummary, IdentificationSummary, KindsSummary, LandmarksSummary, SessionSummary,
    SuspectSummary, session_summaries,
};
use truepose_solvers::Solver;

/// A solver and the options of a fit.
pub type Fitting<'a> = (&'a dyn Solver, &'a FitOptions);

/// What a fit was made from, beside robot, effects and rows.
#[derive(Debug, Clone)]
pub struct Source {
    /// Units, frames and the head of certificates of the robot's description.
    pub details: RobotDetails,
    /// What the table has besides its rows.
    pub info: Arc<CsvInfo>,
    /// What the description leaves open and is found from the data, in words.
    pub assumed: Vec<String>,
    /// What seems wrong with the rows, and which are left out.
    pub check: DataCheck,
}

impl Source {
    /// Records units, frames and columns in a fit, for files of the same robot.
    pub(crate) fn record(&self, fitted: &mut FittedModel) {
        parameters::record_details(fitted, &self.details);
        record_columns(fitted, &self.info.map);
    }
}

/// Robot, effects and rows of a fit, in the measurement frame of the first installation.
#[derive(Debug)]
pub struct Campaign {
    /// The robot.
    pub chain: Chain,
    /// The declared effects, and those of sessions, landmarks and sensors.
    pub effects: Vec<Box<dyn AnyEffect>>,
    /// The rows.
    pub data: Arc<Dataset>,
    /// The installations; none where it is one.
    installed: Vec<Installed>,
    /// RMS of each placement with the nominal arm, m.
    placed: Vec<Option<f64>>,
    /// Landmarks that were touched.
    touched: Option<Touched>,
    /// The same before landmarks and sensors were found.
    read: Option<Box<AsRead>>,
    /// What a user should know of sessions, landmarks and repeated rows.
    pub remarks: Vec<String>,
}

/// Rows at landmarks as they were read, and what is declared of them.
#[derive(Debug)]
struct AsRead {
    chain: Chain,
    effects: Vec<Box<dyn AnyEffect>>,
    data: Dataset,
    surroundings: Surroundings,
}

impl AsRead {
    /// With landmarks and sensors where they are found.
    fn found(self, (solver, options): Fitting<'_>) -> Result<Campaign, IdentifyError> {
        let AsRead { chain, effects, data, surroundings } = &self;
        let found = touched(chain, effects, data, surroundings, (solver, options))?;
        Ok(Campaign {
            chain: found.chain.clone(),
            effects: found.effects.clone(),
            data: Arc::new(found.data.clone()),
            installed: Vec::new(),
            placed: Vec::new(),
            remarks: found.remarks.clone(),
            touched: Some(found),
            read: Some(Box::new(self)),
        })
    }
}

impl Campaign {
    /// Of what was read: base and tool that the description leaves open are unknown, sessions are placed, landmarks found, and mistakes looked
    /// for. Rows in which one mistake is known are left out, unless `all_rows`; gravity that is not declared is that which the rows support.
    ///
    /// # Errors
    /// When sessions or landmarks cannot be placed, landmarks are not declared as they were used, or rows that are read as one point are several.
    pub fn new(inputs: Inputs, fit: Fitting<'_>, all_rows: bool) -> Result<(Self, Source), WorkflowError> {
        let Inputs { chain, details, beside, undeclared, effects, data, info } = inputs;
        let opened = undeclared.unknown(&chain, &data)?;
        let (chain, assumed) =
            opened.map_or_else(|| (chain, Vec::new()), |(chain, words)| (chain, vec![words]));
        let mut made = Campaign::of(beside, chain, effects, data, &info, fit)?;
        made.remarks.extend(points::one_point(&made.chain, &made.data, &info)?);
        let mistakes = Mistakes::of(&made.chain, &made.data, &info.file);
        // Sessions and landmarks are used as they are.
        let (kept, mut check) = match all_rows || made.read.is_some() || !made.installed.is_empty() {
            true => (None, mistakes.check()),
            false => mistakes.set_aside(&made.data),
        };
        made.data = kept.map_or(made.data, Arc::new);
        if !details.gravity && made.read.is_none() {
            let options = made.options(fit.1);
            let found = vertical::settled(&made.chain, &made.effects, &made.data, (fit.0, &options))?;
            if let Some((chain, words)) = found {
                made.chain = chain;
                check.suspected.push(words);
            }
        }
        Ok((made, Source { details, info, assumed, check }))
    }

    /// Of rows, with what sessions share, and what is known of landmarks.
    fn of(
        (rules, surroundings): (SessionRules, Surroundings),
        chain: Chain,
        effects: Vec<Box<dyn AnyEffect>>,
        data: Arc<Dataset>,
        info: &CsvInfo,
        fit: Fitting<'_>,
    ) -> Result<Self, WorkflowError> {
        let file: &Path = &info.file;
        let about = |error: IdentifyError| WorkflowError::about(file, error);
        if !info.landmarks.is_empty() {
            if info.sessions.len() > 1 {
                let words = "landmarks and several sessions in one table are not read: a socket does not move with an instrument";
                return Err(WorkflowError::Input(format!("{}: {words}", file.display())));
            }
            let mut data = Arc::unwrap_or_clone(data);
            let surroundings = declared(surroundings, file, &chain, &mut data, info)?;
            return AsRead { chain, effects, data, surroundings }.found(fit).map_err(about);
        }
        if info.sessions.len() < 2 {
            let (installed, placed, remarks) = (Vec::new(), Vec::new(), Vec::new());
            return Ok(Campaign {
                chain,
                effects,
                data,
                installed,
                placed,
                touched: None,
                read: None,
                remarks,
            });
        }
        let found = unify(&chain, &data, &info.sessions, rules).map_err(about)?;
        let mut effects = effects;
        effects.extend(found.effects);
        let placed = found.placed.iter().map(|session| session.rms).collect();
        let (chain, data) = (found.chain, Arc::new(found.data));
        let (installed, remarks) = (found.installed, found.remarks);
        Ok(Campaign { chain, effects, data, installed, placed, touched: None, read: None, remarks })
    }

    /// The same with a suspicion allowed for; none where that cannot be declared.
    fn allowing(&self, suspect: &Suspect, fit: Fitting<'_>) -> Option<Result<Campaign, IdentifyError>> {
        let (found, read) = (self.touched.as_ref()?, self.read.as_ref()?);
        let (data, surroundings) = allowed_for(suspect, found, &read.data, &read.surroundings)?;
        let (chain, effects) = (read.chain.clone(), read.effects.clone());
        Some(AsRead { chain, effects, data, surroundings }.found(fit))
    }

    /// What its rows are to be fitted with.
    pub fn options(&self, options: &FitOptions) -> FitOptions {
        self.touched.as_ref().map_or_else(|| options.clone(), |found| found.options(options))
    }

    /// Refuses a test set of an identification whose landmarks are left out as a whole.
    pub fn without_test_set(&self, holdout: Option<f64>) -> Result<(), WorkflowError> {
        if holdout.is_some() && landmark_groups(&self.effects).is_some() {
            let words = "rows that share a landmark are left out together, one landmark after the other, so that no test set is drawn from them; leave it out";
            return Err(WorkflowError::option("holdout", words));
        }
        Ok(())
    }

    /// What an identification says of sessions, landmarks and kinds of observation.
    pub fn identified(
        &self,
        mut summary: IdentificationSummary,
        found: &Identification,
    ) -> Result<IdentificationSummary, WorkflowError> {
        let held_out = found.declared.held_out.as_ref().filter(|_| found.test_set.is_none());
        let held_out = held_out.map(|cv| &cv.residuals);
        summary.sessions = self.sessions(&found.fit.fitted, held_out)?;
        let mut landmarks = self.landmarks(&found.fit.fitted, held_out, &found.landmark_folds)?;
        let before = Some(&found.frames_only.train);
        let whole = landmark_groups(&self.effects).is_some();
        let mut kinds = self.kinds(&found.fit, before, held_out)?;
        self.suspected(&found.fit, landmarks.as_mut(), kinds.as_mut())?;
        summary = summary.with_landmarks(landmarks);
        Ok(summary.with_kinds(kinds, whole))
    }

    /// What a discovery says of the same.
    pub fn discovered(
        &self,
        summary: &mut DiscoverySummary,
        found: &Diagnosis,
        of_fit: Fitting<'_>,
    ) -> Result<(), WorkflowError> {
        summary.sessions = self.sessions(&found.fit.fitted, None)?;
        let mut left_out = None;
        let groups = landmark_groups(&self.effects);
        if groups.is_some() || self.touched.as_ref().is_some_and(|found| !found.contacts.is_empty()) {
            let judged = match groups {
                Some(groups) => landmark_cross_validation(&found.fit, &found.data, &groups, of_fit)?,
                None => contacts_left_out(found, of_fit.0)?.map(|of| (of, Vec::new())),
            };
            let (held_out, folds) =
                judged.map_or((None, Vec::new()), |(of, folds)| (Some(of.residuals), folds));
            summary.landmarks = self.landmarks(&found.fit.fitted, held_out.as_ref(), &folds)?;
            left_out = held_out;
        }
        let left_out = left_out.unwrap_or_else(|| among_all(found, self.data.len()));
        summary.kinds = self.kinds(&found.fit, None, Some(&left_out))?;
        self.suspected(&found.fit, summary.landmarks.as_mut(), summary.kinds.as_mut())
    }

    /// A fit as it is used: it knows its sessions; landmarks and the order of the record are no part of it.
    pub fn used(&self, fitted: &FittedModel) -> Result<FittedModel, WorkflowError> {
        let mut used = fitted.without_order()?.without_landmarks()?.without_seen()?;
        used.sessions.clone_from(&self.installed);
        if let (Some(found), Some(moved)) = (&self.touched, fitted.landmarks_displaced()) {
            let at = found.positions.iter().zip(moved).map(|(at, by)| <[f64; 3]>::from(at + by));
            let places = found.names.iter().zip(at).map(|(name, at)| (name.clone(), serde_json::json!(at)));
            used.provenance.insert("landmarks_m".into(), serde_json::Value::Object(places.collect()));
        }
        let sensors = self.touched.iter().flat_map(|found| &found.sensors);
        let cameras: serde_json::Map<_, _> = sensors.filter_map(camera_place).collect();
        if !cameras.is_empty() {
            used.provenance.insert("cameras".into(), serde_json::Value::Object(cameras));
        }
        Ok(used)
    }

    /// Each session on its own: none where it is one. The fit is in the frame of the first.
    fn sessions(
        &self,
        fitted: &FittedModel,
        held_out: Option<&Residuals>,
    ) -> Result<Vec<SessionSummary>, WorkflowError> {
        if self.installed.is_empty() {
            return Ok(Vec::new());
        }
        let residuals = Residuals::of(fitted, &self.data)?;
        let names: Vec<&str> = self.installed.iter().map(|session| session.name.as_str()).collect();
        Ok(session_summaries(&names, &self.placed, &self.data, &residuals, held_out))
    }

    /// What is wrong with a landmark or a sensor, each where it is reported.
    fn suspected(
        &self,
        fit: &Fit,
        landmarks: Option<&mut LandmarksSummary>,
        kinds: Option<&mut KindsSummary>,
    ) -> Result<(), WorkflowError> {
        let Some(found) = &self.touched else { return Ok(()) };
        let all = suspects(fit, &self.data, found)?;
        let of = |suspect: &&Suspect| found.sensors.iter().find(|sensor| sensor.name == suspect.name);
        if let Some(landmarks) = landmarks {
            let own = all.iter().filter(|suspect| of(suspect).is_none());
            landmarks.suspects = own.map(|suspect| SuspectSummary::new(suspect, &self.data, false)).collect();
        }
        if let Some(kinds) = kinds {
            let own = all.iter().filter_map(|suspect| Some((suspect, of(&suspect)?)));
            let pixels = |sensor: &SensorFound| sensor.observation.unit() == "px";
            let summary = |(suspect, sensor)| SuspectSummary::new(suspect, &self.data, pixels(sensor));
            kinds.suspects = own.map(summary).collect();
        }
        Ok(())
    }

    /// Spread at each landmark and known distances: none without landmarks that were touched.
    fn landmarks(
        &self,
        fitted: &FittedModel,
        held_out: Option<&Residuals>,
        folds: &[LandmarkFold],
    ) -> Result<Option<LandmarksSummary>, WorkflowError> {
        let Some(found) =
            self.touched.as_ref().filter(|found| !found.names.is_empty() || !found.contacts.is_empty())
        else {
            return Ok(None);
        };
        let residuals = Residuals::of(fitted, &self.data)?;
        let moved = fitted.landmarks_displaced().unwrap_or_default();
        Ok(Some(LandmarksSummary::new(found, &moved, &self.data, (&residuals, held_out), folds)))
    }

    /// What each kind of observation leaves; none where no row measured a single number. `before` are residuals with the installation alone.
    fn kinds(
        &self,
        fit: &Fit,
        before: Option<&Residuals>,
        held_out: Option<&Residuals>,
    ) -> Result<Option<KindsSummary>, WorkflowError> {
        let Some(found) = self.touched.as_ref().filter(|found| !found.sensors.is_empty()) else {
            return Ok(None);
        };
        let residuals = Residuals::of(&fit.fitted, &self.data)?;
        let moved = fit.fitted.sensors_moved().unwrap_or_default();
        let uncertain = fit.fitted.sensors_uncertain().unwrap_or_default();
        let shares = leverages(fit, &self.data)?;
        let unknowns = (moved.as_slice(), uncertain.as_slice());
        Ok(Some(KindsSummary::new(found, unknowns, &self.data, (before, &residuals, held_out), &shares)))
    }
}

/// The name of a camera, and where it was found.
fn camera_place(found: &SensorFound) -> Option<(String, serde_json::Value)> {
    let camera = (&*found.observation as &dyn Any).downcast_ref::<Camera>()?;
    let place = camera.place?;
    let xyz: [f64; 3] = place.translation.into();
    Some((found.name.clone(), serde_json::json!({"xyz_m": xyz, "rpy_rad": place.rpy()})))
}

/// Contacts, which are rows like any other, in folds; none of too few.
fn contacts_left_out(
    found: &Diagnosis,
    solver: &dyn Solver,
) -> Result<Option<CrossValidation>, WorkflowError> {
    /// As in an identification.
    const FOLDS: usize = 10;
    let Ok(folds) = Folds::new(&found.data, &Split::Random { folds: FOLDS, seed: 0 }) else {
        return Ok(None);
    };
    Ok(Some(cross_validate(&found.fit, &found.data, &folds, solver, Method::Auto)?))
}
