//! The whole of an identification: placement, what the frames alone explain, the declared model, and how far to trust it.

use crate::{
    Answer, CrossValidation, Excitation, Fit, FitOptions, Folds, IdentifyError, LandmarkFold, Method,
    Observability, Placement, Repeats, Residuals, Split, Spread, Warning, against_plain, cross_validate,
    excitation, fit, hold_out, landmark_cross_validation, landmark_groups, observability, place, proceed,
    repeats,
};
use nalgebra::DMatrix;
use truepose_errormodel::effects::{Geometric, Landmarks, Observed, Session, Where};
use truepose_errormodel::{AnyEffect, Dataset, Effect, ErrorModel, FittedModel, Visits};
use truepose_kinematics::{Chain, FrameId};
use truepose_solvers::{PivotedQr, Solver};

/// What to do besides fitting.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentificationOptions {
    /// How to fit.
    pub fit: FitOptions,
    /// How to cross-validate; not at all when absent.
    pub split: Option<Split>,
    /// How often a random split is drawn again (with the following seeds); at least 1.
    pub repeats: usize,
    /// A share of the configurations that is drawn first, takes part in nothing and judges the result; the model is
    /// then fitted again on all rows with its structure frozen.
    pub holdout: Option<f64>,
    /// Seed of that draw.
    pub seed: u64,
}

impl Default for IdentificationOptions {
    fn default() -> Self {
        IdentificationOptions {
            fit: FitOptions::default(),
            split: Some(Split::Random { folds: 5, seed: 0 }),
            repeats: 1,
            holdout: None,
            seed: 0,
        }
    }
}

/// A model and its errors, on the data it was made from and on data that it did not see.
#[derive(Debug, Clone)]
pub struct Stage {
    /// Residuals on the data of the fit.
    pub train: Residuals,
    /// Cross-validated residuals.
    pub held_out: Option<CrossValidation>,
}

/// Rows that were drawn before anything else and took no part in the stages.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct TestSet {
    /// Rows of the data, ascending; the residuals are in their order.
    pub rows: Vec<usize>,
    /// Of the installation parameters (base, tool and target frames) alone.
    pub frames_only: Residuals,
    /// Of the declared model.
    pub declared: Residuals,
}

/// Everything that an identification found.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Identification {
    /// Where base, tool and targets were found, if they were looked for.
    pub placement: Placement,
    /// Residuals of the robot as described; none when its placement had to be found.
    pub nominal: Option<Residuals>,
    /// With errors of base and tool alone: what a good set-up of the instrument explains.
    pub frames_only: Stage,
    /// With the declared model.
    pub declared: Stage,
    /// Held-out RMS of the declared model for each repetition of a random split, m; the first is that of `declared`.
    pub repeated: Vec<f64>,
    /// The fit of the declared model.
    pub fit: Fit,
    /// The configurations that were held out first; none where all were used.
    pub test_set: Option<TestSet>,
    /// Pure error from repeated visits.
    pub repeats: Option<Repeats>,
    /// Where landmarks are by fits that have not seen them; empty without landmarks, or with one group of them.
    pub landmark_folds: Vec<LandmarkFold>,
    /// Observability indices of the data.
    pub observability: Observability,
    /// Directions that the data leaves weak, and which joints would help.
    pub excitation: Excitation,
}

/// Where an identification is, for a progress bar.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Step {
    /// Looking for base, tool and targets.
    Placing,
    /// Fitting the frames alone.
    FramesOnly,
    /// Fitting the declared model.
    Fitting,
    /// Cross-validating.
    Validating,
    /// Judging repeats, observability and excitation.
    Judging,
}

impl Step {
    /// All of them, in order.
    pub const ALL: [Step; 5] =
        [Step::Placing, Step::FramesOnly, Step::Fitting, Step::Validating, Step::Judging];
}

/// Identifies a robot from data: places it, fits what is declared, and judges the result.
///
/// `effects` are made for `chain`; they do not depend on where base, tool and targets are.
///
/// # Errors
/// When the model does not fit the data, nothing was measured, or a solver refuses; [`IdentifyError::Cancelled`] where `observer` ends the run.
pub fn identify<A: Answer>(
    chain: &Chain,
    effects: &[Box<dyn AnyEffect>],
    data: &Dataset,
    solver: &dyn Solver,
    options: &IdentificationOptions,
    observer: &dyn Fn(Step) -> A,
) -> Result<Identification, IdentifyError> {
    steps(chain, effects, data, solver, options, &|step| proceed(observer(step)))
}

fn steps(
    chain: &Chain,
    effects: &[Box<dyn AnyEffect>],
    data: &Dataset,
    solver: &dyn Solver,
    options: &IdentificationOptions,
    begin: &dyn Fn(Step) -> Result<(), IdentifyError>,
) -> Result<Identification, IdentifyError> {
    let (train_rows, held_rows) = match options.holdout {
        Some(share) => hold_out(data, share, options.seed)?,
        None => ((0..data.len()).collect(), Vec::new()),
    };
    let selected;
    let train = if held_rows.is_empty() {
        data
    } else {
        selected = data.select(&train_rows);
        &selected
    };
    begin(Step::Placing)?;
    let placement = place(chain, train)?.checked()?;
    let placed = &placement.chain;
    begin(Step::FramesOnly)?;
    let groups = landmark_groups(effects);
    let own = [Landmarks::FAMILY, Observed::FAMILY];
    let found_here = effects.iter().any(|effect| own.contains(&effect.kind()));
    let nominal = if placement.found.is_empty() && !found_here {
        Some(nominal_residuals(placed, train)?)
    } else {
        None
    };
    let frames_model = ErrorModel::new(placed.clone(), installation(placed, effects, train))?;
    let frames_fit = fit(&frames_model, train, solver, &options.fit)?;
    begin(Step::Fitting)?;
    let model = ErrorModel::new(placed.clone(), effects.to_vec())?;
    let mut declared_fit = fit(&model, train, solver, &options.fit)?;
    let model = declared_fit.fitted.model().clone();
    begin(Step::Validating)?;
    let folds = match &options.split {
        Some(split) => Some(Folds::new(train, split)?),
        None => None,
    };
    let mut landmark_folds = Vec::new();
    let mut validated = |fit: &Fit| match (&folds, &groups) {
        // Rows that share the place of a landmark are left out together.
        (Some(_), Some(groups)) => {
            let judged = landmark_cross_validation(fit, train, groups, (solver, &options.fit))?;
            Ok::<_, IdentifyError>(judged.map(|(held_out, places)| {
                landmark_folds = places;
                held_out
            }))
        }
        (Some(folds), None) => cross_validate(fit, train, folds, solver, Method::Auto).map(Some),
        (None, _) => Ok(None),
    };
    let frames_only = Stage { held_out: validated(&frames_fit)?, train: frames_fit.residuals.clone() };
    let mut held_out = validated(&declared_fit)?;
    let mut solver = solver;
    let plain = PivotedQr::default();
    if let Some((known, folds)) = held_out.as_ref().zip(folds.as_ref())
        && groups.is_none()
        && against_plain::asked(solver, &options.fit)
    {
        let simplest = against_plain::fitted(&model, train, &options.fit, folds)?;
        let ratio = against_plain::ratio(&simplest.1, known);
        if let Some(refused) = against_plain::judged(&mut declared_fit, solver, ratio, simplest.0) {
            declared_fit = refused;
            (held_out, solver) = (Some(simplest.1), &plain);
        }
    }
    let declared = Stage { held_out, train: declared_fit.residuals.clone() };
    let mut repeated: Vec<f64> = declared.held_out.iter().map(|cv| cv.residuals.positions().rms).collect();
    if let Some(Split::Random { folds, seed }) = options.split.clone().filter(|_| groups.is_none()) {
        for more in 1..options.repeats as u64 {
            let folds = Folds::new(train, &Split::Random { folds, seed: seed + more })?;
            let again = cross_validate(&declared_fit, train, &folds, solver, Method::Auto)?;
            repeated.push(again.residuals.positions().rms);
        }
    }
    begin(Step::Judging)?;
    let pure = repeats(&declared_fit, train);
    let excitation = excitation(&declared_fit, train)?;
    let observability = observability(&declared_fit, Visits::of(train).len())?;
    let mut test_set = None;
    if !held_rows.is_empty() {
        let held = data.select(&held_rows);
        test_set = Some(TestSet {
            rows: held_rows,
            frames_only: Residuals::of(&frames_fit.fitted, &held)?,
            declared: Residuals::of(&declared_fit.fitted, &held)?,
        });
        let frozen =
            crate::FitOptions { noise: crate::NoiseSource::Fixed(declared_fit.noise), ..options.fit.clone() };
        let (shapes, scatter) = (std::mem::take(&mut declared_fit.shapes), declared_fit.scatter);
        let told = std::mem::take(&mut declared_fit.warnings);
        declared_fit =
            crate::refit(&model, data, solver, &frozen, &declared_fit.reduction, &declared_fit.prior)?;
        let told = told
            .into_iter()
            .filter(|w| matches!(w, Warning::FellBack { .. } | Warning::WorseThanPlain { .. }));
        declared_fit.warnings.extend(told);
        (declared_fit.shapes, declared_fit.scatter) = (shapes, scatter);
    }
    Ok(Identification {
        placement,
        nominal,
        frames_only,
        declared,
        repeated,
        fit: declared_fit,
        test_set,
        repeats: pure,
        landmark_folds,
        observability,
        excitation,
    })
}

/// Position errors before anything of the arm is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AsFound {
    /// Of the robot as it is described, m; none where base, tool or targets were unknown.
    pub nominal: Option<Spread>,
    /// With the best base, tool and targets, m.
    pub installation: Spread,
}

/// Errors of a placed robot before anything of its arm is fitted.
///
/// # Errors
/// When the robot does not fit the data.
pub fn as_found(
    placement: &Placement,
    data: &Dataset,
    options: &FitOptions,
) -> Result<AsFound, IdentifyError> {
    let placed = &placement.chain;
    let nominal =
        if placement.found.is_empty() { Some(nominal_residuals(placed, data)?.positions()) } else { None };
    let model = ErrorModel::new(placed.clone(), vec![Box::new(frames_only(placed))])?;
    let installation = fit(&model, data, &PivotedQr::default(), options)?.residuals.positions();
    Ok(AsFound { nominal, installation })
}

/// Errors of the installation, and of the further ones that sessions have.
pub(crate) fn installation(
    placed: &Chain,
    effects: &[Box<dyn AnyEffect>],
    data: &Dataset,
) -> Vec<Box<dyn AnyEffect>> {
    let own = [Landmarks::FAMILY, Observed::FAMILY];
    let met = (0..data.len()).any(|row| data.meets(row).is_some());
    let touched = met || effects.iter().any(|effect| own.contains(&effect.kind()));
    let base = effects.iter().any(|effect| {
        let geometric = effect.concrete::<Geometric>();
        geometric
            .is_some_and(|of| of.frames.as_ref().is_none_or(|all| all.contains(&Where::Frame(FrameId::BASE))))
    });
    let mut own = frames_only(placed);
    if let Some(frames) = own.frames.as_mut().filter(|_| touched && !base) {
        // The base has no place.
        frames.retain(|place| *place != Where::Frame(FrameId::BASE));
    }
    let mut all: Vec<Box<dyn AnyEffect>> = vec![Box::new(own)];
    let of_installation = [Session::FAMILY, Landmarks::FAMILY, Observed::FAMILY];
    all.extend(effects.iter().filter(|effect| of_installation.contains(&effect.kind())).cloned());
    all
}

/// Errors of the base, the tool and the targets: what says where instrument and targets are, and nothing about the arm.
fn frames_only(chain: &Chain) -> Geometric {
    let ends = chain.frames().filter(|frame| *frame == FrameId::BASE || chain.tool_of(*frame).is_some());
    let mut frames: Vec<Where> = ends.map(Where::Frame).collect();
    if !chain.described_targets().is_empty() {
        frames.push(Where::Targets(truepose_errormodel::effects::AllTargets::All));
    }
    Geometric { frames: Some(frames), components: None }
}

pub(crate) fn nominal_residuals(chain: &Chain, data: &Dataset) -> Result<Residuals, IdentifyError> {
    let bare = ErrorModel::new(chain.clone(), Vec::new())?;
    Residuals::of(&FittedModel::new(bare, Vec::new(), DMatrix::zeros(0, 0))?, data)
}
