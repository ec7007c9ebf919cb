//! What a program leaves open.

use truepose_kinematics::{Load, Pose};

/// Frames, tools, conditions and limits of a correction.
#[derive(Debug, Clone)]
pub struct CorrectOptions {
    /// Frames by the names of the program, in the controller's base, m.
    pub frames: Vec<(String, Pose)>,
    /// The frame of points whose own has no value in the program; several names then need one each.
    pub frame: Option<Pose>,
    /// Tools by the names of the program, in the controller's flange, m.
    pub tools: Vec<(String, Pose)>,
    /// The tool of points whose own has no value in the program.
    pub tool: Option<Pose>,
    /// Frames and tools that were taught by touching with the uncorrected robot.
    pub taught: Vec<Taught>,
    /// Names of frames and tools that were measured, or are those of a drawing: they are where the program has them.
    pub stated: Vec<String>,
    /// The controller's base in that of the robot description.
    pub controller_base: Pose,
    /// The controller's flange in the last joint's frame of the robot description.
    pub controller_flange: Pose,
    /// The controller's joint values before the program, rad or m.
    pub start: Option<Vec<f64>>,
    /// What the robot carries, whatever the program states.
    pub load: Load,
    /// The loads that the program states are taken in place of `load`, where they are clear.
    pub program_loads: bool,
    /// Channels that the model reads, with the values that they have while the program runs.
    pub channels: Vec<(String, f64)>,
    /// Largest correction, m.
    pub limit: f64,
    /// External axes of the program that are joints of the robot: name in the program, name of the joint.
    pub external: Vec<(String, String)>,
    /// Frames of the program on a positioner: name in the program, name of the fit's tool that is there. Their values are in the axes of that tool.
    pub work: Vec<(String, String)>,
    /// Other external axes move neither the robot nor what the points are on.
    pub ignore_external: bool,
    /// The axes (1 to 6) of FANUC's three turn numbers.
    pub turn_axes: Option<[usize; 3]>,
    /// Pulses of each axis per rad, or per m.
    pub pulses: Option<Vec<f64>>,
}

impl Default for CorrectOptions {
    fn default() -> Self {
        CorrectOptions {
            frames: Vec::new(),
            frame: None,
            tools: Vec::new(),
            tool: None,
            taught: Vec::new(),
            stated: Vec::new(),
            controller_base: Pose::IDENTITY,
            controller_flange: Pose::IDENTITY,
            start: None,
            load: Load::None,
            program_loads: false,
            channels: Vec::new(),
            // No arm of which measurements are published errs by more than 6 mm: more is a wrong frame, unit or load.
            limit: 0.01,
            external: Vec::new(),
            work: Vec::new(),
            ignore_external: false,
            turn_axes: None,
            pulses: None,
        }
    }
}

/// A frame or a tool that was taught by touching.
#[derive(Debug, Clone)]
pub struct Taught {
    /// Of the frame or tool, in the program.
    pub name: String,
    /// Of the tool that touched, in the program; none: the tool of the points in this frame.
    pub tool: Option<String>,
    /// The file of the points, for messages.
    pub file: String,
    /// The points, in their order.
    pub touched: Vec<Touched>,
}

/// A point that was touched.
#[derive(Debug, Clone)]
pub struct Touched {
    /// `origin`, `x`, `xy`, or ABB's `x1`, `x2`, `y1`; empty: the first three in this order. A tool's points need none.
    pub word: String,
    /// From 1, in the file.
    pub line: usize,
    /// All moving joints, variables.
    pub joints: Vec<f64>,
    /// What was carried; none: what the program carries.
    pub load: Option<Load>,
}
