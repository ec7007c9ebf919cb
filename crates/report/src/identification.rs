//! The result of an identification: one summary, shown as text or as JSON.

mod limit;
mod nonlinear_parameter;
mod text;

pub use nonlinear_parameter::NonlinearParameterSummary;

use self::limit::limit;
use crate::largest::{LargestError, largest_errors};
use crate::{
    DataCheck, LandmarksSummary, OrientationStatistics, ParameterSummary, PositionStatistics, advice_text,
    warning_text,
};
use serde::Serialize;
use truepose_errormodel::{Dataset, Visits, configurations};
use truepose_identify::reduction::{Cause, group_words};
use truepose_identify::{Identification, LackOfFit, Observability, Repeats, Residuals, Stage};

/// Pose measurements with the largest errors that are listed.
const MOST_LARGEST: usize = 8;

/// Everything that is shown of an identification.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IdentificationSummary {
    /// Whether the fit converged; where it did not, no other figure here is final.
    pub converged: bool,
    /// Iterations of the fit.
    pub rounds: usize,
    /// Name of the robot.
    pub robot: String,
    /// Rows of data.
    pub rows: usize,
    /// Pose measurements.
    pub visits: usize,
    /// Different pairs of joint values and load.
    pub configurations: usize,
    /// The solver, as it is chosen on the command line.
    pub solver: String,
    /// Base, tool and target frames that were estimated; absent when all are known.
    pub placement: Option<PlacementSummary>,
    /// Errors of the robot as described, of its frames alone, and of the declared model, in this order.
    pub stages: Vec<StageSummary>,
    /// How the folds of the cross-validation were made.
    pub held_out_by: Option<String>,
    /// Held-out RMS of the declared model for each repetition of a random split, mm.
    pub repeated_rms_mm: Vec<f64>,
    /// Residuals of the declared model by axis x, y, z: mean is signed.
    pub axes: Vec<PositionStatistics>,
    /// Residuals of the declared model by target.
    pub targets: Vec<(String, PositionStatistics)>,
    /// Noise standard deviations.
    pub noise: NoiseSummary,
    /// Unknowns before the reduction.
    pub unknowns: usize,
    /// Grouped errors.
    pub rank: usize,
    /// Dropped columns that are not identifiable from any data of this kind on this robot.
    pub structural: usize,
    /// Dropped columns that this data does not excite.
    pub unexcited: usize,
    /// Directions whose posterior standard deviation exceeds the prior standard deviation.
    pub weak_directions: usize,
    /// Gap of the singular values where the structural rank was cut, and where the rank of the data was cut; null when
    /// nothing was cut or what was cut is exactly zero.
    pub gaps: [Option<f64>; 2],
    /// Scale factor of the prior standard deviations; null without a prior.
    pub prior: Option<f64>,
    /// The grouped errors.
    pub groups: Vec<GroupSummary>,
    /// Nonlinear parameters that were estimated within a range.
    #[serde(rename = "shapes")]
    pub nonlinear_parameters: Vec<NonlinearParameterSummary>,
    /// Motions that would make more directions identifiable.
    pub advice: Vec<String>,
    /// Observability indices.
    pub observability: Observability,
    /// Repeatability (pure error) from repeated pose measurements; null without repeats.
    pub repeats: Option<RepeatsSummary>,
    /// Position error as found, after the best base and tool, and calibrated, in a sentence.
    pub verdict: String,
    /// What limits the accuracy, in sentences.
    pub limit: String,
    /// The pose measurements with the largest errors; held-out errors where there are any.
    pub worst: Vec<LargestError>,
    /// Warnings.
    pub warnings: Vec<String>,
    /// What the run assumed of the installation, in sentences.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub assumed: Vec<String>,
    /// What seems wrong with the data; it stands first.
    #[serde(skip_serializing_if = "DataCheck::is_empty")]
    pub data_check: DataCheck,
    /// Which components of the position were measured, where some were not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub partial_rows: Option<crate::PartialRows>,
    /// Conformity of held-out poses with a specification, where one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub specification: Option<crate::SpecificationLines>,
    /// Each session of a campaign of several.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sessions: Vec<crate::SessionSummary>,
    /// Spread at landmarks, where some were touched.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub landmarks: Option<crate::LandmarksSummary>,
    /// Each kind of observation, where rows measured single numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kinds: Option<crate::KindsSummary>,
    /// Uncertainty budget of one measured position about its prediction.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub budget: Option<crate::BudgetSummary>,
    /// The fitted robot in the numbers of its own description, where they were worked out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parameters: Option<crate::ParametersSummary>,
}

/// Estimated base, tool and target frames.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlacementSummary {
    /// The frames that were estimated.
    pub found: Vec<String>,
    /// RMS of the 3-D position error with the nominal arm, mm.
    pub rms_mm: f64,
    /// What the data does not determine, and what would.
    pub undetermined: Vec<String>,
    /// Where they are, in the units of the robot file; the JSON has it among the parameters.
    #[serde(skip)]
    pub places: Vec<ParameterSummary>,
}

/// Repeatability from repeated pose measurements.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RepeatsSummary {
    /// Configurations that were measured more than once.
    pub groups: usize,
    /// Effective degrees of freedom of the pure error.
    pub freedom: usize,
    /// 3-D RMS of one row around its expectation, mm.
    pub rms_mm: f64,
    /// Whether all repeats of a configuration came with the same directions of approach.
    pub one_sided: bool,
    /// Lack of fit of the model; null where it has no degrees of freedom.
    pub lack_of_fit: Option<LackOfFit>,
}

impl RepeatsSummary {
    fn new(repeats: &Repeats) -> Self {
        RepeatsSummary {
            groups: repeats.groups,
            freedom: repeats.freedom,
            rms_mm: 1e3 * repeats.rms,
            one_sided: repeats.one_sided,
            lack_of_fit: repeats.lack_of_fit,
        }
    }
}

/// Errors before, between and after.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageSummary {
    /// `as described`, `base and tool`, `declared model`.
    pub name: String,
    /// On the data of the fit.
    pub train: PositionStatistics,
    /// Cross-validated: each fold predicted by a fit without it.
    pub held_out: Option<PositionStatistics>,
    /// On the held-out test set (`--holdout`).
    #[serde(rename = "locked")]
    pub test_set: Option<PositionStatistics>,
    /// Orientation, on the data of the fit.
    pub train_rotation: Option<OrientationStatistics>,
    /// Orientation, cross-validated.
    pub held_out_rotation: Option<OrientationStatistics>,
}

/// Noise standard deviations of the measurements.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseSummary {
    /// Standard deviation of a position's component, on top of what the instrument states, mm.
    pub position_sd_mm: f64,
    /// Whether the instrument states standard deviations.
    pub stated: bool,
    /// Standard deviation shared by the rows of a pose measurement (repeatability), per component, mm.
    pub visit_sd_mm: f64,
    /// Standard deviation of an orientation's component, mrad; null where none was measured.
    pub orientation_sd_mrad: Option<f64>,
}

/// One grouped error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GroupSummary {
    /// Name of the group and its members.
    pub words: String,
    /// Value in SI units.
    pub value: f64,
    /// Half width of its 95 % interval.
    pub half_width: f64,
    /// SI unit.
    pub unit: String,
    /// Posterior standard deviation divided by the prior standard deviation.
    #[serde(rename = "against_expected")]
    pub ratio_to_prior: f64,
}

/// The grouped errors of a fit.
pub(crate) fn groups(fit: &truepose_identify::Fit) -> Vec<GroupSummary> {
    let model = fit.fitted.model();
    let half = fit.half_widths();
    let group = |group: &truepose_identify::reduction::Group| {
        let column = &model.columns()[group.column];
        let variance = fit.fitted.covariance()[(group.column, group.column)];
        let (words, sign) = group_words(model, group);
        GroupSummary {
            words,
            value: sign * fit.fitted.coefficients()[group.column],
            half_width: half[group.column],
            unit: column.unit.clone(),
            ratio_to_prior: variance.max(0.0).sqrt() / column.scale,
        }
    };
    fit.reduction.groups.iter().map(group).collect()
}

impl IdentificationSummary {
    /// Summary of an identification; `labels` are the numbers of the pose measurements in the file, `solver` its text.
    pub fn new(
        found: &Identification,
        data: &Dataset,
        labels: &[i64],
        solver: &str,
        held_out_by: Option<String>,
    ) -> Self {
        let chain = &found.placement.chain;
        let fit = &found.fit;
        let model = fit.fitted.model();
        let groups = groups(fit);
        let dropped = |cause: Cause| fit.reduction.dropped.iter().filter(|d| d.cause == cause).count();
        let gap = |g: f64| g.is_finite().then_some(g);
        let residuals = &found.declared.train;
        // With a held-out test set the last fit uses all rows, the stages only the training part.
        let targets = if residuals.position.len() == data.len() {
            by_target(residuals, data, chain)
        } else {
            Vec::new()
        };
        let visits = Visits::of(data);
        let oriented = data.orientation.iter().any(Option::is_some);
        let summary = IdentificationSummary {
            robot: chain.name().into(),
            rows: data.len(),
            visits: visits.len(),
            configurations: configurations(data).iter().max().map_or(0, |last| last + 1),
            solver: solver.into(),
            placement: placement(found),
            stages: stages(found),
            held_out_by,
            repeated_rms_mm: found.repeated.iter().map(|r| r * 1e3).collect(),
            axes: (0..3).map(|axis| residuals.axis(axis).into()).collect(),
            targets,
            noise: NoiseSummary {
                position_sd_mm: fit.noise.position_sd * 1e3,
                stated: data.position_sd.iter().flatten().any(|v| !v.is_nan()),
                visit_sd_mm: fit.noise.visit_sd * 1e3,
                orientation_sd_mrad: oriented.then_some(fit.noise.orientation_sd * 1e3),
            },
            unknowns: model.columns().len(),
            rank: fit.reduction.rank(),
            structural: dropped(Cause::Structural),
            unexcited: dropped(Cause::Unexcited),
            weak_directions: found.excitation.weak_directions,
            gaps: [gap(fit.reduction.structural.gap), gap(fit.reduction.practical.gap)],
            prior: gap(fit.prior.kappa),
            groups,
            nonlinear_parameters: NonlinearParameterSummary::all(fit),
            advice: found.excitation.advice.iter().take(4).map(|a| advice_text(chain, a)).collect(),
            observability: found.observability.clone(),
            repeats: found.repeats.as_ref().map(RepeatsSummary::new),
            limit: String::new(),
            verdict: String::new(),
            worst: largest_errors(found, data, labels, MOST_LARGEST),
            warnings: fit.warnings.iter().map(warning_text).collect(),
            assumed: Vec::new(),
            data_check: DataCheck::default(),
            partial_rows: crate::PartialRows::of(data),
            rounds: fit.rounds,
            converged: fit.converged,
            specification: None,
            sessions: Vec::new(),
            landmarks: None,
            kinds: None,
            budget: crate::BudgetSummary::of_identification(found, data).ok(),
            parameters: None,
        };
        let summary = IdentificationSummary { limit: limit(&summary), ..summary };
        IdentificationSummary { verdict: summary.sentence(), ..summary }
    }
}

impl IdentificationSummary {
    /// With what seems wrong with the data.
    #[must_use]
    pub fn with_data_check(self, data_check: DataCheck) -> Self {
        let mut summary = IdentificationSummary { data_check, ..self };
        let check = &summary.data_check;
        summary.worst.iter_mut().for_each(|worst| worst.row = check.row_of_all(worst.row));
        IdentificationSummary { limit: limit(&summary), ..summary }
    }

    /// With what was found at landmarks: then errors are spreads, and the verdict says so.
    #[must_use]
    pub fn with_landmarks(self, landmarks: Option<crate::LandmarksSummary>) -> Self {
        if landmarks.is_none() {
            return self;
        }
        let mut summary = IdentificationSummary { landmarks, ..self };
        let places = summary.landmarks.as_ref().is_some_and(LandmarksSummary::has_places);
        if let Some(first) = summary.stages.first_mut().filter(|_| places) {
            first.name = "tool and landmarks".into();
        }
        if places && summary.held_out_by.is_some() {
            summary.held_out_by = Some("each group of landmarks in turn, judged about their own mean".into());
        }
        let verdict = summary.sentence();
        IdentificationSummary { verdict, ..summary }
    }
}

fn placement(found: &Identification) -> Option<PlacementSummary> {
    (!found.placement.found.is_empty()).then(|| PlacementSummary {
        found: found.placement.found.clone(),
        rms_mm: found.placement.rms * 1e3,
        undetermined: found
            .placement
            .undetermined
            .iter()
            .map(|u| format!("{} not determined: {}", u.what, u.advice))
            .collect(),
        places: Vec::new(),
    })
}

fn stages(found: &Identification) -> Vec<StageSummary> {
    let stage = |name: &str, stage: &Stage, test_set: Option<&Residuals>| StageSummary {
        name: name.into(),
        train: stage.train.positions().into(),
        held_out: stage.held_out.as_ref().map(|cv| cv.residuals.positions().into()),
        test_set: test_set.map(|r| r.positions().into()),
        train_rotation: rotation(&stage.train),
        held_out_rotation: stage.held_out.as_ref().and_then(|cv| rotation(&cv.residuals)),
    };
    let mut stages = Vec::new();
    if let Some(nominal) = &found.nominal {
        let plain = Stage { train: nominal.clone(), held_out: None };
        stages.push(stage("as described", &plain, None));
    }
    stages.push(stage(
        "base, tool, targets",
        &found.frames_only,
        found.test_set.as_ref().map(|test| &test.frames_only),
    ));
    let declared = if found.fit.converged { "declared model" } else { "declared model, NOT CONVERGED" };
    stages.push(stage(declared, &found.declared, found.test_set.as_ref().map(|test| &test.declared)));
    stages
}

fn rotation(residuals: &Residuals) -> Option<OrientationStatistics> {
    let spread = residuals.orientations();
    (spread.count > 0).then(|| spread.into())
}

fn by_target(
    residuals: &Residuals,
    data: &Dataset,
    chain: &truepose_kinematics::Chain,
) -> Vec<(String, PositionStatistics)> {
    if chain.described_targets().len() < 2 {
        return Vec::new();
    }
    let rows_of = |k: usize| -> Vec<usize> {
        (0..data.len()).filter(|&row| data.target[row].is_some_and(|t| t.0 == k)).collect()
    };
    (0..chain.described_targets().len())
        .map(|k| (chain.targets()[k].name.clone(), residuals.positions_of(&rows_of(k)).into()))
        .filter(|(_, spread): &(String, PositionStatistics)| spread.count > 0)
        .collect()
}
