//! What there is to know of a program besides its points.

/// A statement about the program that is not about one of its points.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// From 1.
    pub line: usize,
    /// What it is about.
    pub name: String,
    /// In words.
    pub words: String,
    /// Whether a compensated program would move otherwise than it says: a position that is computed from a point.
    pub refuses: bool,
    /// The point to which a motion goes and which has no value in the files given.
    pub missing: Option<String>,
    /// The file of the line: 0 is the program, 1 the first of the further files.
    pub file: usize,
}

impl Note {
    /// Of a motion to a point without a value.
    pub(crate) fn missing(line: usize, name: String, point: String) -> Note {
        let words = format!("{point} has no value in the files given");
        Note { line, name, words, refuses: false, missing: Some(point), file: 0 }
    }

    /// Of a position that is computed while the program runs, or a motion that is not understood.
    pub(crate) fn refusing(line: usize, name: String, words: String) -> Note {
        Note { line, name, words, refuses: true, missing: None, file: 0 }
    }
}
