//! What happens in a program, in the order of its text.

/// What happens in a file, in the order of its text.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Event {
    /// A destination of a motion.
    Visit(Visit),
    /// A routine begins; it may be inside another one.
    Begin(String),
    /// The innermost routine ends.
    End,
    /// A routine is called, or something else of this name.
    Call(String),
    /// From here on configuration data of joint motions, or of linear ones, is followed or not.
    Control { linear: bool, followed: bool },
}

/// A destination.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Visit {
    /// Points of the program that it may be, by their places; none: a place that is not known.
    pub(crate) points: Vec<usize>,
    /// Whether the tool moves along a line or an arc.
    pub(crate) linear: bool,
    /// Line of the motion, from 1.
    pub(crate) line: usize,
}

impl Visit {
    pub(crate) fn event(points: Vec<usize>, linear: bool, line: usize) -> Event {
        Event::Visit(Visit { points, linear, line })
    }
}
