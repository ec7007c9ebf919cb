//! Of many channels those that say the most different things.
//!
//! Fifty thermometers in one hall follow each other. What is proposed of every pair of channels, or of each at a dozen time constants, is
//! proposed of a few of them: Gram–Schmidt with pivots on the standardised columns (Golub and Businger 1965). What was measured of the robot has
//! no say in it, so that the distribution of the screen under the null hypothesis holds as it is.

use truepose_errormodel::Dataset;

/// A column of which the chosen ones leave less than this share of its squares says nothing of its own.
const NOTHING: f64 = 1e-6;

/// At most so many of these channels, in their order; all of them where they are not more.
pub(crate) fn independent(data: &Dataset, channels: &[usize], most: usize) -> Vec<usize> {
    if channels.len() <= most {
        return channels.to_vec();
    }
    let mut left: Vec<Vec<f64>> = channels.iter().map(|&k| standardised(&data.channels[k])).collect();
    let mut chosen = Vec::new();
    while chosen.len() < most {
        let squares: Vec<f64> = left.iter().map(|column| column.iter().map(|v| v * v).sum()).collect();
        let best = (0..left.len()).max_by(|&a, &b| squares[a].total_cmp(&squares[b]).then(b.cmp(&a)));
        let Some(best) = best.filter(|&best| squares[best] > NOTHING) else { break };
        chosen.push(best);
        let along: Vec<f64> = left[best].iter().map(|v| v / squares[best].sqrt()).collect();
        for column in &mut left {
            let share: f64 = column.iter().zip(&along).map(|(a, b)| a * b).sum();
            column.iter_mut().zip(&along).for_each(|(v, along)| *v -= share * along);
        }
        left[best].fill(0.0);
    }
    chosen.sort_unstable();
    chosen.into_iter().map(|k| channels[k]).collect()
}

/// Without its mean, of length one; zeros where it does not change.
fn standardised(column: &[f64]) -> Vec<f64> {
    let mean = column.iter().sum::<f64>() / column.len().max(1) as f64;
    let length = column.iter().map(|v| (v - mean).powi(2)).sum::<f64>().sqrt();
    let by = if length > 1e-9 * (mean.abs() + 1.0) && length.is_finite() { 1.0 / length } else { 0.0 };
    column.iter().map(|v| (v - mean) * by).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn data() -> Dataset {
        // A hall's temperature in six columns, a motor's in one, a constant.
        let hall = |k: usize| (0..50).map(move |row| (0.2 * row as f64).sin() + 1e-3 * (row * k % 7) as f64);
        let mut channels: Vec<Vec<f64>> = (0..6).map(|k| hall(k).collect()).collect();
        channels.insert(3, (0..50).map(|row| 40.0 + 0.1 * row as f64).collect());
        channels.push(vec![21.0; 50]);
        Dataset { channels, ..Dataset::default() }
    }

    #[test]
    fn few_are_all_of_them_and_of_many_the_different_ones_are_taken() {
        let data = data();
        assert_eq!(independent(&data, &[0, 1, 7], 3), [0, 1, 7]);
        let two = independent(&data, &(0..8).collect::<Vec<_>>(), 2);
        assert!(two.contains(&3) && two.iter().any(|k| ![3, 7].contains(k)), "{two:?}");
        // A channel that never changed is none.
        assert!(!independent(&data, &(0..8).collect::<Vec<_>>(), 7).contains(&7));
    }
}
