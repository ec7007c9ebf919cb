//! Which column of a file is which, where the file has names of its own.

use super::orientation::OrientationConvention;

/// Names of columns, columns and rows to leave out, and the convention of orientations: `[columns]` of a robot file, `--map`, `--ignore`,
/// `--exclude`, `--orientation`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ColumnMap {
    /// Pairs of a name of ours (a joint, `x`, `time` …) and the column of the file that holds it, with or without a unit: `("A1", "Joint 1[deg]")`.
    pub names: Vec<(String, String)>,
    /// Columns of the file that are not read.
    pub ignore: Vec<String>,
    /// Lines of the file that are not read, as messages number them.
    pub exclude: Vec<u64>,
    /// How three angles (or four numbers) describe an orientation; none: quaternions and rotation vectors.
    pub orientation: Option<OrientationConvention>,
}

impl ColumnMap {
    /// This map with the entries of another one, which win.
    #[must_use]
    pub fn with(mut self, other: &ColumnMap) -> ColumnMap {
        self.names.retain(|(name, _)| other.names.iter().all(|(theirs, _)| theirs != name));
        self.names.extend(other.names.iter().cloned());
        self.ignore.extend(other.ignore.iter().cloned());
        self.exclude.extend(&other.exclude);
        self.exclude.sort_unstable();
        self.exclude.dedup();
        self.orientation = other.orientation.or(self.orientation);
        self
    }
}
