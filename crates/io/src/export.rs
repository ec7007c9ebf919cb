//! A data set as a CSV file of measurements.

use crate::commanded::{commanded, commanded_names};
use crate::export_kinds::{KindColumns, in_kind_columns};
use crate::poses::si_unit;
use crate::table::TableWriter;
use crate::{IoError, Quantity, Unit};
use std::path::Path;
use truepose_errormodel::{Channel, Dataset};
use truepose_kinematics::{Chain, JointKind, Load};

/// Units of a file of measurements.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ExportUnits {
    /// Of joints that slide, positions and centres of gravity.
    pub length: Unit,
    /// Of joints that turn.
    pub angle: Unit,
}

impl Default for ExportUnits {
    fn default() -> Self {
        ExportUnits { length: *Quantity::Length.si(), angle: *Quantity::Angle.si() }
    }
}

/// Writes a data set of positions and poses as a file of measurements, leaving away the columns that hold nothing.
///
/// # Errors
/// When the file cannot be written, the data does not fit the robot, or a row observed a landmark.
pub fn write_measurements(
    path: impl AsRef<Path>,
    chain: &Chain,
    data: &Dataset,
    units: &ExportUnits,
) -> Result<(), IoError> {
    write_observations(path, chain, data, &[], units)
}

/// The same with rows of any kind; their landmarks have these names, by their number.
///
/// # Errors
/// When the file cannot be written, the data does not fit the robot, or a landmark has no name.
pub fn write_observations(
    path: impl AsRef<Path>,
    chain: &Chain,
    data: &Dataset,
    landmarks: &[String],
    units: &ExportUnits,
) -> Result<(), IoError> {
    let path = path.as_ref();
    data.validate(chain).map_err(|error| IoError::Write { file: path.into(), message: error.to_string() })?;
    for (unit, quantity) in [(&units.length, Quantity::Length), (&units.angle, Quantity::Angle)] {
        if unit.quantity != quantity {
            let message = format!("[{}] is not the unit of {}", unit.word, quantity.word());
            return Err(IoError::Write { file: path.into(), message });
        }
    }
    let kinds = KindColumns::of(data, landmarks, units.length)
        .map_err(|message| IoError::Write { file: path.into(), message })?;
    let relative = |row: usize| kinds.as_ref().and_then(|kinds| kinds.relative(row));
    let any = |rows: &[[f64; 3]]| rows.iter().flatten().any(|v| !v.is_nan());
    let (position, position_sd, orientation_sd) =
        (any(&data.position), any(&data.position_sd), any(&data.orientation_sd));
    let position = position || (0..data.len()).any(|row| relative(row).is_some());
    let orientation = data.orientation.iter().any(Option::is_some);
    let targets = data.target.iter().any(Option::is_some);
    let payload = data.load.iter().any(|load| matches!(load, Load::Payload(_)));
    let wrench = data.load.iter().any(|load| matches!(load, Load::Wrench(_)));
    let length = units.length.word;
    let xyz = |prefix: &str, unit: &str| ["x", "y", "z"].map(|k| format!("{prefix}{k}[{unit}]"));

    let joint_units: Vec<Unit> = chain
        .movable()
        .iter()
        .map(|&joint| match chain.joint(joint).kind {
            JointKind::Prismatic => units.length,
            JointKind::Revolute => units.angle,
            kind => *si_unit(kind),
        })
        .collect();
    let own = commanded(chain);
    let names = || commanded_names(chain).into_iter();
    let mut header: Vec<String> = names()
        .zip(&own)
        .map(|(name, &k)| (name, &joint_units[k]))
        .map(|(name, unit)| format!("{name}[{}]", unit.word))
        .collect();
    header.extend(position.then(|| xyz("", length)).into_iter().flatten());
    header.extend(orientation.then_some(["qw", "qx", "qy", "qz"].map(String::from)).into_iter().flatten());
    header.extend(targets.then(|| "target".to_string()));
    header.extend(kinds.iter().flat_map(KindColumns::header));
    header.push("visit".into());
    header.extend(payload.then(|| "payload[kg]".to_string()));
    header.extend(payload.then(|| xyz("c", length)).into_iter().flatten());
    header.extend(wrench.then(|| xyz("f", "N")).into_iter().flatten());
    header.extend(wrench.then(|| xyz("t", "N*m")).into_iter().flatten());
    header.extend(data.schema.time.then(|| "time[s]".to_string()));
    if data.schema.approach {
        header.extend(names().map(|name| format!("approach_{name}")));
    }
    header.extend(position_sd.then(|| xyz("s", length)).into_iter().flatten());
    header.extend(orientation_sd.then(|| xyz("sr", "rad")).into_iter().flatten());
    let (channels, columns): (Vec<&Channel>, Vec<&Vec<f64>>) =
        (data.schema.channels.iter().zip(&data.channels))
            .filter(|(channel, _)| !in_kind_columns(&channel.name))
            .unzip();
    header.extend(channels.iter().map(|channel| format!("{}[{}]", channel.name, channel.unit)));

    let mut table = TableWriter::create(path, &header)?;
    let mut values = vec![0.0; data.joints.len()];
    for row in 0..data.len() {
        let lengths = |table: &mut TableWriter, values: &[f64]| {
            values.iter().for_each(|&value| table.number(units.length.from_si(value)));
        };
        values.iter_mut().zip(&data.joints).for_each(|(value, column)| *value = column[row]);
        chain.joints_to_controller(&mut values);
        for &k in &own {
            table.number(joint_units[k].from_si(values[k]));
        }
        if position {
            lengths(&mut table, &relative(row).unwrap_or(data.position[row]));
        }
        if orientation {
            data.orientation[row].unwrap_or([f64::NAN; 4]).iter().for_each(|&value| table.number(value));
        }
        if targets {
            table.text(data.target[row].map_or("", |target| &chain.targets()[target.0].name));
        }
        if let Some(kinds) = &kinds {
            kinds.cells(&mut table, row);
        }
        table.integer(data.visit[row] as i64);
        if payload {
            match &data.load[row] {
                Load::Payload(carried) => {
                    table.number(carried.mass);
                    lengths(&mut table, carried.com.as_slice());
                }
                _ => [0.0; 4].iter().for_each(|&value| table.number(value)),
            }
        }
        if wrench {
            match &data.load[row] {
                Load::Wrench(w) => (0..6).for_each(|k| table.number(w.component(k))),
                _ => [f64::NAN; 6].iter().for_each(|&value| table.number(value)),
            }
        }
        if data.schema.time {
            table.number(data.time[row]);
        }
        if data.schema.approach {
            own.iter().for_each(|&k| table.integer(data.approach[k][row] as i64));
        }
        if position_sd {
            lengths(&mut table, &data.position_sd[row]);
        }
        if orientation_sd {
            data.orientation_sd[row].iter().for_each(|&value| table.number(value));
        }
        columns.iter().for_each(|column| table.number(column[row]));
        table.end_row()?;
    }
    table.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MeasurementsOptions, MeasurementsReader, read_measurements};
    use proptest::prelude::*;
    use truepose_errormodel::Schema;
    use truepose_kinematics::nalgebra::Vector3;
    use truepose_kinematics::{Payload, TargetId, Wrench, samples};

    /// A data set with everything in it, its numbers drawn from a small generator.
    fn everything(rows: usize, seed: u64) -> Dataset {
        let mut state = seed;
        let mut draw = move || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let mut data = Dataset {
            schema: Schema {
                channels: vec![
                    Channel { name: "oil".into(), unit: "degC".into(), temperature: true },
                    Channel { name: "pressure".into(), unit: "bar".into(), temperature: false },
                ],
                time: true,
                load: true,
                approach: true,
            },
            joints: vec![vec![]; 6],
            approach: vec![vec![]; 6],
            channels: vec![vec![]; 2],
            ..Dataset::default()
        };
        for row in 0..rows {
            let visit = row / 3;
            for (k, column) in data.joints.iter_mut().enumerate() {
                let value = if row % 3 == 0 { 0.04 * (draw() - 0.5) } else { column[row - 1] };
                column.push(value);
                data.approach[k].push(f64::from((draw() * 3.0) as i8) - 1.0);
            }
            data.position.push([draw(), if draw() < 0.2 { f64::NAN } else { -draw() * 1e-5 }, draw() * 3.0]);
            data.position_sd.push(if draw() < 0.5 { [f64::NAN; 3] } else { [draw() + 1e-6; 3] });
            data.orientation_sd.push([draw() + 1e-7; 3]);
            let half = draw();
            data.orientation.push((draw() < 0.7).then_some([half.cos(), half.sin(), 0.0, 0.0]));
            data.target.push((draw() < 0.8).then_some(TargetId((draw() * 3.0) as usize)));
            data.visit.push(visit);
            data.load.push(match (row % 3, visit % 3) {
                (1 | 2, _) => data.load[row - 1],
                (_, 0) => Load::Payload(Payload { mass: 0.0, com: Vector3::zeros() }),
                (_, 1) => {
                    Load::Payload(Payload { mass: draw() * 90.0, com: Vector3::new(draw(), 0.0, -draw()) })
                }
                _ => {
                    Load::Wrench(Wrench { force: Vector3::repeat(draw()), moment: Vector3::repeat(-draw()) })
                }
            });
            data.time.push(row as f64 + draw());
            data.channels[0].push(20.0 + draw());
            data.channels[1].push(draw() * 1e-7);
            data.line.push(row as u64 + 2);
        }
        data
    }

    fn same(a: f64, b: f64, relative: f64) -> bool {
        a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()) || (a - b).abs() <= relative * a.abs()
    }

    fn check_same(a: &Dataset, b: &Dataset, relative: f64) {
        let table = |data: &Dataset| -> Vec<f64> {
            let mut all: Vec<f64> =
                data.joints.iter().chain(&data.approach).chain(&data.channels).flatten().copied().collect();
            all.extend(data.position.iter().chain(&data.position_sd).chain(&data.orientation_sd).flatten());
            all.extend(data.orientation.iter().flatten().flatten());
            all.extend(&data.time);
            for load in &data.load {
                match load {
                    Load::None => all.push(0.5),
                    Load::Payload(p) => all.extend(p.com.iter().chain([&p.mass])),
                    Load::Wrench(w) => all.extend((0..6).map(|k| w.component(k))),
                }
            }
            all
        };
        assert_eq!((&a.schema, &a.target, &a.visit, &a.line), (&b.schema, &b.target, &b.visit, &b.line));
        let (a, b) = (table(a), table(b));
        assert_eq!(a.len(), b.len());
        for (a, b) in a.iter().zip(&b) {
            assert!(same(*a, *b, relative), "{a} {b}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]
        #[test]
        fn every_column_comes_back(rows in 1usize..40, seed: u64) {
            let folder = tempfile::tempdir().unwrap();
            let path = folder.path().join("d.csv");
            let chain = samples::pps();
            let data = everything(rows, seed);
            let millimetres = ExportUnits { length: *Unit::named("mm").unwrap(), angle: *Unit::named("deg").unwrap() };
            for (units, relative) in [(ExportUnits::default(), 0.0), (millimetres, 4e-16)] {
                write_measurements(&path, &chain, &data, &units).unwrap();
                let (again, ..) = read_measurements(&path, &chain, &MeasurementsOptions::default()).unwrap();
                // Quaternions are normalised once more, which may cost a unit in the last place.
                check_same(&data, &again, f64::max(relative, 4e-16));
                // In blocks of any size the same rows come, and no visit is cut.
                for size in [1, 4, 7, 1000] {
                    let mut reader = MeasurementsReader::open(&path, &chain, &MeasurementsOptions::default()).unwrap();
                    let (mut block, mut row) = (Dataset::default(), 0);
                    while reader.read_block(size, &mut block).unwrap() > 0 {
                        let rows: Vec<usize> = (row..row + block.len()).collect();
                        check_same(&block, &again.select(&rows), 0.0);
                        row += block.len();
                        prop_assert!(row == again.len() || again.visit[row] != again.visit[row - 1]);
                    }
                    prop_assert_eq!(row, again.len());
                    prop_assert_eq!(reader.info().rows, row);
                }
            }
        }
    }

    #[test]
    fn wrong_units_and_shapes_are_reported() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("d.csv");
        let units = ExportUnits { length: *Unit::named("kg").unwrap(), ..ExportUnits::default() };
        let say = |data: &Dataset, units: &ExportUnits| {
            write_measurements(&path, &samples::pps(), data, units).unwrap_err().to_string()
        };
        assert!(say(&everything(2, 1), &units).ends_with("[kg] is not the unit of a length"));
        assert!(say(&Dataset::default(), &ExportUnits::default()).contains("joint columns"));
        assert!(!path.exists());
    }
}
