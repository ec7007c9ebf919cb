//! A solver as a line of text, and back.
//!
//! ```text
//! solver  = name [ "(" argument { "," argument } ")" ]
//! argument = number-option "=" number | word-option "=" word | flag | solver
//! ```
//!
//! `svd(rcond=1e-10)`, `ridge(gcv)`, `huber(qr, k=1.345)`, `tukey(svd(gap=1000), c=4.685, start=huber)`. Text is read at the
//! edge into enums that carry their own options; nothing inside looks at strings. Printing gives the shortest text that
//! reads back the same.

mod grammar;
mod names;
mod read;
mod tree;
mod write;

pub use tree::SolverSpec;

#[cfg(test)]
mod tests {
    use super::SolverSpec;

    #[track_caller]
    fn check(text: &str, printed: &str) {
        let spec: SolverSpec = text.parse().unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!(spec.to_string(), printed);
        assert_eq!(printed.parse::<SolverSpec>().unwrap(), spec);
    }

    #[test]
    fn text_and_back() {
        check("qr", "qr");
        check(" svd( rcond = 1e-10 ) ", "svd(rcond=1e-10)");
        check("normal(condition_limit=1000000)", "normal(condition_limit=1000000.0)");
        check("normal()", "normal");
        check("qr(gap=1000)", "qr(gap=1000.0)");
        check("ridge", "ridge");
        check("ridge(gcv)", "ridge");
        check("ridge(lambda=1e-3)", "ridge(lambda=0.001)");
        check("ridge(map)", "ridge(map)");
        check("ridge(cv, folds=10, one_se)", "ridge(cv, folds=10, one_se)");
        check("huber(qr, k=1.345)", "huber(qr)");
        check("huber", "huber(qr)");
        check("tukey(svd, c=4.685)", "tukey(svd)");
        check("tukey(svd(rcond=1e-8), c=6, start=huber)", "tukey(svd(rcond=1e-8), c=6.0, start=huber)");
        check(
            "huber(ridge(lcurve), start=trimmed, keep=0.6)",
            "huber(ridge(lcurve), start=trimmed, keep=0.6)",
        );
    }

    #[cfg(feature = "clarabel")]
    #[test]
    fn text_and_back_with_cones() {
        check("lasso(cv)", "lasso");
        check("lasso(ratio=0.01, refit)", "lasso(ratio=0.01, refit)");
        check("elastic_net(lambda=0.1, mix=0.9)", "elastic_net(lambda=0.1, mix=0.9)");
        check("group_lasso(cv, count=30, seed=7)", "group_lasso(count=30, seed=7)");
        check("bounded", "bounded(qr)");
        check("bounded(svd)", "bounded(svd)");
        check("huber_exact(k=2)", "huber_exact(k=2.0)");
    }

    #[track_caller]
    fn refused(text: &str, message: &str) {
        let e = text.parse::<SolverSpec>().unwrap_err().to_string();
        assert!(e.contains(message), "{text}: {e}");
    }

    #[test]
    fn mistakes_are_named() {
        refused("rigde", "did you mean `ridge`?");
        refused("rigde", "there are: normal, qr, svd, ridge");
        refused("svd(rcnd=1)", "did you mean `rcond`?");
        refused("svd(rcond=2)", "0 ≤ rcond < 1");
        refused("svd(rcond=)", "expected a number or a word at character 10");
        refused("svd(rcond=1", "expected `,` or `)`");
        refused("svd)", "expected the end");
        refused("", "expected the name of a solver");
        refused("qr(svd)", "`qr` has no option `svd`");
        refused("huber(qr, k=-1)", "k = -1");
        refused("huber(qr, svd)", "has no option `svd`");
        refused("ridge(gcv, map)", "has no option `map`");
        refused("ridge(lambda=-1)", "lambda = -1");
        refused("huber(qr, start=best)", "has no option `best`");
        refused("ridge(cv, folds=2.5)", "folds = 2.5");
    }

    #[test]
    fn brackets_without_end_are_refused() {
        refused(&"bounded(".repeat(100_000), "expected fewer brackets within brackets");
        refused(&"a=(".repeat(100_000), "expected");
    }

    #[test]
    fn a_robust_solver_has_no_robust_one_inside() {
        refused("huber(huber(qr))", "`huber` has `huber(qr)` inside, which is robust as well");
        refused("huber(huber(huber(huber(huber(qr)))))", "name one robust solver, such as `huber(qr)`");
        refused("tukey(huber(qr), start=plain)", "`tukey` has `huber(qr)` inside");
    }

    #[cfg(feature = "clarabel")]
    #[test]
    fn a_robust_solver_has_no_robust_one_inside_a_bounded_one() {
        refused("huber(bounded(tukey(qr)))", "`huber` has `tukey(qr)` inside");
        refused("tukey(huber_exact)", "`tukey` has `huber_exact` inside");
        check("huber(bounded(svd))", "huber(bounded(svd))");
    }

    #[cfg(not(feature = "clarabel"))]
    #[test]
    fn solvers_that_are_not_built_in_are_refused_with_the_name_of_their_feature() {
        for text in
            ["lasso", "elastic_net(mix=0.9)", "group_lasso", "bounded(qr)", "huber_exact", "huber(lasso)"]
        {
            refused(text, "feature `clarabel`");
        }
    }

    #[test]
    fn everything_that_is_known_builds_and_passes_on_its_name() {
        for (name, about) in SolverSpec::known() {
            let solver = name.parse::<SolverSpec>().unwrap().build();
            assert!(solver.name().starts_with(name), "{name} {}", solver.name());
            assert!(!about.is_empty());
        }
        assert_eq!("tukey(svd)".parse::<SolverSpec>().unwrap().build().name(), "tukey(svd)");
    }
}
