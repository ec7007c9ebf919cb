//! Numbers and texts as bytes, little-endian, closed by a digest: what was cut off or altered is refused before anything is read.

use crate::error::input;
use pyo3::PyResult;
use truepose_io::sha256;

const DIGEST: usize = 64;

/// Writes.
#[derive(Default)]
pub struct Packer(Vec<u8>);

impl Packer {
    pub fn whole(&mut self, value: u64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    pub fn wide(&mut self, value: u128) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    pub fn number(&mut self, value: f64) {
        self.0.extend_from_slice(&value.to_le_bytes());
    }

    pub fn bytes(&mut self, bytes: &[u8]) {
        self.whole(bytes.len() as u64);
        self.0.extend_from_slice(bytes);
    }

    pub fn numbers(&mut self, numbers: &[f64]) {
        self.whole(numbers.len() as u64);
        numbers.iter().for_each(|&number| self.number(number));
    }

    pub fn finish(mut self) -> Vec<u8> {
        let digest = sha256(&self.0);
        self.0.extend_from_slice(digest.as_bytes());
        self.0
    }
}

/// Reads.
pub struct Unpacker<'a>(&'a [u8]);

impl<'a> Unpacker<'a> {
    pub fn new(bytes: &'a [u8]) -> PyResult<Self> {
        let (content, digest) =
            bytes.split_at_checked(bytes.len().saturating_sub(DIGEST)).unwrap_or((&[], &[]));
        if digest != sha256(content).as_bytes() {
            return Err(input("these bytes were cut off or altered, or are something else"));
        }
        Ok(Unpacker(content))
    }

    fn take(&mut self, count: usize) -> PyResult<&'a [u8]> {
        let (taken, rest) =
            self.0.split_at_checked(count).ok_or_else(|| input("these bytes end too early"))?;
        self.0 = rest;
        Ok(taken)
    }

    fn fixed<const N: usize>(&mut self) -> PyResult<[u8; N]> {
        self.take(N)?.try_into().map_err(input)
    }

    pub fn whole(&mut self) -> PyResult<u64> {
        Ok(u64::from_le_bytes(self.fixed()?))
    }

    pub fn count(&mut self) -> PyResult<usize> {
        usize::try_from(self.whole()?).map_err(input)
    }

    pub fn wide(&mut self) -> PyResult<u128> {
        Ok(u128::from_le_bytes(self.fixed()?))
    }

    pub fn number(&mut self) -> PyResult<f64> {
        Ok(f64::from_le_bytes(self.fixed()?))
    }

    pub fn bytes(&mut self) -> PyResult<&'a [u8]> {
        let count = self.count()?;
        self.take(count)
    }

    pub fn text(&mut self) -> PyResult<&'a str> {
        std::str::from_utf8(self.bytes()?).map_err(input)
    }

    pub fn numbers(&mut self) -> PyResult<Vec<f64>> {
        let count = self.count()?;
        // No more room is made than there are bytes.
        let bytes = self.take(count.checked_mul(8).ok_or_else(|| input("these bytes end too early"))?)?;
        Ok(bytes.chunks_exact(8).map(|b| f64::from_le_bytes(b.try_into().unwrap_or_default())).collect())
    }
}
