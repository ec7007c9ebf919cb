//! What a trace is made of.

/// One effect against its driver, row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct Trace {
    /// Which error: `a2 about its axis`.
    pub what: String,
    /// Its unit: rad, m or kg.
    pub unit: &'static str,
    /// What drives it: a joint, a load, a channel, the time.
    pub driver: String,
    /// The driver's unit, SI or as the channel has it.
    pub driver_unit: String,
    /// Names of the classes that points belong to (sides of approach); empty without classes.
    pub classes: Vec<String>,
    /// Rows whose position was measured and depends on the error.
    pub points: Vec<TracePoint>,
}

/// One row of a trace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TracePoint {
    /// Row of the data (0-based).
    pub row: usize,
    /// The driver.
    pub driver: f64,
    /// What the effect is not asked to explain away: e + f.
    pub before: f64,
    /// What is left: e.
    pub after: f64,
    /// What the model says: f.
    pub fitted: f64,
    /// Standard deviation of f from its coefficients.
    pub sd: f64,
    /// |m|.
    pub lever: f64,
    /// Which class.
    pub class: usize,
}
