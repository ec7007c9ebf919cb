//! Options of the verb that assesses a robot: iso9283.

use super::files::{Input, OutputFolder};
use super::values::parse_length;
use super::{Accept, Grouped};
use truepose_report::Limit;

/// `truepose iso9283`
#[derive(Debug, clap::Args)]
pub struct Iso9283 {
    /// Robot description (.toml or .urdf) [default: the robot of the fit]
    #[arg(long, value_name = "FILE", required_unless_present = "fit")]
    pub robot: Option<Input>,
    /// Base link of a URDF [default: its root]
    #[arg(long, value_name = "LINK")]
    pub base: Option<String>,
    /// Tip link of a URDF [default: its only leaf]
    #[arg(long, value_name = "LINK")]
    pub tip: Option<String>,
    /// Measurements (CSV): each pose repeated, e.g. in the order of `truepose plan --for iso9283`. Optional columns: pose, cycle, direction,
    /// speed, and command_x, command_y, command_z (command_rx, command_ry, command_rz) in the base frame
    #[arg(long, value_name = "FILE")]
    pub data: Input,
    #[command(flatten)]
    pub grouped: Grouped,
    /// A fit: the same figures with the displacement that its model predicts taken off
    #[arg(long, value_name = "FILE", conflicts_with_all = ["robot", "base", "tip"])]
    pub fit: Option<Input>,
    #[command(flatten)]
    pub accept: Accept,
    /// Which of its sessions the robot is in, of a fit that knows several
    #[arg(long, value_name = "NAME", requires = "fit")]
    pub session: Option<String>,
    /// Frames of instrument and robot: described (with --fit: as the fit found them), or best-fit of the attained positions to the commanded
    /// ones [default: described; best-fit where the base has `known = false`]
    #[arg(long, value_enum, value_name = "FRAMES", hide_possible_values = true)]
    pub align: Option<FramesFrom>,
    /// Standard uncertainty (k = 1) of a measured position in each axis that the readings of one pose share, e.g. 15um [default: 0]
    #[arg(long, value_name = "LENGTH", allow_hyphen_values = true, value_parser = parse_length)]
    pub instrument: Option<f64>,
    /// The rows are points of a path, and the column `cycle` numbers its repeats: path accuracy AT and repeatability RT
    #[arg(long)]
    pub path: bool,
    /// Limit of a figure (AP, RP, vAP, AD, RD, dAP, dRP, AT, RT), e.g. AP=0.5mm; repeat the option for each. Exit code 1 where a figure does
    /// not conform: with the identified model where a fit is given
    #[arg(long, value_name = "FIGURE=LENGTH", allow_hyphen_values = true, value_parser = parse_limit)]
    pub spec: Vec<Limit>,
    /// Folder for the report: `index.html`, its figures, `acceptance.json` and `run.json`
    #[arg(long, value_name = "DIR")]
    pub report: Option<OutputFolder>,
    /// File with the head of the report, [certificate] (TOML) [default: the robot file]
    #[arg(long, value_name = "FILE", requires = "report")]
    pub certificate: Option<Input>,
    /// Print JSON instead of text
    #[arg(long)]
    pub json: bool,
}

/// Where the frames of instrument and robot come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum FramesFrom {
    /// The robot description (with --fit: the fit)
    Described,
    /// A best fit of the attained positions to the commanded ones
    BestFit,
}

/// `AP=0.5mm`; `0.5mm` is a limit of AP.
fn parse_limit(text: &str) -> Result<Limit, String> {
    let (name, length) = text.split_once('=').unwrap_or(("AP", text));
    let name = name.trim();
    let Some((name, _)) = Limit::KNOWN.iter().find(|(known, _)| known.eq_ignore_ascii_case(name)) else {
        let known: Vec<&str> = Limit::KNOWN.iter().map(|(known, _)| *known).collect();
        return Err(format!("`{name}` is no figure with a limit (known: {})", known.join(", ")));
    };
    Ok(Limit { characteristic: (*name).into(), limit: parse_length(length.trim())? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_have_a_figure_and_a_length() {
        let limit = parse_limit("rp = 50um").unwrap();
        assert_eq!(limit.characteristic, "RP");
        assert!((limit.limit - 5e-5).abs() < 1e-18);
        assert_eq!(parse_limit("0.5mm").unwrap().characteristic, "AP");
        for bad in ["XX=1mm", "AP=1", "AP=-1mm", "AP=", "", "AP=0.5mm=3"] {
            assert!(parse_limit(bad).is_err(), "{bad}");
        }
    }
}
