#![doc = include_str!("../README.md")]
// The border to C: pointers of the caller are read and written here, and nowhere else in the workspace. Each block states why it is sound.
#![allow(unsafe_code)]
#![allow(non_camel_case_types, reason = "the names of the header")]

mod arm;
mod border;
mod conditions;
mod fit;
mod status;
mod structs;

pub use arm::{
    truepose_arm, truepose_arm_free, truepose_arm_new, truepose_command, truepose_options_default,
    truepose_predict,
};
pub use fit::{
    truepose_fit, truepose_fit_channel, truepose_fit_channels, truepose_fit_free, truepose_fit_joint,
    truepose_fit_joint_is_prismatic, truepose_fit_joints, truepose_fit_parse, truepose_fit_read,
    truepose_fit_target, truepose_fit_target_name, truepose_fit_targets,
};
pub use status::{
    TRUEPOSE_ERROR_ARGUMENT, TRUEPOSE_ERROR_FIT, TRUEPOSE_ERROR_LENGTH, TRUEPOSE_ERROR_NOT_FINITE,
    TRUEPOSE_ERROR_NULL, TRUEPOSE_ERROR_ORIENTATION, TRUEPOSE_ERROR_PANIC, TRUEPOSE_ERROR_TARGET,
    TRUEPOSE_LIMIT, TRUEPOSE_NOT_CONVERGED, TRUEPOSE_OK, TRUEPOSE_UNREACHABLE, truepose_last_error,
    truepose_message,
};
pub use structs::{
    TRUEPOSE_LOAD_NONE, TRUEPOSE_LOAD_PAYLOAD, TRUEPOSE_LOAD_WRENCH, TRUEPOSE_TOOL, truepose_answer,
    truepose_conditions, truepose_options, truepose_pose, truepose_target,
};

use std::ffi::c_char;

/// Version of this interface. It grows with each change that an existing program would notice.
pub const TRUEPOSE_ABI: u32 = 1;

/// Version of the interface of the library that is loaded: has to be `TRUEPOSE_ABI` of the header.
#[unsafe(no_mangle)]
pub extern "C" fn truepose_abi() -> u32 {
    TRUEPOSE_ABI
}

/// Version of the library, e.g. `0.1.0`: a static text.
#[unsafe(no_mangle)]
pub extern "C" fn truepose_version() -> *const c_char {
    concat!(env!("CARGO_PKG_VERSION"), "\0").as_ptr().cast()
}
