//! The two halves of the study, and what is drawn from them.
//!
//! ```text
//! generator    ChaCha8, key = (series − 1) · 2⁴⁸ + kind · 2⁴⁰ + cell · 2³² + number,   stream = constant of the half · 2³² + part
//! seeds        63 bits of that generator, the highest bit = the half
//! ```
//!
//! A robot is given by its half, its series, its kind, its cell where cells have robots of their own (0 elsewhere) and its number, and by nothing
//! else. The halves have different streams of the
//! generator (no state of one is a state of the other), and seeds that are passed on to a plant or a campaign differ in
//! their highest bit, so that no plant, campaign or noise of one half can occur in the other. A later series of a half is
//! for a locked half that was looked at: other robots of the same description.

use crate::prelude::*;

/// What is drawn; each part has a stream of its own, so that one more draw leaves the other parts as they were.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    Description = 1,
    Robot,
    Cause,
    Plant,
    Campaign,
    Noise,
    Replicates,
    Fresh,
    Reference,
}

/// The number of a robot within a kind, a series and a half.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Key {
    pub half: Half,
    /// Which robots of the half, from 1.
    pub series: u64,
    /// Number of the kind of campaign.
    pub kind: u64,
    /// Number of the cell, from 1, where each cell has robots of its own; 0 where cells are the same robots under other conditions.
    pub cell: u64,
    pub number: u64,
}

impl Key {
    /// The generator of a part.
    pub fn draw(self, part: Part) -> Draw {
        let earlier = self.series.saturating_sub(1);
        let seed = earlier << 48 | self.kind << 40 | self.cell << 32 | self.number;
        Draw::of(seed, self.half.letters() << 32 | part as u64)
    }

    /// A seed for a part, of this half alone.
    pub fn seed(self, part: Part) -> u64 {
        self.draw(part).seed() | u64::from(self.half == Half::Locked) << 63
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    const PARTS: [Part; 9] = {
        use Part::*;
        [Description, Robot, Cause, Plant, Campaign, Noise, Replicates, Fresh, Reference]
    };

    fn keys(half: Half, series: u64) -> impl Iterator<Item = Key> {
        (0..12).flat_map(move |kind| (0..200).map(move |number| Key { half, series, kind, cell: 0, number }))
    }

    fn seeds(half: Half, series: u64) -> HashSet<u64> {
        keys(half, series).flat_map(|key| PARTS.map(|part| key.seed(part))).collect()
    }

    #[test]
    fn the_halves_have_no_seed_and_no_stream_in_common() {
        let (tuning, locked) = (seeds(Half::Tuning, 1), seeds(Half::Locked, 1));
        assert!(tuning.iter().all(|seed| seed >> 63 == 0));
        assert!(locked.iter().all(|seed| seed >> 63 == 1));
        // Within a half no two parts of any two robots share a seed either.
        assert_eq!(tuning.len(), 12 * 200 * 9);
        assert_eq!(locked.len(), 12 * 200 * 9);
        // The lower bits differ as well: one half is not the other with a bit set.
        let low = |set: &HashSet<u64>| -> HashSet<u64> { set.iter().map(|seed| seed << 1).collect() };
        assert!(low(&tuning).is_disjoint(&low(&locked)));
    }

    #[test]
    fn a_later_series_has_no_seed_of_an_earlier_one() {
        let (first, second) = (seeds(Half::Locked, 1), seeds(Half::Locked, 2));
        assert_eq!(second.len(), 12 * 200 * 9);
        assert!(first.is_disjoint(&second) && second.iter().all(|seed| seed >> 63 == 1));
        assert!(second.is_disjoint(&seeds(Half::Locked, 3)));
        // The first series is that of the tables that are published: its seeds do not change.
        let key = Key { half: Half::Tuning, series: 1, kind: 2, cell: 0, number: 5 };
        let mut known = Draw::of(2 << 40 | 5, 0x5455_4e45 << 32 | Part::Noise as u64);
        assert_eq!(key.seed(Part::Noise), known.seed());
    }

    #[test]
    fn a_key_draws_the_same_numbers_again() {
        let key = Key { half: Half::Tuning, series: 1, kind: 3, cell: 0, number: 17 };
        let numbers = |key: Key| {
            let mut draw = key.draw(Part::Robot);
            (0..20).map(|_| draw.normal().to_bits()).collect::<Vec<_>>()
        };
        assert_eq!(numbers(key), numbers(key));
        assert_ne!(numbers(key), numbers(Key { half: Half::Locked, ..key }));
        assert_ne!(numbers(key), numbers(Key { number: 18, ..key }));
        assert_ne!(numbers(key), numbers(Key { cell: 1, ..key }));
        assert_eq!(key.seed(Part::Noise), key.seed(Part::Noise));
    }
}
