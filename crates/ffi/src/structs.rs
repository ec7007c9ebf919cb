//! The structures of the header. SI units: m, rad, kg, N, N·m, s.

/// The tool's origin, in place of the number of a target.
pub const TRUEPOSE_TOOL: i32 = -1;

/// Nothing is carried.
pub const TRUEPOSE_LOAD_NONE: i32 = 0;
/// A mass is carried: `payload_mass` and `payload_com`.
pub const TRUEPOSE_LOAD_PAYLOAD: i32 = 1;
/// The load is measured: `wrench`.
pub const TRUEPOSE_LOAD_WRENCH: i32 = 2;

/// Position of a target and orientation of the tool, in the measurement frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct truepose_pose {
    /// x, y, z of the target, m.
    pub position: [f64; 3],
    /// Orientation of the tool: w, x, y, z.
    pub quaternion: [f64; 4],
}

/// A desired pose, in the measurement frame.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct truepose_target {
    /// x, y, z of the target, m.
    pub position: [f64; 3],
    /// Desired orientation of the tool: w, x, y, z, of any length but zero; read where `has_orientation` is not 0.
    pub quaternion: [f64; 4],
    /// 0: the tool keeps the orientation that it has at the seed, as far as the robot can.
    pub has_orientation: i32,
    /// Number of the target, or `TRUEPOSE_TOOL`.
    pub target: i32,
}

/// Under which conditions a pose is commanded or predicted. All zeros: unloaded, at time 0, without channels.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct truepose_conditions {
    /// `TRUEPOSE_LOAD_NONE`, `TRUEPOSE_LOAD_PAYLOAD` or `TRUEPOSE_LOAD_WRENCH`.
    pub load: i32,
    /// Mass carried, kg.
    pub payload_mass: f64,
    /// Its centre of gravity in the tool frame, m.
    pub payload_com: [f64; 3],
    /// Force (N) and moment (N·m) that the load exerts at the tool's origin, in the tool's axes.
    pub wrench: [f64; 6],
    /// Time, s; read by models with drift.
    pub time: f64,
    /// Direction in which each joint arrives, −1, 0 or +1: one for each joint; null for all 0. Read by models with backlash.
    pub approach: *const f64,
    /// Length of `approach`; 0 where it is null.
    pub approach_count: usize,
    /// One value for each channel of the fit, in the order of `truepose_fit_channel`.
    pub channels: *const f64,
    /// Length of `channels`.
    pub channel_count: usize,
}

/// Options of an arm; `truepose_options_default` fills in what the program uses.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct truepose_options {
    /// Distance from the desired position at which a command is good, m.
    pub position_tolerance: f64,
    /// Angle from the desired orientation at which a command is good, rad.
    pub orientation_tolerance: f64,
    /// Most evaluations of the exact model from one start.
    pub iterations: u32,
    /// Number of starts that are tried when the seed leads nowhere, or there is none.
    pub starts: u32,
    /// Not 0: directions of approach follow from the straight move from the seed, instead of the conditions.
    pub approach_from_seed: i32,
    /// Joints that stay where the seed has them: bit k is joint k of `truepose_fit_joint`, e.g. a track. A seed is then needed.
    pub hold: u32,
}

/// What is known about a command.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct truepose_answer {
    /// Distance of the real robot's target from the desired position by the exact model, m.
    pub position_error: f64,
    /// Angle of its tool from the desired orientation, rad; 0 where none was requested.
    pub orientation_error: f64,
    /// Not 0: some input lies beyond the range of the data of the fit.
    pub extrapolates: i32,
    /// 0: a straight move from the seed arrives from another side than the one for which the command was computed (backlash).
    pub approach_holds: i32,
}
