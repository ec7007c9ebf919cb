//! A program and its points, whatever its language.

use crate::definitions::Definitions;
use crate::event::Event;
use crate::note::Note;
use crate::number::Slot;
use crate::reference::{Carried, Reference};
use crate::{ControllerError, Dialect, Orientation};
use truepose_kinematics::Pose;

/// A program, byte for byte, and what was read of it.
#[derive(Debug, Clone)]
pub struct Program {
    pub(crate) dialect: Dialect,
    pub(crate) text: Vec<u8>,
    pub(crate) points: Vec<Point>,
    pub(crate) definitions: Definitions,
    /// What happens in each file, this one first; files in which nothing happens may be absent at the end.
    pub(crate) route: Vec<Vec<Event>>,
    pub(crate) notes: Vec<Note>,
}

/// A point with literal numbers in the program.
#[derive(Debug, Clone)]
pub struct Point {
    /// As the program calls it; of a point without a name the instruction.
    pub name: String,
    /// Line of its first number, from 1.
    pub line: usize,
    /// What it is.
    pub value: Value,
    /// External axes with their values as written.
    pub external: Vec<(String, f64)>,
    /// What the robot carries there.
    pub carried: Carried,
    /// Why it must not be changed, whatever its value; none: it may.
    pub fixed: Option<String>,
    pub(crate) slots: Vec<Slot>,
    /// The numbers in the slots, as they stand.
    pub(crate) written: Vec<f64>,
    /// Numbers of the configuration that a correction may change: turns and quadrants.
    pub(crate) turns: Vec<Slot>,
}

/// The kind of a point.
#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "most points are poses, and a program has some hundreds")]
pub enum Value {
    /// A pose of the tool in a frame.
    Pose {
        /// Its value, m.
        pose: Pose,
        /// The frame in which it is given.
        frame: Reference,
        /// The tool whose pose it is.
        tool: Reference,
        /// The arm's configuration.
        branch: Branch,
    },
    /// Joint values in the units of the program.
    Joints(Vec<f64>),
}

/// Data of the arm's configuration.
#[derive(Debug, Clone, PartialEq)]
pub enum Branch {
    /// None: the configuration nearest to the point before.
    Continuous,
    /// Data that is not interpreted; equal data of two points is taken for the same configuration.
    Opaque(String),
    /// The configuration nearest to these joints, rad.
    Near(Vec<f64>),
    /// KUKA's S and T.
    Kuka {
        /// Bits 0 to 2: overhead, elbow, wrist.
        status: i64,
        /// A bit for each negative axis.
        turn: Option<i64>,
    },
    /// ABB's cf1, cf4, cf6, cfx.
    Abb([i64; 4]),
    /// Stäubli's shoulder, elbow and wrist.
    Val3 {
        /// lefty, not righty; none: as at the point before.
        lefty: Option<bool>,
        /// epositive, not enegative.
        elbow: Option<bool>,
        /// wpositive, not wnegative.
        wrist: Option<bool>,
    },
    /// FANUC's letters and turn numbers.
    Fanuc {
        /// F, not N.
        flip: bool,
        /// U, not D.
        up: bool,
        /// T, not B.
        toward: bool,
        /// Turn numbers of three axes.
        turns: [i64; 3],
    },
}

/// What becomes of a point: its new numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct Replacement {
    /// Pose in the point's frame (m) or joints in the program's units.
    pub numbers: Vec<f64>,
    /// Turn numbers of the configuration; empty: as they are.
    pub turns: Vec<i64>,
}

impl Program {
    /// A file that has frames and tools alone.
    pub(crate) fn of_frames(dialect: Dialect, text: &[u8], definitions: Definitions) -> Program {
        let (points, route, notes) = (Vec::new(), Vec::new(), Vec::new());
        Program { dialect, text: text.to_vec(), points, definitions, route, notes }
    }

    /// Its language.
    pub fn dialect(&self) -> Dialect {
        self.dialect
    }

    /// Its points, in the order of the text.
    pub fn points(&self) -> &[Point] {
        &self.points
    }

    /// Frames and tools whose values stand in the files.
    pub fn definitions(&self) -> &Definitions {
        &self.definitions
    }

    /// Motions of this file: their lines, and the points to which they go.
    pub fn motions(&self) -> impl Iterator<Item = (usize, &[usize])> {
        self.route.first().into_iter().flatten().filter_map(|event| match event {
            Event::Visit(visit) => Some((visit.line, visit.points.as_slice())),
            _ => None,
        })
    }

    /// Of each point, whether a motion of the files goes to it.
    pub fn reached(&self) -> Vec<bool> {
        let mut reached = vec![false; self.points.len()];
        for event in self.route.iter().flatten() {
            if let Event::Visit(visit) = event {
                visit.points.iter().for_each(|&k| reached[k] = true);
            }
        }
        reached
    }

    /// What else there is to know.
    pub fn notes(&self) -> &[Note] {
        &self.notes
    }

    /// The text with these points replaced: one for each point, none leaves it as it is. Nothing else changes.
    ///
    /// # Errors
    /// When the replacements are not those of this program's points.
    pub fn rewritten(&self, replacements: &[Option<Replacement>]) -> Result<Vec<u8>, ControllerError> {
        let unfit = || ControllerError::Option("the replacements are not those of this program".into());
        if replacements.len() != self.points.len() {
            return Err(unfit());
        }
        let mut edits = Vec::new();
        for (point, new) in self.points.iter().zip(replacements) {
            let Some(new) = new else { continue };
            if new.numbers.len() != point.slots.len()
                || !(new.turns.is_empty() || new.turns.len() == point.turns.len())
                || !new.numbers.iter().all(|value| value.is_finite())
            {
                return Err(unfit());
            }
            edits.extend(point.slots.iter().zip(&new.numbers).map(|(slot, &value)| (slot, value)));
            edits.extend(point.turns.iter().zip(&new.turns).map(|(slot, &value)| (slot, value as f64)));
        }
        edits.sort_by_key(|(slot, _)| slot.range.start);
        let mut out = Vec::with_capacity(self.text.len() + 64);
        let mut from = 0;
        for (slot, value) in edits {
            if slot.range.start < from {
                return Err(ControllerError::Option("two points share a number".into()));
            }
            out.extend_from_slice(&self.text[from..slot.range.start]);
            out.extend_from_slice(slot.written(&self.text, value).as_bytes());
            from = slot.range.end;
        }
        out.extend_from_slice(&self.text[from..]);
        Ok(out)
    }
}

impl Point {
    /// Without a value yet.
    pub(crate) fn new(name: String, line: usize) -> Point {
        Point {
            name,
            line,
            value: Value::Joints(Vec::new()),
            external: Vec::new(),
            carried: Carried::unstated(),
            fixed: None,
            slots: Vec::new(),
            written: Vec::new(),
            turns: Vec::new(),
        }
    }

    /// Byte ranges of its numbers.
    pub fn ranges(&self) -> impl Iterator<Item = std::ops::Range<usize>> + '_ {
        self.slots.iter().chain(&self.turns).map(|slot| slot.range.clone())
    }

    /// Numbers of the orientation as they stand, for the choice between those that mean the same.
    pub(crate) fn written_orientation(&self) -> Vec<f64> {
        self.written.get(3..).unwrap_or(&[]).to_vec()
    }

    /// The pose's numbers in the program's form: position, then orientation.
    pub fn numbers_of(&self, pose: &Pose, dialect: Dialect, like: &[f64]) -> Vec<f64> {
        let scale = dialect.length();
        let form: Orientation = dialect.orientation();
        let mut numbers: Vec<f64> = pose.translation.iter().map(|v| v / scale).collect();
        numbers.extend(form.write(&pose.rotation, like));
        numbers
    }
}
