//! Options of the verbs that use a fit: plan, predict, compensate, export, map.

use super::files::{Input, Output, OutputFolder};
use super::program::RobotProgram;
use super::values::{parse_length, parse_position, parse_three, parse_units, parse_whole};
use super::{Grouped, NamedColumns};
use truepose_workflow::{GivenPlace, Units};

/// `truepose plan`
#[derive(Debug, clap::Args)]
pub struct Plan {
    /// A fit, as `identify` or `discover` writes it
    #[arg(long, value_name = "FILE", required_unless_present_any = ["robot", "model"])]
    pub fit: Option<Input>,
    /// Which of its sessions the robot is in, of a fit that knows several
    #[arg(long, value_name = "NAME")]
    pub session: Option<String>,
    /// Plan rows at the landmarks and sensors of this robot file: sockets, balls, plates, wires, gauges, cameras
    #[arg(long, value_name = "FILE", conflicts_with_all = ["test", "rival", "report"])]
    pub observe: Option<Input>,
    /// Measurements (CSV) among whose pose measurements is chosen; what they measured does not count [default: postures within the joints' ranges]
    #[arg(long, value_name = "FILE", requires = "observe")]
    pub among: Option<Input>,
    /// Target that touches or is seen [default: the first; the tool's origin when there is none]
    #[arg(long, value_name = "NAME", requires = "observe", conflicts_with = "among")]
    pub target: Option<String>,
    /// Declared effects (TOML), where nothing has been fitted yet: their prior standard deviations stand for what is not known
    #[arg(long, value_name = "FILE", requires = "observe", conflicts_with = "fit")]
    pub model: Option<Input>,
    /// Plan a test instead: iso9283, the cube, the five poses and the cycles of ISO 9283; monitor, the poses of the fit that show changes best (12, or --count); or transfer, those from which a new installation is found best (8, or --count)
    #[arg(long = "for", value_enum, value_name = "TEST", hide_possible_values = true, conflicts_with_all = ["rival", "at", "report"])]
    pub test: Option<PlannedTest>,
    /// Robot of the test (.toml or .urdf), in place of a fit
    #[arg(long, value_name = "FILE", requires = "test", conflicts_with = "fit")]
    pub robot: Option<Input>,
    /// Base link of a URDF [default: its root]
    #[arg(long, value_name = "LINK", requires = "robot")]
    pub base: Option<String>,
    /// Tip link of a URDF [default: its only leaf]
    #[arg(long, value_name = "LINK", requires = "robot")]
    pub tip: Option<String>,
    /// Edge of the test's cube, e.g. 400mm [default: the largest of the standard's sizes that the robot reaches]
    #[arg(long, value_name = "LENGTH", requires = "test", allow_hyphen_values = true, value_parser = parse_length)]
    pub edge: Option<f64>,
    /// Its centre in the base frame, e.g. 600mm,0mm,500mm [default: where the largest cube fits]
    #[arg(long, value_name = "X,Y,Z", requires = "test", allow_hyphen_values = true, value_parser = parse_position)]
    pub centre: Option<[f64; 3]>,
    /// Orientation of the tool in the base frame: roll, pitch, yaw, degrees [default: chosen with the cube]
    #[arg(long, value_name = "R,P,Y", requires = "test", allow_hyphen_values = true, value_parser = parse_three)]
    pub rpy: Option<[f64; 3]>,
    /// Cycles of the test
    #[arg(long, default_value_t = 30, value_parser = clap::value_parser!(u16).range(2..=10_000))]
    pub cycles: u16,
    /// Fit of a competing hypothesis: plan the pose measurements that distinguish the two
    #[arg(long, value_name = "FILE", alias = "discriminate")]
    pub rival: Option<Input>,
    /// Joints, loads and channels (CSV) where accuracy matters [default: spread over the joints' ranges]
    #[arg(long, value_name = "FILE")]
    pub at: Option<Input>,
    #[command(flatten)]
    pub grouped: Grouped,
    /// Where to write the plan (CSV, with the columns of measurements)
    #[arg(long, value_name = "FILE")]
    pub out: Output,
    /// Folder for the report: `index.html`, its figures, `plan.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<OutputFolder>,
    /// File with the head of the report, [certificate] (TOML)
    #[arg(long, value_name = "FILE", requires = "report")]
    pub certificate: Option<Input>,
    /// Units of the joints in --out, e.g. deg or deg,mm [default: rad,m]
    #[arg(long, value_name = "UNITS", value_parser = parse_units)]
    pub units: Option<Units>,
    /// For transfer: the tool will be new as well
    #[arg(long, requires = "test")]
    pub tool: bool,
    /// For transfer: the targets will be new as well
    #[arg(long, requires = "test")]
    pub targets: bool,
    /// Number of pose measurements [default: 30; 12 for monitor; 8 for transfer]
    #[arg(long, value_parser = parse_whole::<usize>)]
    pub count: Option<usize>,
    /// Available payloads, kg [default: none]
    #[arg(long, value_name = "KG", value_delimiter = ',', allow_negative_numbers = true)]
    pub loads: Vec<f64>,
    /// Their centre of gravity in the tool frame, mm
    #[arg(long, value_name = "MM", num_args = 3, value_delimiter = ',', allow_negative_numbers = true, default_values_t = [0.0, 0.0, 0.0])]
    pub com: Vec<f64>,
    /// Number of candidate configurations
    #[arg(long, default_value_t = 400, value_parser = parse_whole::<usize>)]
    pub pool: usize,
    /// Seed of the candidate configurations
    #[arg(long, default_value_t = 0, value_parser = parse_whole::<u64>)]
    pub seed: u64,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// Tests whose poses are planned.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum PlannedTest {
    /// Pose accuracy and repeatability of ISO 9283
    Iso9283,
    /// Looks at the robot with `truepose monitor`
    Monitor,
    /// Another installation, found with `truepose transfer`
    Transfer,
}

/// Whether the user insists.
#[derive(Debug, Default, clap::Args)]
pub struct Accept {
    /// Use a fit that its own run found not to fit; the output states it
    #[arg(long, requires = "fit")]
    pub accept: bool,
}

/// `truepose predict`
#[derive(Debug, clap::Args)]
pub struct Predict {
    /// A fit, as `identify` writes it
    #[arg(long, value_name = "FILE")]
    pub fit: Input,
    #[command(flatten)]
    pub accept: Accept,
    /// Which of its sessions the robot is in, of a fit that knows several
    #[arg(long, value_name = "NAME")]
    pub session: Option<String>,
    /// Joints, loads and channels (CSV); measured columns may be empty or absent
    #[arg(long, value_name = "FILE")]
    pub data: Input,
    #[command(flatten)]
    pub grouped: Grouped,
    /// Where to write the predictions
    #[arg(long, value_name = "FILE")]
    pub out: Output,
    /// Folder for the report: `index.html`, its figures, `prediction.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<OutputFolder>,
    /// File with the head of the report, [certificate] (TOML)
    #[arg(long, value_name = "FILE", requires = "report")]
    pub certificate: Option<Input>,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose compensate`
#[derive(Debug, clap::Args)]
pub struct Compensate {
    /// A fit, as `identify` writes it
    #[arg(long, value_name = "FILE")]
    pub fit: Input,
    #[command(flatten)]
    pub accept: Accept,
    /// Which of its sessions the robot is in, of a fit that knows several
    #[arg(long, value_name = "NAME")]
    pub session: Option<String>,
    /// Desired poses (CSV): x y z, optional orientation, target, load, channels, time, approach; joint columns are the start of the search
    #[arg(long, value_name = "FILE", required_unless_present_any = ["joints", "program"])]
    pub poses: Option<Input>,
    /// Other tool of the robot in whose axes the poses are, where it really is: one hand is brought to the other, whose joints stay where the joint columns have them
    #[arg(long, value_name = "TOOL", requires = "poses", conflicts_with_all = ["frame", "tcp", "cartesian", "report"])]
    pub relative_to: Option<String>,
    /// Joint that stays where the joint columns have it, e.g. track; the others take the correction. Repeat for each; of a program see --external
    #[arg(long, value_name = "JOINT", conflicts_with = "program")]
    pub hold: Vec<String>,
    #[command(flatten)]
    pub named: NamedColumns,
    /// Joint values of a programme for the nominal robot (CSV), instead of poses: each is replaced by the joints that bring the real flange there
    #[arg(long, value_name = "FILE", conflicts_with_all = ["poses", "tcp"])]
    pub joints: Option<Input>,
    /// Frame of the poses: base, measurement, the name of a frame, or x,y,z,roll,pitch,yaw in the base, e.g. 900mm,0mm,50mm,0,0,90
    /// (degrees) [default: measurement]. Of a program: the value of a frame by its name, e.g. UF1=900mm,0mm,50mm,0,0,90, repeated for
    /// each; without a name that of points whose frame is not known [default: the robot's base]
    #[arg(long, value_name = "FRAME", value_parser = GivenPlace::parse, allow_hyphen_values = true)]
    pub frame: Vec<GivenPlace>,
    /// Tool centre point of the poses: flange, the name of a frame, or x,y,z,roll,pitch,yaw in the last joint's frame [default: the tool of
    /// the measurements]. Of a program: as --frame, e.g. UT1=0mm,0mm,120mm,0,0,0
    #[arg(long, visible_alias = "tool-frame", value_name = "FRAME", value_parser = GivenPlace::parse, allow_hyphen_values = true)]
    pub tcp: Vec<GivenPlace>,
    /// File with [[frames]] (TOML) [default: those of the fit's robot file]
    #[arg(long, value_name = "FILE")]
    pub frames: Option<Input>,
    /// Also write the corrected pose that a controller without the model has to be given, in the frame of the poses
    #[arg(long)]
    pub cartesian: bool,
    /// Units of the joints and corrected poses in --out, e.g. deg,mm; orientations of corrected poses are then in the convention of --poses [default: joints as in the file, else rad,m]
    #[arg(long, value_name = "UNITS", conflicts_with = "program", value_parser = parse_units)]
    pub units: Option<Units>,
    #[command(flatten)]
    pub robot_program: RobotProgram,
    /// Where to write the commands, or the program; the table of its corrections is written beside it (FILE.corrections.csv)
    #[arg(long, value_name = "FILE")]
    pub out: Output,
    /// Folder for the report: `index.html`, its figures, `compensation.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<OutputFolder>,
    /// File with the head of the report, [certificate] (TOML)
    #[arg(long, value_name = "FILE", requires = "report")]
    pub certificate: Option<Input>,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// `truepose export`
#[derive(Debug, clap::Args)]
pub struct Export {
    /// A fit, as `identify` writes it
    #[arg(long, value_name = "FILE")]
    pub fit: Input,
    #[command(flatten)]
    pub accept: Accept,
    /// Which of its sessions the robot is in, of a fit that knows several
    #[arg(long, value_name = "NAME")]
    pub session: Option<String>,
    /// Format of the file
    #[arg(long, value_enum)]
    pub format: ExportFormat,
    /// Where to write it
    #[arg(long, value_name = "FILE")]
    pub out: Output,
    /// The URDF that the fit was made from: its joint origins are corrected, everything else stays as it is
    #[arg(long, value_name = "FILE")]
    pub urdf: Option<Input>,
    /// Maker whose structure `--format ros-yaml` has
    #[arg(long, value_enum, required_if_eq("format", "ros-yaml"))]
    pub style: Option<YamlStyle>,
    /// The maker's own kinematics file (YAML), e.g. `default_kinematics.yaml`: ros-yaml gets its link frames
    #[arg(long, value_name = "FILE")]
    pub like: Option<Input>,
    /// The controller's hash, for `--style ur`: `calib_…`, as extracted from this robot [default: a hash of our own, which the driver reports]
    #[arg(long, value_name = "HASH", value_parser = parse_hash)]
    pub hash: Option<String>,
    /// Reject nearly parallel axes in dh and mdh, instead of using Hayati's parameter (beta)
    #[arg(long)]
    pub no_hayati: bool,
    /// Number of values of each joint in iso230
    #[arg(long, default_value_t = 181, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub entries: u32,
    /// Target at which the remaining error is computed [default: the tool's origin]
    #[arg(long, value_name = "NAME")]
    pub target: Option<String>,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// Forms of the fitted geometry.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum ExportFormat {
    /// URDF with corrected joint origins
    Urdf,
    /// Denavit and Hartenberg's table (CSV)
    Dh,
    /// Craig's modified table (CSV)
    Mdh,
    /// Kinematics file of ROS drivers (YAML): x y z roll pitch yaw of each joint
    Ros,
    /// Kinematics file in the structure of a maker's ROS description (YAML, with --style)
    RosYaml,
    /// Component errors of each joint, named as in ISO 230-1 (CSV)
    Iso230,
    /// Parameters in the convention and units of the robot file: nominal, calibrated, 95 % interval (CSV)
    Parameters,
}

/// Makers whose ROS descriptions have a kinematics file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum YamlStyle {
    /// Universal Robots: `kinematics:` with `hash:`
    Ur,
    /// Franka: `joint1:` `kinematic:`
    Franka,
    /// Flexiv: `kinematics:` `joint1:`
    Flexiv,
    /// UFACTORY xArm: `kinematics:` `joint1:`
    Xarm,
}

impl ExportFormat {
    /// The form of a file of the geometry; none of the parameters as described, which are a table.
    pub fn of_geometry(self) -> Option<truepose_workflow::ExportFormat> {
        use truepose_workflow::ExportFormat as Of;
        Some(match self {
            ExportFormat::Urdf => Of::Urdf,
            ExportFormat::Dh => Of::Dh,
            ExportFormat::Mdh => Of::Mdh,
            ExportFormat::Ros => Of::Ros,
            ExportFormat::RosYaml => Of::RosYaml,
            ExportFormat::Iso230 => Of::Iso230,
            ExportFormat::Parameters => return None,
        })
    }
}

impl From<YamlStyle> for truepose_compensate::RosStyle {
    fn from(of: YamlStyle) -> Self {
        match of {
            YamlStyle::Ur => Self::Ur,
            YamlStyle::Franka => Self::Franka,
            YamlStyle::Flexiv => Self::Flexiv,
            YamlStyle::Xarm => Self::XArm,
        }
    }
}

/// A word that YAML reads as it stands.
fn parse_hash(text: &str) -> Result<String, String> {
    let plain = text.starts_with("calib_") && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if plain { Ok(text.into()) } else { Err("the hash of a controller is `calib_` and digits".into()) }
}

/// `truepose map`
#[derive(Debug, clap::Args)]
pub struct Map {
    /// A fit, as `identify` writes it
    #[arg(long, value_name = "FILE")]
    pub fit: Input,
    #[command(flatten)]
    pub accept: Accept,
    /// Which of its sessions the robot is in, of a fit that knows several
    #[arg(long, value_name = "NAME")]
    pub session: Option<String>,
    /// Where to write the map (CSV)
    #[arg(long, value_name = "FILE")]
    pub out: Output,
    /// Folder for the report: `index.html`, its figures, `map.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<OutputFolder>,
    /// File with the head of the report, [certificate] (TOML)
    #[arg(long, value_name = "FILE", requires = "report")]
    pub certificate: Option<Input>,
    /// Corner of a box in the measurement frame, e.g. -500mm,0mm,200mm [default: a grid of joint values]
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_position, requires = "to", allow_hyphen_values = true)]
    pub from: Option<[f64; 3]>,
    /// The opposite corner
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_position, requires = "from", allow_hyphen_values = true)]
    pub to: Option<[f64; 3]>,
    /// Orientation of the tool in the box: roll, pitch, yaw about the fixed axes, degrees [default: any]
    #[arg(long, value_name = "R,P,Y", value_parser = parse_three, requires = "from", allow_hyphen_values = true)]
    pub rpy: Option<[f64; 3]>,
    /// Number of values of each joint, or of each coordinate of the box
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub points: u16,
    /// Mass carried, kg
    #[arg(long, allow_negative_numbers = true, value_name = "KG")]
    pub payload: Option<f64>,
    /// Its centre of gravity in the tool's frame, e.g. 0mm,0mm,80mm
    #[arg(long, value_name = "X,Y,Z", value_parser = parse_position, requires = "payload", allow_hyphen_values = true)]
    pub com: Option<[f64; 3]>,
    /// Target that is mapped [default: the tool's origin]
    #[arg(long, value_name = "NAME")]
    pub target: Option<String>,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}
