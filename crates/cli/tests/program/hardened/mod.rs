//! What a red team found, each in a test of its own that failed before it was mended.

mod inputs;
mod pipes;
mod sizes;
mod verify;
