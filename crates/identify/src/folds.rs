//! Subsets of the configurations for cross-validation.
//!
//! The unit is the configuration: all rows of a visit, and all visits of equal joints and load, are in one fold.

use crate::IdentifyError;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use truepose_errormodel::{Dataset, Visits, configurations};

/// How the configurations are divided.
#[derive(Debug, Clone, PartialEq)]
pub enum Split {
    /// At random into this many folds.
    Random {
        /// How many folds.
        folds: usize,
        /// Seed of the shuffle.
        seed: u64,
    },
    /// One configuration at a time.
    LeaveOneOut,
    /// Contiguous blocks in time (by row where the data has no time).
    TimeBlocks {
        /// How many.
        folds: usize,
    },
    /// Slabs of equal count along the joint coordinate with the widest spread relative to its range, or along one
    /// given by its position among the movable joints.
    JointBlocks {
        /// How many.
        folds: usize,
        /// The coordinate; the principal direction of the configurations when absent.
        coordinate: Option<usize>,
    },
    /// The caller's own: a fold number for each visit.
    Given(Vec<usize>),
}

/// The fold of each visit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Folds {
    /// 0… for each visit.
    pub of_visit: Vec<usize>,
    /// How many folds.
    pub count: usize,
}

impl Folds {
    /// Divides the configurations of a data set.
    ///
    /// # Errors
    /// [`IdentifyError::TooFewFolds`] when there are fewer configurations than folds.
    pub fn new(data: &Dataset, split: &Split) -> Result<Self, IdentifyError> {
        let visits = Visits::of(data);
        let configuration = configurations(data);
        let count = configuration.iter().max().map_or(0, |last| last + 1);
        let enough = |folds: usize| {
            if folds >= 2 && folds <= count {
                Ok(())
            } else {
                Err(IdentifyError::TooFewFolds { have: count, need: folds })
            }
        };
        // First visit of each configuration, for orders in time or space.
        let mut first = vec![usize::MAX; count];
        for (visit, &c) in configuration.iter().enumerate() {
            first[c] = first[c].min(visit);
        }
        let row_of = |c: usize| visits.rows[first[c]][0];
        let by_key = |folds: usize, key: &dyn Fn(usize) -> f64| {
            let mut order: Vec<usize> = (0..count).collect();
            order.sort_by(|&a, &b| key(a).total_cmp(&key(b)).then(a.cmp(&b)));
            let mut fold = vec![0; count];
            for (place, &c) in order.iter().enumerate() {
                fold[c] = place * folds / count;
            }
            fold
        };
        let (fold, folds) = match split {
            Split::Random { folds, seed } => {
                enough(*folds)?;
                let order = shuffled(data, &configuration, count, *seed);
                let mut fold = vec![0; count];
                for (place, &c) in order.iter().enumerate() {
                    fold[c] = place % folds;
                }
                (fold, *folds)
            }
            Split::LeaveOneOut => {
                enough(count.max(2))?;
                ((0..count).collect(), count)
            }
            Split::TimeBlocks { folds } => {
                enough(*folds)?;
                let time = |c: usize| if data.schema.time { data.time[row_of(c)] } else { row_of(c) as f64 };
                (by_key(*folds, &time), *folds)
            }
            Split::JointBlocks { folds, coordinate } => {
                enough(*folds)?;
                let coordinate = coordinate.unwrap_or_else(|| widest(data)).min(data.joints.len() - 1);
                (by_key(*folds, &|c| data.joints[coordinate][row_of(c)]), *folds)
            }
            Split::Given(of_visit) => {
                if of_visit.len() != visits.len() {
                    return Err(IdentifyError::TooFewFolds { have: of_visit.len(), need: visits.len() });
                }
                let folds = of_visit.iter().max().map_or(0, |last| last + 1);
                return Ok(Folds { of_visit: of_visit.clone(), count: folds });
            }
        };
        Ok(Folds { of_visit: configuration.iter().map(|&c| fold[c]).collect(), count: folds })
    }

    /// The visits of a fold.
    pub fn members(&self, fold: usize) -> Vec<usize> {
        (0..self.of_visit.len()).filter(|&visit| self.of_visit[visit] == fold).collect()
    }
}

/// The configurations in a random order. Where rows have a time the draw depends on it, and not on the order of the rows in a file.
fn shuffled(data: &Dataset, configuration: &[usize], count: usize, seed: u64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    if data.schema.time {
        let mut earliest = vec![f64::INFINITY; count];
        for (&visit, &time) in data.visit.iter().zip(&data.time) {
            let first = &mut earliest[configuration[visit]];
            *first = first.min(time);
        }
        order.sort_by(|&a, &b| earliest[a].total_cmp(&earliest[b]).then(a.cmp(&b)));
    }
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    order
}

/// The joint with the largest standard deviation.
fn widest(data: &Dataset) -> usize {
    let spread = |column: &[f64]| {
        let n = column.len().max(1) as f64;
        let mean = column.iter().sum::<f64>() / n;
        column.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n
    };
    (0..data.joints.len())
        .max_by(|&a, &b| spread(&data.joints[a]).total_cmp(&spread(&data.joints[b])).then(b.cmp(&a)))
        .unwrap_or(0)
}

/// Splits the rows of a data set into a training and a held-out part: `share` of the configurations, drawn at
/// random from this seed.
///
/// # Errors
/// When there are too few configurations for both parts to have one.
pub fn hold_out(data: &Dataset, share: f64, seed: u64) -> Result<(Vec<usize>, Vec<usize>), IdentifyError> {
    if !(share > 0.0 && share < 1.0) {
        return Err(IdentifyError::Option { option: "holdout", value: share, expected: "between 0 and 1" });
    }
    let configuration = configurations(data);
    let count = configuration.iter().max().map_or(0, |last| last + 1);
    let held = ((count as f64 * share).round() as usize).max(1);
    if held >= count {
        let expected = "so small that a configuration is left to fit";
        return Err(IdentifyError::Option { option: "holdout", value: share, expected });
    }
    let order = shuffled(data, &configuration, count, seed);
    let mut out = vec![false; count];
    order[..held].iter().for_each(|&c| out[c] = true);
    Ok((0..data.len()).partition(|&row| !out[configuration[data.visit[row]]]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::Load;

    /// Poses of one joint, a minute after each other, in this order of rows.
    fn poses(order: &[usize]) -> Dataset {
        let n = order.len();
        let mut data = Dataset {
            joints: vec![order.iter().map(|&k| 0.1 * k as f64).collect()],
            position: vec![[0.0; 3]; n],
            visit: (0..n).collect(),
            load: vec![Load::None; n],
            time: order.iter().map(|&k| 60.0 * k as f64).collect(),
            ..Dataset::default()
        };
        data.schema.time = true;
        data.dwell.joints = vec![1e-5];
        data
    }

    #[test]
    fn the_order_of_rows_draws_no_other_poses() {
        let plain: Vec<usize> = (0..40).collect();
        let permuted: Vec<usize> = plain.iter().map(|k| (17 * k + 5) % 40).collect();
        let (a, b) = (poses(&plain), poses(&permuted));
        let held = |data: &Dataset| {
            let mut times: Vec<f64> =
                hold_out(data, 0.2, 3).unwrap().1.iter().map(|&row| data.time[row]).collect();
            times.sort_by(f64::total_cmp);
            times
        };
        assert_eq!(held(&a), held(&b));
        let fold = |data: &Dataset| {
            let folds = Folds::new(data, &Split::Random { folds: 5, seed: 1 }).unwrap();
            let mut all: Vec<(u64, usize)> =
                (0..40).map(|row| (data.time[row].to_bits(), folds.of_visit[data.visit[row]])).collect();
            all.sort_unstable();
            all
        };
        assert_eq!(fold(&a), fold(&b));
    }
}
