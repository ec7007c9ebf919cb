//! Predicted rows: the file of `truepose predict`.

use crate::commanded::commanded;
use crate::poses::si_unit;
use crate::table::TableWriter;
use crate::{CsvInfo, IoError};
use std::path::Path;
use truepose_errormodel::Dataset;
use truepose_kinematics::{Chain, Pose};

/// A predicted row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prediction {
    /// Position of the row's target, m, and orientation of the tool, in the measurement frame.
    pub pose: Pose,
    /// Whether the orientation is known; else its cells are empty.
    pub oriented: bool,
    /// With 95 % a new measurement lies no farther from the position, m; what has no bound makes an empty cell.
    pub within_95: f64,
    /// Whether the row lies beyond the data of the fit.
    pub extrapolates: bool,
}

/// What a file of predictions repeats of the rows that were predicted, besides their joints.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Repeated {
    /// Names of the rows (`id`).
    pub ids: bool,
    /// Numbers of visits.
    pub visits: bool,
    /// Targets.
    pub targets: bool,
    /// Sessions, by the names of [`PredictionsWriter::with_sessions`].
    pub sessions: bool,
}

/// Predicted rows, block after block, in the order of the data. The file appears with [`PredictionsWriter::finish`].
///
/// Besides `x[m],y[m],z[m]`, `qw,qx,qy,qz`, `within_95[m]` and `extrapolates` each row repeats its name, its visit (by the file's own number), its session, its joints in rad and m, and its
/// target, where the data has them.
#[derive(Debug)]
pub struct PredictionsWriter<'a> {
    chain: &'a Chain,
    repeated: Repeated,
    table: TableWriter,
    /// The controller's values of the movable joints, of one row.
    values: Vec<f64>,
    /// Names of the sessions.
    sessions: Vec<String>,
}

impl<'a> PredictionsWriter<'a> {
    /// Begins a file.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn create(path: impl AsRef<Path>, chain: &'a Chain, repeated: Repeated) -> Result<Self, IoError> {
        let mut header: Vec<String> = Vec::new();
        if repeated.ids {
            header.push("id".into());
        }
        if repeated.visits {
            header.push("visit".into());
        }
        if repeated.sessions {
            header.push("session".into());
        }
        header.extend(commanded(chain).into_iter().map(|k| {
            let joint = chain.joint(chain.movable()[k]);
            format!("{}[{}]", joint.name, si_unit(joint.kind).word)
        }));
        if repeated.targets {
            header.push("target".into());
        }
        let said = ["x[m]", "y[m]", "z[m]", "qw", "qx", "qy", "qz", "within_95[m]", "extrapolates"];
        header.extend(said.map(String::from));
        let table = TableWriter::create(path.as_ref(), &header)?;
        let values = vec![0.0; chain.movable().len()];
        Ok(PredictionsWriter { chain, repeated, table, values, sessions: Vec::new() })
    }

    /// With the names of the data's sessions, by their number.
    #[must_use]
    pub fn with_sessions(self, names: &[String]) -> Self {
        PredictionsWriter { sessions: names.to_vec(), ..self }
    }

    /// One row for each row of the data. `labels` are the file's numbers of the data's visits, `ids` its names of the rows.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(
        &mut self,
        data: &Dataset,
        (labels, ids): (&[i64], &[String]),
        predicted: &[Prediction],
    ) -> Result<(), IoError> {
        let table = &mut self.table;
        for (row, prediction) in predicted.iter().enumerate() {
            if self.repeated.ids {
                table.text(ids.get(row).map_or("", String::as_str));
            }
            if self.repeated.visits {
                table.integer(labels.get(data.visit[row]).copied().unwrap_or(data.visit[row] as i64));
            }
            if self.repeated.sessions {
                table.text(self.sessions.get(data.session(row)).map_or("", String::as_str));
            }
            self.values.iter_mut().zip(&data.joints).for_each(|(value, column)| *value = column[row]);
            self.chain.joints_to_controller(&mut self.values);
            for (k, &value) in self.values.iter().enumerate() {
                if self.chain.is_commanded(k) {
                    table.number(value);
                }
            }
            if self.repeated.targets {
                table.text(data.target[row].map_or("", |target| &self.chain.targets()[target.0].name));
            }
            prediction.pose.translation.iter().for_each(|&v| table.number(v));
            let turned = if prediction.oriented { prediction.pose.quaternion() } else { [f64::NAN; 4] };
            turned.iter().for_each(|&v| table.number(v));
            table.number(if prediction.within_95.is_finite() { prediction.within_95 } else { f64::NAN });
            table.integer(prediction.extrapolates.into());
            table.end_row()?;
        }
        Ok(())
    }

    /// Makes the file appear.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn finish(self) -> Result<(), IoError> {
        self.table.finish()
    }
}

/// Writes one predicted row for each row of the data, in its order, as [`PredictionsWriter`] does; visits bear the file's own numbers, from
/// `info`.
///
/// # Errors
/// When the file cannot be written, or there is not one prediction for each row.
pub fn write_predictions(
    path: impl AsRef<Path>,
    chain: &Chain,
    data: &Dataset,
    info: &CsvInfo,
    predicted: &[Prediction],
) -> Result<(), IoError> {
    let path = path.as_ref();
    if predicted.len() != data.len() {
        let message = format!("there are {} predictions for {} rows", predicted.len(), data.len());
        return Err(IoError::Write { file: path.into(), message });
    }
    let repeated = Repeated {
        ids: info.ids.len() == data.len(),
        visits: !info.visit_labels.is_empty(),
        targets: data.target.iter().any(Option::is_some),
        sessions: !info.sessions.is_empty(),
    };
    let mut file = PredictionsWriter::create(path, chain, repeated)?.with_sessions(&info.sessions);
    file.write(data, (&info.visit_labels, &info.ids), predicted)?;
    file.finish()
}

#[cfg(test)]
#[allow(clippy::float_cmp)] // what is exact is tested as such
mod tests {
    use super::*;
    use crate::{MeasurementsOptions, read_measurements};
    use truepose_kinematics::samples;

    #[test]
    fn predictions_read_as_measurements() {
        let folder = tempfile::tempdir().unwrap();
        let (source, out) = (folder.path().join("d.csv"), folder.path().join("p.csv"));
        std::fs::write(
            &source,
            "visit,r1[rad],r2[deg],slide[mm],r4[rad]\n7,0.1,20,30,0.4\n-2,0.5,60,70,0.8\n",
        )
        .unwrap();
        let chain = samples::scara();
        let options = MeasurementsOptions { measured_required: false, ..MeasurementsOptions::default() };
        let (data, info, _) = read_measurements(&source, &chain, &options).unwrap();
        let predicted: Vec<Prediction> = (0..2)
            .map(|row| Prediction {
                pose: chain.forward(&data.conditions(row).joints),
                oriented: row == 0,
                within_95: 1e-4,
                extrapolates: row == 1,
            })
            .collect();
        write_predictions(&out, &chain, &data, &info, &predicted).unwrap();
        let (again, info, warnings) =
            read_measurements(&out, &chain, &MeasurementsOptions::default()).unwrap();
        assert_eq!(info.visit_labels, vec![7, -2]);
        // A length that is no joint is remarked upon, and read as a channel.
        assert!(warnings.iter().all(|w| w.message.contains("counts as a channel")), "{warnings:?}");
        assert_eq!(again.joints, data.joints);
        assert_eq!(again.measured_rotation(1), None);
        assert_eq!(again.channels, [[1e-4, 1e-4], [0.0, 1.0]]);
        for (row, Prediction { pose, oriented, .. }) in predicted.iter().enumerate() {
            assert_eq!(again.position[row], [pose.translation.x, pose.translation.y, pose.translation.z]);
            if *oriented {
                let same = again.measured_rotation(row).unwrap() - pose.rotation;
                assert!(same.amax() < 1e-15);
            }
        }
        assert!(write_predictions(&out, &chain, &data, &CsvInfo::default(), &[]).is_err());
    }
}
