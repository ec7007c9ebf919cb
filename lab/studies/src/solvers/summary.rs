//! What the records come to: a table, and which strategy to take when, by the numbers.

use super::optimality::Strategy;
use super::record::Record;
use crate::prelude::*;

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

/// Median of what a strategy reached in a regime.
fn reached(records: &[Record], strategy: &str, regime: &Regime, of: fn(&Record) -> f64) -> f64 {
    let here = records.iter().filter(|r| r.solver == strategy && (regime.holds)(r));
    median(here.map(of))
}

/// Median; an infinite value counts, one that is missing does not.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    truepose_solvers::order::median(values.filter(|v| !v.is_nan())).unwrap_or(f64::NAN)
}

/// Everything that is printed.
pub fn text(records: &[Record], strategies: &[Strategy]) -> Outcome<String> {
    let ratio = |r: &Record| r.parameters / r.oracle_parameters;
    let held_out = |s: &str, regime: &Regime| short(reached(records, s, regime, Record::ratio));
    let parameters = |s: &str, regime: &Regime| short(reached(records, s, regime, ratio));
    let significant = |s: &str, regime: &Regime| {
        let mine = || records.iter().filter(|r| r.solver == s && (regime.holds)(r));
        let count = |better: bool| mine().filter(|r| r.p_value < 0.05 && (r.t < 0.0) == better).count();
        format!("{}/{} of {}", count(true), count(false), mine().count())
    };
    let mut text = String::new();
    let first = "held-out error / oracle, median";
    writeln!(text, "{first}\n{}{}", heads(), by_regime(strategies, held_out))?;
    writeln!(text, "parameter error / oracle, median\n{}{}", heads(), by_regime(strategies, parameters))?;
    cost(&mut text, records, strategies)?;
    let words = "on the same folds: problems significantly better / worse (p < 0.05)";
    let table = by_regime(&strategies[1..], significant);
    writeln!(text, "against {} {words}\n{table}", strategies[0].name)?;
    verdict(&mut text, records, strategies)?;
    Ok(text)
}

fn heads() -> String {
    format!("{:18}{}\n", "", REGIMES.iter().map(|r| format!(" {:>10}", r.name)).collect::<String>())
}

/// A line a strategy, a column a regime.
fn by_regime(strategies: &[Strategy], cell: impl Fn(&str, &Regime) -> String) -> String {
    let cells = |name: &str| REGIMES.iter().map(|r| format!(" {:>10}", cell(name, r))).collect::<String>();
    strategies.iter().map(|s| format!("{:18}{}\n", s.name, cells(s.name))).collect()
}

fn short(value: f64) -> String {
    match value {
        v if v.is_nan() => "–".into(),
        v if (1e-3..1e3).contains(&v) => format!("{v:.3}"),
        v => format!("{v:.0e}"),
    }
}

fn cost(text: &mut String, records: &[Record], strategies: &[Strategy]) -> Outcome {
    let mut table = Table::columns(
        "one solve -18|ms 9|ms 9|kB 10|kB 10|iterations 11|rank 11|worst KKT 10| not converged -1",
    );
    table.row(&[&"", &"600 rows", &"20000", &"600 rows", &"20000", &"median", &"least–most"]);
    for strategy in strategies {
        let mine = || records.iter().filter(|r| r.solver == strategy.name && r.condition.is_finite());
        let at = |rows: f64, of: fn(&Record) -> f64| {
            median(mine().filter(|r| (r.rows - rows).abs() < 0.5).map(of))
        };
        let [ms, many_ms] = [600.0, 20_000.0].map(|rows| 1e3 * at(rows, |r| r.seconds));
        let [kb, many_kb] = [600.0, 20_000.0].map(|rows| fixed(1e-3 * at(rows, |r| r.bytes), 0));
        let iterations = fixed(median(mine().map(|r| r.iterations)), 0);
        let ranks = || mine().map(|r| r.rank);
        let rank = format!("{}–{}", ranks().fold(f64::INFINITY, f64::min), ranks().fold(0.0, f64::max));
        let worst = mine().map(|r| r.optimality).filter(|v| !v.is_nan()).fold(f64::NAN, f64::max);
        let worst = if worst.is_nan() { "–".into() } else { format!("{worst:.0e}") };
        let mut failed: Vec<&str> = mine().map(|r| r.status.as_str()).collect();
        failed.retain(|s| !["Converged", "RankDeficient"].contains(s));
        let first = failed.first().map_or(String::new(), |s| format!(" ({s})"));
        let failed = format!(" {} of {}{first}", failed.len(), mine().count());
        let (ms, many_ms) = (fixed(ms, 2), fixed(many_ms, 1));
        let name = &strategy.name;
        table.row(&[name, &ms, &many_ms, &kb, &many_kb, &iterations, &rank, &worst, &failed]);
    }
    let conic = strategies.iter().filter(|s| s.conic).map(|s| s.name);
    let worst = conic
        .flat_map(|name| records.iter().filter(move |r| r.solver == name))
        .map(|r| r.optimality)
        .filter(|v| !v.is_nan())
        .fold(0.0, f64::max);
    let words = "worst violation of the optimality conditions on clarabel, from the rows";
    writeln!(text, "{}{words}: {worst:.1e}\n", table.text())?;
    Ok(())
}

/// For each regime the strategies within 2 % of the best, cheapest first: once by prediction, once by parameters.
fn verdict(text: &mut String, records: &[Record], strategies: &[Strategy]) -> Outcome {
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
