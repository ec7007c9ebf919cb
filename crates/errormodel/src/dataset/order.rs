//! The order of the rows in place of a time that nobody wrote down.

use super::table::Dataset;

impl Dataset {
    /// The data with the number of its pose measurement, 1…, as the time of each row; as it is where it has a time.
    ///
    /// What changed while the robot was measured shows in that order. Where a later pose stands in it is not known, so that fits are made
    /// independent of it before they are used ([`FittedModel::without_order`](crate::FittedModel::without_order)).
    #[must_use]
    pub fn ordered(mut self) -> Self {
        if !self.schema.time {
            self.time = self.visit.iter().map(|&visit| visit as f64 + 1.0).collect();
            (self.schema.time, self.by_order) = (true, true);
        }
        self
    }

    /// Whether rows carry a time that a clock showed.
    pub fn has_clock(&self) -> bool {
        self.schema.time && !self.by_order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_order_stands_in_for_a_time_and_never_for_a_known_one() {
        let data = Dataset { visit: vec![0, 0, 1], time: vec![0.0; 3], ..Dataset::default() };
        let ordered = data.clone().ordered();
        assert_eq!(
            (ordered.time.as_slice(), ordered.by_order, ordered.has_clock()),
            (&[1.0, 1.0, 2.0][..], true, false)
        );
        let mut timed = Dataset { time: vec![5.0, 6.0, 9.0], ..data };
        timed.schema.time = true;
        assert_eq!(timed.clone().ordered(), timed);
        assert!(timed.has_clock());
    }
}
