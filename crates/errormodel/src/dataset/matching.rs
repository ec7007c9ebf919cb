//! Rows of one configuration and of one dwell, as [`super::dwell`] defines them.

use super::table::Dataset;
use truepose_kinematics::Load;

impl Dataset {
    /// True when both rows have the same joint values, to the tolerance of [`Dataset::dwell`], and the same load.
    pub fn same_configuration(&self, a: usize, b: usize) -> bool {
        self.same_joints(a, b) && self.load[a] == self.load[b]
    }

    /// True when both rows have the same joint values, to the tolerance of [`Dataset::dwell`].
    pub(super) fn same_joints(&self, a: usize, b: usize) -> bool {
        self.joints
            .iter()
            .enumerate()
            .all(|(k, column)| (column[a] - column[b]).abs() <= self.dwell.tolerance(k))
    }

    /// True when both rows have the same joint values and the same load to the last bit.
    pub(crate) fn same_inputs(&self, a: usize, b: usize) -> bool {
        self.joints.iter().all(|column| column[a].to_bits() == column[b].to_bits())
            && self.load[a] == self.load[b]
    }

    /// True when a row goes on with the dwell that began at row `first`, all rows from there on being of that dwell: the same
    /// configuration, and no target far from where it was first measured in that dwell.
    pub fn continues_dwell(&self, first: usize, row: usize) -> bool {
        self.same_configuration(first, row) && !self.moved(first, row)
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
