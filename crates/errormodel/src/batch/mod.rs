//! A model in a block of rows at once.

mod columns;
mod engine;
mod fill;

pub use engine::{Lanes, Phi};
pub use fill::Component;

#[cfg(test)]
mod tests;
