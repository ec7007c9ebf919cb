//! Signs and sizes that a mechanism can have.

/// What the coefficients of a hypothesis are held against before it is accepted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// The first coefficient is a compliance or a gap: it is not negative beyond twice its standard deviation.
    FirstNotNegative,
    /// The coefficients lie within a hundred prior standard deviations: a link that needs more would be as soft as paper.
    BoundedWidth,
    /// Coefficients in rad, or rad per rad of another joint, are those of a drive: at most 10 mrad.
    DriveAngle,
}
