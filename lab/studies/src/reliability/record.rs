//! One line a robot.

use crate::journal::Line;
use std::collections::BTreeMap;

/// Of so many intervals, how many hold the truth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Count {
    pub held: usize,
    pub of: usize,
}

/// What became of one robot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Record {
    pub seed: u64,
    pub robot: String,
    pub extra: String,
    pub visits: usize,
    /// Width of the prior that the data chose.
    pub kappa: f64,
    /// p of the lack-of-fit test; NaN without one.
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

impl Line for Record {
    const HEADER: &'static str = "seed,robot,extra,visits,kappa,lack_of_fit,seconds,counts,story";

    fn row(&self) -> String {
        let counts: Vec<String> = self
            .counts
            .iter()
            .map(|(what, c)| format!("{}|{}|{}", what.replace(',', "_"), c.held, c.of))
            .collect();
        [
            self.seed.to_string(),
            self.robot.clone(),
            self.extra.clone(),
            self.visits.to_string(),
            self.kappa.to_string(),
            self.lack_of_fit.to_string(),
            self.seconds.to_string(),
            counts.join(";"),
            self.story.clone(),
        ]
        .join(",")
    }

    fn of(row: &str) -> Option<Self> {
        let cells: Vec<&str> = row.split(',').collect();
        let [seed, robot, extra, visits, kappa, lack_of_fit, seconds, counts, story] = cells[..] else {
            return None;
        };
        let count = |text: &str| {
            let parts: Vec<&str> = text.split('|').collect();
            let [what, held, of] = parts[..] else { return None };
            Some((what.replace('_', ","), Count { held: held.parse().ok()?, of: of.parse().ok()? }))
        };
        Some(Record {
            seed: seed.parse().ok()?,
            robot: robot.into(),
            extra: extra.into(),
            visits: visits.parse().ok()?,
            kappa: kappa.parse().ok()?,
            lack_of_fit: lack_of_fit.parse().ok()?,
            seconds: seconds.parse().ok()?,
            counts: counts.split(';').filter_map(count).collect(),
            story: story.into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_comes_back() {
        let mut record = Record {
            seed: 7,
            robot: "pps".into(),
            extra: "lag".into(),
            visits: 99,
            kappa: 0.1 + 0.2,
            lack_of_fit: 0.25,
            story: "ended".into(),
            ..Record::default()
        };
        record.count("constant errors, angles", true);
        record.count("constant errors, angles", false);
        record.count("lag", true);
        assert_eq!(Record::of(&record.row()), Some(record));
    }
}
