//! A map of the accuracy as a CSV file: the file of `truepose map`.

use crate::commanded::commanded;
use crate::poses::{controller_values, si_unit};
use crate::table::TableWriter;
use crate::{CommandStatus, IoError, WholeFile};
use std::path::Path;
use truepose_kinematics::Chain;

/// One place of the workspace. NaN makes an empty cell.
#[derive(Debug, Clone, PartialEq)]
pub struct MapRow {
    /// Where the point is to be, m, measurement frame.
    pub position: [f64; 3],
    /// Variables of the movable joints, rad or m; written as the controller's values, where the place can be reached.
    pub joints: Vec<f64>,
    /// Whether it can be reached.
    pub status: CommandStatus,
    /// By how much the uncompensated robot misses it, m.
    pub before: f64,
    /// With 95 % the uncompensated robot misses it by no more, m.
    pub before_95: f64,
    /// With 95 % the compensated robot misses it by no more, m.
    pub after_95: f64,
    /// Whether the place is outside of the range of the data of the fit.
    pub extrapolates: bool,
    /// What lies beyond that, in words.
    pub beyond: String,
}

/// Writes a map, in m and rad.
///
/// # Errors
/// When the file cannot be written.
pub fn write_map(path: impl AsRef<Path>, chain: &Chain, rows: &[MapRow]) -> Result<(), IoError> {
    map_file(path, chain, rows)?.finish()
}

/// The file that [`write_map`] writes, under no name yet.
///
/// # Errors
/// As [`write_map`].
pub fn map_file(path: impl AsRef<Path>, chain: &Chain, rows: &[MapRow]) -> Result<WholeFile, IoError> {
    let mut header: Vec<String> = ["x[m]", "y[m]", "z[m]"].map(String::from).to_vec();
    let own = commanded(chain);
    header.extend(own.iter().map(|&k| {
        let joint = chain.joint(chain.movable()[k]);
        format!("{}[{}]", joint.name, si_unit(joint.kind).word)
    }));
    header.extend(
        ["status", "before[m]", "before_95[m]", "after_95[m]", "extrapolates", "beyond"].map(String::from),
    );
    let mut table = TableWriter::create(path.as_ref(), &header)?;
    for row in rows {
        row.position.iter().for_each(|&value| table.number(value));
        let values = controller_values(chain, &row.joints);
        for &k in &own {
            let reached = row.status == CommandStatus::Ok;
            table.number(values.get(k).copied().filter(|_| reached).unwrap_or(f64::NAN));
        }
        table.text(row.status.word());
        table.number(row.before);
        table.number(row.before_95);
        table.number(row.after_95);
        table.integer(row.extrapolates.into());
        table.text(&row.beyond);
        table.end_row()?;
    }
    Ok(table.into_file())
}

#[cfg(test)]
mod tests {
    use super::*;
    use truepose_kinematics::samples;

    #[test]
    fn what_has_no_figures_has_empty_cells() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.csv");
        let row = MapRow {
            position: [1.0, 2.0, 3.0],
            joints: vec![0.5, 0.25, 0.125, -1.0],
            status: CommandStatus::Ok,
            before: 1e-3,
            before_95: 2e-3,
            after_95: 5e-5,
            extrapolates: true,
            beyond: "r1; leverage".into(),
        };
        let nan = f64::NAN;
        let far = MapRow {
            status: CommandStatus::Unreachable,
            before: nan,
            before_95: nan,
            after_95: nan,
            extrapolates: false,
            beyond: String::new(),
            ..row.clone()
        };
        write_map(&path, &samples::scara(), &[row, far]).unwrap();
        let names: Vec<String> =
            samples::scara().joints().iter().map(|j| format!("{}[{}]", j.name, j.unit())).collect();
        assert_eq!(
            std::fs::read_to_string(&path).unwrap(),
            format!(
                "x[m],y[m],z[m],{},status,before[m],before_95[m],after_95[m],extrapolates,beyond\n\
                 1.0,2.0,3.0,0.5,0.25,0.125,-1.0,ok,0.001,0.002,5e-5,1,r1; leverage\n\
                 1.0,2.0,3.0,,,,,unreachable,,,,0,\n",
                names.join(",")
            )
        );
    }
}
