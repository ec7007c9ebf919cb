//! Figures against limits, with guard bands.

use super::{FigureSummary, StateSummary};
use serde::Serialize;
use truepose_acceptance::{Conformity, GuardBand};

/// A limit of a characteristic.
#[derive(Debug, Clone, PartialEq)]
pub struct Limit {
    /// `AP`, `RP`, `AD`, …: the positional figure of the characteristic.
    pub characteristic: String,
    /// m.
    pub limit: f64,
}

impl Limit {
    /// Characteristics that may have a limit, with the symbols of their figures.
    pub const KNOWN: [(&str, &str); 9] = [
        ("AP", "AP_p"),
        ("RP", "RP_l"),
        ("vAP", "vAP_p"),
        ("AD", "AD_p"),
        ("RD", "RD_p"),
        ("dAP", "dAP_p"),
        ("dRP", "dRP_l"),
        ("AT", "AT_p"),
        ("RT", "RT_p"),
    ];

    fn symbol(&self) -> &str {
        let known = Self::KNOWN.iter().find(|(name, _)| *name == self.characteristic);
        known.map_or(self.characteristic.as_str(), |(_, symbol)| symbol)
    }
}

/// One figure against its limit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct VerdictSummary {
    /// `as measured`, or `with the identified model`.
    pub state: &'static str,
    /// The pose, the pair of poses, or the path.
    pub of: String,
    /// Symbol of the figure.
    pub symbol: String,
    /// The limit, mm.
    pub limit_mm: f64,
    /// The magnitude of the figure, mm.
    pub value_mm: f64,
    /// Standard uncertainty, mm.
    pub u_mm: f64,
    /// Guard band above the figure, mm.
    pub guard_band_mm: f64,
    /// Guard band divided by the standard uncertainty.
    pub factor: f64,
    /// `conform`, `not conform` or `undecided`.
    pub verdict: &'static str,
    #[serde(skip)]
    pub(crate) conformity: Conformity,
}

/// Every figure of a state that has a limit.
pub(super) fn verdicts(state: &StateSummary, limits: &[Limit]) -> Vec<VerdictSummary> {
    let mut all = Vec::new();
    for limit in limits {
        let mut add = |of: &str, figures: &[FigureSummary]| {
            let Some(figure) = figures.iter().find(|figure| figure.symbol == limit.symbol()) else { return };
            let band = GuardBand::new(&figure.figure, limit.limit);
            all.push(VerdictSummary {
                state: state.name,
                of: of.into(),
                symbol: figure.symbol.clone(),
                limit_mm: 1e3 * band.limit,
                value_mm: 1e3 * band.value,
                u_mm: 1e3 * figure.figure.u,
                guard_band_mm: 1e3 * band.guard[1],
                factor: band.factor,
                verdict: band.verdict.name(),
                conformity: band.verdict,
            });
        };
        state.poses.iter().for_each(|pose| add(&pose.name, &pose.figures));
        state.distances.iter().for_each(|pair| add(&pair.between.join("–"), &pair.figures));
        state.path.iter().for_each(|path| add("path", &path.figures));
    }
    all
}

/// The verdict of a state over all limits; a limit without a figure is undecided.
pub(super) fn overall(all: &[VerdictSummary], state: &str, limits: &[Limit]) -> Option<&'static str> {
    if limits.is_empty() {
        return None;
    }
    let of_state = || all.iter().filter(|verdict| verdict.state == state);
    let missing = limits.iter().any(|limit| of_state().all(|verdict| verdict.symbol != limit.symbol()));
    let missing = missing.then_some(Conformity::Undecided);
    Some(Conformity::of_all(of_state().map(|verdict| verdict.conformity).chain(missing)).name())
}
