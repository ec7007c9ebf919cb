//! Universal Robots' script, `.script`.
//!
//! ```text
//! motion = (movej|movel|movep|movec|servoj|servoc|servol) "(" target { "," … } ")"
//! target = p "[" x,y,z,rx,ry,rz "]" | "[" q1,…,q6 "]" | name
//!        | pose_trans "(" frame "," target ")" | get_inverse_kin "(" target "," qnear "=" joints … ")"
//! value  = [global|local] name "=" (p "[" … "]" | "[" … "]")
//! tool   = set_tcp "(" p "[" … "]" ")"
//! ```
//!
//! A function that is not known and has a pose or joints is refused. A pose or a list is a point where a motion goes to it, directly or under its name. Metres and radians.

mod expression;
mod file;
mod points;

use crate::{ControllerError, Program};
use file::File;

pub(crate) fn read(text: &[u8], others: &[&[u8]]) -> Result<Program, ControllerError> {
    let mut files = vec![File::read(text)?];
    for (k, other) in others.iter().enumerate() {
        files.push(File::read(other).map_err(|error| error.in_other(k))?);
    }
    Ok(points::program(text, &files))
}
