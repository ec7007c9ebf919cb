//! W4: ten times ten-fold cross-validation of W1's model on all rows, and every configuration left out alone.

use super::paper::{PLAIN, model};
use super::shared;
use crate::prelude::*;
use truepose_errormodel::Visits;
use truepose_identify::engine::{gram, left_out};

fn way(folder: &Path) -> Outcome<Way> {
    let model = model(folder)?;
    let data = rows_of(folder, "w1.csv")?;
    let folds = Table::read(&folder.join("w4_folds.csv"))?.series("rep", 0..10)?;
    let folds: Vec<Vec<usize>> = folds.iter().map(|f| f.iter().map(|v| *v as usize).collect()).collect();
    let zero = vec![0.0; model.columns().len()];
    shared(move || {
        let visits = Visits::of(&data);
        let found = gram(&model, &data, &visits, PLAIN, &zero, None)?.solve_guarded(0, 1e6)?;
        let kept = found.and_then(|s| s.info.kept).ok_or("the guard refused")?;
        let rows = left_out(&model, &data, &visits, PLAIN, &zero, Some(&kept))?;
        let (mut squares, mut count) = (0.0, 0);
        for fold_of in &folds {
            for fold in 0..10 {
                let out: Vec<usize> = (0..visits.len()).filter(|&v| fold_of[v] == fold).collect();
                let left = rows.without(&out).ok_or("a fold is needed")?;
                squares += left.iter().map(|v| v * v).sum::<f64>();
                count += left.len();
            }
        }
        let alone = rows.one_by_one()?;
        let rms = |squares: f64, count: usize| 1e6 * (3.0 * squares / count as f64).sqrt();
        let one: f64 = alone.iter().flatten().map(|v| v * v).sum();
        Ok([
            ("rank".into(), kept.len() as f64),
            ("cv_rms_um".into(), rms(squares, count)),
            ("loo_rms_um".into(), rms(one, 3 * data.len())),
        ]
        .into())
    })
}

/// 100 refits and leave-one-out.
pub const W4: Workload = Workload::of(
    "W4",
    "10 × 10-fold cross-validation and leave-one-out, 4 050 rows, 224 columns",
    [3.1e9, 0.0],
    &[("rank", 9), ("cv_rms_um", 9), ("loo_rms_um", 9)],
    &[Declared::of("gram", &[("numpy-gram", 0.5)], way)],
);
