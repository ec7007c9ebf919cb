//! What was measured, ready for a fit: rows of several installations in one frame, rows at landmarks where these were found.

use crate::failure::Failure;
use crate::terminal;
use std::any::Any;
use std::path::Path;
use truepose_discover::Diagnosis;
use truepose_errormodel::observation::{Camera, FRAMES, KINDS, Sphere, unknown};
use truepose_errormodel::{
    AnyEffect, Dataset, FittedModel, Installed, Landmark, RobotPoint, SessionRules, Surroundings,
};
use truepose_identify::{
    CrossValidation, Fit, FitOptions, Folds, Identification, LandmarkFold, Method, Residuals, SensorFound,
    Split, Suspect, Touched, cross_validate, landmark_cross_validation, landmark_groups, leverages, suspects,
    touched, unify,
};
use truepose_io::{CsvInfo, robot_sessions, robot_surroundings};
use truepose_kinematics::{Chain, TargetId, ToolId};
use truepose_report::{
    DiscoverySummary, IdentificationSummary, KindsSummary, LandmarksSummary, SessionSummary, SuspectSummary,
    session_summaries,
};
use truepose_solvers::Solver;

/// Rows, robot and effects of a fit.
#[derive(Debug)]
pub(crate) struct Campaign {
    pub chain: Chain,
    pub effects: Vec<Box<dyn AnyEffect>>,
    pub data: Dataset,
    /// The installations; none where it is one.
    installed: Vec<Installed>,
    /// RMS of each placement with the nominal arm, m.
    placed: Vec<Option<f64>>,
    /// Landmarks that were touched.
    touched: Option<Touched>,
    /// What a user should know of it.
    pub remarks: Vec<String>,
}

impl Campaign {
    /// Of what was read; `robot` is the file that may say what sessions share, and what is known of landmarks. Remarks are printed.
    pub fn read(
        (robot, file): (&Path, &Path),
        chain: Chain,
        effects: Vec<Box<dyn AnyEffect>>,
        data: Dataset,
        info: &CsvInfo,
        fit: (&dyn Solver, &FitOptions),
    ) -> Result<Self, Failure> {
        let surroundings = match info.landmarks.is_empty() {
            true => Surroundings::default(),
            false => robot_surroundings(robot)?,
        };
        let rules = if info.sessions.len() < 2 { SessionRules::default() } else { robot_sessions(robot)? };
        let made = Campaign::of((rules, surroundings), file, chain, effects, data, info, fit)?;
        terminal::warn(made.remarks.as_slice());
        Ok(made)
    }

    /// Of what was read, with what sessions share, and what is known of landmarks; `file` names the data in messages.
    pub fn of(
        (rules, surroundings): (SessionRules, Surroundings),
        file: &Path,
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
            let surroundings = declared(surroundings, file, &chain, &mut data, info)?;
            let found = touched(&chain, &effects, &data, &surroundings, fit).map_err(about)?;
            let (chain, effects, data) = (found.chain.clone(), found.effects.clone(), found.data.clone());
            let (installed, placed, remarks) = (Vec::new(), Vec::new(), found.remarks.clone());
            return Ok(Campaign { chain, effects, data, installed, placed, touched: Some(found), remarks });
        }
        if info.sessions.len() < 2 {
            let (installed, placed, remarks) = (Vec::new(), Vec::new(), Vec::new());
            return Ok(Campaign { chain, effects, data, installed, placed, touched: None, remarks });
        }
        let found = unify(&chain, &data, &info.sessions, rules).map_err(about)?;
        let mut effects = effects;
        effects.extend(found.effects);
        let placed = found.placed.iter().map(|session| session.rms).collect();
        let (chain, data, installed, remarks) = (found.chain, found.data, found.installed, found.remarks);
        Ok(Campaign { chain, effects, data, installed, placed, touched: None, remarks })
    }

    /// Refuses a test set of an identification whose landmarks are left out as a whole.
    pub fn without_test_set(&self, holdout: Option<f64>) -> Result<(), Failure> {
        if holdout.is_some() && landmark_groups(&self.effects).is_some() {
            let words = "--holdout: rows that share a landmark are left out together, one landmark after the other, so that no test set is drawn from them; leave out --holdout";
            return Err(Failure::Input(words.into()));
        }
        Ok(())
    }

    /// What an identification says of sessions, landmarks and kinds of observation.
    pub fn identified(
        &self,
        mut summary: IdentificationSummary,
        found: &Identification,
    ) -> Result<IdentificationSummary, Failure> {
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
        of_fit: (&dyn Solver, &FitOptions),
    ) -> Result<(), Failure> {
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
        summary.kinds = self.kinds(&found.fit, None, left_out.as_ref())?;
        self.suspected(&found.fit, summary.landmarks.as_mut(), summary.kinds.as_mut())
    }

    /// A fit as it is used: it knows its sessions; landmarks and the order of the record are no part of it.
    pub fn used(&self, fitted: &FittedModel) -> Result<FittedModel, Failure> {
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
    ) -> Result<Vec<SessionSummary>, Failure> {
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
    ) -> Result<(), Failure> {
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
    ) -> Result<Option<LandmarksSummary>, Failure> {
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
    ) -> Result<Option<KindsSummary>, Failure> {
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
fn contacts_left_out(found: &Diagnosis, solver: &dyn Solver) -> Result<Option<CrossValidation>, Failure> {
    /// As in an identification.
    const FOLDS: usize = 10;
    let Ok(folds) = Folds::new(&found.data, &Split::Random { folds: FOLDS, seed: 0 }) else {
        return Ok(None);
    };
    Ok(Some(cross_validate(&found.fit, &found.data, &folds, solver, Method::Auto)?))
}

/// What the robot file says of the landmarks of a table; where it names none, all of them are unknown. The rows count as it does.
pub(super) fn declared(
    mut known: Surroundings,
    file: &Path,
    chain: &Chain,
    data: &mut Dataset,
    info: &CsvInfo,
) -> Result<Surroundings, Failure> {
    let frames = |row: usize| data.kind(row).is_some_and(|kind| KINDS[kind] == FRAMES);
    let met = |k: usize| {
        let mut rows = (0..data.len()).filter(|&row| data.landmark(row) == Some(k)).peekable();
        rows.peek().is_some() && rows.all(frames)
    };
    if known.open || known.landmarks.is_empty() {
        let point = |name: &String| Landmark { name: name.clone(), ..Landmark::default() };
        let names = info.landmarks.iter().enumerate().filter(|(k, _)| !met(*k));
        let further = names.filter(|(_, name)| known.landmarks.iter().all(|known| known.name != **name));
        let further: Vec<Landmark> = further.map(|(_, name)| point(name)).collect();
        known.landmarks.extend(further);
    }
    let mut numbers = Vec::new();
    let mut meets = vec![None; data.len()];
    for (k, name) in info.landmarks.iter().enumerate() {
        let rows = (0..data.len()).filter(|&row| data.landmark(row) == Some(k));
        let first = rows.clone().next().unwrap_or(0);
        let refused = |row: usize, words: String| {
            let line = data.line.get(row).map_or(String::new(), |line| format!("{line}: "));
            Failure::Input(format!("{}:{line}{words}", file.display()))
        };
        if met(k) {
            let point = robot_point(chain, name).map_err(|words| refused(first, words))?;
            rows.for_each(|row| meets[row] = Some(point));
            numbers.push(None);
            continue;
        }
        let Some(number) = known.landmarks.iter().position(|landmark| landmark.name == *name) else {
            let names: Vec<&str> = known.landmarks.iter().map(|landmark| landmark.name.as_str()).collect();
            let words = format!(
                "the robot file has no landmark `{name}`; declare it in [[landmarks]] (its landmarks: {})",
                names.join(", ")
            );
            return Err(refused(first, words));
        };
        if rows.clone().next().is_none() && (0..data.len()).any(|row| data.point(row) == Some(k)) {
            numbers.push(Some(number));
            continue;
        }
        let word = |row: usize| data.kind(row).map_or("same_point", |kind| KINDS[kind]);
        let kind = word(first);
        if let Some(other) = rows.clone().find(|&row| word(row) != kind) {
            let words = format!(
                "landmark `{name}` is of kind `{}` here and of kind `{kind}` before; give each its own name",
                word(other)
            );
            return Err(refused(other, words));
        }
        let landmark = &mut known.landmarks[number];
        let described = landmark.observed.as_ref().map(|observed| observed.kind());
        match (data.kind(first), described) {
            (None, None) => {}
            // A ball may be touched as a point as well.
            (None, Some(Sphere::KIND)) => landmark.observed = None,
            (Some(_), Some(described)) if described == kind => {}
            (Some(number), None) => {
                landmark.observed = unknown(number, landmark.position, landmark.known);
                if landmark.observed.is_none() {
                    let words = format!(
                        "camera `{name}` has to be declared in [[cameras]] of the robot file, with fx, fy, cx, cy"
                    );
                    return Err(refused(first, words));
                }
            }
            (_, Some(described)) => {
                let words = format!(
                    "landmark `{name}` is a `{described}` in the robot file, and the row is of kind `{kind}`"
                );
                return Err(refused(first, words));
            }
        }
        let observed = landmark.observed.as_deref().map(|observed| observed as &dyn Any);
        if let Some(Camera { size: Some(size), .. }) = observed.and_then(|observed| observed.downcast_ref()) {
            for row in rows.clone() {
                for (which, limit) in size.iter().enumerate() {
                    let value = data.scalar(row, which).unwrap_or(0.0);
                    if !(0.0..=*limit).contains(&value) {
                        let column = ["u[px]", "v[px]"][which];
                        let words = format!(
                            "column `{column}`: {value} is outside of the image of camera `{name}` ({} × {} px)",
                            size[0], size[1]
                        );
                        return Err(refused(row, words));
                    }
                }
            }
        }
        numbers.push(Some(number));
    }
    let of_row: Vec<Option<usize>> =
        (0..data.len()).map(|row| data.landmark(row).and_then(|k| numbers[k])).collect();
    data.set_landmarks(Some(&of_row));
    if (0..data.len()).any(|row| data.point(row).is_some()) {
        let points: Vec<Option<usize>> =
            (0..data.len()).map(|row| data.point(row).and_then(|k| numbers[k])).collect();
        data.set_points(Some(&points));
    }
    if meets.iter().any(Option::is_some) {
        data.set_meets(Some(&meets));
    }
    Ok(known)
}

/// The target or the tool of a name.
fn robot_point(chain: &Chain, name: &str) -> Result<RobotPoint, String> {
    let target = chain.targets().iter().position(|target| target.name == *name);
    let tool = || chain.tools().iter().position(|tool| tool.name == *name);
    let point = target.map(|k| RobotPoint::Target(TargetId(k)));
    point.or_else(|| tool().map(|k| RobotPoint::Tool(ToolId(k)))).ok_or_else(|| {
        let targets = chain.targets().iter().map(|target| target.name.as_str());
        let all: Vec<&str> = targets.chain(chain.tools().iter().map(|tool| tool.name.as_str())).collect();
        format!(
            "`{name}` is no point of the robot: a row of kind `frames` names the target or tool that its own met, one of {}",
            all.join(", ")
        )
    })
}
