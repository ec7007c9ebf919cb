//! What the robot carries: the load of the tool, or of `\\TLoad`, and the one that `GripLoad` has switched on.

use super::cfg::{MODAL, WRIST};
use super::node::Node;
use crate::definitions::{Definition, Definitions};
use crate::flow::{Active, Flow, LOAD};
use crate::reference::{Carried, Reference};
use truepose_kinematics::Pose;
use truepose_kinematics::nalgebra::Vector3;

/// The loads of a motion.
#[derive(Debug, Clone)]
pub(super) struct Held {
    /// The option `\\TLoad`, in place of the tool's.
    pub(super) total: Option<Reference>,
    /// The number of its use, for what `GripLoad` has switched on.
    pub(super) used: usize,
}

/// Which load `GripLoad` has switched on at a statement.
#[derive(Debug, Clone)]
pub(super) struct Grip {
    flow: Flow,
    /// The THEN that follows is that of an ELSEIF.
    another: bool,
    /// Whether any load is gripped in the file.
    pub(super) any: bool,
}

/// None is on, unless another routine has switched it on.
const NONE: Active = [Reference::Identity, Reference::Identity, Reference::Identity];

impl Default for Grip {
    fn default() -> Self {
        let mut flow = Flow::new("");
        flow.restart(NONE);
        Grip { flow, another: false, any: false }
    }
}

/// Instructions of the language that stand between gripping and moving.
const SIGNALS: [&str; 22] = [
    "SET",
    "RESET",
    "SETDO",
    "SETGO",
    "SETAO",
    "PULSEDO",
    "INVERTDO",
    "WAITTIME",
    "WAITDI",
    "WAITDO",
    "WAITUNTIL",
    "WAITROB",
    "TPWRITE",
    "TPERASE",
    "ACCSET",
    "VELSET",
    "SINGAREA",
    "INCR",
    "DECR",
    "CLKSTART",
    "CLKSTOP",
    "STOP",
];

/// Why the gripped load is not clear.
const OPEN: &str = "whether a load of GripLoad is active is not clear";

impl Grip {
    /// A routine begins.
    pub(super) fn begin(&mut self) {
        self.flow.restart(NONE);
    }

    pub(super) fn set(&mut self, name: String) {
        self.any |= name != "LOAD0";
        let to = match name.as_str() {
            "LOAD0" => Reference::Value(Pose::IDENTITY),
            _ => Reference::Named(name),
        };
        self.flow.set(LOAD, to);
    }

    /// An instruction: another routine may grip.
    pub(super) fn call(&mut self, word: &str) {
        if !SIGNALS.contains(&word) {
            self.flow.set(LOAD, Reference::Identity);
        }
    }

    /// A keyword that may open or close a block; `IF a b;` has no THEN.
    pub(super) fn block(&mut self, word: &str) {
        match word {
            "ELSEIF" => {
                self.another = true;
                self.flow.branch();
            }
            "THEN" if std::mem::take(&mut self.another) => {}
            "THEN" | "TEST" => self.flow.open(false),
            "DO" => self.flow.open(true),
            "ELSE" | "CASE" | "DEFAULT" => self.flow.branch(),
            "ENDIF" | "ENDFOR" | "ENDWHILE" | "ENDTEST" => self.flow.close(),
            _ => {}
        }
    }

    /// A motion: the number of its use.
    pub(super) fn motion(&mut self) -> usize {
        self.flow.motion()
    }

    fn at(&self, used: usize) -> &Reference {
        &self.flow.uses[used][LOAD]
    }
}

impl Held {
    /// The load of a motion with this tool; `grips`: whether some routine grips a load.
    pub(super) fn carried(
        &self,
        tool: &Reference,
        grip: &Grip,
        definitions: &Definitions,
        grips: bool,
    ) -> Carried {
        // A controller takes `TLoad` or GripLoad; without its configuration each that is there.
        let modal = definitions.switch(MODAL);
        let own = match (self.total.as_ref().filter(|_| modal != Some(true)), tool) {
            (Some(total), _) => definitions.load(total),
            (None, Reference::Named(name)) => definitions.load(&Reference::Named(format!("{name}.TLOAD"))),
            (None, Reference::Identity) => {
                Carried::Mass { name: "tool0".into(), mass: 0.0, com: Vector3::zeros() }
            }
            (None, _) => Carried::Open("the tool has no name".into()),
        };
        let grip = match grip.at(self.used) {
            _ if modal == Some(false) => return own,
            // Without a GripLoad in the files none is on; with one in another routine it may be.
            Reference::Identity if grips => return Carried::Open(OPEN.into()),
            Reference::Identity | Reference::Value(_) => return own,
            named => definitions.load(named),
        };
        let frame = match tool {
            _ if definitions.switch(WRIST) == Some(true) => Some(Pose::IDENTITY),
            Reference::Named(name) => definitions.get(name).ok().flatten(),
            Reference::Identity => Some(Pose::IDENTITY),
            _ => None,
        };
        match (own, grip, frame) {
            (
                Carried::Mass { name, mass, com },
                Carried::Mass { name: other, mass: more, com: there },
                Some(frame),
            ) => {
                let total = mass + more;
                // The gripped load's centre is in the tool's frame, or in the flange's.
                let sum = mass * com + more * frame.apply(&there);
                let com = if total > 0.0 { sum / total } else { sum };
                Carried::Mass { name: format!("{name} and {other}"), mass: total, com }
            }
            (Carried::Open(words), ..) | (_, Carried::Open(words), _) => Carried::Open(words),
            _ => Carried::Open(OPEN.into()),
        }
    }
}

/// `[mass,[x,y,z],…]`
pub(super) fn load(node: Option<&Node>) -> Definition {
    let read = || {
        let items = node?.items();
        let Node::Number(mass, _) = items.first()? else { return None };
        let center = items.get(1)?.numbers(3)?;
        Some(Definition::Load(*mass, 1e-3 * Vector3::new(center[0].0, center[1].0, center[2].0)))
    };
    read().unwrap_or_else(|| Definition::Unusable("its load is not made of numbers".into()))
}
