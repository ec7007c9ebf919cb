//! Options of `truepose compensate --program`.

use super::files::{Input, TaughtFrom};
use super::values::{parse_length, parse_position};
use truepose_controllers::Dialect;
use truepose_kinematics::Pose;
use truepose_workflow::program::{self, ProgramRequest};
use truepose_workflow::{GivenPlace, Place};

/// A robot program, and what it leaves open.
#[derive(Debug, Default, clap::Args)]
pub struct RobotProgram {
    /// Robot program whose points are replaced by compensated ones, instead of poses: KUKA .src .dat, ABB .mod, FANUC .ls, Universal Robots
    /// .script, Yaskawa .jbi, Stäubli .dtx. A folder is a controller's backup: all its programs, with its frames, tools and loads, are
    /// written into the folder --out
    #[arg(long, value_name = "FILE", conflicts_with_all = ["poses", "joints", "cartesian"])]
    pub program: Option<Input>,
    /// Further file of the program with motions, declarations or frames; repeat the option for each. Its points are compensated, too, and
    /// written beside --out
    #[arg(long, value_name = "FILE", requires = "program")]
    pub with: Vec<Input>,
    /// Language of the program: krl, rapid, fanuc, urscript, inform, val3 [default: by the ending of its name]
    #[arg(long, value_name = "LANGUAGE", value_parser = parse_language, requires = "program")]
    pub language: Option<Dialect>,
    /// Frame or tool of the program that was taught by touching with the uncorrected robot, and the joints at which it was touched, e.g.
    /// UF1=points.csv (one row a point: origin, x, xy), UF1=points.csv,UT9 (touched with UT9), UT1=tip.csv (one tip, four postures)
    #[arg(long, value_name = "NAME=FILE[,TOOL]", value_parser = parse_taught, requires = "program")]
    pub taught: Vec<TaughtFrom>,
    /// Frame or tool of the program that was measured, e.g. with a laser tracker: it is where the program has it; repeat for each
    #[arg(long, value_name = "NAME", requires = "program")]
    pub measured: Vec<String>,
    /// Frame or tool of the program that is that of a drawing in the robot's base; repeat for each
    #[arg(long, value_name = "NAME", requires = "program")]
    pub cad: Vec<String>,
    /// Largest correction of a point of the program, mm
    #[arg(long, value_name = "MM", default_value = "10", value_parser = parse_limit, requires = "program", allow_hyphen_values = true)]
    pub limit: f64,
    /// Leave points unchanged that cannot be compensated, and mark them in the table, instead of rejecting the program
    #[arg(long, requires = "program")]
    pub mark: bool,
    /// Point that stays as it is, with or without a value in the files given, e.g. HOME; repeat for each
    #[arg(long, value_name = "NAME", requires = "program")]
    pub leave: Vec<String>,
    /// Write the program as it is, and the table of corrections
    #[arg(long, requires = "program")]
    pub dry_run: bool,
    /// Write the corrections as other values of frames (of tools, where points are in the base), where a program must not be changed: --out
    /// is a table with one row for each, OUT.points.csv has what remains at each point; no program is written. Of a folder the values that are best for the points of all its programs
    #[arg(long, requires = "program", conflicts_with = "dry_run")]
    pub offsets: bool,
    /// The controller's base in that of the robot description: x,y,z,roll,pitch,yaw, e.g. 0mm,0mm,450mm,0,0,0 [default: the same]
    #[arg(long, value_name = "FRAME", value_parser = parse_pose, requires = "program", allow_hyphen_values = true)]
    pub controller_base: Option<Pose>,
    /// The controller's flange in the last joint's frame of the robot description [default: the same]
    #[arg(long, value_name = "FRAME", value_parser = parse_pose, requires = "program", allow_hyphen_values = true)]
    pub controller_flange: Option<Pose>,
    /// Joint values before the program, degrees or mm, e.g. 0,-90,90,0,45,0: the start of poses without configuration data
    #[arg(
        long,
        value_name = "J1,J2,…",
        value_delimiter = ',',
        requires = "program",
        allow_negative_numbers = true,
        allow_hyphen_values = true
    )]
    pub start: Vec<f64>,
    /// Mass carried while the program runs, kg [default: what the program states, where the fit has loads]
    #[arg(long, value_name = "KG", requires = "program", allow_negative_numbers = true)]
    pub payload: Option<f64>,
    /// Its centre of gravity in the frame of the measurements' tool, e.g. 0mm,0mm,80mm
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_position, requires = "payload", allow_hyphen_values = true)]
    pub com: Option<[f64; 3]>,
    /// Value of a channel that the model reads while the program runs, in the unit of the fit, e.g. temperature=24; repeat for each
    #[arg(long, value_name = "NAME=VALUE", value_parser = parse_channel, requires = "program")]
    pub channel: Vec<(String, f64)>,
    /// External axis of the program that is a joint of the fit, e.g. E1=track: it stays where the program has it; repeat for each
    #[arg(long, value_name = "AXIS=JOINT", value_parser = parse_external, requires = "program")]
    pub external: Vec<(String, String)>,
    /// Frame of the program on a positioner, and the tool of the fit that is there, e.g. W1=table: its value is in the axes of that tool; repeat for each
    #[arg(long, value_name = "NAME=TOOL", value_parser = parse_work, requires = "program")]
    pub work: Vec<(String, String)>,
    /// External axes of the program that are no joints move neither the robot nor the work: their values are ignored
    #[arg(long, requires = "program")]
    pub ignore_external: bool,
    /// Axes of FANUC's three turn numbers, e.g. 1,4,6
    #[arg(long, value_name = "A,B,C", value_delimiter = ',', requires = "program")]
    pub turn_axes: Vec<usize>,
    /// Pulses per degree (per mm) of each axis, for INFORM
    #[arg(
        long,
        value_name = "P1,P2,…",
        value_delimiter = ',',
        requires = "program",
        allow_negative_numbers = true,
        allow_hyphen_values = true
    )]
    pub pulses: Vec<f64>,
}

impl RobotProgram {
    /// What is asked, with frames and tools, and a file of frames, which poses have as well.
    pub fn request(&self, [frames, tools]: [&[GivenPlace]; 2], file: Option<&Input>) -> ProgramRequest {
        let taught = |taught: &TaughtFrom| program::TaughtFrom {
            name: taught.name.clone(),
            file: taught.file.to_path_buf(),
            tool: taught.tool.clone(),
        };
        ProgramRequest {
            with: self.with.iter().map(|file| file.to_path_buf()).collect(),
            language: self.language,
            frames: frames.to_vec(),
            tools: tools.to_vec(),
            frames_file: file.map(|file| file.to_path_buf()),
            taught: self.taught.iter().map(taught).collect(),
            measured: self.measured.clone(),
            cad: self.cad.clone(),
            limit: self.limit,
            mark: self.mark,
            leave: self.leave.clone(),
            dry_run: self.dry_run,
            offsets: self.offsets,
            controller_base: self.controller_base,
            controller_flange: self.controller_flange,
            start: self.start.clone(),
            payload: self.payload.map(|mass| (mass, self.com.unwrap_or_default())),
            channels: self.channel.clone(),
            external: self.external.clone(),
            work: self.work.clone(),
            ignore_external: self.ignore_external,
            turn_axes: self.turn_axes.clone(),
            pulses: self.pulses.clone(),
        }
    }
}

/// `UF1=points.csv`, `UF1=points.csv,UT9`.
fn parse_taught(text: &str) -> Result<TaughtFrom, String> {
    let needed = || "a frame and a file are needed, as in UF1=points.csv or UF1=points.csv,UT9".to_owned();
    let (name, rest) = text.split_once('=').ok_or_else(needed)?;
    let (file, tool) = rest.rsplit_once(',').map_or((rest, None), |(file, tool)| (file, Some(tool.trim())));
    if [name, file, tool.unwrap_or("T")].iter().any(|part| part.trim().is_empty()) {
        return Err(needed());
    }
    Ok(TaughtFrom { name: name.trim().into(), file: file.trim().into(), tool: tool.map(Into::into) })
}

fn parse_pose(text: &str) -> Result<Pose, String> {
    match Place::parse(text)? {
        Place::At(pose) => Ok(pose),
        Place::Named(_) => Err("six values are needed: x,y,z,roll,pitch,yaw".into()),
    }
}

fn parse_language(text: &str) -> Result<Dialect, String> {
    Dialect::ALL.into_iter().find(|dialect| dialect.word() == text).ok_or_else(|| {
        let known: Vec<&str> = Dialect::ALL.iter().map(|dialect| dialect.word()).collect();
        format!("unknown language (known: {})", known.join(", "))
    })
}

/// `2` or `2mm`; metres.
fn parse_limit(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(1e-3 * value),
        Ok(_) => Err("a length above 0 is needed, in mm".into()),
        Err(_) => parse_length(text),
    }
}

fn parse_external(text: &str) -> Result<(String, String), String> {
    parse_pair(text, "an external axis and a joint are needed, as in E1=track")
}

fn parse_work(text: &str) -> Result<(String, String), String> {
    parse_pair(text, "a frame and a tool of the fit are needed, as in W1=table")
}

fn parse_pair(text: &str, needed: &str) -> Result<(String, String), String> {
    match text.split_once('=').map(|(name, of)| (name.trim(), of.trim())) {
        Some((name, of)) if !name.is_empty() && !of.is_empty() => Ok((name.into(), of.into())),
        _ => Err(needed.into()),
    }
}

fn parse_channel(text: &str) -> Result<(String, f64), String> {
    let found =
        text.split_once('=').and_then(|(name, value)| Some((name.trim(), value.trim().parse::<f64>().ok()?)));
    match found {
        Some((name, value)) if !name.is_empty() && value.is_finite() => Ok((name.into(), value)),
        _ => Err("a channel and a number are needed, as in temperature=24".into()),
    }
}
