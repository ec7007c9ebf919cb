//! One pass over all rows: what it needs, and what it adds up, fold by fold.

use crate::linearise::{Lineariser, accumulate, gram, left_over};
use crate::streamed::Tally;
use crate::{IdentifyError, NoiseModel, Residuals};
use rayon::prelude::*;
use truepose_errormodel::{Dataset, Domain, FittedModel, Visits};
use truepose_kinematics::Load;
use truepose_solvers::Gram;
use truepose_solvers::accumulator::Triangular;

/// A pass over all rows that adds up normal equations: what is needed to take in a block, wherever that is.
#[derive(Debug, Clone)]
pub struct FitPass {
    /// The model; its coefficients are not read.
    pub fitted: FittedModel,
    /// Coefficients at which it is linearised.
    pub at: Vec<f64>,
    /// Columns that the reduction has kept.
    pub kept: Vec<usize>,
    /// Noise by which rows are whitened.
    pub noise: NoiseModel,
    /// Folds of the cross-validation, at least 1.
    pub folds: usize,
    /// Whether triangular factors are needed: Gram matrices had too few digits.
    pub all_digits: bool,
}

/// The last pass, which adds up residuals.
#[derive(Debug, Clone)]
pub struct JudgePass {
    /// The fit.
    pub fitted: FittedModel,
    /// For each fold, what leaving it out changes in the coefficients; empty without cross-validation.
    pub changes: Vec<Vec<f64>>,
}

/// What a pass has to do with each block. A block is whole visits, and what it comes to depends on nothing but its rows.
#[derive(Debug, Clone)]
pub enum Pass {
    /// Adds up normal equations.
    Fit(Box<FitPass>),
    /// Adds up residuals.
    Judge(Box<JudgePass>),
}

/// The normal equations of each fold.
#[derive(Debug, Clone)]
pub enum Equations {
    /// As Gram matrices.
    Gram(Vec<Gram>),
    /// All digits, where a Gram matrix does not have enough.
    Triangle(Vec<Triangular>),
}

/// What a pass for a fit adds up. Merged in the order of the blocks the sum is the same to the last bit, whoever made the parts.
#[derive(Debug, Clone)]
pub struct Sums {
    /// Normal equations.
    pub equations: Equations,
    /// Ranges of the inputs, and a sample of the rows.
    pub domain: Domain,
    /// Rows.
    pub rows: usize,
    /// Visits.
    pub visits: usize,
    /// Measured numbers.
    pub observations: usize,
}

impl FitPass {
    /// Nothing yet.
    pub fn nothing(&self) -> Sums {
        let (columns, folds) = (self.kept.len(), self.folds.max(1));
        let equations = match self.all_digits {
            true => Equations::Triangle(vec![Triangular::new(columns, 1); folds]),
            false => Equations::Gram(vec![Gram::new(columns, 1); folds]),
        };
        Sums { equations, domain: Domain::default(), rows: 0, visits: 0, observations: 0 }
    }

    /// What a block comes to.
    ///
    /// # Errors
    /// When the block lacks a signal of the model, or does not fit the robot.
    pub fn sums(&self, block: &Dataset) -> Result<Sums, IdentifyError> {
        let mut sums = self.nothing();
        let model = self.fitted.model();
        sums.domain = Domain::of(block);
        sums.rows = block.len();
        sums.visits = block.visit.last().map_or(0, |last| last + 1);
        sums.observations = (0..block.len()).map(|row| block.seen(row).count()).sum();
        let parts = by_fold(block, self.folds.max(1));
        match &mut sums.equations {
            Equations::Gram(folds) => folds.par_iter_mut().zip(parts).try_for_each(|(sum, visits)| {
                Ok::<(), IdentifyError>(sum.merge(&gram(
                    model,
                    block,
                    &visits,
                    self.noise,
                    &self.at,
                    Some(&self.kept),
                )?)?)
            })?,
            Equations::Triangle(folds) => folds.par_iter_mut().zip(parts).try_for_each(|(sum, visits)| {
                let lineariser = Lineariser::new(model, block, self.noise, &self.at)?.of_columns(&self.kept);
                Ok::<(), IdentifyError>(sum.merge(&accumulate(lineariser, &visits, 0..visits.len())?)?)
            })?,
        }
        Ok(sums)
    }
}

impl Sums {
    /// Takes in what the next block came to.
    ///
    /// # Errors
    /// When it is of another pass.
    pub fn merge(&mut self, next: &Sums) -> Result<(), IdentifyError> {
        match (&mut self.equations, &next.equations) {
            (Equations::Gram(sums), Equations::Gram(more)) if sums.len() == more.len() => {
                sums.iter_mut().zip(more).try_for_each(|(sum, more)| sum.merge(more))?;
            }
            (Equations::Triangle(sums), Equations::Triangle(more)) if sums.len() == more.len() => {
                sums.iter_mut().zip(more).try_for_each(|(sum, more)| sum.merge(more))?;
            }
            _ => return Err(IdentifyError::NotStreamed { why: "these sums are of another pass".into() }),
        }
        self.domain.widen(&next.domain);
        self.rows += next.rows;
        self.visits += next.visits;
        self.observations += next.observations;
        Ok(())
    }
}

/// What the last pass adds up: residuals of positions (m) and orientations (rad). Merged in any order it is the same to the last bit.
#[derive(Debug, Clone, Default)]
pub struct Judged {
    /// Positions.
    pub position: Tally,
    /// Orientations.
    pub orientation: Tally,
    /// Positions held out, of all rows.
    pub held_position: Tally,
    /// Orientations held out.
    pub held_orientation: Tally,
    /// Positions held out, of each fold.
    pub folds: Vec<Tally>,
}

impl Judged {
    /// Takes in what other blocks came to.
    pub fn merge(&mut self, other: &Judged) {
        self.folds.resize(self.folds.len().max(other.folds.len()), Tally::default());
        self.position.merge(&other.position);
        self.orientation.merge(&other.orientation);
        self.held_position.merge(&other.held_position);
        self.held_orientation.merge(&other.held_orientation);
        self.folds.iter_mut().zip(&other.folds).for_each(|(into, more)| into.merge(more));
    }
}

impl JudgePass {
    /// What a block comes to: residuals of the fit, and of each fold with the change of the coefficients that leaving it out makes.
    ///
    /// # Errors
    /// When the block lacks a signal of the model, or does not fit the robot.
    pub fn judged(&self, block: &Dataset) -> Result<Judged, IdentifyError> {
        let mut judged = Judged { folds: vec![Tally::default(); self.changes.len()], ..Judged::default() };
        let (model, at) = (self.fitted.model(), self.fitted.coefficients());
        let residuals = left_over(model, block, at, &vec![0.0; at.len()])?;
        add(&mut judged.position, &mut judged.orientation, &residuals);
        if self.changes.is_empty() {
            return Ok(judged);
        }
        let parts: Vec<Residuals> = by_fold(block, self.changes.len())
            .into_par_iter()
            .zip(&self.changes)
            .map(|(visits, change)| {
                let rows: Vec<usize> = visits.rows.into_iter().flatten().collect();
                left_over(model, &block.select(&rows), at, change)
            })
            .collect::<Result<_, _>>()?;
        for (part, fold) in parts.iter().zip(&mut judged.folds) {
            add(&mut judged.held_position, &mut judged.held_orientation, part);
            fold.add((0..part.position.len()).filter_map(|row| part.distance(row)));
        }
        Ok(judged)
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
