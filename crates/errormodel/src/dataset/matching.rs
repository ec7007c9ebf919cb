//! Rows of one configuration and of one dwell, as [`super::dwell`] defines them.

use super::table::Dataset;
use truepose_kinematics::Load;

impl Dataset {
    /// True when both rows have the same joint values, to the tolerance of one dwell ([`Dataset::dwell`]), and the same load.
    pub fn same_place(&self, a: usize, b: usize) -> bool {
        let alike =
            |(k, column): (usize, &Vec<f64>)| (column[a] - column[b]).abs() <= self.dwell.tolerance(k);
        self.joints.iter().enumerate().all(alike) && self.load[a] == self.load[b]
    }

    /// The largest distance of a joint of two rows, in tolerances of one configuration ([`Dataset::dwell`]); none above one.
    pub(super) fn repeat_distance(&self, a: usize, b: usize) -> Option<f64> {
        let mut most = 0.0;
        for (k, column) in self.joints.iter().enumerate() {
            let (apart, tolerance) = ((column[a] - column[b]).abs(), self.dwell.repeat_tolerance(k));
            if apart > tolerance {
                return None;
            }
            most = f64::max(most, if tolerance > 0.0 { apart / tolerance } else { 0.0 });
        }
        Some(most)
    }

    /// True when both rows have the same joint values and the same load to the last bit.
    pub(crate) fn same_inputs(&self, a: usize, b: usize) -> bool {
        self.joints.iter().all(|column| column[a].to_bits() == column[b].to_bits())
            && self.load[a] == self.load[b]
            && self.tools().is_none_or(|tools| tools[a].to_bits() == tools[b].to_bits())
    }

    /// True when a row goes on with the dwell that began at row `first`, all rows from there on being of that dwell: the same
    /// place, and no target far from where it was first measured in that dwell.
    pub fn continues_dwell(&self, first: usize, row: usize) -> bool {
        self.same_place(first, row) && self.same_session(first, row) && !self.moved(first, row)
    }

    /// True when the measured position of a row says that the robot has moved since row `first`.
    fn moved(&self, first: usize, row: usize) -> bool {
        let [least, most] = self.dwell.position;
        if !most.is_finite() {
            return false;
        }
        let gap = |earlier: usize| {
            let square = (0..3)
                .map(|k| self.position[row][k] - self.position[earlier][k])
                .filter(|d| !d.is_nan())
                .map(|d| d * d);
            square.reduce(|a, b| a + b).map(f64::sqrt)
        };
        let same = |earlier: usize| self.target[earlier] == self.target[row];
        let Some((earlier, gap)) = (first..row).filter(|&r| same(r)).find_map(|r| gap(r).map(|gap| (r, gap)))
        else {
            return false;
        };
        let stated = [earlier, row]
            .iter()
            .flat_map(|&r| self.position_sd[r])
            .filter(|sd| !sd.is_nan())
            .fold(f64::NAN, f64::max);
        let limit = if stated.is_nan() { most } else { (10.0 * stated).clamp(least, most) };
        gap > limit
    }
}

/// Whether visits with these loads are repeats of each other where the joints are the same. A measured wrench is never the same twice: the
/// joints alone decide.
pub(super) fn same_load(a: &Load, b: &Load) -> bool {
    matches!((a, b), (Load::Wrench(_), Load::Wrench(_))) || a == b
}
