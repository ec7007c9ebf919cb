//! What to measure next.
//!
//! | symbol | here | shape | unit |
//! | --- | --- | --- | --- |
//! | C = L Lᵀ | covariance of the coefficients that the data determined | r × r | |
//! | B(x) = J_e Φ L / σ | what a visit x would show, all targets, in deviations | 3a × r | 1 |
//! | G = J_e Φ L at the poses that matter | positions alone | 3g × r | m |
//! | P = (1 + Σ BᵀB)⁻¹ | what the plan leaves of C | r × r | 1 |
//! | d, S | difference of two fits' predictions and its covariance | 3a | m |
//!
//! Two questions. *How accurate will the robot be?* `min tr(G P Gᵀ)`, the expected squared error after compensation at the user's own
//! poses (I-optimality; Wu, Klimchik, Caro, Furet and Pashkevich 2015). *Which of two explanations is right?*
//! `max Σ dᵀ (σ² 1 + S_a + S_b)⁻¹ d` (T-optimality; Atkinson and Fedorov 1975; with the predictions' covariance, Buzzi-Ferraris
//! and Forzatti 1983). Both by greedy choice from a pool spread over the joints' ranges; the first is improved by exchange
//! (Fedorov 1972). The last eighth of the visits repeats the best ones, coming from the other side: they tell noise and play
//! from everything else.

use super::options::PlanOptions;
use super::{accuracy, discriminate, pool};
use crate::IdentifyError;
use serde::{Deserialize, Serialize};
use truepose_errormodel::{Dataset, FittedModel};
use truepose_kinematics::Conditions;

/// Why a visit is in a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Why {
    /// It shows what is not known.
    New,
    /// It repeats another one, from the other side.
    Repeat,
}

/// A visit to make.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// Joints, load and sides of approach.
    pub conditions: Conditions,
    /// Why.
    pub why: Why,
    /// What it adds: share of the expected squared error that it takes away, or T of this visit alone.
    pub worth: f64,
}

/// Configurations among which can be chosen: each is a block of rows in memory.
const MOST: usize = 100_000;

/// What to measure next, and what it would bring.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// In the order of their worth; repeats last.
    pub visits: Vec<Planned>,
    /// Expected 3-D RMS error that the coefficients leave at the poses that matter, now and then, m.
    pub accuracy: (f64, f64),
    /// Where rivals are told apart: Σ T of the plan, and the value that settles it (χ², 99 %).
    pub separation: Option<(f64, f64)>,
    /// O1–O5 of what the data and the plan determine, in units of today's deviations; the first of each is of no plan.
    pub observability: [(f64, f64); 5],
}

/// Plans the next visits for a fit: against a rival where one is given, else for accuracy at `goals` (the joints' ranges when
/// there are none).
///
/// # Errors
/// When the fit has no coefficient with a deviation, or the rival is a fit of another robot.
pub fn plan(
    fitted: &FittedModel,
    rival: Option<&FittedModel>,
    goals: Option<&Dataset>,
    options: &PlanOptions,
) -> Result<Plan, IdentifyError> {
    checked("count", options.count)?;
    checked("pool", options.pool)?;
    if options.pool < options.count {
        let value = options.pool as f64;
        return Err(IdentifyError::Option { option: "pool", value, expected: "at least `count`" });
    }
    let pool = pool::spread(fitted, options);
    let repeats = options.count / 8;
    let new = options.count - repeats;
    let (chosen, separation) = match rival {
        Some(rival) => {
            let (chosen, total) = discriminate::choose(fitted, rival, &pool, new)?;
            (chosen, Some(total))
        }
        None => (accuracy::choose(fitted, &pool, goals, new, options.seed)?, None),
    };
    let mut visits: Vec<Planned> = chosen
        .iter()
        .map(|&(at, worth)| Planned { conditions: pool[at].clone(), why: Why::New, worth })
        .collect();
    for at in 0..repeats.min(visits.len()) {
        let mut again = visits[at].clone();
        again.conditions.approach.iter_mut().for_each(|side| *side = -*side);
        again.why = Why::Repeat;
        visits.push(again);
    }
    let planned: Vec<Conditions> = visits.iter().map(|visit| visit.conditions.clone()).collect();
    let (accuracy, observability) = accuracy::judged(fitted, &planned, goals, options.seed)?;
    Ok(Plan { visits, accuracy, separation, observability })
}

/// A number of visits that is one.
pub(super) fn checked(option: &'static str, value: usize) -> Result<(), IdentifyError> {
    let expected = match value {
        0 => "at least 1",
        1..=MOST => return Ok(()),
        _ => "at most 100 000",
    };
    Err(IdentifyError::Option { option, value: value as f64, expected })
}
