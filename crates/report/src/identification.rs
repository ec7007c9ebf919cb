//! What an identification found: one summary, shown as text or as JSON.

mod shape;
mod text;

pub use shape::ShapeSummary;

use crate::{PositionSpread, RotationSpread, advice_words, warning_words};
use serde::Serialize;
use truepose_errormodel::{Dataset, Visits, configurations};
use truepose_identify::reduction::{Cause, group_words};
use truepose_identify::{Identification, Observability, Repeats, Residuals, Stage};

/// Everything that is shown of an identification.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct IdentificationSummary {
    /// Whether the rounds of the fit came to rest; where they did not, no other number here is final.
    pub converged: bool,
    /// Rounds of the fit.
    pub rounds: usize,
    /// Name of the robot.
    pub robot: String,
    /// Rows of data.
    pub rows: usize,
    /// Standstills of the robot.
    pub visits: usize,
    /// Different pairs of joint values and load.
    pub configurations: usize,
    /// The solver, as it is chosen on the command line.
    pub solver: String,
    /// What was found of base, tool and targets; absent when all are known.
    pub placement: Option<PlacementSummary>,
    /// Errors of the robot as described, of its frames alone, and of the declared model, in this order.
    pub stages: Vec<StageSummary>,
    /// How the held-out columns were made.
    pub held_out_by: Option<String>,
    /// Held-out RMS of the declared model for each repetition of a random split, mm.
    pub repeated_rms_mm: Vec<f64>,
    /// Residuals of the declared model by axis x, y, z: mean is signed.
    pub axes: Vec<PositionSpread>,
    /// Residuals of the declared model by target.
    pub targets: Vec<(String, PositionSpread)>,
    /// How measurements scatter.
    pub noise: NoiseSummary,
    /// Unknowns before the reduction.
    pub unknowns: usize,
    /// Grouped errors.
    pub rank: usize,
    /// Of the dropped columns, those that no data on this robot with this kind of measurement can tell from others.
    pub structural: usize,
    /// Of the dropped columns, those that only more varied data would excite.
    pub unexcited: usize,
    /// Directions with a posterior standard deviation above the expected size.
    pub weak_directions: usize,
    /// Gap of the singular values where the structural rank was cut, and where the rank of the data was cut; null when
    /// nothing was cut or what was cut is exactly zero.
    pub gaps: [Option<f64>; 2],
    /// Width of the prior in expected sizes; null without one.
    pub prior: Option<f64>,
    /// The grouped errors.
    pub groups: Vec<GroupSummary>,
    /// Parameters in which effects are not linear, where they were looked for.
    pub shapes: Vec<ShapeSummary>,
    /// What would determine more.
    pub advice: Vec<String>,
    /// Observability indices.
    pub observability: Observability,
    /// Repeated visits.
    pub repeats: Option<Repeats>,
    /// What limits the accuracy, in a sentence.
    pub limit: String,
    /// The visits with the largest errors: number, row (from 1), distance in mm.
    pub worst: Vec<(String, usize, f64)>,
    /// What a user should know.
    pub warnings: Vec<String>,
    /// Poses that the judged fit did not see against a specification, where one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub specification: Option<crate::SpecificationSummary>,
}

/// Where base, tool and targets were found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PlacementSummary {
    /// What was looked for.
    pub found: Vec<String>,
    /// RMS of the 3-D distance that the placement alone leaves, mm.
    pub rms_mm: f64,
    /// What the data does not fix, and what would.
    pub undetermined: Vec<String>,
}

/// Errors before, between and after.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StageSummary {
    /// `as described`, `base and tool`, `declared model`.
    pub name: String,
    /// On the data of the fit.
    pub train: PositionSpread,
    /// On data that the fit did not see.
    pub held_out: Option<PositionSpread>,
    /// On the configurations that were locked away first.
    pub locked: Option<PositionSpread>,
    /// Orientation, on the data of the fit.
    pub train_rotation: Option<RotationSpread>,
    /// Orientation, on data that the fit did not see.
    pub held_out_rotation: Option<RotationSpread>,
}

/// How measurements scatter around the model.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct NoiseSummary {
    /// Standard deviation of a position's component, on top of what the instrument states, mm.
    pub position_sd_mm: f64,
    /// Whether the instrument states standard deviations.
    pub stated: bool,
    /// Standard deviation shared by the rows of a visit, per component, mm.
    pub visit_sd_mm: f64,
    /// Standard deviation of an orientation's component, mrad; null where none was measured.
    pub orientation_sd_mrad: Option<f64>,
}

/// One grouped error.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct GroupSummary {
    /// In words.
    pub words: String,
    /// Value in SI units.
    pub value: f64,
    /// Half width of its 95 % interval.
    pub half_width: f64,
    /// SI unit.
    pub unit: String,
    /// Standard deviation after the fit, over the expected size.
    pub against_expected: f64,
}

/// The grouped errors of a fit.
pub(crate) fn groups(fit: &truepose_identify::Fit) -> Vec<GroupSummary> {
    let model = fit.fitted.model();
    let half = fit.half_widths();
    let group = |group: &truepose_identify::reduction::Group| {
        let column = &model.columns()[group.column];
        let variance = fit.fitted.covariance()[(group.column, group.column)];
        GroupSummary {
            words: group_words(model, group),
            value: fit.fitted.coefficients()[group.column],
            half_width: half[group.column],
            unit: column.unit.clone(),
            against_expected: variance.max(0.0).sqrt() / column.scale,
        }
    };
    fit.reduction.groups.iter().map(group).collect()
}

impl IdentificationSummary {
    /// Of an identification; `labels` are the file's own numbers of the visits, `solver` its text.
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
        // With a locked hold-out the last fit saw all rows, the stages only the training part.
        let targets = if residuals.position.len() == data.len() {
            by_target(residuals, data, chain)
        } else {
            Vec::new()
        };
        let visits = Visits::of(data);
        let worst = fit
            .residuals
            .worst_visits(&visits, 5)
            .into_iter()
            .map(|(visit, row, d)| {
                let label = labels.get(visit).map_or_else(|| visit.to_string(), ToString::to_string);
                (label, row + 1, d * 1e3)
            })
            .collect();
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
            shapes: ShapeSummary::all(fit),
            advice: found.excitation.advice.iter().take(4).map(|a| advice_words(chain, a)).collect(),
            observability: found.observability.clone(),
            repeats: found.repeats.clone(),
            limit: String::new(),
            worst,
            warnings: fit.warnings.iter().map(warning_words).collect(),
            rounds: fit.rounds,
            converged: fit.converged,
            specification: None,
        };
        IdentificationSummary { limit: limit(&summary), ..summary }
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
    })
}

fn stages(found: &Identification) -> Vec<StageSummary> {
    let stage = |name: &str, stage: &Stage, locked: Option<&Residuals>| StageSummary {
        name: name.into(),
        train: stage.train.positions().into(),
        held_out: stage.held_out.as_ref().map(|cv| cv.residuals.positions().into()),
        locked: locked.map(|r| r.positions().into()),
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

fn rotation(residuals: &Residuals) -> Option<RotationSpread> {
    let spread = residuals.orientations();
    (spread.count > 0).then(|| spread.into())
}

fn by_target(
    residuals: &Residuals,
    data: &Dataset,
    chain: &truepose_kinematics::Chain,
) -> Vec<(String, PositionSpread)> {
    if chain.targets().len() < 2 {
        return Vec::new();
    }
    let rows_of = |k: usize| -> Vec<usize> {
        (0..data.len()).filter(|&row| data.target[row].is_some_and(|t| t.0 == k)).collect()
    };
    (0..chain.targets().len())
        .map(|k| (chain.targets()[k].name.clone(), residuals.positions_of(&rows_of(k)).into()))
        .filter(|(_, spread): &(String, PositionSpread)| spread.count > 0)
        .collect()
}

/// What limits the accuracy.
fn limit(summary: &IdentificationSummary) -> String {
    let Some(last) = summary.stages.last() else { return String::new() };
    let judged = last.locked.or(last.held_out).unwrap_or(last.train);
    if let Some(repeats) = &summary.repeats {
        let floor = repeats.rms * 1e3;
        let ratio = judged.rms_mm / floor.max(1e-12);
        let fits = repeats.lack_of_fit.is_none_or(|l| l.p_value > 0.05);
        return if fits || ratio < 1.1 {
            format!(
                "repeated visits scatter by {} mm (3-D RMS): the model is at the limit of the robot and the instrument",
                crate::significant(floor, 3)
            )
        } else {
            format!(
                "repeated visits scatter by {} mm (3-D RMS), the model misses by {} times as much: it lacks an effect",
                crate::significant(floor, 3),
                crate::significant(ratio, 2)
            )
        };
    }
    if summary.weak_directions > 0 && judged.rms_mm > 1.3 * last.train.rms_mm {
        return "the model fits its own data much better than data it did not see: measure more, and more varied, \
                configurations"
            .into();
    }
    "no configuration was visited twice, so that noise and missing effects cannot be told apart: repeat a few visits".into()
}
