//! Names of variants, in records, in tables and on the command line, and the two halves of the robots.

use clap::ValueEnum;

/// What clap knows of a variant.
pub trait Word: ValueEnum + 'static {
    /// Its name.
    fn word(&self) -> String {
        self.to_possible_value().map_or_else(String::new, |value| value.get_name().to_owned())
    }

    /// The variant with this name.
    fn named(word: &str) -> Option<Self> {
        Self::from_str(word, false).ok()
    }

    /// All variants in their order.
    fn all() -> &'static [Self] {
        Self::value_variants()
    }
}

impl<T: ValueEnum + 'static> Word for T {}

/// A half of the robots.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, ValueEnum)]
pub enum Half {
    /// For development: may be run and studied at any time.
    Tuning,
    /// For publication: run once at a commit, never while a constant is chosen.
    Locked,
}

impl Half {
    /// The letters TUNE and LOCK, a part of the key of every generator.
    pub fn letters(self) -> u64 {
        match self {
            Half::Tuning => 0x5455_4e45,
            Half::Locked => 0x4c4f_434b,
        }
    }

    /// The name of the tables of a series: the half, with the number of a later series.
    pub fn part(self, series: u64) -> String {
        if series == 1 { self.word() } else { format!("{}-{series}", self.word()) }
    }
}
