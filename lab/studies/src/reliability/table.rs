//! What the lines come to.
//!
//! ```text
//! c = Σ held / Σ of        s² = n/(n−1) Σ (held − c of)² / (Σ of)²        c ± 1.96 s
//! ```
//!
//! The sums go over robots: what is stated of one robot shares its noise, so that intervals of one robot are not independent
//! trials. Where each robot has one interval s is the binomial deviation.

use super::trial::{Record, WHAT};
use crate::discovery::record::{Interval, Record as Discovered};
use crate::discovery::summary::first_p;
use crate::prelude::*;

/// Coverage of one kind of interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coverage {
    pub robots: usize,
    pub intervals: usize,
    pub fraction: f64,
    /// Standard deviation of the fraction.
    pub deviation: f64,
}

impl Coverage {
    /// Of (held, of), a pair a robot.
    pub fn of(pairs: &[(usize, usize)]) -> Self {
        let robots = pairs.len();
        let intervals: usize = pairs.iter().map(|p| p.1).sum();
        let all = intervals.max(1) as f64;
        let fraction = pairs.iter().map(|p| p.0).sum::<usize>() as f64 / all;
        let squares: f64 = pairs.iter().map(|&(held, of)| (held as f64 - fraction * of as f64).powi(2)).sum();
        let n = robots.max(2) as f64;
        // Where all or none are held the scatter says nothing: then that of one more that is not.
        let least = 1.0 / (all + 1.0);
        let deviation = (n / (n - 1.0) * squares).sqrt() / all;
        Coverage {
            robots,
            intervals,
            fraction,
            deviation: deviation.max(if squares > 0.0 { 0.0 } else { least }),
        }
    }

    /// Whether the coverage is within 93 to 97 %, as far as is significant.
    pub fn verdict(&self, least: f64, most: f64) -> &'static str {
        let (low, high) = (self.fraction - 1.96 * self.deviation, self.fraction + 1.96 * self.deviation);
        match (self.fraction < least, self.fraction > most) {
            (false, false) => "",
            (true, _) if high >= least => "low, not significant",
            (_, true) if low <= most => "high, not significant",
            (true, _) => "LOW",
            _ => "HIGH",
        }
    }
}

/// Coverage of a kind of interval over all robots that have it.
pub fn coverage(records: &[Record], what: &str) -> Option<Coverage> {
    let pairs: Vec<(usize, usize)> =
        records.iter().filter_map(|r| r.counts.get(what)).map(|c| (c.held, c.of)).collect();
    (!pairs.is_empty()).then(|| Coverage::of(&pairs))
}

/// A table of intervals.
fn intervals(head: &str) -> Table {
    Table::markdown(&format!("{head}|robots|intervals|contain the truth|"))
}

fn row(table: &mut Table, what: &str, c: &Coverage, most: f64) {
    let fraction = format!("{:.1} ± {:.1} %", 100.0 * c.fraction, 196.0 * c.deviation);
    table.row(&[&what, &c.robots, &c.intervals, &fraction, &c.verdict(0.93, most)]);
}

/// Intervals of robots whose effects are declared.
pub fn declared(records: &[Record]) -> String {
    let mut table = intervals("stated with 95 %");
    for what in WHAT {
        let Some(c) = coverage(records, what) else { continue };
        // What is stated of all poses holds at least so often, whatever the distribution: it cannot be exact.
        let most = if ["tolerance", "share at least", "share at most"].contains(&what) { 1.0 } else { 0.97 };
        row(&mut table, what, &c, most);
    }
    table.text()
}

/// Intervals of what the closed loop found.
pub fn found(records: &[Discovered]) -> String {
    if records.is_empty() {
        return String::new();
    }
    let mut table = intervals("stated by `discover`");
    let shape =
        |i: &Interval| ["period", "at", "lag", "time_constant", "flank_load"].contains(&i.name.as_str());
    for (what, shapes) in [("shapes", true), ("sizes", false)] {
        let of = |r: &Discovered| {
            let mine = r.intervals.iter().filter(|i| !i.empty() && shape(i) == shapes);
            Fraction::of(mine.map(Interval::covers))
        };
        let all = records.iter().map(of).filter(|f| f.of > 0).map(|f| (f.hits, f.of));
        let pairs: Vec<(usize, usize)> = all.collect();
        if !pairs.is_empty() {
            row(&mut table, what, &Coverage::of(&pairs), 0.97);
        }
    }
    table.text()
}

/// p-values where nothing is missing, against the uniform distribution.
pub fn nulls(records: &[Record], screened: &[Discovered]) -> String {
    let mut table = Table::markdown(
        "p-values where nothing is missing|robots|largest distance from the uniform distribution|probability of a larger one (Kolmogorov, Smirnov)|below 5 %",
    );
    let lack: Vec<f64> = records.iter().map(|r| r.lack_of_fit).filter(|p| p.is_finite()).collect();
    let screen: Vec<f64> = screened.iter().filter(|r| r.ended()).map(first_p).collect();
    for (what, values) in [("lack of fit", lack), ("`discover`, family-wise p of its first screen", screen)] {
        if !values.is_empty() {
            let (distance, probability) = uniformity(&values);
            let below = format!("{:.1} %", Fraction::of(values.iter().map(|p| *p < 0.05)).percent());
            table.row(&[&what, &values.len(), &fixed(distance, 3), &fixed(probability, 2), &below]);
        }
    }
    table.text()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_interval_a_robot_has_the_binomial_deviation() {
        let pairs: Vec<(usize, usize)> = (0..400).map(|k| (usize::from(k % 20 > 0), 1)).collect();
        let c = Coverage::of(&pairs);
        assert!((c.fraction - 0.95).abs() < 1e-12);
        assert!((c.deviation - (0.95f64 * 0.05 / 399.0).sqrt()).abs() < 1e-12);
        // The same robots with ten intervals each that all agree tell no more.
        let tens: Vec<(usize, usize)> = pairs.iter().map(|p| (10 * p.0, 10)).collect();
        assert!((Coverage::of(&tens).deviation - c.deviation).abs() < 1e-12);
    }

    #[test]
    fn what_is_off_is_called_off() {
        let of =
            |held: usize| Coverage::of(&(0..1000).map(|k| (usize::from(k < held), 1)).collect::<Vec<_>>());
        assert_eq!(of(950).verdict(0.93, 0.97), "");
        assert_eq!(of(925).verdict(0.93, 0.97), "low, not significant");
        assert_eq!(of(880).verdict(0.93, 0.97), "LOW");
        assert_eq!(of(995).verdict(0.93, 0.97), "HIGH");
    }
}
