//! Desired poses in, joint commands out: the files of `truepose compensate`.

use crate::commanded::commanded;
use crate::measurements::{From, Needs, read_table};
use crate::table::TableWriter;
use crate::{
    ColumnMap, CsvInfo, IoError, MemoryTable, OrientationConvention, Quantity, Unit, Warning, WholeFile,
};
use std::path::Path;
use truepose_errormodel::{Dataset, DwellTolerance};
use truepose_kinematics::{Chain, JointKind, Pose};

/// Desired poses, with the conditions under which they are wanted.
#[derive(Debug, Clone, PartialEq)]
pub struct Poses {
    /// One row for each pose: `position` and `orientation` are the desired ones. Joints are the seed of the search
    /// where the file has one, else zero; directions of approach are zero where the file states none.
    pub rows: Dataset,
    /// Whether the file has joint columns.
    pub seeded: bool,
    /// The unit of each movable joint in the file, in which commands are written.
    pub joint_units: Vec<Unit>,
    /// What the file calls each row (column `id`), repeated in the commands; empty without such a column.
    pub ids: Vec<String>,
    /// The convention of the file's orientations; none where it has quaternions or no orientations.
    pub convention: Option<OrientationConvention>,
}

/// In which units and convention a corrected pose is written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseForm {
    /// Of its position.
    pub length: Unit,
    /// Of its orientation, with the unit of the angles; none: a quaternion.
    pub turn: Option<(OrientationConvention, Unit)>,
}

impl Default for PoseForm {
    fn default() -> Self {
        PoseForm { length: *Quantity::Length.si(), turn: None }
    }
}

impl PoseForm {
    fn header(&self) -> Vec<String> {
        let length = self.length.word;
        let mut names: Vec<String> = ["x", "y", "z"].iter().map(|name| format!("{name}[{length}]")).collect();
        match self.turn.and_then(|(convention, unit)| Some((convention.names()?, unit))) {
            Some((angles, unit)) => names.extend(angles.map(|name| format!("{name}[{}]", unit.word))),
            None => names.extend(["qw", "qx", "qy", "qz"].map(String::from)),
        }
        names
    }

    /// Numbers under that header; NaN without a pose.
    fn numbers(&self, pose: Option<&Pose>) -> Vec<f64> {
        let Some(pose) = pose else { return vec![f64::NAN; self.header().len()] };
        let mut numbers: Vec<f64> = pose.translation.iter().map(|&v| self.length.from_si(v)).collect();
        match self.turn.and_then(|(convention, unit)| Some((convention.angles(&pose.rotation)?, unit))) {
            Some((angles, unit)) => numbers.extend(angles.map(|angle| unit.from_si(angle))),
            None => numbers.extend(pose.quaternion()),
        }
        numbers
    }
}

/// What became of a desired pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandStatus {
    /// The command brings the robot to the pose.
    Ok,
    /// The pose is out of reach.
    Unreachable,
    /// Only joint values beyond their limits would reach it.
    Limit,
    /// The search did not come to an end.
    NotConverged,
}

impl CommandStatus {
    /// Its word in the file.
    pub fn word(self) -> &'static str {
        match self {
            CommandStatus::Ok => "ok",
            CommandStatus::Unreachable => "unreachable",
            CommandStatus::Limit => "limit",
            CommandStatus::NotConverged => "not_converged",
        }
    }
}

/// The command for one desired pose.
#[derive(Debug, Clone, PartialEq)]
pub struct CommandRow {
    /// Variables of the movable joints, rad or m; written as the controller's values, where the status is `ok`. NaN makes an empty cell.
    pub joints: Vec<f64>,
    /// What became of the pose.
    pub status: CommandStatus,
    /// With 95 % the robot ends no farther from the pose, m; NaN and what has no bound make an empty cell.
    pub within_95: f64,
    /// Whether the command is corrected; else it is that of the nominal robot.
    pub corrected: bool,
    /// What of the command lies beyond the data of the fit, in words; empty: nothing.
    pub beyond: String,
}

/// Reads desired poses: positions in m, orientations as quaternions, in the frame of the file; `columns` says which column is which.
///
/// # Errors
/// When the file cannot be read, lacks a position, or at the first cell that is wrong.
pub fn read_poses(
    path: impl AsRef<Path>,
    chain: &Chain,
    columns: &ColumnMap,
) -> Result<(Poses, CsvInfo, Vec<Warning>), IoError> {
    poses(From::File(path.as_ref()), chain, columns)
}

/// Reads desired poses of a table in memory, as [`read_poses`] those of a file.
///
/// # Errors
/// When it lacks a position, or at the first cell that is wrong.
pub fn poses_in_memory(
    table: MemoryTable,
    chain: &Chain,
    columns: &ColumnMap,
) -> Result<(Poses, CsvInfo, Vec<Warning>), IoError> {
    poses(From::Memory(table), chain, columns)
}

fn poses(
    from: From<'_>,
    chain: &Chain,
    columns: &ColumnMap,
) -> Result<(Poses, CsvInfo, Vec<Warning>), IoError> {
    let needs = Needs { joints: false, measured: false, position: true };
    let table = read_table(from, chain, needs, DwellTolerance::default(), columns)?;
    let joint_units = match &table.header.slots.joints {
        Some(slots) => slots.iter().map(|&k| table.header.columns[k].conversion).collect(),
        None => chain.movable().iter().map(|&joint| *si_unit(chain.joint(joint).kind)).collect(),
    };
    let seeded = table.header.slots.joints.is_some();
    let ids = table.info.ids.clone();
    let slots = &table.header.slots;
    let vector = slots.rotation_vector.map(|_| OrientationConvention::RotationVector);
    let convention = slots.angles.map(|(_, convention)| convention).or(vector);
    Ok((Poses { rows: table.data, seeded, joint_units, ids, convention }, table.info, table.warnings))
}

/// Writes the command of each pose, in the order of the poses and in their units.
///
/// # Errors
/// When the file cannot be written, or there is not one command for each pose.
pub fn write_commands(
    path: impl AsRef<Path>,
    chain: &Chain,
    poses: &Poses,
    commands: &[CommandRow],
) -> Result<(), IoError> {
    commands_file(path, chain, poses, commands, None)?.finish()
}

/// The file that [`write_commands`] writes, under no name yet; with the pose (m) for a controller without the model, one for each command, where
/// given.
///
/// # Errors
/// As [`write_commands`].
pub fn commands_file(
    path: impl AsRef<Path>,
    chain: &Chain,
    poses: &Poses,
    commands: &[CommandRow],
    corrected: Option<(&[Pose], PoseForm)>,
) -> Result<WholeFile, IoError> {
    let path = path.as_ref();
    if commands.len() != poses.rows.len() || poses.joint_units.len() != chain.movable().len() {
        let message = format!("there are {} commands for {} poses", commands.len(), poses.rows.len());
        return Err(IoError::Write { file: path.into(), message });
    }
    let own = commanded(chain);
    let joints = own.iter().map(|&k| (chain.movable()[k], &poses.joint_units[k]));
    let joints = joints.map(|(joint, unit)| format!("{}[{}]", chain.joint(joint).name, unit.word));
    let named = poses.ids.len() == commands.len() && !commands.is_empty();
    let mut header: Vec<String> = named.then(|| "id".to_owned()).into_iter().chain(joints).collect();
    header.extend(["status", "within_95[m]", "correction", "extrapolates", "beyond"].map(String::from));
    if let Some((_, form)) = &corrected {
        header.extend(form.header().into_iter().map(|name| format!("corrected_{name}")));
    }
    let mut table = TableWriter::create(path, &header)?;
    for (row, command) in commands.iter().enumerate() {
        if named {
            table.text(&poses.ids[row]);
        }
        let values = controller_values(chain, &command.joints);
        for &k in &own {
            let unit = &poses.joint_units[k];
            let written = values.get(k).filter(|_| command.status == CommandStatus::Ok);
            table.number(written.map_or(f64::NAN, |&value| unit.from_si(value)));
        }
        table.text(command.status.word());
        if command.status == CommandStatus::Ok {
            table.number(if command.within_95.is_finite() { command.within_95 } else { f64::NAN });
            table.text(if command.corrected { "model" } else { "nominal" });
            table.integer((!command.beyond.is_empty()).into());
            table.text(&command.beyond);
        } else {
            (0..4).for_each(|_| table.text(""));
        }
        if let Some((poses, form)) = &corrected {
            let pose = poses.get(row).filter(|_| command.status == CommandStatus::Ok);
            form.numbers(pose).into_iter().for_each(|value| table.number(value));
        }
        table.end_row()?;
    }
    Ok(table.into_file())
}

/// The controller's values of these variables of the movable joints, rad or m; of fewer, none are coupled.
pub(crate) fn controller_values(chain: &Chain, joints: &[f64]) -> Vec<f64> {
    let mut values = joints.to_vec();
    if values.len() == chain.movable().len() {
        chain.joints_to_controller(&mut values);
    }
    values
}

pub(crate) fn si_unit(kind: JointKind) -> &'static Unit {
    match kind {
        JointKind::Prismatic => Quantity::Length.si(),
        _ => Quantity::Angle.si(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::{TargetId, samples};

    fn read(text: &str) -> Result<(Poses, Vec<Warning>), String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.csv");
        std::fs::write(&path, text).unwrap();
        read_poses(&path, &samples::pps(), &ColumnMap::default())
            .map(|(poses, _, warnings)| (poses, warnings))
            .map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
    }

    #[test]
    fn seeds_are_optional() {
        let (poses, warnings) =
            read("x[mm],y[mm],z[mm],target,time[s],approach_d1\n1,2,3,P1,5,1\n4,5,6,,4,-1\n").unwrap();
        assert!(!poses.seeded && !poses.rows.schema.approach);
        assert_eq!(poses.rows.joints, vec![vec![0.0, 0.0]; 6]);
        assert_eq!(poses.rows.approach[0], [1.0, -1.0]);
        assert_eq!(poses.rows.target, [Some(TargetId(0)), None]);
        assert_eq!(
            poses.joint_units.iter().map(|u| u.word).collect::<Vec<_>>(),
            ["m", "m", "m", "rad", "rad", "rad"]
        );
        assert_eq!(warnings.len(), 1);
        let (poses, _) = read(
            "d1[mm],d2[mm],d3[mm],theta[deg],roll[deg],pitch[deg],x[mm],y[mm],z[mm],qw,qx,qy,qz\n\
             10,20,30,40,1,2,1,2,3,1,0,0,0\n1,2,3,4,1,2,1,2,3,,,,\n",
        )
        .unwrap();
        assert!(poses.seeded);
        assert_eq!(poses.rows.joints[0], [0.01, 0.001]);
        assert_eq!(poses.rows.orientation, [Some([1.0, 0.0, 0.0, 0.0]), None]);
    }

    #[test]
    fn what_is_wrong_is_reported() {
        assert_eq!(
            read("x[mm],y[mm],z[mm]\n1,,3\n").unwrap_err(),
            "t.csv:2: column `y[mm]` (2): is empty; a desired pose needs all of x, y, z"
        );
        assert_eq!(
            read("qw,qx,qy,qz\n1,0,0,0\n").unwrap_err(),
            "t.csv:1: no columns hold a position; add `x[mm]`, `y[mm]`, `z[mm]` (columns here: qw, qx, qy, qz)"
        );
        assert!(
            read("d1[mm],x[mm],y[mm],z[mm]\n1,1,2,3\n")
                .unwrap_err()
                .contains("joints `d2`, `d3`, `theta`, `roll`, `pitch` have no columns")
        );
    }

    #[test]
    fn commands_come_in_the_units_of_the_poses() {
        let (poses, _) = read(
            "d1[mm],d2[mm],d3[mm],theta[deg],roll[deg],pitch[deg],x[mm],y[mm],z[mm]\n\
             10,20,30,40,1,2,1,2,3\n1,2,3,4,1,2,1,2,3\n",
        )
        .unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("q.csv");
        let commands = [
            CommandRow {
                joints: vec![0.25, 0.5, 1.0, std::f64::consts::PI, 0.0, 0.0],
                status: CommandStatus::Ok,
                within_95: 1e-4,
                corrected: true,
                beyond: "d1".into(),
            },
            // The nearest that was found is no command.
            CommandRow {
                joints: vec![0.5; 6],
                status: CommandStatus::Unreachable,
                within_95: 1.0,
                corrected: true,
                beyond: "d1".into(),
            },
        ];
        write_commands(&path, &samples::pps(), &poses, &commands).unwrap();
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            "d1[mm],d2[mm],d3[mm],theta[deg],roll[deg],pitch[deg],status,within_95[m],correction,extrapolates,beyond\n\
             250.0,500.0,1000.0,180.0,0.0,0.0,ok,0.0001,model,1,d1\n,,,,,,unreachable,,,,\n"
        );
        assert!(write_commands(&path, &samples::pps(), &poses, &commands[..1]).is_err());
    }
}
