//! Is it the robot, or what observed it? Where something that observed is suspected beside the declared model, the search is made with it allowed
//! for as well, and the rows that neither search has seen decide.
//!
//! ```text
//! Δ = Σ_k m_k ln(e_k / e'_k),   p = 1/(1 + exp(−Δ))
//! ```
//!
//! | symbol | here |
//! | --- | --- |
//! | e_k, e'_k | RMS of kind k on its held-out rows, in its unit: with the observers as described, with what is suspected allowed for |
//! | m_k | standstills of the robot among these rows: numbers of one standstill are not independent |
//!
//! Each kind has a standard deviation of its own, so that Δ is the logarithm of a ratio of likelihoods. Where the two are as good, within a factor of e²,
//! the search that finds fewer effects of the robot is preferred.

use super::held_out::by_kind;
use super::{Campaign, Fitting};
use crate::error::WorkflowError;
use std::collections::BTreeMap;
use truepose_discover::Diagnosis;
use truepose_errormodel::ErrorModel;
use truepose_identify::{Touched, fit, suspects};
use truepose_report::{AllowedKind, AllowedSummary, SuspectSummary};

/// Suspicions that are allowed for, at most.
const MOST: usize = 4;

/// What a search finds in a campaign.
pub(crate) struct Decided {
    pub found: Diagnosis,
    /// The campaign in which it is found, where that is one with something allowed for.
    pub allowing: Option<Campaign>,
    /// What both searches leave, where there were two.
    pub summary: Option<AllowedSummary>,
    /// Why there was no second search, where something was suspected.
    pub remark: Option<String>,
}

/// Searches a campaign, and with what is suspected allowed for as well, where something is: the better of both. Where only the second search fails,
/// the first counts, and a remark states why.
///
/// # Errors
/// When the first search fails, or a search is ended by its observer.
pub(crate) fn decided(
    campaign: &Campaign,
    fit: Fitting<'_>,
    search: &dyn Fn(&Campaign) -> Result<Diagnosis, WorkflowError>,
) -> Result<Decided, WorkflowError> {
    let found = search(campaign)?;
    let alone = |found, remark| Decided { found, allowing: None, summary: None, remark };
    let Some(other) = allowed(campaign, fit)? else { return Ok(alone(found, None)) };
    let second = match search(&other.campaign) {
        Ok(second) => second,
        Err(failure) if failure.is_cancelled() => return Err(failure),
        Err(failure) => return Ok(alone(found, Some(unanswered(&other.suspects, &failure)))),
    };
    let judged = other.judged((campaign, &found), &second);
    let (found, allowing) = if judged.preferred { (second, Some(other.campaign)) } else { (found, None) };
    Ok(Decided { found, allowing, summary: Some(judged), remark: None })
}

/// That the search with these suspicions allowed for failed.
fn unanswered(suspects: &[SuspectSummary], failure: &WorkflowError) -> String {
    let names: Vec<&str> = suspects.iter().map(|suspect| suspect.name.as_str()).collect();
    format!("with {} allowed for, the search failed: {failure}", names.join(", "))
}

/// A campaign in which what is suspected is allowed for.
struct Allowed {
    campaign: Campaign,
    suspects: Vec<SuspectSummary>,
}

/// Allows for what is suspected beside the declared model, one thing after the other; none where nothing is, or nothing can be allowed for.
fn allowed(campaign: &Campaign, (solver, options): Fitting<'_>) -> Result<Option<Allowed>, WorkflowError> {
    let mut all: Option<Allowed> = None;
    for _ in 0..MOST {
        let before = all.as_ref().map_or(campaign, |all| &all.campaign);
        let Some(found) = &before.touched else { break };
        let model = ErrorModel::new(before.chain.clone(), before.effects.clone())?;
        let declared = fit(&model, &before.data, solver, &found.options(options))?;
        let suspected = suspects(&declared, &before.data, found)?;
        let next = suspected.iter().find_map(|suspect| {
            // What cannot be fitted with it allowed for stays a suspicion.
            Some((suspect, before.allowing(suspect, (solver, options))?.ok()?))
        });
        let Some((suspect, campaign)) = next else { break };
        let told = SuspectSummary::new(suspect, &before.data, in_pixels(found, &suspect.name));
        let mut suspects = all.map_or_else(Vec::new, |all| all.suspects);
        suspects.push(told);
        all = Some(Allowed { campaign, suspects });
    }
    Ok(all)
}

/// Whether a sensor of this name measured pixels.
fn in_pixels(found: &Touched, name: &str) -> bool {
    let sensor = found.sensors.iter().find(|sensor| sensor.name == name);
    sensor.is_some_and(|sensor| sensor.observation.unit() == "px")
}

impl Allowed {
    /// Which of two searches explains the rows that neither has seen: that of the campaign as described, and that of this one.
    fn judged(&self, described: (&Campaign, &Diagnosis), other: &Diagnosis) -> AllowedSummary {
        let of = |campaign: &Campaign, found: &Diagnosis| {
            campaign
                .touched
                .as_ref()
                .map_or_else(BTreeMap::new, |touched| by_kind(touched, &campaign.data, found))
        };
        let (a, b) = (of(described.0, described.1), of(&self.campaign, other));
        let mut log_ratio = 0.0;
        let mut kinds = Vec::new();
        for (kind, before) in &a {
            let Some(after) = b.get(kind) else { continue };
            let least = f64::MIN_POSITIVE;
            log_ratio += before.standstills as f64 * (before.rms.max(least) / after.rms.max(least)).ln();
            let (as_described, allowed) = (before.rms, after.rms);
            kinds.push(AllowedKind { kind: kind.clone(), unit: before.unit.into(), as_described, allowed });
        }
        let fewer = other.findings.len() <= described.1.findings.len();
        let preferred = log_ratio > AllowedSummary::ALIKE || (log_ratio > -AllowedSummary::ALIKE && fewer);
        let words = |finding: &truepose_discover::Finding| finding.candidate.words();
        AllowedSummary {
            suspects: self.suspects.clone(),
            instead: described.1.findings.iter().map(words).collect(),
            kinds,
            probability: 1.0 / (1.0 + (-log_ratio).exp()),
            preferred,
        }
    }
}
