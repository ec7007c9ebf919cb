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
    /// As `names`, of other files of the same robot: they serve where this file has such columns.
    pub usual_names: Vec<(String, String)>,
    /// As `ignore`, of other files of the same robot.
    pub usual_ignore: Vec<String>,
    /// Columns of `names` and `ignore` that have to be in the file, because an option names them; that others are missing is a warning.
    pub asked: Vec<String>,
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
        self.usual_names.extend(other.usual_names.iter().cloned());
        self.usual_ignore.extend(other.usual_ignore.iter().cloned());
        self.asked.extend(other.asked.iter().cloned());
        self.exclude.extend(&other.exclude);
        self.exclude.sort_unstable();
        self.exclude.dedup();
        self.orientation = other.orientation.or(self.orientation);
        self
    }

    /// This map, of which every column has to be in the file.
    #[must_use]
    pub fn asked(mut self) -> ColumnMap {
        self.asked = self.names.iter().map(|(_, column)| column).chain(&self.ignore).cloned().collect();
        self
    }

    /// What of this map serves for other files of the same robot: their lines are others, and a column that they lack is no mistake.
    #[must_use]
    pub fn usual(mut self) -> ColumnMap {
        self.usual_names.retain(|(name, _)| self.names.iter().all(|(own, _)| own != name));
        self.usual_names.append(&mut self.names);
        self.usual_ignore.append(&mut self.ignore);
        self.asked.clear();
        self.exclude.clear();
        self
    }

    /// Whether it says nothing.
    pub fn is_empty(&self) -> bool {
        *self == ColumnMap::default()
    }
}
