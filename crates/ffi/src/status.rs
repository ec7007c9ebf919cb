//! What a call returns: 0, an outcome of a command above 0, or an error of its use below 0.

use std::cell::RefCell;
use std::ffi::{CString, c_char};
use truepose_compensate::Status;

/// Done.
pub const TRUEPOSE_OK: i32 = 0;
/// No joint values were found that reach the pose.
pub const TRUEPOSE_UNREACHABLE: i32 = 1;
/// Only joint values beyond their limits would reach the pose.
pub const TRUEPOSE_LIMIT: i32 = 2;
/// The search did not converge.
pub const TRUEPOSE_NOT_CONVERGED: i32 = 3;
/// A pointer that is required is null.
pub const TRUEPOSE_ERROR_NULL: i32 = -1;
/// A list has the wrong length.
pub const TRUEPOSE_ERROR_LENGTH: i32 = -2;
/// A number is not finite, or a quaternion is zero.
pub const TRUEPOSE_ERROR_NOT_FINITE: i32 = -3;
/// The robot has no such target, or the fit does not know where it is.
pub const TRUEPOSE_ERROR_TARGET: i32 = -4;
/// A value has no meaning (a kind of load, an option).
pub const TRUEPOSE_ERROR_ARGUMENT: i32 = -5;
/// The fit cannot be read or used; `truepose_last_error` has the reason.
pub const TRUEPOSE_ERROR_FIT: i32 = -6;
/// A defect of the library. The arm that was in use returns this from now on: free it.
pub const TRUEPOSE_ERROR_PANIC: i32 = -7;
/// An orientation is desired, and the fit does not determine that of the tool.
pub const TRUEPOSE_ERROR_ORIENTATION: i32 = -8;

/// The code of a command.
pub(crate) fn code(status: Status) -> i32 {
    match status {
        Status::Ok => TRUEPOSE_OK,
        Status::Unreachable => TRUEPOSE_UNREACHABLE,
        Status::Limit => TRUEPOSE_LIMIT,
        Status::NotConverged => TRUEPOSE_NOT_CONVERGED,
    }
}

/// What a code means, in one line: a static text, never null.
#[unsafe(no_mangle)]
pub extern "C" fn truepose_message(code: i32) -> *const c_char {
    let text: &'static str = match code {
        TRUEPOSE_OK => "done\0",
        TRUEPOSE_UNREACHABLE => "the pose is out of reach\0",
        TRUEPOSE_LIMIT => "only joint values beyond their limits would reach the pose\0",
        TRUEPOSE_NOT_CONVERGED => "the search for joint values did not converge\0",
        TRUEPOSE_ERROR_NULL => "a pointer that is required is null\0",
        TRUEPOSE_ERROR_LENGTH => "a list has the wrong length\0",
        TRUEPOSE_ERROR_NOT_FINITE => "a number is not finite, or a quaternion is zero\0",
        TRUEPOSE_ERROR_TARGET => "the robot has no such target, or the fit does not know where it is\0",
        TRUEPOSE_ERROR_ARGUMENT => "a value has no meaning\0",
        TRUEPOSE_ERROR_FIT => "the fit cannot be read or used\0",
        TRUEPOSE_ERROR_PANIC => "a defect of the library\0",
        TRUEPOSE_ERROR_ORIENTATION => "the fit does not determine the orientation of the tool\0",
        _ => "no code of this library\0",
    };
    text.as_ptr().cast()
}

thread_local! {
    static REASON: RefCell<CString> = RefCell::new(CString::default());
}

/// Records why a fit was refused.
pub(crate) fn because(reason: &str) {
    let text = CString::new(reason.replace('\0', " ")).unwrap_or_default();
    REASON.with(|last| last.replace(text));
}

/// Why the last fit was refused by this thread (file, line and column where there are any); empty when none was. Valid until the next call
/// of this thread that loads a fit or makes an arm.
#[unsafe(no_mangle)]
pub extern "C" fn truepose_last_error() -> *const c_char {
    REASON.try_with(|last| last.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}
