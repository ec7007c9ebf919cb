//! One line a robot.

use crate::prelude::*;

/// Of so many intervals, how many hold the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Count {
    pub held: usize,
    pub of: usize,
}

/// What became of one robot.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Record {
    pub seed: u64,
    pub robot: String,
    pub extra: String,
    pub visits: usize,
    /// Width of the prior that the data chose.
    #[serde(with = "number")]
    pub kappa: f64,
    /// p of the lack-of-fit test; NaN without one.
    #[serde(with = "number")]
    pub lack_of_fit: f64,
    pub seconds: f64,
    /// By statement.
    pub counts: BTreeMap<String, Count>,
    /// [`Record::ENDED`] with the shape that was found and its truth, or why not.
    pub story: String,
}

impl Record {
    pub const ENDED: &str = "ended";

    pub fn ended(&self) -> bool {
        self.story.starts_with(Record::ENDED)
    }

    /// One more interval.
    pub fn count(&mut self, what: &str, held: bool) {
        let count = self.counts.entry(what.to_owned()).or_default();
        count.of += 1;
        count.held += usize::from(held);
    }
}
