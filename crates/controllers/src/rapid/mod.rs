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

mod cfg;
mod file;
mod instructions;
mod load;
mod motion;
mod node;
mod points;

use crate::definitions::{Definition, Definitions};
use crate::{ControllerError, Dialect, Program};
use file::File;
use truepose_kinematics::Pose;

pub(crate) fn read(text: &[u8], others: &[&[u8]]) -> Result<Program, ControllerError> {
    let mut definitions = Definitions::default();
    for text in others.iter().copied().chain([text]).filter(|text| cfg::is(text)) {
        cfg::read(text, &mut definitions)?;
    }
    if cfg::is(text) {
        return Ok(Program::of_frames(Dialect::Rapid, text, definitions));
    }
    let mut files = vec![File::read(text)?];
    for (k, other) in others.iter().enumerate() {
        // Its place in the list is that of the file.
        let file = if cfg::is(other) { Ok(File::default()) } else { File::read(other) };
        files.push(file.map_err(|error| error.in_other(k))?);
    }
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
