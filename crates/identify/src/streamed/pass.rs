//! One pass over all rows: what it adds up, fold by fold.

use crate::linearise::{Lineariser, accumulate, gram, left_over};
use crate::streamed::Tally;
use crate::{Fit, IdentifyError, Residuals};
use rayon::prelude::*;
use truepose_errormodel::{Dataset, Domain, Visits};
use truepose_kinematics::Load;
use truepose_solvers::Gram;
use truepose_solvers::accumulator::Triangular;

/// The normal equations of each fold.
pub(super) enum Equations {
    Gram(Vec<Gram>),
    /// All digits, where a Gram matrix does not have enough.
    Triangle(Vec<Triangular>),
}

/// What the first pass adds up.
pub(super) struct Sums {
    pub equations: Equations,
    pub domain: Domain,
    pub rows: usize,
    pub visits: usize,
    pub observations: usize,
}

impl Sums {
    pub fn new(columns: usize, folds: usize, all_digits: bool) -> Self {
        let equations = match all_digits {
            true => Equations::Triangle(vec![Triangular::new(columns, 1); folds]),
            false => Equations::Gram(vec![Gram::new(columns, 1); folds]),
        };
        Sums { equations, domain: Domain::default(), rows: 0, visits: 0, observations: 0 }
    }

    /// Takes in a block, linearised at these coefficients of the model of a fit, with its noise and over its kept columns.
    pub fn take(&mut self, fit: &Fit, at: &[f64], block: &Dataset) -> Result<(), IdentifyError> {
        let (model, kept) = (fit.fitted.model(), &fit.reduction.kept);
        self.domain.widen(&Domain::of(block));
        self.rows += block.len();
        self.visits += block.visit.last().map_or(0, |last| last + 1);
        self.observations += (0..block.len()).map(|row| block.seen(row).count()).sum::<usize>();
        match &mut self.equations {
            Equations::Gram(folds) => {
                let parts = by_fold(block, folds.len());
                folds.par_iter_mut().zip(parts).try_for_each(|(sum, visits)| {
                    Ok(sum.merge(&gram(model, block, &visits, fit.noise, at, Some(kept))?)?)
                })
            }
            Equations::Triangle(folds) => {
                let parts = by_fold(block, folds.len());
                folds.par_iter_mut().zip(parts).try_for_each(|(sum, visits)| {
                    let lineariser = Lineariser::new(model, block, fit.noise, at)?.of_columns(kept);
                    Ok(sum.merge(&accumulate(lineariser, &visits, 0..visits.len())?)?)
                })
            }
        }
    }
}

/// What the last pass adds up: residuals of positions (m) and orientations (rad).
#[derive(Default)]
pub(super) struct Judged {
    pub position: Tally,
    pub orientation: Tally,
    /// Held out, of all rows, and of each fold.
    pub held_position: Tally,
    pub held_orientation: Tally,
    pub folds: Vec<Tally>,
}

impl Judged {
    pub fn new(folds: usize) -> Self {
        Judged { folds: vec![Tally::default(); folds], ..Judged::default() }
    }

    /// Takes in a block: residuals of the fit, and of each fold with the change of the coefficients that leaving it out makes.
    pub fn take(&mut self, fit: &Fit, changes: &[Vec<f64>], block: &Dataset) -> Result<(), IdentifyError> {
        let (model, at) = (fit.fitted.model(), fit.fitted.coefficients());
        let residuals = left_over(model, block, at, &vec![0.0; at.len()])?;
        add(&mut self.position, &mut self.orientation, &residuals);
        if changes.is_empty() {
            return Ok(());
        }
        let parts: Vec<Residuals> = by_fold(block, changes.len())
            .into_par_iter()
            .zip(changes)
            .map(|(visits, change)| {
                let rows: Vec<usize> = visits.rows.into_iter().flatten().collect();
                left_over(model, &block.select(&rows), at, change)
            })
            .collect::<Result<_, _>>()?;
        for (part, fold) in parts.iter().zip(&mut self.folds) {
            add(&mut self.held_position, &mut self.held_orientation, part);
            fold.add((0..part.position.len()).filter_map(|row| part.distance(row)));
        }
        Ok(())
    }
}

fn add(position: &mut Tally, orientation: &mut Tally, residuals: &Residuals) {
    position.add((0..residuals.position.len()).filter_map(|row| residuals.distance(row)));
    orientation.add(residuals.orientation.iter().flatten().map(|turn| turn.norm()));
}

/// Width of a cell of joint values, in tolerances of a configuration ([`Dataset::dwell`]): where repeats lie across a border, two visits of a
/// configuration may come into different folds; that is so for a share of them of about their distance in widths, times the joints: one in some
/// thousand where they flicker, some in a hundred where they are as far apart as the tolerance allows.
const CELL: f64 = 100.0;
/// Where cells begin, in widths: not at round numbers, which many configurations have.
const BORDER: f64 = 0.381_966;

/// The visits of each fold. All visits of a configuration are in the same one, which the cell of its numbers alone decides: nothing has to be
/// remembered.
fn by_fold(block: &Dataset, folds: usize) -> Vec<Visits> {
    let mut parts = vec![Visits { rows: Vec::new() }; folds];
    for rows in Visits::of(block).rows {
        let fold = rows.first().map_or(0, |&row| fold_of(block, row, folds));
        parts[fold].rows.push(rows);
    }
    parts
}

/// A number that the cell of the joints and the load of a row make.
fn fold_of(block: &Dataset, row: usize, folds: usize) -> usize {
    if folds < 2 {
        return 0;
    }
    let mut mixed = 0x9e37_79b9_7f4a_7c15_u64;
    let mut add = |value: f64| {
        // The finaliser of SplitMix64.
        let mut z = mixed ^ value.to_bits();
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed = (z ^ (z >> 31)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    };
    for (joint, column) in block.joints.iter().enumerate() {
        let width = CELL * block.dwell.repeat_tolerance(joint);
        add(if width > 0.0 { (column[row] / width + BORDER).floor() } else { column[row] });
    }
    // A measured wrench is never the same twice: the joints alone tell repeats.
    if let Load::Payload(payload) = block.load[row] {
        add(payload.mass);
        payload.com.iter().for_each(|&v| add(v));
    }
    (mixed % folds as u64) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flicker_does_not_part_a_configuration() {
        let joints: Vec<f64> =
            (0..200).map(|k| f64::from(k % 100).to_radians() + 3e-6 * f64::from(k / 100)).collect();
        let data = Dataset {
            joints: vec![joints.clone(), joints],
            load: vec![Load::None; 200],
            ..Dataset::default()
        };
        let fold: Vec<usize> = (0..200).map(|row| fold_of(&data, row, 5)).collect();
        assert_eq!(fold[100..], fold[..100]);
        assert!((0..5).all(|k| fold.iter().filter(|&&f| f == k).count() > 20), "{fold:?}");
    }
}
