//! What an effect says at a posture: triples (column, site, value).

use truepose_kinematics::{Axis, JointKind, JointMotion, Site};

/// One triple: a unit of this column makes this much error at this site.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Entry {
    /// Which unknown.
    pub column: usize,
    /// Where the error appears.
    pub site: Site,
    /// Error at the site (m or rad) per unit of the coefficient.
    pub value: f64,
}

/// The non-zero entries of Φ at one posture. Two consumers read the same emission: the design matrix, and
/// the evaluation of a fitted model.
#[derive(Debug, Clone, Default)]
pub struct Emission {
    entries: Vec<Entry>,
    first_column: usize,
}

impl Emission {
    /// Without entries.
    pub fn new() -> Self {
        Emission::default()
    }

    /// With memory for so many entries, so that pushing them does not allocate.
    pub fn with_capacity(entries: usize) -> Self {
        Emission { entries: Vec::with_capacity(entries), first_column: 0 }
    }

    /// Forgets all entries and keeps the memory.
    pub fn clear(&mut self) {
        self.entries.clear();
        self.first_column = 0;
    }

    /// From here on, an effect's column 0 is this column of the model.
    #[inline]
    pub(crate) fn start_at(&mut self, first_column: usize) {
        self.first_column = first_column;
    }

    /// Per unit of the effect's own column, the error at this site is `value`.
    #[inline]
    pub fn push(&mut self, column: usize, site: Site, value: f64) {
        self.entries.push(Entry { column: self.first_column + column, site, value });
    }

    /// Per unit of the effect's own column, the joint moves by `value` (rad or m) beyond what it says:
    /// spread over the sites that the joint's own motion touches.
    #[inline]
    pub fn along(&mut self, column: usize, motion: &JointMotion, value: f64) {
        let first = if motion.kind == JointKind::Prismatic { 0 } else { 3 };
        for direction in 0..3 {
            let share = motion.axis[direction];
            if share != 0.0 {
                self.push(column, Site::Frame(motion.frame, Axis::ALL[first + direction]), value * share);
            }
        }
    }

    /// Forgets all but the first entries and keeps the memory.
    pub(crate) fn truncate(&mut self, entries: usize) {
        self.entries.truncate(entries);
    }

    /// All triples so far.
    #[inline]
    pub fn entries(&self) -> &[Entry] {
        &self.entries
    }
}
