//! What the columns of a file are probably, where their names do not say so: one complete proposal, for people to take or leave.
//!
//! ```text
//! headers, first rows ──► Seen (words, unit, values) ──► joints ──► position ──► orientation (held against the robot) ──► load ──► time, id, target
//! ```
//!
//! Nothing of it is applied, but for `X Y Z` with units of length, which are read as `x y z`, and for the only column with a unit of mass, which is
//! read as `payload`, each with a warning.

mod applied;
mod fitting;
mod groups;
mod joints;
mod loads;
mod others;
mod places;
mod seen;
mod turned;
mod units;

pub(super) use applied::applied;
pub(super) use units::impossible;

use super::names::Names;
use super::sampled::Sample;
use seen::{Seen, see};
use std::fmt::Write;

/// Names for columns.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Proposal {
    /// Names of ours and the columns that they may stand for, with the unit where the header has none.
    pairs: Vec<(String, String)>,
    /// The word of the convention of measured orientations.
    orientation: Option<&'static str>,
    /// Columns that cannot be read as numbers.
    ignore: Vec<String>,
    /// Columns of commanded positions and of deviations, which would be read as channels.
    no_cause: Vec<String>,
    /// Targets that the robot file lacks.
    targets: Vec<String>,
    /// What there is to say about it.
    notes: Vec<String>,
    /// Whether a unit was concluded from values.
    guessed: bool,
}

impl Proposal {
    /// Of the headers of a file, as far as their names do not say what they are.
    pub fn of(headers: &[&str], sample: &Sample, names: &Names<'_>) -> Proposal {
        let mut seen = see(headers, sample, names);
        let mut all = Proposal::default();
        let joints = joints::propose(&mut seen, names.chain, &mut all);
        places::propose(&mut seen, names, &mut all);
        turned::propose(&mut seen, names, joints.as_deref(), &mut all);
        loads::propose(&mut seen, &mut all);
        others::propose(&mut seen, names, &mut all);
        all
    }

    /// Whether it says nothing that messages about rows do not say: columns to leave out are named there.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
            && self.orientation.is_none()
            && self.notes.is_empty()
            && self.no_cause.is_empty()
            && self.targets.is_empty()
    }

    /// The unit that was concluded for a column of ours.
    fn unit_of(&self, ours: &str) -> Option<&'static str> {
        let (_, theirs) = self.pairs.iter().find(|(name, _)| name == ours)?;
        let (_, unit) = theirs.strip_suffix(']')?.rsplit_once('[')?;
        crate::Unit::named(unit).map(|unit| unit.word)
    }

    /// What is the matter with the columns that it is about.
    pub fn matter(&self) -> &'static str {
        match self.pairs.is_empty() && self.orientation.is_none() && !self.no_cause.is_empty() {
            true => "columns are read as channels that are none",
            false => "some columns are not read, or as channels, that may have a meaning",
        }
    }

    /// Whether it is about the column of this header.
    pub fn has(&self, header: &str) -> bool {
        let theirs = |theirs: &str| {
            theirs == header || theirs.strip_prefix(header).is_some_and(|rest| rest.starts_with('['))
        };
        self.pairs.iter().any(|(_, column)| theirs(column))
    }

    fn pair(&mut self, seen: &mut Seen<'_>, ours: &str, unit: Option<&str>) {
        seen.free = false;
        let theirs = match (seen.unit, unit) {
            (None, Some(unit)) => {
                self.guessed |= !seen.unit_in_words;
                format!("{}[{unit}]", seen.header)
            }
            _ => seen.header.to_owned(),
        };
        self.pairs.push((ours.to_owned(), theirs));
    }

    /// To end a message with: options for the command line, and a table for the robot's TOML; empty where there is nothing to propose.
    pub fn text(&self) -> String {
        if self.is_empty() {
            return String::new();
        }
        let mut text = String::new();
        let mut options: Vec<String> = Vec::new();
        options.extend(
            self.pairs.iter().map(|(ours, theirs)| format!("--map {}", quoted(&format!("{ours}={theirs}")))),
        );
        options.extend(self.orientation.map(|word| format!("--orientation {word}")));
        let ignore: Vec<&String> = self.ignore.iter().chain(&self.no_cause).collect();
        options.extend(ignore.iter().map(|column| format!("--ignore {}", quoted(column))));
        if !options.is_empty() {
            let _ = write!(text, "\nperhaps they are meant by: {}", options.join(" "));
            text += "\nor in the robot's TOML:\n[columns]";
            for (ours, theirs) in &self.pairs {
                let _ = write!(text, "\n{} = {}", key(ours), toml(theirs));
            }
            if let Some(word) = self.orientation {
                let _ = write!(text, "\norientation = \"{word}\"");
            }
            if !ignore.is_empty() {
                let columns: Vec<String> = ignore.iter().map(|column| toml(column)).collect();
                let _ = write!(text, "\nignore = [{}]", columns.join(", "));
            }
        }
        if !self.targets.is_empty() {
            text += "\nand, for the targets that the robot does not have, below it:";
            for target in &self.targets {
                let _ = write!(text, "\n[[targets]]\nname = {}\nknown = false", toml(target));
            }
        }
        if self.guessed {
            text += "\n(units in [] that the header does not have are concluded from the values: check them)";
        }
        if !self.no_cause.is_empty() {
            text += "\n(commanded positions, deviations and matrices are no quantities that errors depend on: they are left out)";
        }
        for note in &self.notes {
            let _ = write!(text, "\n({note})");
        }
        text
    }
}

/// An argument for a shell.
fn quoted(text: &str) -> String {
    match text.contains(['$', '`', '"', '\\', '!']) {
        true => format!("'{}'", text.replace('\'', "'\\''")),
        false => format!("\"{text}\""),
    }
}

/// A key of TOML.
fn key(name: &str) -> String {
    let bare = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    if bare { name.to_owned() } else { toml(name) }
}

/// A string of TOML.
fn toml(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}
