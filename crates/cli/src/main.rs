//! The program `truepose`.
fn main() {}
