//! What `discover` found, as values that JSON and text share.

mod limits;
mod text;

pub use limits::{NoiseFloorSummary, TooFewPoses, WithdrawnSummary};

use crate::{PositionSpread, SpecificationSummary};
use serde::{Deserialize, Serialize};
use truepose_discover::{
    Alternative, Diagnosis, Errors, Evidence, Finding, Nested, Parameter, Place, Stop, Verdict,
};
use truepose_errormodel::{Dataset, Visits};

/// The ledger of a discovery: `discovery.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DiscoverySummary {
    /// The robot's name.
    pub robot: String,
    /// Rows, visits.
    pub rows: usize,
    /// Standstills of the robot.
    pub visits: usize,
    /// Rows (1-based) that were drawn out first and took part in nothing.
    pub holdout_rows: Vec<usize>,
    /// Expected 3-D RMS of one new row if the model were perfect, mm; none when nothing tells it.
    pub noise_floor_mm: Option<f64>,
    /// The same with its source and interval.
    pub noise_floor: NoiseFloorSummary,
    /// Whether the model is enough.
    pub verdict: Verdict,
    /// With the declared model.
    pub before: BothParts,
    /// With everything that was found.
    pub after: BothParts,
    /// Effects in the order in which they were added.
    pub effects: Vec<FindingSummary>,
    /// Candidates that won a contest and were not believed.
    pub refused: Vec<RefusedSummary>,
    /// Causes that this data cannot test.
    pub not_testable: Vec<UntestableSummary>,
    /// Lack of fit against repeats, before and after.
    pub lack_of_fit: LackOfFitSummary,
    /// What is left.
    pub unexplained: UnexplainedSummary,
    /// Findings that were withdrawn, since the declared model predicts unseen data better.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub withdrawn: Option<WithdrawnSummary>,
    /// Training poses and identifiable parameters of the declared model, where the former are fewer than three times the latter: too few to
    /// search with confidence.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub too_few_poses: Option<TooFewPoses>,
    /// Why the loop stopped.
    pub stopped: Stop,
    /// The loop itself, judged on every row by a run that did not see it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub nested: Option<NestedSummary>,
    /// Held-out poses against a specification, where one was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub specification: Option<SpecificationSummary>,
    /// Why the loop was ended before it came to its end, where it was: there may be more effects, rivals were not judged, and coefficients
    /// are those of the training part.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub incomplete: Option<String>,
    /// Seed, flips, level.
    pub settings: Settings,
}

/// The loop judged by whole runs with a fold left out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct NestedSummary {
    /// How the folds were made.
    pub folds: String,
    /// With the declared model.
    pub before: PositionSpread,
    /// With what each run found.
    pub after: PositionSpread,
    /// What each run found, in words.
    pub found: Vec<Vec<String>>,
    /// What each run left on the fold that it did not see.
    #[serde(default)]
    pub after_by_fold: Vec<PositionSpread>,
}

impl NestedSummary {
    /// Of nested runs.
    pub fn new(judged: &Nested, folds: String) -> Self {
        let words = |run: &Diagnosis| run.findings.iter().map(|f| f.candidate.words()).collect();
        NestedSummary {
            folds,
            before: judged.before.into(),
            after: judged.after.into(),
            found: judged.runs.iter().map(words).collect(),
            after_by_fold: judged.runs.iter().map(|run| run.after.holdout.positions().into()).collect(),
        }
    }
}

/// Errors on the training part and on the part that took part in nothing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BothParts {
    /// Training rows.
    pub train: PositionSpread,
    /// Held-out rows.
    pub holdout: PositionSpread,
    /// Training rows without those that are reported as outliers, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub train_without_outliers: Option<PositionSpread>,
    /// Held-out rows without those that are reported as outliers, where there are any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holdout_without_outliers: Option<PositionSpread>,
}

impl BothParts {
    /// Held-out rows that are judged: without those that are reported as outliers.
    pub fn judged(&self) -> PositionSpread {
        self.holdout_without_outliers.unwrap_or(self.holdout)
    }

    /// Training rows that are judged.
    pub fn judged_train(&self) -> PositionSpread {
        self.train_without_outliers.unwrap_or(self.train)
    }
}

/// One effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FindingSummary {
    /// Its family.
    pub family: String,
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// Period, rad or m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub period: Option<f64>,
    /// All its periods, rad or m.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub periods: Vec<f64>,
    /// Instant of a shift, s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<f64>,
    /// 1-based data rows of outliers or a wrong payload.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rows: Vec<usize>,
    /// Family-wise, from permutation.
    pub p_value: f64,
    /// Of the likelihood ratio.
    pub p_parametric: f64,
    /// On the held-out part.
    pub holdout_rms_mm: BeforeAfter,
    /// On the training part.
    pub train_rms_mm: BeforeAfter,
    /// Cross-validated when it was added.
    pub cross_validated_rms_mm: BeforeAfter,
    /// Share of half samples in which it is there.
    pub stability: f64,
    /// Sizes.
    pub parameters: Vec<Parameter>,
    /// Rivals.
    pub alternatives: Vec<AlternativeSummary>,
    /// In a sentence.
    pub meaning: String,
}

/// An error before and after.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BeforeAfter {
    /// Without the effect.
    pub before: f64,
    /// With it.
    pub after: f64,
}

/// A rival.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AlternativeSummary {
    /// Its family.
    pub family: String,
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// On the held-out part with it in place of the find.
    pub holdout_rms_mm: f64,
    /// How much less likely it makes the data.
    pub behind: f64,
    /// True when this data cannot tell it from the find.
    pub equivalent: bool,
}

/// A candidate that was not believed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RefusedSummary {
    /// Its family.
    pub family: String,
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// Why.
    pub reason: String,
    /// Family-wise, from permutation.
    pub p_value: f64,
    /// Cross-validated.
    pub cross_validated_rms_mm: BeforeAfter,
    /// Share of half samples in which it is there.
    pub stability: f64,
}

/// A cause that the data cannot test.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct UntestableSummary {
    /// Its family.
    pub family: String,
    /// Where.
    #[serde(flatten)]
    pub place: Place,
    /// Share of its effect that the declared model does not imitate.
    pub share: f64,
    /// 3-D RMS that it would need to be seen, mm; none when it does nothing here.
    pub detectable_rms_mm: Option<f64>,
}

/// Lack of fit against repeated visits.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct LackOfFitSummary {
    /// Against what residuals were judged.
    pub against: Reference,
    /// 3-D RMS of a repeat, mm.
    pub pure_error_mm: Option<f64>,
    /// p of the declared model.
    pub before: Option<f64>,
    /// p with everything that was found.
    pub after: Option<f64>,
}

/// What tells noise from structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reference {
    /// Repeated visits of configurations.
    Repeats,
    /// The scatter that is left, by sign flips of whole visits.
    SignFlips,
}

/// What is left.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct UnexplainedSummary {
    /// Whether it is more than noise.
    pub significant: bool,
    /// 3-D RMS beyond the repeatability limit, mm; none where no estimate of that is known.
    #[serde(default)]
    pub rms_mm: Option<f64>,
    /// Its share of the variance that the declared model left, with its sign; none where no estimate of the limit is known.
    pub share_of_variance: Option<f64>,
    /// Smallest family-wise p of the last screen.
    pub p_value: f64,
}

/// What makes a run what it is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Seed of every draw.
    pub seed: u64,
    /// Share that was held out.
    pub holdout: f64,
    /// Sign flips.
    pub flips: usize,
    /// Family-wise level.
    pub alpha: f64,
}

impl DiscoverySummary {
    /// Of a diagnosis.
    pub fn new(found: &Diagnosis, settings: Settings) -> Self {
        let repeats = found.repeats_before.as_ref();
        let p = |r: &Option<truepose_identify::Repeats>| {
            r.as_ref().and_then(|r| r.lack_of_fit.as_ref()).map(|l| l.p_value)
        };
        DiscoverySummary {
            robot: found.fit.fitted.chain().name().into(),
            rows: found.data.len(),
            visits: Visits::of(&found.data).len(),
            holdout_rows: found.holdout_rows.iter().map(|row| row + 1).collect(),
            noise_floor_mm: found.noise_floor.rms.map(|rms| 1e3 * rms),
            noise_floor: NoiseFloorSummary {
                rms_mm: found.noise_floor.rms.map(|rms| 1e3 * rms),
                source: found.noise_floor.source,
                ci95_mm: found.noise_floor.ci95.map(|ends| ends.map(|end| 1e3 * end)),
            },
            verdict: found.verdict,
            before: (&found.before).into(),
            after: (&found.after).into(),
            effects: found.findings.iter().map(FindingSummary::new).collect(),
            refused: found
                .refused
                .iter()
                .map(|r| RefusedSummary {
                    family: r.candidate.family.word().into(),
                    place: r.candidate.place.clone(),
                    reason: text::doubt_words(r.doubt).into(),
                    p_value: r.evidence.p_value,
                    cross_validated_rms_mm: cross_validated(&r.evidence),
                    stability: r.evidence.stability,
                })
                .collect(),
            not_testable: found
                .untestable
                .iter()
                .map(|u| UntestableSummary {
                    family: u.family.word().into(),
                    place: u.place.clone(),
                    share: u.share,
                    detectable_rms_mm: u.detectable.map(|d| d * 1e3),
                })
                .collect(),
            lack_of_fit: LackOfFitSummary {
                against: if repeats.is_some() { Reference::Repeats } else { Reference::SignFlips },
                pure_error_mm: repeats.map(|r| r.rms * 1e3),
                before: p(&found.repeats_before),
                after: p(&found.repeats_after),
            },
            unexplained: UnexplainedSummary {
                significant: found.unexplained.significant,
                rms_mm: found.unexplained.rms.map(|rms| 1e3 * rms),
                share_of_variance: found.unexplained.share_of_variance,
                p_value: found.unexplained.p_value,
            },
            withdrawn: found.withdrawn.as_ref().map(|w| WithdrawnSummary {
                check: w.check,
                declared_rms_mm: 1e3 * w.declared,
                enlarged_rms_mm: 1e3 * w.enlarged,
                findings: w.findings.iter().map(|(candidate, _)| candidate.words()).collect(),
            }),
            too_few_poses: TooFewPoses::of(found),
            stopped: found.stopped,
            nested: None,
            incomplete: None,
            specification: None,
            settings,
        }
    }
}

impl DiscoverySummary {
    /// With the held-out poses of `data`, as it was read, against a limit of the 3-D position error (m).
    pub fn against(mut self, limit: f64, found: &Diagnosis, data: &Dataset) -> Self {
        let worst = crate::worst_of_poses(data, &found.holdout_rows, &found.after.holdout);
        self.specification = Some(SpecificationSummary::new(limit, &worst));
        self
    }
}

impl From<&Errors> for BothParts {
    fn from(errors: &Errors) -> Self {
        let (train, holdout) = errors.spreads();
        let (good_train, good_holdout) = errors.spreads_without_outliers();
        let [out_train, out_holdout] = &errors.outliers;
        BothParts {
            train: train.into(),
            holdout: holdout.into(),
            train_without_outliers: (!out_train.is_empty()).then(|| good_train.into()),
            holdout_without_outliers: (!out_holdout.is_empty()).then(|| good_holdout.into()),
        }
    }
}

fn cross_validated(evidence: &Evidence) -> BeforeAfter {
    BeforeAfter { before: evidence.random.before * 1e3, after: evidence.random.after * 1e3 }
}

impl FindingSummary {
    fn new(finding: &Finding) -> Self {
        let candidate = &finding.candidate;
        let mm = |(before, after): (f64, f64)| BeforeAfter { before: before * 1e3, after: after * 1e3 };
        let parameter = |effect: &dyn truepose_errormodel::AnyEffect, key: &str| {
            effect.parameters().get(key).and_then(serde_json::Value::as_f64)
        };
        let mut periods = Vec::new();
        let mut at = None;
        for effect in candidate.effects() {
            if let Some(period) = parameter(&**effect, "period") {
                let listed = effect.parameters();
                let harmonics: Vec<f64> = listed
                    .get("harmonics")
                    .and_then(serde_json::Value::as_array)
                    .map(|list| list.iter().filter_map(serde_json::Value::as_f64).collect())
                    .unwrap_or_else(|| vec![1.0]);
                periods.extend(harmonics.iter().map(|h| period / h));
            }
            if effect.kind() == "shift" {
                at = at.or_else(|| parameter(&**effect, "at"));
            }
        }
        // The strongest wave, by the sizes of its sine and cosine.
        let strength = |k: usize| -> f64 {
            let part = |j: usize| finding.parameters.get(j).map_or(0.0, |p: &Parameter| p.value * p.value);
            part(2 * k) + part(2 * k + 1)
        };
        let complete = finding.parameters.len() == 2 * periods.len();
        let strongest = (0..periods.len())
            .max_by(|&a, &b| strength(a).total_cmp(&strength(b)))
            .filter(|_| complete)
            .unwrap_or(0);
        FindingSummary {
            family: candidate.family.word().into(),
            place: candidate.place.clone(),
            period: periods.get(strongest).copied(),
            periods: if periods.len() > 1 { periods } else { Vec::new() },
            at,
            rows: finding.rows.iter().map(|row| row + 1).collect(),
            p_value: finding.evidence.p_value,
            p_parametric: finding.evidence.p_parametric,
            holdout_rms_mm: mm(finding.holdout),
            train_rms_mm: mm(finding.train),
            cross_validated_rms_mm: cross_validated(&finding.evidence),
            stability: finding.evidence.stability,
            parameters: finding.shape.iter().chain(&finding.parameters).cloned().collect(),
            alternatives: finding.alternatives.iter().map(AlternativeSummary::from).collect(),
            meaning: text::meaning(finding),
        }
    }

    /// `backlash a1`.
    pub fn words(&self) -> String {
        format!("{} {}", self.family, self.place.words()).trim_end().to_owned()
    }
}

impl From<&Alternative> for AlternativeSummary {
    fn from(a: &Alternative) -> Self {
        AlternativeSummary {
            family: a.family.word().into(),
            place: a.place.clone(),
            holdout_rms_mm: a.holdout * 1e3,
            behind: a.behind,
            equivalent: a.equivalent,
        }
    }
}
