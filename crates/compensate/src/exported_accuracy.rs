//! Position error of a robot that a controller would be given.

/// RMS of the 3-D distance, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy {
    /// With base, tool and targets as they stand.
    pub as_written: f64,
    /// With the best base and tool.
    pub aligned: f64,
}
