//! How a finding is drawn, residual by residual.

use crate::hypotheses::driver::Driver;

/// What a trace of a finding shows: which error, against what.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct TraceView {
    /// Whether it is the error of a joint's own motion, about or along its axis (the joint of the place); else of the site whose error moves
    /// the target most.
    pub own_motion: bool,
    /// Drivers in order of preference: the first that the data has is taken; without one the time, or else the pose measurement.
    pub against: Vec<Driver>,
    /// Whether points are told apart by the direction in which the joint last moved.
    pub by_approach: bool,
}

impl TraceView {
    /// Of a joint's own motion.
    pub fn of_motion(against: impl IntoIterator<Item = Driver>) -> Self {
        TraceView { own_motion: true, ..TraceView::of_site(against) }
    }

    /// Of a site.
    pub fn of_site(against: impl IntoIterator<Item = Driver>) -> Self {
        TraceView { own_motion: false, against: against.into_iter().collect(), by_approach: false }
    }

    /// With points of each direction of approach in a class of their own.
    pub fn by_approach(self) -> Self {
        TraceView { by_approach: true, ..self }
    }
}
