//! What a reader of the figures has to know: what the standard asks for and the data does not have.

/// One remark.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Remark {
    /// Fewer cycles of a pose than the standard asks for (30).
    FewCycles {
        /// The fewest of any pose.
        fewest: usize,
    },
    /// Another number of poses than five.
    NotFivePoses {
        /// Poses with repeats.
        poses: usize,
    },
    /// So few poses say little about the accuracy over a workspace.
    FewPlaces {
        /// Poses with repeats.
        poses: usize,
    },
    /// The data has no load.
    LoadNotStated,
    /// Poses were measured under different loads.
    SeveralLoads,
    /// The data has no speed (channel `speed`).
    SpeedNotStated,
    /// Attained positions were moved onto the commanded ones.
    BestFit {
        /// Poses of the best fit.
        poses: usize,
    },
    /// No uncertainty that the readings of a pose share is stated.
    NoCommonUncertainty,
    /// The uncertainty of the instrument is more than a quarter of a figure.
    Instrument {
        /// Its expanded uncertainty, m.
        expanded: f64,
        /// The smallest figure, m.
        figure: f64,
        /// Its symbol.
        symbol: &'static str,
    },
    /// Successive cycles of a pose are not independent: the robot or the instrument drifts.
    Dependent {
        /// The pose.
        pose: String,
        /// Correlation of a cycle with the next one.
        correlation: f64,
    },
    /// The cycles of a pose came in from several directions.
    Directions {
        /// The pose.
        pose: String,
        /// How many.
        directions: usize,
    },
    /// Rows without a whole position.
    PartlyMeasured {
        /// How many.
        rows: usize,
    },
    /// Poses that were measured once.
    MeasuredOnce {
        /// How many.
        poses: usize,
    },
    /// A path with fewer than ten cycles.
    FewPathCycles {
        /// How many.
        cycles: usize,
    },
}
