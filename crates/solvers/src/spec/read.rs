//! A tree of calls into a solver.

use super::grammar::{Argument, Call, Value, parse};
use super::names::{NAMES, Name, nearest};
use super::tree::{MAX_ITERATIONS, SolverSpec};
use crate::{
    Choice, GroupedFolds, Loss, NormalEquations, PivotedQr, RankRule, Ridge, RidgeStrength, SolveError,
    Start, Svd, Trimming,
};
#[cfg(feature = "clarabel")]
use crate::{ElasticNet, ExactHuber, GroupLasso, Lasso, Strength};

impl std::str::FromStr for SolverSpec {
    type Err = SolveError;

    fn from_str(text: &str) -> Result<Self, SolveError> {
        read(&parse(text)?)
    }
}

fn read(call: &Call) -> Result<SolverSpec, SolveError> {
    let Some(entry) = NAMES.iter().find(|n| n.name == call.name) else {
        let known: Vec<&'static str> = NAMES.iter().filter(|n| n.available).map(|n| n.name).collect();
        let nearest = nearest(&call.name, &known);
        return Err(SolveError::UnknownSolver { name: call.name.clone(), known, nearest });
    };
    if !entry.available {
        return Err(SolveError::FeatureOff { solver: entry.name, feature: entry.feature });
    }
    let mut options = Options { entry, left: call.arguments.clone() };
    let spec = match entry.name {
        "normal" => {
            let plain = NormalEquations::default();
            let condition_limit = options.number("condition_limit")?.unwrap_or(plain.condition_limit);
            let solver = NormalEquations { rank: options.rank()?, condition_limit };
            solver.validate()?;
            SolverSpec::Normal(solver)
        }
        "qr" => SolverSpec::Qr(PivotedQr { rank: options.rank()? }),
        "svd" => SolverSpec::Svd(Svd { rank: options.rank()? }),
        "ridge" => SolverSpec::Ridge(options.ridge()?),
        #[cfg(feature = "clarabel")]
        "lasso" => SolverSpec::Lasso(Lasso { strength: options.strength()?, refit: options.flag("refit") }),
        #[cfg(feature = "clarabel")]
        "elastic_net" => {
            let mix = options.number("mix")?.unwrap_or(ElasticNet::default().mix);
            if !(mix > 0.0 && mix <= 1.0) {
                return Err(SolveError::BadOption {
                    option: "mix",
                    value: mix,
                    expected: "above 0, at most 1",
                });
            }
            let strength = options.strength()?;
            SolverSpec::ElasticNet(ElasticNet { strength, mix, refit: options.flag("refit") })
        }
        #[cfg(feature = "clarabel")]
        "group_lasso" => {
            SolverSpec::GroupLasso(GroupLasso { strength: options.strength()?, refit: options.flag("refit") })
        }
        #[cfg(feature = "clarabel")]
        "bounded" => SolverSpec::Bounded { inner: Box::new(options.inner()?) },
        #[cfg(feature = "clarabel")]
        "huber_exact" => {
            let k = options.number("k")?.unwrap_or(ExactHuber::default().k);
            Loss::Huber { k }.validate()?;
            SolverSpec::ExactHuber(ExactHuber { k, noise: options.number("noise")? })
        }
        "huber" => {
            let loss = options.number("k")?.map_or_else(Loss::huber, |k| Loss::Huber { k });
            options.robust(loss, Start::Plain)?
        }
        _ => {
            let loss = options.number("c")?.map_or_else(Loss::tukey, |c| Loss::Tukey { c });
            options.robust(loss, Start::Trimmed(Trimming::default()))?
        }
    };
    options.finish()?;
    Ok(spec)
}

/// Arguments that have not been read yet.
struct Options {
    entry: &'static Name,
    left: Vec<Argument>,
}

impl Options {
    fn take(&mut self, wanted: impl Fn(&Argument) -> bool) -> Option<Argument> {
        self.left.iter().position(wanted).map(|at| self.left.remove(at))
    }

    fn unknown(&self, option: String) -> SolveError {
        let known = self.entry.options.to_vec();
        let nearest = nearest(&option, &known);
        SolveError::UnknownOption { solver: self.entry.name, option, known, nearest }
    }

    fn number(&mut self, key: &'static str) -> Result<Option<f64>, SolveError> {
        match self.take(|a| a.key.as_deref() == Some(key)).map(|a| a.value) {
            None => Ok(None),
            Some(Value::Number(n)) => Ok(Some(n)),
            Some(Value::Call(c)) => Err(self.unknown(c.name)),
        }
    }

    fn count(&mut self, key: &'static str) -> Result<Option<usize>, SolveError> {
        match self.number(key)? {
            Some(value) if !(0.0..1e15).contains(&value) || value.fract() != 0.0 => {
                Err(SolveError::BadOption { option: key, value, expected: "a whole number" })
            }
            other => Ok(other.map(|n| n as usize)),
        }
    }

    fn flag(&mut self, name: &str) -> bool {
        self.take(|a| {
            a.key.is_none() && matches!(&a.value, Value::Call(c) if c.name == name && c.arguments.is_empty())
        })
        .is_some()
    }

    /// A solver among the arguments; `qr` if there is none.
    fn inner(&mut self) -> Result<SolverSpec, SolveError> {
        match self.take(|a| a.key.is_none() && matches!(a.value, Value::Call(_))).map(|a| a.value) {
            Some(Value::Call(call)) => read(&call),
            _ => Ok(SolverSpec::default()),
        }
    }

    fn rank(&mut self) -> Result<RankRule, SolveError> {
        let rule = if let Some(rcond) = self.number("rcond")? {
            RankRule::Relative(rcond)
        } else if let Some(tolerance) = self.number("tolerance")? {
            RankRule::Absolute(tolerance)
        } else if let Some(least) = self.number("gap")? {
            RankRule::widest_gap(least)
        } else {
            RankRule::Default
        };
        rule.validate()?;
        Ok(rule)
    }

    fn folds(&mut self) -> Result<GroupedFolds, SolveError> {
        let plain = GroupedFolds::default();
        let folds = GroupedFolds {
            folds: self.count("folds")?.unwrap_or(plain.folds),
            seed: self.count("seed")?.map_or(plain.seed, |s| s as u64),
            choice: if self.flag("one_se") { Choice::OneStandardError } else { plain.choice },
        };
        folds.validate()?;
        Ok(folds)
    }

    fn ridge(&mut self) -> Result<Ridge, SolveError> {
        let strength = if let Some(value) = self.number("lambda")? {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(SolveError::BadOption {
                    option: "lambda",
                    value,
                    expected: "a finite number ≥ 0",
                });
            }
            RidgeStrength::Fixed(value)
        } else if self.flag("gcv") {
            RidgeStrength::Gcv
        } else if self.flag("lcurve") {
            RidgeStrength::LCurve
        } else if self.flag("map") {
            RidgeStrength::Map
        } else if self.flag("cv") {
            RidgeStrength::GroupedCv(self.folds()?)
        } else {
            RidgeStrength::default()
        };
        Ok(Ridge { strength })
    }

    #[cfg(feature = "clarabel")]
    fn strength(&mut self) -> Result<Strength, SolveError> {
        let strength = if let Some(lambda) = self.number("lambda")? {
            Strength::Fixed(lambda)
        } else if let Some(ratio) = self.number("ratio")? {
            Strength::Ratio(ratio)
        } else {
            self.flag("cv");
            let folds = self.folds()?;
            let Strength::GroupedCv { count, least, .. } = Strength::default() else {
                return Ok(Strength::default());
            };
            let count = self.count("count")?.unwrap_or(count);
            Strength::GroupedCv { folds, count, least: self.number("least")?.unwrap_or(least) }
        };
        strength.validate()?;
        Ok(strength)
    }

    fn robust(&mut self, loss: Loss, usual: Start) -> Result<SolverSpec, SolveError> {
        loss.validate()?;
        let mut start = match self.take(|a| a.key.as_deref() == Some("start")).map(|a| a.value) {
            None => usual,
            Some(Value::Call(c)) => match c.name.as_str() {
                "plain" => Start::Plain,
                "huber" => Start::Huber,
                "trimmed" => Start::Trimmed(Trimming::default()),
                _ => return Err(self.unknown(c.name)),
            },
            Some(Value::Number(n)) => return Err(self.unknown(n.to_string())),
        };
        if let Start::Trimmed(trimming) = &mut start {
            trimming.keep = self.number("keep")?.unwrap_or(trimming.keep);
            trimming.starts = self.count("starts")?.unwrap_or(trimming.starts);
            trimming.seed = self.count("seed")?.map_or(trimming.seed, |s| s as u64);
            trimming.validate()?;
        }
        let max_iterations = self.count("rounds")?.unwrap_or(MAX_ITERATIONS).max(1);
        let inner = self.inner()?;
        // Each of the outer's iterations would run all of the inner's: time grows by a power with each level.
        if let Some(inner) = inner.robust() {
            return Err(SolveError::NestedRobust { outer: self.entry.name, inner: inner.to_string() });
        }
        Ok(SolverSpec::Robust { inner: Box::new(inner), loss, start, max_iterations })
    }

    fn finish(self) -> Result<(), SolveError> {
        match self.left.first() {
            None => Ok(()),
            Some(argument) => {
                let name = argument.key.clone().unwrap_or_else(|| match &argument.value {
                    Value::Number(n) => n.to_string(),
                    Value::Call(c) => c.name.clone(),
                });
                Err(self.unknown(name))
            }
        }
    }
}
