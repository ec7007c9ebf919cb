//! What crosses the border: pointers become references or codes, and no panic gets out.

use crate::status::{TRUEPOSE_ERROR_LENGTH, TRUEPOSE_ERROR_NULL, TRUEPOSE_ERROR_PANIC};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// The code of a call; a panic is one as well.
pub(crate) fn guarded(call: impl FnOnce() -> Result<i32, i32>) -> i32 {
    match catch_unwind(AssertUnwindSafe(call)) {
        Ok(Ok(code) | Err(code)) => code,
        Err(_) => TRUEPOSE_ERROR_PANIC,
    }
}

/// Numbers of the caller; exactly so many.
///
/// # Safety
/// `pointer` is null, or leads to `count` numbers that nobody writes while the slice is in use.
pub(crate) unsafe fn numbers<'a>(pointer: *const f64, count: usize, need: usize) -> Result<&'a [f64], i32> {
    if count != need {
        return Err(TRUEPOSE_ERROR_LENGTH);
    }
    if count == 0 {
        return Ok(&[]);
    }
    if pointer.is_null() {
        return Err(TRUEPOSE_ERROR_NULL);
    }
    // SAFETY: not null, and `count` numbers by the caller's promise; `count` is the number of joints or channels of a robot.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// A value of the caller.
///
/// # Safety
/// `pointer` is null, or leads to a value that nobody writes while the reference is in use.
pub(crate) unsafe fn given<'a, T>(pointer: *const T) -> Result<&'a T, i32> {
    // SAFETY: the promise is the caller's.
    unsafe { pointer.as_ref() }.ok_or(TRUEPOSE_ERROR_NULL)
}

/// A value of the caller that is written.
///
/// # Safety
/// `pointer` is null, or leads to a value that nobody else uses while the reference is in use.
pub(crate) unsafe fn taken<'a, T>(pointer: *mut T) -> Result<&'a mut T, i32> {
    // SAFETY: the promise is the caller's.
    unsafe { pointer.as_mut() }.ok_or(TRUEPOSE_ERROR_NULL)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_a_code() {
        assert_eq!(guarded(|| Ok(3)), 3);
        assert_eq!(guarded(|| Err(-2)), -2);
        assert_eq!(guarded(|| panic!("a defect that a test makes")), TRUEPOSE_ERROR_PANIC);
    }

    #[test]
    fn lists_are_measured_before_they_are_read() {
        // SAFETY: no pointer here is read.
        unsafe {
            assert_eq!(numbers(std::ptr::null(), 6, 6), Err(TRUEPOSE_ERROR_NULL));
            assert_eq!(numbers(std::ptr::null(), 5, 6), Err(TRUEPOSE_ERROR_LENGTH));
            assert_eq!(numbers(std::ptr::null(), 0, 0), Ok(&[][..]));
            assert_eq!(given::<f64>(std::ptr::null()), Err(TRUEPOSE_ERROR_NULL));
        }
    }
}
