//! What a search without a fold comes to.

use crate::conclude::cross_validated::used;
use crate::conclude::diagnosis::Diagnosis;
use crate::conclude::errors::Errors;
use crate::conclude::fold_run::FoldRun;
use crate::conclude::held_out::clusters;
use truepose_errormodel::Dataset;
use truepose_identify::measured;

impl FoldRun {
    /// Of a run whose test set is the fold; `data` has all rows.
    pub(crate) fn of((fold, folds): (usize, usize), run: &Diagnosis, data: &Dataset) -> Self {
        let residuals = |errors: &Errors| {
            let rows = 0..errors.holdout.position.len();
            let of =
                |row| errors.holdout.distance(row).map(|_| measured(&errors.holdout.position[row]).into());
            rows.map(of).collect()
        };
        FoldRun {
            fold,
            folds,
            findings: run.findings.iter().map(|finding| finding.candidate.words()).collect(),
            rows: run.holdout_rows.clone(),
            before: residuals(&run.before),
            after: residuals(&run.after),
            dependence: run.dependence.map(|dependence| dependence.p_value),
            clusters: clusters(data, run.dependence.as_ref()),
            rank: run.fit.reduction.rank(),
            used: [&run.declared, &run.fit].map(used),
        }
    }
}
