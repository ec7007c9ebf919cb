//! Landmarks: what rows share beside the robot, as a point of the surroundings that a target touched, wherever that is.
//!
//! The landmark of a row is a channel, [`LANDMARK`]: 0 where something else was measured, k for the k-th landmark. The measured position of
//! such a row is where the landmark is taken to be; what is left of that is an unknown ([`crate::effects::Landmarks`]).

use super::table::Dataset;

/// The channel of the landmark's number. No file can have a column of this name, and no cause is looked for in it.
pub const LANDMARK: &str = "landmark~";

impl Dataset {
    /// The landmark that a row touched, by its number from zero; none where something else was measured.
    pub fn landmark(&self, row: usize) -> Option<usize> {
        // Numbers are small and whole.
        (self.landmarks()?[row] as usize).checked_sub(1)
    }

    /// The number of each row's landmark, from one; none where no landmark was touched.
    pub fn landmarks(&self) -> Option<&[f64]> {
        self.schema.channel(LANDMARK).map(|k| self.channels[k].as_slice())
    }

    /// With these landmarks, one a row; none where nothing was touched.
    pub fn set_landmarks(&mut self, of_row: Option<&[Option<usize>]>) {
        let numbers = |of: &[Option<usize>]| of.iter().map(|k| k.map_or(0.0, |k| (k + 1) as f64)).collect();
        self.set_numbers(LANDMARK, of_row.map(numbers));
    }
}
