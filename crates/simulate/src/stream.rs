//! Streams of random numbers: a kind of noise that is switched on leaves the others as they were.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// What a stream is for.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Stream {
    Visit = 1,
    Instrument,
    Orientation,
    Outliers,
    Payloads,
    Channels,
    Joints,
    Wander,
    Station,
    BadPoses,
    Flicker,
    Aims,
    Readings,
}

impl Stream {
    /// The stream of a seed.
    pub fn of(self, seed: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(self as u64);
        rng
    }
}
