//! Uncertainty budgets (GUM) of an acceptance and of an identification.

use crate::document::Document;
use crate::layout::Alignment::{Left, Right};
use crate::significant;
use serde::Serialize;
use truepose_acceptance::{Budget, Contribution, Evaluation};
use truepose_errormodel::{Dataset, configurations};
use truepose_identify::{Identification, IdentifyError, Residuals};

/// One contribution.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ContributionSummary {
    /// Its source.
    pub source: String,
    /// `A` or `B` (GUM 4.2, 4.3).
    pub evaluation: &'static str,
    /// Standard uncertainty of x, y, z, mm; null where nothing is known of it.
    pub u_mm: Option<[f64; 3]>,
    /// Standard uncertainty of the position, all axes, mm; null where nothing is known of it.
    pub total_mm: Option<f64>,
    /// Degrees of freedom; null where the contribution is known, or nothing is known of it.
    pub freedom: Option<f64>,
    /// Part of the combined variance, 0 to 1; null where nothing is known of it.
    pub fraction: Option<f64>,
}

/// A budget.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BudgetSummary {
    /// Of what.
    pub measurand: String,
    /// Contributions.
    pub contributions: Vec<ContributionSummary>,
    /// Combined standard uncertainty of x, y, z, mm.
    pub combined_mm: [f64; 3],
    /// Combined standard uncertainty of the position, all axes, mm.
    pub total_mm: f64,
    /// The coverage factor k.
    pub coverage_factor: f64,
    /// Expanded uncertainties of x, y, z, mm.
    pub expanded_mm: [f64; 3],
    /// Expanded uncertainty of the position, all axes, mm.
    pub expanded_total_mm: f64,
    /// Effective degrees of freedom of the total (Welch and Satterthwaite); null where they are not limited.
    pub freedom: Option<f64>,
    /// What is not known, in words.
    pub notes: Vec<String>,
}

/// Rows to which the covariance of the coefficients is propagated, at most.
const ROWS: usize = 2000;

impl BudgetSummary {
    /// A budget in mm; nothing is known of the contributions of these sources, for a reason each.
    fn new(measurand: &str, budget: &Budget, unknown: &[(&str, &str)], mut notes: Vec<String>) -> Self {
        let finite = |freedom: f64| freedom.is_finite().then_some(freedom);
        let one = |c: &Contribution| {
            let known = unknown.iter().all(|(source, _)| c.source != *source);
            ContributionSummary {
                source: c.source.clone(),
                evaluation: match c.evaluation {
                    Evaluation::A => "A",
                    Evaluation::B => "B",
                },
                u_mm: known.then(|| c.u.map(|u| 1e3 * u)),
                total_mm: known.then(|| 1e3 * c.total()),
                freedom: finite(c.freedom).filter(|_| known),
                fraction: known.then(|| budget.fraction(c)),
            }
        };
        notes.splice(0..0, unknown.iter().map(|(source, why)| format!("{source}: {why}")));
        let (k, combined) = (Budget::COVERAGE_FACTOR, budget.combined().map(|u| 1e3 * u));
        BudgetSummary {
            measurand: measurand.into(),
            contributions: budget.contributions.iter().map(one).collect(),
            combined_mm: combined,
            total_mm: 1e3 * budget.total(),
            coverage_factor: k,
            expanded_mm: combined.map(|u| k * u),
            expanded_total_mm: 1e3 * k * budget.total(),
            freedom: finite(budget.freedom()),
            notes,
        }
    }

    /// Of test poses.
    pub(super) fn of_assessment(budget: &Budget) -> Self {
        let mut unknown = Vec::new();
        if budget.contributions.iter().any(|c| c.source == "instrument" && c.total() <= 0.0) {
            unknown.push(("instrument", "not stated (--instrument)"));
        }
        let measurand = "position that the calibrated robot attains once at a test pose, base frame";
        Self::new(measurand, budget, &unknown, Vec::new())
    }

    /// Of the held-out rows of an identification: contributions to the variance of one measured position about its prediction.
    ///
    /// ```text
    /// unexplained = mean e² − instrument − repeatability − model       e: held-out error of one axis; at least 0
    /// ```
    ///
    /// # Errors
    /// When the model cannot be evaluated on the data.
    pub fn of_identification(found: &Identification, data: &Dataset) -> Result<Self, IdentifyError> {
        let train = Residuals::default();
        let (errors, rows, held): (&Residuals, Vec<usize>, bool) =
            match (&found.test_set, &found.declared.held_out) {
                (Some(test), _) => (&test.declared, test.rows.clone(), true),
                (None, Some(folds)) => (&folds.residuals, (0..data.len()).collect(), true),
                (None, None) if found.declared.train.position.len() == data.len() => {
                    (&found.declared.train, (0..data.len()).collect(), false)
                }
                _ => (&train, Vec::new(), false),
            };
        let (mut unknown, mut notes) = (Vec::new(), Vec::new());
        let mean = |values: &mut dyn Iterator<Item = f64>| {
            let (sum, n) = values.filter(|v| v.is_finite()).fold((0.0, 0.0), |(s, n), v| (s + v, n + 1.0));
            if n > 0.0 { sum / n } else { 0.0 }
        };
        let each = |of: &dyn Fn(usize) -> f64| [of(0), of(1), of(2)];
        // What was measured along a direction has a part in all axes.
        let seen = |row: usize| if data.ray(row).is_some() { [true; 3] } else { data.seen(row).position };
        // An axis that no row measured has no part in it.
        let axes = [0, 1, 2].map(|k| rows.iter().any(|&row| seen(row)[k]));
        let stated = each(&|k| {
            mean(&mut rows.iter().filter(|&&row| seen(row)[k]).map(|&row| data.position_sd[row][k].powi(2)))
        });
        if stated.iter().all(|v| *v <= 0.0) {
            unknown.push(("instrument", "not stated (columns sx, sy, sz)"));
        }
        let (repeats, freedom) = match &found.repeats {
            Some(repeats) => {
                let counts =
                    rows.iter().map(|&row| seen(row).iter().filter(|seen| **seen).count()).filter(|&n| n > 0);
                let each = mean(&mut counts.map(|n| n as f64));
                (repeats.rms.powi(2) / each.max(1.0), repeats.freedom as f64)
            }
            None => {
                let why =
                    "unknown, no configuration was measured twice; it is contained in the last contribution";
                unknown.push(("repeatability", why));
                (0.0, f64::INFINITY)
            }
        };
        // Repeats contain the scatter of the instrument as well.
        let repeatability = each(&|k| if axes[k] { (repeats - stated[k]).max(0.0) } else { 0.0 });
        let mut model = [0.0; 3];
        let step = rows.len().div_ceil(ROWS).max(1);
        let chosen: Vec<usize> = rows.iter().copied().step_by(step).collect();
        for spread in truepose_identify::open_variances(&found.fit, data, &chosen)? {
            (0..3).filter(|&k| axes[k]).for_each(|k| model[k] += spread[k] / chosen.len() as f64);
        }
        let square = each(&|k| mean(&mut errors.position.iter().map(|e| e[k].powi(2))));
        if !held {
            notes.push("no rows were held out: errors on the rows of the fit are too small".into());
        }
        let poses = configurations(data);
        let mut tested: Vec<usize> = rows.iter().map(|&row| poses[data.visit[row]]).collect();
        tested.sort_unstable();
        tested.dedup();
        let left = each(&|k| square[k] - stated[k] - repeatability[k] - model[k]);
        let known = f64::INFINITY;
        let budget = Budget {
            contributions: vec![
                Contribution::of_variances("instrument", Evaluation::B, stated, known),
                Contribution::of_variances("repeatability", Evaluation::A, repeatability, freedom),
                Contribution::of_variances("model parameters", Evaluation::A, model, known),
                Contribution::of_variances(
                    "unexplained by the model",
                    Evaluation::A,
                    left,
                    tested.len() as f64,
                ),
            ],
        };
        let measurand = "one measured position about its prediction, measurement frame";
        Ok(Self::new(measurand, &budget, &unknown, notes))
    }

    /// Cells of a table: names, then x, y, z, total.
    fn rows(&self) -> Vec<Vec<String>> {
        let mm = |v: f64| significant(v, 3);
        let freedom = |of: Option<f64>| of.map_or_else(|| "∞".into(), |v| significant(v.max(1.0).round(), 3));
        let mut rows: Vec<Vec<String>> = self
            .contributions
            .iter()
            .map(|c| {
                let mut row = vec![c.source.clone(), c.evaluation.into()];
                match (c.u_mm, c.total_mm, c.fraction) {
                    (Some(u), Some(total), Some(fraction)) => {
                        row.extend(u.map(mm));
                        row.extend([mm(total), freedom(c.freedom), format!("{:.0} %", 100.0 * fraction)]);
                    }
                    _ => row.resize(Self::HEAD.len(), "–".into()),
                }
                row
            })
            .collect();
        let mut combined = vec!["combined standard uncertainty".to_owned(), String::new()];
        combined.extend(self.combined_mm.map(mm));
        combined.extend([mm(self.total_mm), freedom(self.freedom), "100 %".into()]);
        let mut expanded = vec![format!("expanded uncertainty, k = {}", self.coverage_factor), String::new()];
        expanded.extend(self.expanded_mm.map(mm));
        expanded.extend([mm(self.expanded_total_mm), String::new(), String::new()]);
        rows.extend([combined, expanded]);
        rows
    }

    /// Heads of the columns.
    const HEAD: [&str; 8] =
        ["contribution", "type", "u(x), mm", "u(y), mm", "u(z), mm", "total, mm", "ν", "variance"];
}

impl BudgetSummary {
    /// The table with its notes.
    pub(crate) fn document(&self) -> Document {
        let mut document = Document::default();
        let sides = [Left, Left, Right, Right, Right, Right, Right, Right];
        let caption = format!("uncertainty budget (GUM): {}", self.measurand);
        document.table(caption, &Self::HEAD, &sides, self.rows());
        document.note(
            "Type A: from the scatter of observations; type B: from other knowledge (GUM). ν: degrees of freedom. Variance: part of the \
             combined variance.",
        );
        self.notes.iter().for_each(|note| document.note(note));
        document
    }
}
