//! What effects say in a block of rows: which column makes how much error at which site, with a value a lane.

use super::standing::Standing;
use super::width::LANES;
use crate::Entry;
use nalgebra::Vector3;
use truepose_kinematics::{Axis, Chain, FrameId, JointKind, JointMotion, Site};

/// Values of one function in a block; several entries may share them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LaneValue(pub(crate) u32);

/// One triple (column, site, factor · value).
#[derive(Debug, Clone, Copy)]
pub(crate) struct LaneEntry {
    pub column: u32,
    pub site: Site,
    pub value: LaneValue,
    pub factor: f64,
}

/// The non-zero entries of Φ in a block of rows.
#[derive(Debug, Clone)]
pub struct LaneEmission {
    pub(crate) entries: Vec<LaneEntry>,
    /// Value k: `LANES` numbers; value 0 is one everywhere.
    values: Vec<f64>,
    first_column: usize,
    /// The value of each column at each site that was taken lane by lane.
    places: Vec<Option<LaneValue>>,
}

impl LaneEmission {
    /// One everywhere.
    pub const ONE: LaneValue = LaneValue(0);

    /// Without entries.
    pub(crate) fn new() -> Self {
        LaneEmission { entries: Vec::new(), values: vec![1.0; LANES], first_column: 0, places: Vec::new() }
    }

    pub(crate) fn clear(&mut self) {
        self.entries.clear();
        self.values.truncate(LANES);
        self.first_column = 0;
    }

    /// From here on, an effect's column 0 is this column of the model.
    pub(crate) fn start_at(&mut self, first_column: usize) {
        self.first_column = first_column;
    }

    /// How many entries and values there are.
    pub(crate) fn mark(&self) -> usize {
        self.entries.len()
    }

    /// Forgets all but the first entries; values that only later ones have go, too.
    pub(crate) fn truncate(&mut self, entries: usize) {
        self.entries.truncate(entries);
        let last = self.entries.iter().map(|entry| entry.value.0 as usize).max().unwrap_or(0);
        self.values.truncate((last + 1) * LANES);
    }

    /// Gives every lane the values of its standstill.
    pub(crate) fn spread(&mut self, standing: &Standing) {
        standing.spread(&mut self.values[LANES..]);
    }

    /// Values that `fill` writes into `LANES` zeros; those beyond the rows of the block are read by nobody but have to be finite.
    #[inline]
    pub fn value(&mut self, fill: impl FnOnce(&mut [f64])) -> LaneValue {
        let at = self.values.len();
        self.values.resize(at + LANES, 0.0);
        fill(&mut self.values[at..]);
        LaneValue((at / LANES) as u32)
    }

    /// As [`LaneEmission::value`], of the first rows, row by row.
    #[inline]
    pub fn each(&mut self, rows: usize, of: impl Fn(usize) -> f64) -> LaneValue {
        self.value(|into| into[..rows].iter_mut().enumerate().for_each(|(row, value)| *value = of(row)))
    }

    /// As [`LaneEmission::value`], for so many values that are written together, one after the other.
    #[inline]
    pub fn values<F: FnOnce(&mut [f64])>(
        &mut self,
        count: usize,
        fill: F,
    ) -> impl Iterator<Item = LaneValue> + use<F> {
        let at = self.values.len();
        self.values.resize(at + count * LANES, 0.0);
        fill(&mut self.values[at..]);
        let first = (at / LANES) as u32;
        (first..first + count as u32).map(LaneValue)
    }

    /// The product of a value with another one's numbers.
    #[inline]
    pub fn product(&mut self, a: LaneValue, b: LaneValue) -> LaneValue {
        if a == Self::ONE {
            return b;
        }
        if b == Self::ONE {
            return a;
        }
        let (a, b) = (a.0 as usize * LANES, b.0 as usize * LANES);
        let at = self.values.len();
        self.values.resize(at + LANES, 0.0);
        let (old, new) = self.values.split_at_mut(at);
        for (new, (a, b)) in new.iter_mut().zip(old[a..a + LANES].iter().zip(&old[b..b + LANES])) {
            *new = a * b;
        }
        LaneValue((at / LANES) as u32)
    }

    /// Per unit of the effect's own column, the error at this site is `value`.
    #[inline]
    pub fn push(&mut self, column: usize, site: Site, value: LaneValue) {
        let column = (self.first_column + column) as u32;
        self.entries.push(LaneEntry { column, site, value, factor: 1.0 });
    }

    /// Per unit of the effect's own column, a frame moves by this vector (in its own axes) times `value`.
    #[inline]
    pub(crate) fn shift(&mut self, column: usize, frame: FrameId, vector: &Vector3<f64>, value: LaneValue) {
        let column = (self.first_column + column) as u32;
        for axis in Axis::TRANSLATIONS {
            let factor = vector[axis.direction()];
            if factor != 0.0 {
                self.entries.push(LaneEntry { column, site: Site::Frame(frame, axis), value, factor });
            }
        }
    }

    /// Per unit of the effect's own column, the joint moves by `value` (rad or m) beyond what it says.
    #[inline]
    pub fn along(&mut self, column: usize, motion: &JointMotion, value: LaneValue) {
        let first = if motion.kind == JointKind::Prismatic { 0 } else { 3 };
        let column = (self.first_column + column) as u32;
        for direction in 0..3 {
            let factor = motion.axis[direction];
            if factor != 0.0 {
                let site = Site::Frame(motion.frame, Axis::ALL[first + direction]);
                self.entries.push(LaneEntry { column, site, value, factor });
            }
        }
    }

    /// Numbers of a value.
    pub(crate) fn numbers(&self, value: LaneValue) -> &[f64] {
        &self.values[value.0 as usize * LANES..][..LANES]
    }

    /// How many values there are.
    pub(crate) fn count(&self) -> usize {
        self.values.len() / LANES
    }

    /// Begins to take what another way of asking finds, lane by lane, of the columns of a model.
    pub(crate) fn begin(&mut self, columns: usize, chain: &Chain) {
        self.places.clear();
        self.places.resize(columns * chain.site_count(), None);
    }

    /// The entries of one lane. Lanes may speak of different columns, as of different pieces of a curve: what all of them say of a column at a site is one
    /// entry.
    pub(crate) fn take(&mut self, lane: usize, entries: &[Entry], chain: &Chain) {
        for entry in entries {
            let place = entry.column * chain.site_count() + chain.site_index(entry.site);
            let value = match self.places[place] {
                Some(value) => value,
                None => {
                    let value = self.value(|_| {});
                    self.places[place] = Some(value);
                    let (column, site) = (entry.column as u32, entry.site);
                    self.entries.push(LaneEntry { column, site, value, factor: 1.0 });
                    value
                }
            };
            self.values[value.0 as usize * LANES + lane] += entry.value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn lanes_that_speak_of_different_columns_share_their_entries() {
        let chain = samples::ur10();
        let site = Site::Frame(FrameId(1), Axis::Rz);
        let entry = |column: usize| Entry { column, site, value: 10.0 * column as f64 };
        let mut emission = LaneEmission::new();
        emission.begin(4, &chain);
        // Pieces of a curve: two of them at each lane, in another order each time.
        for (lane, columns) in [[2, 3], [0, 1], [1, 2], [3, 0]].into_iter().enumerate() {
            emission.take(lane, &columns.map(entry), &chain);
        }
        let mut columns: Vec<u32> = emission.entries.iter().map(|entry| entry.column).collect();
        columns.sort_unstable();
        assert_eq!(columns, [0, 1, 2, 3]);
        let of = |column: u32| {
            let found = emission.entries.iter().find(|entry| entry.column == column);
            found.map(|entry| emission.numbers(entry.value)[..4].to_vec())
        };
        assert_eq!(of(2), Some(vec![20.0, 0.0, 20.0, 0.0]));
        assert_eq!(of(3), Some(vec![30.0, 0.0, 0.0, 30.0]));
    }
}
