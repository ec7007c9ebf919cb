//! A solver into the shortest text that reads back the same.

use super::tree::{MAX_ITERATIONS, SolverSpec};
use crate::{Choice, GroupedFolds, Loss, NormalEquations, RankRule, RidgeStrength, Start, Trimming};
#[cfg(feature = "clarabel")]
use crate::{ElasticNet, ExactHuber, Strength};
use std::fmt::{self, Display};

impl Display for SolverSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, options) = parts(self);
        f.write_str(name)?;
        if options.is_empty() { Ok(()) } else { write!(f, "({})", options.join(", ")) }
    }
}

fn parts(spec: &SolverSpec) -> (&'static str, Vec<String>) {
    let mut o = Vec::new();
    let name = match spec {
        SolverSpec::Normal(s) => {
            rank(&mut o, s.rank);
            unless(&mut o, "condition_limit", s.condition_limit, NormalEquations::default().condition_limit);
            "normal"
        }
        SolverSpec::Qr(s) => {
            rank(&mut o, s.rank);
            "qr"
        }
        SolverSpec::Svd(s) => {
            rank(&mut o, s.rank);
            "svd"
        }
        SolverSpec::Ridge(s) => {
            match s.strength {
                RidgeStrength::Fixed(lambda) => o.push(format!("lambda={lambda:?}")),
                RidgeStrength::Gcv => {}
                RidgeStrength::LCurve => o.push("lcurve".into()),
                RidgeStrength::Map => o.push("map".into()),
                RidgeStrength::GroupedCv(by) => {
                    o.push("cv".into());
                    folds(&mut o, by);
                }
            }
            "ridge"
        }
        #[cfg(feature = "clarabel")]
        SolverSpec::Lasso(s) => {
            strength(&mut o, s.strength);
            flag(&mut o, "refit", s.refit);
            "lasso"
        }
        #[cfg(feature = "clarabel")]
        SolverSpec::ElasticNet(s) => {
            strength(&mut o, s.strength);
            unless(&mut o, "mix", s.mix, ElasticNet::default().mix);
            flag(&mut o, "refit", s.refit);
            "elastic_net"
        }
        #[cfg(feature = "clarabel")]
        SolverSpec::GroupLasso(s) => {
            strength(&mut o, s.strength);
            flag(&mut o, "refit", s.refit);
            "group_lasso"
        }
        #[cfg(feature = "clarabel")]
        SolverSpec::Bounded { inner } => {
            o.push(inner.to_string());
            "bounded"
        }
        #[cfg(feature = "clarabel")]
        SolverSpec::ExactHuber(s) => {
            unless(&mut o, "k", s.k, ExactHuber::default().k);
            o.extend(s.noise.map(|n| format!("noise={n:?}")));
            "huber_exact"
        }
        SolverSpec::Robust { inner, loss, start, max_iterations } => {
            o.push(inner.to_string());
            let usual = match (*loss, Loss::huber(), Loss::tukey()) {
                (Loss::Huber { k }, Loss::Huber { k: plain }, _) => {
                    unless(&mut o, "k", k, plain);
                    Start::Plain
                }
                (Loss::Tukey { c }, _, Loss::Tukey { c: plain }) => {
                    unless(&mut o, "c", c, plain);
                    Start::Trimmed(Trimming::default())
                }
                _ => Start::Plain,
            };
            begin(&mut o, *start, usual);
            if *max_iterations != MAX_ITERATIONS {
                o.push(format!("rounds={max_iterations}"));
            }
            loss.name()
        }
    };
    (name, o)
}

fn unless(o: &mut Vec<String>, key: &str, value: f64, usual: f64) {
    if value.total_cmp(&usual).is_ne() {
        o.push(format!("{key}={value:?}"));
    }
}

#[cfg(feature = "clarabel")]
fn flag(o: &mut Vec<String>, name: &str, set: bool) {
    if set {
        o.push(name.into());
    }
}

fn rank(o: &mut Vec<String>, rule: RankRule) {
    match rule {
        RankRule::Default => {}
        RankRule::Relative(r) => o.push(format!("rcond={r:?}")),
        RankRule::Absolute(t) => o.push(format!("tolerance={t:?}")),
        RankRule::WidestGap { least, .. } => o.push(format!("gap={least:?}")),
    }
}

fn folds(o: &mut Vec<String>, by: GroupedFolds) {
    let usual = GroupedFolds::default();
    if by.folds != usual.folds {
        o.push(format!("folds={}", by.folds));
    }
    if by.seed != usual.seed {
        o.push(format!("seed={}", by.seed));
    }
    if by.choice == Choice::OneStandardError {
        o.push("one_se".into());
    }
}

#[cfg(feature = "clarabel")]
fn strength(o: &mut Vec<String>, by: Strength) {
    match (by, Strength::default()) {
        (Strength::Fixed(lambda), _) => o.push(format!("lambda={lambda:?}")),
        (Strength::Ratio(ratio), _) => o.push(format!("ratio={ratio:?}")),
        (
            Strength::GroupedCv { folds: by, count, least },
            Strength::GroupedCv { count: usual_count, least: usual_least, .. },
        ) => {
            if count != usual_count {
                o.push(format!("count={count}"));
            }
            unless(o, "least", least, usual_least);
            folds(o, by);
        }
        _ => {}
    }
}

fn begin(o: &mut Vec<String>, start: Start, usual: Start) {
    match (start, usual) {
        (Start::Trimmed(trimming), _) => {
            if !matches!(usual, Start::Trimmed(_)) {
                o.push("start=trimmed".into());
            }
            let plain = Trimming::default();
            unless(o, "keep", trimming.keep, plain.keep);
            if trimming.starts != plain.starts {
                o.push(format!("starts={}", trimming.starts));
            }
            if trimming.seed != plain.seed {
                o.push(format!("seed={}", trimming.seed));
            }
        }
        (Start::Plain, Start::Plain) => {}
        (Start::Plain, _) => o.push("start=plain".into()),
        (Start::Huber, _) => o.push("start=huber".into()),
    }
}
