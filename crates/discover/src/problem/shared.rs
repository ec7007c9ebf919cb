//! What rows that are kept out have in common: a declared payload, or a stretch of the record.
//!
//! Gross errors come one by one. Of n poses k have rows that are kept out; n_L of them declare a level of payload, and c of the k do:
//!
//! ```text
//! level      p = levels · P(H ≥ c),         H hypergeometric of n, n_L, k
//! stretch    p = n · P(B ≥ c),              B binomial of w poses at k/n, the best stretch of w poses from one such pose to another
//! ```
//!
//! Where p is small, they are perhaps an effect that acts in a part of the record alone: a label that was wrong, a clamp that slipped. The
//! stretch is the scan statistic with Bonferroni's bound (Naus, *Approximations for distributions of scan statistics*, 1982).

use crate::data::payload;
use statrs::distribution::{Binomial, DiscreteCDF, Hypergeometric};
use truepose_errormodel::{Dataset, Visits};

/// Fewer poses than this have nothing in common.
const LEAST: usize = 4;
/// More poses than this are not looked for in one stretch: a longer one shows by a part of it, and the cost stays linear in the poses.
const MOST: usize = 100;

/// What rows have in common.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum InCommon {
    /// The payload that they declare, kg.
    Level(f64),
    /// The place in the record.
    Stretch,
}

/// Rows that have something in common.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Shared {
    pub what: InCommon,
    /// Those of the rows that were asked about that have it, ascending.
    pub rows: Vec<usize>,
    /// How probable it is by chance.
    pub p_value: f64,
}

/// The payload that these rows (ascending) declare more often than by chance would be with this probability.
pub(crate) fn level_of(data: &Dataset, rows: &[usize], chance: f64) -> Option<Shared> {
    let levels = payload::levels(data);
    if rows.is_empty() || levels.len() < 2 {
        return None;
    }
    let visits = Visits::of(data);
    let out = poses(data, rows, visits.len());
    let count = |of: &dyn Fn(usize) -> bool| (0..visits.len()).filter(|&visit| of(visit)).count();
    let k = count(&|visit| out[visit]);
    let one = |&level: &f64| {
        let declaring = payload::rows_at(data, (level, None));
        let with = poses(data, &declaring, visits.len());
        let (all, among) = (count(&|visit| with[visit]), count(&|visit| with[visit] && out[visit]));
        if among < LEAST {
            return None;
        }
        let distribution = Hypergeometric::new(visits.len() as u64, all as u64, k as u64).ok()?;
        let p_value = (levels.len() as f64 * distribution.sf(among as u64 - 1)).min(1.0);
        let own = rows.iter().copied().filter(|row| declaring.binary_search(row).is_ok()).collect();
        Some(Shared { what: InCommon::Level(level), rows: own, p_value })
    };
    let best = levels.iter().filter_map(one).min_by(|a, b| a.p_value.total_cmp(&b.p_value));
    best.filter(|shared| shared.p_value < chance)
}

/// The stretch of the record in which more of these rows (ascending) lie than by chance would with this probability.
pub(crate) fn stretch_of(data: &Dataset, rows: &[usize], chance: f64) -> Option<Shared> {
    let visits = Visits::of(data);
    let n = visits.len();
    let out = poses(data, rows, n);
    // In the order of time; rows of one time stay in theirs.
    let mut order: Vec<usize> = (0..n).filter(|&visit| !visits.rows[visit].is_empty()).collect();
    order.sort_by(|&a, &b| data.time[visits.rows[a][0]].total_cmp(&data.time[visits.rows[b][0]]));
    let places: Vec<usize> = (0..order.len()).filter(|&place| out[order[place]]).collect();
    let rate = places.len() as f64 / n.max(1) as f64;
    let mut best: Option<([usize; 2], f64)> = None;
    for first in 0..places.len() {
        for last in first + LEAST - 1..places.len().min(first + MOST) {
            let (c, w) = (last - first + 1, places[last] - places[first] + 1);
            let Ok(distribution) = Binomial::new(rate.min(1.0), w as u64) else { continue };
            let p = (n as f64 * distribution.sf(c as u64 - 1)).min(1.0);
            if best.is_none_or(|(_, least)| p < least) {
                best = Some(([places[first], places[last]], p));
            }
        }
    }
    let ([first, last], p_value) = best.filter(|&(_, p)| p < chance)?;
    let mut within = vec![false; n];
    order[first..=last].iter().for_each(|&visit| within[visit] = true);
    let own = rows.iter().copied().filter(|&row| within[data.visit[row]]).collect();
    Some(Shared { what: InCommon::Stretch, rows: own, p_value })
}

/// Which poses have some of these rows.
fn poses(data: &Dataset, rows: &[usize], count: usize) -> Vec<bool> {
    let mut some = vec![false; count];
    rows.iter().for_each(|&row| some[data.visit[row]] = true);
    some
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_errormodel::Schema;
    use truepose_kinematics::nalgebra::Vector3;
    use truepose_kinematics::{Load, Payload};

    /// 90 poses of two rows; each third declares 8 kg, the others none.
    fn record() -> Dataset {
        let mut data = Dataset { schema: Schema { time: true, ..Schema::default() }, ..Dataset::default() };
        for row in 0..180 {
            let mass = if row / 2 % 3 == 0 { 8.0 } else { 0.0 };
            data.load.push(Load::Payload(Payload { mass, com: Vector3::zeros() }));
            data.time.push((row / 2) as f64);
            data.visit.push(row / 2);
        }
        data
    }

    #[test]
    fn rows_of_one_level_and_of_one_stretch_are_recognised() {
        let data = record();
        let loaded: Vec<usize> = (0..180).filter(|row| row / 2 % 3 == 0 && (40..100).contains(row)).collect();
        let level = level_of(&data, &loaded, 1e-3).unwrap();
        assert_eq!((level.what, level.rows), (InCommon::Level(8.0), loaded.clone()));
        let stretch = stretch_of(&data, &[100, 102, 103, 104, 106, 170], 1e-3).unwrap();
        assert_eq!((stretch.what, stretch.rows), (InCommon::Stretch, vec![100, 102, 103, 104, 106]));
    }

    #[test]
    fn scattered_rows_have_nothing_in_common() {
        let data = record();
        for rows in [vec![], vec![4], vec![0, 6, 12], vec![3, 31, 60, 88, 120, 151]] {
            assert_eq!(level_of(&data, &rows, 1e-3), None, "{rows:?}");
            assert_eq!(stretch_of(&data, &rows, 1e-3), None, "{rows:?}");
        }
        // Of draws at random one in a thousand would; here none of forty.
        let mut state = 7u64;
        let mut draw = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 33) as usize % 180
        };
        for _ in 0..40 {
            let mut rows: Vec<usize> = (0..6).map(|_| draw()).collect();
            rows.sort_unstable();
            rows.dedup();
            assert!(level_of(&data, &rows, 1e-3).is_none() && stretch_of(&data, &rows, 1e-3).is_none());
        }
    }
}
