//! Rows as keys of a table.

use std::hash::{Hash, Hasher};

/// 128 mixed bits of some numbers: equal numbers give equal bits, and no collision is to be expected otherwise.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(super) struct Mixed {
    a: u64,
    b: u64,
}

impl Hash for Mixed {
    fn hash<H: Hasher>(&self, state: &mut H) {
        state.write_u64(self.a);
    }
}

/// Passes on bits that are mixed already.
#[derive(Default)]
pub(super) struct AlreadyMixed(u64);

impl Hasher for AlreadyMixed {
    fn finish(&self) -> u64 {
        self.0
    }

    fn write(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.write_u64(u64::from(byte));
        }
    }

    fn write_u64(&mut self, bits: u64) {
        self.0 = self.0.rotate_left(5) ^ bits;
    }
}

impl Mixed {
    /// Takes a number in.
    pub(super) fn add(&mut self, value: f64) {
        let bits = value.to_bits();
        self.a = (self.a ^ bits).wrapping_mul(0x9E37_79B9_7F4A_7C15).rotate_left(31);
        self.b = (self.b.rotate_left(23) ^ bits).wrapping_mul(0xC2B2_AE3D_27D4_EB4F).rotate_left(29) ^ self.a;
    }
}
