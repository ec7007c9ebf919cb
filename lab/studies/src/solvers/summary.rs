//! What the records come to: a table, and which strategy to take when, by the numbers.

use super::record::Record;
use super::strategies::Strategy;
use std::fmt::{Error, Write};

/// Problems that a user would recognise as one's own.
struct Regime {
    name: &'static str,
    holds: fn(&Record) -> bool,
}

const REGIMES: [Regime; 8] = [
    Regime { name: "κ ≤ 1e4", holds: |r| r.sweep == "condition" && r.condition <= 1.1e4 },
    Regime { name: "κ ≥ 1e6", holds: |r| r.sweep == "condition" && r.condition >= 0.9e6 },
    Regime { name: "60 rows", holds: |r| r.sweep == "rows" && r.rows < 61.0 },
    Regime { name: "20000", holds: |r| r.sweep == "rows" && r.rows > 19_999.0 },
    Regime { name: "sparse", holds: |r| r.sweep == "sparse" },
    Regime { name: "5–10 % bad", holds: |r| r.sweep == "outliers" && r.outliers > 0.01 },
    Regime { name: "robots", holds: |r| r.condition.is_nan() && r.outliers < 0.01 },
    Regime { name: "robots bad", holds: |r| r.condition.is_nan() && r.outliers > 0.01 },
];

/// Median; NaN of nothing.
pub fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return f64::NAN;
    }
    values.sort_by(f64::total_cmp);
    let (low, high) = (values[(values.len() - 1) / 2], values[values.len() / 2]);
    0.5 * (low + high)
}

/// Median of what a strategy reached in a regime.
fn reached(records: &[Record], strategy: &str, regime: &Regime, of: fn(&Record) -> f64) -> f64 {
    let here = records.iter().filter(|r| r.solver == strategy && (regime.holds)(r));
    median(here.map(of).filter(|v| !v.is_nan()).collect())
}

/// Everything that is printed.
pub fn text(records: &[Record], strategies: &[Strategy]) -> Result<String, Error> {
    let mut text = String::new();
    block(&mut text, records, strategies, "held-out error / oracle, median", Record::ratio)?;
    block(&mut text, records, strategies, "parameter error / oracle, median", |r| {
        r.parameters / r.oracle_parameters
    })?;
    cost(&mut text, records, strategies)?;
    significance(&mut text, records, strategies)?;
    verdict(&mut text, records, strategies)?;
    Ok(text)
}

fn block(
    text: &mut String,
    records: &[Record],
    strategies: &[Strategy],
    title: &str,
    of: fn(&Record) -> f64,
) -> Result<(), Error> {
    writeln!(text, "{title}")?;
    write!(text, "{:18}", "")?;
    REGIMES.iter().try_for_each(|r| write!(text, " {:>10}", r.name))?;
    writeln!(text)?;
    for strategy in strategies {
        write!(text, "{:18}", strategy.name)?;
        for regime in &REGIMES {
            write!(text, " {:>10}", short(reached(records, strategy.name, regime, of)))?;
        }
        writeln!(text)?;
    }
    writeln!(text)
}

fn short(value: f64) -> String {
    match value {
        v if v.is_nan() => "–".into(),
        v if (1e-3..1e3).contains(&v) => format!("{v:.3}"),
        v => format!("{v:.0e}"),
    }
}

fn cost(text: &mut String, records: &[Record], strategies: &[Strategy]) -> Result<(), Error> {
    writeln!(
        text,
        "{:18} {:>9} {:>9} {:>10} {:>10} {:>11} {:>11} {:>10}  not converged",
        "one solve", "ms", "ms", "kB", "kB", "iterations", "rank", "worst KKT"
    )?;
    writeln!(
        text,
        "{:18} {:>9} {:>9} {:>10} {:>10} {:>11} {:>11}",
        "", "600 rows", "20000", "600 rows", "20000", "median", "least–most"
    )?;
    for strategy in strategies {
        let mine = || records.iter().filter(|r| r.solver == strategy.name && r.condition.is_finite());
        let at = |rows: f64, of: fn(&Record) -> f64| {
            median(mine().filter(|r| (r.rows - rows).abs() < 0.5).map(of).collect())
        };
        let ranks = || mine().map(|r| r.rank);
        let worst = mine().map(|r| r.optimality).filter(|v| !v.is_nan()).fold(f64::NAN, f64::max);
        let mut failed: Vec<&str> = mine().map(|r| r.status.as_str()).collect();
        failed.retain(|s| !["Converged", "RankDeficient"].contains(s));
        writeln!(
            text,
            "{:18} {:>9.2} {:>9.1} {:>10.0} {:>10.0} {:>11.0} {:>11} {:>10}  {} of {}{}",
            strategy.name,
            1e3 * at(600.0, |r| r.seconds),
            1e3 * at(20_000.0, |r| r.seconds),
            1e-3 * at(600.0, |r| r.bytes),
            1e-3 * at(20_000.0, |r| r.bytes),
            median(mine().map(|r| r.iterations).collect()),
            format!("{}–{}", ranks().fold(f64::INFINITY, f64::min), ranks().fold(0.0, f64::max)),
            if worst.is_nan() { "–".into() } else { format!("{worst:.0e}") },
            failed.len(),
            mine().count(),
            failed.first().map_or(String::new(), |s| format!(" ({s})")),
        )?;
    }
    let conic = strategies.iter().filter(|s| s.conic).map(|s| s.name);
    let worst = conic
        .flat_map(|name| records.iter().filter(move |r| r.solver == name))
        .map(|r| r.optimality)
        .filter(|v| !v.is_nan())
        .fold(0.0, f64::max);
    writeln!(text, "worst violation of the optimality conditions on clarabel, from the rows: {worst:.1e}\n")
}

fn significance(text: &mut String, records: &[Record], strategies: &[Strategy]) -> Result<(), Error> {
    writeln!(
        text,
        "against {} on the same folds: problems significantly better / worse (p < 0.05)",
        strategies[0].name
    )?;
    for strategy in &strategies[1..] {
        write!(text, "{:18}", strategy.name)?;
        for regime in &REGIMES {
            let mine = || records.iter().filter(|r| r.solver == strategy.name && (regime.holds)(r));
            let count = |better: bool| mine().filter(|r| r.p_value < 0.05 && (r.t < 0.0) == better).count();
            write!(text, " {:>10}", format!("{}/{} of {}", count(true), count(false), mine().count()))?;
        }
        writeln!(text)?;
    }
    writeln!(text)
}

/// For each regime the strategies within 2 % of the best, cheapest first: once by prediction, once by parameters.
fn verdict(text: &mut String, records: &[Record], strategies: &[Strategy]) -> Result<(), Error> {
    writeln!(text, "which to take when: within 2 % of the best, cheapest first")?;
    for regime in &REGIMES {
        let best = |of: fn(&Record) -> f64| {
            let all: Vec<(f64, f64, &str)> = strategies
                .iter()
                .map(|s| {
                    let time = reached(records, s.name, regime, |r| r.seconds);
                    (reached(records, s.name, regime, of), time, s.name)
                })
                .filter(|s| !s.0.is_nan())
                .collect();
            let least = all.iter().map(|s| s.0).fold(f64::INFINITY, f64::min);
            let mut good: Vec<_> = all.into_iter().filter(|s| s.0 <= 1.02 * least).collect();
            good.sort_by(|a, b| a.1.total_cmp(&b.1));
            good.iter().take(4).map(|s| s.2).collect::<Vec<_>>().join(", ")
        };
        writeln!(text, "{:12} to predict: {}", regime.name, best(Record::ratio))?;
        let parameters = best(|r| r.parameters / r.oracle_parameters);
        if !parameters.is_empty() {
            writeln!(text, "{:12} to know the parameters: {parameters}", "")?;
        }
    }
    Ok(())
}
