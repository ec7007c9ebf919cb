//! Properties of a problem that not every solver supports.

/// A property of a problem that not every solver supports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Need {
    /// Columns that depend on each other.
    RankDeficient,
    /// Weights of rows.
    Weights,
    /// Box constraints.
    Bounds,
    /// Resistance to wrong rows.
    Outliers,
    /// Columns that enter or stay out together.
    ColumnGroups,
    /// No penalty on the unknowns: the gradient of the squares (as weighted in the end) vanishes.
    Unpenalised,
}

impl std::fmt::Display for Need {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Need::RankDeficient => "a deficient rank",
            Need::Weights => "weights",
            Need::Bounds => "bounds",
            Need::Outliers => "outliers",
            Need::ColumnGroups => "groups of columns",
            Need::Unpenalised => "the absence of a penalty",
        })
    }
}
