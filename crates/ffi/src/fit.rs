//! A fit in memory: loaded once, then shared by all threads and never changed.

use crate::border::{given, guarded, taken};
use crate::status::{
    TRUEPOSE_ERROR_ARGUMENT, TRUEPOSE_ERROR_FIT, TRUEPOSE_ERROR_NULL, TRUEPOSE_ERROR_TARGET, TRUEPOSE_OK,
    because,
};
use std::ffi::{CStr, CString, c_char};
use std::sync::Arc;
use truepose_errormodel::{Channel, EffectRegistry, FittedModel, Schema, Signal, TargetKnown};
use truepose_io::{IoError, fit_from_text, read_fit};
use truepose_kinematics::TargetId;

/// A fit. Any number of threads may use it at once; an arm keeps what it needs, so that the fit may be freed before its arms.
pub struct truepose_fit {
    pub(crate) shared: Arc<Shared>,
}

/// What arms share.
pub(crate) struct Shared {
    pub fitted: FittedModel,
    /// The channels that the model reads, and every other signal.
    pub schema: Schema,
    joints: Vec<CString>,
    channels: Vec<CString>,
    targets: Vec<CString>,
    /// Whether the place of each target is known, and of the tool's origin.
    known: (Vec<bool>, bool),
    /// Whether the orientation of the tool is known.
    pub oriented: bool,
}

impl Shared {
    fn new(fitted: FittedModel) -> Self {
        // Errors of instrument and log are none of the robot.
        let fitted = fitted.of_robot();
        let mut channels: Vec<Channel> = Vec::new();
        for need in fitted.model().effects().iter().flat_map(|effect| effect.needs()) {
            if let Signal::Channel(name) = need
                && !channels.iter().any(|channel| channel.name == name)
            {
                let at_fit = fitted.channels.iter().find(|channel| channel.name == name).cloned();
                channels.push(at_fit.unwrap_or(Channel { name, unit: "1".into(), temperature: false }));
            }
        }
        let chain = fitted.chain();
        let text = |name: &str| CString::new(name.replace('\0', " ")).unwrap_or_default();
        let joints = chain.movable().iter().map(|&joint| text(&chain.joint(joint).name)).collect();
        let targets = chain.targets().iter().map(|target| text(&target.name)).collect();
        let names = channels.iter().map(|channel| text(&channel.name)).collect();
        let schema = Schema { channels, time: true, load: true, approach: true };
        let known = |target| fitted.target_known(target) != TargetKnown::Undetermined;
        let each = (0..chain.targets().len()).map(|k| known(Some(TargetId(k)))).collect();
        let (known, oriented) =
            ((each, known(None)), fitted.orientation_known() != TargetKnown::Undetermined);
        Shared { schema, joints, channels: names, targets, known, oriented, fitted }
    }

    /// The target of a number, if the fit knows where it is.
    pub fn target(&self, number: i32) -> Result<Option<TargetId>, i32> {
        let (target, known) = match usize::try_from(number) {
            Ok(k) => (Some(TargetId(k)), self.known.0.get(k).copied()),
            Err(_) if number == crate::TRUEPOSE_TOOL => (None, Some(self.known.1)),
            Err(_) => (None, None),
        };
        if known == Some(true) { Ok(target) } else { Err(TRUEPOSE_ERROR_TARGET) }
    }
}

/// Hands a fit over, or records why there is none.
fn hand_over(read: Result<FittedModel, IoError>, out: &mut *mut truepose_fit) -> Result<i32, i32> {
    match read {
        Ok(fitted) => {
            let shared = Arc::new(Shared::new(fitted));
            *out = Box::into_raw(Box::new(truepose_fit { shared }));
            Ok(TRUEPOSE_OK)
        }
        Err(error) => {
            because(&error.to_string());
            Err(TRUEPOSE_ERROR_FIT)
        }
    }
}

/// Loads a fit from a file, as `truepose identify` or `discover` writes it, into `*fit`. On an error `*fit` is null, and
/// `truepose_last_error` has the reason.
///
/// # Safety
/// `path` is null or ends in a zero byte; `fit` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_fit_read(path: *const c_char, fit: *mut *mut truepose_fit) -> i32 {
    guarded(|| {
        // SAFETY: the caller's promise.
        let out = unsafe { taken(fit) }?;
        *out = std::ptr::null_mut();
        if path.is_null() {
            return Err(TRUEPOSE_ERROR_NULL);
        }
        // SAFETY: not null, and ends in a zero byte by the caller's promise.
        let path = unsafe { CStr::from_ptr(path) };
        let Ok(path) = path.to_str() else {
            because("the path is not UTF-8");
            return Err(TRUEPOSE_ERROR_ARGUMENT);
        };
        hand_over(read_fit(path, &EffectRegistry::builtin()), out)
    })
}

/// Loads a fit from the contents of its file in memory, `length` bytes of JSON.
///
/// # Safety
/// `json` is null or leads to `length` bytes; `fit` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_fit_parse(
    json: *const c_char,
    length: usize,
    fit: *mut *mut truepose_fit,
) -> i32 {
    guarded(|| {
        // SAFETY: the caller's promise.
        let out = unsafe { taken(fit) }?;
        *out = std::ptr::null_mut();
        if json.is_null() {
            return Err(TRUEPOSE_ERROR_NULL);
        }
        if isize::try_from(length).is_err() {
            return Err(TRUEPOSE_ERROR_ARGUMENT);
        }
        // SAFETY: not null, and `length` bytes by the caller's promise; no longer than a slice may be.
        let bytes = unsafe { std::slice::from_raw_parts(json.cast::<u8>(), length) };
        let Ok(text) = std::str::from_utf8(bytes) else {
            because("the fit is not UTF-8");
            return Err(TRUEPOSE_ERROR_FIT);
        };
        hand_over(fit_from_text("fit", text, &EffectRegistry::builtin()), out)
    })
}

/// Frees a fit; nothing happens for null. Arms made from it stay usable.
///
/// # Safety
/// `fit` is null, or comes from this library and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_fit_free(fit: *mut truepose_fit) {
    if !fit.is_null() {
        guarded(|| {
            // SAFETY: made by `Box::into_raw`, and freed once, by the caller's promise.
            drop(unsafe { Box::from_raw(fit) });
            Ok(TRUEPOSE_OK)
        });
    }
}

/// A count of a fit; 0 for null.
unsafe fn count(fit: *const truepose_fit, of: impl FnOnce(&Shared) -> usize) -> usize {
    // SAFETY: the promise of the callers.
    unsafe { fit.as_ref() }.map_or(0, |fit| of(&fit.shared))
}

/// A name of a fit; null where there is none.
unsafe fn name(fit: *const truepose_fit, k: usize, of: impl FnOnce(&Shared) -> &[CString]) -> *const c_char {
    // SAFETY: the promise of the callers.
    let names = unsafe { fit.as_ref() }.map(|fit| of(&fit.shared));
    names.and_then(|names| names.get(k)).map_or(std::ptr::null(), |name| name.as_ptr())
}

/// Number of movable joints; 0 for null.
///
/// # Safety
/// `fit` is null, or comes from this library and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_fit_joints(fit: *const truepose_fit) -> usize {
    // SAFETY: the caller's promise.
    unsafe { count(fit, |shared| shared.joints.len()) }
}

/// Name of a movable joint, from 0; null where there is none. Valid as long as the fit.
///
/// # Safety
/// As `truepose_fit_joints`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_fit_joint(fit: *const truepose_fit, k: usize) -> *const c_char {
    // SAFETY: the caller's promise.
    unsafe { name(fit, k, |shared| &shared.joints) }
}

/// 1 where the values of a joint are m, 0 where they are rad, −1 where there is no such joint.
///
/// # Safety
/// As `truepose_fit_joints`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_fit_joint_is_prismatic(fit: *const truepose_fit, k: usize) -> i32 {
    // SAFETY: the caller's promise.
    let Some(fit) = (unsafe { fit.as_ref() }) else { return -1 };
    let chain = fit.shared.fitted.chain();
    chain.movable().get(k).map_or(-1, |&joint| i32::from(chain.joint(joint).unit() == "m"))
}

/// Number of channels that the model reads; 0 for null.
///
/// # Safety
/// As `truepose_fit_joints`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_fit_channels(fit: *const truepose_fit) -> usize {
    // SAFETY: the caller's promise.
    unsafe { count(fit, |shared| shared.channels.len()) }
}

/// Name of a channel that the model reads, from 0, in the order of the conditions; null where there is none. Valid as long as the fit.
///
/// # Safety
/// As `truepose_fit_joints`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_fit_channel(fit: *const truepose_fit, k: usize) -> *const c_char {
    // SAFETY: the caller's promise.
    unsafe { name(fit, k, |shared| &shared.channels) }
}

/// Number of declared targets; 0 for null.
///
/// # Safety
/// As `truepose_fit_joints`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_fit_targets(fit: *const truepose_fit) -> usize {
    // SAFETY: the caller's promise.
    unsafe { count(fit, |shared| shared.targets.len()) }
}

/// Name of a target, from 0; null where there is none. Valid as long as the fit.
///
/// # Safety
/// As `truepose_fit_joints`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_fit_target_name(fit: *const truepose_fit, k: usize) -> *const c_char {
    // SAFETY: the caller's promise.
    unsafe { name(fit, k, |shared| &shared.targets) }
}

/// Number of the target of this name into `*target`.
///
/// # Safety
/// `fit` as in `truepose_fit_joints`; `name` is null or ends in a zero byte; `target` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_fit_target(
    fit: *const truepose_fit,
    name: *const c_char,
    target: *mut i32,
) -> i32 {
    guarded(|| {
        // SAFETY: the caller's promise.
        let (fit, out) = unsafe { (given(fit)?, taken(target)?) };
        if name.is_null() {
            return Err(TRUEPOSE_ERROR_NULL);
        }
        // SAFETY: not null, and ends in a zero byte by the caller's promise.
        let name = unsafe { CStr::from_ptr(name) };
        let found = fit.shared.targets.iter().position(|known| known.as_c_str() == name);
        *out = found.and_then(|k| i32::try_from(k).ok()).ok_or(TRUEPOSE_ERROR_TARGET)?;
        Ok(TRUEPOSE_OK)
    })
}
