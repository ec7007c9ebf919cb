//! W3: the paper's model over many points, in memory.

use super::paper::{PLAIN, STABLE, model, rows};
use super::{answer_of_points, of_points, shared_with};
use crate::prelude::*;
use truepose_identify::{Way as By, plain};

/// The columns that W1's rows tell apart: chosen once, as the peers choose theirs.
pub fn columns(folder: &Path) -> Outcome<Vec<usize>> {
    Ok(plain(&model(folder)?, &rows(folder)?, PLAIN, None, STABLE, 1)?.kept)
}

fn way(folder: &Path, file: &str, by: By) -> Outcome<Way> {
    let (model, kept) = (model(folder)?, columns(folder)?);
    let data: Dataset = rows_of(folder, file)?;
    let (also, again) = (model.clone(), data.clone());
    let run = move || {
        let found = plain(&model, &data, PLAIN, Some(&kept), by, 1)?;
        match found.guarded == matches!(by, By::Guarded(_)) {
            true => Ok(found),
            false => Err("the guard refused".into()),
        }
    };
    shared_with(run, move |found| answer_of_points(&also, &again, found.kept.len(), &found.coefficients))
}

const ASKED: &[(&str, f64)] = &[("numba-chunk", 0.7), ("numpy-chunk", 0.7)];

/// Bytes of a point in memory.
const BYTES: f64 = 88.0;

/// 200 000 points.
pub const W3_200K: Workload = of_points(
    ("W3-200k", "200 000 points, 224 columns, in memory"),
    (2e5, BYTES),
    &[Declared::of("gram", ASKED, |folder| way(folder, "w3_200k.csv", By::Guarded(1e6)))],
);

/// A million.
pub const W3_1M: Workload = of_points(
    ("W3-1m", "1 000 000 points, 224 columns, in memory"),
    (1e6, BYTES),
    &[Declared::of("gram", ASKED, |folder| way(folder, "w3_1m.csv", By::Guarded(1e6)))],
);
