//! What is drawn of a robot.

pub use crate::draw::Draw;

/// What a stream is for.
#[derive(Debug, Clone, Copy)]
pub enum Stream {
    Shape = 1,
    Place,
    Known,
    Visits,
    Hidden,
    Unnamed,
    Scatter,
    Seen,
    Spoil,
    Fresh,
}

impl Stream {
    pub fn draw(self, seed: u64) -> Draw {
        Draw::of(seed, self as u64)
    }
}
