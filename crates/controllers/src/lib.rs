#![doc = include_str!("../README.md")]

mod backup;
mod correct;
mod definitions;
mod dialect;
mod error;
mod event;
mod fanuc;
mod flow;
mod inform;
mod krl;
mod lines;
mod note;
mod number;
mod orientation;
mod program;
mod rapid;
mod reading;
mod reference;
mod route;
mod tokens;
mod urscript;
mod val3;

pub use backup::{Role, calls, linked};
pub use correct::{
    CorrectOptions, Correction, Gathered, Offset, Outcome, Remaining, Taught, Touched, correct, correct_all,
    gathered, is_stated, offsets, unused,
};
pub use definitions::Definitions;
pub use dialect::Dialect;
pub use error::ControllerError;
pub use note::Note;
pub use orientation::Orientation;
pub use program::{Branch, Point, Program, Replacement, Value};
pub use reference::{Carried, Reference};
