//! Where a shape parameter is tried before anything is descended into.
//!
//! | search | tried |
//! | --- | --- |
//! | smooth | 40 values, in even ratios where the range spans a factor of four |
//! | period P | even steps of 1/P, six to a valley: valleys of harmonic h over a travel R are 1/(h R) wide |
//! | instant | the middle of every gap between two rows; every n-th where there are many |

use truepose_errormodel::{Dataset, NonlinearParameter, Search};

/// From, to.
pub(super) type Range = [f64; 2];

const SMOOTH: usize = 40;
/// Steps to a valley in 1/P.
const FINENESS: f64 = 6.0;
/// Values at most: beyond that a range of periods is too wide for its travel, and steps get longer.
const MOST: usize = 5000;
const LEAST: usize = 24;

/// Values to try, ascending.
pub(super) fn values(
    shape: &NonlinearParameter,
    data: &Dataset,
    chain: &truepose_kinematics::Chain,
) -> Vec<f64> {
    let (lower, upper) = (shape.lower, shape.upper);
    match shape.search {
        Search::Smooth if lower > 0.0 && upper / lower >= 4.0 => {
            even(SMOOTH, lower.ln(), upper.ln()).map(f64::exp).map(|v| v.clamp(lower, upper)).collect()
        }
        Search::Smooth => even(SMOOTH, lower, upper).collect(),
        Search::Period(joint, harmonic) => {
            let column = chain.coordinate(joint).and_then(|k| data.joints.get(k));
            let seen = column.into_iter().flatten();
            let (low, high) =
                seen.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
            let travel = (high - low).max(0.0) * f64::from(harmonic);
            let valleys = travel * (1.0 / lower - 1.0 / upper);
            let count = (FINENESS * valleys).ceil().clamp(LEAST as f64, MOST as f64) as usize;
            let mut list: Vec<f64> =
                even(count, 1.0 / upper, 1.0 / lower).map(|f| (1.0 / f).clamp(lower, upper)).collect();
            list.reverse();
            list
        }
        Search::Instant => {
            let all = gaps(shape, data);
            let step = all.len().div_ceil(200).max(1);
            all.iter().step_by(step).map(|gap| 0.5 * (gap[0] + gap[1])).collect()
        }
    }
}

/// The gaps between rows within the range, each from the last instant before it to the first after it; at its ends as well. Most lie between
/// visits, but what happens may happen during one.
pub(super) fn gaps(shape: &NonlinearParameter, data: &Dataset) -> Vec<[f64; 2]> {
    let mut times: Vec<f64> = data.time.iter().copied().filter(|t| t.is_finite()).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let between = times.windows(2).map(|pair| [pair[0], pair[1]]);
    between.filter(|gap| gap[1] >= shape.lower && gap[0] <= shape.upper).collect()
}

/// `count` values from `from` to `to`, both included.
fn even(count: usize, from: f64, to: f64) -> impl Iterator<Item = f64> {
    (0..count).map(move |k| from + (to - from) * k as f64 / (count - 1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::{JointId, samples};

    fn shape(lower: f64, upper: f64, search: Search) -> NonlinearParameter {
        NonlinearParameter { name: "s".into(), unit: "1".into(), value: lower, lower, upper, search }
    }

    #[test]
    fn no_valley_of_a_period_is_stepped_over() {
        let chain = samples::ur10();
        let data = Dataset {
            joints: vec![(0..100).map(|k| f64::from(k) * 0.06 - 3.0).collect(); 6],
            ..Dataset::default()
        };
        let list = values(&shape(0.1, 2.0, Search::Period(JointId(2), 1)), &data, &chain);
        assert!((list[0] - 0.1).abs() < 1e-12 && (list[list.len() - 1] - 2.0).abs() < 1e-12);
        // From one value to the next the wave slips by at most a sixth of a period over the travel.
        let travel = 0.06 * 99.0;
        let slip = list.windows(2).map(|p| travel * (1.0 / p[0] - 1.0 / p[1]));
        assert!(slip.fold(0.0, f64::max) < 1.01 / FINENESS);
        assert!(list.windows(2).all(|p| p[0] < p[1]));
    }

    #[test]
    fn instants_lie_between_rows() {
        let chain = samples::ur10();
        let data = Dataset {
            visit: vec![1, 1, 0, 0, 2, 2],
            time: vec![10.0, 11.0, 0.0, 0.0, 20.0, 21.0],
            ..Dataset::default()
        };
        let free = shape(2.0, 20.5, Search::Instant);
        assert_eq!(gaps(&free, &data), [[0.0, 10.0], [10.0, 11.0], [11.0, 20.0], [20.0, 21.0]]);
        assert_eq!(values(&free, &data, &chain), [5.0, 10.5, 15.5, 20.5]);
    }
}
