//! The stored form of an accumulator: magic, version, sizes, numbers, checksum; all little-endian.
//!
//! | bytes | content |
//! | --- | --- |
//! | 4 | magic, which kind of accumulator |
//! | 4 | version |
//! | 3 × 8 | columns, right-hand sides, rows |
//! | n × 8 | numbers |
//! | 8 | FNV-1a of everything before |

use crate::SolveError;

const VERSION: u32 = 1;
const HEAD: usize = 32;

/// What is in the bytes.
pub(super) struct Stored {
    pub columns: usize,
    pub rhs: usize,
    pub rows: usize,
    pub numbers: Vec<f64>,
}

pub(super) fn write(magic: [u8; 4], stored: &Stored) -> Vec<u8> {
    let mut out = Vec::with_capacity(HEAD + 8 * stored.numbers.len() + 8);
    out.extend_from_slice(&magic);
    out.extend_from_slice(&VERSION.to_le_bytes());
    for n in [stored.columns, stored.rhs, stored.rows] {
        out.extend_from_slice(&(n as u64).to_le_bytes());
    }
    for v in &stored.numbers {
        out.extend_from_slice(&v.to_le_bytes());
    }
    let sum = checksum(&out);
    out.extend_from_slice(&sum.to_le_bytes());
    out
}

/// Reads back; `count` says how many numbers belong to so many columns and right-hand sides.
pub(super) fn read(
    magic: [u8; 4],
    bytes: &[u8],
    count: impl Fn(usize, usize) -> Option<usize>,
) -> Result<Stored, SolveError> {
    let corrupt = |reason, at| Err(SolveError::Corrupt { reason, at });
    if bytes.len() < HEAD + 8 {
        return corrupt("too short: it was cut off", bytes.len());
    }
    if bytes[..4] != magic {
        return corrupt("it is not of this kind", 0);
    }
    let version: [u8; 4] = [bytes[4], bytes[5], bytes[6], bytes[7]];
    if u32::from_le_bytes(version) != VERSION {
        return corrupt("its version is not 1: read it with the program that wrote it", 4);
    }
    let body = bytes.len() - 8;
    if checksum(&bytes[..body]) != word(bytes, body) {
        return corrupt("its checksum does not match: copy it again", body);
    }
    let size = |at| usize::try_from(word(bytes, at)).ok();
    let (Some(columns), Some(rhs), Some(rows)) = (size(8), size(16), size(24)) else {
        return corrupt("its sizes do not fit this machine", 8);
    };
    let expected = count(columns, rhs).and_then(|n| n.checked_mul(8)).and_then(|n| n.checked_add(HEAD));
    if expected != Some(body) {
        return corrupt("its sizes do not match its length", 8);
    }
    let numbers: Vec<f64> = (HEAD..body).step_by(8).map(|at| f64::from_bits(word(bytes, at))).collect();
    match numbers.iter().position(|v| !v.is_finite()) {
        Some(bad) => corrupt("it holds a number that is not finite", HEAD + 8 * bad),
        None => Ok(Stored { columns, rhs, rows, numbers }),
    }
}

fn word(bytes: &[u8], at: usize) -> u64 {
    bytes[at..at + 8].iter().rev().fold(0, |w, b| (w << 8) | u64::from(*b))
}

fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x100_0000_01b3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flipped_byte_and_every_cut_is_noticed() {
        let stored = Stored { columns: 1, rhs: 1, rows: 9, numbers: vec![1.5, -2.5] };
        let count = |c: usize, r: usize| c.checked_add(r);
        let bytes = write(*b"TEST", &stored);
        assert_eq!(read(*b"TEST", &bytes, count).unwrap().numbers, stored.numbers);
        assert!(read(*b"ELSE", &bytes, count).is_err());
        for at in 0..bytes.len() {
            let mut broken = bytes.clone();
            broken[at] ^= 0x10;
            assert!(read(*b"TEST", &broken, count).is_err(), "byte {at}");
            assert!(read(*b"TEST", &bytes[..at], count).is_err(), "cut {at}");
        }
    }
}
