//! A program and its points, whatever its language.

use crate::event::Event;
use crate::note::Note;
use crate::number::Slot;
use crate::{ControllerError, Dialect, Orientation};
use std::collections::BTreeMap;
use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::Vector3;

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

/// A frame or a tool of a point.
#[derive(Debug, Clone, PartialEq)]
pub enum Reference {
    /// The robot's base, or its flange.
    Identity,
    /// One that the program names.
    Named(String),
    /// One whose value stands in the program, m.
    Value(Pose),
    /// Unknown, for this reason.
    Unknown(String),
    /// Not compensated for this reason, whatever else is stated.
    Excluded(String),
}

impl Reference {
    /// In words.
    pub fn words(&self) -> String {
        match self {
            Reference::Identity => "none".into(),
            Reference::Named(name) => name.clone(),
            Reference::Value(_) => "given in the program".into(),
            Reference::Unknown(_) => "unknown".into(),
            Reference::Excluded(_) => "not compensated".into(),
        }
    }
}

/// What the robot carries at a point, as the program states it.
#[derive(Debug, Clone, PartialEq)]
pub enum Carried {
    /// It is not stated, or not clear, for this reason.
    Open(String),
    /// A load.
    Mass {
        /// As the program calls it.
        name: String,
        /// kg.
        mass: f64,
        /// Centre of gravity in the controller's flange, m.
        com: Vector3<f64>,
    },
}

impl Carried {
    pub(crate) fn unstated() -> Carried {
        Carried::Open("the program states none".into())
    }
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

/// Values of frames and tools by their names in the program.
#[derive(Debug, Clone, Default)]
pub struct Definitions(pub(crate) BTreeMap<String, Definition>);

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Definition {
    Value(Pose),
    SameAs(String),
    /// Mass, kg, and centre of gravity in the flange, m.
    Load(f64, Vector3<f64>),
    /// A setting of the controller that is on or off.
    Switch(bool),
    /// In the axes of a unit that moves: a positioner. Known where it is stated which one it is.
    Carried(Reference),
    /// It has a value that cannot be used, for this reason.
    Unusable(String),
    /// Its points are not compensated, whatever else is stated.
    Excluded(String),
}

impl Definitions {
    pub(crate) fn put(&mut self, name: String, definition: Definition) {
        if matches!(definition, Definition::Excluded(_)) {
            self.0.insert(name, definition);
            return;
        }
        // A name with two values is neither.
        if let Some(old) = self.0.get(&name) {
            let same = *old == definition;
            if !same && !matches!(old, Definition::Excluded(_)) {
                let words = format!("{name} has more than one value in the files given");
                self.0.insert(name, Definition::Unusable(words));
            }
            return;
        }
        self.0.insert(name, definition);
    }

    /// The value of a name; none where the files do not have it.
    ///
    /// # Errors
    /// When it has one that cannot be used.
    pub fn get(&self, name: &str) -> Result<Option<Pose>, String> {
        let mut name = name;
        // Chains of names are short; a ring of them has no value.
        for _ in 0..8 {
            match self.0.get(name) {
                None | Some(Definition::Load(..) | Definition::Switch(_)) => return Ok(None),
                Some(Definition::Value(pose)) => return Ok(Some(*pose)),
                Some(Definition::Unusable(words) | Definition::Excluded(words)) => return Err(words.clone()),
                Some(Definition::Carried(_)) => {
                    return Err(format!(
                        "a unit that moves carries it (--work {name}=TOOL where the fit has the unit)"
                    ));
                }
                Some(Definition::SameAs(other)) => name = other,
            }
        }
        Ok(None)
    }

    /// The value of a frame in the axes of the unit that carries it.
    pub(crate) fn carried(&self, name: &str) -> Result<Option<Pose>, String> {
        match self.0.get(self.last_name(name)) {
            Some(Definition::Carried(Reference::Value(pose))) => Ok(Some(*pose)),
            Some(Definition::Carried(Reference::Named(other))) => self.get(other),
            _ => self.get(name),
        }
    }

    /// The load of a reference.
    pub(crate) fn load(&self, reference: &Reference) -> Carried {
        match reference {
            Reference::Named(name) => {
                let name = self.last_name(name);
                // `GRIP.TLOAD` is the load of GRIP.
                let shown = name.split('.').next().unwrap_or(name);
                match self.0.get(name) {
                    Some(Definition::Load(mass, com)) => {
                        Carried::Mass { name: shown.into(), mass: *mass, com: *com }
                    }
                    Some(Definition::Unusable(words)) => Carried::Open(words.clone()),
                    _ => Carried::Open(format!("the load of {shown} has no value in the files given")),
                }
            }
            Reference::Unknown(words) => Carried::Open(words.clone()),
            _ => Carried::unstated(),
        }
    }

    /// Whether a setting of the controller is on; none where the files do not have it.
    pub(crate) fn switch(&self, name: &str) -> Option<bool> {
        match self.0.get(name) {
            Some(Definition::Switch(on)) => Some(*on),
            _ => None,
        }
    }

    /// Why points with this frame or tool are not compensated, whatever else is stated.
    pub(crate) fn excluded(&self, name: &str) -> Option<&str> {
        match self.0.get(self.last_name(name)) {
            Some(Definition::Excluded(words)) => Some(words),
            _ => None,
        }
    }

    /// The last name in a chain of names.
    pub fn last_name<'a>(&'a self, name: &'a str) -> &'a str {
        let mut name = name;
        for _ in 0..8 {
            match self.0.get(name) {
                Some(Definition::SameAs(other)) => name = other,
                _ => break,
            }
        }
        name
    }
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
