//! What can be wrong with a problem or an option. Not converging is no error: it is a
//! [`Status`](crate::Status).

use crate::Need;

/// Why a problem was refused, or a factorisation could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError {
    /// Two things that have to match in length do not.
    #[error("{what} has {found} entries, expected {expected}: make them match the design matrix")]
    Shape {
        /// What was measured.
        what: &'static str,
        /// How many entries it needs.
        expected: usize,
        /// How many it has.
        found: usize,
    },
    /// A NaN or an infinity in the data.
    #[error("{what} is not finite at row {row}, column {column}: remove or repair that row before fitting")]
    NotFinite {
        /// Which input.
        what: &'static str,
        /// Row of the first offender.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// A weight is negative or not finite.
    #[error(
        "weight {value} of row {row} is not a finite number ≥ 0: use 1/σ² of that row, or 0 to leave it out"
    )]
    BadWeight {
        /// Row.
        row: usize,
        /// Its weight.
        value: f64,
    },
    /// An expected size is not a positive number.
    #[error(
        "scale {value} of column {column} is not a finite number > 0: give the size that you expect of it"
    )]
    BadScale {
        /// Column.
        column: usize,
        /// Its scale.
        value: f64,
    },
    /// Lower above upper, or a bound that is NaN.
    #[error("bounds [{lower}, {upper}] of column {column} are empty: the lower must not exceed the upper")]
    BadBounds {
        /// Column.
        column: usize,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// The solver does not support a property of the problem.
    #[error("`{solver}` does not support {need}: take a solver that does, or leave that out")]
    Unsupported {
        /// Name of the solver.
        solver: String,
        /// What the problem needs.
        need: Need,
    },
    /// A robust solver inside of another.
    #[error(
        "`{outer}` has `{inner}` inside, which is robust as well: name one robust solver, such as `{outer}(qr)`"
    )]
    NestedRobust {
        /// Name of the outer one.
        outer: &'static str,
        /// Name of the inner one.
        inner: String,
    },
    /// The solver needs something that the problem does not bring.
    #[error("`{solver}` needs `{missing}` in the problem")]
    Missing {
        /// Name of the solver.
        solver: &'static str,
        /// The field of [`LeastSquares`](crate::LeastSquares).
        missing: &'static str,
    },
    /// An option out of its range.
    #[error("option {option} = {value} is out of range: {expected}")]
    BadOption {
        /// Name of the option.
        option: &'static str,
        /// Value given.
        value: f64,
        /// What it has to be.
        expected: &'static str,
    },
    /// Not enough groups of rows to leave some out.
    #[error("{have} groups of rows, {need} needed: give more visits or use fewer folds")]
    TooFewGroups {
        /// Groups in the data.
        have: usize,
        /// Groups needed.
        need: usize,
    },
    /// A factorisation did not converge.
    #[error("{what} of a {rows} × {columns} matrix did not converge: rescale the columns")]
    Breakdown {
        /// Which factorisation.
        what: &'static str,
        /// Rows.
        rows: usize,
        /// Columns.
        columns: usize,
    },
    /// A stored accumulator cannot be read.
    #[error("stored accumulator: {reason} (byte {at})")]
    Corrupt {
        /// What is wrong.
        reason: &'static str,
        /// Where.
        at: usize,
    },
    /// A solver name that does not exist.
    #[error("unknown solver `{name}`{}; there are: {}", hint(.nearest), .known.join(", "))]
    UnknownSolver {
        /// Name given.
        name: String,
        /// Names that exist.
        known: Vec<&'static str>,
        /// The nearest of them.
        nearest: Option<&'static str>,
    },
    /// An option that the solver does not have.
    #[error("`{solver}` has no option `{option}`{}; it has: {}", hint(.nearest), .known.join(", "))]
    UnknownOption {
        /// Solver.
        solver: &'static str,
        /// Option given.
        option: String,
        /// Options that exist.
        known: Vec<&'static str>,
        /// The nearest of them.
        nearest: Option<&'static str>,
    },
    /// A solver description that cannot be read.
    #[error("`{text}`: expected {expected} at character {at}")]
    Grammar {
        /// The text.
        text: String,
        /// What should stand there.
        expected: &'static str,
        /// Where, in characters from 0.
        at: usize,
    },
    /// The solver exists, but this program was built without it.
    #[error("`{solver}` needs the feature `{feature}`: build with it, or take another solver")]
    FeatureOff {
        /// Solver.
        solver: &'static str,
        /// Cargo feature.
        feature: &'static str,
    },
}

fn hint(name: &Option<&'static str>) -> String {
    name.map(|n| format!(", did you mean `{n}`?")).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_say_what_to_do() {
        let e = SolveError::UnknownSolver {
            name: "rigde".into(),
            known: vec!["qr", "ridge"],
            nearest: Some("ridge"),
        };
        assert_eq!(e.to_string(), "unknown solver `rigde`, did you mean `ridge`?; there are: qr, ridge");
        let e = SolveError::Unsupported { solver: "qr".into(), need: Need::Bounds };
        assert!(e.to_string().contains("bounds"));
    }
}
