//! ABB RAPID, `.mod`.
//!
//! ```text
//! point      = (CONST|PERS|VAR) (robtarget|jointtarget) name [ "{" n "}" ] ":=" value ";"
//!            | name ":=" value ";"
//!            | motion … value …, tool [ "\" WObj ":=" wobj ] ";"                  see `instructions`
//! robtarget   = "[" [x,y,z] "," [q1,q2,q3,q4] "," [cf1,cf4,cf6,cfx] "," [six external axes] "]"
//! jointtarget = "[" [six joints] "," [six external axes] "]"
//! frame      = wobjdata, tooldata: their values in the files given; wobj0 and tool0 are base and flange
//! ```
//!
//! An instruction that is not known and has a point in it is refused. Statements may span lines, with comments in between. Names have no case.

mod file;
mod instructions;
mod load;
mod motion;
mod node;
mod points;

use crate::program::{Definition, Definitions};
use crate::{ControllerError, Program};
use file::File;
use truepose_kinematics::Pose;

pub(crate) fn read(text: &[u8], others: &[&[u8]]) -> Result<Program, ControllerError> {
    let mut files = vec![File::read(text)?];
    for (k, other) in others.iter().enumerate() {
        files.push(File::read(other).map_err(|error| error.in_other(k))?);
    }
    let mut definitions = Definitions::default();
    for name in ["WOBJ0", "TOOL0"] {
        definitions.put(name.into(), Definition::Value(Pose::IDENTITY));
    }
    for file in &files {
        for (name, definition) in &file.definitions {
            definitions.put(name.clone(), definition.clone());
        }
        for (name, line) in &file.changed {
            if definitions.0.contains_key(name) {
                let words = format!("line {line} changes {name} while the program runs");
                definitions.0.insert(name.clone(), Definition::Unusable(words));
            }
        }
    }
    Ok(points::program(text, &files, definitions))
}
