/* truepose: compensation of a calibrated robot in a controller.
 *
 * Load a fit, make an arm of it for each thread, then command and predict. Lengths are m, angles rad, masses kg, forces N.
 * Made by cbindgen from crates/ffi; do not edit. */

#ifndef TRUEPOSE_H
#define TRUEPOSE_H

#include <stddef.h>
#include <stdint.h>

/*
 Version of this interface. It grows with each change that an existing program would notice.
 */
#define TRUEPOSE_ABI 1

/*
 Done.
 */
#define TRUEPOSE_OK 0

/*
 No joint values were found that reach the pose.
 */
#define TRUEPOSE_UNREACHABLE 1

/*
 Only joint values beyond their limits would reach the pose.
 */
#define TRUEPOSE_LIMIT 2

/*
 The search did not converge.
 */
#define TRUEPOSE_NOT_CONVERGED 3

/*
 A pointer that is required is null.
 */
#define TRUEPOSE_ERROR_NULL -1

/*
 A list has the wrong length.
 */
#define TRUEPOSE_ERROR_LENGTH -2

/*
 A number is not finite, or a quaternion is zero.
 */
#define TRUEPOSE_ERROR_NOT_FINITE -3

/*
 The robot has no such target, or the fit does not know where it is.
 */
#define TRUEPOSE_ERROR_TARGET -4

/*
 A value has no meaning (a kind of load, an option).
 */
#define TRUEPOSE_ERROR_ARGUMENT -5

/*
 The fit cannot be read or used; `truepose_last_error` has the reason.
 */
#define TRUEPOSE_ERROR_FIT -6

/*
 A defect of the library. The arm that was in use returns this from now on: free it.
 */
#define TRUEPOSE_ERROR_PANIC -7

/*
 An orientation is desired, and the fit does not determine that of the tool.
 */
#define TRUEPOSE_ERROR_ORIENTATION -8

/*
 The tool's origin, in place of the number of a target.
 */
#define TRUEPOSE_TOOL -1

/*
 Nothing is carried.
 */
#define TRUEPOSE_LOAD_NONE 0

/*
 A mass is carried: `payload_mass` and `payload_com`.
 */
#define TRUEPOSE_LOAD_PAYLOAD 1

/*
 The load is measured: `wrench`.
 */
#define TRUEPOSE_LOAD_WRENCH 2

/*
 Memory of one thread: no two threads may use one arm at the same time. Any number of arms may come from one fit.
 */
typedef struct truepose_arm truepose_arm;

/*
 A fit. Any number of threads may use it at once; an arm keeps what it needs, so that the fit may be freed before its arms.
 */
typedef struct truepose_fit truepose_fit;

/*
 Options of an arm; `truepose_options_default` fills in what the program uses.
 */
typedef struct truepose_options {
  /*
   Distance from the desired position at which a command is good, m.
   */
  double position_tolerance;
  /*
   Angle from the desired orientation at which a command is good, rad.
   */
  double orientation_tolerance;
  /*
   Most evaluations of the exact model from one start.
   */
  uint32_t iterations;
  /*
   Number of starts that are tried when the seed leads nowhere, or there is none.
   */
  uint32_t starts;
  /*
   Not 0: directions of approach follow from the straight move from the seed, instead of the conditions.
   */
  int32_t approach_from_seed;
  /*
   Joints that stay where the seed has them: bit k is joint k of `truepose_fit_joint`, e.g. a track. A seed is then needed.
   */
  uint32_t hold;
} truepose_options;

/*
 A desired pose, in the measurement frame.
 */
typedef struct truepose_target {
  /*
   x, y, z of the target, m.
   */
  double position[3];
  /*
   Desired orientation of the tool: w, x, y, z, of any length but zero; read where `has_orientation` is not 0.
   */
  double quaternion[4];
  /*
   0: the tool keeps the orientation that it has at the seed, as far as the robot can.
   */
  int32_t has_orientation;
  /*
   Number of the target, or `TRUEPOSE_TOOL`.
   */
  int32_t target;
} truepose_target;

/*
 Under which conditions a pose is commanded or predicted. All zeros: unloaded, at time 0, without channels.
 */
typedef struct truepose_conditions {
  /*
   `TRUEPOSE_LOAD_NONE`, `TRUEPOSE_LOAD_PAYLOAD` or `TRUEPOSE_LOAD_WRENCH`.
   */
  int32_t load;
  /*
   Mass carried, kg.
   */
  double payload_mass;
  /*
   Its centre of gravity in the tool frame, m.
   */
  double payload_com[3];
  /*
   Force (N) and moment (N·m) that the load exerts at the tool's origin, in the tool's axes.
   */
  double wrench[6];
  /*
   Time, s; read by models with drift.
   */
  double time;
  /*
   Direction in which each joint arrives, −1, 0 or +1: one for each joint; null for all 0. Read by models with backlash.
   */
  const double *approach;
  /*
   Length of `approach`; 0 where it is null.
   */
  size_t approach_count;
  /*
   One value for each channel of the fit, in the order of `truepose_fit_channel`.
   */
  const double *channels;
  /*
   Length of `channels`.
   */
  size_t channel_count;
} truepose_conditions;

/*
 What is known about a command.
 */
typedef struct truepose_answer {
  /*
   Distance of the real robot's target from the desired position by the exact model, m.
   */
  double position_error;
  /*
   Angle of its tool from the desired orientation, rad; 0 where none was requested.
   */
  double orientation_error;
  /*
   Not 0: some input lies beyond the range of the data of the fit.
   */
  int32_t extrapolates;
  /*
   0: a straight move from the seed arrives from another side than the one for which the command was computed (backlash).
   */
  int32_t approach_holds;
} truepose_answer;

/*
 Position of a target and orientation of the tool, in the measurement frame.
 */
typedef struct truepose_pose {
  /*
   x, y, z of the target, m.
   */
  double position[3];
  /*
   Orientation of the tool: w, x, y, z.
   */
  double quaternion[4];
} truepose_pose;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Version of the interface of the library that is loaded: has to be `TRUEPOSE_ABI` of the header.
 */
uint32_t truepose_abi(void);

/*
 Version of the library, e.g. `0.1.0`: a static text.
 */
const char *truepose_version(void);

/*
 Fills in the options that the program uses.

 # Safety
 `options` is null or may be written.
 */
int32_t truepose_options_default(struct truepose_options *options);

/*
 Makes an arm of a fit, into `*arm`; `options` may be null. On an error `*arm` is null, and `truepose_last_error` has the reason.

 # Safety
 `fit` is null or comes from this library and has not been freed; `options` is null or may be read; `arm` is null or may be written.
 */
int32_t truepose_arm_new(const struct truepose_fit *fit,
                         const struct truepose_options *options,
                         struct truepose_arm **arm);

/*
 Frees an arm; nothing happens for null.

 # Safety
 `arm` is null, or comes from this library and has not been freed.
 */
void truepose_arm_free(struct truepose_arm *arm);

/*
 The joint values (rad or m, as the controller has them) that bring the real robot to a desired pose, into `joints`. They are written only
 where the result is `TRUEPOSE_OK`; `answer` (may be null) is written for every result that is not negative. `seed` has the joint values at
 which the search begins, or is null. Allocates nothing.

 # Safety
 Pointers are null, or lead to what their types and counts state; `joints` and `answer` may be written. No other thread uses `arm`.
 */
int32_t truepose_command(struct truepose_arm *arm,
                         const struct truepose_target *desired,
                         const struct truepose_conditions *conditions,
                         const double *seed,
                         double *joints,
                         size_t joint_count,
                         struct truepose_answer *answer);

/*
 Where a target of the real robot is under these joint values and conditions, and how the tool is turned, into `*pose`. Allocates nothing.

 # Safety
 Pointers are null, or lead to what their types and counts state; `pose` may be written. No other thread uses `arm`.
 */
int32_t truepose_predict(struct truepose_arm *arm,
                         const double *joints,
                         size_t joint_count,
                         const struct truepose_conditions *conditions,
                         int32_t target,
                         struct truepose_pose *pose);

/*
 Loads a fit from a file, as `truepose identify` or `discover` writes it, into `*fit`. On an error `*fit` is null, and
 `truepose_last_error` has the reason.

 # Safety
 `path` is null or ends in a zero byte; `fit` is null or may be written.
 */
int32_t truepose_fit_read(const char *path,
                          struct truepose_fit **fit);

/*
 Loads a fit from the contents of its file in memory, `length` bytes of JSON.

 # Safety
 `json` is null or leads to `length` bytes; `fit` is null or may be written.
 */
int32_t truepose_fit_parse(const char *json, size_t length, struct truepose_fit **fit);

/*
 Frees a fit; nothing happens for null. Arms made from it stay usable.

 # Safety
 `fit` is null, or comes from this library and has not been freed.
 */
void truepose_fit_free(struct truepose_fit *fit);

/*
 Number of movable joints; 0 for null.

 # Safety
 `fit` is null, or comes from this library and has not been freed.
 */
size_t truepose_fit_joints(const struct truepose_fit *fit);

/*
 Name of a movable joint, from 0; null where there is none. Valid as long as the fit.

 # Safety
 As `truepose_fit_joints`.
 */
const char *truepose_fit_joint(const struct truepose_fit *fit, size_t k);

/*
 1 where the values of a joint are m, 0 where they are rad, −1 where there is no such joint.

 # Safety
 As `truepose_fit_joints`.
 */
int32_t truepose_fit_joint_is_prismatic(const struct truepose_fit *fit, size_t k);

/*
 Number of channels that the model reads; 0 for null.

 # Safety
 As `truepose_fit_joints`.
 */
size_t truepose_fit_channels(const struct truepose_fit *fit);

/*
 Name of a channel that the model reads, from 0, in the order of the conditions; null where there is none. Valid as long as the fit.

 # Safety
 As `truepose_fit_joints`.
 */
const char *truepose_fit_channel(const struct truepose_fit *fit,
                                 size_t k);

/*
 Number of declared targets; 0 for null.

 # Safety
 As `truepose_fit_joints`.
 */
size_t truepose_fit_targets(const struct truepose_fit *fit);

/*
 Name of a target, from 0; null where there is none. Valid as long as the fit.

 # Safety
 As `truepose_fit_joints`.
 */
const char *truepose_fit_target_name(const struct truepose_fit *fit, size_t k);

/*
 Number of the target of this name into `*target`.

 # Safety
 `fit` as in `truepose_fit_joints`; `name` is null or ends in a zero byte; `target` is null or may be written.
 */
int32_t truepose_fit_target(const struct truepose_fit *fit,
                            const char *name,
                            int32_t *target);

/*
 Number of sessions (installations) of the fit, from which one has to be chosen; 0 where it has one installation, and for null.

 # Safety
 As `truepose_fit_joints`.
 */
size_t truepose_fit_sessions(const struct truepose_fit *fit);

/*
 Name of a session, from 0; null where there is none. Valid as long as the fit.

 # Safety
 As `truepose_fit_joints`.
 */
const char *truepose_fit_session(const struct truepose_fit *fit, size_t k);

/*
 The fit in one of its sessions, as a fit of its own, into `*chosen`: arms are made of it. On an error `*chosen` is null.

 # Safety
 `fit` as in `truepose_fit_joints`; `name` is null or ends in a zero byte; `chosen` is null or may be written.
 */
int32_t truepose_fit_in_session(const struct truepose_fit *fit,
                                const char *name,
                                struct truepose_fit **chosen);

/*
 What a code means, in one line: a static text, never null.
 */
const char *truepose_message(int32_t code);

/*
 Why the last fit was refused by this thread (file, line and column where there are any); empty when none was. Valid until the next call
 of this thread that loads a fit or makes an arm.
 */
const char *truepose_last_error(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* TRUEPOSE_H */
