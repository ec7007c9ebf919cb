//! The names of solvers and of their options, and the nearest to a misspelt one.

pub(super) struct Name {
    pub name: &'static str,
    pub about: &'static str,
    pub available: bool,
    pub feature: &'static str,
    pub options: &'static [&'static str],
}

const CONES: bool = cfg!(feature = "clarabel");

const fn name(name: &'static str, about: &'static str, options: &'static [&'static str]) -> Name {
    Name { name, about, available: true, feature: "", options }
}

const fn cone(name: &'static str, about: &'static str, options: &'static [&'static str]) -> Name {
    Name { name, about, available: CONES, feature: "clarabel", options }
}

pub(super) const NAMES: &[Name] = &[
    name("normal", "normal equations with a guard", &["rcond", "tolerance", "gap", "condition_limit"]),
    name("qr", "pivoted QR, basic solution", &["rcond", "tolerance", "gap"]),
    name("svd", "truncated SVD, shortest solution", &["rcond", "tolerance", "gap"]),
    name("ridge", "squares as penalty", &["gcv", "lcurve", "cv", "map", "lambda", "folds", "seed", "one_se"]),
    cone(
        "lasso",
        "absolute values as penalty",
        &["cv", "lambda", "ratio", "refit", "folds", "seed", "one_se", "count", "least"],
    ),
    cone(
        "elastic_net",
        "absolute values and squares as penalty",
        &["cv", "lambda", "ratio", "mix", "refit", "folds", "seed", "one_se", "count", "least"],
    ),
    cone(
        "group_lasso",
        "whole effects enter or stay out",
        &["cv", "lambda", "ratio", "refit", "folds", "seed", "one_se", "count", "least"],
    ),
    cone("bounded", "least squares within bounds", &["SOLVER"]),
    cone("huber_exact", "Huber's loss as one convex program", &["k", "noise"]),
    name(
        "huber",
        "any solver, the pull of wrong visits limited",
        &["SOLVER", "k", "start", "keep", "starts", "seed", "rounds"],
    ),
    name(
        "tukey",
        "any solver, wrong visits left out",
        &["SOLVER", "c", "start", "keep", "starts", "seed", "rounds"],
    ),
];

pub(super) fn nearest(name: &str, known: &[&'static str]) -> Option<&'static str> {
    let score = |k: &&&'static str| strsim::damerau_levenshtein(name, k);
    known
        .iter()
        .min_by_key(score)
        .filter(|k| strsim::damerau_levenshtein(name, k) <= 1 + name.len() / 3)
        .copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_is_near() {
        assert_eq!(nearest("laso", &["lasso", "ridge"]), Some("lasso"));
        assert_eq!(nearest("quantum", &["lasso", "ridge"]), None);
    }
}
