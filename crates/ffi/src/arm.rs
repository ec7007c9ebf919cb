//! An arm: the memory in which one thread computes commands and predictions.

use crate::border::{given, guarded, numbers, taken};
use crate::conditions::enter;
use crate::fit::{Shared, truepose_fit};
use crate::status::{
    TRUEPOSE_ERROR_ARGUMENT, TRUEPOSE_ERROR_FIT, TRUEPOSE_ERROR_LENGTH, TRUEPOSE_ERROR_NOT_FINITE,
    TRUEPOSE_ERROR_NULL, TRUEPOSE_ERROR_ORIENTATION, TRUEPOSE_ERROR_PANIC, TRUEPOSE_OK, because, code,
};
use crate::structs::{
    truepose_answer, truepose_conditions, truepose_options, truepose_pose, truepose_target,
};
use nalgebra::Vector3;
use std::sync::Arc;
use truepose_compensate::{Approach, CompensateError, Compensator, CompensatorOptions, Status, Target};
use truepose_errormodel::FittedModel;
use truepose_kinematics::{Conditions, Pose};

/// Memory of one thread: no two threads may use one arm at the same time. Any number of arms may come from one fit.
pub struct truepose_arm {
    // Borrows from `shared`, and stands before it: fields are dropped in their order.
    compensator: Compensator<'static>,
    conditions: Conditions,
    seed: Vec<f64>,
    /// A call has panicked: what it left is not to be used.
    broken: bool,
    shared: Arc<Shared>,
}

impl truepose_arm {
    fn new(shared: &Arc<Shared>, options: CompensatorOptions) -> Result<Self, CompensateError> {
        let shared = Arc::clone(shared);
        // SAFETY: the fit stands in the allocation of an `Arc`, which does not move it. It is shared and never written, and lives as long
        // as `shared` beside the compensator, which is dropped before it. The reference leaves neither this struct nor a call.
        let fitted: &'static FittedModel = unsafe { &*std::ptr::from_ref(&shared.fitted) };
        let compensator = Compensator::bind(fitted, &shared.schema, options)?;
        let joints = fitted.chain().movable().len();
        let conditions = Conditions {
            joints: vec![0.0; joints],
            approach: vec![0.0; joints],
            channels: vec![0.0; shared.schema.channels.len()],
            ..Conditions::default()
        };
        Ok(truepose_arm { compensator, conditions, seed: vec![0.0; joints], broken: false, shared })
    }

    /// A call that computes: refused after a panic of an earlier one, and by a panic of its own.
    fn computed(&mut self, call: impl FnOnce(&mut Self) -> Result<i32, i32>) -> Result<i32, i32> {
        if self.broken {
            return Err(TRUEPOSE_ERROR_PANIC);
        }
        self.broken = true;
        let code = call(self);
        self.broken = false;
        code
    }
}

/// Fills in the options that the program uses.
///
/// # Safety
/// `options` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_options_default(options: *mut truepose_options) -> i32 {
    guarded(|| {
        // SAFETY: the caller's promise.
        let out = unsafe { taken(options) }?;
        let usual = CompensatorOptions::default();
        *out = truepose_options {
            position_tolerance: usual.position_tolerance,
            orientation_tolerance: usual.orientation_tolerance,
            iterations: usual.rounds as u32,
            starts: usual.starts as u32,
            approach_from_seed: 0,
            hold: 0,
        };
        Ok(TRUEPOSE_OK)
    })
}

/// Makes an arm of a fit, into `*arm`; `options` may be null. On an error `*arm` is null, and `truepose_last_error` has the reason.
///
/// # Safety
/// `fit` is null or comes from this library and has not been freed; `options` is null or may be read; `arm` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_arm_new(
    fit: *const truepose_fit,
    options: *const truepose_options,
    arm: *mut *mut truepose_arm,
) -> i32 {
    guarded(|| {
        // SAFETY: the caller's promise.
        let out = unsafe { taken(arm) }?;
        *out = std::ptr::null_mut();
        // SAFETY: the caller's promise.
        let (fit, options) = unsafe { (given(fit)?, options.as_ref()) };
        if fit.is_open() {
            because("the fit has several sessions: choose one with truepose_fit_in_session");
            return Err(TRUEPOSE_ERROR_FIT);
        }
        let options = options.map_or_else(CompensatorOptions::default, |given| CompensatorOptions {
            position_tolerance: given.position_tolerance,
            orientation_tolerance: given.orientation_tolerance,
            rounds: given.iterations as usize,
            starts: given.starts as usize,
            approach: if given.approach_from_seed == 0 { Approach::Stated } else { Approach::FromSeed },
            hold: (0..u32::BITS as usize).filter(|k| given.hold >> k & 1 == 1).collect(),
            ..CompensatorOptions::default()
        });
        match truepose_arm::new(&fit.shared, options) {
            Ok(made) => {
                *out = Box::into_raw(Box::new(made));
                Ok(TRUEPOSE_OK)
            }
            Err(error) => {
                because(&error.to_string());
                let option = matches!(error, CompensateError::Option { .. });
                Err(if option { TRUEPOSE_ERROR_ARGUMENT } else { TRUEPOSE_ERROR_FIT })
            }
        }
    })
}

/// Frees an arm; nothing happens for null.
///
/// # Safety
/// `arm` is null, or comes from this library and has not been freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_arm_free(arm: *mut truepose_arm) {
    if !arm.is_null() {
        guarded(|| {
            // SAFETY: made by `Box::into_raw`, and freed once, by the caller's promise.
            drop(unsafe { Box::from_raw(arm) });
            Ok(TRUEPOSE_OK)
        });
    }
}

/// The joint values (rad or m, as the controller has them) that bring the real robot to a desired pose, into `joints`. They are written only
/// where the result is `TRUEPOSE_OK`; `answer` (may be null) is written for every result that is not negative. `seed` has the joint values at
/// which the search begins, or is null. Allocates nothing.
///
/// # Safety
/// Pointers are null, or lead to what their types and counts state; `joints` and `answer` may be written. No other thread uses `arm`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_command(
    arm: *mut truepose_arm,
    desired: *const truepose_target,
    conditions: *const truepose_conditions,
    seed: *const f64,
    joints: *mut f64,
    joint_count: usize,
    answer: *mut truepose_answer,
) -> i32 {
    guarded(|| {
        // SAFETY: the caller's promise.
        let (arm, desired, conditions) = unsafe { (taken(arm)?, given(desired)?, conditions.as_ref()) };
        let n = arm.seed.len();
        if joint_count != n {
            return Err(TRUEPOSE_ERROR_LENGTH);
        }
        if joints.is_null() {
            return Err(TRUEPOSE_ERROR_NULL);
        }
        arm.computed(|arm| {
            let chain = arm.shared.fitted.chain();
            // SAFETY: the caller's promise; copied before `joints`, which may be the same memory, is written.
            let seeded = (!seed.is_null()).then(|| unsafe { numbers(seed, joint_count, n) }).transpose()?;
            if let Some(seed) = seeded {
                if !seed.iter().all(|q| q.is_finite()) {
                    return Err(TRUEPOSE_ERROR_NOT_FINITE);
                }
                arm.seed.copy_from_slice(seed);
                chain.joints_from_controller(&mut arm.seed);
            }
            // SAFETY: the caller's promise about the lists of the conditions.
            unsafe { enter(conditions, &mut arm.conditions) }?;
            let wanted = wanted(desired, &arm.shared)?;
            let start = seeded.is_some().then_some(&arm.seed[..]);
            let command = arm.compensator.command(&wanted, &arm.conditions, start);
            // SAFETY: null, or may be written, by the caller's promise.
            if let Some(out) = unsafe { answer.as_mut() } {
                *out = truepose_answer {
                    position_error: command.position_error,
                    orientation_error: command.orientation_error,
                    extrapolates: i32::from(command.extrapolation.any()),
                    approach_holds: i32::from(command.approach_holds),
                };
            }
            if command.status == Status::Ok {
                let mut values = command.joints;
                chain.joints_to_controller(&mut values);
                // SAFETY: not null, and `n` numbers by the caller's promise; the slice of the seed is no longer used.
                unsafe { std::slice::from_raw_parts_mut(joints, n) }.copy_from_slice(&values);
            }
            Ok(code(command.status))
        })
    })
}

/// Where a target of the real robot is under these joint values and conditions, and how the tool is turned, into `*pose`. Allocates nothing.
///
/// # Safety
/// Pointers are null, or lead to what their types and counts state; `pose` may be written. No other thread uses `arm`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn truepose_predict(
    arm: *mut truepose_arm,
    joints: *const f64,
    joint_count: usize,
    conditions: *const truepose_conditions,
    target: i32,
    pose: *mut truepose_pose,
) -> i32 {
    guarded(|| {
        // SAFETY: the caller's promise.
        let (arm, conditions, out) = unsafe { (taken(arm)?, conditions.as_ref(), taken(pose)?) };
        arm.computed(|arm| {
            // SAFETY: the caller's promise.
            let joints = unsafe { numbers(joints, joint_count, arm.seed.len()) }?;
            // SAFETY: the caller's promise about the lists of the conditions.
            unsafe { enter(conditions, &mut arm.conditions) }?;
            arm.conditions.joints.copy_from_slice(joints);
            arm.shared.fitted.chain().joints_from_controller(&mut arm.conditions.joints);
            let target = arm.shared.target(target)?;
            let found = arm.compensator.predict(&arm.conditions, target).ok_or(TRUEPOSE_ERROR_NOT_FINITE)?;
            *out = truepose_pose { position: found.translation.into(), quaternion: found.quaternion() };
            Ok(TRUEPOSE_OK)
        })
    })
}

/// The desired pose of the caller.
fn wanted(desired: &truepose_target, shared: &Shared) -> Result<Target, i32> {
    if !desired.position.iter().all(|v| v.is_finite()) {
        return Err(TRUEPOSE_ERROR_NOT_FINITE);
    }
    let target = Target::at(Vector3::from(desired.position)).of(shared.target(desired.target)?);
    if desired.has_orientation == 0 {
        return Ok(target);
    }
    if !shared.oriented {
        return Err(TRUEPOSE_ERROR_ORIENTATION);
    }
    let length = desired.quaternion.iter().map(|v| v * v).sum::<f64>();
    if !(length.is_finite() && length > 0.0) {
        return Err(TRUEPOSE_ERROR_NOT_FINITE);
    }
    Ok(target.turned(Pose::rotation_from_quaternion(desired.quaternion)))
}
