//! The side on which a joint with play lay before its first move.
//!
//! Nobody wrote down from where the joint came to its first pose. Until it moves, its play lies on one side all the same: in place of the
//! middle between both, one sign for all of these pose measurements is taken from the data, where they tell.
//!
//! ```text
//! s = argmin L(s),  s ∈ {−1, +1},    taken where |L(+1) − L(−1)| ≥ d
//! L(s) = Σ_visits min(c, mean over rows of Σ_axes e(s)² / (σ_row² + σ_visit²))
//! ```
//!
//! | symbol | here | unit |
//! | --- | --- | --- |
//! | e(s) | measured − predicted with the side s | m |
//! | σ_row, σ_visit | noise of rows and of visits of the fit | m |
//! | c | [`GROSS`]: an outlier decides nothing | 1 |
//! | d | [`DECISIVE`] | 1 |

use crate::error::DiscoverError;
use crate::hypotheses::candidate::{Candidate, FirstSide};
use crate::model::prepared::{with_found, without_side};
use truepose_errormodel::{Dataset, Signal, Visits};
use truepose_identify::{Fit, Residuals};
use truepose_kinematics::Chain;

/// Largest part of one visit, in squared standard deviations.
const GROSS: f64 = 25.0;
/// Difference of −2 ln L between both sides from which on one is taken: odds of e^4.5, some 90 to 1.
const DECISIVE: f64 = 9.0;

/// Takes the side of each finding that depends on one, from the data as it was read; whether one changed.
pub(crate) fn settled(fit: &Fit, data: &Dataset, found: &mut [Candidate]) -> Result<bool, DiscoverError> {
    let mut changed = false;
    for which in 0..found.len() {
        let Some(column) = column(fit.fitted.chain(), &found[which]) else { continue };
        let rows = before_first_move(data, column);
        if rows.is_empty() {
            continue;
        }
        let (part, known) = (data.select(&rows), found[which].first_side);
        let mut loss_of = |side: f64| {
            found[which].first_side = Some(FirstSide { column, side });
            loss(fit, &with_found(&part, found))
        };
        let lead = loss_of(-1.0)? - loss_of(1.0)?;
        let taken = (lead.abs() >= DECISIVE).then(|| FirstSide { column, side: lead.signum() });
        changed |= taken != known;
        found[which].first_side = taken;
    }
    Ok(changed)
}

/// The joint, as a column, on whose side of approach a candidate depends.
fn column(chain: &Chain, candidate: &Candidate) -> Option<usize> {
    candidate.effects().iter().flat_map(|effect| effect.needs()).find_map(|need| match need {
        Signal::Approach(joint) => chain.coordinate(joint),
        _ => None,
    })
}

/// The rows without a side, where all of them are earlier than any with one: a side that is not known in between is not one side.
fn before_first_move(data: &Dataset, column: usize) -> Vec<usize> {
    let rows = without_side(data, column);
    let when = |row: usize| if data.schema.time { data.time[row] } else { data.visit[row] as f64 };
    let last = rows.iter().map(|&row| when(row)).fold(f64::NEG_INFINITY, f64::max);
    let moved = (0..data.len()).filter(|row| rows.binary_search(row).is_err());
    if moved.map(when).all(|first| first > last) { rows } else { Vec::new() }
}

/// L of all rows.
fn loss(fit: &Fit, data: &Dataset) -> Result<f64, DiscoverError> {
    let residuals = Residuals::of(&fit.fitted, data)?;
    let variance = |row: usize, axis: usize| {
        // What measured one number states one deviation.
        let stated = data.position_sd[row][if data.ray(row).is_some() { 0 } else { axis }];
        fit.noise.position(stated).powi(2) + fit.noise.visit_sd.powi(2)
    };
    let square = |row: usize| -> f64 {
        let all = residuals.position[row].iter().enumerate().filter(|(_, e)| e.is_finite());
        all.map(|(axis, e)| e * e / variance(row, axis)).sum()
    };
    let mean = |rows: &Vec<usize>| rows.iter().map(|&row| square(row)).sum::<f64>() / rows.len() as f64;
    Ok(Visits::of(data).rows.iter().map(|rows| mean(rows).min(GROSS)).sum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hypotheses::family::Family;
    use crate::hypotheses::library::Library;
    use crate::model::current::Context;
    use crate::options::DiscoverOptions;
    use crate::problem::synthetic::{data_of, wave};
    use truepose_errormodel::AnyEffect;
    use truepose_errormodel::effects::Geometric;
    use truepose_solvers::PivotedQr;

    /// The play of joint 4, 1 mrad, lies where the moves lay it, and on the side `first` for the first twelve poses, whose side is not known.
    fn played(first: f64) -> (Chain, Dataset) {
        let value = |pose: usize| 2.0 * wave(3000 + 6 * pose + 3);
        let moved = |pose: usize| if value(pose) > value(pose - 1) { 1.0 } else { -1.0 };
        let actual = |joints: &[f64]| {
            let pose = (0..60).find(|&pose| value(pose).to_bits() == joints[3].to_bits()).expect("a pose");
            let mut joints = joints.to_vec();
            joints[3] -= 0.5e-3 * if pose < 12 { first } else { moved(pose) };
            joints
        };
        let noise =
            |_: usize, _: &[f64], row: usize| [0, 1, 2].map(|axis| 1e-5 * wave(9000 + 3 * row + axis));
        let (chain, mut data) = data_of(60, 3, &actual, &noise);
        data.schema.approach = true;
        for row in 0..data.len() {
            let pose = data.visit[row];
            data.approach[3][row] = if pose < 12 { 0.0 } else { moved(pose) };
        }
        (chain, data)
    }

    #[test]
    fn the_side_before_the_first_move_is_taken_from_the_data() {
        for first in [-1.0, 1.0] {
            let (chain, data) = played(first);
            assert_eq!(before_first_move(&data, 3).len(), 18);
            let library = Library::standard();
            let mut all = library.candidates(&chain, &data).into_iter();
            let play = all.find(|one| one.family == Family::Backlash && column(&chain, one) == Some(3));
            let candidate = play.expect("backlash of joint 4");
            let options = DiscoverOptions::default();
            let declared: Vec<Box<dyn AnyEffect>> = vec![Box::new(Geometric::default())];
            let context = Context {
                levels_first: true,
                full_report: true,
                chain: &chain,
                declared: &declared,
                data: &data,
                solver: &PivotedQr::default(),
                fit: options.fit.clone(),
                options: &options,
            };
            let fitted = context.fit_model(vec![candidate], &[]).expect("a fit");
            let side = fitted.found[0].first_side.expect("the data tell");
            assert_eq!((side.column, side.side), (3, first));
            assert!(without_side(&fitted.data, 3).is_empty());
            let own = fitted.fit.fitted.model().columns_of(context.effects_of(&fitted.found, 0).start);
            let gap = fitted.fit.fitted.coefficients()[own.start];
            assert!((gap - 1e-3).abs() < 2e-5, "{gap}");
            assert!(fitted.outliers.suspects.is_empty());
        }
    }
}
