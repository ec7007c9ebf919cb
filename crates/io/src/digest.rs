//! SHA-256 of what a file holds: whether a run is repeated on the same files.
//!
//! Source: FIPS 180-4. No secret is kept with it.

use crate::IoError;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Length and SHA-256 (hexadecimal) of a file.
///
/// # Errors
/// [`IoError::Read`] when it cannot be read.
pub fn file_digest(path: impl AsRef<Path>) -> Result<(u64, String), IoError> {
    let path = path.as_ref();
    let bytes = fs::read(path).map_err(|source| IoError::Read { file: path.into(), source })?;
    Ok((bytes.len() as u64, sha256(&bytes)))
}

/// SHA-256 of bytes, in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    let mut padded = bytes.to_vec();
    padded.push(0x80);
    while padded.len() % 64 != 56 {
        padded.push(0);
    }
    padded.extend((bytes.len() as u64 * 8).to_be_bytes());
    let mut state = roots(1.0 / 2.0, 8);
    let keys = roots(1.0 / 3.0, 64);
    for block in padded.chunks_exact(64) {
        absorb(&mut state, block, &keys);
    }
    state.iter().fold(String::new(), |mut text, word| {
        let _ = write!(text, "{word:08x}");
        text
    })
}

/// Thirty-two bits behind the point of the square or cube roots of the first primes.
fn roots(power: f64, count: usize) -> Vec<u32> {
    (2u32..)
        .filter(|n| (2..*n).take_while(|d| d * d <= *n).all(|d| n % d != 0))
        .take(count)
        .map(|prime| {
            // The root to 32 bits behind the point, in whole numbers: no rounding of floats.
            let whole = |guess: u128| -> bool {
                if power > 0.4 {
                    guess * guess <= u128::from(prime) << 64
                } else {
                    guess * guess * guess <= u128::from(prime) << 96
                }
            };
            let near = (f64::from(prime).powf(power) * 4_294_967_296.0) as u128;
            let mut root = near.saturating_sub(64);
            while whole(root + 1) {
                root += 1;
            }
            root as u32
        })
        .collect()
}

fn absorb(state: &mut [u32], block: &[u8], keys: &[u32]) {
    let mut words = [0u32; 64];
    for (word, bytes) in words.iter_mut().zip(block.chunks_exact(4)) {
        *word = bytes.iter().fold(0, |word, byte| word << 8 | u32::from(*byte));
    }
    for k in 16..64 {
        let (a, b) = (words[k - 15], words[k - 2]);
        let s0 = a.rotate_right(7) ^ a.rotate_right(18) ^ (a >> 3);
        let s1 = b.rotate_right(17) ^ b.rotate_right(19) ^ (b >> 10);
        words[k] = words[k - 16].wrapping_add(s0).wrapping_add(words[k - 7]).wrapping_add(s1);
    }
    let mut v: [u32; 8] = std::array::from_fn(|k| state[k]);
    for (word, key) in words.iter().zip(keys) {
        let s1 = v[4].rotate_right(6) ^ v[4].rotate_right(11) ^ v[4].rotate_right(25);
        let choice = (v[4] & v[5]) ^ (!v[4] & v[6]);
        let first = v[7].wrapping_add(s1).wrapping_add(choice).wrapping_add(*key).wrapping_add(*word);
        let s0 = v[0].rotate_right(2) ^ v[0].rotate_right(13) ^ v[0].rotate_right(22);
        let majority = (v[0] & v[1]) ^ (v[0] & v[2]) ^ (v[1] & v[2]);
        v.rotate_right(1);
        v[4] = v[4].wrapping_add(first);
        v[0] = first.wrapping_add(s0.wrapping_add(majority));
    }
    for (state, v) in state.iter_mut().zip(v) {
        *state = state.wrapping_add(v);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digests_of_the_standard() {
        assert_eq!(sha256(b""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
        assert_eq!(sha256(b"abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        assert_eq!(
            sha256(b"abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1"
        );
        assert_eq!(
            sha256(&[b'a'; 1_000_000]),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0"
        );
    }
}
