//! Repeated pose measurements that are gross errors: far from the median of their group.

use crate::numbers::{ByAim, Numbers, square};
use nalgebra::Vector3;
use truepose_errormodel::Visits;

/// Robust standard deviations from the median of its group beyond which a pose measurement is a gross error. Of normal noise whose variance
/// differs between poses by a factor of three, one in some 10⁷ is.
const GROSS: f64 = 8.0;

/// Largest share of the repeated pose measurements that are gross errors; of more, the scatter itself has two sizes.
const MOST_GROSS: f64 = 0.2;

/// The groups without the pose measurements that are gross errors. Deviations are from the median of a group, axis by axis, the mean over
/// targets; the standard deviation is that of their median over all groups. Of two pose measurements alone neither is the wrong one: both go.
pub(crate) fn without_gross(
    numbers: &Numbers<'_>,
    visits: &Visits,
    groups: &[Vec<usize>],
) -> Vec<Vec<usize>> {
    let mut deviations: Vec<Vec<f64>> = Vec::new();
    for group in groups {
        let mut values: ByAim<Vec<(usize, Vector3<f64>)>> = ByAim::new();
        for (at, &visit) in group.iter().enumerate() {
            for &row in &visits.rows[visit] {
                if let Some(value) = numbers.of(row) {
                    numbers.entry(&mut values, row).push((at, value));
                }
            }
        }
        let (mut squares, mut counts) = (vec![0.0; group.len()], vec![0.0; group.len()]);
        for of_target in values.values().flatten().map(|alike| &alike.of).filter(|of| of.len() > 1) {
            let middle =
                Vector3::from_fn(|axis, _| median(of_target.iter().map(|(_, value)| value[axis]).collect()));
            for (at, value) in of_target {
                squares[*at] += square(&(value - middle));
                counts[*at] += 1.0;
            }
        }
        deviations.push(
            squares.iter().zip(&counts).map(|(square, count)| square / f64::max(*count, 1.0)).collect(),
        );
    }
    let all: Vec<f64> = deviations.iter().flatten().copied().filter(|square| *square > 0.0).collect();
    let repeated: usize = groups.iter().map(Vec::len).sum();
    if all.is_empty() {
        return groups.to_vec();
    }
    let limit = GROSS * GROSS * median(all);
    let gross = deviations.iter().flatten().filter(|square| **square > limit).count();
    if gross == 0 || gross as f64 > MOST_GROSS * repeated as f64 {
        return groups.to_vec();
    }
    let clean = |(group, own): (&Vec<usize>, &Vec<f64>)| {
        group.iter().zip(own).filter(|(_, square)| **square <= limit).map(|(&visit, _)| visit).collect()
    };
    groups.iter().zip(&deviations).map(clean).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    let (count, middle) = (values.len(), values.len() / 2);
    let (below, &mut upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let lower = below.iter().copied().max_by(f64::total_cmp);
    lower.filter(|_| count.is_multiple_of(2)).map_or(upper, |lower| 0.5 * (lower + upper))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_median_is_between_two_values_or_one_of_them() {
        for (values, wanted) in
            [(vec![3.0, 1.0, 2.0], 2.0), (vec![4.0, 1.0, 2.0, 3.0], 2.5), (vec![7.0], 7.0)]
        {
            assert!((median(values) - wanted).abs() < 1e-12);
        }
    }
}
