//! What a red team found, each in a test of its own that failed before it was mended.

mod channels;
mod disk;
mod exports;
mod inputs;
mod pipes;
mod sizes;
mod verify;
