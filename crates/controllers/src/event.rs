//! What happens in a program, in the order of its text.

use crate::program::Note;

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
}

impl Visit {
    pub(crate) fn event(points: Vec<usize>, linear: bool) -> Event {
        Event::Visit(Visit { points, linear })
    }
}

/// What happens in a file before its points are known.
#[derive(Debug, Clone)]
pub(crate) enum Step {
    /// A motion, by its number.
    Motion(usize),
    Begin(String),
    End,
    Call(String),
    Control {
        linear: bool,
        followed: bool,
    },
    /// The robot moves without a destination.
    Away {
        linear: bool,
    },
}

impl Step {
    /// What happens, with the visits of each motion.
    pub(crate) fn events(&self, visits: impl FnOnce(usize) -> Vec<Event>) -> Vec<Event> {
        vec![match self {
            Step::Motion(number) => return visits(*number),
            Step::Begin(name) => Event::Begin(name.clone()),
            Step::End => Event::End,
            Step::Call(name) => Event::Call(name.clone()),
            Step::Control { linear, followed } => Event::Control { linear: *linear, followed: *followed },
            Step::Away { linear } => Visit::event(Vec::new(), *linear),
        }]
    }
}

/// A motion without its destinations.
#[derive(Debug, Clone)]
pub(crate) struct Head {
    /// From 1.
    pub(crate) line: usize,
    /// As written.
    pub(crate) shown: String,
    /// Along a line or an arc.
    pub(crate) linear: bool,
    /// Why it is not understood.
    pub(crate) odd: Option<String>,
}

impl Head {
    /// Of a motion in this file that stands against the program.
    pub(crate) fn refusing(&self, file: usize, words: &str) -> Note {
        Note { file, ..Note::refusing(self.line, self.shown.clone(), words.into()) }
    }

    /// Of a motion to a point without a value.
    pub(crate) fn missing(&self, file: usize, point: &str) -> Note {
        Note { file, ..Note::missing(self.line, self.shown.clone(), point.into()) }
    }
}
