//! The findings of a discovery with their competing hypotheses.

use crate::significant;
use serde::{Deserialize, Serialize};
use truepose_discover::{Alternative, Evidence, Finding, Parameter, Place};
use truepose_errormodel::Dataset;

/// One finding: an effect that was added to the model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FindingSummary {
    /// Family of the effect.
    pub family: String,
    /// Where the effect acts.
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
    /// Lines of the file of these rows; empty of data from no file.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<u64>,
    /// 1-based data rows of each pose measurement that is an outlier as a whole; they are among `rows`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub poses: Vec<Vec<usize>>,
    /// Family-wise p-value of the effect's existence: rotation test, exact for normal errors.
    pub p_value: f64,
    /// The same as a single test by sign flips of whole poses, without the assumption of normal errors. Of outliers, which no search selects,
    /// this, the parametric p, the number of poses, the cross-validation and the selection frequency are not computed, and absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_sign_flips: Option<f64>,
    /// For an effect that reads a channel: p among surrogates of that channel (the same record moved in time).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_surrogates: Option<f64>,
    /// Number of poses on which the effect rests.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effective_poses: Option<f64>,
    /// Probability of its name (family and place), given that it exists.
    pub name_probability: f64,
    /// Probability that the library has no name for it.
    pub unnamed_probability: f64,
    /// Parametric p-value of the likelihood-ratio statistic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_parametric: Option<f64>,
    /// RMS on held-out rows, mm.
    pub holdout_rms_mm: BeforeAfter,
    /// RMS on the training part, mm.
    pub train_rms_mm: BeforeAfter,
    /// Cross-validated RMS at the time when the effect was added, mm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cross_validated_rms_mm: Option<BeforeAfter>,
    /// Selection frequency: fraction of half-samples in which the effect is selected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stability: Option<f64>,
    /// Nonlinear parameters and coefficients with their 95 % intervals.
    pub parameters: Vec<Parameter>,
    /// True when zero is in the interval of every coefficient: only all of them together are significant.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub only_jointly: bool,
    /// Competing hypotheses, the most likely first.
    pub alternatives: Vec<AlternativeSummary>,
    /// One sentence: what the effect is and where to inspect the robot.
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

/// A competing hypothesis.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AlternativeSummary {
    /// Family of the effect.
    pub family: String,
    /// Where the effect acts.
    #[serde(flatten)]
    pub place: Place,
    /// RMS on held-out rows with this hypothesis in place of the finding, mm.
    pub holdout_rms_mm: f64,
    /// Probability of its name, given that the effect exists.
    pub probability: f64,
    /// Penalised −2 ln L minus that of the finding: above 0, the data is less likely under this hypothesis.
    pub behind: f64,
    /// True when the hypothesis and the finding are not distinguishable with this data.
    pub equivalent: bool,
    /// True when it is the simplest of those that are not distinguishable, and simpler than the finding.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub simplest: bool,
}

/// Of a finding whose coefficients are significant only together.
pub(crate) const ONLY_JOINTLY: &str = "Each coefficient alone could be zero, since they are correlated with constants of the model or with each other: \
     the test of existence is of all of them together.";

impl FindingSummary {
    /// Of a finding in this data; without a time the numbers of pose measurements stand for it.
    pub(super) fn new(finding: &Finding, data: &Dataset) -> Self {
        let by_order = data.by_order;
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
        // The harmonic of largest amplitude.
        let power = |k: usize| -> f64 {
            let part = |j: usize| finding.parameters.get(j).map_or(0.0, |p: &Parameter| p.value * p.value);
            part(2 * k) + part(2 * k + 1)
        };
        let complete = finding.parameters.len() == 2 * periods.len();
        let strongest = (0..periods.len())
            .max_by(|&a, &b| power(a).total_cmp(&power(b)))
            .filter(|_| complete)
            .unwrap_or(0);
        FindingSummary {
            family: candidate.family.word().into(),
            place: candidate.place.clone(),
            period: periods.get(strongest).copied(),
            periods: if periods.len() > 1 { periods } else { Vec::new() },
            at,
            rows: finding.rows.iter().map(|row| row + 1).collect(),
            lines: finding.rows.iter().filter_map(|&row| data.line.get(row).copied()).collect(),
            poses: finding.poses.iter().map(|rows| rows.iter().map(|row| row + 1).collect()).collect(),
            p_value: finding.p_value,
            p_sign_flips: finding.evidence.as_ref().map(|evidence| evidence.p_sign_flips),
            p_surrogates: finding.evidence.as_ref().and_then(|evidence| evidence.p_surrogates),
            effective_poses: finding.evidence.as_ref().map(|evidence| evidence.effective_poses),
            name_probability: finding.name_probability,
            unnamed_probability: finding.unnamed_probability,
            p_parametric: finding.evidence.as_ref().map(|evidence| evidence.p_parametric),
            holdout_rms_mm: mm(finding.holdout),
            train_rms_mm: mm(finding.train),
            cross_validated_rms_mm: finding.evidence.as_ref().map(cross_validated),
            stability: finding.evidence.as_ref().map(|evidence| evidence.stability),
            parameters: finding
                .shape
                .iter()
                .chain(&finding.parameters)
                .map(|one| counted(one.clone(), by_order))
                .collect(),
            only_jointly: !finding.parameters.is_empty()
                && finding.parameters.iter().all(|one| one.ci95[0] <= 0.0 && one.ci95[1] >= 0.0),
            alternatives: finding.alternatives.iter().map(AlternativeSummary::from).collect(),
            meaning: super::meaning::meaning(finding, by_order),
        }
    }

    /// `selected in 97 % of half-samples; cross-validated RMS 0.3 → 0.1 mm`, of what was computed.
    pub(crate) fn selection(&self) -> Vec<String> {
        let stability =
            self.stability.map(|of| format!("selected in {} % of half-samples", significant(100.0 * of, 3)));
        let validated = self.cross_validated_rms_mm.map(|of| {
            format!("cross-validated RMS {} → {} mm", significant(of.before, 3), significant(of.after, 3))
        });
        stability.into_iter().chain(validated).collect()
    }

    /// Family and place, e.g. `backlash a1`.
    pub fn name(&self) -> String {
        format!("{} {}", self.family, self.place.words()).trim_end().to_owned()
    }

    /// The name for a sentence that stands alone: one that is less probable than not says so, and whose name is more probable.
    pub(crate) fn claim(&self) -> String {
        let named = self.alternatives.iter().filter(|other| other.family != "unmodelled");
        let others = named
            .map(|other| (other.name(), other.probability))
            .chain([(UNNAMED.to_owned(), self.unnamed_probability)]);
        let name = match self.family.as_str() {
            "unmodelled" => self.name(),
            _ => claimed(&self.name(), self.name_probability, others.max_by(|a, b| a.1.total_cmp(&b.1))),
        };
        match self.simplest() {
            Some(simplest) => format!("{name}; {simplest}"),
            None => name,
        }
    }

    /// The simplest hypothesis that is not distinguishable from the finding, where the finding is not the simplest.
    pub(crate) fn simplest(&self) -> Option<String> {
        let simplest = self.alternatives.iter().find(|other| other.simplest)?;
        Some(format!(
            "simplest that is not distinguishable: {} ({})",
            simplest.name(),
            probability(simplest.probability)
        ))
    }

    /// The rows that it concerns, as a person finds them: `lines 304, 305` of the file, or `rows 303, 304` of data from no file.
    pub(crate) fn places(&self, most: usize) -> String {
        let (word, numbers): (_, Vec<String>) = match self.lines.len() == self.rows.len() {
            true => ("line", self.lines.iter().map(ToString::to_string).collect()),
            false => ("row", self.rows.iter().map(ToString::to_string).collect()),
        };
        let (shown, more) = (numbers.len().min(most), numbers.len().saturating_sub(most));
        let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
        format!("{word}{} {}{rest}", if numbers.len() == 1 { "" } else { "s" }, numbers[..shown].join(", "))
    }

    /// The probabilities of the names: `joint_compliance j2 (0.93), link_compliance j3 (0.05), none of the library (0.01)`.
    pub(crate) fn names(&self) -> String {
        /// Smaller probabilities are left out.
        const LISTED: f64 = 0.01;
        let one = |name: &str, p: f64| format!("{name} ({})", probability(p));
        let mut names = vec![one(&self.name(), self.name_probability)];
        let named = |other: &&AlternativeSummary| other.probability >= LISTED && other.family != "unmodelled";
        names.extend(
            self.alternatives.iter().filter(named).map(|other| one(&other.name(), other.probability)),
        );
        if self.unnamed_probability >= LISTED && self.family != "unmodelled" {
            names.push(one(UNNAMED, self.unnamed_probability));
        }
        names.join(", ")
    }

    /// What decides where the two tests of existence disagree; none where they agree.
    pub(crate) fn assumption(&self) -> Option<String> {
        /// A single test that is not significant at this level disagrees.
        const LEVEL: f64 = 0.05;
        self.p_sign_flips.zip(self.effective_poses).filter(|(flips, _)| *flips > LEVEL).map(|(flips, poses)| {
            format!(
                "It rests on about {} poses: sign flips of whole poses give p = {}, so that the normal distribution of the errors decides.",
                significant(poses.max(1.0).round(), 2),
                significant(flips, 2)
            )
        })
    }
}

/// Stands for all causes that the library lacks.
const UNNAMED: &str = "a cause without a name in the library";

impl From<&Alternative> for AlternativeSummary {
    fn from(a: &Alternative) -> Self {
        AlternativeSummary {
            family: a.family.word().into(),
            place: a.place.clone(),
            holdout_rms_mm: a.holdout * 1e3,
            probability: a.probability,
            behind: a.behind,
            equivalent: a.equivalent,
            simplest: a.simplest,
        }
    }
}

/// A probability with two digits.
fn probability(p: f64) -> String {
    match p {
        p if p < 0.005 => "< 0.01".into(),
        p if p > 0.995 => "> 0.99".into(),
        p => format!("{p:.2}"),
    }
}

/// A name beside the most probable of the others.
fn claimed(name: &str, probability: f64, other: Option<(String, f64)>) -> String {
    if probability >= 0.5 {
        return name.to_owned();
    }
    let said = self::probability(probability);
    match other.filter(|(_, p)| *p > probability) {
        Some((other, p)) => {
            format!("{name} (name uncertain, probability {said}; more probable: {other}, {p:.2})")
        }
        None => format!("{name} (name uncertain, probability {said})"),
    }
}

/// The parameter in pose measurements, where their order stands for the time.
fn counted(parameter: Parameter, by_order: bool) -> Parameter {
    match by_order && parameter.unit == "s" {
        true => Parameter { unit: "pose measurements".into(), ..parameter },
        false => parameter,
    }
}

/// Cross-validated RMS without and with a candidate, mm.
pub(super) fn cross_validated(evidence: &Evidence) -> BeforeAfter {
    BeforeAfter { before: evidence.random.before * 1e3, after: evidence.random.after * 1e3 }
}

impl AlternativeSummary {
    /// Family and place, e.g. `backlash a1`.
    pub fn name(&self) -> String {
        format!("{} {}", self.family, self.place.words()).trim_end().to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::claimed;

    #[test]
    fn a_name_that_is_less_probable_than_not_says_so_and_which_is_more_probable() {
        let of = |p: f64, other: f64| claimed("backlash a1", p, Some(("transmission a1".into(), other)));
        assert_eq!(of(0.5, 0.4), "backlash a1");
        assert_eq!(of(0.36, 0.3), "backlash a1 (name uncertain, probability 0.36)");
        assert_eq!(
            of(0.36, 0.6),
            "backlash a1 (name uncertain, probability 0.36; more probable: transmission a1, 0.60)"
        );
        let unlikely = claimed("backlash a1", 0.001, None);
        assert_eq!(unlikely, "backlash a1 (name uncertain, probability < 0.01)");
    }
}
