//! KUKA Robot Language, `.src` and `.dat`.
//!
//! ```text
//! point   = [DECL] (E6POS|POS|E6AXIS|AXIS|FRAME) name ["[" n "]"] "=" aggregate      declaration
//!         | name ["[" n "]"] "=" aggregate                                          assignment
//!         | (PTP|LIN|CIRC|SPTP|SLIN|SCIRC|SPL) aggregate ["," aggregate]            motion
//! aggregate = "{" [type ":"] component value {"," component value} "}"
//! frame   = ($BASE|$TOOL) "=" (BASE_DATA|TOOL_DATA) "[" n "]" | BAS(#BASE,n) | FDAT_ACT=name | WITH $TOOL=STOOL2(name)
//! ```
//!
//! A FRAME is a point where a motion goes to it. Keywords and names have no case. A statement that is no motion and has a
//! point in it (`F(XP1)`, `MOVE {X 1, …}`) is refused; everything else is passed over.

mod aggregate;
mod candidate;
mod file;
mod motion;
mod points;
mod settings;

use crate::definitions::{Definition, Definitions};
use crate::{ControllerError, Program};
use file::File;
use truepose_kinematics::Pose;

pub(crate) fn read(text: &[u8], others: &[&[u8]]) -> Result<Program, ControllerError> {
    let mut files = vec![File::read(text)?];
    for (k, other) in others.iter().enumerate() {
        files.push(File::read(other).map_err(|error| error.in_other(k))?);
    }
    let mut definitions = Definitions::default();
    for name in ["BASE_DATA[0]", "TOOL_DATA[0]"] {
        definitions.put(name.into(), Definition::Value(Pose::IDENTITY));
    }
    for (name, definition) in files.iter().flat_map(|file| &file.definitions) {
        definitions.put(name.clone(), definition.clone());
    }
    for (changed, line) in files.iter().flat_map(|file| &file.changed) {
        for (name, definition) in definitions.0.iter_mut().filter(|(name, _)| points::means(changed, name)) {
            *definition = Definition::Unusable(format!("line {line} changes {name} while the program runs"));
        }
    }
    Ok(points::program(text, &files, definitions))
}
