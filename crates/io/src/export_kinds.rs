//! Columns of a file of measurements that say what else than a position a row observed.

use crate::Unit;
use crate::table::TableWriter;
use truepose_errormodel::observation::{Camera, Distance, KINDS, Linear, Relative};
use truepose_errormodel::{Dataset, KIND, LANDMARK, POINT, VALUE};

/// The columns `kind`, `landmark`, `point` and those of measured numbers, as far as any row needs them.
pub(crate) struct KindColumns<'d> {
    data: &'d Dataset,
    names: &'d [String],
    length: Unit,
    point: bool,
    distance: bool,
    value: bool,
    pixels: bool,
}

/// Whether a channel is one of these columns.
pub(crate) fn in_kind_columns(channel: &str) -> bool {
    [LANDMARK, KIND, POINT].contains(&channel) || VALUE.contains(&channel)
}

impl<'d> KindColumns<'d> {
    /// Of these rows, whose landmarks have these names; none where all are positions and poses.
    pub fn of(data: &'d Dataset, names: &'d [String], length: Unit) -> Result<Option<Self>, String> {
        let rows = || 0..data.len();
        if rows().all(|row| data.landmark(row).is_none()) {
            return Ok(None);
        }
        let numbers = rows().flat_map(|row| [data.landmark(row), data.point(row)]).flatten();
        if let Some(most) = numbers.max().filter(|most| *most >= names.len()) {
            let (row, named) = (most + 1, names.len());
            return Err(format!("a row observed landmark {row}, and names are given of {named}"));
        }
        let any = |word: &str| rows().any(|row| data.kind(row).is_some_and(|kind| KINDS[kind] == word));
        Ok(Some(KindColumns {
            data,
            names,
            length,
            point: rows().any(|row| data.point(row).is_some()),
            distance: any(Distance::KIND),
            value: any(Linear::KIND),
            pixels: any(Camera::KIND),
        }))
    }

    pub fn header(&self) -> Vec<String> {
        let mut all = vec!["kind".to_string(), "landmark".into()];
        let length = self.length.word;
        all.extend(self.point.then(|| "point".into()));
        all.extend(self.distance.then(|| format!("distance[{length}]")));
        all.extend(self.value.then(|| format!("value[{length}]")));
        all.extend(self.pixels.then_some(["u[px]", "v[px]"].map(String::from)).into_iter().flatten());
        all
    }

    pub fn cells(&self, table: &mut TableWriter, row: usize) {
        let kind = self.kind(row);
        let name = |number: Option<usize>| number.map_or("", |number| self.names[number].as_str());
        table.text(match (kind, self.data.landmark(row), self.data.orientation[row]) {
            (Some(kind), ..) => kind,
            (None, Some(_), _) => "same_point",
            (None, None, Some(_)) => "pose",
            (None, None, None) => "position",
        });
        table.text(name(self.data.landmark(row)));
        if self.point {
            table.text(name(self.data.point(row)));
        }
        let number = |which: usize, of: &str| {
            let value = self.data.scalar(row, which).filter(|_| kind == Some(of));
            value.unwrap_or(f64::NAN)
        };
        if self.distance {
            table.number(self.length.from_si(number(0, Distance::KIND)));
        }
        if self.value {
            table.number(self.length.from_si(number(0, Linear::KIND)));
        }
        if self.pixels {
            (0..2).for_each(|which| table.number(number(which, Camera::KIND)));
        }
    }

    /// What stands in `x`, `y`, `z` of a row of a relative instrument, m.
    pub fn relative(&self, row: usize) -> Option<[f64; 3]> {
        let own = self.kind(row) == Some(Relative::KIND);
        own.then(|| [0, 1, 2].map(|which| self.data.scalar(row, which).unwrap_or(f64::NAN)))
    }

    fn kind(&self, row: usize) -> Option<&'static str> {
        self.data.kind(row).map(|kind| KINDS[kind])
    }
}

#[cfg(test)]
mod tests {
    use crate::{ExportUnits, MeasurementsOptions, Unit, read_measurements, write_observations};
    use truepose_errormodel::{Dataset, DatasetBuilder, Measurement};
    use truepose_kinematics::samples;

    /// A position and one row of each kind: number of the kind from one, landmark, point, numbers.
    fn mixed() -> Dataset {
        type Written = (f64, Option<usize>, Option<usize>, [f64; 3]);
        let rows: [Written; 8] = [
            (0.0, None, None, [0.0; 3]),
            (0.0, Some(0), None, [0.0; 3]),
            (1.0, Some(1), None, [1.25, 0.0, 0.0]),
            (2.0, Some(2), None, [0.0; 3]),
            (3.0, Some(3), None, [0.0; 3]),
            (4.0, Some(4), None, [-0.125, 0.0, 0.0]),
            (5.0, Some(5), Some(0), [512.25, 300.5, 0.0]),
            (6.0, Some(6), None, [0.5, -0.25, 1.0]),
        ];
        let mut builder = DatasetBuilder::new(&samples::scara());
        for (k, (_, landmark, ..)) in rows.iter().enumerate() {
            let row = Measurement::at([0.1 * k as f64, 0.2, 0.05, 0.3]).visit(k as u64);
            let position = landmark.is_none().then_some([0.5, 0.25, 0.125]);
            builder.push(position.map_or(row.clone(), |at| row.position(at))).unwrap();
        }
        let mut data = builder.finish();
        data.set_landmarks(Some(&rows.map(|row| row.1)));
        data.set_points(Some(&rows.map(|row| row.2)));
        data.set_kinds(
            Some(rows.map(|row| row.0).to_vec()),
            [0, 1, 2].map(|k| Some(rows.map(|row| row.3[k]).to_vec())),
        );
        data
    }

    #[test]
    fn every_kind_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("d.csv");
        let (chain, data) = (samples::scara(), mixed());
        let names: Vec<String> =
            ["A", "wire", "table", "ball", "gauge", "eye", "morning"].map(String::from).to_vec();
        let units = ExportUnits { length: *Unit::named("mm").unwrap(), angle: *Unit::named("deg").unwrap() };
        write_observations(&path, &chain, &data, &names, &units).unwrap();
        let (again, info, _) = read_measurements(&path, &chain, &MeasurementsOptions::default()).unwrap();
        let name = |number: Option<usize>| number.map(|number| info.landmarks[number].as_str());
        for row in 0..data.len() {
            assert_eq!(again.kind(row), data.kind(row), "row {row}");
            assert_eq!(name(again.landmark(row)), data.landmark(row).map(|k| names[k].as_str()));
            assert_eq!(name(again.point(row)), data.point(row).map(|k| names[k].as_str()));
            for which in 0..3 {
                let (a, b) = (again.scalar(row, which).unwrap(), data.scalar(row, which).unwrap());
                assert!((a - b).abs() < 1e-12, "row {row}: {a} {b}");
            }
            let (a, b) = (again.measured_position(row), data.measured_position(row));
            assert!((a - b).norm() < 1e-12 || (a.x.is_nan() && b.x.is_nan()), "row {row}: {a} {b}");
        }
        let error = write_observations(&path, &chain, &data, &names[..3], &units).unwrap_err().to_string();
        assert!(error.contains("a row observed landmark 7, and names are given of 3"), "{error}");
    }
}
