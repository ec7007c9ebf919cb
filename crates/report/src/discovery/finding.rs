//! One effect that was found.

use serde::{Deserialize, Serialize};
use truepose_discover::{Parameter, Place};

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
